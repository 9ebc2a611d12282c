# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""From a description, wherever it is, to a robot that can be solved."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..description.description_file import read_description
from ..description.stiffness_jumps import check_jumps
from ..errors import CprError, DescriptionError
from ..model.robot import Robot
from .chosen_modes import choose_modes

__all__ = ["load_robot"]


def load_robot(robot: str | Path | Mapping[str, Any], modes: int | None = None) -> Robot:
    """Load a robot.

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
    description = read_description(robot)
    if modes is not None:
        description = description.with_modes(modes)
    if modes is not None or math.isinf(description.tolerance):
        check_jumps(description)
        return Robot(description)
    try:
        return choose_modes(Robot(description), description.tolerance)
    except DescriptionError:
        raise
    except CprError as error:
        text, at_home = str(error), f"{description.source}: home: "
        field = "home" if text.startswith(at_home) else "strain.tolerance"
        raise DescriptionError(description.source, field, text.removeprefix(at_home)) from error
