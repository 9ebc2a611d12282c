# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""Rod grid: weights, integration matrix, rotation steps, Magnus step of order six."""

import math

import numpy as np
import pytest
from helpers.shipped_steps import SHORT_FORM
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.polynomial import Polynomial, legendre
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from benchmarks.robustness import RANGES
from cpr_core import NotReached, solve_forward, solve_home
from cpr_core.description.description_file import shipped_robots
from cpr_core.kernels.rotation_kernel import rotation_steps
from cpr_core.lie import rotation_exp
from cpr_core.rods.quadrature import MAGNUS_WEIGHTS, distinct_stations, rod_grid
from cpr_core.solving.load_robot import load_robot

FAST = settings(deadline=None, derandomize=True, max_examples=100)
BREAKPOINTS = [(), (0.5,), (0.3, 0.7), (0.7, 0.1, 0.2), (0.0, 0.25, 1.0)]
NODES = [1, 2, 3, 5, 8, 16]
POINTS = rod_grid(1).step_points[0] / rod_grid(1).steps[0]  # of a step from 0 to 1


def inner(breakpoints):
    return sorted({b for b in breakpoints if 0.0 < b < 1.0})


def piecewise(breakpoints, degree):
    """A polynomial with other coefficients on every panel: values and integral from 0."""
    edges = np.array([0.0, *inner(breakpoints), 1.0])
    rng = np.random.default_rng(degree)
    pieces = [Polynomial(rng.normal(size=degree + 1)) for _ in edges[1:]]
    integrals = [piece.integ() for piece in pieces]
    whole = [
        integral(end) - integral(start)
        for integral, start, end in zip(integrals, edges[:-1], edges[1:], strict=True)
    ]
    before = np.concatenate([[0.0], np.cumsum(whole)])

    def values(sigma):
        panel = np.minimum(np.searchsorted(edges, sigma, side="right") - 1, len(pieces) - 1)
        return np.array([pieces[p](s) for p, s in zip(panel, sigma, strict=True)])

    def integral(sigma):
        panel = np.minimum(np.searchsorted(edges, sigma, side="right") - 1, len(pieces) - 1)
        return np.array(
            [
                before[p] + integrals[p](s) - integrals[p](edges[p])
                for p, s in zip(panel, sigma, strict=True)
            ]
        )

    return values, integral


@pytest.mark.parametrize("breakpoints", BREAKPOINTS)
@pytest.mark.parametrize("nodes", NODES)
def test_nodes_lie_inside_and_increase(nodes, breakpoints):
    grid = rod_grid(nodes, breakpoints)
    count = nodes * (len(inner(breakpoints)) + 1)
    assert grid.nodes.shape == grid.weights.shape == (count,)
    assert grid.integration.shape == (count, count)
    assert grid.nodes[0] > 0.0
    assert grid.nodes[-1] < 1.0
    assert np.all(np.diff(grid.nodes) > 0.0)
    assert np.all(grid.weights > 0.0)


@pytest.mark.parametrize("nodes", NODES)
def test_without_breakpoints_it_is_gauss_legendre(nodes):
    points, weights = legendre.leggauss(nodes)
    grid = rod_grid(nodes)
    assert_allclose(grid.nodes, 0.5 * (points + 1.0), rtol=0.0, atol=1e-15)
    assert_allclose(grid.weights, 0.5 * weights, rtol=0.0, atol=1e-15)


@pytest.mark.parametrize("breakpoints", BREAKPOINTS)
@pytest.mark.parametrize("nodes", NODES)
def test_weights_integrate_piecewise_polynomials_exactly(nodes, breakpoints):
    grid = rod_grid(nodes, breakpoints)
    for degree in range(2 * nodes):
        values, integral = piecewise(breakpoints, degree)
        expected = integral(np.array([1.0]))[0]
        assert grid.weights @ values(grid.nodes) == pytest.approx(expected, abs=2e-14)


