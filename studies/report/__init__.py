"""Pages of archives: one HTML file that stands alone, with curves that answer to the pointer and the keyboard.

In the order in which they build on one another: assets (style, scripts and template of the page), motion
(a picture of the machine that moves).
"""
