# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Descriptions as files: YAML in, checked against the schema, errors that name file and field."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from copy import deepcopy
from functools import cache, lru_cache
from pathlib import Path
from typing import Any

import yaml

from ..description_part import Described
from ..errors import DescriptionError
from ..rods.sections import SECTIONS
from ..rods.strain_basis import STRAIN_BASES
from .chain_joints import CHAIN_JOINTS
from .description_builder import described_robot
from .description_paths import Place, numbers_in, path_of
from .description_schema import description_schema, without_references
from .joints import JOINTS
from .motors import MOTORS
from .number_schema import surely_allowed
from .robot_description import RobotDescription

__all__ = ["check_numbers", "check_schema", "read_description", "shipped_robots"]


def shipped_robots() -> dict[str, Path]:
    """Descriptions that come with the package, by name."""
    package = Path(__file__).resolve().parents[1]
    # Inside the package where it is installed, beside it in the source tree.
    folder = next(path for path in (package / "config", package.parent / "config") if path.is_dir())
    return {path.stem: path for path in sorted(folder.glob("*.yaml")) if path.stem != "cpr_node"}


def read_description(robot: str | Path | Mapping[str, Any]) -> RobotDescription:
    """Read and check a description.

    Args:
        robot: Name of a shipped robot, a YAML file, the text of one (more than one line, or in braces),
            or its content.

    Raises:
        DescriptionError: Names the file, the field, what was found and what was expected.
    """
    empty = isinstance(robot, str) and not robot.strip()  # as a path it would be this folder
    if empty or not isinstance(robot, str | Path | Mapping):
        raise DescriptionError(
            "description", "", f"expected a name, a file or its content, got {robot!r:.200}"
        )
    text = ""
    if isinstance(robot, Mapping):
        source = str(robot.get("name", "description"))
    elif isinstance(robot, str) and ("\n" in robot or robot.startswith("{")):
        source, text = "description", robot
    else:
        path = _find(robot)
        source = str(path)
        try:
            text = path.read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            raise DescriptionError(source, "", f"cannot be read: {error}") from None
    try:
        if isinstance(robot, Mapping):
            content = _with_numbers(dict(robot))
            check_schema(source, content)
        else:
            content = deepcopy(_checked(source, text, _kinds()))
    except RecursionError:
        raise DescriptionError(source, "", "is nested too deeply, or refers to itself") from None
    return described_robot(source, content, text)


@lru_cache(maxsize=32)
def _checked(source: str, text: str, kinds: tuple[tuple[str, type[Described]], ...]) -> Any:
    """Content of a YAML text, which keeps to the schema of these kinds.

    Kept: that takes most of the time to load a robot, and robots are loaded again and again.
    """
    content = _parsed(source, text)
    check_schema(source, content)
    return content


def _parsed(source: str, text: str) -> Any:
    """Content of a YAML text."""
    try:
        return yaml.load(text, Loader=_Loader)
    except (yaml.YAMLError, TypeError, ValueError, RecursionError) as error:
        raise DescriptionError(source, "", f"is not valid YAML: {error}") from None


def _with_numbers(content: Any) -> Any:
    """Content with numbers such as 210e9, which YAML 1.1 reads as words, outside names."""
    if isinstance(content, dict):
        return {
            key: value if key in ("name", "leg") else _with_numbers(value)
            for key, value in content.items()
        }
    if isinstance(content, list):
        return [_with_numbers(value) for value in content]
    return float(content) if isinstance(content, str) and _EXPONENT.match(content) else content


def _find(robot: str | Path) -> Path:
    """Path of a shipped robot or of a file."""
    shipped = shipped_robots()
    if str(robot) in shipped:
        return shipped[str(robot)]
    path = Path(robot)
    try:
        found, folder, other = path.is_file(), path.is_dir(), path.exists()
    except (OSError, ValueError):  # not even a possible name
        found, folder, other = False, False, False
    if not found:
        hint = " (it is a folder)" if folder else " (it is something else)" if other else ""
        raise DescriptionError(
            str(robot),
            "",
            f"no such file{hint}, nor a shipped robot (shipped: {', '.join(shipped) or 'none'})",
        )
    return path


#: libyaml where there is one.
_Reader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


class _Loader(yaml.composer.Composer, _Reader):
    """YAML as people write it: numbers as in YAML 1.2, every field once.

    YAML 1.1 reads 2.1e11 as a word, 010 as eight and 1:30 as ninety. Python puts together what
    libyaml reads: there, what is nested too deeply would end the process.
    """

    def __init__(self, stream: str) -> None:
        _Reader.__init__(self, stream)
        yaml.composer.Composer.__init__(self)

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        seen = set()
        for key_node, _ in node.value:
            if key_node.tag == "tag:yaml.org,2002:merge":
                continue
            key = self.construct_object(key_node, deep=True)
            if key in seen:
                raise yaml.constructor.ConstructorError(
                    None, None, f"field {key!r} is given twice", key_node.start_mark
                )
            seen.add(key)
        return super().construct_mapping(node, deep)

    def construct_decimal(self, node: yaml.ScalarNode) -> int:
        return int(self.construct_scalar(node), base=10)


