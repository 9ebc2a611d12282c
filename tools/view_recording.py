#!/usr/bin/env python3
# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Films the page of a robot for README and docs/view.md: docs/images/view.gif. Needs a chromium."""

from __future__ import annotations

import io
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
from PIL import Image

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "test")]

from helpers.browser import Looker, running_browser  # noqa: E402

import cpr_core  # noqa: E402
from cpr_core.viewing.page import Page  # noqa: E402
from cpr_core.viewing.recorded import as_gif  # noqa: E402

FILE = ROOT / "docs/images/view.gif"
#: Of the film, and how wide its pictures are.
RATE, WIDTH = 8.0, 720
LARGEST = 2_000_000


class Film:
    """Takes pictures of a page while something is done on it."""

    def __init__(self, page: Page, looker: Looker) -> None:
        self.page, self.looker, self.frames = page, looker, list[np.ndarray]()

    def take(self, count: int = 1) -> None:
        """Pictures of the page as it is."""
        picture = Image.open(io.BytesIO(self.looker.page.screenshot())).convert("RGB")
        height = round(WIDTH * picture.height / picture.width)
        frame = np.asarray(picture.resize((WIDTH, height), Image.Resampling.LANCZOS))
        self.frames += [frame] * count

    def seen(self) -> None:
        """Wait until the browser shows where the robot is."""
        self.page.wait()
        position = self.page.equilibrium.platform_position
        self.looker.until(
            lambda: np.allclose(self.looker.position("/platform"), position, atol=1e-12)
        )
        self.looker.page.wait_for_timeout(150)

    def during(self, steps: int, do: Callable[[float], None]) -> None:
        """Do something in steps, with a picture of each."""
        for fraction in np.linspace(0.0, 1.0, steps):
            do(float(fraction))
            self.seen()
            self.take()


def main() -> int:
    """Make the film; status 1 if it became too large."""
    robot = cpr_core.load_robot("six_rfs")
    home = cpr_core.solve_home(robot)
    page = cpr_core.view(robot)
    with running_browser() as browser:
        looker = Looker(browser, page.address, "motor6", size=(1180, 700))
        looker.until(lambda: looker.visible("/robot/legs"))
        looker.page.get_by_role("alert").get_by_role("button").first.click(force=True)
        film = Film(page, looker)
        film.seen()
        film.take(4)
        play(film, page, home)
        page.close()
    content = as_gif(film.frames, RATE)
    FILE.write_bytes(content)
    print(f"{FILE}: {len(film.frames)} pictures, {len(content)} bytes")
    return 0 if len(content) < LARGEST else 1


def play(film: Film, page: Page, home: cpr_core.Equilibrium) -> None:
    """A motor, the platform past a fold, home, a force."""

    def motor(fraction: float) -> None:
        at = home.motors[0] + 1.2 * np.sin(np.pi * fraction)
        page.do("motor", lambda handled: handled.move_motor(0, at))

    def platform(fraction: float) -> None:
        position = home.platform_position + np.array([0.42, 0.05, 0.0]) * fraction
        turned = home.platform_quaternion
        page.do("platform", lambda handled: handled.move_platform(position, turned))

    def push(fraction: float) -> None:
        unit = home.robot.kernel_arrays.energy_unit / home.robot.mean_length
        force = unit * 2.0 * np.sin(np.pi * fraction) * np.array([1.0, 0.0, -0.4])
        page.do("force", lambda handled: handled.push(force))

    film.during(12, motor)
    film.during(14, platform)
    film.take(8)
    page.do("home", lambda handled: handled.go_home())
    film.seen()
    film.take(4)
    film.during(12, push)


if __name__ == "__main__":
    sys.exit(main())
