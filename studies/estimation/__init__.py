"""Parameters of a machine estimated from measured data, through the simulator.

In the order in which they build on one another: parameters, priors, heavy_tails (of both),
noise, scatter_sizes and scatter (between runs), engine_starts (of an engine's runs), nuisance_space, residuals,
levenberg_marquardt, fixed_parameter (one parameter), profile_likelihood, cluster_robust (variances), model,
calibration.
"""
