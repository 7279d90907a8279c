"""What others do with a gap: the baselines of the blind benchmark, with the command line of `apesim gap explain`."""
