"""Drawing: what the figures of all studies share.

In their order: spread (some of many runs), cycle_order (rows of a cycle), axes (those a user hands over, or new ones),
style (how lines look), panels (figures and their axes), conditions (in words, below a figure), files, shapes (of a
machine's parts), machine (a picture to scale). The figures of a study stand beside it, in its `figures`. A function
named ``draw_...`` draws one panel into axes and returns them; results call it with a user's axes. One that returns a
figure lays out panels; one named ``..._figures`` writes files.
"""
