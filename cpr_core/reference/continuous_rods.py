"""Robots of continuous Kirchhoff rods, solved by shooting.

The rods obey, in the world frame, with the tangent t = R e_1 and the curvature k = R H_a^-1 R^T m,

    p' = t,   R' = k^ R,   m' = -t x n,   n' = -fbar                                     (a)

where (m, n) is the wrench the part beyond s exerts on the part before it. Small variations, with
dtheta the rotation in the world, obey

    dp' = dtheta x t,   dtheta' = R H_a^-1 R^T (dm - dtheta x m),
    dm' = -(dtheta x t) x n - t x dn,   dn' = 0                                          (b)

Both are integrated together by the eighth-order Runge-Kutta pair of Dormand and Prince with fixed
steps, so the Jacobian of the shooting is exact up to the error of the integrator.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numba
import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import DOP853
from scipy.spatial.transform import Rotation

from ..description import LegDescription
from ..equilibrium import Equilibrium
from ..errors import InvalidRequest, NoForwardSolution
from ..joints import Revolute as RevoluteJoint
from ..joints import Spherical
from ..lie import quaternion_from_rotation, skew
from ..loads import Loads
from ..motors import Revolute as RevoluteMotor
from ..robot import Robot

__all__ = [
    "STEPS",
    "ContinuousEquilibrium",
    "RodTrajectory",
    "balance_rows",
    "force",
    "frame",
    "integrate",
    "integrate_rod",
    "moment",
    "position",
    "solve_continuous",
    "transition",
]

Floats = NDArray[np.float64]

_NODES = np.ascontiguousarray(DOP853.A[: DOP853.n_stages, : DOP853.n_stages])
_WEIGHTS = np.ascontiguousarray(DOP853.B)

#: Steps along a rod. Halving them changes no tip by more than 1e-12 lengths on the paper's paths.
STEPS = 64


@numba.njit(cache=True, nogil=True)
def _slope(state, compliance, distributed, slope):
    """Right-hand sides of (a) and (b); see ``integrate`` for the order of the state."""
    r = state[3:12]
    mx, my, mz = state[12], state[13], state[14]
    nx, ny, nz = state[15], state[16], state[17]
    tx, ty, tz = r[0], r[3], r[6]
    kx = ky = kz = 0.0
    # W = R H_a^-1 R^T, the compliance in the world.
    wxx = wxy = wxz = wyy = wyz = wzz = 0.0
    for j in range(3):
        a, b, c = r[j], r[3 + j], r[6 + j]
        wxx += compliance[j] * a * a
        wxy += compliance[j] * a * b
        wxz += compliance[j] * a * c
        wyy += compliance[j] * b * b
        wyz += compliance[j] * b * c
        wzz += compliance[j] * c * c
    kx = wxx * mx + wxy * my + wxz * mz
    ky = wxy * mx + wyy * my + wyz * mz
    kz = wxz * mx + wyz * my + wzz * mz
    slope[0], slope[1], slope[2] = tx, ty, tz
    for j in range(3):
        a, b, c = r[j], r[3 + j], r[6 + j]
        slope[3 + j] = ky * c - kz * b
        slope[6 + j] = kz * a - kx * c
        slope[9 + j] = kx * b - ky * a
    slope[12] = ny * tz - nz * ty
    slope[13] = nz * tx - nx * tz
    slope[14] = nx * ty - ny * tx
    for j in range(3):
        slope[15 + j] = -distributed[j]
    # Columns: what a unit variation of dtheta, dm, dn at the start does to dp, dtheta, dm.
    for column in range(9):
        o = 18 + 9 * column
        ax, ay, az = state[o + 3], state[o + 4], state[o + 5]
        # dm - dtheta x m
        bx = state[o + 6] - (ay * mz - az * my)
        by = state[o + 7] - (az * mx - ax * mz)
        bz = state[o + 8] - (ax * my - ay * mx)
        # dtheta x t
        vx = ay * tz - az * ty
        vy = az * tx - ax * tz
        vz = ax * ty - ay * tx
        slope[o], slope[o + 1], slope[o + 2] = vx, vy, vz
        slope[o + 3] = wxx * bx + wxy * by + wxz * bz
        slope[o + 4] = wxy * bx + wyy * by + wyz * bz
        slope[o + 5] = wxz * bx + wyz * by + wzz * bz
        fx = 1.0 if column == 6 else 0.0
        fy = 1.0 if column == 7 else 0.0
        fz = 1.0 if column == 8 else 0.0
        slope[o + 6] = ny * vz - nz * vy + (fy * tz - fz * ty)
        slope[o + 7] = nz * vx - nx * vz + (fz * tx - fx * tz)
        slope[o + 8] = nx * vy - ny * vx + (fx * ty - fy * tx)


@numba.njit(cache=True, nogil=True)
def _steps(states, step, compliance, distributed, nodes, weights):
    """Runge-Kutta steps of one size from ``states[0]`` into the rows after it."""
    stages, size = len(weights), states.shape[1]
    slopes = np.empty((stages, size))
    inner = np.empty(size)
    for k in range(len(states) - 1):
        for stage in range(stages):
            for i in range(size):
                inner[i] = states[k, i]
            for earlier in range(stage):
                factor = step * nodes[stage, earlier]
                if factor != 0.0:
                    for i in range(size):
                        inner[i] += factor * slopes[earlier, i]
            _slope(inner, compliance, distributed, slopes[stage])
        for i in range(size):
            states[k + 1, i] = states[k, i]
        for stage in range(stages):
            factor = step * weights[stage]
            for i in range(size):
                states[k + 1, i] += factor * slopes[stage, i]


@dataclass(frozen=True, eq=False)
class RodTrajectory:
    """A rod and its variations, along equal steps from one of its ends.

    Attributes:
        step: Arc length of a step, negative from the tip to the base [m].
        rigidities: H_a, (3,) [N m^2].
        distributed: Force per length in the world, (3,) [N/m].
        states: Position, frame (rows), moment, force and the columns of the variations, in the world,
            (steps + 1, 99).
    """

    step: float
    rigidities: Floats
    distributed: Floats
    states: Floats = field(repr=False)

    def at(self, fraction: float) -> Floats:
        """State a fraction of the length from the start, (99,), by one step from the node before."""
        place = fraction * (len(self.states) - 1)
        node = min(int(place), len(self.states) - 1)
        rest = place - node
        if rest == 0.0:
            return self.states[node]
        states = np.empty((2, 99))
        states[0] = self.states[node]
        _steps(states, rest * self.step, 1.0 / self.rigidities, self.distributed, _NODES, _WEIGHTS)
        return states[1]


def position(state: Floats) -> Floats:
    """Position in the world, (3,) [m]."""
    return state[:3]


def frame(state: Floats) -> Floats:
    """Cross-section frame in the world, (3, 3); columns d1 (tangent), d2, d3."""
    return state[3:12].reshape(3, 3)


def moment(state: Floats) -> Floats:
    """Internal moment in the world, (3,) [N m]."""
    return state[12:15]


def force(state: Floats) -> Floats:
    """Internal force in the world, (3,) [N]."""
    return state[15:18]


def transition(state: Floats) -> Floats:
    """Transition matrix of (b) for (dp, dtheta, dm, dn) from the start of the rod, (12, 12)."""
    matrix = np.eye(12)
    matrix[:9, 3:] = state[18:].reshape(9, 9).T
    return matrix


def integrate(
    start: tuple[ArrayLike, ArrayLike, ArrayLike, ArrayLike],
    length: float,
    rigidities: Floats,
    distributed: ArrayLike,
    steps: int = STEPS,
) -> RodTrajectory:
    """Integrate a rod and its variations, (a) and (b).

    Args:
        start: Position [m], frame, internal moment [N m] and internal force [N] at the start, in the
            world, (3,), (3, 3), (3,), (3,).
        length: Arc length [m]; negative from the tip to the base.
        rigidities: H_a, (3,) [N m^2].
        distributed: Force per length, fixed in the world, (3,) [N/m].
        steps: Number of steps.
    """
    states = np.empty((steps + 1, 99))
    states[0, :18] = np.concatenate([np.ravel(part) for part in start])
    states[0, 18:] = np.vstack([np.zeros((3, 9)), np.eye(9)[:6]]).T.ravel()
    force_per_length = np.array(distributed, float)
    _steps(states, length / steps, 1.0 / rigidities, force_per_length, _NODES, _WEIGHTS)
    return RodTrajectory(length / steps, rigidities, force_per_length, states)


def integrate_rod(
    leg: LegDescription,
    base_pose: tuple[ArrayLike, ArrayLike],
    base_moment: ArrayLike,
    base_force: ArrayLike,
    distributed: ArrayLike,
    steps: int = STEPS,
) -> RodTrajectory:
    """Integrate a leg from its base to its tip.

    Args:
        leg: The leg; its rod is uniform and straight at rest.
        base_pose: Position (3,) [m] and frame (3, 3) of the base in the world.
        base_moment: Moment the rod exerts on the base, about the base point, (3,) [N m].
        base_force: Force the rod exerts on the base, (3,) [N].
        distributed: Force per length, fixed in the world, (3,) [N/m].
        steps: Number of steps.
    """
    start = (*base_pose, base_moment, base_force)
    return integrate(start, leg.rod.length, leg.rod.rigidities, distributed, steps)


@dataclass(frozen=True, eq=False)
class ContinuousEquilibrium:
    """An equilibrium of a robot of continuous rods.

    Attributes:
        robot: The robot; its strain modes play no part.
        loads: Loads in force.
        motors: Motor positions q_a, (n,) [rad].
        efforts: Motor efforts tau_a on the rods, (n,) [N m].
        platform_rotation: R_p in the world, (3, 3).
        platform_position: p_p in the world, (3,) [m].
        base_wrenches: Moment [N m] and force [N] every rod exerts on its base, in the world, (L, 6).
        residual: Largest dimensionless gap or imbalance.
        iterations: Newton steps.
        steps: Runge-Kutta steps along every rod.
        integration_error: Largest change of a dimensionless residual with twice the steps.
        legs: The rods from base to tip.
    """

    robot: Robot
    loads: Loads
    motors: Floats
    efforts: Floats
    platform_rotation: Floats
    platform_position: Floats
    base_wrenches: Floats
    residual: float
    iterations: int
    steps: int
    integration_error: float
    legs: tuple[RodTrajectory, ...] = field(repr=False)

    def __post_init__(self) -> None:
        for array in (
            self.motors,
            self.efforts,
            self.platform_rotation,
            self.platform_position,
            self.base_wrenches,
            *(leg.states for leg in self.legs),
        ):
            array.flags.writeable = False

    @property
    def platform_quaternion(self) -> Floats:
        """Orientation of the platform as a unit quaternion (w, x, y, z)."""
        return quaternion_from_rotation(self.platform_rotation)


def solve_continuous(
    equilibrium: Equilibrium,
    held: Literal["motors", "platform"] = "motors",
    *,
    steps: int = STEPS,
    tolerance: float = 1e-11,
) -> ContinuousEquilibrium:
    """Refine an equilibrium of the strain-mode model into one of continuous rods.

    Loads and either motor positions or the platform pose stay. Unknowns are the base wrenches and
    the other of the two, equations the tip gaps, the tip moments and the balance of the platform,
    Eq. (32) without strain modes.

    Args:
        equilibrium: Where the shooting starts.
        held: What stays. With the motors held the Jacobian is singular where stability is lost with
            motors locked (it is b(0)), so hold the platform there; it needs a motor for each of its
            coordinates.
        steps: Runge-Kutta steps along every rod.
        tolerance: On the residual: lengths in rod lengths, moments in EI/l, forces in EI/l^2.

    Raises:
        InvalidRequest: The robot or a load is not of the kind this method knows.
        NoForwardSolution: Newton's method does not reach the tolerance.
    """
    _check(equilibrium, held)
    robot, loads = equilibrium.robot, equilibrium.loads
    legs = robot.description.legs
    density = [leg.rod.mass_per_length * loads.gravity + loads.rod_force for leg in legs]
    motor_axes = np.array([leg.motor.axis for leg in legs])  # type: ignore[attr-defined]
    motors = np.array(equilibrium.motors)
    frames = [
        Rotation.from_rotvec(axis * angle).as_matrix() @ leg.base_rotation
        for leg, axis, angle in zip(legs, motor_axes, motors, strict=True)
    ]
    axes = robot.arrays.position_axes
    tip_forces = np.zeros((len(legs), 3))
    tip_forces[:, axes] = equilibrium.multipliers.reshape(len(legs), len(axes))
    wrenches = np.array(
        [
            _base_wrench(equilibrium, number, frames[number], tip_forces[number], density[number])
            for number in range(len(legs))
        ]
    )
    rotation = np.array(equilibrium.platform_rotation)
    place = np.array(equilibrium.platform_position)
    rows, columns, unit = _selection(robot, held)

    def shoot(count: int) -> tuple[list[RodTrajectory], Floats]:
        rods = [
            integrate_rod(leg, (leg.base_position, base), wrench[:3], wrench[3:], load, count)
            for leg, base, wrench, load in zip(legs, frames, wrenches, density, strict=True)
        ]
        gaps = [
            np.concatenate(
                [
                    position(rod.states[-1]) - place - rotation @ leg.joint.position,
                    moment(rod.states[-1]),
                ]
            )
            for rod, leg in zip(rods, legs, strict=True)
        ]
        forces = np.array([force(rod.states[-1]) for rod in rods])
        return rods, np.concatenate([*gaps, balance(robot, loads, rotation, forces)])

    for iteration in range(30):  # noqa: B007 - reported
        rods, residual = shoot(steps)
        largest = float(np.abs((residual / unit)[rows]).max())
        if largest < tolerance:
            break
        size = len(residual)
        jacobian = np.zeros((size, size + len(legs)))  # wrenches, platform, motors
        for number, (rod, leg) in enumerate(zip(rods, legs, strict=True)):
            gap = np.arange(6 * number, 6 * number + 6)
            at_tip = transition(rod.states[-1])[[0, 1, 2, 6, 7, 8]]
            jacobian[np.ix_(gap, gap)] = at_tip[:, 6:]
            jacobian[gap[:3], size - 6 : size - 3] = skew(rotation @ leg.joint.position)
            jacobian[gap[:3], size - 3 : size] = -np.eye(3)
            jacobian[gap, size + number] = at_tip[:, 3:6] @ motor_axes[number]
        on_platform = balance_rows(
            robot, loads, rotation, np.array([force(rod.states[-1]) for rod in rods])
        )
        jacobian[-6:, size - 6 : size] = on_platform[:, :6]
        for number in range(len(legs)):  # under dead loads the tip force varies as the base force
            at_base = slice(6 * number + 3, 6 * number + 6)
            jacobian[-6:, at_base] = on_platform[:, 6 + 3 * number : 9 + 3 * number]
        matrix = (jacobian / unit[:, None])[np.ix_(rows, columns)]
        change = np.zeros(size + len(legs))
        change[columns] = np.linalg.solve(matrix, -(residual / unit)[rows])
        wrenches += change[: size - 6].reshape(-1, 6)
        rotation = Rotation.from_rotvec(change[size - 6 : size - 3]).as_matrix() @ rotation
        place = place + change[size - 3 : size]
        motors = motors + change[size:]
        frames = [
            Rotation.from_rotvec(axis * turn).as_matrix() @ base
            for axis, turn, base in zip(motor_axes, change[size:], frames, strict=True)
        ]
    else:
        raise NoForwardSolution(f"shooting: residual {largest:.1e} after 30 steps", 0.0, None)
    finer = shoot(2 * steps)[1]
    return ContinuousEquilibrium(
        robot=robot,
        loads=loads,
        motors=motors,
        # The rod holds its base with (m, n); the motor turns the rod against it.
        efforts=-(motor_axes * wrenches[:, :3]).sum(axis=1),
        platform_rotation=rotation,
        platform_position=place,
        base_wrenches=wrenches,
        residual=largest,
        iterations=iteration,
        steps=steps,
        integration_error=float(np.abs(((finer - residual) / unit)[rows]).max()),
        legs=tuple(rods),
    )


def balance(robot: Robot, loads: Loads, rotation: Floats, tip_forces: Floats) -> Floats:
    """Moment about P and force on the platform, in the world, (6,) [N m, N]."""
    description = robot.description
    weight = description.platform_mass * loads.gravity
    following = loads.wrench_body.reshape(2, 3) @ rotation.T
    total = loads.wrench_world + following.ravel()
    total[:3] += np.cross(rotation @ description.center_of_mass, weight)
    total[3:] += weight
    for leg, tip_force in zip(description.legs, tip_forces, strict=True):
        total[:3] -= np.cross(rotation @ leg.joint.position, tip_force)
        total[3:] -= tip_force
    return total


def balance_rows(robot: Robot, loads: Loads, rotation: Floats, tip_forces: Floats) -> Floats:
    """Derivative of ``balance`` by the platform's world twist and the tip forces, (6, 6 + 3 L)."""
    description = robot.description
    following = loads.wrench_body.reshape(2, 3) @ rotation.T
    rows = np.zeros((6, 6 + 3 * len(tip_forces)))
    weight = description.platform_mass * loads.gravity
    # d(r x f) = (dOmega x r) x f = f^ r^ dOmega
    rows[:3, :3] = skew(weight) @ skew(rotation @ description.center_of_mass) - skew(following[0])
    rows[3:, :3] = -skew(following[1])
    for number, (leg, tip_force) in enumerate(zip(description.legs, tip_forces, strict=True)):
        arm = skew(rotation @ leg.joint.position)
        rows[:3, :3] -= skew(tip_force) @ arm
        rows[:3, 6 + 3 * number : 9 + 3 * number] = -arm
        rows[3:, 6 + 3 * number : 9 + 3 * number] = -np.eye(3)
    return rows


