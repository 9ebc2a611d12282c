#!/usr/bin/env python3
# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Draws the frames and the elements of legs for docs/description.md: docs/images/elements/*.png."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray
from PIL import Image

from cpr_core.lie import rotation_exp

Floats = NDArray[np.float64]

FOLDER = Path(__file__).parents[1] / "docs/images/elements"
#: d1, d2, d3; rods, rigid pieces, what is meant by words, where things were before.
FRAME = ("#D62728", "#2CA02C", "#1F77B4")
ROD, RIGID, TEXT, BEFORE = "#0072B2", "0.35", "0.15", "0.75"
#: From space to paper: x right, y up, z towards the reader.
VIEW = np.array([[1.0, 0.0, -0.28], [0.0, 1.0, -0.42]])
E1, E2, E3 = np.eye(3)


class Paper:
    """A drawing in oblique view."""

    def __init__(self, width: float, height: float) -> None:
        self.figure = Figure(figsize=(width, height), dpi=160)
        self.axes: Any = self.figure.add_axes((0, 0, 1, 1))
        self.axes.set_axis_off()
        self.seen: list[Floats] = []  # words and arrows are not among what axes are scaled to

    def line(self, points: ArrayLike, color: str, width: float, **more: Any) -> None:
        """A line through points."""
        flat = VIEW @ np.transpose(points)
        self.seen += list(flat.T)
        more = {"solid_capstyle": "round", "zorder": 2, **more}
        self.axes.plot(*flat, color=color, linewidth=width, **more)

    def plate(self, corners: list[Floats]) -> None:
        """The platform."""
        flat = VIEW @ np.transpose(corners)
        self.seen += list(flat.T)
        self.axes.fill(*flat, color=ROD, alpha=0.25, zorder=1)

    def text(self, place: ArrayLike, words: str, color: str = TEXT, **more: Any) -> None:
        """Words, centred if nothing else is asked for."""
        more = {"fontsize": 8, "ha": "center", "va": "center", **more}
        flat = VIEW @ np.asarray(place)
        self.seen.append(flat)
        self.axes.text(*flat, words, color=color, **more)

    def arrow(
        self, start: ArrayLike, vector: ArrayLike, color: str, width: float = 1.5, **more: Any
    ) -> None:
        """An arrow along a vector."""
        start = np.asarray(start, float)
        tip, tail = VIEW @ (start + vector), VIEW @ start
        self.seen += [tip, tail]
        style = {"arrowstyle": "-|>", "color": color, "lw": width, "shrinkA": 0, "shrinkB": 0}
        self.axes.annotate("", tip, tail, arrowprops=style | more, zorder=4)

    def frame(self, place: ArrayLike, rotation: Floats, size: float = 0.45) -> None:
        """Arrows along d1, d2, d3."""
        place = np.asarray(place, float)
        beside = -0.13 * rotation[:, 1]  # a rod goes on along d1
        for axis, color, name in zip(rotation.T, FRAME, ("d1", "d2", "d3"), strict=True):
            self.arrow(place, size * axis, color)
            place_of_name = size * axis + beside if name == "d1" else (size + 0.13) * axis
            self.text(place + place_of_name, name, color)

    def joint(self, place: ArrayLike, motor: bool, square: bool = False) -> None:
        """A mark as in drawings of robots."""
        self.axes.plot(
            *(VIEW @ np.asarray(place)),
            marker="s" if square else "o",
            color="black",
            markerfacecolor="black" if motor else "white",
            markersize=7,
            zorder=5,
        )

    def axis(self, place: ArrayLike, vector: ArrayLike, name: str, **more: Any) -> None:
        """A dashed line through a joint, named at its end."""
        place, vector = np.asarray(place, float), np.asarray(vector, float)
        self.line([place - vector, place + vector], TEXT, 0.9, linestyle=(0, (5, 3)), zorder=1)
        self.text(place + 1.2 * vector, name, **more)

    def turn(self, place: ArrayLike, axis: ArrayLike, start: ArrayLike, angle: float) -> None:
        """An arc about an axis, from where ``start`` points."""
        place = np.asarray(place, float)
        arc = [
            place + rotation_exp(a * np.asarray(axis)) @ start for a in np.linspace(0, angle, 30)
        ]
        self.line(arc, TEXT, 0.9)
        self.arrow(arc[-2], arc[-1] - arc[-2], TEXT, 0.9)

    def spring(self, start: ArrayLike, stop: ArrayLike, across: ArrayLike) -> None:
        """A zigzag between two points."""
        start, stop, across = (np.asarray(value, float) for value in (start, stop, across))
        turns = [0, 0, *([1, -1] * 4), 0, 0]
        ways = [0, 0.2, *np.linspace(0.25, 0.75, 8), 0.8, 1]
        zigzag = [
            start + way * (stop - start) + turn * across
            for way, turn in zip(ways, turns, strict=True)
        ]
        self.line(zigzag, TEXT, 1.0)

    def base(self, place: ArrayLike) -> None:
        """Hatched ground."""
        place = np.asarray(place, float)
        self.line([place + [0, -0.3, 0], place + [0, 0.3, 0]], RIGID, 1.6)
        for height in np.linspace(-0.3, 0.2, 6):
            start = place + [0, height, 0]
            self.line([start + [0, 0.1, 0], start + [-0.1, 0, 0]], RIGID, 0.8)

    def save(self, file: Path) -> None:
        """Write it, as large as what is on it asks for."""
        low, high = np.min(self.seen, axis=0), np.max(self.seen, axis=0)
        size = self.figure.get_size_inches()
        half = 0.5 * size * np.max((high - low + [0.5, 0.3]) / size)  # the same scale both ways
        for place, limit in zip(0.5 * (low + high), ("xlim", "ylim"), strict=True):
            reach = half[0 if limit == "xlim" else 1]
            self.axes.set(**{limit: (place - reach, place + reach)})
        canvas = FigureCanvasAgg(self.figure)
        canvas.draw()
        picture = Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")
        picture.quantize(64, dither=Image.Dither.NONE).save(file, optimize=True)


