# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The model alone, and one dense LU of the matrix of the forward problem (its KKT matrix)."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np
from scipy.linalg import lapack, lu_factor

from cpr_core.model.model_state import evaluate

from .measure import Case
from .walks import ROBOTS, walk_of

__all__ = ["matrix_sizes", "model_cases"]


def model_cases(modes: tuple[int, ...]) -> Iterator[Case]:
    """Residual and tangent in one call from Python, and the LU factors of the tangent."""
    for name in ROBOTS:
        for count in modes:
            start = walk_of(name, count, "forward").start
            evaluation = partial(
                evaluate,
                start.robot,
                start.load_arrays,
                start.state,
                start.platform_rotation,
                start.platform_position,
            )
            yield Case(f"residual and tangent/{name}/{count}", evaluation)
            matrix = _matrix(name, count)
            yield Case(f"dense LU, scipy/{name}/{count}", partial(lu_factor, matrix))
            yield Case(f"dense LU, LAPACK/{name}/{count}", partial(lapack.dgetrf, matrix))


def matrix_sizes(modes: tuple[int, ...]) -> dict[str, int]:
    """Rows of the matrices, by robot and modes."""
    return {f"{name}/{count}": len(_matrix(name, count)) for name in ROBOTS for count in modes}


def _matrix(name: str, modes: int) -> np.ndarray:
    """Dimensionless matrix of the forward problem, in the order LAPACK wants."""
    start = walk_of(name, modes, "forward").start
    arrays = start.robot.kernel_arrays
    size = arrays.motor_index
    unit = arrays.unit[:size]
    matrix = start.tangent[:size, :size] * unit[:, None] * unit / arrays.energy_unit
    return np.asfortranarray(matrix)
