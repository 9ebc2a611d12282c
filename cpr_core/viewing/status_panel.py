# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What the page says of a robot: whether it is stable, what was refused and why, and the bars."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from .bars import Bar
from .handled_robot import HandledRobot
from .sent import send_new

if TYPE_CHECKING:
    import viser

__all__ = ["BarsPanel", "as_plain", "status_text"]

_COLORS = {"fine": "green", "slow": "yellow", "stop": "red"}


def status_text(handled: HandledRobot) -> str:
    """Stability in a line, then what was refused, or done."""
    current = handled.equilibrium
    if not current.spectrum_locked.energy_criterion_applies:
        verdict = (
            f"energy does not decide (index {current.index_locked}): a load without potential acts"
        )
    elif current.index_locked == 0:
        verdict = "stable with the motors held"
    else:
        verdict = f"UNSTABLE: index {current.index_locked} with the motors held"
    lines = [f"**{verdict}**"]
    if handled.refused is not None:
        lines.append(f"**Refused ({handled.refused.kind})**: {as_plain(handled.refused.reason)}")
    elif handled.words:
        lines.append(as_plain(handled.words))
    return "\n\n".join(lines)


def as_plain(text: str) -> str:
    """Text that Markdown shows as it is."""
    for sign in r"\`*_{}[]<>#|":
        text = text.replace(sign, f"\\{sign}")
    return text


class BarsPanel:
    """One bar for every measure."""

    def __init__(self, gui: viser.GuiApi, first: Sequence[Bar]) -> None:
        self._names = [bar.name for bar in first]
        self._rows = []
        for _ in first:
            self._rows.append((gui.add_markdown(""), gui.add_progress_bar(0.0)))
        self.show(first)

    def show(self, bars: Sequence[Bar]) -> None:
        """Fill the bars; what a measure does not say any more stays empty."""
        by_name = {bar.name: bar for bar in bars}
        for name, (label, filled) in zip(self._names, self._rows, strict=True):
            bar = by_name.get(name)
            text = f"{name}: none" if bar is None else as_plain(bar.text)
            value = 100.0 if bar is None else 100.0 * bar.filled
            color = "gray" if bar is None else _COLORS[bar.level]
            send_new(label, content=text)
            if not math.isclose(filled.value, value, abs_tol=0.05):
                filled.value = value  # type: ignore[misc]
            send_new(filled, color=color)
