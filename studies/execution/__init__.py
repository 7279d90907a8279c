"""How work is carried out: own_thread (so that Ctrl-C is heard), pool (processes), cluster (dask)."""
