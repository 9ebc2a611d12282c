# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""What decisions look like as messages; no node is needed for that."""

from dataclasses import replace
from itertools import pairwise
from operator import attrgetter
from types import SimpleNamespace

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from cpr_msgs.msg import Equilibrium as EquilibriumMessage
from cpr_msgs.msg import ErrorCode, StabilityMetrics
from cpr_msgs.srv import CheckStability, GetKinematoStatics
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import WrenchStamped
from helpers.drive import SETTINGS, Drive, changed_robot, robot, uncontrolled_robot
from helpers.markers import markers_of
from helpers.rigid_leg import rigid_leg
from helpers.turntable import turntable
from sensor_msgs.msg import JointState
from std_msgs.msg import Header
from visualization_msgs.msg import Marker

from cpr_core import (
    CprError,
    InvalidRequest,
    NonFiniteInput,
    error_of,
    kinemato_statics,
    leg_shapes,
    solve_forward,
    solve_home,
    spectrum,
)
from cpr_core.drawing.robot_lines import bending_curvature
from cpr_core.lie import rotation_exp
from cpr_core.model.assessment import Assessment
from cpr_core.model.kinemato_statics import KinematoStatics
from cpr_core.model.platform_coordinates import six_components
from cpr_ros.closed_loop.loop_status import Loop, LoopStatus
from cpr_ros.error_codes import RequestError
from cpr_ros.following.supervision import BLIND, FIELDS, Action, State, Status, Verdict
from cpr_ros.interface.diagnostics import NodeHealth, diagnostic_array
from cpr_ros.messages.analysis import (
    fill_kinemato_statics,
    fill_stability,
    message_matrix,
    singularity_message,
)
from cpr_ros.messages.equilibrium_messages import fill_equilibrium, platform_pose
from cpr_ros.messages.frames import Frames
from cpr_ros.messages.geometry import quaternion_of, twist_of, vector_of, wrench_of
from cpr_ros.messages.model_error import model_error_message
from cpr_ros.messages.motor_messages import measured_motors, motor_setpoint
from cpr_ros.messages.stability_stream import Moment, StabilityStream
from cpr_ros.messages.transforms import transform_of
from cpr_ros.messages.wrench_messages import with_wrench

FRAMES = Frames("base", "platform")


def metrics_of(outcome):
    """The message of the stream after a tick, without setpoint and wrench."""
    return told_of(StabilityStream(), outcome)


def told_of(stream, outcome, **about):
    moment = Moment(outcome, 0.0, (0, 0))
    return stream.message(
        moment, SETTINGS.thresholds, FRAMES, setpoint_age=-1.0, wrench_age=-1.0, **about
    )


def test_a_wrench_in_a_third_frame_is_turned_if_somebody_knows_the_frame():
    rotation = rotation_exp([0.0, 0.0, 0.5 * np.pi])
    known = Frames("base", "platform", lambda name: rotation if name == "tool" else None)
    message = WrenchStamped()
    message.wrench.force.x, message.wrench.torque.y = 2.0, 3.0
    message.header.frame_id = "tool"
    loads = with_wrench(robot("six_rfs").default_loads, message, known)
    np.testing.assert_allclose(loads.wrench_world, [-3, 0, 0, 0, 2, 0], atol=1e-15)
    np.testing.assert_array_equal(loads.wrench_body, 0.0)
    for frames, frame in ((known, "camera"), (FRAMES, "tool")):
        message.header.frame_id = frame
        with pytest.raises(RequestError) as caught:
            with_wrench(robot("six_rfs").default_loads, message, frames)
        assert caught.value.val == ErrorCode.FRAME_TRANSFORM_FAILURE


@pytest.mark.parametrize("frames", [("base", "platform"), ("platform", "base")])
def test_a_wrench_replaces_the_one_before_also_in_the_other_frame(frames):
    loads = robot("six_rfs").default_loads
    for frame, size in zip(frames, (1.0, 2.0), strict=True):
        message = WrenchStamped()
        message.header.frame_id, message.wrench.force.x = frame, size
        loads = with_wrench(loads, message, FRAMES)
    found = {"base": loads.wrench_world, "platform": loads.wrench_body}
    np.testing.assert_array_equal(found[frames[0]], 0.0)
    np.testing.assert_array_equal(found[frames[1]], [0, 0, 0, 2.0, 0, 0])


