# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Losses by which measurements count less the farther off they are, and what that costs."""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from ..validation import checked_word

__all__ = ["Loss", "checked_loss", "loss_width", "variance_factor"]

Floats = NDArray[np.float64]
Loss = Literal["linear", "soft_l1", "huber", "cauchy"]

#: Residuals beyond so many standard deviations count less; 95 % as exact as squares without outliers.
_WIDTHS: dict[str, float] = {"linear": 1.0, "soft_l1": 1.287, "huber": 1.345, "cauchy": 2.385}


def checked_loss(loss: object) -> Loss:
    """A loss.

    Raises:
        InvalidRequest: Another than there are.
    """
    return checked_word("loss", loss, get_args(Loss))


def loss_width(loss: Loss) -> float:
    """Where it departs from squares, in standard deviations."""
    return _WIDTHS[loss]


def variance_factor(loss: Loss, residuals: Floats, unknowns: int) -> float:
    """By how much variances are those of least squares with the stated deviations.

    Of an estimate by a loss with the derivative psi that is ``E[psi^2] / E[psi']^2``.

    Args:
        loss: The loss.
        residuals: In standard deviations, (M,).
        unknowns: Number of parameters found.
    """
    if loss == "linear":
        return 1.0
    width = _WIDTHS[loss]
    away = residuals / width
    if loss == "huber":
        pull, slope = np.clip(away, -1.0, 1.0), (np.abs(away) <= 1.0).astype(float)
    elif loss == "soft_l1":
        pull, slope = away / np.sqrt(1.0 + away**2), (1.0 + away**2) ** -1.5
    else:
        pull, slope = away / (1.0 + away**2), (1.0 - away**2) / (1.0 + away**2) ** 2
    freedom = max(len(residuals) - unknowns, 1)
    return float(width**2 * (pull @ pull) / freedom / slope.mean() ** 2)
