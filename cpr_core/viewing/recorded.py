# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What is on screen as YAML, and pictures as a GIF."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from ..lie import quaternion_from_rotation
from ..version import __version__
from ..workspace.stored_values import plain_values
from .bars import bars
from .handled_robot import HandledRobot
from .refused import Asked

__all__ = ["as_gif", "as_yaml", "screen"]


def screen(handled: HandledRobot) -> dict[str, Any]:
    """What is on screen as plain values, SI units."""
    current, refused = handled.equilibrium, handled.refused
    shown: dict[str, Any] = {
        "cpr": __version__,
        "robot": current.robot.description.name,
        "source": str(current.robot.description.source),
        "modes": [list(rod.modes.counts) for rod in current.robot.description.rods],
        "motors": dict(zip(current.robot.motor_names, current.motors.tolist(), strict=True)),
        "efforts": dict(zip(current.robot.motor_names, current.efforts.tolist(), strict=True)),
        "platform": {
            "position": current.platform_position.tolist(),
            "quaternion_wxyz": current.platform_quaternion.tolist(),
        },
        "gravity": current.loads.gravity.tolist(),
        "wrench_world": current.loads.wrench_world.tolist(),
        "energy": current.energy,
        "index_locked": current.index_locked,
        "measures": {bar.name: float(bar.value) for bar in bars(current)},
    }
    if refused is not None:
        asked = refused.asked or Asked()
        shown["refused"] = {"kind": refused.kind, "reason": refused.reason}
        if asked.motors is not None:
            shown["refused"]["motors"] = asked.motors.tolist()
        if asked.platform is not None:
            quaternion = quaternion_from_rotation(asked.platform.rotation)
            shown["refused"]["position"] = asked.platform.position.tolist()
            shown["refused"]["quaternion_wxyz"] = quaternion.tolist()
        if asked.loads is not None:
            shown["refused"]["gravity"] = asked.loads.gravity.tolist()
            shown["refused"]["wrench_world"] = asked.loads.wrench_world.tolist()
    return shown


def as_yaml(handled: HandledRobot) -> str:
    """The same as YAML; numbers are exact."""
    return yaml.safe_dump(plain_values(screen(handled)), sort_keys=False, allow_unicode=True)


def as_gif(frames: Sequence[NDArray[np.uint8]], rate: float) -> bytes:
    """Pictures (H, W, 3) one after the other as a GIF that begins again at its end.

    Args:
        frames: The pictures; at least one.
        rate: So many a second; a GIF knows hundredths of a second.
    """
    from PIL import Image

    pictures = [
        Image.fromarray(frame[..., :3]).quantize(128, dither=Image.Dither.NONE) for frame in frames
    ]
    file = io.BytesIO()
    pictures[0].save(
        file,
        "GIF",
        save_all=True,
        append_images=pictures[1:],
        duration=max(20, round(1000.0 / rate / 10.0) * 10),
        loop=0,
        optimize=True,
    )
    return file.getvalue()
