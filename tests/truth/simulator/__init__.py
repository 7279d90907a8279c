"""Independent simulators of valve, engine and cylinder, and what their sensors see."""
