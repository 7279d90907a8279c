"""The one march in time, whose bodies are chosen by the type of a machine's parameters.

hybrid_system (what a machine registers to be marched), dormand_prince (an explicit step), rosenbrock (an implicit one,
for stiff stretches), adaptive (the march, with located events), stepping (a march in steps), acceleration (from cycle
to cycle), periodic (periodic states), error_bounds (how well a run promises to close).
"""
