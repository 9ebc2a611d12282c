# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What the log is to be told. No ROS here."""

from __future__ import annotations

from typing import NamedTuple

__all__ = ["News"]


class News(NamedTuple):
    """What the log is to be told, once.

    Attributes:
        warning: Empty: none.
        information: Empty: none.
    """

    warning: str = ""
    information: str = ""