def _selection(robot: Robot, held: str) -> tuple[Floats, Floats, Floats]:
    """Rows and unknown columns of the shooting (fewer in the plane), and units of all rows."""
    count = len(robot.description.legs)
    in_leg = np.array([0, 1, 5] if robot.planar else range(6))
    rows = (6 * np.arange(count)[:, None] + in_leg).ravel()
    in_wrench = np.array([2, 3, 4] if robot.planar else range(6))
    columns = (6 * np.arange(count)[:, None] + in_wrench).ravel()
    platform = 6 * count + robot.platform_axes
    length = np.mean([leg.rod.length for leg in robot.description.legs])
    bending = np.mean([leg.rod.rigidities[2] for leg in robot.description.legs])
    unit = np.repeat([length, bending / length], 3)
    on_platform = np.repeat([bending / length, bending / length**2], 3)
    return (
        np.append(rows, platform),
        np.append(columns, platform if held == "motors" else 6 * count + 6 + np.arange(count)),
        np.concatenate([np.tile(unit, count), on_platform]),
    )


def _base_wrench(
    equilibrium: Equilibrium, number: int, base: Floats, tip_force: Floats, density: Floats
) -> Floats:
    """Base wrench by statics from the tip force, about the strain-mode shape, (6,) [N m, N].

    The shape enters through the lever arm of the distributed force only; a few hundred small
    rotations from midpoint to midpoint are plenty for a starting guess.
    """
    robot, leg = equilibrium.robot, equilibrium.robot.description.legs[number]
    first, length, count = robot.arrays.legs[number]["strain_index"], leg.rod.length, 200
    strain = equilibrium.state[first : first + leg.modes.total]
    sigma = (np.arange(count) + 0.5) / count
    curvature = (leg.modes.values(sigma) * strain) @ np.eye(3)[leg.modes.directions]
    tangents, frame_here = np.empty((count, 3)), base
    for k, turn in enumerate(Rotation.from_rotvec(curvature * length / count).as_matrix()):
        tangents[k], frame_here = frame_here[:, 0], frame_here @ turn
    arms = np.cumsum(tangents, axis=0) * length / count
    tip = equilibrium.platform_position + equilibrium.platform_rotation @ leg.joint.position
    at_base = np.cross(tip - leg.base_position, tip_force)
    at_base += np.cross(arms, density).sum(axis=0) * length / count
    return np.concatenate([at_base, tip_force + density * length])


def _check(equilibrium: Equilibrium, held: str) -> None:
    robot, loads = equilibrium.robot, equilibrium.loads
    if held == "platform" and robot.motor_count != len(robot.platform_axes):
        raise InvalidRequest("held", "expected as many motors as platform coordinates")
    for leg in robot.description.legs:
        if not (isinstance(leg.motor, RevoluteMotor) and leg.motor_name is not None):
            raise InvalidRequest("robot", f"{leg.name}: expected a revolute motor")
        if not isinstance(leg.joint, Spherical) and not (
            robot.planar and isinstance(leg.joint, RevoluteJoint)
        ):
            raise InvalidRequest("robot", f"{leg.name}: expected a tip joint that takes no moment")
        if not leg.rod.uniform or any(np.any(series) for series in leg.rod.rest_curvature):
            raise InvalidRequest("robot", f"{leg.name}: expected a uniform rod, straight at rest")
    if loads.distributed or loads.points:
        raise InvalidRequest("loads", "expected gravity, rod_force and platform wrenches only")
