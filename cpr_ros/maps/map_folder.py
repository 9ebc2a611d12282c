# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Where maps may be written: whoever is heard by the node may order them. No ROS here."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from cpr_core import InvalidRequest

from ..operation.kept_state import state_folder

if TYPE_CHECKING:
    from ..settings.node_settings import Parameters

__all__ = ["MapFolder"]


#: Longest path that Linux takes.
_LONGEST = 4096


@dataclass(frozen=True)
class MapFolder:
    """The folder of maps.

    Attributes:
        folder: The folder, absolute; made for its first map.
        anywhere: Whether files outside of it may be named as well.
    """

    folder: Path
    anywhere: bool

    @classmethod
    def of(cls, parameters: Parameters) -> MapFolder:
        """What the parameters say.

        Raises:
            CprError: It is in the home of a user, who has none.
        """
        given = parameters.map_directory
        folder = state_folder(given, "map_directory")
        if not given:
            folder /= "maps"
        return cls(folder.absolute(), parameters.map_anywhere)

    def file(self, name: str) -> Path:
        """The file that a name means, absolute; what is relative is in the folder.

        Raises:
            InvalidRequest: No such file may be written, or it is none that can hold a map.
        """
        if not name:
            raise InvalidRequest("file", "expected the name of a NetCDF file, got none")
        if len(name) > _LONGEST:
            raise InvalidRequest("file", f"expected a name of at most {_LONGEST} letters")
        try:
            return self._checked(name)
        except (OSError, RuntimeError, ValueError) as error:  # too long, NUL, ~nobody
            raise InvalidRequest(
                "file", f"expected a name of a file, got {name!r}: {error}"
            ) from None

    def _checked(self, name: str) -> Path:
        file = self.folder / (Path(name).expanduser() if self.anywhere else name)
        inside = file.resolve().is_relative_to(self.folder.resolve())
        if not (inside or self.anywhere):
            raise InvalidRequest(
                "file",
                f"expected a file in {self.folder} (parameter map_directory), got {name!r}: other "
                "places are allowed by the parameter map_anywhere",
            )
        if inside:
            self._make()
        if file.exists() and not (file.is_file() or file.is_dir()):
            raise InvalidRequest("file", f"expected an ordinary file, {file} is none")
        return file

    def _make(self) -> None:
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InvalidRequest(
                "file", f"{self.folder} (parameter map_directory) cannot be made: {error}"
            ) from None