def test_the_platform_frame_is_its_pose():
    pose = platform_pose(solve_home(robot("six_rfs")), FRAMES, Time(sec=5))
    transform = transform_of(pose, "platform")
    assert (transform.header.frame_id, transform.child_frame_id) == ("base", "platform")
    assert transform.header.stamp.sec == 5
    moved, point = transform.transform.translation, pose.pose.position
    assert (moved.x, moved.y, moved.z) == (point.x, point.y, point.z)
    assert transform.transform.rotation == pose.pose.orientation


def test_a_partial_setpoint_keeps_the_others():
    planar = robot("rfrfr")
    message = JointState(name=["motor2"], position=[0.4])
    np.testing.assert_array_equal(motor_setpoint(planar, message, np.array([1.0, 2.0])), [1.0, 0.4])


def test_joints_of_others_alone_are_named():
    message = JointState(name=["gripper", "lift"], position=[0.1, 0.2])
    with pytest.raises(InvalidRequest, match=r"\(motor1, motor2\), got gripper, lift"):
        measured_motors(robot("rfrfr"), message)


def test_measured_motors_are_found_among_others():
    planar = robot("rfrfr")
    names = ["gripper", "motor2", "motor1"]
    message = JointState(name=names, position=[np.nan, 0.5, 2.6])
    np.testing.assert_array_equal(measured_motors(planar, message), [2.6, 0.5])
    with pytest.raises(NonFiniteInput):
        measured_motors(planar, JointState(name=names, position=[0.0, 0.5, np.inf]))
    for wrong in (
        JointState(name=names[:2], position=[0.0, 0.5]),
        JointState(name=names, position=[0.0, 0.5]),
        JointState(name=names, position=[0.0, 0.5, 2.6, 2.7]),
        JointState(name=["motor1", "motor2", "motor1"], position=[1.0, 0.5, 1.0]),
    ):
        with pytest.raises(InvalidRequest):
            measured_motors(planar, wrong)


def test_every_measure_is_in_the_message():
    outcome = Drive(robot("delta")).tick()
    message = metrics_of(outcome)
    for measure, field in FIELDS.items():
        assert attrgetter(field)(message) == pytest.approx(outcome.assessment.value(measure)) != 0.0


def test_every_field_of_the_stream_is_what_it_is_called():
    home, thresholds = solve_home(robot("delta")), SETTINGS.thresholds
    assessment = Assessment(home, characteristic_length=0.3, solve_time=0.0125)
    verdict = Verdict(Status.JOINT_BOUND, "near its end", Action.SLOW, 0.25, "motor_range", 0.5)
    tick = Drive(robot("delta")).tick()
    outcome = replace(tick, assessment=assessment, verdict=verdict, state=State.ALIGNING)
    loop = LoopStatus(Loop.FROZEN, "it jumped", 0.7, 0.01, 0.02)
    told = StabilityStream().message(
        Moment(outcome, 0.0, (7, 8)),
        thresholds,
        FRAMES,
        setpoint_age=1.5,
        wrench_age=2.5,
        loop=loop,
    )
    locked, free = home.spectrum_locked.eigenvalues, home.spectrum_free.eigenvalues
    model = kinemato_statics(home)
    forward, inverse = (model.singularity(name, 0.3) for name in ("forward", "inverse"))
    expected = {
        "status": Status.JOINT_BOUND,
        "status_text": "near its end",
        "action": Action.SLOW,
        "speed_scale": 0.25,
        "state": State.ALIGNING,
        "converged": True,
        "residual": home.residual,
        "energy_criterion_applies": True,
        "index_locked": 0,
        "index_free": 1,
        "smallest_eigenvalues_locked": locked[:4],
        "smallest_eigenvalues_free": free[:4],
        "inverse_condition_number": locked[0] / locked[-1],
        "margin": home.margin,
        "margin_trend": 0.0,
        "margin_warning": thresholds["margin"].warning,
        "margin_stop": thresholds["margin"].stop,
        "characteristic_length": 0.3,
        "forward": singularity_message(home.robot, forward),
        "inverse": singularity_message(home.robot, inverse),
        "motor_range": assessment.motor_range,
        "effort_reserve": assessment.effort_reserve,
        "strain_reserve": assessment.strain_reserve,
        "model_error": error_of(home).distance,
        "model_error_warning": np.inf,
        "nearest_threshold": "motor_range",
        "distance_to_threshold": 0.5,
        "stiffness": message_matrix(home.robot, model.stiffness()).ravel(),
        "setpoint_age": 1.5,
        "wrench_age": 2.5,
        "solve_time": 0.0125,
        "loop": Loop.FROZEN,
        "loop_text": "it jumped",
        "measured_pose_age": 0.7,
        "position_error": 0.01,
        "rotation_error": 0.02,
    }
    assert {"header", *expected} == {*told.get_fields_and_field_types()}
    assert told.header == Header(stamp=Time(sec=7, nanosec=8), frame_id="base")
    for name, value in expected.items():
        np.testing.assert_array_equal(getattr(told, name), value, err_msg=name)


