"""How a march ended, as archives hold it: codes and their words."""

from apesim.march.adaptive import Status

STATUS_MEANINGS = ", ".join(f"{int(status)} {status.name.lower().replace('_', ' ')}" for status in Status)
"""Each code with its words, from "0 done" on."""
