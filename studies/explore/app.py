"""What is served: the page with its assets, the session behind it, and what it hands on."""

from collections.abc import Awaitable, Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from starlette.applications import Starlette
from starlette.requests import Request as HttpRequest
from starlette.responses import Response
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket, WebSocketDisconnect

from apesim.engine.cylinder import INTAKES
from apesim.engine.drivetrain.preparing import machines_of
from apesim.engine.machine import Machine
from apesim.quantities import InputError
from apesim.studies.explore.commands import FILE, command_of
from apesim.studies.explore.corrections import can_correct, correct_commands
from apesim.studies.explore.frames import encode_text
from apesim.studies.explore.live_point import ANGLES
from apesim.studies.explore.reports import Reports, write_report_of
from apesim.studies.explore.requests import MAX_BYTES, Request, as_faults, parse_request, read_request
from apesim.studies.explore.session import Session, highest_pressure, run_in_thread
from apesim.studies.explore.sliders import effect_sliders, sliders_of
from apesim.studies.report import assets

OWN, SHARED = __package__, assets.__package__
"""Packages whose folder ``assets`` holds a file."""
ASSETS = {
    "/": (OWN, "explore.html", "text/html"),
    "/explore.css": (OWN, "explore.css", "text/css"),
    "/explore.js": (OWN, "explore.js", "text/javascript"),
    "/style.css": (SHARED, "style.css", "text/css"),
    "/motion.css": (SHARED, "motion.css", "text/css"),
    "/uplot.css": (SHARED, "uplot.min.css", "text/css"),
    "/uplot.js": (SHARED, "uplot.iife.min.js", "text/javascript"),
    "/curves.js": (SHARED, "curves.js", "text/javascript"),
    "/motion.js": (SHARED, "motion.js", "text/javascript"),
}
"""Files by the path of their address: no other path leads to a file."""
HEADERS = {
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; "
    "connect-src 'self'; img-src data:; form-action 'none'; base-uri 'none'; frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cache-Control": "no-store",
}
"""Headers of all answers: the page loads nothing from elsewhere, and is shown in no other."""
REPORT_HEADERS = HEADERS | {
    "Content-Security-Policy": "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src data:; form-action 'none'; base-uri 'none'; frame-ancestors 'none'",
}
"""Headers of a report, which stands alone: its scripts and styles are in it."""
BAD_REQUEST, TOO_LARGE, UNPROCESSABLE = 400, 413, 422
"""Statuses of HTTP for what is no request of ours, is too long, and has values that cannot be."""


@dataclass(frozen=True)
class Page:
    """What a page begins with."""

    machine: Machine
    speed: float
    """Speed [r/min]."""
    measured: Sequence[Mapping[str, Any]] = field(default=())

    def start(self) -> dict[str, Any]:
        """What the page is made from, as JSON knows it."""
        machine = self.machine
        count = len(machines_of(machine))
        what = "stage" if machine.stage_2.is_on else "cylinder"
        shown = f"{what} 1 of {count} is shown; torque, power and air are of all" if count > 1 else ""
        return {
            "sliders": [slider._asdict() for slider in sliders_of(machine, self.speed)],
            "effects": [
                effect._asdict() | {"sliders": [slider._asdict() for slider in effect.sliders]}
                for effect in effect_sliders(machine)
            ],
            "angles": ANGLES.tolist(),
            "intake": INTAKES[machine.engine.intake],
            "shown": shown,
            "can_correct": can_correct(machine),
            "ambient": machine.ambient.pressure,
            "highest": highest_pressure(machine),
            "measured": list(self.measured),
        }


def make_app(page: Page) -> Starlette:
    """Make the application; who may ask it is decided before, see `apesim.studies.explore.loopback`."""

    async def asset(request: HttpRequest) -> Response:
        package, name, kind = ASSETS[request.url.path]
        return Response(assets.read_asset(name, package), media_type=f"{kind}; charset=utf-8", headers=HEADERS)

    async def start(_: HttpRequest) -> Response:
        return _json(page.start())

    async def session(socket: WebSocket) -> None:
        await socket.accept()

        async def send(frame: bytes) -> None:
            await socket.send_bytes(frame)

        try:
            await Session(page.machine).serve(socket.iter_text(), send)
        except (WebSocketDisconnect, RuntimeError):  # the page went away while it was answered
            return

    async def save(asked: Request) -> Response:
        text = await run_in_thread(asked.machine.to_toml)
        name = {"Content-Disposition": f'attachment; filename="{FILE}"'}
        return Response(text, media_type="application/toml; charset=utf-8", headers=HEADERS | name)

    async def command(asked: Request) -> Response:
        text = command_of(asked.machine, asked.speed_text)
        return _json({"command": text, "file": FILE if text.endswith(FILE) else ""})

    async def correct(asked: Request) -> Response:
        try:
            return _json({"values": await run_in_thread(correct_commands, asked)})
        except InputError as error:
            return _json({"faults": as_faults(error)}, status=UNPROCESSABLE)

    async def report(asked: Request) -> Response:
        name = reports.keep(await run_in_thread(write_report_of, asked))
        return _json({"address": f"/report/{name}"})

    async def show_report(request: HttpRequest) -> Response:
        text = reports.find(request.path_params["name"])
        if text is None:
            return Response("this report is no longer kept\n", status_code=404, headers=HEADERS)
        return Response(text, media_type="text/html; charset=utf-8", headers=REPORT_HEADERS)

    def reading(answer: Callable[[Request], Awaitable[Response]]) -> Callable[[HttpRequest], Awaitable[Response]]:
        async def endpoint(request: HttpRequest) -> Response:
            asked = await _read_body(page.machine, request)
            return asked if isinstance(asked, Response) else await answer(asked)

        return endpoint

    # What the page hands on is asked for by a body, and read in one place; all else is an address alone.
    reports = Reports()
    answers = {"/machine.toml": save, "/command": command, "/timing": correct, "/report": report}
    routes: list[Any] = [Route(path, asset) for path in ASSETS]
    routes += [
        Route("/start.json", start),
        *(Route(path, reading(answer), methods=["POST"]) for path, answer in answers.items()),
        Route("/report/{name}", show_report),
        WebSocketRoute("/session", session),
    ]
    return Starlette(routes=routes)


async def _read_body(base: Machine, request: HttpRequest) -> Request | Response:
    """Read a request of the page from a body; what cannot be is a response that says why."""
    body = b""
    async for part in request.stream():
        body += part
        if len(body) > MAX_BYTES:
            return _json({"faults": []}, status=TOO_LARGE)
    asked = parse_request(body.decode("utf-8", "replace"))
    if asked is None:
        return _json({"faults": []}, status=BAD_REQUEST)
    try:
        return read_request(base, asked)
    except InputError as error:
        return _json({"faults": as_faults(error)}, status=UNPROCESSABLE)


def _json(data: Any, status: int = 200) -> Response:
    """Answer with JSON."""
    return Response(encode_text(data), status_code=status, media_type="application/json", headers=HEADERS)
