"""Who may ask: pages that this server gave out itself, under a name of this computer.

A page of another site that is open in the same browser could ask, too: it says so in ``Origin``. A foreign name that
leads here (DNS rebinding) stands in ``Host``. Both are refused.
"""

from collections.abc import Awaitable, Callable, MutableMapping
from typing import Any

HOST = "127.0.0.1"
"""Address that is listened at: nobody from outside reaches it."""
NAMES = HOST, "localhost"
"""Names of this computer that a browser may use for it."""
REFUSED = b"apesim explore answers its own page on this computer only\n"
Message = MutableMapping[str, Any]
App = Callable[[Message, Callable[[], Awaitable[Message]], Callable[[Message], Awaitable[None]]], Awaitable[None]]
"""Application of ASGI."""


def is_own(scope: Message, port: int) -> bool:
    """Whether a request names this computer and port, and comes from a page of its own, or from no page at all.

    A page always says where it comes from when it opens a WebSocket, so that there it has to be said.
    """
    hosts = {f"{name}:{port}" for name in NAMES}
    given: dict[bytes, list[bytes]] = {}
    for name, value in scope["headers"]:
        given.setdefault(name.lower(), []).append(value)
    host, origin = given.get(b"host", []), given.get(b"origin", [])
    if len(host) != 1 or host[0].decode("latin-1") not in hosts:
        return False
    if not origin:
        return scope["type"] == "http" and scope["method"] in ("GET", "HEAD")
    return len(origin) == 1 and origin[0].decode("latin-1") == f"http://{host[0].decode('latin-1')}"


def for_own_pages(app: App, port: int) -> App:
    """Let an application answer what `is_own` alone."""

    async def guarded(
        scope: Message, receive: Callable[[], Awaitable[Message]], send: Callable[[Message], Awaitable[None]]
    ) -> None:
        if scope["type"] == "lifespan" or is_own(scope, port):
            await app(scope, receive, send)
        elif scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": 1008})
        else:
            head = [(b"content-type", b"text/plain; charset=utf-8"), (b"content-length", str(len(REFUSED)).encode())]
            await send({"type": "http.response.start", "status": 403, "headers": head})
            await send({"type": "http.response.body", "body": REFUSED})

    return guarded
