"""Tests of what is done with archives."""
