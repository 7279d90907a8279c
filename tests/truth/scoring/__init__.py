"""Sealed cases solved by command line, and verdicts held against answers."""
