# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Who can reach the page, and what happens without what it needs."""

import asyncio
import json
import re
import signal
import socket
import subprocess
import sys
import threading
import time
import urllib.request
from contextlib import suppress
from pathlib import Path

import msgspec
import numpy as np
import pytest
import websockets.exceptions
from websockets.sync.client import connect

import cpr_core
from cpr_core import InvalidRequest
from cpr_core.viewing.server import MissingViewer, origin_problem
from cpr_core.workspace import map_workspace, pose_grid


@pytest.fixture(scope="module")
def robot():
    return cpr_core.load_robot("rfrfr")


@pytest.fixture(scope="module")
def page(robot):
    page = cpr_core.view(robot)
    yield page
    page.close()


def port_of(page):
    return int(page.address.rpartition(":")[2])


def heard(page, host=None, **options):
    """Whether anything comes through a connection."""
    address = f"ws://127.0.0.1:{port_of(page)}"
    headers = {} if host is None else {"additional_headers": {"Host": host}}
    with connect(address, subprotocols=[subprotocol()], **options, **headers) as socket_:
        try:
            return bool(socket_.recv(timeout=20.0))
        except websockets.exceptions.ConnectionClosed as closed:
            return closed.rcvd.reason


@pytest.mark.parametrize("notebook", [False, True])
def test_what_is_sent_while_the_sender_begins_to_wait_is_not_forgotten(page, notebook):
    """Its event was set between its look and its waiting: no browser heard anything ever after."""
    buffer, loop = page.server._websock_server._broadcast_buffer, page.server.get_event_loop()
    event, looked, sent = buffer.message_event, threading.Event(), threading.Event()
    own_loop = event._get_loop

    def look():
        looked.set()
        assert sent.wait(20.0)
        return own_loop()

    def show():
        mark.content = "meanwhile"

    async def cell():  # notebooks have a loop of their own
        show()

    with connect(f"ws://127.0.0.1:{port_of(page)}", subprotocols=[subprotocol()]) as socket_:
        mark = page.server.gui.add_markdown("before")
        with suppress(TimeoutError):
            while socket_.recv(timeout=1.0):
                pass
        event._get_loop = look
        try:
            loop.call_soon_threadsafe(event.set)  # it finds nothing to send, and waits again
            assert looked.wait(20.0)
            shows = threading.Thread(target=(lambda: asyncio.run(cell())) if notebook else show)
            shows.start()
            shows.join()
        finally:
            event._get_loop = own_loop
            sent.set()
        assert socket_.recv(timeout=20.0)


def until(done, timeout=60.0):
    end = time.monotonic() + timeout
    while not done():
        assert time.monotonic() < end
        time.sleep(0.01)


def subprotocol():
    import viser

    return f"viser-v{viser.__version__}"


@pytest.mark.parametrize(
    ("host", "origin", "asked", "welcome"),
    [
        ("127.0.0.1:8080", None, "127.0.0.1", True),
        ("127.0.0.1:8080", "http://127.0.0.1:8080", "127.0.0.1", True),
        ("localhost:8080", "http://localhost:8080", "127.0.0.1", True),
        ("127.0.0.1:8080", "http://evil.example", "127.0.0.1", False),
        ("127.0.0.1:8080", "http://127.0.0.1:9999", "127.0.0.1", False),
        ("evil.example:8080", "http://evil.example:8080", "127.0.0.1", False),
        ("127.0.0.1:8080", "null", "127.0.0.1", False),
        ("robot.lab:8080", "http://robot.lab:8080", "0.0.0.0", True),
        ("robot.lab:8080", "http://evil.example", "0.0.0.0", False),
        ("Robot.Lab:8080", "http://Robot.Lab:8080", "0.0.0.0", True),
        ("robot:8080", "http://robot:8080", "0.0.0.0", True),
        ("robot.local:8080", "http://robot.local:8080", "::", True),
        ("localhost:8080", "http://localhost:8080", "0.0.0.0", True),
        ("192.168.1.7:8080", "http://192.168.1.7:8080", "0.0.0.0", True),
        ("[fe80::7]:8080", "http://[fe80::7]:8080", "::", True),
        ("bench.lab:8080", "http://bench.lab:8080", "bench.lab", True),
        ("bench.lab:8080", "http://bench.lab:8080", "0.0.0.0", False),
        ("evil.example:8080", "http://evil.example:8080", "0.0.0.0", False),
        ("evil.example:8080", "http://evil.example:8080", "192.168.1.7", False),
        ("robot.evil.example:8080", "http://robot.evil.example:8080", "0.0.0.0", False),
        ("robot.lab:8080", "http://robot.lab:8080", "127.0.0.1", False),
        ("[::1", "http://[::1", "0.0.0.0", False),
        ("", None, "0.0.0.0", False),
    ],
)
def test_only_pages_of_its_own_are_welcome(host, origin, asked, welcome):
    assert (origin_problem(host, origin, asked, ["robot", "robot.lab"]) == "") == welcome


