"""A session of the page: requests come as fast as a hand moves, the newest is answered, the others are let go.

Each answer bears the number of its request. Once no other has come for `REST`, the same point is run again exactly.
"""

import asyncio
import time
from collections.abc import AsyncIterator, Awaitable, Callable, Mapping
from typing import Any, NamedTuple, ParamSpec, TypeVar

from apesim.engine.indicators import is_adiabatic
from apesim.engine.machine import Machine
from apesim.quantities import InputError
from apesim.studies.execution.own_thread import call_in_thread
from apesim.studies.explore.frames import encode_frame
from apesim.studies.explore.live_point import LivePoint, States, march_kind, run_live
from apesim.studies.explore.requests import Request, as_faults, parse_request, read_request
from apesim.studies.report.motion import Snapshot, motion_geometry, render_motion, shapes_of
from apesim.studies.run.engine_run import supply_conditions

REST = 0.15
"""Time without a new request after which the exact numbers are computed [s]."""
SNAPSHOT_ANGLE = 60
"""Crank angle of the picture before a script moves it [deg]."""
FIRST_MARCH = (
    "getting ready: a march of this kind is compiled once for your processor, which takes up to a minute; "
    "after that it is there at once"
)
P = ParamSpec("P")
R = TypeVar("R")
Send = Callable[[bytes], Awaitable[None]]
"""Sends a frame to the page."""


class Newest:
    """Place for one text, in which a newer one replaces what nobody has taken."""

    def __init__(self) -> None:
        self._text: str | None = None
        self._is_there = asyncio.Event()

    def put(self, text: str) -> None:
        """Put a text there, in place of an older one."""
        self._text = text
        self._is_there.set()

    async def take(self, timeout: float | None = None) -> str | None:
        """Take the newest text, once there is one; None where there is none after a time [s]."""
        try:
            await asyncio.wait_for(self._is_there.wait(), timeout)
        except TimeoutError:
            return None
        self._is_there.clear()
        text, self._text = self._text, None
        return text


class Answer(NamedTuple):
    """Answer to a request."""

    header: Mapping[str, Any]
    own: LivePoint | None = None
    ideal: LivePoint | None = None

    def encode(self) -> bytes:
        """Write it as a frame."""
        curves = {} if self.own is None else dict(self.own.curves)
        if self.ideal is not None:
            curves |= {f"ideal_{name}": values for name, values in self.ideal.curves.items()}
        return encode_frame(self.header, curves)


class Session:
    """What the server remembers of one page: the states that the next run starts from, and the picture it has."""

    def __init__(self, base: Machine) -> None:
        self.base = base
        self.states = States()
        self.kinds: set[tuple[Any, ...]] = set()
        self.shapes: Any = None

    async def serve(self, texts: AsyncIterator[str], send: Send) -> None:
        """Answer the newest of the requests, one at a time, until the page goes away."""
        newest = Newest()
        reader = asyncio.create_task(_keep_newest(texts, newest))
        worker = asyncio.create_task(self._work(newest, send))
        try:
            done, _ = await asyncio.wait([reader, worker], return_when=asyncio.FIRST_COMPLETED)
            for task in done:
                task.result()
        finally:
            for task in (reader, worker):
                task.cancel()
            await asyncio.gather(reader, worker, return_exceptions=True)

    async def _work(self, newest: Newest, send: Send) -> None:
        """Answer one request after the other; exactly once they rest."""
        while True:
            text = await newest.take()
            request = await self._read(text or "", send)
            is_exact = False
            while request is not None:
                await self._answer(request, send, is_exact=is_exact)
                if is_exact:
                    break
                later = await newest.take(REST)
                is_exact = later is None
                request = request if later is None else await self._read(later, send)

    async def _read(self, text: str, send: Send) -> Request | None:
        """Read a request; one that cannot be is answered with what is wrong, and None is returned."""
        asked = parse_request(text)
        if asked is None:
            await send(encode_frame({"kind": "refused", "number": -1, "faults": []}, {}))
            return None
        try:
            return read_request(self.base, asked)
        except InputError as error:
            faults = as_faults(error)
            await send(encode_frame({"kind": "refused", "number": asked.number, "faults": faults}, {}))
            return None

    async def _answer(self, request: Request, send: Send, *, is_exact: bool) -> None:
        """Run a request in another thread, and send what came of it."""
        kind = march_kind(request.machine)
        if kind not in self.kinds:
            await send(encode_frame({"kind": "compiling", "number": request.number, "text": FIRST_MARCH}, {}))
        answer = await run_in_thread(self.run, request, is_exact=is_exact)
        self.kinds.add(kind)
        await send(answer.encode())

    def run(self, request: Request, *, is_exact: bool) -> Answer:
        """Run a request; a fault of the machine that only the march finds is told as any other."""
        begin, used = time.perf_counter(), time.thread_time()
        head: dict[str, Any] = {"number": request.number, "is_exact": is_exact}
        machine = request.machine
        try:
            own, ideal = run_live(machine, request.speed, self.states, is_exact=is_exact)
        except InputError as error:
            return Answer({"kind": "refused", "faults": as_faults(error)} | head)
        head |= {
            "kind": "point",
            "own": own.numbers,
            "ideal": ideal.numbers,
            "warnings": own.warnings,
            "is_adiabatic": is_adiabatic(machine),
            "conditions": supply_conditions(machine)["supply"],
            "picture": self._picture(machine, own, is_new=not own.curves),
            "server_ms": 1e3 * (time.perf_counter() - begin),
            "processor_ms": 1e3 * (time.thread_time() - used),
        }
        return Answer(head, own, ideal)

    def _picture(self, machine: Machine, point: LivePoint, *, is_new: bool) -> dict[str, Any] | None:
        """Picture of the machine with its sizes, where it is not the one that the page has; None: it is."""
        shapes = shapes_of(machine), machine.engine.exhaust, machine.engine.intake
        if shapes == self.shapes or is_new:
            return None
        self.shapes = shapes
        highest = highest_pressure(machine)
        names = "lift", "pressure_a", "pressure_b", "cylinder_pressure", "receiver_pressure"
        row = SNAPSHOT_ANGLE + 60
        at = Snapshot(SNAPSHOT_ANGLE, *(float(point.curves[name][row]) for name in names))
        return {"html": render_motion(machine, at, highest), "geometry": motion_geometry(machine, highest)}


def highest_pressure(machine: Machine) -> float:
    """Pressure of the strongest colour [Pa abs]: that of the supply or of the control air."""
    return max(machine.supply.engine_air().pressure, machine.supply.control().pressure)


async def _keep_newest(texts: AsyncIterator[str], newest: Newest) -> None:
    """Put each text in the place of the one before."""
    async for text in texts:
        newest.put(text)


async def run_in_thread(function: Callable[P, R], *arguments: P.args, **options: P.kwargs) -> R:
    """Call a function in another thread, so that requests are heard meanwhile.

    Who waits may be cancelled, as the page goes away; the call is not: its thread has to come to the end of it.
    """
    return await asyncio.shield(asyncio.wrap_future(call_in_thread(function, *arguments, **options)))
