"""Robot descriptions: YAML in, validated immutable values out."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import yaml
from numpy.typing import NDArray

from . import joints, motors
from .errors import CprError, DescriptionError
from .lie import rotation_from_quaternion
from .rod import Rod, StrainModes
from .sections import CircularSection
from .strain_basis import STRAIN_BASES

__all__ = [
    "CONTROLLED_COORDINATES",
    "HomeGuess",
    "LegDescription",
    "RobotDescription",
    "read_description",
    "shipped_robots",
]

Floats = NDArray[np.float64]

#: Number of scalars of every controllable platform coordinate.
CONTROLLED_COORDINATES = {"x": 1, "y": 1, "z": 1, "angle": 1, "orientation": 3}
_DIRECTIONS = ("torsion", "bending_2", "bending_3")
_DEFAULT_MODES = 5


@dataclass(frozen=True, eq=False)
class LegDescription:
    """One leg.

    Attributes:
        name: Name of the leg.
        motor_name: Name of its motor in messages; None for a passive base.
        rod: The rod.
        modes: Its strain modes.
        base_position: Base point in the world at motor zero, (3,) [m].
        base_rotation: Base frame (d1, d2, d3 as columns) in the world at motor zero, (3, 3).
        motor: What holds the base.
        joint: What holds the tip.
    """

    name: str
    motor_name: str | None
    rod: Rod
    modes: StrainModes
    base_position: Floats
    base_rotation: Floats
    motor: motors.Motor
    joint: joints.Joint


@dataclass(frozen=True, eq=False)
class HomeGuess:
    """Rough equilibrium without loads, from which the home equilibrium is found.

    Attributes:
        motors: Motor positions, (n,); these are exact.
        platform_position: (3,) [m].
        platform_rotation: (3, 3).
        strain: For every leg and every strain component Legendre coefficients of the curvature [1/m].
    """

    motors: Floats
    platform_position: Floats
    platform_rotation: Floats
    strain: tuple[tuple[Floats, Floats, Floats], ...]


@dataclass(frozen=True, eq=False)
class RobotDescription:
    """A whole robot, as its file says.

    Attributes:
        name: Name of the robot.
        source: Where the description came from.
        planar: Whether the robot lives in the plane z = 0.
        point_platform: Whether the platform has no orientation (planar only).
        platform_mass: [kg].
        center_of_mass: Of the platform in its frame, (3,) [m].
        gravity: In the world, (3,) [m/s^2].
        legs: The legs.
        controlled: Platform coordinates of the inverse problem, in order.
        home: Rough home equilibrium.
        text: The description as it was read.
    """

    name: str
    source: str
    planar: bool
    point_platform: bool
    platform_mass: float
    center_of_mass: Floats
    gravity: Floats
    legs: tuple[LegDescription, ...]
    controlled: tuple[str, ...]
    home: HomeGuess
    text: str = ""

    @property
    def motor_names(self) -> tuple[str, ...]:
        """Names of the motors in order."""
        return tuple(leg.motor_name for leg in self.legs if leg.motor_name is not None)

    def with_modes(self, modes: int) -> RobotDescription:
        """The same robot with another number of modes in every direction that has any."""
        if modes < 1:
            raise CprError(f"modes: expected at least 1, got {modes}")

        def counts(leg: LegDescription) -> tuple[int, int, int]:
            torsion, bending_2, bending_3 = (modes if count else 0 for count in leg.modes.counts)
            return torsion, bending_2, bending_3

        return replace(
            self,
            legs=tuple(
                replace(leg, modes=replace(leg.modes, counts=counts(leg))) for leg in self.legs
            ),
        )


def shipped_robots() -> dict[str, Path]:
    """Descriptions that come with the package, by name."""
    package = Path(__file__).resolve().parent
    # Inside the package where it is installed, beside it in the source tree.
    folder = next(path for path in (package / "config", package.parent / "config") if path.is_dir())
    return {path.stem: path for path in sorted(folder.glob("*.yaml")) if path.stem != "cpr_node"}


def read_description(robot: str | Path | Mapping[str, Any]) -> RobotDescription:
    """Read and check a description.

    Args:
        robot: Name of a shipped robot, a YAML file, or the content of one.

    Raises:
        DescriptionError: Names the file, the field, what was found and what was expected.
    """
    text = ""
    if isinstance(robot, Mapping):
        source, content = str(robot.get("name", "description")), dict(robot)
    else:
        path = _find(robot)
        source = str(path)
        try:
            text = path.read_text(encoding="utf-8")
            content = yaml.load(text, Loader=_Loader)
        except (OSError, UnicodeDecodeError) as error:
            raise DescriptionError(source, "", f"cannot be read: {error}") from None
        except yaml.YAMLError as error:
            raise DescriptionError(source, "", f"is not valid YAML: {error}") from None
    _check_schema(source, content)
    return _Builder(source, content, text).robot()


def _find(robot: str | Path) -> Path:
    """Path of a shipped robot or of a file."""
    shipped = shipped_robots()
    if str(robot) in shipped:
        return shipped[str(robot)]
    path = Path(robot)
    if not path.is_file():
        raise DescriptionError(
            str(robot),
            "",
            f"no such file, nor a shipped robot (shipped: {', '.join(shipped) or 'none'})",
        )
    return path


class _Loader(yaml.SafeLoader):
    """YAML as people write it: 2.1e11 is a number (in YAML 1.1 a string); keys are unique."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        seen = set()
        for key_node, _ in node.value:
            key = self.construct_object(key_node, deep=True)
            if key in seen:
                raise yaml.constructor.ConstructorError(
                    None, None, f"field {key!r} is given twice", key_node.start_mark
                )
            seen.add(key)
        return super().construct_mapping(node, deep)


