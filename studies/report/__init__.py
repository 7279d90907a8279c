"""Pages of archives: one HTML file that stands alone, with curves that answer to the pointer and the keyboard.

In the order in which they build on one another: assets (style, scripts and template of the page), motion
(a picture of the machine that moves), figures (curves, maps and others), sections (of a page), grid (variables over the
axes that they have), machine (of an archive), pages (of each kind of archive), measured_points (over the curves), page
(all of it as HTML), writing (into a file).
"""
