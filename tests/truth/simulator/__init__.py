"""Independent simulators of valve, engine, engine in transients and cylinder, and what their sensors see."""
