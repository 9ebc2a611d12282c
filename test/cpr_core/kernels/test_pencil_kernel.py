# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Smallest eigenvalues of pencils shaped as robots are, against LAPACK on the whole matrices."""

import numpy as np
import pytest
from helpers.kernel_entry import entry
from scipy import linalg

from cpr_core import load_robot, solve_home
from cpr_core.kernels import pencil_kernel
from cpr_core.kernels.kept_factors import kept_factors
from cpr_core.kernels.pencil import pencil_of
from cpr_core.model.stability import null_space_of

#: Two legs in the plane, six legs, six legs with moments at their tips.
ROBOTS = ("rfrfr", "six_rfs", "gough_stewart")


@entry
def smallest_eigenvalue(robot, pencil, free):
    diagonal = pencil_kernel.is_diagonal(pencil.gram)
    measure = pencil_kernel.Measure(pencil.gram, diagonal, pencil.weights, 1.0, free)
    return pencil_kernel.smallest_eigenvalue(robot, pencil, measure, np.nan)


@entry
def eliminate_pencil(robot, pencil, free, shift):
    measure = pencil_kernel.Measure(pencil.gram, False, pencil.weights, 1.0, free)
    return pencil_kernel.eliminate_pencil(robot, pencil, measure, shift)


@entry
def recall_pencil(robot, kept, pencil):
    return pencil_kernel.recall_pencil(robot, kept, pencil)


class Whole:
    """A pencil put together from its legs, and a random one to put there."""

    def __init__(self, name, modes=3):
        self.robot = load_robot(name, modes=modes)
        self.arrays, self.pencil = (
            self.robot.arrays,
            pencil_of(self.robot.arrays, self.robot.strain_grams),
        )
        self.strains = self.arrays.slots.strain_count
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
            if self.arrays.slots.orientation_count == 0:
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
            here = slice(lane * self.rows, (lane + 1) * self.rows)
            whole[here, here] = np.triu(blocks[0, :, : self.rows, lane])
            whole[here, border] = blocks[0, :, self.rows :, lane]
            mass[here, here] = np.diag(self.pencil.weights["lane"][0, :, lane])
            inner = slice(here.start, here.start + self.strains)
            mass[inner, inner] = np.triu(self.pencil.gram["lane"][0, ..., lane])
            multipliers[inner.stop : here.stop - 1] = True
            moving[here.stop - 1] = free
        whole, mass = whole + np.triu(whole, 1).T, mass + np.triu(mass, 1).T
        moving &= ~multipliers
        basis = null_space_of(whole[np.ix_(multipliers, moving)])
        return tuple(basis.T @ m[np.ix_(moving, moving)] @ basis for m in (whole, mass))

    def smallest(self, free):
        return smallest_eigenvalue(self.arrays, self.pencil, free)

    def below(self, free, shift):
        return eliminate_pencil(self.arrays, self.pencil, free, shift)


@pytest.mark.parametrize("free", [False, True])
@pytest.mark.parametrize("name", ROBOTS)
def test_random_pencils_definite_or_not(name, free):
    rng, whole = np.random.default_rng(4), Whole(name)
    seen = set()
    for _ in range(40):
        whole.fill(rng)
        expected = linalg.eigvalsh(*whole.matrices(free))
        seen.add(expected[0] > 0.0)
        accuracy = 1e-10 * np.abs(expected).max()
        assert whole.smallest(free) == pytest.approx(expected[0], rel=1e-10, abs=accuracy)
        for shift in (-3.0, 0.5, expected[0] - 1e-6, expected[0] + 1e-6, 2.5):
            assert whole.below(free, shift) == np.sum(expected < shift)
    assert False in seen


@pytest.mark.parametrize("gap", [0.0, 1e-12, 1e-9, 1e-6, 1e-3])
def test_equal_and_nearly_equal_eigenvalues(gap):
    """Legs that are the same but for a little, and a platform that does not see them."""
    whole = Whole("six_rfs")
    whole.fill(np.random.default_rng(2))
    legs = whole.pencil.blocks["lane"]
    for lane in range(whole.legs):
        legs[0, ..., lane] = legs[0, ..., 0]
        legs[0, 0, 0, lane] += gap * (lane == 3)
        whole.pencil.gram["lane"][0, ..., lane] = whole.pencil.gram["lane"][0, ..., 0]
    legs[0, :, whole.rows :] = 0.0
    whole.pencil.corner[:] = 50.0 * np.eye(6)
    expected = linalg.eigvalsh(*whole.matrices(True))
    assert expected[4] - expected[0] < 2.0 * gap + 1e-12
    assert whole.smallest(True) == pytest.approx(expected[0], abs=2e-11)


def test_zero_is_an_eigenvalue_as_any_other():
    whole = Whole("rfrfr")
    whole.fill(np.random.default_rng(5))
    first = linalg.eigvalsh(*whole.matrices(False))[0]
    blocks, mass = whole.pencil.blocks["lane"], whole.pencil.gram["lane"]
    blocks[0, : whole.strains, : whole.strains] -= first * mass[0]
    whole.pencil.corner[:] -= first * np.eye(whole.width)
    assert whole.smallest(False) == pytest.approx(0.0, abs=1e-11)


@pytest.mark.parametrize("name", ROBOTS)
def test_factors_are_put_together_to_what_they_were_factored_from(name):
    """With the tangent of the robot itself, by states."""
    whole = Whole(name, modes=5)
    home, arrays = solve_home(whole.robot), whole.arrays
    assert recall_pencil(arrays, home.factors, whole.pencil)
    expected = home.robot.arrays.energy_unit * linalg.eigvalsh(*whole.matrices(True))
    np.testing.assert_allclose(expected, home.spectrum_free.eigenvalues, rtol=0.0, atol=1e-10)


def test_a_leg_nearly_straight_is_refused():
    """Three modes can hardly shorten these legs: their stiffness hides all other."""
    home = solve_home(load_robot("gough_stewart", modes=3))
    assert not recall_pencil(
        home.robot.arrays, home.factors, pencil_of(home.robot.arrays, home.robot.strain_grams)
    )
    assert home.spectrum_free.smallest == home.spectrum_free.eigenvalues[0]


def test_a_leg_without_stiffness_is_refused():
    robot = load_robot("rfrfr", modes=3)
    kept, pencil = kept_factors(robot.arrays), pencil_of(robot.arrays, robot.strain_grams)
    kept[:] = solve_home(robot).factors
    kept["lane"][1, 1] *= 1e9  # an inverse pivot
    assert not recall_pencil(robot.arrays, kept, pencil)
