# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A page in a real browser, and what is in its scene: of the objects that are drawn there."""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

#: What the last line of a run says where there is none.
NO_BROWSER = "no browser here: Debian's package chromium has one"
#: Pictures are kept here to be looked at.
SCREENSHOTS = Path(__file__).parents[2] / "log" / "pages"
TIMEOUT = 60.0

_ARGUMENTS = (
    "--no-sandbox",  # tests may run as root, and open nothing but pages of their own
    "--disable-gpu-rasterization",  # where there is no graphics card it is slower
    "--disable-gpu-compositing",  # and so is this, by half
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
)
#: viser keeps the nodes of its scene in a React context.
_FIND = """() => {
  const root = document.getElementById('root');
  const key = Object.keys(root).find(name => name.startsWith('__reactContainer'));
  const stack = [root[key]];
  while (stack.length) {
    const fiber = stack.pop(), value = fiber.memoizedProps && fiber.memoizedProps.value;
    if (value && value.mutable && value.useSceneTree) { window.viewed = value.mutable.current; return; }
    if (fiber.sibling) stack.push(fiber.sibling);
    if (fiber.child) stack.push(fiber.child);
  }
}"""
_POSITION = "name => window.viewed.nodeRefFromName[name].position.toArray()"
_QUATERNION = "name => window.viewed.nodeRefFromName[name].quaternion.toArray()"
_VISIBLE = """name => { let node = window.viewed.nodeRefFromName[name];
  if (!node) return false;
  for (; node; node = node.parent) if (!node.visible) return false;
  return true; }"""
_POINTS = """name => { let found = null;
  window.viewed.nodeRefFromName[name].traverse(node => {
    const of = node.geometry && node.geometry.attributes;
    if (of && of.instanceStart) found = [of.instanceStart, of.instanceEnd]; });
  const all = one => Array.from({length: one.count}, (_, k) => [one.getX(k), one.getY(k), one.getZ(k)]);
  return found.map(all); }"""
_FRAMES = """() => new Promise(told => {
  let frames = 0;
  const count = () => { frames += 1; requestAnimationFrame(count); };
  requestAnimationFrame(count);
  setTimeout(() => told(frames), 1000); })"""
#: Places in the scene are those of the last frame that was drawn, for the ray under the mouse too.
_DRAWN = """frames => new Promise(told => {
  const count = left => left ? requestAnimationFrame(() => count(left - 1)) : told();
  count(frames); })"""
#: Without a graphics card every frame takes 50 ms of a processor: pages of tests draw 8 in a second.
_SELDOM = """(() => {
  const ask = window.requestAnimationFrame.bind(window), drop = window.cancelAnimationFrame.bind(window);
  const asked = new Map();
  let last = 0, count = 0;
  window.requestAnimationFrame = draw => {
    const id = ++count;
    const due = time => {
      if (time !== last && time - last < 120) { asked.set(id, ask(due)); return; }
      last = time; asked.delete(id); draw(time); };
    asked.set(id, ask(due));
    return id; };
  window.cancelAnimationFrame = id => { drop(asked.get(id)); asked.delete(id); }; })()"""
#: And without smooth edges, which take a third of that.
_ROUGH = """(() => {
  const get = HTMLCanvasElement.prototype.getContext;
  HTMLCanvasElement.prototype.getContext = function(kind, wishes) {
    return get.call(this, kind, kind.startsWith('webgl') ? {...wishes, antialias: false} : wishes); };
  })()"""
_ON_SCREEN = """place => {
  const camera = window.viewed.camera, canvas = window.viewed.canvas.getBoundingClientRect();
  camera.updateMatrixWorld();
  const root = window.viewed.nodeRefFromName[''];  // turns what is up
  const at = root.localToWorld(new camera.position.constructor(...place)).project(camera);
  return [canvas.x + (at.x + 1) / 2 * canvas.width, canvas.y + (1 - at.y) / 2 * canvas.height]; }"""


def chromium() -> str | None:
    """The browser of this machine, if it has one."""
    for name in ("chromium", "chromium-browser", "google-chrome"):
        found = shutil.which(name)
        if found:
            return found
    return None


@contextmanager
def running_browser() -> Iterator[Any]:
    """A browser without a window."""
    program = chromium()
    if program is None:
        pytest.skip(NO_BROWSER)
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=list(_ARGUMENTS))
        try:
            yield browser
        finally:
            browser.close()