def test_pages_of_others_cannot_connect(page):
    assert heard(page) is True
    assert heard(page, origin=page.address) is True
    assert "may not move this robot" in heard(page, origin="http://evil.example")
    assert "may not move this robot" in heard(page, origin=f"http://{'evil.' * 40}example")
    assert "only, not for ''" in heard(page, host="evil.example")  # and that of the client itself
    until(lambda: not page.server._websock_server._live_connections)


def test_of_another_page_nothing_is_read(page):
    """What comes together with its request neither, which is there before it is refused."""
    inputs = page.server.gui._gui_input_handle_from_uuid.values()
    slider = next(part for part in inputs if getattr(part, "label", "").startswith("motor1"))
    before, moved = slider.value, float(slider.min + 1000 * slider.step)
    update = {"type": "GuiUpdateMessage", "uuid": slider._impl.uuid, "updates": {"value": moved}}
    content = msgspec.msgpack.encode(update)
    assert len(content) < 126  # else its length is written otherwise
    frame = bytes([0x82, 0x80 | len(content), 0, 0, 0, 0]) + content  # masked by zeros
    assert before != moved
    for origin, expected in (("http://evil.example", before), (page.address, moved)):
        request = (
            f"GET / HTTP/1.1\r\nHost: 127.0.0.1:{port_of(page)}\r\nOrigin: {origin}\r\n"
            "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
            f"Sec-WebSocket-Key: {'A' * 22}==\r\nSec-WebSocket-Protocol: {subprotocol()}\r\n\r\n"
        )
        with socket.create_connection(("127.0.0.1", port_of(page)), timeout=20.0) as connection:
            connection.sendall(request.encode() + frame)
            told = b""
            while b"\r\n\r\n" not in told or told.endswith(b"\r\n\r\n"):
                more = connection.recv(1 << 16)
                assert more, "it was closed without a word"
                told += more  # something after the answer
            assert (b"may not move this robot" in told) == (expected == before)
        until(lambda: not page.server._websock_server._live_connections)
        assert slider.value == expected


def test_other_addresses_are_refused_unless_asked_for(page, robot):
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(("127.0.0.2", port_of(page)), timeout=10.0)
    asked = cpr_core.view(robot, host="0.0.0.0")
    with socket.create_connection(("127.0.0.2", port_of(asked)), timeout=10.0):
        pass
    asked.close()


def test_nobody_passes_the_page_on(page):
    assert page.server.request_share_url() is None


def test_a_port_that_is_taken_is_an_error(page, robot):
    with pytest.raises(cpr_core.InvalidRequest, match="free port"):
        cpr_core.view(robot, port=port_of(page))
    with pytest.raises(cpr_core.InvalidRequest, match=r"192\.0\.2\.1"):
        cpr_core.view(robot, host="192.0.2.1")


@pytest.mark.parametrize(
    "wrong", [{"port": "8080"}, {"port": 70000}, {"port": True}, {"host": None}]
)
def test_addresses_that_are_none_are_refused(robot, wrong):
    """Errors of Python, which tell nobody."""
    with pytest.raises(InvalidRequest, match=rf"^{next(iter(wrong))}: expected "):
        cpr_core.view(robot, **wrong)