def bent(
    place: ArrayLike, rotation: Floats, length: float, curvature: ArrayLike
) -> tuple[Floats, Floats, Floats]:
    """Points, position and frame of the end of a rod of constant curvature."""
    points, frame = [np.asarray(place, float)], rotation
    steps = 60
    for _ in range(steps):
        half = rotation_exp(0.5 * length / steps * np.asarray(curvature))
        frame = frame @ half
        points.append(points[-1] + length / steps * frame[:, 0])
        frame = frame @ half
    return np.array(points), points[-1], frame


def frames() -> Paper:
    """World, base, a section, tip and platform."""
    paper = Paper(6.6, 2.4)
    world = np.array([-1.5, -0.3, 0.0])
    for axis, name in ((E1, "x"), (E2, "y"), (E3, "z")):
        paper.arrow(world, 0.5 * axis, TEXT)
        paper.text(world + 0.63 * axis, name)
    paper.text(world + [0.35, -0.42, 0.0], "world")
    base = np.array([0.0, 0.0, 0.0])
    paper.base(base - [0.45, 0, 0])
    paper.line([base - [0.45, 0, 0], base], RIGID, 4.0)
    paper.frame(base, np.eye(3))
    paper.text([0.3, -0.6, 0.0], "base.position, base frame\n(all joints at zero)")
    points, tip, end = bent(base, np.eye(3), 3.2, [0, 0, 0.22])
    paper.line(points, ROD, 3.0)
    _, place, section = bent(base, np.eye(3), 1.7, [0, 0, 0.22])
    paper.frame(place, section)
    paper.text(place + [0.5, -0.5, 0.0], "a section, s/l = 0.53")
    paper.frame(tip, end, 0.4)
    paper.text(tip + [-0.15, -0.5, 0.0], "tip, s/l = 1")
    paper.joint(tip, False)
    platform = tip + [1.4, 0.0, 0.0]
    corners = [tip, platform + [0.5, 0.5, 0.0], platform + [0.7, -0.4, 0.0]]
    paper.plate(corners)
    for axis, name in ((E1, "x"), (E2, "y"), (E3, "z")):
        paper.arrow(platform, 0.4 * axis, TEXT)
        paper.text(platform + 0.52 * axis, name)
    paper.arrow(platform, tip - platform, TEXT, 0.8, linestyle="--")
    paper.text(0.5 * (tip + platform) + [0.1, -0.17, 0.0], "tip.position")
    paper.text(platform + [0.35, -0.65, 0.0], "platform frame")
    return paper


