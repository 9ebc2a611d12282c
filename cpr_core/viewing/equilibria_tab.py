# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The tab of other equilibria: found while one looks, a click goes to one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from ..errors import CprError
from ..model.equilibrium import Equilibrium
from ..solving.find_equilibria import FoundEquilibrium, find_equilibria, merged_equilibria
from .background import Background, Task
from .controls import Do
from .handled_robot import HandledRobot
from .status_panel import as_plain

if TYPE_CHECKING:
    import viser

__all__ = ["EquilibriaTab", "search"]

#: Starts of one round, after which what was found is shown, and rounds of one search.
_STARTS, _ROUNDS = 50, 10
#: Buttons at most; more would not be found.
_SHOWN = 16


def search(
    current: Equilibrium,
    told: Callable[[tuple[FoundEquilibrium, ...]], None],
    stopped: Callable[[], bool],
    starts: int = _STARTS,
    rounds: int = _ROUNDS,
) -> None:
    """Search equilibria at the motors and under the loads of one, round by round.

    Args:
        current: Where to search from: its motors and loads.
        told: Called after every round with all that are known, by energy.
        stopped: Whether to stop after this round.
        starts: Random starts of a round.
        rounds: How many rounds.
    """
    known: tuple[FoundEquilibrium, ...] = ()
    for number in range(rounds):
        new = find_equilibria(
            current.robot, current.motors, starts=starts, seed=number, loads=current.loads
        )
        known = merged_equilibria(known, new)
        if stopped():
            return
        told(known)


class EquilibriaTab:
    """A button that searches, and one for every equilibrium."""

    def __init__(self, gui: viser.GuiApi, do: Do, background: Background) -> None:
        self._gui, self._do, self._background = gui, do, background
        self._found: tuple[FoundEquilibrium, ...] = ()
        find: Any = gui.add_button("find others")
        self._text = gui.add_markdown("Equilibria at the motors of now, by energy.")
        self._buttons: list[Any] = []
        for number in range(_SHOWN):
            self._buttons.append(self._button(number))

        async def asked(_: Any) -> None:
            self._do("find", self._begin)

        find.on_click(asked)

    def _button(self, number: int) -> Any:
        button: Any = self._gui.add_button("", visible=False)

        async def chosen(_: Any) -> None:
            self._do("jump", lambda handled: self._jump(handled, number))

        button.on_click(chosen)
        return button

    def _begin(self, handled: HandledRobot) -> None:
        current = handled.equilibrium
        self._show((), "searching")

        def work(task: Task) -> None:
            def told(found: tuple[FoundEquilibrium, ...]) -> None:
                task.post("found", lambda _: self._show(found, "searching"))

            end = "done"
            try:
                search(current, told, task.stopped)
            except CprError as error:
                end = str(error)
            task.post("searched", lambda _: self._show(self._found, end))

        self._background.start("equilibria", work)

    def _show(self, found: Sequence[FoundEquilibrium], state: str) -> None:
        self._found = tuple(found)
        stable = sum(each.stable for each in found)
        self._text.content = as_plain(f"{len(found)} found, {stable} stable; {state}")
        for number, button in enumerate(self._buttons):
            button.visible = number < len(found)
            if number < len(found):
                label = label_of(found[number])
                if button.label != label:
                    button.label = label
                    button.color = "green" if found[number].stable else "gray"

    def _jump(self, handled: HandledRobot, number: int) -> None:
        if number < len(self._found):
            chosen = self._found[number]
            handled.take(chosen.equilibrium, f"jumped to another equilibrium: {label_of(chosen)}")


def label_of(found: FoundEquilibrium) -> str:
    """Energy and index of an equilibrium, and how often it was met."""
    equilibrium = found.equilibrium
    kind = "stable" if found.stable else f"index {equilibrium.index_locked}"
    home = ", branch of home" if found.from_home else ""
    beyond = ", beyond a limit" if found.beyond else ""
    return f"{equilibrium.energy:.5g} J, {kind}, met {found.starts} times{home}{beyond}"
