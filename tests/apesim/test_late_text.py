"""A machine's text is written once, when it is first read."""

import pickle
from dataclasses import replace
from functools import partial

from apesim.archive import Archive
from apesim.results import Result

WRITTEN = []


def write(text):
    WRITTEN.append(text)
    return text


def test_a_text_is_written_when_it_is_first_read():
    for holder in (Archive(partial(write, "bore = 1"), {}, {}), Result({}, machine=partial(write, "bore = 1"))):
        WRITTEN.clear()
        assert WRITTEN == []
        assert holder.machine == holder.machine == "bore = 1" and WRITTEN == ["bore = 1"]
        assert replace(holder).machine == pickle.loads(pickle.dumps(holder)).machine == "bore = 1"
        assert WRITTEN == ["bore = 1"]
    assert Archive().machine == ""