def test_every_field_of_an_equilibrium_is_what_it_is_called():
    made = robot("delta")
    wrenches = {"wrench_world": [0, 0, 0, 0.1, 0.2, 0.3], "wrench_body": [0, 0.01, 0, 0, 0, 0.4]}
    loads = made.default_loads.with_(gravity=[0.1, 0.2, -9.0], **wrenches)
    found = solve_forward(made, solve_home(made).motors + [0.1, 0.0, 0.05], loads=loads)
    told, stamp = EquilibriumMessage(), Time(sec=7, nanosec=8)
    fill_equilibrium(told, found, FRAMES, stamp, 0.0125, eigenvalues=True)
    expected = {
        "leg_coordinates": found.leg_coordinates,
        "multipliers": found.multipliers,
        "converged": True,
        "residual": found.residual,
        "iterations": found.iterations,
        "index_locked": found.index_locked,
        "index_free": found.index_free,
        "smallest_eigenvalue_locked": found.spectrum_locked.smallest,
        "smallest_eigenvalue_free": found.spectrum_free.smallest,
        "margin": found.margin,
        "energy": found.energy,
        "solve_time": 0.0125,
    }
    of_parts = {"header", "motors", "platform_in_base", "loads"}
    assert of_parts | expected.keys() == {*told.get_fields_and_field_types()}
    for name, value in expected.items():
        np.testing.assert_array_equal(getattr(told, name), value, err_msg=name)
    assert found.iterations and found.residual and found.index_free != found.index_locked
    header = Header(stamp=stamp, frame_id="base")
    assert told.header == told.motors.header == header
    assert told.motors.name == list(made.motor_names)
    for name, value in (("position", found.motors), ("effort", found.efforts)):
        np.testing.assert_array_equal(getattr(told.motors, name), value)
    np.testing.assert_array_equal(told.motors.velocity, np.zeros(3))
    np.testing.assert_array_equal(
        vector_of(told.platform_in_base.position), found.platform_position
    )
    turn = quaternion_of(told.platform_in_base.orientation)
    np.testing.assert_array_equal(turn, found.platform_quaternion)
    (own,) = told.loads
    np.testing.assert_array_equal(vector_of(own.gravity), loads.gravity)
    np.testing.assert_array_equal(wrench_of(own.wrench_in_base), loads.wrench_world)
    np.testing.assert_array_equal(wrench_of(own.wrench_in_platform), loads.wrench_body)


@pytest.mark.parametrize("reading", ["locked", "free"])
def test_every_field_of_an_answer_about_stability_is_what_it_is_called(reading):
    home, answer = solve_home(robot("delta")), CheckStability.Response()
    request = CheckStability.Request()
    request.motors_are = request.FREE if reading == "free" else request.LOCKED
    fill_stability(home, request, answer)
    found = spectrum(home, reading)
    assert answer.stable == (reading == "locked") and answer.energy_criterion_applies
    assert answer.index == found.index
    np.testing.assert_array_equal(answer.eigenvalues, found.eigenvalues[:6])
    np.testing.assert_array_equal(answer.margin, found.margin)
    assert answer.inverse_condition_number == found.inverse_condition_number
    motors = found.softest_motion[home.robot.motor_indices]
    np.testing.assert_array_equal(answer.softest_motors, motors)
    assert motors.any() == (reading == "free")
    platform = six_components(
        home.robot.platform_axes, found.softest_motion[home.robot.platform_indices]
    )
    np.testing.assert_array_equal(twist_of(answer.softest_platform), platform)


