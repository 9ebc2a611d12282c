# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Statics with MuJoCo's forces: it integrates in time only, so Newton's method is ours."""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lu_factor, lu_solve
from scipy.spatial.transform import Rotation

from .mujoco_model import xml_of
from .placed_robot import BOW, Frame, PlacedRobot, tip_frame

__all__ = ["MujocoRobot", "NotBalanced"]

Floats = NDArray[np.float64]

#: Step of the central differences [rad or m].
STEP = 1e-6
#: Largest correction that ends the iteration [rad or m], and steps it may take.
SMALL, MOST = 1e-9, 40
#: Largest correction that is taken whole [rad or m].
LARGEST = 0.3


class NotBalanced(Exception):
    """Newton's method does not converge."""


class MujocoRobot:
    """A robot with so many joints a rod, held where one says.

    Args:
        robot: What is to be built.
        pieces: Joints of every rod.
    """

    def __init__(self, robot: PlacedRobot, pieces: int) -> None:
        self.robot, self.pieces = robot, pieces
        self.model = mujoco.MjModel.from_xml_string(xml_of(robot, pieces))
        self.data = mujoco.MjData(self.model)
        self.start = self.data.qpos.copy()
        names = range(len(robot.legs))
        self.motors = np.array([self.model.joint(f"motor{i}").dofadr[0] for i in names])
        self.sites = [self.model.site(f"tip{i}").id for i in names]
        self.body = self.model.body("platform").id
        self.free = np.setdiff1d(np.arange(self.model.nv), self.motors)
        self.platform_dofs = np.arange(self.model.nv)[-self.model.body("platform").dofnum[0] :]
        self.held = [tip_frame(leg.tip) for leg in robot.legs]
        self.stiffness = 0.0
        self.forces = np.zeros(3 * len(robot.legs))

    def _evaluate(self, position: Floats) -> tuple[Floats, Floats, Floats]:
        """Generalised forces (nv,), gaps (g,), and their derivative (g, nv)."""
        model, data = self.model, self.data
        data.qpos[:] = position
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        forces = data.qfrc_passive - data.qfrc_bias
        if self.stiffness:
            away = np.zeros(model.nv)
            mujoco.mj_differentiatePos(model, away, 1.0, self.start, position)
            forces[self.platform_dofs] -= self.stiffness * away[self.platform_dofs]
        rotation, place = data.xmat[self.body].reshape(3, 3), data.xpos[self.body]
        gaps, rows = [], []
        along, other = np.zeros((3, model.nv)), np.zeros((3, model.nv))
        for site, held in zip(self.sites, self.held, strict=True):
            point = place + rotation @ held.position
            mujoco.mj_jacSite(model, data, along, None, site)
            mujoco.mj_jac(model, data, other, None, point, self.body)
            gaps.append(data.site_xpos[site] - point)
            rows.append(along - other)
        return forces, np.concatenate(gaps), np.vstack(rows)

    def _residual(self, position: Floats) -> tuple[Floats, Floats]:
        forces, gaps, rows = self._evaluate(position)
        return np.concatenate([(forces + rows.T @ self.forces)[self.free], gaps]), rows

    def _moved(self, position: Floats, change: Floats) -> Floats:
        found = position.copy()
        mujoco.mj_integratePos(self.model, found, change, 1.0)
        return found

    def balance(self, position: Floats) -> Floats:
        """Where forces and gaps vanish, from a position on.

        Raises:
            NotBalanced: Not within a few steps.
        """
        count, size = self.model.nv, len(self.free)
        for _ in range(MOST):
            residual, rows = self._residual(position)
            tangent = np.zeros((len(residual), len(residual)))
            for column, dof in enumerate(self.free):
                change = np.zeros(count)
                change[dof] = STEP
                ahead, _ = self._residual(self._moved(position, change))
                behind, _ = self._residual(self._moved(position, -change))
                tangent[:, column] = (ahead - behind) / (2.0 * STEP)
            tangent[:size, size:] = rows[:, self.free].T
            step = -lu_solve(lu_factor(tangent), residual)
            largest = np.abs(step[:size]).max()
            if not np.isfinite(largest):
                break
            part = min(1.0, LARGEST / largest)
            change = np.zeros(count)
            change[self.free] = part * step[:size]
            position = self._moved(position, change)
            self.forces = self.forces + part * step[size:]
            if largest < SMALL:
                return position
        raise NotBalanced(f"MuJoCo, {self.pieces} joints a rod")

    def efforts(self, position: Floats) -> Floats:
        """What the motors have to do, (legs,) [N m]."""
        forces, _, rows = self._evaluate(position)
        return -(forces + rows.T @ self.forces)[self.motors]

    def platform(self, position: Floats) -> Frame:
        """Where the platform is."""
        self._evaluate(position)
        rotation = self.data.xmat[self.body].reshape(3, 3).copy()
        return Frame(rotation, self.data.xpos[self.body].copy())

    def bent(self) -> Floats:
        """The start with every leg bent evenly to its side: a straight one cannot give way."""
        found = self.start.copy()
        for number, leg in enumerate(self.robot.legs):
            assert leg.bow is not None
            axis = leg.clamp.rotation.T @ np.cross(leg.bow, leg.clamp.rotation[:, 0])
            bend = BOW / (self.pieces * len(leg.rods)) * axis / np.linalg.norm(axis)
            for rod in range(len(leg.rods)):
                for piece in range(1, self.pieces + 1):
                    at = self._joint(number, rod, piece)
                    found[at : at + 4] = Rotation.from_rotvec(bend).as_quat()[[3, 0, 1, 2]]
        return found

    def halved(self, finer: MujocoRobot, position: Floats) -> Floats:
        """The position of a robot with twice as many joints: the curvature at theirs."""
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
                    _interpolated(fine, coarse, 0.5 * turns), fine_at, strict=True
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
