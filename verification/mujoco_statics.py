# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Statics with MuJoCo's forces: it integrates in time only, so Newton's method is ours."""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from cpr_core.description.joints import Fixed

from .mujoco_model import xml_of
from .placed_robot import BOW, Frame, PlacedRobot, tip_frame

__all__ = ["LARGEST", "SMALL", "MujocoRobot", "NotBalanced"]

Floats = NDArray[np.float64]

#: Step of the central differences [rad or m].
STEP = 1e-6
#: Largest correction that ends the iteration [rad or m], and steps it may take.
SMALL, MOST = 1e-9, 40
#: Largest correction that is taken whole [rad or m].
LARGEST = 0.3
#: Turn of a leg from base to tip at the start, where the description tells no side [rad].
SLIGHT = 0.3


class NotBalanced(Exception):
    """Newton's method does not converge."""


class MujocoRobot:
    """A robot with so many joints a rod, held where one says.

    Args:
        robot: What is to be built.
        pieces: Joints of every rod.

    Attributes:
        held: Where the platform holds the tips, in the platform.
        forces: On the tips, and moments on clamped ones, in the world.
        stiffness: Of the springs that hold the platform where it was at first [N/m, N m].
    """

    def __init__(self, robot: PlacedRobot, pieces: int) -> None:
        self.robot, self.pieces = robot, pieces
        self.model = mujoco.MjModel.from_xml_string(xml_of(robot, pieces))
        self.data = mujoco.MjData(self.model)
        self.start = self.data.qpos.copy()
        self.clamps = np.array([self._clamp(number) for number in range(len(robot.legs))])
        self.sites = [self.model.site(f"tip{number}").id for number in range(len(robot.legs))]
        self.body = self.model.body("platform").id
        self.free = np.setdiff1d(np.arange(self.model.nv), self.clamps)
        self.platform_dofs = np.arange(self.model.nv)[-self.model.body("platform").dofnum[0] :]
        self.clamped = [isinstance(leg.tip, Fixed) for leg in robot.legs]
        self.held = [tip_frame(leg.tip) for leg in robot.legs]
        self.stiffness = 0.0
        self.forces = np.zeros(3 * (len(robot.legs) + sum(self.clamped)))

    def _clamp(self, number: int) -> list[int]:
        """Numbers of the motions of a clamp: along its axes, about them."""
        first, turn = (self.model.joint(f"{name}{number}").dofadr[0] for name in ("x", "turn"))
        return [first, first + 1, first + 2, turn, turn + 1, turn + 2]

    def _evaluate(self, position: Floats) -> tuple[Floats, Floats, Floats]:
        """Generalised forces (nv,), gaps (g,), and their derivative (g, nv), exact where they vanish."""
        model, data = self.model, self.data
        data.qpos[:] = position
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        forces = data.qfrc_passive - data.qfrc_bias
        if self.stiffness:
            away = np.zeros(model.nv)
            mujoco.mj_differentiatePos(model, away, 1.0, self.start, position)
            forces[self.platform_dofs] -= self.stiffness * away[self.platform_dofs]
        platform = self._platform()
        gaps, rows = [], []
        of_tip, of_platform = np.zeros((6, model.nv)), np.zeros((6, model.nv))
        for site, held, clamped in zip(self.sites, self.held, self.clamped, strict=True):
            tip, target = self._tip(site), platform @ held
            mujoco.mj_jacSite(model, data, of_tip[:3], of_tip[3:], site)
            mujoco.mj_jac(model, data, of_platform[:3], of_platform[3:], target.position, self.body)
            count = 6 if clamped else 3
            turn = Rotation.from_matrix(tip.rotation @ target.rotation.T).as_rotvec()
            gaps.append(np.concatenate([tip.position - target.position, turn])[:count])
            rows.append((of_tip - of_platform)[:count])
        return forces, np.concatenate(gaps), np.vstack(rows)

    def _platform(self) -> Frame:
        rotation = self.data.xmat[self.body].reshape(3, 3).copy()
        return Frame(rotation, self.data.xpos[self.body].copy())

    def _tip(self, site: int) -> Frame:
        rotation = self.data.site_xmat[site].reshape(3, 3).copy()
        return Frame(rotation, self.data.site_xpos[site].copy())

    def _residual(self, position: Floats) -> tuple[Floats, Floats]:
        forces, gaps, rows = self._evaluate(position)
        return np.concatenate([(forces + rows.T @ self.forces)[self.free], gaps]), rows

    def linearised(self, position: Floats) -> tuple[Floats, Floats]:
        """Free forces and gaps (r,), and their derivative by free motions and forces (r, r)."""
        residual, rows = self._residual(position)
        size = len(self.free)
        tangent = np.zeros((len(residual), len(residual)))
        for column in range(size):
            change = STEP * np.eye(1, size, column)[0]
            ahead, _ = self._residual(self.moved(position, change))
            behind, _ = self._residual(self.moved(position, -change))
            tangent[:, column] = (ahead - behind) / (2.0 * STEP)
        tangent[:size, size:] = rows[:, self.free].T
        return residual, tangent

    def moved(self, position: Floats, change: Floats) -> Floats:
        """A position after free motions, (f,)."""
        found, motion = position.copy(), np.zeros(self.model.nv)
        motion[self.free] = change
        mujoco.mj_integratePos(self.model, found, motion, 1.0)
        return found

    def balance(self, position: Floats) -> Floats:
        """Where forces and gaps vanish, from a position on, by Newton's method.

        Raises:
            NotBalanced: Not within a few steps.
        """
        size = len(self.free)
        for _ in range(MOST):
            residual, tangent = self.linearised(position)
            step = -np.linalg.solve(tangent, residual)
            largest = np.abs(step[:size]).max()
            if not np.isfinite(largest):
                break
            part = min(1.0, LARGEST / largest)
            position = self.moved(position, part * step[:size])
            self.forces = self.forces + part * step[size:]
            if largest < SMALL:
                return position
        raise NotBalanced(f"MuJoCo, {self.pieces} joints a rod")

    def efforts(self, position: Floats) -> Floats:
        """What the motors have to do, (legs,) [N m or N]."""
        forces, _, rows = self._evaluate(position)
        wrenches = -(forces + rows.T @ self.forces)[self.clamps]
        gravity = self.robot.description.gravity
        return np.array(
            [
                leg.effort(leg.clamp.rotation @ moment, leg.clamp.rotation @ force, gravity)
                for leg, force, moment in zip(
                    self.robot.legs, wrenches[:, :3], wrenches[:, 3:], strict=True
                )
            ]
        )

    def platform(self, position: Floats) -> Frame:
        """Where the platform is."""
        self._evaluate(position)
        return self._platform()

    def tips(self, position: Floats) -> list[Frame]:
        """Where the tips are, in the platform."""
        self._evaluate(position)
        inside = self._platform().inverse
        return [inside @ self._tip(site) for site in self.sites]

    def bent(self) -> Floats:
        """The start with every leg bent evenly to its side: a straight one cannot give way."""
        found = self.start.copy()
        for number, leg in enumerate(self.robot.legs):
            side, turn = (leg.bow, BOW) if leg.bow is not None else (self._side(number), SLIGHT)
            axis = leg.clamp.rotation.T @ np.cross(side, leg.clamp.rotation[:, 0])
            bend = turn / (self.pieces * len(leg.rods)) * axis / np.linalg.norm(axis)
            for rod in range(len(leg.rods)):
                for piece in range(1, self.pieces + 1):
                    at = self._joint(number, rod, piece)
                    found[at : at + 4] = Rotation.from_rotvec(bend).as_quat()[[3, 0, 1, 2]]
        return found

    def _side(self, number: int) -> Floats:
        """Where the middle of a leg stands out if its tip goes to its joint, or any side."""
        leg = self.robot.legs[number]
        joint = self.robot.platform @ tip_frame(leg.tip)
        across = leg.clamp.rotation[:, 1:]
        away = across.T @ (leg.clamp.position - joint.position)
        return across @ (away if np.linalg.norm(away) > 1e-3 * leg.reach else np.array([1.0, 0.0]))

    def refined(self, finer: MujocoRobot, position: Floats) -> Floats:
        """The position of a robot with more joints: the curvature at theirs."""
        found = finer.start.copy()
        found[-self.platform_size :] = position[-self.platform_size :]
        coarse, fine = (_at_joints(robot.pieces) for robot in (self, finer))
        for leg, placed in enumerate(self.robot.legs):
            for rod in range(len(placed.rods)):
                coarse_at = [self._joint(leg, rod, piece) for piece in range(1, self.pieces + 1)]
                fine_at = [finer._joint(leg, rod, piece) for piece in range(1, finer.pieces + 1)]
                turns = np.array(
                    [
                        Rotation.from_quat(position[at : at + 4][[1, 2, 3, 0]]).as_rotvec()
                        for at in coarse_at
                    ]
                )
                for axis_turns, at in zip(
                    _interpolated(fine, coarse, turns * (self.pieces / finer.pieces)),
                    fine_at,
                    strict=True,
                ):
                    found[at : at + 4] = Rotation.from_rotvec(axis_turns).as_quat()[[3, 0, 1, 2]]
        finer.forces = self.forces.copy()
        return found

    @property
    def platform_size(self) -> int:
        """How many numbers its position takes."""
        return 3 if self.robot.description.point_platform else 7

    def _joint(self, leg: int, rod: int, piece: int) -> int:
        return int(self.model.joint(f"bend{leg}_{rod}_{piece}").qposadr[0])


def _at_joints(pieces: int) -> Floats:
    return (np.arange(pieces) + 0.5) / pieces


def _interpolated(fine: Floats, coarse: Floats, values: Floats) -> Floats:
    return np.column_stack([np.interp(fine, coarse, column) for column in values.T])
