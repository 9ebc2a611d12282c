"""The stability message a supervisory controller acts on."""

from __future__ import annotations

import math
from dataclasses import dataclass

from builtin_interfaces.msg import Time
from cpr_msgs.msg import StabilityMetrics
from std_msgs.msg import Header

from cpr_core import Equilibrium

from .conversions import Frames

__all__ = ["Thresholds", "stability_metrics"]

_TEXTS = {
    StabilityMetrics.STATUS_INVALID: "stability unknown",
    StabilityMetrics.STATUS_NO_WARNING: "stable",
    StabilityMetrics.STATUS_DECELERATE_FOR_STABILITY: "stability margin below the warning threshold",
    StabilityMetrics.STATUS_HALT_FOR_STABILITY: "stability margin below the stop threshold",
}


@dataclass(frozen=True)
class Thresholds:
    """Margins of Spectrum.margin, dimensionless.

    Attributes:
        warning: Below it the motors should slow down, linearly.
        stop: Below it they should halt.
    """

    warning: float
    stop: float


def stability_metrics(
    equilibrium: Equilibrium,
    thresholds: Thresholds,
    frames: Frames,
    stamp: Time,
    solve_time: float,
) -> StabilityMetrics:
    """Metrics of an equilibrium and what they ask for."""
    locked, free = equilibrium.spectrum_locked, equilibrium.spectrum_free
    status, scale = _verdict(locked.margin, thresholds)
    text = _TEXTS[status]
    if not locked.energy_criterion_applies:
        # No energy decides: be as careful as the numbers say, but never call it stable.
        text = f"non-conservative load, energy does not decide stability ({text})"
        if status == StabilityMetrics.STATUS_NO_WARNING:
            status = StabilityMetrics.STATUS_INVALID
    action = StabilityMetrics.ACTION_NONE
    if scale == 0.0:
        action = StabilityMetrics.ACTION_HALT
    elif scale < 1.0:
        action = StabilityMetrics.ACTION_SLOW
    return StabilityMetrics(
        header=Header(stamp=stamp, frame_id=frames.base),
        status=status,
        status_text=text,
        action=action,
        speed_scale=scale,
        converged=equilibrium.converged,
        residual=equilibrium.residual,
        energy_criterion_applies=locked.energy_criterion_applies,
        index_locked=locked.index,
        index_free=free.index,
        smallest_eigenvalues_locked=locked.eigenvalues[:4].tolist(),
        smallest_eigenvalues_free=free.eigenvalues[:4].tolist(),
        inverse_condition_number=locked.inverse_condition_number,
        margin=locked.margin,
        margin_warning=thresholds.warning,
        margin_stop=thresholds.stop,
        solve_time=solve_time,
    )


def _verdict(margin: float, thresholds: Thresholds) -> tuple[int, float]:
    """Status and speed scale: 1 above the warning margin, 0 below the stop margin, linear between."""
    if math.isnan(margin):
        return StabilityMetrics.STATUS_INVALID, 0.0
    scale = (margin - thresholds.stop) / (thresholds.warning - thresholds.stop)
    scale = min(1.0, max(0.0, scale))
    if scale == 0.0:
        return StabilityMetrics.STATUS_HALT_FOR_STABILITY, scale
    if scale < 1.0:
        return StabilityMetrics.STATUS_DECELERATE_FOR_STABILITY, scale
    return StabilityMetrics.STATUS_NO_WARNING, scale
