"""The live page as a public function: it listens on this computer until it is interrupted."""

import socket
from collections.abc import Callable
from importlib import import_module
from os import PathLike
from typing import TYPE_CHECKING, Any

from apesim.engine.angles import TURN
from apesim.engine.machine import Machine
from apesim.quantities import Fault, InputError, Quantity
from apesim.quantities.arguments import WithUnit
from apesim.studies.execution.calls import arguments_of, public
from apesim.studies.explore.loopback import HOST, for_own_pages
from apesim.studies.explore.requests import MAX_BYTES
from apesim.studies.run.operating_conditions import SPEED

if TYPE_CHECKING:
    from apesim.studies.explore.app import Page

PORT = Quantity("", 1, 65535, "a call", whole=True, typical="8765")
"""What a port has to be."""
EXTRA, PACKAGES = "explore", ("starlette", "uvicorn", "websockets")
"""Extra of the package that brings what serves the page, and what that is."""
GRACE = 1
"""Time for which an answer on its way is waited for at the end [s]."""


@public
def explore(
    machine: Machine | None = None,
    speed: WithUnit = "1000 rpm",
    *,
    port: int | None = None,
    browser: bool = True,
    measured: str | PathLike[str] | None = None,
    ready: Callable[[str], object] | None = None,
) -> None:
    """Serve a live page of a machine on this computer: sliders, and the engine that is run again while they move.

    It returns when it is interrupted. Only this computer can open the page. It needs the extra ``explore`` of the
    package.

    Parameters
    ----------
    machine : Machine, optional
        Machine to begin with; the default one if left out.
    speed : str or (float, str)
        Speed of the crankshaft to begin with, with its unit.
    port : int, optional
        Port to listen at; a free one if left out.
    browser : bool
        Open the page in a browser.
    measured : path, optional
        Folder with measured runs of an engine, which are laid over the curves.
    ready : function, optional
        Called with the page's address once it listens.

    Raises
    ------
    InputError
        An argument cannot be taken, the port is in use, or the extra is not installed.

    Examples
    --------
    >>> import apesim
    >>> apesim.explore(apesim.Machine(), speed="1500 rpm")  # doctest: +SKIP
    """
    arguments, machine = arguments_of("explore", Machine() if machine is None else machine)
    omega = arguments.quantity("speed", speed, SPEED)
    number = arguments.quantity("port", port, PORT)
    arguments.refuse()
    require_extra()
    from apesim.studies.explore.app import Page
    from apesim.studies.explore.measured_points import overlays_of
    from apesim.studies.measured import read_measured

    overlays = [] if measured is None else overlays_of(read_measured(measured, machine.ambient.pressure))
    with listen(int(number or 0)) as listener:
        server = make_server(Page(machine, omega / TURN * 60.0, overlays), listener)
        server.announce = lambda address: _tell(address, browser, ready)
        server.run(sockets=[listener])


def _tell(address: str, browser: bool, ready: Callable[[str], object] | None) -> None:
    """Tell who waits that the page can be opened, and open it."""
    if ready is not None:
        ready(address)
    if browser:
        import webbrowser

        webbrowser.open(address)


def make_server(page: "Page", listener: socket.socket) -> Any:
    """Make the server of a page; its attribute ``announce`` is called with the address once it listens."""
    import uvicorn

    from apesim.studies.explore.app import make_app

    port = listener.getsockname()[1]
    config = uvicorn.Config(
        for_own_pages(make_app(page), port),
        log_level="error",
        lifespan="off",
        ws="websockets-sansio",  # the other implementation stands on what websockets gives up
        ws_max_size=MAX_BYTES,
        ws_per_message_deflate=False,
        timeout_graceful_shutdown=GRACE,
        server_header=False,
    )

    class Server(uvicorn.Server):
        announce: Callable[[str], object] = print

        async def startup(self, sockets: list[socket.socket] | None = None) -> None:
            await super().startup(sockets)
            if self.started:
                self.announce(f"http://{HOST}:{port}/")

    return Server(config)


def listen(port: int) -> socket.socket:
    """Listen at a port of this computer alone; at a free one where it is 0."""
    listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    try:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind((HOST, port))
    except OSError as error:
        listener.close()
        wrong = f"{port} cannot be listened at: {(error.strerror or str(error)).lower()}"
        raise InputError([Fault("explore()", "port", wrong, "give another one, or leave it out")]) from None
    return listener


def require_extra() -> None:
    """Refuse to serve a page where a package of the extra is missing: raises InputError, which names the extra."""
    try:
        for name in PACKAGES:
            import_module(name)
    except ImportError as error:
        wrong = f"needs the package {error.name}, which is not installed"
        right = f'python -m pip install "apesim[{EXTRA}]"'
        raise InputError([Fault("explore()", "", wrong, right)]) from None
