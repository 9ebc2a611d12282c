# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What a description was made of, kept with it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

__all__ = ["WrittenFields"]


@dataclass(frozen=True, eq=False, repr=False)
class WrittenFields:
    """The fields of a description.

    Attributes:
        content: As they were written; never to be changed.
        read: What was read of them by path, such as ``legs[2].motor.offset``, with the defaults of
            what was not written.
    """

    content: Mapping[str, Any]
    read: Mapping[str, Any]
