"""Parameters of a machine estimated from measured data, through the simulator.

In the order in which they build on one another: arguments (of a call), parameters, priors, heavy_tails (of both),
noise, scatter_sizes and scatter (between runs), starts (of an engine's runs), nuisance_space, residuals,
levenberg_marquardt, held (one parameter), profile_likelihood, model, calibration.
"""