@pytest.mark.parametrize("breakpoints", BREAKPOINTS)
@pytest.mark.parametrize("nodes", NODES)
def test_integration_matrix_integrates_piecewise_polynomials_exactly(nodes, breakpoints):
    grid = rod_grid(nodes, breakpoints)
    for degree in range(nodes):
        values, integral = piecewise(breakpoints, degree)
        found = grid.integration @ values(grid.nodes)
        assert_allclose(found, integral(grid.nodes), rtol=0.0, atol=2e-14)


@pytest.mark.parametrize("breakpoints", BREAKPOINTS)
@pytest.mark.parametrize("nodes", [4, 8, 12, 16, 20])
def test_integration_matrix_meets_the_interpolation_bound_for_smooth_functions(nodes, breakpoints):
    grid = rod_grid(nodes, breakpoints)
    error = np.abs(grid.integration @ np.cos(6.0 * grid.nodes) - np.sin(6.0 * grid.nodes) / 6.0)
    # max |f^(n)| / n! times the largest value (n!)^2 / (2n)! of the monic Legendre polynomial.
    bound = 6.0**nodes * math.factorial(nodes) / math.factorial(2 * nodes)
    assert error.max() < bound + 2e-15


@pytest.mark.parametrize("breakpoints", BREAKPOINTS)
@pytest.mark.parametrize("nodes", NODES)
def test_rotation_steps_cover_the_rod_and_stop_at_every_node(nodes, breakpoints):
    grid = rod_grid(nodes, breakpoints)
    stops = np.cumsum(grid.steps)
    assert np.all(grid.steps > 0.0)
    assert stops[-1] == pytest.approx(1.0, abs=1e-14)
    at_node = grid.step_node >= 0
    assert grid.step_node[at_node].tolist() == list(range(len(grid.nodes)))
    assert_allclose(stops[at_node], grid.nodes, rtol=0.0, atol=1e-14)
    assert_allclose(stops[~at_node], [*inner(breakpoints), 1.0], rtol=0.0, atol=1e-14)
    assert np.all(grid.step_node[~at_node] == -1)


@pytest.mark.parametrize("breakpoints", BREAKPOINTS)
@pytest.mark.parametrize("nodes", NODES)
@pytest.mark.parametrize("substeps", [1, 2, 3])
def test_steps_may_be_cut(nodes, breakpoints, substeps):
    whole, cut = rod_grid(nodes, breakpoints), rod_grid(nodes, breakpoints, substeps)
    last = slice(substeps - 1, None, substeps)
    assert_allclose(cut.steps, np.repeat(whole.steps / substeps, substeps), rtol=0.0, atol=1e-15)
    assert np.array_equal(cut.step_node[last], whole.step_node)
    assert np.count_nonzero(cut.step_node >= 0) == len(whole.nodes)


@pytest.mark.parametrize("breakpoints", BREAKPOINTS)
@pytest.mark.parametrize("nodes", NODES)
def test_step_points_give_the_moments_of_the_steps(nodes, breakpoints):
    grid = rod_grid(nodes, breakpoints)
    middles = np.cumsum(grid.steps) - 0.5 * grid.steps
    for degree in (0, 1, 2, 5, 11, 20):
        function = Polynomial(np.random.default_rng(degree).normal(size=degree + 1))
        moments = MAGNUS_WEIGHTS @ function(grid.step_points).T
        powers = np.arange(degree + 1) + np.array([[1], [2], [3]])
        integrals = (0.5**powers - (-0.5) ** powers) / powers  # of x^k, x x^k, x^2 x^k
        # Taylor's series about the middle of every step, x from -1/2 to 1/2.
        local = [
            function.deriv(k)(middles) * grid.steps**k / math.factorial(k)
            for k in range(degree + 1)
        ]
        first, second, third = integrals @ local
        expected = [2.25 * first - 15.0 * third, 12.0 * second, 180.0 * third - 15.0 * first]
        assert_allclose(moments, expected, rtol=0.0, atol=1e-11)


def test_breakpoints_count_once_in_any_order():
    first, second = rod_grid(4, (0.2, 0.6)), rod_grid(4, (0.6, 0.2, 0.6, 0.0, 1.0))
    assert np.array_equal(first.nodes, second.nodes)
    assert np.array_equal(first.steps, second.steps)


