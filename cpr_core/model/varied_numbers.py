# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The numbers of a robot and its loads in one piece of memory, where parameters can change them.

Kernels read arrays; a parameter is places in all of them. So arrays that are to be varied are views of
one memory, and a place is a position in it.
"""

from __future__ import annotations

import threading
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..kernels.kernel_arrays import Element, LoadArrays, RobotArrays
from ..kernels.prepared_robot import PreparedRobot
from .robot import Robot, kept_with_robot

__all__ = ["VariedNumbers", "are_floats", "array_starts", "legs_of_numbers", "numbers_of"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

#: What the residual is made of; natural units change with the description too, but it has none.
_MECHANICS = (
    "groups",
    "motor_ratio",
    "elements",
    "rods",
    "functions",
    "step_functions",
    "elastic",
    "rest_moment",
    "rest_steps",
    "weights",
    "integration",
    "steps",
)
_LOADS = ("gravity", "distributed", "point", "platform", "on_rods")
#: Of these, what the rods have one by one.
_ROD_LOADS = ("distributed", "point")
#: Arrays begin where cache lines do [numbers].
_LINE = 8


def numbers_of(robot: RobotArrays, loads: LoadArrays) -> Floats:
    """All numbers that the residual is made of, array by array, those of the robot first, (K + L,)."""
    return np.concatenate([_robot_numbers(robot), _load_numbers(loads)])


def are_floats(robot: RobotArrays, loads: LoadArrays) -> NDArray[np.bool_]:
    """Which of them are floats; no parameter changes the whole ones."""
    own = [_padded(_is_float(getattr(robot, name))) for name in _MECHANICS]
    return np.concatenate([*own, np.ones(len(_load_numbers(loads)), np.bool_)])


def array_starts(robot: RobotArrays, loads: LoadArrays) -> Integers:
    """Where the arrays begin among them."""
    arrays = [getattr(robot, name) for name in _MECHANICS]
    arrays += [getattr(loads, name) for name in _LOADS]
    counts = [len(_words(array)) for array in arrays]
    lengths = [count + -count % _LINE for count in counts]
    return np.concatenate([[0], np.cumsum(lengths[:-1])])


def legs_of_numbers(robot: Robot, loads: LoadArrays) -> Floats:
    """Which leg a number is of, -1: of none, or of all; in the order of ``numbers_of``."""
    arrays = robot.kernel_arrays
    # A lane without leg repeats the last leg of its group.
    lanes = np.where(arrays.lane_leg < 0, arrays.lane_leg.max(1, keepdims=True), arrays.lane_leg)
    own = {name: np.zeros_like(getattr(arrays, name)) for name in _MECHANICS}
    for array in own.values():
        if array.dtype.names is None:
            array[:] = -1.0
        for name in array.dtype.names or ():
            if array.dtype[name].base.kind == "f":
                np.moveaxis(array[name], 0, -2)[:] = lanes  # (..., groups, lanes)
    others = {name: np.zeros_like(getattr(loads, name)) for name in _LOADS}
    for name, array in others.items():
        if name in _ROD_LOADS:
            array[:] = np.array([rod.leg for rod in robot.numbers.rods])[:, None, None]
        else:
            _words(array)[:] = -1.0
    return numbers_of(arrays._replace(**own), loads._replace(**others))


def _robot_numbers(arrays: RobotArrays) -> Floats:
    return np.concatenate([_padded(_words(getattr(arrays, name))) for name in _MECHANICS])


def _load_numbers(arrays: LoadArrays) -> Floats:
    """Numbers of loads; whether there are any on rods is none of theirs."""
    parts = [_padded(_words(getattr(arrays, name))) for name in _LOADS]
    return np.concatenate([*parts[:-1], np.zeros(_LINE)])


class VariedNumbers:
    """Arrays of a robot and of loads of their own, in one memory; for one thread.

    Attributes:
        prepared: The robot as kernels take it; its workspace is that of the robot.
        numbers: The memory, in the order of ``numbers_of``.
        memory: As much again, for what was there.
        robot_count: Numbers of the robot, K.
    """

    def __init__(self, robot: Robot, loads: LoadArrays) -> None:
        """Copy them."""
        arrays = robot.kernel_arrays
        own, others = _robot_numbers(arrays), _load_numbers(loads)
        self.numbers = _aligned(len(own) + len(others))
        self.memory = np.empty(len(self.numbers))
        self.robot_count = len(own)
        self.numbers[: len(own)] = own
        views: dict[str, Any] = _views(arrays, _MECHANICS, self.numbers[: len(own)])
        # A link without mass may be varied in it.
        views["elements"]["heavy"] |= views["elements"]["kind"] == Element.LINK
        _, work, pencil = robot.prepared.values
        self.prepared = PreparedRobot(arrays._replace(**views), work, pencil)
        self._loads = LoadArrays(**_views(loads, _LOADS, self.numbers[len(own) :]))
        self._copied: LoadArrays | None = None

    @staticmethod
    def of(robot: Robot, loads: LoadArrays) -> VariedNumbers:
        """Those of a robot and this thread; the loads say how many numbers such loads have."""
        kept = _of_threads(robot)
        try:
            varied: VariedNumbers = kept.varied
        except AttributeError:
            varied = kept.varied = VariedNumbers(robot, loads)
        return varied

    def loads(self, loads: LoadArrays) -> LoadArrays:
        """Loads in the memory; rods may carry some, whether these have any there or not."""
        if self._copied is not loads:
            self.numbers[self.robot_count :] = _load_numbers(loads)
            self._loads.on_rods[0] = 1.0
            self._copied = loads
        return self._loads


@kept_with_robot
def _of_threads(robot: Robot) -> threading.local:
    return threading.local()


def _views(arrays: Any, names: tuple[str, ...], numbers: Floats) -> dict[str, NDArray[Any]]:
    """Arrays of the same kinds in a memory."""
    views, start = {}, 0
    for name in names:
        array = getattr(arrays, name)
        count = len(_words(array))
        views[name] = numbers[start : start + count].view(array.dtype).reshape(array.shape)
        start += count + -count % _LINE
    return views


def _aligned(count: int) -> Floats:
    """Memory that begins where a cache line does."""
    numbers = np.zeros(count + _LINE)
    first = (-numbers.ctypes.data % (8 * _LINE)) // 8
    return numbers[first : first + count]


def _words(array: NDArray[Any]) -> Floats:
    """An array as numbers of eight bytes, one after the other: a view."""
    return array.reshape(-1).view(np.float64)


def _padded(words: NDArray[Any]) -> NDArray[Any]:
    """With nothing behind, up to the end of a line."""
    missing = -len(words) % _LINE
    return np.concatenate([words, np.zeros(missing, words.dtype)]) if missing else words


def _is_float(array: NDArray[Any]) -> NDArray[np.bool_]:
    """Which numbers of an array are floats."""
    if array.dtype.names is None:
        return np.ones(len(_words(array)), np.bool_)
    row = np.zeros(array.dtype.itemsize // 8, np.bool_)
    for name in array.dtype.names:
        kind, offset = array.dtype.fields[name][:2]  # type: ignore[index]
        row[offset // 8 : (offset + kind.itemsize) // 8] = kind.base.kind == "f"
    return np.tile(row, array.size)
