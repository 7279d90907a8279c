"""Sealed cases: data of a rig with something hidden in it, and the answer, stored apart."""