#: Numbers with an exponent that YAML 1.1 takes for words: without a point, or without its sign.
_EXPONENT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)e[-+]?[0-9]+$", re.IGNORECASE)

_NUMBERS = {
    "tag:yaml.org,2002:int": r"[-+]?[0-9][0-9_]*$",
    "tag:yaml.org,2002:float": (
        r"[-+]?(\.[0-9_]+|[0-9][0-9_]*(\.[0-9_]*)?)(e[-+]?[0-9]+)?$|[-+]?\.inf$|\.nan$"
    ),
}
_Loader.yaml_implicit_resolvers = {
    first: [(tag, pattern) for tag, pattern in resolvers if tag not in _NUMBERS]
    for first, resolvers in yaml.SafeLoader.yaml_implicit_resolvers.items()
}
for _tag, _pattern in _NUMBERS.items():
    _Loader.add_implicit_resolver(_tag, re.compile(_pattern, re.IGNORECASE), list("-+0123456789."))
_Loader.add_constructor("tag:yaml.org,2002:int", _Loader.construct_decimal)


#: The only numbers that may be infinite: a motor that has a limit to one side.
_END_OF_A_RANGE = re.compile(r"\blimits\.position\[[01]\]$")


@cache
def _validator(kinds: tuple[tuple[str, type[Described]], ...]) -> Any:
    """What checks content, made once for all classes that have a name now."""
    import jsonschema  # takes as long to import as all of this package

    return jsonschema.Draft202012Validator(without_references(description_schema()))


def check_numbers(source: str, content: Any, places: Mapping[Place, float]) -> None:
    """The same as ``check_schema`` where content kept to the schema before it got these finite numbers.

    Raises:
        DescriptionError: It does not with them.
    """
    validator = _validator(_kinds())
    if not all(surely_allowed(validator, content, *number) for number in places.items()):
        check_schema(source, content)


def check_schema(source: str, content: Any) -> None:
    """Structure, types and ranges, against the JSON schema."""
    if not isinstance(content, dict):
        raise DescriptionError(source, "", f"expected fields and values, got {content!r:.60}")
    for path, number in numbers_in(content):
        try:
            allowed = math.isfinite(number) or (
                math.isinf(number) and _END_OF_A_RANGE.search(path) is not None
            )
        except OverflowError:  # a whole number beyond all floats
            allowed = False
        if not allowed:
            raise DescriptionError(source, path, f"expected a finite number, got {number!s:.40}")
    errors = list(_validator(_kinds()).iter_errors(content))
    # A misspelt field is also a missing one: say the misspelt name.
    unknown = [error for error in errors if error.validator == "additionalProperties"]
    if not errors:
        return
    from jsonschema.exceptions import best_match

    error = best_match(unknown or errors)
    assert error is not None
    raise DescriptionError(source, path_of(error.absolute_path), _explain(error))


def _kinds() -> tuple[tuple[str, type[Described]], ...]:
    """All classes that have a name now."""
    every = (MOTORS, CHAIN_JOINTS, JOINTS, SECTIONS, STRAIN_BASES)
    return tuple(item for named in every for item in named.items())


def _explain(error: Any) -> str:
    """What was found and what was expected."""
    found, limit = error.instance, error.validator_value
    meaning = error.schema.get("description", "")
    about = f" ({meaning})" if meaning else ""
    match error.validator:
        case "required":
            missing = [name for name in limit if name not in found]
            return f"missing field {missing[0]!r}"
        case "additionalProperties":
            known = list(error.schema["properties"])
            unknown = [name for name in found if name not in known]
            return f"unknown field {unknown[0]!r}, expected one of {', '.join(known)}"
        case "enum":
            return f"expected one of {', '.join(map(str, limit))}, got {found!r}{about}"
        case "type":
            return f"expected {limit}, got {found!r}{about}"
        case "exclusiveMaximum":
            return f"expected a number below {limit}, got {found}{about}"
        case "exclusiveMinimum":
            return f"expected a number above {limit}, got {found}{about}"
        case "minimum" | "maximum":
            bound = "least" if error.validator == "minimum" else "most"
            return f"expected a number of at {bound} {limit}, got {found}{about}"
        case "minItems" | "maxItems":
            bound = "at least" if error.validator == "minItems" else "at most"
            if error.schema.get("minItems") == error.schema.get("maxItems"):
                bound = "exactly"
            return f"expected {bound} {limit} entries, got {len(found)}{about}"
        case "uniqueItems":
            return f"expected no entry twice, got {found}{about}"
        case "anyOf":
            return f"expected another form, got {found!r:.60}{about}"
        case "oneOf":
            names = [choice["required"][0] for choice in limit]
            given = [name for name in names if name in found]
            if not given:
                first, *others = map(repr, names)
                got = f", got {', '.join(map(repr, found))}" if found else ""
                return f"missing field {first} (or {', '.join(others)}){got}"
            return f"expected one of {', '.join(names)}, got {' and '.join(given)}"
        case "not":
            return str(meaning)
    return f"{error.message}{about}"