class Looker:
    """Somebody who looks at a page.

    Attributes:
        page: As playwright has it.
        complaints: Errors in the console.
        requests: Everything the page asked for.
    """

    def __init__(
        self, browser: Any, address: str, text: str, size: tuple[int, int] = (1000, 760)
    ) -> None:
        """Open a page.

        Args:
            browser: The browser.
            address: Of the page.
            text: Is on the page once it is loaded.
            size: Of the window, width and height.
        """
        self.page = browser.new_page(viewport={"width": size[0], "height": size[1]})
        self.page.set_default_timeout(1e3 * TIMEOUT)
        self.page.add_init_script(_SELDOM)
        self.page.add_init_script(_ROUGH)
        self.complaints: list[str] = []
        self.requests: list[str] = []
        self.page.on("console", self._hear)
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.on("request", lambda request: self.requests.append(request.url))
        self.page.on("websocket", lambda socket: self.requests.append(socket.url))
        self.page.goto(address)
        self.page.get_by_text(text).first.wait_for()
        self.page.evaluate(_FIND)

    def _hear(self, message: Any) -> None:
        if message.type == "error":
            self.complaints.append(message.text)

    def position(self, node: str) -> np.ndarray:
        """Where a node of the scene is."""
        return np.array(self.page.evaluate(_POSITION, node))

    def quaternion(self, node: str) -> np.ndarray:
        """How it is turned, w x y z."""
        return np.roll(self.page.evaluate(_QUATERNION, node), 1)

    def visible(self, node: str) -> bool:
        """Whether it is there and drawn."""
        return self.page.evaluate(_VISIBLE, node)

    def pieces(self, node: str) -> np.ndarray:
        """Both ends of the pieces of lines, (N, 2, 3)."""
        return np.array(self.page.evaluate(_POINTS, node)).transpose(1, 0, 2)

    def until(self, done: Callable[[], bool], instead: Callable[[], str] = lambda: "") -> None:
        """Wait until something holds, or say what is so instead."""
        end = time.monotonic() + TIMEOUT
        while not done():
            assert time.monotonic() < end, (
                f"never so; {instead()}; {self._condition()}; it says:\n{self.text()}"
            )
            self.page.wait_for_timeout(50)

    def _condition(self) -> str:
        """How the page is, for somebody who has to find out why it does not do what it should."""
        frames = self.page.evaluate(_FRAMES)
        return f"the page draws {frames} frames a second and complains of {self.complaints}"

    def text(self) -> str:
        """All that is written on the page."""
        return self.page.inner_text("body")

    def drag(self, start: np.ndarray, end: np.ndarray) -> None:
        """Drag with the mouse from a place of the scene to another one."""
        self.hold(start, end)
        self.page.mouse.up()

    def hold(self, start: np.ndarray, end: np.ndarray) -> None:
        """The same, but do not let go."""
        first, last = (self.page.evaluate(_ON_SCREEN, place.tolist()) for place in (start, end))
        mouse = self.page.mouse
        mouse.move(*first)
        self.until_drawn(2)  # one that shows what was there, and one with what the mouse has done
        mouse.down()
        self.until_drawn()
        for part in np.linspace(0.0, 1.0, 12)[1:]:
            mouse.move(*(first + part * np.subtract(last, first)))
            self.until_drawn()

    def until_drawn(self, frames: int = 1) -> None:
        """Wait for the next pictures of the scene."""
        self.page.evaluate(_DRAWN, frames)

    def field(self, label: str) -> Any:
        """What is typed into, or ticked, beside a label."""
        named, box = f'//label[normalize-space(.)="{label}"]', '*[not(@type="hidden")][self::input]'
        return self.page.locator(f"xpath={named}/ancestor::*[.//{box}][1]//{box}")

    def press(self, button: str) -> None:
        """Press a button, wherever it has been scrolled to."""
        found = self.page.get_by_role("button", name=button, exact=True)
        found.evaluate("node => node.click()")

    def switch(self, label: str) -> None:
        """Tick a box, or take its tick away."""
        _click(self.page.locator(f'xpath=//label[normalize-space(.)="{label}"]'))

    def choose(self, label: str, option: str) -> None:
        """Choose out of a list."""
        _click(self.field(label))
        _click(self.page.get_by_role("option", name=option, exact=True))

    def open_tab(self, name: str) -> None:
        """Show a tab."""
        tab = self.page.get_by_role("tab", name=name, exact=True)
        _click(tab)
        self.until(lambda: tab.get_attribute("aria-selected") == "true")

    def click(self, place: np.ndarray) -> None:
        """Click at a place of the scene."""
        self.page.mouse.click(*self.page.evaluate(_ON_SCREEN, place.tolist()))

    def picture(self, name: str) -> None:
        """Keep a picture."""
        SCREENSHOTS.mkdir(parents=True, exist_ok=True)
        self.page.screenshot(path=SCREENSHOTS / f"{name}.png")


def _click(found: Any) -> None:
    """Click on something that stands still: the page comes piece by piece, which moves what is there."""
    before = None
    while before != (place := found.bounding_box()):
        before = place
        found.page.evaluate(_DRAWN, 2)
    found.click(force=True)


def type_into(page: Any, looker: Looker, label: str, text: str) -> None:
    """Type into a field and wait until the page has heard of it, as a hand does.

    Browsers send every 50 ms: a button that is pressed within them would go out in place of the text.
    """
    inputs = page.server.gui._gui_input_handle_from_uuid.values()
    field = next(part for part in inputs if getattr(part, "label", "") == label)
    looker.field(label).fill(text, force=True)
    looker.until(lambda: field.value == text)


def settled(page: Any, looker: Looker) -> None:
    """Wait until the scene of the browser is where the robot is, and nobody holds it any more."""

    def at_the_robot(node: str) -> bool:
        expected = page.equilibrium.platform_position
        return np.allclose(looker.position(node), expected, rtol=0, atol=1e-12)

    assert page.wait()
    handle = ["/handle"] if looker.visible("/handle") else []
    looker.until(lambda: all(at_the_robot(node) for node in ["/platform", *handle]))
