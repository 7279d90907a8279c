"""Figures: what archives and results look like, on paper and in a user's axes.

A single curve or two is drawn by the result itself (`plot` of a run, of a sweep, of a map), with `axes` of this folder.

What all figures share: drawing (style, panels, conditions, files), axes (those a user hands over, or new ones). The
figures by what they show: valve (maps, velocities, working limits), discharge, identify (a fit), soft_landing; sweep,
timing, engine_limit, optimise, assessment; measured; gap (the missing-effect workflow); paper.

A function named ``draw_...`` draws one panel into axes and returns them; results call it with a user's axes. A function
that returns a figure lays out panels. A function named ``..._figures`` writes files.
"""
