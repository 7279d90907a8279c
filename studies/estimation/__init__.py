"""Parameters of a machine estimated from measured data, through the simulator.

In the order in which they build on one another: parameters, noise, residuals, levenberg_marquardt, profile_likelihood,
model, nuisance_space, priors, calibration.
"""