_Loader.add_implicit_resolver(
    "tag:yaml.org,2002:float",
    re.compile(r"^[-+]?(\d+(\.\d*)?|\.\d+)[eE][-+]?\d+$"),
    list("-+0123456789."),
)


@cache
def _validator() -> Any:
    schema = json.loads(
        resources.files("cpr_core").joinpath("description.schema.json").read_text("utf-8")
    )
    return jsonschema.Draft202012Validator(schema)


def _check_schema(source: str, content: Any) -> None:
    """Structure, types and ranges, against the JSON schema."""
    if not isinstance(content, dict):
        raise DescriptionError(source, "", f"expected fields and values, got {content!r:.60}")
    for path, number in _numbers(content, ""):
        if not math.isfinite(number):
            raise DescriptionError(source, path, f"expected a finite number, got {number}")
    error = jsonschema.exceptions.best_match(_validator().iter_errors(content))
    if error is None:
        return
    path = ""
    for part in error.absolute_path:
        path += f"[{part}]" if isinstance(part, int) else ("." if path else "") + str(part)
    raise DescriptionError(source, path, _explain(error))


def _numbers(value: Any, path: str) -> Iterator[tuple[str, float]]:
    if isinstance(value, dict):
        for key, item in value.items():
            yield from _numbers(item, f"{path}.{key}" if path else str(key))
    elif isinstance(value, list):
        for index, item in enumerate(value):
            yield from _numbers(item, f"{path}[{index}]")
    elif isinstance(value, float):
        yield path, value


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
    return f"{error.message}{about}"


