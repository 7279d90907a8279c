"""A valve or an engine in steps, for those who close a loop around it: stepper."""
