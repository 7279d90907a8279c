"""The noise of measured channels: process, discrepancy (of the model), hum, estimation, residual_noise, sampling.

All take it for an autoregressive process, see `process`. Who estimates it from what:

- `apesim gap explain` by `estimation`: from repeats, else from stretches at rest, else from what no effect of the
  library explains; for each sampling interval, with hum of the mains, and known no better than its samples tell
  (`sampling`).
- `apesim valve fit` by `residual_noise`: from repeats, else from what the best fit leaves, as it has no library that
  could say what else that may be; one noise a sensor, without hum.
"""
