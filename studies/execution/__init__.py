"""How work is done: own_thread (so that Ctrl-C is heard), pool (processes), cluster (dask)."""
