# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The wrench somebody measures on the platform, with a timeout of its own. No ROS here."""

from __future__ import annotations

from cpr_core import Loads, Robot

from .watchdog import Watchdog

__all__ = ["ExternalWrench"]


class ExternalWrench:
    """Loads with the newest external wrench; without it when it is too old.

    Attributes:
        watchdog: Age of the newest wrench.
    """

    def __init__(self, robot: Robot, timeout: float) -> None:
        """Start without a wrench.

        Args:
            robot: The robot, whose description says what acts without an external wrench.
            timeout: Age beyond which a wrench acts no more [s]; 0: never.
        """
        self.robot, self.watchdog = robot, Watchdog(timeout)
        self._loads: Loads | None = None
        self._lost = False  # it was too old, and none has come since

    @property
    def acts(self) -> bool:
        """Whether what a message said acts, or its end is not borne yet."""
        return self._loads is not None

    @property
    def missing(self) -> str:
        """Why what pushes on the platform is not known any more; empty: it is, or nothing was said."""
        timeout = self.watchdog.timeout
        if not self._lost or timeout <= 0.0:
            return ""
        return f"the external wrench is older than wrench_timeout {timeout:g} s and acts no more"

    def forget_missing(self) -> None:
        """Be as if no wrench had ever been too old."""
        self._lost = False

    def take(self, loads: Loads, now: float) -> None:
        """Take loads with a new wrench.

        Raises:
            InvalidRequest: Loads that leave the plane of a planar robot.
        """
        self.robot.load_arrays(loads)
        # Loads with the same numbers are not solved for again.
        if self._loads is None or loads.differences(self._loads):
            self._loads = loads
        self._lost = False
        self.watchdog.feed(now)

    def at_rest(self, known: Loads) -> bool:
        """Whether known loads are those that act, and stay so until a wrench comes."""
        return not self.watchdog.expires and not self.unborne(known)

    def unborne(self, known: Loads) -> bool:
        """Whether known loads are others than those that act: these are not borne, or not yet."""
        return self._loads is not None and self._loads is not known

    def loads(self, known: Loads, now: float) -> Loads:
        """Loads that act now; ``known`` itself if nothing changed."""
        if self._loads is None:
            return known
        if self.watchdog.stale(now):
            default = self.robot.default_loads
            without = known.with_(
                wrench_world=default.wrench_world, wrench_body=default.wrench_body
            )
            # A wrench of zero says that nothing pushes, and nothing changes when it is too old.
            self._lost = any("wrench" in name for name in self._loads.differences(without))
            self._loads = without
            self.watchdog.forget()
        elif self._loads is known and self.watchdog.age(now) < 0.0:
            self._loads = None  # its end is borne: what is applied later is not taken for it
            return known
        return self._loads
