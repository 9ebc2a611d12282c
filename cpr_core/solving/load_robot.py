# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""From a description, wherever it is, to a robot that can be solved."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

from ..description.description_file import (
    DescribedKinds,
    described_kinds,
    read_description,
    shipped_robots,
)
from ..errors import CprError, DescriptionError
from ..model.robot import Robot
from .chosen_modes import choose_modes

__all__ = ["load_robot"]


def load_robot(robot: str | Path | Mapping[str, Any], modes: int | None = None) -> Robot:
    """Load a robot.

    A shipped robot is the same object whenever it is asked for: nothing of it changes, and what is found
    about it, such as its home, is found once.

    Args:
        robot: Name of a shipped robot (``rfrfr``, ``six_rfs``), a YAML file, the text of one (more than
            one line, or in braces), or its content as a mapping.
        modes: Number of strain modes per direction, instead of the description's; instead of a
            ``strain.tolerance`` in every direction, torsion too. Without it, a description with such a
            tolerance has them chosen, which takes some tenths of a second.

    Raises:
        DescriptionError: The description is not valid, or its tolerance cannot be met; names the file,
            field and expectation.

    Warns:
        DescriptionWarning: It is valid, but a number looks like another unit.
    """
    if isinstance(robot, str) and (modes is None or type(modes) is int):
        file = shipped_robots().get(robot)
        if file is not None:
            return _shipped(robot, file.read_text(encoding="utf-8"), described_kinds(), modes)
    return _loaded(robot, modes)


@lru_cache(maxsize=32)
def _shipped(name: str, text: str, kinds: DescribedKinds, modes: int | None) -> Robot:
    """A shipped robot; its text and the classes that have a name may be others later."""
    return _loaded(name, modes)


def _loaded(robot: str | Path | Mapping[str, Any], modes: int | None) -> Robot:
    description = read_description(robot)
    if modes is not None:
        return Robot(description.with_modes(modes))
    if math.isinf(description.tolerance):
        return Robot(description)
    try:
        return choose_modes(Robot(description), description.tolerance)
    except DescriptionError:
        raise
    except CprError as error:
        raise DescriptionError(description.source, "strain.tolerance", str(error)) from error
