"""How work is done.

calls (arguments, and the text of a call), progress, output (files, and what is there already), resuming (what an
interrupted computation left), own_thread (so that Ctrl-C is heard), interrupts (that wait for microseconds), pool
(processes), cluster (dask).
"""
