"""A live page that is served, once for all tests of a process."""

import json
import queue
import struct
import threading

import numpy as np
import pytest

from apesim.engine.machine import Machine
from apesim.studies.explore.app import Page
from apesim.studies.explore.live_page import listen, make_server


@pytest.fixture(scope="session")
def address():
    """Address of a page of the default machine at 1000 r/min."""
    told = queue.SimpleQueue()
    with listen(0) as listener:
        server = make_server(Page(Machine(), 1000.0), listener)
        server.announce = told.put
        thread = threading.Thread(target=server.run, kwargs={"sockets": [listener]}, daemon=True)
        thread.start()
        yield told.get(timeout=30)
        server.should_exit = True
        thread.join(timeout=30)


def decode(frame):
    """Header and curves of an answer."""
    (length,) = struct.unpack_from("<I", frame)
    header, curves, offset = json.loads(frame[4 : 4 + length]), {}, 4 + length
    for name, count in header["curves"]:
        curves[name] = np.frombuffer(frame, "<f4", count, offset)
        offset += 4 * count
    assert offset == len(frame)
    return header, curves
