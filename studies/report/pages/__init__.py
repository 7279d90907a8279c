"""Pages of the kinds of archives: what each says first, and its figures.

In their order: cycle (around the cycle or over time), ledger (of exergy), tables (of runs), sweep, march (a start, or a
run over time), starts (over keys), grid (any other study: its variables over the axes that they have), kinds (which is
whose).
"""
