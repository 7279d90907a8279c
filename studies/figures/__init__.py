"""Figures of archives; the only place that draws: style (how they look), sweep, valve."""
