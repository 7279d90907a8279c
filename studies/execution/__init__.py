"""How work is done.

calls (arguments, and the text of a call), progress, output (files, and what is there already), own_thread (so that
Ctrl-C is heard), pool (processes), cluster (dask).
"""
