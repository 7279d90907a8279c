"""Interrupts while compiled code is called for microseconds."""

import signal
import subprocess
import sys
import threading

import pytest

from apesim.studies.execution.interrupts import call_uninterrupted

STEPPED = """
import os, signal, threading, time
import apesim

stepper, heard, going = apesim.Stepper(apesim.Machine(), "valve"), 0, True

def interrupt():
    while going:
        time.sleep(2e-3)
        os.kill(os.getpid(), signal.SIGINT)

sender = threading.Thread(target=interrupt)
while heard < 200:
    try:
        if heard == 0 and not sender.is_alive():
            sender.start()
        while True:
            stepper.advance(stepper.time + 1e-4, command=1)
    except KeyboardInterrupt:
        heard += 1
signal.signal(signal.SIGINT, signal.SIG_IGN)
going = False
print("heard", heard, max(stepper.closure().values()) < 1e-12)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="a process of Windows cannot interrupt itself alone")
def test_a_stepped_valve_hears_interrupts_and_does_not_crash():
    run = subprocess.run([sys.executable, "-c", STEPPED], capture_output=True, text=True, timeout=300)
    assert (run.returncode, run.stdout.strip()) == (0, "heard 200 True"), run.stderr


def test_an_interrupt_is_heard_when_the_call_has_returned():
    done = []

    def interrupted():
        signal.raise_signal(signal.SIGINT)
        done.append("went on")

    with pytest.raises(KeyboardInterrupt):
        call_uninterrupted(interrupted)
    assert done == ["went on"]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_a_handler_of_ones_own_is_called_then_and_stays():
    told = []
    before = signal.signal(signal.SIGINT, lambda number, frame: told.append(number))
    try:
        assert call_uninterrupted(lambda: signal.raise_signal(signal.SIGINT) or len(told)) == 0
        assert told == [signal.SIGINT]
    finally:
        signal.signal(signal.SIGINT, before)


def test_another_thread_calls_as_it_is():
    results = []
    thread = threading.Thread(target=lambda: results.append(call_uninterrupted(max, 1, 2)))
    thread.start()
    thread.join()
    assert results == [2]
