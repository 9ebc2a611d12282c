# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Robots that a tracker sees, and what it tells of them."""

from dataclasses import replace

import numpy as np

import cpr_core
from cpr_core.lie import quaternion_from_rotation, rotation_exp
from helpers.yaml_content import shipped_content

FRAME = ("position", "rotation_vector")
TRACKER = tuple(f"tracker.{name}[{axis}]" for name in FRAME for axis in range(3))
MARKER = tuple(f"tracker.marker.{name}[{axis}]" for name in FRAME for axis in range(3))


def tracked_content(name="six_rfs", frame=(), marker=()):
    """Description of a shipped robot with a tracker; numbers as in TRACKER and MARKER, else 0."""
    content = shipped_content(name)
    tracker, mark = (
        {"position": [*each[:3]], "rotation_vector": [*each[3:]]} if each else {}
        for each in (frame, marker)
    )
    content["tracker"] = tracker | {"marker": mark}
    return content


def tracked(name="six_rfs", frame=(), marker=()):
    """The robot of it."""
    return cpr_core.load_robot(tracked_content(name, frame, marker))


def as_told(rows, robot, *, turned=True):
    """World measurements as the tracker of a robot tells them; without turned no orientations."""
    found, tracker = [], robot.description.tracker
    for row in rows:
        position, rotation = tracker.marker_in_tracker(row.position, row.rotation)
        quaternion = quaternion_from_rotation(rotation) if turned else None
        found.append(replace(row, position=position, quaternion_wxyz=quaternion, frame="tracker"))
    return found


def noisy(rows, deviations, seed):
    """The same with the noise of a tracker, in its own frame."""
    generator, found = np.random.default_rng(seed), []
    for row in rows:
        position = row.position + generator.normal(0.0, deviations.position, 3)
        quaternion = row.quaternion_wxyz
        if quaternion is not None:
            turn = rotation_exp(generator.normal(0.0, deviations.rotation, 3))
            quaternion = quaternion_from_rotation(turn @ row.rotation)
        found.append(replace(row, position=position, quaternion_wxyz=quaternion))
    return found


def random_frame(generator, size):
    """Numbers of a frame anywhere, turned by anything."""
    way = generator.normal(size=3)
    return [
        *(size * generator.normal(size=3)),
        *(generator.uniform(0, np.pi) * way / np.linalg.norm(way)),
    ]
