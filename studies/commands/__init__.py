"""The commands of apesim, one file each: its options, the one call, and what is printed, drawn or written.

One file or folder each, by its first word: new, machine, valve, engine, measured, gap, fmu, archive, report,
explore, paper, doctor.

options (that commands share) and cli (the whole command line) stand beside them.

What a command computes with is imported where it is called: ``--help`` answers at once.
"""
