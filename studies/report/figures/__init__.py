"""Figures of pages: each a still picture as inline SVG, and data for the script that lets it answer.

In the order in which they build on one another: packing (of arrays), labels (names and units as pages show them),
drawing (axes, ticks and paths of SVG), curves (over an axis, and loops), maps, bars (of a ledger), rings (angles),
moving (valve and crank).
"""