def test_loads_of_the_description_are_not_told():
    told = EquilibriumMessage()
    fill_equilibrium(told, solve_home(robot("delta")), FRAMES, Time(), 0.0, eigenvalues=False)
    assert not told.loads
    assert np.isnan(
        [told.margin, told.smallest_eigenvalue_locked, told.smallest_eigenvalue_free]
    ).all()


@pytest.mark.parametrize("held", ["motors", "pose", "efforts"])
def test_every_field_of_a_model_error_is_what_it_is_called(held):
    home = solve_home(robot("six_rfs"))
    found, told = error_of(home, held), model_error_message(home, held)
    assert (told.held, told.distance) == (held, found.distance)
    for name in ("position", "rotation"):
        np.testing.assert_array_equal(vector_of(getattr(told, name)), getattr(found, name))
    np.testing.assert_array_equal(told.motors, found.motors)
    np.testing.assert_array_equal(told.efforts, found.efforts)


def test_a_platform_that_is_to_be_seen_and_is_not_is_slowed_down(rfrfr):
    """The action was NONE, and that is all a supervisor looks at."""
    stream, outcome = StabilityStream(), rfrfr.tick()

    def told(unseen):
        message = told_of(stream, outcome, unseen=unseen)
        return message.action, message.status, message.status_text, message.speed_scale

    good = told("")
    assert good == (StabilityMetrics.ACTION_NONE, StabilityMetrics.STATUS_NO_WARNING, "stable", 1.0)
    why = "the measured pose jumped by 0.1"
    slow = (StabilityMetrics.ACTION_SLOW, StabilityMetrics.STATUS_STALE_COMMAND, why, BLIND)
    assert told(why) == slow
    assert told("") == good


def test_all_that_takes_long_is_measured_in_pieces_before_the_message(rfrfr, monkeypatch):
    """The message itself is made between two ticks."""
    stream, outcome = StabilityStream(), elsewhere(rfrfr, 0.01)
    assert finished(stream.measure(lambda: Moment(outcome, 0.0, (0, 0)))) == (5, outcome)

    def long(*_about, **_more):
        raise AssertionError("this takes long")

    with monkeypatch.context() as patch:
        for function in ("eigh", "eigvalsh", "slogdet"):
            patch.setattr(np.linalg, function, long)
        for method in ("singularity", "matrices"):
            patch.setattr(KinematoStatics, method, long)
        found = told_of(stream, outcome)
        assert finished(stream.measure(lambda: Moment(outcome, 0.0, (0, 0)))) == (0, outcome)
    expected = metrics_of(elsewhere(rfrfr, 0.01))
    assert repr(found) == repr(expected)  # with NaN in them they are not equal


def test_the_message_is_about_the_tick_it_was_begun_in_or_where_the_robot_stands_now(rfrfr):
    start, next_one, last = (elsewhere(rfrfr, way) for way in (0.0, 0.01, 0.02))
    moving = [replace(outcome, moved=True) for outcome in (start, next_one, last)]
    assert told_while(moving) == (5, moving[0])
    standing = replace(last, moved=False)
    assert told_while([*moving, standing]) == (10, standing)
    again = replace(standing, refusal=None)  # a halted robot goes on trying
    assert told_while([standing, again]) == (5, again)


def told_while(outcomes):
    """How many pieces there are and what is told if the robot does this meanwhile, one a piece."""
    outcomes = iter(outcomes)
    newest = [next(outcomes)]
    work = StabilityStream().measure(lambda: Moment(newest[0], 0.0, (0, 0)))

    def meanwhile():
        newest[0] = next(outcomes, newest[0])

    return finished(work, meanwhile)


