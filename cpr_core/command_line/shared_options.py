# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Options that several commands have, and what shows how far they are."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from tqdm import tqdm

from ..solving.objectives import OBJECTIVES
from .argument_types import count, picture, real

__all__ = [
    "add_motors",
    "add_objective",
    "add_place",
    "add_plot",
    "add_pose",
    "add_seed",
    "progress_bar",
]


def add_place(parser: argparse.ArgumentParser) -> None:
    """Where: at motors, at a pose, or at home."""
    place = parser.add_mutually_exclusive_group()
    add_motors(place)
    add_pose(place)


def add_motors(parser: argparse._ActionsContainer) -> None:
    """Where the motors are."""
    parser.add_argument(
        "--motors",
        nargs="+",
        type=real,
        metavar="Q",
        help="motor positions in the order of the motors, rad (extensible and prismatic ones: m, with a "
        "lead rad); else home",
    )


def add_pose(parser: argparse._ActionsContainer, required: bool = False) -> None:
    """Where the platform is."""
    parser.add_argument(
        "--pose",
        nargs="+",
        type=real,
        required=required,
        metavar="C",
        help="controlled coordinates in the order of the description, m and rad, as forward prints "
        "them; orientation is qw qx qy qz" + ("" if required else "; else home"),
    )


def add_objective(parser: argparse.ArgumentParser) -> None:
    """What the freedom of redundant motors is used for."""
    parser.add_argument(
        "--objective",
        choices=OBJECTIVES,
        help="what redundant motors are used for; else least_motion",
    )


def add_plot(parser: argparse.ArgumentParser, what: str) -> None:
    """The file of a picture."""
    parser.add_argument("--plot", type=picture, metavar="FILE", help=f"draw {what} (png, svg, pdf)")


def add_seed(parser: argparse.ArgumentParser, meaning: str) -> None:
    """The seed of what is random."""
    parser.add_argument(
        "--seed", type=count, default=0, metavar="N", help=f"{meaning}; default %(default)s"
    )


@contextmanager
def progress_bar(description: str) -> Iterator[Callable[[float], None]]:
    """A progress bar on a terminal, nothing elsewhere."""
    with tqdm(total=100.0, unit="%", desc=description, disable=None, leave=False) as bar:

        def show(fraction: float) -> None:
            bar.n = 100.0 * fraction
            bar.refresh() if fraction >= 1.0 else bar.update(0)

        yield show