# Magnus step.


def smooth_curvature(s):
    return np.array([np.sin(3.0 * s) + 0.4, 2.0 * np.cos(2.0 * s), 1.5 * s * s - 0.7])


def polynomial_curvature(s):
    return np.array([1.0 - 2.0 * s, 0.5 + s**3, 2.0 * s - s**2])


def planar_curvature(s):
    return np.array([0.0, 2.0 * np.cos(2.0 * s), 1.5 * s * s - 0.7])


def magnus(moments, step):
    """Rotation over one step from the moments of the curvature, (moment, component)."""
    vectors = np.full((1, 3), np.nan)
    rotation_steps(np.array([moments], float), np.array([step]), vectors)
    return rotation_exp(vectors[0])


def one_step(curvature, start, step):
    return magnus(MAGNUS_WEIGHTS @ [curvature(start + step * c) for c in POINTS], step)


def reference_rotation(curvature, start, end):
    """R(end) of R' = R kappa^, R(start) = 1, by an ODE solver of order eight."""

    def rate(s, flat):
        x, y, z = curvature(s)
        return (flat.reshape(3, 3) @ [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]).ravel()

    return (
        solve_ivp(rate, (start, end), np.eye(3).ravel(), method="DOP853", rtol=1e-13, atol=1e-15)
        .y[:, -1]
        .reshape(3, 3)
    )


@pytest.mark.parametrize("curvature", [smooth_curvature, polynomial_curvature, planar_curvature])
@pytest.mark.parametrize("start", [0.0, 0.6])
def test_magnus_step_is_of_order_six(curvature, start):
    # Small enough for the leading term: from 0.4 to 0.2 the rates still lie between 6.3 and 7.9.
    steps = [0.2, 0.1, 0.05]
    errors = [
        np.abs(
            one_step(curvature, start, h) - reference_rotation(curvature, start, start + h)
        ).max()
        for h in steps
    ]
    # Local error h^7: halving the step divides it by 128; order five would give 64 at most.
    assert errors[0] < 1e-6
    assert np.log2(errors[0] / errors[1]) > 6.5
    assert np.log2(errors[1] / errors[2]) > 6.5


@pytest.mark.parametrize("curvature", [smooth_curvature, polynomial_curvature, planar_curvature])
def test_magnus_steps_converge_globally_with_order_six(curvature):
    expected = reference_rotation(curvature, 0.0, 1.0)
    errors = []
    for count in (4, 8, 16):
        rotation = np.eye(3)
        for i in range(count):
            rotation = rotation @ one_step(curvature, i / count, 1.0 / count)
        errors.append(np.abs(rotation - expected).max())
    assert np.log2(errors[0] / errors[1]) > 5.7
    assert np.log2(errors[1] / errors[2]) > 5.7


vectors = arrays(float, 3, elements=st.floats(-5.0, 5.0, allow_subnormal=False))


@given(vectors, st.floats(0.0, 0.5))
@FAST
def test_constant_curvature_is_exact(vector, step):
    rotation = magnus([vector, np.zeros(3), np.zeros(3)], step)
    x, y, z = step * vector
    expected = expm(np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]))
    assert_allclose(rotation, expected, rtol=0.0, atol=5e-14)
    assert_allclose(rotation, rotation_exp(step * vector), rtol=0.0, atol=1e-15)


@given(arrays(float, 16, elements=st.floats(-3.0, 3.0, allow_subnormal=False)), st.floats(0.1, 1.0))
@FAST
def test_bending_about_one_axis_is_exact(coefficients, step):
    polynomial = Polynomial(coefficients)
    axis = np.array([0.0, 0.6, 0.8])
    rotation = one_step(lambda s: polynomial(s) * axis, 0.0, step)
    angle = polynomial.integ()(step)
    assert_allclose(rotation, rotation_exp(angle * axis), rtol=0.0, atol=2e-14)