def finished(work, meanwhile=lambda: None):
    """How many pieces there are, and which outcome is told."""
    pieces = 0
    while True:
        try:
            next(work)
        except StopIteration as end:
            return pieces, end.value.outcome
        pieces += 1
        meanwhile()


def elsewhere(drive, way):
    """A tick that led to where no other one did."""
    planar = robot("rfrfr")
    moved = solve_forward(planar, solve_home(planar).motors + way)
    return replace(drive.tick(), assessment=Assessment(moved), moved=False)


def test_legs_are_coloured_by_bending_strain_or_by_stability(rfrfr):
    outcome = rfrfr.tick()
    by_strain = markers_of(outcome, "strain").markers
    legs = [marker for marker in by_strain if marker.ns == "legs"]
    assert [marker.id for marker in legs] == [0, 1]
    for marker, shape in zip(legs, leg_shapes(outcome.assessment.equilibrium, 24), strict=True):
        curvature = bending_curvature(shape.curvature)
        red = [color.r - color.b for color in marker.colors]
        assert np.argmax(red) == np.argmax(curvature)
        assert np.argmin(red) == np.argmin(curvature)
    by_stability = markers_of(outcome, "stability").markers
    assert not by_stability[0].colors
    colors = []
    for action in (Action.NONE, Action.SLOW, Action.HALT):
        told = replace(outcome, verdict=replace(outcome.verdict, action=action))
        color = markers_of(told, "stability").markers[0].color
        colors.append([name for name in "rgb" if getattr(color, name) > 0.5])
    assert colors == [["g"], ["r", "g"], ["r"]]


@pytest.mark.parametrize("tolerance", [1e-6, 1e-5])
def test_a_model_that_is_less_exact_than_wanted_is_told(tolerance):
    """Modes are chosen near home; far from there the estimate exceeds the tolerance."""

    def wanted(content):
        content["strain"] = {"tolerance": tolerance}

    drive = Drive(changed_robot("rfrfr", wanted))
    home = metrics_of(drive.tick())
    assert home.model_error == error_of(drive.current.equilibrium).distance
    assert home.model_error_warning == 0.5 * tolerance
    assert home.model_error <= home.model_error_warning
    level, text = diagnosed(drive)
    assert (level, text) == (DiagnosticStatus.OK, f"{home.model_error:.1e} m")
    far = solve_forward(drive.robot, drive.current.equilibrium.motors + [0.35, -0.35])
    drive.current = Assessment(far)
    away = metrics_of(drive.tick())
    assert away.model_error > home.model_error
    assert away.model_error > away.model_error_warning
    level, text = diagnosed(drive)
    assert level == DiagnosticStatus.WARN
    assert text == f"{away.model_error:.1e} m, more than half of strain.tolerance"


def diagnosed(drive):
    """Level and words of the diagnostics of a follower."""
    session = SimpleNamespace(
        follower=drive.follower,
        present=SimpleNamespace(outcome=drive.outcomes[-1]),
        robot=drive.robot,
    )
    health = NodeHealth("active", {}, {}, late_ticks=0, commanders="")
    found = diagnostic_array("node", health, session, "", Time()).status[1]
    values = {value.key: value.value for value in found.values}
    return found.level, values["model error"]


def test_without_a_tolerance_no_error_is_warned_of():
    drive = Drive(robot("rfrfr"))
    message = metrics_of(drive.tick())
    assert message.model_error > 1e-7
    assert message.model_error_warning == np.inf
    assert diagnosed(drive)[0] == DiagnosticStatus.OK


def test_a_singular_solution_has_no_estimate(monkeypatch):
    from cpr_ros.messages import model_error

    def singular(equilibrium, held="motors"):
        raise CprError("singular")

    monkeypatch.setattr(model_error, "error_of", singular)
    home = solve_home(robot("rfrfr"))
    assert np.isnan(model_error.estimated_error(home))
    message = model_error.model_error_message(home, "pose")
    assert np.isnan(message.distance)
    assert message.held == "pose"