def test_what_is_not_of_the_robot_is_not_shown(page):
    """Only the page said so, in the browser."""
    before = page.equilibrium
    for other in (cpr_core.solve_home(cpr_core.load_robot("six_rfs")), [1, 2]):
        with pytest.raises(InvalidRequest, match="equilibrium: expected "):
            page.show(other)
    assert page.wait() and page.equilibrium is before


def test_what_is_not_of_the_robot_is_refused(robot, tmp_path):
    with pytest.raises(cpr_core.InvalidRequest, match="expected a Trace"):
        cpr_core.view(robot, way="path")
    with pytest.raises(cpr_core.CprError):
        cpr_core.view(robot, map_file=tmp_path / "none.nc")
    with pytest.raises(cpr_core.InvalidRequest, match="expected a Robot"):
        cpr_core.view("rfrfr")


def test_without_viser_it_is_said_at_once_what_installs_it(monkeypatch, robot, capsys):
    from cpr_core.command_line import main

    def solved(*_, **__):
        raise AssertionError("its kernels take two minutes to compile on the first day")

    monkeypatch.setitem(sys.modules, "viser", None)
    monkeypatch.setattr("cpr_core.viewing.page.HandledRobot", solved)
    monkeypatch.setattr("cpr_core.command_line.view_command.solve_forward", solved)
    with pytest.raises(MissingViewer, match="pip install"):
        cpr_core.view(robot)
    assert main(["view", "rfrfr", "--motors", "2.6", "0.6"]) == 1
    assert f"{sys.executable} -m pip install 'viser" in capsys.readouterr().err


def test_the_command_shows_what_it_is_asked_for(monkeypatch, robot):
    from cpr_core.command_line import main

    asked = {}

    def view(robot, start, **options):
        asked.update(options, start=start)
        raise cpr_core.InvalidRequest("page", "none in this test")

    monkeypatch.setattr("cpr_core.command_line.view_command.view", view)
    options = ["--map", "map.nc", "--host", "0.0.0.0", "--port", "65535"]
    assert main(["view", "rfrfr", "--gravity", "0", "-1", "0", *options]) == 2
    start = asked.pop("start")
    assert asked == {"map_file": Path("map.nc"), "host": "0.0.0.0", "port": 65535}
    np.testing.assert_array_equal(start.loads.gravity, [0.0, -1.0, 0.0])
    np.testing.assert_array_equal(start.motors, cpr_core.solve_home(robot).motors)
    with pytest.raises(SystemExit):
        main(["view", "rfrfr", "--port", "65536"])


@pytest.mark.parametrize(("arguments", "end"), [([], signal.SIGINT), (["--json"], signal.SIGTERM)])
def test_the_command_prints_the_address_and_ends_with_a_signal(arguments, end):
    process = subprocess.Popen(
        [sys.executable, "-m", "cpr_core.command_line", "view", "rfrfr", "--port", "0", *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    line = process.stdout.readline()
    address = json.loads(line)["address"] if arguments else re.search(r"http://\S+", line)[0]
    with urllib.request.urlopen(address, timeout=20.0) as answer:
        assert b"<html" in answer.read()
    process.send_signal(end)
    out, err = process.communicate(timeout=30.0)
    assert (process.returncode, out, err) == (0, "", "")


def test_a_map_is_read_with_the_loads_of_the_view(robot, tmp_path):
    """Those it was made with; under others it is no map of what is shown."""
    file = tmp_path / "map.nc"
    loads = robot.default_loads.with_(gravity=[0.0, -1.0, 0.0])
    start = cpr_core.solve_forward(robot, cpr_core.solve_home(robot).motors, loads=loads)
    x, y, _ = start.platform_position
    grid = pose_grid(robot, {"x": (x, x + 0.02), "y": (y, y + 0.02)}, resolution=0.02)
    map_workspace(robot, grid, start=start, file=file, tolerance=0.0)
    cpr_core.view(robot, start, map_file=file, port=0).close()
    with pytest.raises(cpr_core.InvalidRequest, match="other loads"):
        cpr_core.view(robot, map_file=file, port=0)
