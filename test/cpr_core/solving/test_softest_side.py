# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The side to which a saddle is left is no matter of rounding."""

import numpy as np
import pytest
from helpers.rigid_leg import leaning_rigid_leg, rigid_leg
from numpy.testing import assert_allclose
from scipy.stats import ortho_group

from cpr_core import solve_home
from cpr_core.solving import assembly
from cpr_core.solving.softest_side import softest_side

CURVATURES = np.array([-2.0, -2.0 + 1e-9, -1.0, 0.5, 3.0])


@pytest.mark.parametrize("equal", [1, 2])
def test_signs_and_choice_of_eigenvectors_change_nothing(equal):
    random = np.random.default_rng(0)
    axes = ortho_group.rvs(5, random_state=random)
    curvatures = CURVATURES if equal == 2 else np.array([-2.0, -1.9, -1.0, 0.5, 3.0])
    side = softest_side(curvatures, axes)
    for _ in range(20):
        others = axes * random.choice([-1.0, 1.0], 5)
        if equal == 2:
            others[:, :2] = others[:, :2] @ ortho_group.rvs(2, random_state=random)
        assert_allclose(softest_side(curvatures, others), side, rtol=0.0, atol=1e-12)


def test_it_is_a_direction_of_least_curvature():
    axes = ortho_group.rvs(5, random_state=1)
    side = softest_side(CURVATURES, axes)
    assert np.linalg.norm(side) == pytest.approx(1.0)
    assert_allclose(axes[:, 2:].T @ side, 0.0, atol=1e-12)
    hessian = axes @ np.diag(CURVATURES) @ axes.T
    assert side @ hessian @ side == pytest.approx(-2.0, abs=1e-8)


def mirrored(sign):
    """Rounding as another computer has it: eigenvectors with the other sign, and noise on the slope."""
    random = np.random.default_rng(2)
    found = assembly._downhill

    def downhill(hessian, gradient, flat):
        noise = sign * 1e-12 * random.uniform(0.1, 1.0, len(gradient))
        return found(hessian, gradient + noise, flat)

    return downhill


def test_the_home_of_a_symmetric_robot_is_the_same_on_every_computer(monkeypatch):
    """Which of its two homes was found depended on the processor: a factorisation rounds as it likes."""
    homes = []
    for sign in (1.0, -1.0):
        with monkeypatch.context() as patched:
            patched.setattr(assembly, "_downhill", mirrored(sign))
            homes.append(solve_home(rigid_leg()))
    side = solve_home(rigid_leg()).platform_position[0]
    assert abs(side) > 0.01
    for home in homes:
        assert home.platform_position[0] == pytest.approx(side, abs=1e-9)


def test_the_other_home_is_the_one_with_the_pose_of_the_platform_mirrored():
    home = solve_home(rigid_leg())
    x, y, angle = home.pose
    for side in (1.0, -1.0):
        found = solve_home(leaning_rigid_leg(side * x, y, side * angle))
        assert_allclose(found.pose, [side * x, y, side * angle], rtol=0.0, atol=1e-9)
