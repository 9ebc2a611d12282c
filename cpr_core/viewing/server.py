# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The web server of the page: on this machine only unless asked, and for pages of its own only."""

from __future__ import annotations

import ipaddress
import socket
import sys
from collections.abc import Collection, Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

from ..errors import CprError, InvalidRequest
from ..validation import checked_count
from .own_loop_event import OwnLoopEvent

if TYPE_CHECKING:
    import viser

__all__ = [
    "MissingViewer",
    "address_of",
    "check_viewer",
    "close_server",
    "open_server",
    "origin_problem",
]

#: Where the page is served unless asked.
_LOCAL = "127.0.0.1"
_HERE = ("127.0.0.1", "localhost", "::1")
#: Bytes of a reason that a websocket is closed for, at most.
_LONGEST_REASON = 123
#: What installs the extra.
_INSTALL = "-m pip install 'viser>=1.1,<1.2'"


class MissingViewer(CprError):
    """What draws the page is not installed."""

    code = "NOT_READY"


def check_viewer() -> None:
    """Whether viser is here; asked before anything that takes long.

    Raises:
        MissingViewer: It is not installed.
    """
    try:
        import viser  # noqa: F401
    except ImportError as error:
        raise MissingViewer(
            f"looking at a robot needs viser (the extra `view`), which is not here ({error}); "
            f"install it: {sys.executable} {_INSTALL}"
        ) from None


def open_server(label: str, host: str = _LOCAL, port: int = 8080) -> viser.ViserServer:
    """Start a server.

    Args:
        label: What the page is called.
        host: Address to listen at; ``0.0.0.0``: every one of this machine.
        port: Port; 0: any that is free.

    Raises:
        MissingViewer: viser is not installed.
        InvalidRequest: The port is taken, or the address is not one of this machine.
    """
    check_viewer()
    import viser

    _check_free(host, port)

    class LocalServer(viser.ViserServer):
        """Never asks another machine to pass the page on, whatever a client asks for."""

        def request_share_url(self, verbose: bool = True) -> str | None:
            return None

    with _silent():
        server = LocalServer(host=host, port=port, label=label, verbose=False)
    _send_from_any_thread(server)
    _refuse_strangers(server, host)
    server.gui.configure_theme(
        show_logo=False, show_share_button=False, control_width="large", brand_color=(0, 114, 178)
    )
    return server


def close_server(server: viser.ViserServer) -> None:
    """Stop a server; pages that show it say that it is gone."""
    with _silent():
        server.stop()


def address_of(server: viser.ViserServer) -> str:
    """Where to look at the page."""
    host = server.get_host()
    return f"http://{_LOCAL if host in ('0.0.0.0', '') else host}:{server.get_port()}"


def origin_problem(
    host_header: str, origin: str | None, asked: str, machine: Collection[str]
) -> str:
    """Why a connection is not one of a page that this server served; empty if it is one.

    A page of anybody else, open in the same browser, could connect to this machine too, and a name of
    somebody else's may lead here: browsers tell both. A number leads to nobody else.

    Args:
        host_header: ``Host`` of the request.
        origin: ``Origin`` of the request; None: no browser.
        asked: Address that the server listens at.
        machine: What this machine is called.
    """
    name = _host_of(f"//{host_header}")
    if asked in _HERE:
        if name not in _HERE:
            return f"this page is for {asked} only, not for {name!r:.60}"
    elif not _is_number(name) and name not in _names(asked, machine):
        return f"this machine does not know itself as {name!r:.60}: open its number"
    if origin is not None and origin.partition("://")[2] != host_header:
        return f"a page of {origin!r:.60} may not move this robot"
    return ""


def _host_of(address: str) -> str:
    """The host in an address, in small letters; empty where there is none."""
    with suppress(ValueError):  # brackets that do not close
        return urlsplit(address).hostname or ""
    return ""


def _is_number(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


def _names(asked: str, machine: Collection[str]) -> set[str]:
    """What a server that listens to others may be called in their browsers."""
    whole = {name.lower() for name in machine}
    short = {name.partition(".")[0] for name in whole}
    return {"localhost", asked.lower(), *whole, *short, *(f"{name}.local" for name in short)} - {""}


@contextmanager
def _silent() -> Iterator[None]:
    """Viser draws a box with its address; who asks for the page says where it is, once."""
    import rich

    console = rich.get_console()
    before, console.quiet = console.quiet, True
    try:
        yield
    finally:
        console.quiet = before


def _check_free(host: str, port: int) -> None:
    """Viser would take the next free port without a word."""
    if not isinstance(host, str):
        raise InvalidRequest("host", f"expected an address in words, got {host!r:.80}")
    checked_count("port", port, 0, 65535)
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        with socket.socket(family, socket.SOCK_STREAM) as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            probe.bind((host, port))
    except (OSError, OverflowError) as error:
        raise InvalidRequest(
            "address", f"expected one of this machine with a free port, got {host}:{port}: {error}"
        ) from None


def _send_from_any_thread(server: viser.ViserServer) -> None:
    """Let no message be forgotten that comes while the sender begins to wait; nothing public does."""
    sockets, loop = server._websock_server, server.get_event_loop()

    async def mend(client) -> None:  # type: ignore[no-untyped-def]
        own = sockets._client_state_from_id[client.client_id].message_buffer
        own.message_event = OwnLoopEvent(loop)

    sockets._broadcast_buffer.message_event = OwnLoopEvent(loop)
    sockets.on_client_connect(mend)


def _refuse_strangers(server: viser.ViserServer, host: str) -> None:
    """Close connections of other pages before anything goes through them.

    viser has no such check, and no public place for one: hence the underscores.
    """
    sockets = server._websock_server
    # The second asks the network, which may take its time.
    machine = () if host in _HERE else (socket.gethostname(), socket.getfqdn())

    async def look(client) -> None:  # type: ignore[no-untyped-def]
        connection = sockets._live_connections[client.client_id]
        assert connection.request is not None
        headers = connection.request.headers
        named, origins = headers.get_all("Host"), headers.get_all("Origin")
        asked_for = named[0] if len(named) == 1 else ""
        problem = origin_problem(asked_for, ", ".join(origins) or None, host, machine)
        if not problem:
            return
        await connection.close(1008, problem.encode()[:_LONGEST_REASON].decode(errors="ignore"))
        with suppress(EOFError):  # viser would still read what came until now
            while True:
                await connection.recv_messages.get(decode=False)

    sockets.on_client_connect(look)
    sockets.disconnect_all_clients()  # who came before; pages of its own connect again
