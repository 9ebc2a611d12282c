"""Robot descriptions: YAML in, validated immutable values out."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from importlib import resources
from numbers import Real
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import yaml
from numpy.typing import NDArray

from . import joints, motors
from .errors import CprError, DescriptionError, InvalidRequest
from .lie import rotation_from_quaternion
from .loads import DistributedForce, Loads, PointForce
from .rod import UNIFORM, Profile, Rod, StrainModes
from .sections import SECTIONS
from .strain_basis import STRAIN_BASES, BSplines, StrainBasis

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
CONTROLLED_COORDINATES = {
    "x": 1,
    "y": 1,
    "z": 1,
    "angle": 1,
    "orientation": 3,
    "roll": 1,
    "pitch": 1,
    "yaw": 1,
}
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
        limits: What the motor can do.
    """

    name: str
    motor_name: str | None
    rod: Rod
    modes: StrainModes
    base_position: Floats
    base_rotation: Floats
    motor: motors.Motor
    joint: joints.Joint
    limits: motors.MotorLimits = field(default_factory=motors.MotorLimits)


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
        legs: The legs.
        controlled: Platform coordinates of the inverse problem, in order; none if there are more
            motors than platform coordinates.
        home: Rough home equilibrium.
        loads: Loads that always act, gravity included.
        stations: s/l where point forces may act, on every leg.
        text: The description as it was read.
    """

    name: str
    source: str
    planar: bool
    point_platform: bool
    platform_mass: float
    center_of_mass: Floats
    legs: tuple[LegDescription, ...]
    controlled: tuple[str, ...]
    home: HomeGuess
    loads: Loads = field(default_factory=Loads.none)
    stations: tuple[float, ...] = ()
    text: str = ""

    @property
    def platform_freedom(self) -> int:
        """Number of platform coordinates."""
        if self.planar:
            return 2 if self.point_platform else 3
        return 6

    @property
    def gravity(self) -> Floats:
        """Gravity in the world, (3,) [m/s^2]."""
        return self.loads.gravity

    @property
    def motor_names(self) -> tuple[str, ...]:
        """Names of the motors in order."""
        return tuple(leg.motor_name for leg in self.legs if leg.motor_name is not None)

    def with_modes(self, modes: int) -> RobotDescription:
        """The same robot with another number of modes in every direction that has any."""
        if modes < 1:
            raise InvalidRequest("modes", f"expected at least 1, got {modes}")
        if any(isinstance(leg.modes.basis, BSplines) for leg in self.legs):
            raise InvalidRequest(
                "modes", "B-splines have as many modes as degree and knots say: change those"
            )

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
        except (yaml.YAMLError, TypeError, ValueError, RecursionError) as error:
            raise DescriptionError(source, "", f"is not valid YAML: {error}") from None
    try:
        _check_schema(source, content)
    except RecursionError:
        raise DescriptionError(source, "", "is nested too deeply, or refers to itself") from None
    return _Builder(source, content, text).robot()


def _find(robot: str | Path) -> Path:
    """Path of a shipped robot or of a file."""
    shipped = shipped_robots()
    if str(robot) in shipped:
        return shipped[str(robot)]
    path = Path(robot)
    try:
        found, folder = path.is_file(), path.is_dir()
    except (OSError, ValueError):  # not even a possible name
        found, folder = False, False
    if not found:
        raise DescriptionError(
            str(robot),
            "",
            f"no such file{' (it is a folder)' if folder else ''}, nor a shipped robot "
            f"(shipped: {', '.join(shipped) or 'none'})",
        )
    return path


class _Loader(yaml.SafeLoader):
    """YAML as people write it: numbers as in YAML 1.2, every field once.

    YAML 1.1 reads 2.1e11 as a word, 010 as eight and 1:30 as ninety.
    """

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
        try:
            finite = math.isfinite(number)
        except OverflowError:  # a whole number beyond all floats
            finite = False
        if not finite:
            raise DescriptionError(source, path, f"expected a finite number, got {number!s:.40}")
    errors = list(_validator().iter_errors(content))
    # A misspelt field is also a missing one: say the misspelt name.
    unknown = [error for error in errors if error.validator == "additionalProperties"]
    error = jsonschema.exceptions.best_match(unknown or errors)
    if error is None:
        return
    path = ""
    for part in error.absolute_path:
        path += f"[{part}]" if isinstance(part, int) else ("." if path else "") + str(part)
    raise DescriptionError(source, path, _explain(error))


def _numbers(value: Any, path: str) -> Iterator[tuple[str, Any]]:
    if isinstance(value, dict):
        for key, item in value.items():
            yield from _numbers(item, f"{path}.{key}" if path else str(key))
    elif isinstance(value, list):
        for index, item in enumerate(value):
            yield from _numbers(item, f"{path}[{index}]")
    elif isinstance(value, Real) and not isinstance(value, bool):
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
        gravity = self.vector("gravity", content.get("gravity", [0, 0, 0]))
        description = RobotDescription(
            name=content["name"],
            source=self.source,
            planar=self.planar,
            point_platform=point,
            platform_mass=float(platform.get("mass", 0.0)),
            center_of_mass=self.vector(
                "platform.center_of_mass", platform.get("center_of_mass", [0, 0, 0])
            ),
            legs=legs,
            controlled=tuple(content["controlled"]),
            home=self.home(legs),
            loads=self.loads(legs, gravity),
            stations=tuple(content.get("stations", ())),
            text=self.text,
        )
        self.check_controlled(description)
        return description

    def loads(self, legs: tuple[LegDescription, ...], gravity: Floats) -> Loads:
        content = self.content.get("loads", {})
        names = [leg.name for leg in legs]

        def leg(where: str, name: str) -> str:
            if name not in names:
                raise self.fail(f"{where}.leg", f"expected one of {', '.join(names)}, got {name!r}")
            return name

        distributed, points = [], []
        for index, force in enumerate(content.get("distributed", [])):
            where = f"loads.distributed[{index}]"
            at = self.stations(f"{where}.at", force["at"])
            if len(force["force"]) != len(at):
                raise self.fail(
                    f"{where}.force", f"expected {len(at)} vectors, got {len(force['force'])}"
                )
            vectors = [
                self.vector(f"{where}.force[{row}]", vector)
                for row, vector in enumerate(force["force"])
            ]
            distributed.append(DistributedForce(leg(where, force["leg"]), at, np.array(vectors)))
        for index, force in enumerate(content.get("points", [])):
            where = f"loads.points[{index}]"
            vector = self.vector(f"{where}.force", force["force"])
            points.append(PointForce(leg(where, force["leg"]), float(force["at"]), vector))
        platform = self.vector("loads.platform_force", content.get("platform_force", [0, 0, 0]))
        return Loads.none().with_(
            gravity=gravity,
            rod_force=self.vector("loads.rod_force", content.get("rod_force", [0, 0, 0])),
            wrench_world=[0.0, 0.0, 0.0, *platform],
            distributed=distributed,
            points=points,
        )

    def stations(self, where: str, at: list[float]) -> Floats:
        stations = np.array(at, float)
        if stations[0] != 0.0 or stations[-1] != 1.0 or np.any(np.diff(stations) <= 0.0):
            raise self.fail(where, f"expected increasing numbers from 0 to 1, got {at}")
        return stations

    def vector(self, field: str, value: list[float]) -> Floats:
        vector = np.array(value, float)
        if self.planar and vector[2] != 0.0:
            raise self.fail(field, f"expected z = 0 in a planar robot, got {value}")
        return vector

    def axis(self, field: str, value: list[float]) -> Floats:
        vector = np.array(value, float)
        largest = float(np.abs(vector).max())
        if largest < 1e-9:
            raise self.fail(field, f"expected a direction, got {value} of length zero")
        vector = vector / largest  # its square is finite now
        return vector / np.linalg.norm(vector)

    def leg(self, index: int) -> LegDescription:
        field = f"legs[{index}]"
        leg = self.content["legs"][index]
        motor = self.motor(f"{field}.motor", leg["motor"])
        motor_name = leg["motor"].get("name", f"motor{index + 1}") if motor.actuated else None
        rod = self.rod(field if "rod" in leg else "", leg.get("rod", self.content["rod"]))
        if motor.extensible and not rod.uniform:
            raise self.fail(
                f"{field}.motor.type",
                "an extensible leg needs a uniform rod (profile, rest_curvature)",
            )
        if leg["motor"].get("spin") and leg["tip"]["type"] == "spherical":
            raise self.fail(
                f"{field}.motor.spin", "nothing would hold the rod against turning about itself"
            )
        strain = leg.get("strain", self.content.get("strain", {}))
        return LegDescription(
            name=leg.get("name", f"leg{index + 1}"),
            motor_name=motor_name,
            rod=rod,
            modes=self.modes(f"{field}.strain" if "strain" in leg else "strain", strain),
            base_position=self.vector(f"{field}.base.position", leg["base"]["position"]),
            base_rotation=self.base_rotation(
                f"{field}.base", leg["base"], motor, leg["tip"]["type"] == "spherical"
            ),
            motor=motor,
            joint=self.joint(f"{field}.tip", leg["tip"]),
            limits=self.limits(f"{field}.motor.limits", leg["motor"].get("limits", {}), motor),
        )

    def rod(self, leg: str, rod: dict[str, Any]) -> Rod:
        where = f"{leg}.rod" if leg else "rod"
        shape = {key: value for key, value in rod["section"].items() if key != "shape"}
        if "inner_radius" in shape and shape["inner_radius"] >= shape["radius"]:
            raise self.fail(
                f"{where}.section.inner_radius",
                f"expected less than the radius {shape['radius']}, got {shape['inner_radius']}",
            )
        if rod["section"]["shape"] != "given":
            for modulus in ("young_modulus", "shear_modulus"):
                if modulus not in rod:
                    raise self.fail(where, f"missing field {modulus!r}")
        rest = rod.get("rest_curvature", {})
        if self.planar and (rest.get("torsion") or rest.get("bending_2")):
            raise self.fail(f"{where}.rest_curvature", "a planar rod is curved about d3 only")
        made = Rod(
            length=float(rod["length"]),
            section=SECTIONS[rod["section"]["shape"]](**shape),
            young_modulus=float(rod.get("young_modulus", 0.0)),
            shear_modulus=float(rod.get("shear_modulus", 0.0)),
            density=float(rod.get("density", 0.0)),
            profile=self.profile(f"{where}.profile", rod["profile"])
            if "profile" in rod
            else UNIFORM,
            rest_curvature=_series(rest),
        )
        if not _can_be_computed(made):
            raise self.fail(
                where, "expected sizes and moduli of a rod: its stiffness is beyond all numbers"
            )
        return made

    def profile(self, where: str, profile: dict[str, Any]) -> Profile:
        at = self.stations(f"{where}.at", profile["at"])
        factors = []
        for name in ("stiffness", "mass"):
            given = profile.get(name, [1.0] * len(at))
            if len(given) != len(at):
                raise self.fail(
                    f"{where}.{name}",
                    f"expected {len(at)} numbers, one per station, got {len(given)}",
                )
            factors.append(np.array(given, float))
        return Profile(at, *factors)

    def modes(self, where: str, strain: dict[str, Any]) -> StrainModes:
        basis = self.basis(where, strain)
        splines = isinstance(basis, BSplines)
        default = basis.modes if isinstance(basis, BSplines) else _DEFAULT_MODES
        torsion, bending_2, bending_3 = (
            strain.get(
                name, 0 if name == "torsion" or (self.planar and name == "bending_2") else default
            )
            for name in _DIRECTIONS
        )
        counts = (int(torsion), int(bending_2), int(bending_3))  # 5.0 is a whole number in JSON
        if self.planar and (torsion or bending_2):
            raise self.fail(where, "a planar robot bends about d3 only: expected bending_3")
        if not any(counts):
            raise self.fail(where, "expected at least one mode")
        if splines and any(count not in (0, default) for count in counts):
            raise self.fail(
                where,
                f"expected {default} or 0 modes with this degree and these knots, got {counts}",
            )
        return StrainModes(counts, basis)

    def basis(self, where: str, strain: dict[str, Any]) -> StrainBasis:
        name = strain.get("basis", "legendre")
        if name != "bsplines":
            for field_name in ("degree", "knots"):
                if field_name in strain:
                    raise self.fail(f"{where}.{field_name}", "goes with basis bsplines only")
            return STRAIN_BASES[name]()
        knots = tuple(float(knot) for knot in strain.get("knots", [0.5]))
        if list(knots) != sorted(set(knots)):
            raise self.fail(f"{where}.knots", f"expected increasing numbers, got {list(knots)}")
        return BSplines(degree=int(strain.get("degree", 3)), knots=knots)

    def motor(self, where: str, motor: dict[str, Any]) -> motors.Motor:
        kind = motors.MOTORS[motor["type"]]
        if "axis" not in motor:
            return kind(**{key: motor[key] for key in ("spin",) if key in motor})
        axis = self.axis(f"{where}.axis", motor["axis"])
        if self.planar:
            if kind is motors.Prismatic:
                self.vector(f"{where}.axis", motor["axis"])
            elif abs(axis[2]) < 1.0 - 1e-9:
                raise self.fail(
                    f"{where}.axis", f"expected +-z in a planar robot, got {motor['axis']}"
                )
        return kind(axis=tuple(axis.tolist()))  # type: ignore[call-arg]

    def limits(self, where: str, limits: dict[str, Any], motor: motors.Motor) -> motors.MotorLimits:
        lower, upper = limits.get("position", (-math.inf, math.inf))
        if lower >= upper:
            raise self.fail(
                f"{where}.position", f"expected lower below upper, got [{lower}, {upper}]"
            )
        if motor.extensible and "position" in limits and lower <= 0.0:
            raise self.fail(f"{where}.position", f"expected a positive length, got {lower}")
        return motors.MotorLimits(
            float(lower),
            float(upper),
            float(limits.get("speed", math.inf)),
            float(limits.get("effort", math.inf)),
        )

    def joint(self, where: str, tip: dict[str, Any]) -> joints.Joint:
        position = tuple(self.vector(f"{where}.position", tip["position"]).tolist())
        kind = tip["type"]
        if kind == "universal" and self.planar:
            raise self.fail(f"{where}.type", "universal joints need a spatial robot")
        if kind == "spherical":
            return joints.Spherical(position)
        if kind == "fixed":
            first, second, third = (tuple(row) for row in self.tip_frame(where, tip).tolist())
            return joints.Fixed(position, (first, second, third))
        if self.planar:
            for name in ("axis", "axis_in_rod"):
                if name in tip and abs(self.axis(f"{where}.{name}", tip[name])[2]) < 1.0 - 1e-9:
                    raise self.fail(
                        f"{where}.{name}", f"expected +-z in the plane, got {tip[name]}"
                    )
            return joints.Revolute(position)
        if "axis" not in tip:
            raise self.fail(where, "missing field 'axis'")
        axis = self.axis(f"{where}.axis", tip["axis"])
        in_rod = self.axis(f"{where}.axis_in_rod", tip.get("axis_in_rod", [0, 0, 1]))
        return joints.JOINTS[kind](position, tuple(axis.tolist()), tuple(in_rod.tolist()))  # type: ignore[call-arg]

    def tip_frame(self, where: str, tip: dict[str, Any]) -> Floats:
        tangent = self.axis(f"{where}.tangent", tip["tangent"])
        if self.planar:
            self.vector(f"{where}.tangent", tip["tangent"])
            if "normal" in tip:
                raise self.fail(f"{where}.normal", "a planar robot has none: d2 is z x tangent")
            normal = np.array([-tangent[1], tangent[0], 0.0])
        elif "normal" in tip:
            normal = self.across(f"{where}.normal", tip["normal"], tangent)
        else:
            raise self.fail(where, "missing field 'normal'")
        return _frame(tangent, normal)

    def across(self, where: str, value: list[float], tangent: Floats) -> Floats:
        normal = self.axis(where, value)
        if abs(normal @ tangent) > 1e-6:
            raise self.fail(where, f"expected a direction across the tangent, got {value}")
        return normal

    def base_rotation(
        self, field: str, base: dict[str, Any], motor: motors.Motor, free_tip: bool
    ) -> Floats:
        tangent = self.axis(f"{field}.tangent", base["tangent"])
        if self.planar:
            self.vector(f"{field}.tangent", base["tangent"])
            if "normal" in base:
                raise self.fail(f"{field}.normal", "a planar robot has none: d2 is z x tangent")
            normal = np.array([-tangent[1], tangent[0], 0.0])
        elif "normal" in base:
            normal = self.across(f"{field}.normal", base["normal"], tangent)
        else:
            normal = np.array(getattr(motor, "axis", np.zeros(3)))
            if np.linalg.norm(normal) < 0.5 or abs(normal @ tangent) > 1e-6:
                if not free_tip:
                    raise self.fail(field, "missing field 'normal'")
                normal = np.linalg.svd(tangent[None, :])[2][1]  # any one: no joint asks for it
        return _frame(tangent, normal)

    def home(self, legs: tuple[LegDescription, ...]) -> HomeGuess:
        home = self.content["home"]
        motor_count = sum(leg.motor_name is not None for leg in legs)
        if len(home["motors"]) != motor_count:
            raise self.fail(
                "home.motors",
                f"expected {motor_count} numbers, one per motor, got {len(home['motors'])}",
            )
        for motor, leg in zip(
            home["motors"], [leg for leg in legs if leg.motor_name is not None], strict=True
        ):
            if leg.motor.extensible and motor <= 0.0:
                raise self.fail("home.motors", f"expected positive rod lengths, got {motor}")
        if len(home["strain"]) != len(legs):
            raise self.fail(
                "home.strain",
                f"expected {len(legs)} entries, one per leg, got {len(home['strain'])}",
            )
        for index, strain in enumerate(home["strain"]):
            if self.planar and ("torsion" in strain or "bending_2" in strain):
                raise self.fail(
                    f"home.strain[{index}]",
                    "a planar robot bends about d3 only: expected bending_3",
                )
        quaternion = home["platform"].get("quaternion_wxyz", [1.0, 0.0, 0.0, 0.0])
        try:
            rotation = rotation_from_quaternion(quaternion)
        except CprError as error:
            raise self.fail("home.platform.quaternion_wxyz", str(error)) from None
        if self.planar and rotation[2, 2] < 1.0 - 1e-9:
            raise self.fail(
                "home.platform.quaternion_wxyz", "expected a rotation about z in a planar robot"
            )
        if (
            "shape" in self.content.get("platform", {})
            and self.content["platform"]["shape"] == "point"
        ):
            rotation = np.eye(3)
        return HomeGuess(
            motors=np.array(home["motors"], float),
            platform_position=self.vector("home.platform.position", home["platform"]["position"]),
            platform_rotation=rotation,
            strain=tuple(_series(leg) for leg in home["strain"]),
        )

    def check_controlled(self, description: RobotDescription) -> None:
        controlled = description.controlled
        allowed = ["x", "y"]
        if not self.planar:
            allowed += ["z", "orientation", "roll", "pitch", "yaw"]
        elif not description.point_platform:
            allowed.append("angle")
        for name in controlled:
            if name not in allowed:
                raise self.fail(
                    "controlled", f"expected some of {', '.join(allowed)}, got {name!r}"
                )
        if "orientation" in controlled and {"roll", "pitch", "yaw"} & set(controlled):
            raise self.fail("controlled", "expected either orientation or single angles, got both")
        count = sum(CONTROLLED_COORDINATES[name] for name in controlled)
        motor_count, freedom = len(description.motor_names), description.platform_freedom
        if motor_count > freedom:
            if controlled:
                raise self.fail(
                    "controlled",
                    f"expected none: {motor_count} motors for {freedom} platform coordinates, the "
                    "inverse problem has no single solution",
                )
        elif count != motor_count:
            raise self.fail(
                "controlled",
                f"expected {motor_count} coordinates, as many as motors, got {count} "
                f"({', '.join(controlled)}; orientation counts for three)",
            )


def _can_be_computed(rod: Rod) -> bool:
    """Whether stiffness, its natural units and the weight are numbers a computer can work with."""
    try:
        scales = [
            rigidity * rod.length**power
            for rigidity in rod.rigidities
            for power in (-3, -2, -1, 0, 1)
        ]
        mass = rod.mass_per_length * rod.length
    except OverflowError:
        return False
    return all(1e-100 < scale < 1e100 for scale in scales) and mass < 1e100


def _series(strain: dict[str, list[float]]) -> tuple[Floats, Floats, Floats]:
    """Series of the three strain components."""
    torsion, bending_2, bending_3 = (
        np.array(strain.get(name, []), dtype=float) for name in _DIRECTIONS
    )
    return torsion, bending_2, bending_3


def _frame(tangent: Floats, normal: Floats) -> Floats:
    """Orthonormal frame (d1, d2, d3) from a unit d1 and a direction close to d2."""
    normal = normal - (normal @ tangent) * tangent
    normal = normal / np.linalg.norm(normal)
    return np.column_stack([tangent, normal, np.cross(tangent, normal)])
