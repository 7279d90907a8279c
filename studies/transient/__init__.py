"""What an engine does beyond steady state: starts from rest, and runs over time with a free or an imposed speed.

courses (what is imposed over time, as a user writes it), transient (a run over time), start (does it start, from which
angles), figures (what both draw into files).
"""
