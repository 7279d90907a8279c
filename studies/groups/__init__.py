"""The groups of the command line: valve, engine, archive, gap.

What a command does is imported where it is called: --help answers at once.
"""
