# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Pencils shaped as robots are, random or not, and the whole matrices they stand for."""

from __future__ import annotations

import numpy as np

from cpr_core import load_robot
from cpr_core.kernels.pencil import pencil_of
from cpr_core.model.stability import null_space_of

#: Two legs in the plane, six legs, six legs with moments at their tips.
ROBOTS = ("rfrfr", "six_rfs", "gough_stewart")


class WholePencil:
    """A pencil put together from its legs, and a random one to put there."""

    def __init__(self, name, modes=3):
        self.robot = load_robot(name, modes=modes)
        self.kernel_arrays, self.pencil = (
            self.robot.kernel_arrays,
            pencil_of(self.robot.kernel_arrays, self.robot.strain_grams),
        )
        self.strains = self.kernel_arrays.slots.strain_count
        self.legs = len(self.robot.description.legs)
        self.rows, self.width = self.pencil.weights.shape[1], len(self.pencil.corner)

    def fill(self, rng):
        """Random legs, platform and M; multipliers see strain, platform and motors only."""
        shape = self.pencil.blocks["lane"].shape[1:]
        held = self.rows - 1 - self.strains
        self.pencil.blocks["lane"][0] = np.eye(*shape[:2])[..., None]  # where there is no leg
        for lane in range(self.legs):
            block = np.triu(rng.standard_normal(shape[:2]))
            block[self.strains : -1, self.strains : -1] = 0.0
            if self.kernel_arrays.slots.orientation_count == 0:
                block[: self.strains, self.rows :] = 0.0
            block[: self.strains, : self.strains] += 4.0 * np.eye(self.strains)
            block[np.arange(held), self.strains + np.arange(held)] += 2.0
            self.pencil.blocks["lane"][0, ..., lane] = block
            mass = 0.1 * rng.standard_normal((self.strains, self.strains))
            self.pencil.gram["lane"][0, ..., lane] = np.triu(
                mass + mass.T + 2.0 * np.eye(len(mass))
            )
        corner = rng.standard_normal((self.width, self.width))
        self.pencil.corner[:] = corner + corner.T

    def matrices(self, free):
        """H_r and M on an orthonormal basis of the admissible motions."""
        size = self.legs * self.rows + self.width
        whole, mass, moving = np.zeros((size, size)), np.zeros((size, size)), np.ones(size, bool)
        blocks, border = self.pencil.blocks["lane"], slice(self.legs * self.rows, size)
        whole[border, border] = np.triu(self.pencil.corner)
        mass[border, border] = np.eye(self.width)
        multipliers = np.zeros(size, bool)
        for lane in range(self.legs):
            leg = slice(lane * self.rows, (lane + 1) * self.rows)
            whole[leg, leg] = np.triu(blocks[0, :, : self.rows, lane])
            whole[leg, border] = blocks[0, :, self.rows :, lane]
            mass[leg, leg] = np.diag(self.pencil.weights["lane"][0, :, lane])
            strains = slice(leg.start, leg.start + self.strains)
            mass[strains, strains] = np.triu(self.pencil.gram["lane"][0, ..., lane])
            multipliers[strains.stop : leg.stop - 1] = True
            moving[leg.stop - 1] = free
        whole, mass = whole + np.triu(whole, 1).T, mass + np.triu(mass, 1).T
        moving &= ~multipliers
        basis = null_space_of(whole[np.ix_(multipliers, moving)])
        return tuple(basis.T @ m[np.ix_(moving, moving)] @ basis for m in (whole, mass))
