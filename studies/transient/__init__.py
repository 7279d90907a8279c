"""What an engine does beyond steady state: starts from rest, and runs over time with a free or an imposed speed.

courses (what is imposed over time, as a user writes it), march_archive (a march as variables of an archive),
checkpoints (of a long march), transient (a run over time), start_archive (starts as variables of an archive), start_map
(over keys of the machine), start (does it start, from which angles), circle and start_curves (what starts draw),
figures (into files).
"""
