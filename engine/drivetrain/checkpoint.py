"""Checkpoints of a march of a drivetrain: all that it needs to go on, as arrays, and the march from these again."""

from collections.abc import Mapping

import numpy as np

from apesim.engine.drivetrain.preparing import Prepared
from apesim.engine.drivetrain.run import OWN_REVOLUTION, REVOLUTION, EventKind, March, ShaftEvent, begin_march

CHECKPOINT = {
    "march": ("quantity",),
    "y": ("state",),
    "mode": ("code",),
    "strokes": ("stroke", "cylinder"),
    "began": ("began_state",),
    "rows": ("revolution", "revolution_quantity"),
    "own_rows": ("revolution", "own_quantity", "cylinder"),
    "events": ("event", "event_quantity"),
    "trace": ("sample", "column"),
}
"""Arrays of a checkpoint, and the names of their axes."""
KINDS = tuple(EventKind)


def checkpoint_of(marched: March) -> dict[str, np.ndarray]:
    """Copy what a march needs to go on, as the arrays of `CHECKPOINT`.

    March: time, steps, turns, sense. Strokes: where the open one began, whether it was full, then the three of the
    last one that ended. Began: time and state at the start of the revolution, empty where none has begun.
    """
    books = marched.books
    open_stroke = [books.opened, np.array(books.is_full, dtype=float)]
    done = np.searchsorted(marched.times, marched.time, side="right")
    return {
        "march": np.array([marched.time, marched.steps, books.turns, books.sense], dtype=float),
        "y": marched.y.copy(),
        "mode": marched.mode.copy(),
        "strokes": np.array([*open_stroke, *books.strokes]),
        "began": np.append(*books.began) if books.began else np.empty(0),
        "rows": np.array(books.rows).reshape(-1, len(REVOLUTION)),
        "own_rows": np.array(books.own_rows).reshape(-1, len(OWN_REVOLUTION), books.count),
        "events": np.array([(KINDS.index(event.kind), *event[1:]) for event in books.events]).reshape(
            -1, len(ShaftEvent._fields)
        ),
        "trace": marched.trace[:done].copy(),
    }


def resume_march(prepared: Prepared, times: np.ndarray, kept: Mapping[str, np.ndarray]) -> March:
    """Make the march that a checkpoint was taken of, of the same drivetrain and with the same times of the trace."""
    begun = begin_march(prepared, times)
    books = begun.books
    time, steps, turns, sense = kept["march"].tolist()
    opened, is_full, *strokes = kept["strokes"]
    books.turns, books.sense = int(turns), int(sense)
    books.opened, books.is_full, books.strokes = opened.copy(), (is_full == 1.0).tolist(), np.array(strokes)
    books.began = (float(kept["began"][0]), kept["began"][1:].copy()) if len(kept["began"]) else None
    books.rows, books.own_rows = kept["rows"].tolist(), list(kept["own_rows"])
    books.events = [ShaftEvent(KINDS[int(code)], *numbers) for code, *numbers in kept["events"].tolist()]
    begun.trace[: len(kept["trace"])] = kept["trace"]
    return begun._replace(time=time, y=kept["y"].copy(), mode=kept["mode"].copy(), steps=int(steps))