class _Builder:
    """Turns checked content into values; checks what a schema cannot."""

    def __init__(self, source: str, content: dict[str, Any], text: str) -> None:
        self.source = source
        self.content = content
        self.text = text
        self.planar = content["space"] == "planar"

    def fail(self, field: str, problem: str) -> DescriptionError:
        return DescriptionError(self.source, field, problem)

    def robot(self) -> RobotDescription:
        content = self.content
        platform = content.get("platform", {})
        point = platform.get("shape", "body") == "point"
        if point and not self.planar:
            raise self.fail("platform.shape", "a point platform needs a planar robot")
        legs = tuple(self.leg(index) for index in range(len(content["legs"])))
        for kind, names in (
            ("name", [leg.name for leg in legs]),
            ("motor.name", [leg.motor_name for leg in legs if leg.motor_name]),
        ):
            for index, name in enumerate(names):
                if name in names[:index]:
                    raise self.fail(
                        f"legs[{index}].{kind}", f"{name!r} is the name of an earlier leg already"
                    )
        description = RobotDescription(
            name=content["name"],
            source=self.source,
            planar=self.planar,
            point_platform=point,
            platform_mass=float(platform.get("mass", 0.0)),
            center_of_mass=self.vector(
                "platform.center_of_mass", platform.get("center_of_mass", [0, 0, 0])
            ),
            gravity=self.vector("gravity", content.get("gravity", [0, 0, 0])),
            legs=legs,
            controlled=tuple(content["controlled"]),
            home=self.home(legs),
            text=self.text,
        )
        self.check_controlled(description)
        return description

    def vector(self, field: str, value: list[float]) -> Floats:
        vector = np.array(value, float)
        if self.planar and vector[2] != 0.0:
            raise self.fail(field, f"expected z = 0 in a planar robot, got {value}")
        return vector

    def axis(self, field: str, value: list[float]) -> Floats:
        vector = np.array(value, float)
        norm = float(np.linalg.norm(vector))
        if norm < 1e-9:
            raise self.fail(field, f"expected a direction, got {value} of length zero")
        return vector / norm

    def leg(self, index: int) -> LegDescription:
        field = f"legs[{index}]"
        leg = self.content["legs"][index]
        motor = self.motor(f"{field}.motor", leg["motor"])
        motor_name = leg["motor"].get("name", f"motor{index + 1}") if motor.actuated else None
        return LegDescription(
            name=leg.get("name", f"leg{index + 1}"),
            motor_name=motor_name,
            rod=self.rod(),
            modes=self.modes(),
            base_position=self.vector(f"{field}.base.position", leg["base"]["position"]),
            base_rotation=self.base_rotation(f"{field}.base", leg["base"], motor),
            motor=motor,
            joint=self.joint(f"{field}.tip", leg["tip"]),
        )

    def rod(self) -> Rod:
        rod = self.content["rod"]
        return Rod(
            length=float(rod["length"]),
            section=CircularSection(float(rod["section"]["radius"])),
            young_modulus=float(rod["young_modulus"]),
            shear_modulus=float(rod["shear_modulus"]),
            density=float(rod.get("density", 0.0)),
        )

    def modes(self) -> StrainModes:
        strain = self.content.get("strain", {})
        default = (0, 0, _DEFAULT_MODES) if self.planar else (0, _DEFAULT_MODES, _DEFAULT_MODES)
        counts = tuple(
            strain.get(name, number) for name, number in zip(_DIRECTIONS, default, strict=True)
        )
        if self.planar and (counts[0] or counts[1]):
            raise self.fail("strain", "a planar robot bends about d3 only: expected bending_3")
        if not any(counts):
            raise self.fail("strain", "expected at least one mode")
        return StrainModes(counts, STRAIN_BASES[strain.get("basis", "legendre")]())

    def motor(self, field: str, motor: dict[str, Any]) -> motors.Motor:
        axis = self.axis(f"{field}.axis", motor["axis"])
        if self.planar and abs(axis[2]) < 1.0 - 1e-9:
            raise self.fail(f"{field}.axis", f"expected +-z in a planar robot, got {motor['axis']}")
        return motors.Revolute(axis=tuple(axis.tolist()))

    def joint(self, field: str, tip: dict[str, Any]) -> joints.Joint:
        position = tuple(self.vector(f"{field}.position", tip["position"]).tolist())
        if tip["type"] == "revolute" and not self.planar:
            raise self.fail(
                f"{field}.type", "revolute tips need a planar robot; expected spherical"
            )
        return joints.JOINTS[tip["type"]](position=position)

    def base_rotation(self, field: str, base: dict[str, Any], motor: motors.Motor) -> Floats:
        tangent = self.axis(f"{field}.tangent", base["tangent"])
        if self.planar:
            self.vector(f"{field}.tangent", base["tangent"])
            if "normal" in base:
                raise self.fail(f"{field}.normal", "a planar robot has none: d2 is z x tangent")
            normal = np.array([-tangent[1], tangent[0], 0.0])
        elif "normal" in base:
            normal = self.axis(f"{field}.normal", base["normal"])
            if abs(normal @ tangent) > 1e-6:
                raise self.fail(
                    f"{field}.normal",
                    f"expected a direction across the tangent, got {base['normal']}",
                )
        else:
            axis = motor.turn_axis(np.eye(3)) or motor.shift_axis or (0.0, 0.0, 0.0)
            normal = np.array(axis)
            if np.linalg.norm(normal) < 0.5 or abs(normal @ tangent) > 1e-6:
                normal = np.linalg.svd(tangent[None, :])[2][1]
        normal = normal - (normal @ tangent) * tangent
        normal /= np.linalg.norm(normal)
        return np.column_stack([tangent, normal, np.cross(tangent, normal)])

    def home(self, legs: tuple[LegDescription, ...]) -> HomeGuess:
        home = self.content["home"]
        motor_count = sum(leg.motor_name is not None for leg in legs)
        if len(home["motors"]) != motor_count:
            raise self.fail(
                "home.motors",
                f"expected {motor_count} numbers, one per motor, got {len(home['motors'])}",
            )
        if len(home["strain"]) != len(legs):
            raise self.fail(
                "home.strain",
                f"expected {len(legs)} entries, one per leg, got {len(home['strain'])}",
            )
        quaternion = home["platform"].get("quaternion_wxyz", [1.0, 0.0, 0.0, 0.0])
        try:
            rotation = rotation_from_quaternion(quaternion)
        except CprError as error:
            raise self.fail("home.platform.quaternion_wxyz", str(error)) from None
        return HomeGuess(
            motors=np.array(home["motors"], float),
            platform_position=self.vector("home.platform.position", home["platform"]["position"]),
            platform_rotation=rotation,
            strain=tuple(
                (
                    np.array(leg.get("torsion", []), float),
                    np.array(leg.get("bending_2", []), float),
                    np.array(leg.get("bending_3", []), float),
                )
                for leg in home["strain"]
            ),
        )

    def check_controlled(self, description: RobotDescription) -> None:
        controlled = description.controlled
        allowed = ["x", "y"] if self.planar else ["x", "y", "z", "orientation"]
        if self.planar and not description.point_platform:
            allowed.append("angle")
        for name in controlled:
            if name not in allowed:
                raise self.fail(
                    "controlled", f"expected some of {', '.join(allowed)}, got {name!r}"
                )
        count = sum(CONTROLLED_COORDINATES[name] for name in controlled)
        expected = len(description.motor_names)
        if count != expected:
            raise self.fail(
                "controlled",
                f"expected {expected} coordinates, as many as motors, got {count} "
                f"({', '.join(controlled)}; orientation counts for three)",
            )