def test_links_and_joints_have_markers():
    outcome = Drive(robot("three_prs")).tick()
    by_name = {marker.ns: marker for marker in markers_of(outcome, "strain").markers}
    shapes = leg_shapes(outcome.assessment.equilibrium, 24)
    links, joints = by_name["links"], by_name["joints"]
    pieces = [piece for shape in shapes for piece in shape.rigid_pieces]
    ends = [end for piece in pieces for pair in pairwise(piece) for end in pair]
    assert (links.type, joints.type) == (Marker.LINE_LIST, Marker.SPHERE_LIST)
    widths = [by_name[name].scale.x for name in ("legs", "links", "joints")]
    np.testing.assert_allclose(np.divide(widths, widths[0]), [1.0, 2.0, 3.0])
    np.testing.assert_allclose([[p.x, p.y, p.z] for p in links.points], ends)
    places = [joint for shape in shapes for joint in shape.joints]
    np.testing.assert_allclose(
        [[p.x, p.y, p.z] for p in joints.points], [joint.position for joint in places]
    )
    assert [color.r < 0.5 for color in joints.colors] == [
        joint.motor is not None for joint in places
    ]


@pytest.mark.parametrize("size", [0.02, 1.0, 10.0])
def test_markers_are_as_thick_as_suits_the_size_of_the_robot(size):
    """Of a robot that fits into a hand, no joint hides the platform; of a large one, legs are seen."""

    def resized(content):
        content["rod"]["length"] *= size
        for leg in content["legs"]:
            leg["base"]["position"] = [size * value for value in leg["base"]["position"]]

    outcome = Drive(changed_robot("rfrfr", resized)).tick()
    for marker in markers_of(outcome, "strain").markers:
        assert 1 / 200 < marker.scale.x / size < 1 / 20


def test_clamped_tips_have_no_marker():
    outcome = Drive(robot("gough_stewart")).tick()
    markers = {marker.ns: marker for marker in markers_of(outcome, "strain").markers}
    assert "links" not in markers
    assert len(markers["joints"].points) == 6


def test_a_robot_without_an_inverse_problem_has_a_stream():
    """More motors than platform coordinates: the inverse measures are not numbers."""
    drive = Drive(uncontrolled_robot())
    outcome = drive.tick()
    message = metrics_of(outcome)
    assert np.isnan(message.inverse.smallest_singular_value)
    assert message.forward.smallest_singular_value > 0.0
    assert outcome.assessment.inverse_singularity == np.inf


@pytest.mark.parametrize("name", ["rfrfr", "six_rfs", "delta"])
def test_indices_count_the_negative_eigenvalues_that_are_told(name):
    """Motors at constant effort hold less; at home the delta falls as soon as none is held."""
    message = metrics_of(Drive(robot(name)).tick())
    locked, free = message.smallest_eigenvalues_locked, message.smallest_eigenvalues_free
    assert sum(value < 0.0 for value in locked) == message.index_locked
    assert sum(value < 0.0 for value in free) == message.index_free
    assert all(less < more for less, more in zip(free, locked, strict=True))


def test_a_platform_that_a_rigid_leg_holds_has_no_stiffness_in_messages():
    """All else is answered; a stiffness of motors that cannot be is refused as ever."""
    home, answer = solve_home(rigid_leg()), GetKinematoStatics.Response()
    fill_kinemato_statics(home, GetKinematoStatics.Request(), answer)
    assert np.isnan(answer.stiffness).all()
    assert np.isfinite(answer.compliance).all()
    fill_kinemato_statics(home, GetKinematoStatics.Request(motor_stiffness=[5.0] * 3), answer)
    assert np.isfinite(answer.stiffness).all()
    with pytest.raises(InvalidRequest, match="motor_stiffness"):
        fill_kinemato_statics(home, GetKinematoStatics.Request(motor_stiffness=[5.0]), answer)


def test_motors_that_hold_nothing_are_refused_in_messages():
    home, answer = solve_home(turntable()), GetKinematoStatics.Response()
    with pytest.raises(InvalidRequest, match=r"motor_stiffness: .* without any force"):
        fill_kinemato_statics(home, GetKinematoStatics.Request(motor_stiffness=[0.0]), answer)
    fill_kinemato_statics(home, GetKinematoStatics.Request(), answer)
    assert np.isfinite(answer.compliance).all()
