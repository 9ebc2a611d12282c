# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""A robot in Exudyn: rods, rigid pieces and a platform, held as tightly as one likes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import exudyn
import numpy as np
from exudyn import itemInterface as items  # noqa: N813
from numpy.typing import NDArray

from cpr_core.description.chain import Link
from cpr_core.description.joints import Fixed

from .exudyn_rods import AddedRod, RodKind, coordinates_of, quaternion
from .placed_robot import Frame, PlacedLeg, PlacedRobot, tip_frame

__all__ = ["ExudynRobot", "NotSettled", "Shape"]

Floats = NDArray[np.float64]

#: Stiffness of the tip joints [N/m] and [N m/rad]: they give way as rods stretch, and go with that.
JOINT, JOINT_TURN = 1e8, 1e6


class NotSettled(Exception):
    """Exudyn's static solver gave up."""


@dataclass(frozen=True, eq=False)
class Shape:
    """Where a robot is.

    Attributes:
        rods: Nodes of every rod of every leg, (elements + 1, c) each.
        links: Frames of the rigid pieces, by leg and rod they are in front of; -1: behind the last.
        platform: The platform.
    """

    rods: tuple[tuple[Floats, ...], ...]
    links: dict[tuple[int, int], Frame]
    platform: Frame


class ExudynRobot:
    """One system of Exudyn.

    Args:
        robot: What is to be built.
        kind: Of what elements.
        elements: Of every rod.
        factor: On what resists stretch and shear, and on the tip joints.
        shape: Where it starts; default: legs straight, tips held where they then are.
    """

    def __init__(
        self,
        robot: PlacedRobot,
        kind: RodKind,
        elements: int,
        factor: float,
        shape: Shape | None = None,
    ) -> None:
        exudyn.config.printToConsole = False  # a step that is too long is no news
        self.robot, self.kind, self.factor, self.elements = robot, kind, factor, elements
        self.container = exudyn.SystemContainer()
        self.system = self.container.AddSystem()
        self.ground = self.system.AddObject(items.ObjectGround())
        self.start = robot.platform if shape is None else shape.platform
        self.gravity = np.array(robot.description.gravity)
        self.platform, self.node = self._body(self.start)
        self._weight(
            self.platform, robot.description.platform_mass, robot.description.center_of_mass
        )
        self.hold = self._spring(
            self._marker(self.ground, self.start), self._marker(self.platform, None), np.zeros(6)
        )
        self.rods: list[tuple[AddedRod, ...]] = []
        self.links: dict[tuple[int, int], int] = {}
        self.clamps: list[int] = []
        self.tips: list[tuple[int, int]] = []
        for number, leg in enumerate(robot.legs):
            self._add_leg(number, leg, shape)
        self.system.Assemble()
        self.settings = _settings(4e-7 * max(1.0, factor) * max(1.0, elements / 32.0))

    def _add_leg(self, number: int, leg: PlacedLeg, shape: Shape | None) -> None:
        frame, rods = leg.clamp, []
        before = self._marker(self.ground, leg.clamp)
        for place, rod in enumerate(leg.rods):
            if rod.before is not None:
                before, frame = self._add_link((number, place), rod.before, before, frame, shape)
            rest = self.kind.straight(frame, rod.length, self.elements)
            nodes = rest if shape is None else shape.rods[number][place]
            added = self.kind.add(self.system, rod, rest, nodes, self.factor)
            self.kind.weigh(self.system, rod, added, self.gravity)
            joint = self._rigid(before, added.base)
            if place == 0:
                self.clamps.append(joint)
            rods.append(added)
            before = added.tip
            frame = frame @ Frame(np.eye(3), np.array([rod.length, 0.0, 0.0]))
        if leg.end is not None:
            before, frame = self._add_link((number, -1), leg.end, before, frame, shape)
        self.rods.append(tuple(rods))
        held = tip_frame(leg.tip) if shape is not None else self.start.inverse @ frame
        marker = self._marker(self.platform, held)
        clamped = JOINT_TURN if isinstance(leg.tip, Fixed) else 0.0
        stiffness = self.factor * np.array([JOINT] * 3 + [clamped] * 3)
        self.tips.append((marker, self._spring(marker, before, stiffness)))

    def _add_link(
        self, key: tuple[int, int], link: Link, before: int, frame: Frame, shape: Shape | None
    ) -> tuple[int, Frame]:
        """A rigid piece behind a marker; the marker of its end, and where that is at rest."""
        body, node = self._body(frame if shape is None else shape.links[key])
        self._weight(body, link.mass, np.array(link.center_of_mass))
        self._rigid(before, self._marker(body, None))
        self.links[key] = node
        end = Frame(link.rotation, np.array(link.offset))
        return self._marker(body, end), frame @ end

    def _body(self, frame: Frame) -> tuple[int, int]:
        """A rigid body and its node; mass does not matter in statics."""
        if self.kind.planar:
            turn = float(np.arctan2(frame.rotation[1, 0], frame.rotation[0, 0]))
            place = [*frame.position[:2].tolist(), turn]
            node = self.system.AddNode(items.NodeRigidBody2D(referenceCoordinates=place))
            body = items.ObjectRigidBody2D(mass=1.0, inertia=1.0, nodeNumber=node)
        else:
            place = [*frame.position.tolist(), *quaternion(frame.rotation).tolist()]
            node = self.system.AddNode(items.NodeRigidBodyEP(referenceCoordinates=place))
            inertia = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0]
            body = items.ObjectRigidBody(mass=1.0, inertia=inertia, nodeNumber=node)
        return int(self.system.AddObject(body)), int(node)

    def _weight(self, body: int, mass: float, center: Floats) -> None:
        if mass * np.any(self.gravity):
            at = Frame(np.eye(3), np.array(center))
            force = (mass * self.gravity).tolist()
            marker = self._marker(body, at)
            self.system.AddLoad(items.Force(markerNumber=marker, loadVector=force))

    def _marker(self, body: int, frame: Frame | None) -> int:
        """A frame on a body; None: that of the body."""
        frame = Frame(np.eye(3), np.zeros(3)) if frame is None else frame
        marker = items.MarkerBodyRigid(bodyNumber=body, localHT=_homogeneous(frame))
        return int(self.system.AddMarker(marker))

    def _rigid(self, first: int, second: int) -> int:
        """Two frames made one."""
        axes = [1, 1, 0, 0, 0, 1] if self.kind.planar else [1] * 6
        joint = items.ObjectJointGeneric(markerNumbers=[first, second], constrainedAxes=axes)
        return int(self.system.AddObject(joint))

    def _spring(self, first: int, second: int, stiffness: Floats) -> int:
        """Springs between two frames, (6,) [N/m], [N m/rad].

        Joints of the platform are springs, not constraints: Exudyn's tangent seems to lack how the
        forces of constraints turn with a body: with them Newton's method does not converge where the
        platform is soft.
        """
        spring = items.ObjectConnectorRigidBodySpringDamper(
            markerNumbers=[first, second], stiffness=np.diag(stiffness)
        )
        return int(self.system.AddObject(spring))

    def move_tip(self, leg: int, held: Frame) -> None:
        """Where the platform holds the tip of a leg, in the platform."""
        self.system.SetMarkerParameter(self.tips[leg][0], "localHT", _homogeneous(held))

    def hold_platform(self, stiffness: float) -> None:
        """Springs that pull the platform to where it started [N/m]; a point never turns."""
        turn = stiffness * self.robot.legs[0].reach ** 2
        if self.robot.description.point_platform:
            turn = 1.0
        values = np.diag([stiffness] * 3 + [turn] * 3)
        self.system.SetObjectParameter(self.hold, "stiffness", values)

    def settle(self) -> None:
        """Static equilibrium from where the robot is.

        Raises:
            NotSettled: Exudyn's Newton iteration does not converge.
        """
        try:
            self.system.SolveStatic(self.settings, updateInitialValues=True)
        except exudyn.SolverError as error:
            raise NotSettled(str(error)) from error

    @property
    def platform_frame(self) -> Frame:
        """Where the platform is."""
        return self._frame(self.node)

    @property
    def shape(self) -> Shape:
        """Where all of it is."""
        rods = tuple(
            tuple(coordinates_of(self.system, rod.nodes) for rod in leg) for leg in self.rods
        )
        links = {key: self._frame(node) for key, node in self.links.items()}
        return Shape(rods, links, self.platform_frame)

    def clamp_wrench(self, leg: int) -> tuple[Floats, Floats]:
        """Moment [N m] and force [N] on a leg at its clamp, in the world, (3,) each."""
        output, clamp = exudyn.OutputVariableType, self.clamps[leg]
        # Force on the second body, torque on the first: seen on a cantilever.
        rotation = self.robot.legs[leg].clamp.rotation
        moment = -rotation @ np.array(self.system.GetObjectOutput(clamp, output.TorqueLocal))
        force = rotation @ np.array(self.system.GetObjectOutput(clamp, output.ForceLocal))
        return moment, force

    def _frame(self, node: int) -> Frame:
        output = exudyn.OutputVariableType
        turn = np.array(self.system.GetNodeOutput(node, output.RotationMatrix)).reshape(3, 3)
        return Frame(turn, np.array(self.system.GetNodeOutput(node, output.Position)))


def _homogeneous(frame: Frame) -> Any:
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = frame.rotation, frame.position
    return matrix


def _settings(tolerance: float) -> Any:
    """Solver settings; the tolerance [N] is above what rounding leaves of stiff rods in short pieces."""
    settings = exudyn.SimulationSettings()
    solver = settings.staticSolver
    solver.numberOfLoadSteps, solver.useLoadFactor, solver.adaptiveStep = 1, False, False
    solver.newton.relativeTolerance, solver.newton.absoluteTolerance = 1e-10, tolerance
    solver.newton.maxIterations, solver.verboseMode = 60, 0
    settings.linearSolver.solverType = exudyn.LinearSolverType.EigenSparse
    settings.solution.file.write = False
    return settings
