"""What people run: the command line, sweeps, figures."""