def revolute() -> Paper:
    """A turn by a motor."""
    paper = Paper(3.2, 2.0)
    turned = rotation_exp(0.45 * E3)
    paper.base([-0.1, 0, 0])
    paper.axis([0, 0, 0], 0.75 * E3, "axis")
    paper.line([[0, 0, 0], E1 * 1.3], BEFORE, 4.0)
    paper.text([1.62, 0.0, 0.0], "at zero", "0.5")
    paper.line([[0, 0, 0], turned @ E1 * 1.3], RIGID, 4.0)
    paper.frame(turned @ E1 * 1.3, turned, 0.4)
    paper.turn([0, 0, 0], E3, 0.8 * E1, 0.4)
    paper.joint([0, 0, 0], True)
    return paper


def prismatic() -> Paper:
    """A shift by a motor."""
    paper = Paper(3.2, 2.0)
    paper.base([-0.1, 0, 0])
    paper.line([[-0.1, 0, 0], [1.6, 0, 0]], TEXT, 0.9, linestyle=(0, (5, 3)))
    paper.text([1.85, 0, 0], "axis")
    for x, color in ((0.0, BEFORE), (1.0, RIGID)):
        paper.line([[x, 0, 0], [x, 0.55, 0]], color, 4.0)
    paper.text([0.0, 0.75, 0.0], "at zero", "0.5")
    paper.arrow([0.05, -0.22, 0], [0.95, 0, 0], TEXT, 0.9)
    paper.text([0.5, -0.4, 0.0], "position")
    paper.frame([1.0, 0.55, 0], np.eye(3), 0.4)
    paper.joint([1.0, 0, 0], True, square=True)
    return paper


def universal() -> Paper:
    """Two passive turns about crossing axes."""
    paper = Paper(3.2, 2.0)
    first = rotation_exp(0.3 * E3)
    whole = first @ rotation_exp(0.5 * E2)
    paper.line([[-0.9, 0, 0], [0, 0, 0]], RIGID, 4.0)
    paper.axis([0, 0, 0], 0.75 * E3, "axes[0]")
    paper.axis([0, 0, 0], first @ E2 * 0.6, "axes[1], turned by the first")
    paper.line([[0, 0, 0], whole @ E1 * 1.1], RIGID, 4.0)
    paper.frame(whole @ E1 * 1.1, whole, 0.4)
    paper.joint([0, 0, 0], False)
    return paper


def link() -> Paper:
    """A rigid piece that leads somewhere and turns the frame."""
    paper = Paper(3.2, 2.0)
    paper.frame([0, 0, 0], np.eye(3), 0.4)
    end = np.array([1.5, 0.35, 0.0])
    paper.line([[0, 0, 0], end], RIGID, 4.0)
    turned = np.column_stack([E2, -E1, E3])
    paper.frame(end, turned, 0.4)
    paper.text(end + [-0.1, -0.55, 0.0], "tangent: [0, 1, 0]\nnormal: [-1, 0, 0]")
    paper.axes.plot(*(VIEW @ (0.6 * end)), "o", color="white", markeredgecolor=RIGID, zorder=5)
    paper.text(0.6 * end + [0.0, 0.45, 0.0], "center_of_mass")
    paper.line([0.6 * end + [0, 0.07, 0], 0.6 * end + [0, 0.36, 0]], TEXT, 0.6)
    paper.text(0.5 * end + [-0.05, -0.6, 0.0], "link: [1.5, 0.35, 0]")
    return paper


