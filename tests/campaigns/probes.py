"""Trials that do something to the process that runs them, for the tests of `tests.campaigns.campaign`."""

import os
import signal
import time

from .campaign import Outcome

HANGING, KILLED, ENDING, RAISING = 1, 2, 3, 4
"""Seeds."""


def trial(seed):
    """Hang, be killed, end the process, raise an error; all other seeds do well."""
    if seed == HANGING:
        time.sleep(600.0)
    if seed == KILLED:
        os.kill(os.getpid(), signal.SIGKILL)
    if seed == ENDING:
        os._exit(7)
    if seed == RAISING:
        raise ValueError("no trial")
    return Outcome("well")
