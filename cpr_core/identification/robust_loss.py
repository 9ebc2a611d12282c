# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Losses by which measurements count less the farther off they are, and what that costs."""

from __future__ import annotations

import math
from functools import cache
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from ..validation import checked_word

__all__ = ["Loss", "checked_loss", "loss_width", "pull", "variance_factor"]

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

    Of an estimate by a loss with the derivative psi that is ``E[psi^2] / E[psi']^2``. Noise is as it is
    stated, which makes it a constant of the loss; outliers make it larger, and that the residuals say.

    Args:
        loss: The loss.
        residuals: In standard deviations, (M,).
        unknowns: Number of parameters found.
    """
    if loss == "linear":
        return 1.0
    stated, count = _stated_factor(loss), len(residuals)
    if count <= unknowns:  # nothing is left of the residuals, with outliers among them or not
        return stated
    pulls, slope = pull(loss, residuals), _slope(loss, residuals)
    mean = max(float(slope.mean()), 1.0 / count)  # where all are outliers, as if one was none
    # Huber, Robust Statistics (1981), 7.6: residuals are less than noise, as parameters follow it.
    fewer = 1.0 + unknowns / count * float(slope.var()) / mean**2
    return max(stated, fewer**2 * float(pulls @ pulls) / (count - unknowns) / mean**2)


@cache
def _stated_factor(loss: Loss) -> float:
    """The same of noise that is normal with the stated deviations, by quadrature."""
    noise, step = np.linspace(-10.0, 10.0, 4001, retstep=True)
    density = step * np.exp(-0.5 * noise**2) / math.sqrt(2.0 * math.pi)
    pulls = pull(loss, noise)
    slope = density @ (noise * pulls)  # E[psi'], by parts
    return float(density @ pulls**2 / slope**2)


def pull(loss: Loss, residuals: Floats) -> Floats:
    """How a loss pulls at residuals in standard deviations, psi, (M,): squares by what they are."""
    if loss == "linear":
        return residuals
    width = _WIDTHS[loss]
    away = residuals / width
    if loss == "huber":
        return np.clip(residuals, -width, width)
    return residuals / (np.sqrt(1.0 + away**2) if loss == "soft_l1" else 1.0 + away**2)


def _slope(loss: Loss, residuals: Floats) -> Floats:
    """Its derivative, (M,)."""
    away = residuals / _WIDTHS[loss]
    if loss == "huber":
        return (np.abs(away) <= 1.0).astype(float)
    if loss == "soft_l1":
        return np.asarray((1.0 + away**2) ** -1.5)
    return np.asarray((1.0 - away**2) / (1.0 + away**2) ** 2)
