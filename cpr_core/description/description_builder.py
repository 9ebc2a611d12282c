# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""From the content of a description file to values; checks what a schema cannot."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import CprError, DescriptionError
from ..lie import rotation_exp, rotation_from_quaternion
from ..rods.rod import UNIFORM, Profile, Rod, StrainModes
from ..rods.sections import SECTIONS
from ..rods.strain_basis import STRAIN_BASES, BSplines, StrainBasis
from . import joints, motors
from .loads import DistributedForce, Loads, PointForce
from .robot_description import CONTROLLED_COORDINATES, HomeGuess, LegDescription, RobotDescription

__all__ = ["DescriptionBuilder"]

Floats = NDArray[np.float64]

_DIRECTIONS = ("torsion", "bending_2", "bending_3")
_DEFAULT_MODES = 5


class DescriptionBuilder:
    """Turns checked content into values; checks what a schema cannot."""

    def __init__(self, source: str, content: dict[str, Any], text: str) -> None:
        self.source = source
        self.content = content
        self.text = text
        self.planar = content["space"] == "planar"

    def fail(self, field: str, problem: str) -> DescriptionError:
        """The error of a field; to be raised."""
        return DescriptionError(self.source, field, problem)

    def robot(self) -> RobotDescription:
        """The whole robot."""
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
        """Loads that always act."""
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
        """Stations along a rod, from 0 to 1."""
        stations = np.array(at, float)
        if stations[0] != 0.0 or stations[-1] != 1.0 or np.any(np.diff(stations) <= 0.0):
            raise self.fail(where, f"expected increasing numbers from 0 to 1, got {at}")
        return stations

    def vector(self, field: str, value: list[float]) -> Floats:
        """A vector; in the plane one without z."""
        vector = np.array(value, float)
        if self.planar and vector[2] != 0.0:
            raise self.fail(field, f"expected z = 0 in a planar robot, got {value}")
        return vector

    def axis(self, field: str, value: list[float]) -> Floats:
        """A unit vector."""
        vector = np.array(value, float)
        largest = float(np.abs(vector).max())
        if largest < 1e-9:
            raise self.fail(field, f"expected a direction, got {value} of length zero")
        vector = vector / largest  # its square is finite now
        return vector / np.linalg.norm(vector)

    def leg(self, index: int) -> LegDescription:
        """One leg."""
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
        """A rod, of all legs or of one."""
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
            yield_strain=float(rod.get("yield_strain", np.inf)),
        )
        if "yield_strain" in rod and made.section.bending_strain(np.ones(1), np.ones(1))[0] == 0.0:
            raise self.fail(
                f"{where}.section", "missing field 'outer_radius': it has a yield_strain"
            )
        if not _can_be_computed(made):
            raise self.fail(
                where, "expected sizes and moduli of a rod: its stiffness is beyond all numbers"
            )
        return made

    def profile(self, where: str, profile: dict[str, Any]) -> Profile:
        """How a rod varies along its length."""
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
        """The strain modes."""
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
        """Their shape functions."""
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
        """What holds the base."""
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
        """What the motor can do."""
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
        """What holds the tip."""
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
        """Tip frame of a clamped rod in the platform frame, (3, 3)."""
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
        """A unit vector across the tangent."""
        normal = self.axis(where, value)
        if abs(normal @ tangent) > 1e-6:
            raise self.fail(where, f"expected a direction across the tangent, got {value}")
        return normal

    def base_rotation(
        self, field: str, base: dict[str, Any], motor: motors.Motor, free_tip: bool
    ) -> Floats:
        """Base frame in the world, motor at zero, (3, 3)."""
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
        """The rough home."""
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
        if not {"bow", "platform", "strain"} & set(home):
            raise self.fail("home", "expected bow (the side of every rod) or a rough platform pose")
        strain = home.get("strain")
        if strain is not None and len(strain) != len(legs):
            raise self.fail(
                "home.strain", f"expected {len(legs)} entries, one per leg, got {len(strain)}"
            )
        for index, series in enumerate(strain or []):
            if self.planar and ("torsion" in series or "bending_2" in series):
                raise self.fail(
                    f"home.strain[{index}]",
                    "a planar robot bends about d3 only: expected bending_3",
                )
        platform = home.get("platform", {})
        quaternion = platform.get("quaternion_wxyz", [1.0, 0.0, 0.0, 0.0])
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
        motors = np.array(home["motors"], float)
        return HomeGuess(
            motors=motors,
            platform_position=self.vector("home.platform.position", platform["position"])
            if platform
            else None,
            platform_rotation=rotation,
            strain=None if strain is None else tuple(_series(leg) for leg in strain),
            bow=self.bow(home.get("bow", [None] * len(legs)), legs, motors),
        )

    def bow(
        self, given: Any, legs: tuple[LegDescription, ...], motors: Floats
    ) -> tuple[Floats | None, ...]:
        """Sides to which the rods bow, in the world."""
        every = [given] * len(legs) if isinstance(given, str) else given
        if len(every) != len(legs):
            raise self.fail("home.bow", f"expected {len(legs)} sides, got {len(every)}")
        middle = np.mean([leg.base_position for leg in legs], axis=0)
        positions = iter(motors)
        found: list[Floats | None] = []
        for index, (side, leg) in enumerate(zip(every, legs, strict=True)):
            field = f"home.bow[{index}]"
            tangent, left = leg.base_rotation[:, 0], leg.base_rotation[:, 1]
            if leg.motor_name is not None:
                position = next(positions)
                axis = leg.motor.turn_axis(leg.base_rotation)
                if axis is not None and leg.motor.actuated == "turn":
                    turn = rotation_exp(np.array(axis) * position)
                    tangent, left = turn @ tangent, turn @ left
            if side is None:
                found.append(None)
                continue
            if side in ("left", "right"):
                if not self.planar:
                    raise self.fail(field, f"expected outward, inward or a vector, got {side!r}")
                vector = left if side == "left" else -left
            elif side in ("outward", "inward"):
                vector = leg.base_position - middle
                vector = vector if side == "outward" else -vector
            else:
                vector = self.vector(field, side)
            across = vector - (vector @ tangent) * tangent
            if np.linalg.norm(across) < 1e-6 * max(1.0, float(np.linalg.norm(vector))):
                raise self.fail(field, "expected a side across the tangent of the rod at its base")
            found.append(across / np.linalg.norm(across))
        return tuple(found)

    def check_controlled(self, description: RobotDescription) -> None:
        """Whether the inverse problem is a square one."""
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
