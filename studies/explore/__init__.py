"""A live page: sliders of a machine, which is run again while they move.

In the order in which they build on one another: sliders (what moves), requests (from the page), live_point (one
operating point, quickly or exactly), measured_points (laid over), frames (answers as bytes), session (the newest
request is kept), commands (that give the same numbers), corrections (of the timing), reports, loopback (who may ask),
app (what is served), live_page (the public function). The page itself lies in ``assets``.
"""
