# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What a description was made of, kept with it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import yaml

from ..validation import cached_property

__all__ = ["WrittenFields"]


@dataclass(frozen=True, eq=False, repr=False)
class WrittenFields:
    """The fields of a description.

    Attributes:
        content: As they were written; never to be changed.
        read: What was read of them by path, such as ``legs[2].motor.offset``, with the defaults of
            what was not written.
        read_text: The file as it was read, empty where there was none; None: there was one, of which
            these fields are a change.
    """

    content: Mapping[str, Any]
    read: Mapping[str, Any]
    read_text: str | None

    @cached_property
    def text(self) -> str:
        """The fields as a file; empty where they were not read from one."""
        if self.read_text is not None:
            return self.read_text
        dumped = yaml.dump(
            dict(self.content),
            Dumper=_Dumper,
            sort_keys=False,
            default_flow_style=None,
            allow_unicode=True,  # names as people read them
        )
        return str(dumped)


class _Dumper(getattr(yaml, "CSafeDumper", yaml.SafeDumper)):  # type: ignore[misc]
    """YAML as it is written by hand: lists in a line, nothing said once for several places."""

    def ignore_aliases(self, data: Any) -> bool:
        return True