def rod() -> Paper:
    """What torsion, bending_2 and bending_3 do."""
    paper = Paper(6.6, 1.9)
    for number, (name, curvature) in enumerate(
        (("bending_3", [0, 0, 0.7]), ("bending_2", [0, 0.9, 0]), ("torsion", [1.0, 0, 0]))
    ):
        start = np.array([2.6 * number, 0.0, 0.0])
        points, end, frame = bent(start, np.eye(3), 1.4, curvature)
        paper.line(points, ROD, 3.0)
        paper.frame(start, np.eye(3), 0.4)
        paper.frame(end, frame, 0.4)
        paper.text(start + [0.7, -0.6, 0.0], f"{name} > 0")
    return paper


def spring() -> Paper:
    """A motor with compliance, and a passive sprung joint."""
    paper = Paper(3.2, 2.0)
    turned, more = rotation_exp(0.65 * E3), rotation_exp(0.3 * E3)
    paper.base([-0.1, 0, 0])
    paper.line([[0, 0, 0], turned @ E1 * 1.2], BEFORE, 4.0)
    paper.line([[0, 0, 0], more @ E1 * 1.2], RIGID, 4.0)
    paper.spring(turned @ E1 * 0.95, more @ E1 * 0.95, 0.09 * (more @ E1))
    paper.text(turned @ E1 * 1.2 + [0.1, 0.2, 0], "where the motor is", "0.5")
    paper.frame(more @ E1 * 1.2, more, 0.35)
    paper.joint([0, 0, 0], True)
    return paper


def shared() -> Paper:
    """One motor in two joints."""
    paper = Paper(3.2, 2.0)
    for height, angle in ((0.5, 0.5), (-0.5, -0.25)):
        place, turned = np.array([0, height, 0]), rotation_exp(angle * E3)
        paper.base(place - [0.1, 0, 0])
        paper.line([place, place + E1], BEFORE, 4.0)
        paper.line([place, place + turned @ E1], RIGID, 4.0)
        paper.turn(place, E3, 0.7 * E1, 0.9 * angle)
        paper.joint(place, True)
        paper.text(place + [1.55, 0.6 * angle, 0], "ratio: 1" if angle > 0 else "ratio: -0.5")
    paper.text([-0.55, 0, 0], "motor1", rotation=90)
    return paper


def tips() -> Paper:
    """The joints between tip and platform."""
    paper = Paper(6.6, 1.7)
    for number, name in enumerate(("fixed", "revolute", "universal", "spherical")):
        start = np.array([2.4 * number, -0.5, 0.0])
        points, tip, frame = bent(start, np.eye(3), 1.1, [0, 0, 0.5])
        paper.line(points, ROD, 3.0)
        plate = [tip, tip + [0.6, 0.4, 0], tip + [0.75, -0.25, 0]]
        paper.plate(plate)
        if name == "revolute":
            paper.axis(tip, -0.6 * E3, "axis", ha="left")
        if name == "universal":
            paper.axis(tip, -0.6 * E3, "axis_in_rod", ha="left")
            paper.axis(tip, -0.4 * frame[:, 1], "axis", ha="left")
        if name == "fixed":
            paper.line([tip - 0.1 * frame[:, 1], tip + 0.1 * frame[:, 1]], RIGID, 4.0)
            paper.arrow(tip, 0.4 * frame[:, 0], FRAME[0])
            paper.arrow(tip, 0.4 * frame[:, 1], FRAME[1])
            paper.text(tip + 0.52 * frame[:, 0], "tangent", FRAME[0], ha="left")
            paper.text(tip + 0.52 * frame[:, 1], "normal", FRAME[1])
        else:
            paper.joint(tip, False)
        paper.text(start + [0.4, -0.4, 0], name, fontsize=9)
    return paper


PICTURES: tuple[Callable[[], Paper], ...] = (
    frames,
    revolute,
    prismatic,
    universal,
    spring,
    shared,
    link,
    rod,
    tips,
)


def main(folder: Path = FOLDER) -> None:
    """All pictures."""
    folder.mkdir(parents=True, exist_ok=True)
    for picture in PICTURES:
        picture().save(folder / f"{picture.__name__}.png")


if __name__ == "__main__":
    main()
