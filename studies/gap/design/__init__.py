"""The design of what to measure: experiments, isolability, next_test."""