@given(arrays(float, (3, 3), elements=st.floats(-4.0, 4.0, allow_subnormal=False)))
@FAST
def test_going_back_undoes_a_step(moments):
    forward, back = magnus(moments, 0.3), magnus(moments * [[1.0], [-1.0], [1.0]], -0.3)
    assert_allclose(forward @ back, np.eye(3), rtol=0.0, atol=5e-15)
    assert_allclose(forward.T @ forward, np.eye(3), rtol=0.0, atol=5e-15)


@given(arrays(float, (3, 3), elements=st.floats(-4.0, 4.0, allow_subnormal=False)), vectors)
@FAST
def test_a_step_does_not_depend_on_the_axes_chosen(moments, vector):
    turn = rotation_exp(vector)
    plain, turned = magnus(moments, 0.3), magnus(moments @ turn.T, 0.3)
    assert_allclose(turned, turn @ plain @ turn.T, rtol=0.0, atol=5e-15)


@pytest.mark.parametrize("curvature", [smooth_curvature, polynomial_curvature, planar_curvature])
@pytest.mark.parametrize("breakpoints", [(), (0.3, 0.7)])
def test_steps_of_the_grid_lead_to_the_frames_at_the_nodes(curvature, breakpoints):
    grid = rod_grid(16, breakpoints)
    moments = MAGNUS_WEIGHTS @ [[curvature(s) for s in points] for points in grid.step_points]
    vectors = np.full((len(grid.steps), 3), np.nan)
    rotation_steps(np.ascontiguousarray(moments), grid.steps, vectors)
    rotation, frames = np.eye(3), {}
    for node, vector in zip(grid.step_node, vectors, strict=True):
        rotation = rotation @ rotation_exp(vector)
        frames[node] = rotation
    for node in (0, 5, 15, len(grid.nodes) - 1):
        expected = reference_rotation(curvature, 0.0, grid.nodes[node])
        assert_allclose(frames[node], expected, rtol=0.0, atol=1e-8)
    assert_allclose(rotation, reference_rotation(curvature, 0.0, 1.0), rtol=0.0, atol=1e-8)


# The grid of a robot is fine enough for its modes.


@pytest.mark.parametrize("modes", [3, 5, 7, 8, 12])
@pytest.mark.parametrize("name", shipped_robots())
def test_finer_grids_do_not_move_an_equilibrium(name, modes):
    robot, fine = load_robot(name, modes=modes), load_robot(name, modes=modes)
    vars(fine)["grid"] = rod_grid(64, robot.breakpoints, 2)
    assert len(robot.grid.nodes) < 32
    found, expected = solve_home(robot), solve_home(fine)
    assert fine.kernel_arrays.weights.shape == (64,)
    assert_allclose(found.platform_position, expected.platform_position, rtol=0.0, atol=1e-10)
    assert_allclose(found.platform_rotation, expected.platform_rotation, rtol=0.0, atol=1e-9)
    assert_allclose(found.efforts, expected.efforts, rtol=0.0, atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("modes", [3, 5, 8, 12])
@pytest.mark.parametrize("name", [*SHORT_FORM, "six_rus"])
def test_nor_where_rods_are_bent_far(name, modes):
    """Motors anywhere on a way that reaches folds: the bound that ``Robot.grid`` states."""
    robot, fine = load_robot(name, modes=modes), load_robot(name, modes=modes)
    vars(fine)["grid"] = rod_grid(48, robot.breakpoints, 2)
    random, compared = np.random.default_rng(modes), 0
    while compared < 8:
        away = random.uniform(-1.0, 1.0, robot.motor_count) * RANGES[name]
        try:
            expected = solve_forward(fine, solve_home(fine).motors + away)
            found = solve_forward(robot, solve_home(fine).motors + away)
        except NotReached:
            continue
        compared += 1
        gap = found.platform_position - expected.platform_position
        assert np.linalg.norm(gap) < 1e-9


def test_stations_that_differ_by_rounding_are_one_and_ends_are_none():
    given = (1e-10, 0.3, 0.1 + 0.2, 0.3 + 1e-7, 1.0 - 1e-10)
    assert distinct_stations(given) == (0.3, 0.3 + 1e-7)
