# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The page of a running node in a real browser, over real DDS."""

import re
import signal
import subprocess
import sys
import threading
import time
from contextlib import contextmanager

import numpy as np
import pytest
import rclpy
from cpr_msgs.msg import StabilityMetrics
from geometry_msgs.msg import Point
from helpers.browser import Looker
from helpers.node_process import TIMEOUT, Client, NodeProcess, free_domain
from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.msg import ParameterValue
from rcl_interfaces.srv import GetParameters, SetParameters
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from visualization_msgs.msg import Marker, MarkerArray

import cpr_core
from cpr_core.viewing import motor_sliders
from cpr_ros.page.view_node import ViewNode
from cpr_ros.page.watched_node import Presence
from cpr_ros.process.own_domain import private_environment

pytestmark = pytest.mark.waits(seconds=35)


class ViewProcess:
    """A running cpr_view."""

    def __init__(self, domain):
        environment = private_environment() | {"ROS_DOMAIN_ID": str(domain)}
        self.process = subprocess.Popen(
            [sys.executable, "-m", "cpr_ros.cpr_view", "--port", "0"],
            stdout=subprocess.PIPE,
            text=True,
            env=environment,
        )
        self.address = re.search(r"http://\S+", self.process.stdout.readline())[0]

    def stop(self):
        self.process.send_signal(signal.SIGINT)
        assert self.process.wait(TIMEOUT) == 0
        self.process.stdout.close()


def started(tmp_path_factory, domain):
    process = NodeProcess(
        tmp_path_factory.mktemp("node") / "node.log",
        domain,
        ["-p", "robot:=rfrfr", "-p", "max_speed:=4", "-p", "start_from:=home"],
    )
    process.wait_for_log("ready")
    return process


@pytest.fixture(scope="module")
def domain():
    return free_domain()


@pytest.fixture(scope="module")
def view(domain, browser):
    """The page is there before the node is."""
    view = ViewProcess(domain)
    yield view
    view.stop()


@pytest.fixture(scope="module")
def looker(view, browser):
    looker = Looker(browser, view.address, "take control")
    yield looker
    looker.page.close()


@pytest.fixture(scope="module")
def client(domain):
    client = Client(domain)
    yield client
    client.close()


@contextmanager
def listening(client, kind, topic):
    """All messages that come."""
    received = []
    subscription = client.node.create_subscription(kind, topic, received.append, 10)
    yield received
    client.node.destroy_subscription(subscription)


def first_of(received, client, looker, good):
    """The first of them for which something holds, once there is one."""

    def spun():
        client.executor.spin_once(timeout_sec=0.05)
        return any(good(message) for message in received)

    looker.until(spun)
    return next(message for message in received if good(message))


def heard(client, looker, kind, topic, good):
    """The next message for which something holds."""
    with listening(client, kind, topic) as received:
        return first_of(received, client, looker, good)


MOTOR_SETPOINT = "/cpr_node/motor_setpoint"


def see_platform_at(looker, equilibrium):
    """Wait until the page has it there."""
    expected = equilibrium.platform_position
    looker.until(lambda: np.allclose(looker.position("/platform"), expected, rtol=0, atol=1e-9))


def see_node_at(looker, home):
    """Wait until a node is shown at home, and nobody else commands it."""
    looker.page.get_by_text("cpr_node is there").wait_for()
    looker.page.get_by_text("motor2").first.wait_for()
    looker.until(lambda: looker.visible("/robot/legs"))
    see_platform_at(looker, home)
    looker.page.get_by_text("NONE").wait_for()
    looker.page.get_by_text("setpoints may also come from: nobody").wait_for()


def see_slider_at(looker, position):
    thumb = looker.page.get_by_role("slider").first
    expected = pytest.approx(position, abs=1e-6)
    looker.until(lambda: float(thumb.get_attribute("aria-valuenow")) == expected)


def move_without_control(looker, client, home):
    """Nothing is sent, and the slider goes back."""
    thumb = looker.page.get_by_role("slider").first
    thumb.focus()
    thumb.press("ArrowRight")
    looker.page.get_by_text("nothing was sent").wait_for()
    thumb.press("End")
    assert client.node.count_publishers(MOTOR_SETPOINT) == 0
    see_slider_at(looker, home.motors[0])


def type_beside_a_slider(looker, client, motors):
    """Nothing is sent: every key would be a setpoint, 2 on the way to 2.70."""
    box = looker.page.locator("input.mantine-NumberInput-input").first
    box.click()
    box.press("Control+a")
    box.press_sequentially("2.70", delay=100)
    looker.page.get_by_text("nothing was sent: motor1 goes where").wait_for()
    see_slider_at(looker, motors[0])
    state = heard(client, looker, JointState, "/joint_states", lambda _: True)
    assert list(state.position) == list(motors)


#: Keys and a click that come at once when a page was held up; 50 ms after it has said anything it says
#: the first of them, and after 50 ms more, of those that came with it, the last.
TYPED_AND_PRESSED = """(field, [texts, label]) => new Promise(done => setTimeout(() => {
  const put = Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, 'value').set;
  for (const text of texts) {
    put.call(field, text);
    field.dispatchEvent(new Event('input', {bubbles: true}));
  }
  [...document.querySelectorAll('button')].find(button => button.innerText === label).click();
  setTimeout(done, 60); }, 60))"""


def type_and_press_at_once(looker, client, field):
    """Only what a button says is sent, not a number that was typed on the way to another one."""
    with listening(client, JointState, MOTOR_SETPOINT) as received:
        field.fill("2.7 0.3")
        looker.page.get_by_role("button", name="send 2.7 0.3").wait_for()
        field.evaluate(TYPED_AND_PRESSED, [["2.7 0.4", "2.7 0.45"], "send 2.7 0.3"])
        looker.page.get_by_role("button", name="send 2.7 0.4", exact=True).wait_for()
        field.fill("2.7 0.5")
        looker.press("send 2.7 0.5")
        first_of(received, client, looker, lambda _: True)
    assert [[*setpoint.position] for setpoint in received] == [[2.7, 0.5]]


def type_into_the_field(looker, client):
    """What is typed there is sent with a button that says it."""
    field = looker.field("numbers")
    field.fill("2,6")
    looker.press("nothing to send")
    looker.page.get_by_text("nothing was sent: motors: expected decimal points").wait_for()
    type_and_press_at_once(looker, client, field)
    looker.page.get_by_text("sent: motor1 to 2.7, motor2 to 0.5").wait_for()
    arrived = [2.7, 0.5]
    heard(client, looker, JointState, "/joint_states", lambda told: [*told.position] == arrived)
    see_slider_at(looker, 2.7)
    looker.page.get_by_role("slider").first.press("ArrowRight")
    near = [pytest.approx(2.7, abs=0.01), 0.5]
    told = heard(client, looker, JointState, "/joint_states", lambda told: told.position[0] > 2.7)
    assert [*told.position] == near


def move_with_control(looker, client, home):
    """The node goes there, and the page shows where it is."""
    looker.press("take control")
    looker.page.get_by_text("give control back").wait_for()
    see_slider_at(looker, home.motors[0])
    type_beside_a_slider(looker, client, home.motors)
    thumb = looker.page.get_by_role("slider").first
    for _ in range(30):
        thumb.press("ArrowRight")
    looker.page.get_by_text("sent: motor1").wait_for()
    moved = heard(
        client,
        looker,
        JointState,
        "/joint_states",
        lambda message: message.position[0] > home.motors[0] + 0.05,
    )
    assert moved.position[1] == home.motors[1]
    looker.until(lambda: not np.allclose(looker.position("/platform"), home.platform_position))
    looker.picture("node")
    type_into_the_field(looker, client)
    let_others_move_it(looker, client)
    looker.press("give control back")
    looker.page.get_by_text("take control").wait_for()


def let_others_move_it(looker, client):
    """Sliders go with the motors, and the next key is a step from there."""
    other = client.node.create_publisher(JointState, MOTOR_SETPOINT, 10)
    looker.until(lambda: other.get_subscription_count() == 1)
    other.publish(JointState(name=["motor1"], position=[2.4]))
    see_slider_at(looker, 2.4)
    looker.page.get_by_role("slider").first.press("ArrowRight")
    told = heard(client, looker, JointState, "/joint_states", lambda told: told.position[0] > 2.4)
    assert [*told.position] == [pytest.approx(2.4, abs=0.01), 0.5]
    client.node.destroy_publisher(other)


def see_who_else_commands(looker, client):
    """Who else may move it is named."""
    other = client.node.create_publisher(JointState, MOTOR_SETPOINT, 10)
    looker.page.get_by_text(client.node.get_name()).wait_for()
    client.node.destroy_publisher(other)


def test_a_node_is_shown_moved_lost_and_found_again(view, looker, client, domain, tmp_path_factory):
    assert "waiting for cpr_node" in looker.text()
    home = cpr_core.solve_home(cpr_core.load_robot("rfrfr"))
    node = started(tmp_path_factory, domain)
    try:
        see_node_at(looker, home)
        move_without_control(looker, client, home)
        move_with_control(looker, client, home)
        see_who_else_commands(looker, client)
        node.stop(signal.SIGKILL)
        looker.page.get_by_text("cpr_node is gone").wait_for()
        looker.page.get_by_text("nothing is known of the robot").wait_for()
        looker.picture("node_gone")
    finally:
        if node.process.poll() is None:
            node.stop()
    node = started(tmp_path_factory, domain)
    try:
        looker.page.get_by_text("cpr_node is back").wait_for()
        see_platform_at(looker, home)
        looker.picture("node_back")
        assert looker.complaints == []
    finally:
        assert node.stop() == 0


class Told:
    """What a node tells of its robot, without the node: all the time, however long a browser takes."""

    def __init__(self, client):
        self.node = node = client.node
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.descriptions = node.create_publisher(String, "/cpr_node/description", latched)
        self.states = node.create_publisher(JointState, "/joint_states", 10)
        self.markers = node.create_publisher(MarkerArray, "/cpr_node/leg_markers", 10)
        self.stability = node.create_publisher(StabilityMetrics, "/cpr_node/stability", 10)
        self.state = JointState()
        self.times = 0
        self.ended = threading.Event()
        self.telling = threading.Thread(target=self.tell)
        self.telling.start()

    def tell(self):
        """Where the motors are, and that the node is there: else control is given back."""
        metrics = StabilityMetrics(margin=0.9, margin_warning=0.2, margin_stop=0.1)
        while not self.ended.wait(0.02):
            self.states.publish(self.state)
            self.stability.publish(metrics)
            self.times += 1

    def describe(self, robot):
        self.descriptions.publish(String(data=robot.description.text))

    def move(self, robot):
        motors = cpr_core.solve_home(robot).motors.tolist()
        self.state = JointState(name=list(robot.motor_names), position=motors)

    def close(self):
        self.ended.set()
        self.telling.join()
        for publisher in (self.descriptions, self.states, self.markers, self.stability):
            self.node.destroy_publisher(publisher)


@pytest.fixture
def told(view, looker, client):
    told = Told(client)
    yield told
    told.close()


@pytest.mark.parametrize("names", [("rfrfr", "six_rfs"), ("six_rfs", "rfrfr")])
def test_another_robot_takes_the_place_of_the_first(told, looker, names):
    """Its motors are told a while after its description, and those of the first once more before."""
    first, second = (cpr_core.load_robot(name) for name in names)

    def sliders():
        return looker.page.get_by_role("slider").count()

    told.describe(first)
    told.move(first)
    looker.until(lambda: sliders() == first.motor_count)
    looker.press("take control")
    looker.until(lambda: "give control back" in looker.text())
    told.describe(second)
    looker.until(lambda: not sliders() and not looker.visible("/platform"))
    before = told.times
    looker.until(lambda: told.times > before + 10)  # motors of the first
    assert sliders() == 0
    looker.until(lambda: "another robot has come" in looker.text())
    told.move(second)
    looker.until(lambda: sliders() == second.motor_count)
    looker.until(lambda: "give control back" not in looker.text())
    looker.until(lambda: looker.visible("/platform"))


def test_who_gives_control_back_or_leaves_has_none(told, looker, view, browser):
    """A double click took it again; who opened the page next was in control with the first key."""
    robot = cpr_core.load_robot("rfrfr")
    told.describe(robot)
    told.move(robot)
    looker.until(lambda: looker.page.get_by_role("slider").count() == robot.motor_count)
    looker.press("take control")
    button = looker.page.get_by_text("give control back")
    button.wait_for()
    place = button.bounding_box()
    looker.page.mouse.dblclick(
        place["x"] + 0.5 * place["width"], place["y"] + 0.5 * place["height"], delay=60
    )
    looker.page.get_by_text("take control").wait_for()
    time.sleep(0.3)  # a second click would have shown by now
    assert "give control back" not in looker.text()
    time.sleep(1.0)
    looker.press("take control")
    looker.page.get_by_text("give control back").wait_for()
    looker.page.reload()  # nobody has the page meanwhile
    looker.until(lambda: "take control" in looker.text())
    looker.until(lambda: "nobody has the page open" in looker.text())


def test_nothing_that_is_published_ends_the_page(told, looker, view):
    robot = cpr_core.load_robot("rfrfr")
    told.describe(robot)
    told.move(robot)
    sliders = looker.page.get_by_role("slider")
    looker.until(lambda: sliders.count() == robot.motor_count)
    links = Marker(ns="links", points=[Point() for _ in range(3)])  # half a link
    looker.until(lambda: told.markers.get_subscription_count() == 1)
    told.markers.publish(MarkerArray(markers=[links]))
    looker.until(lambda: "the page failed" in looker.text())
    told.state.position[0] += 0.5
    expected = f"{told.state.position[0]:.3f}"
    looker.until(lambda: f"{float(sliders.first.get_attribute('aria-valuenow')):.3f}" == expected)
    assert view.process.poll() is None


def test_a_call_that_rclpy_raises_for_does_not_end_it(view, client):
    """A parameter of a type that there is not ended the process with a traceback."""
    wrong = SetParameters.Request(
        parameters=[ParameterMessage(name="use_sim_time", value=ParameterValue(type=99))]
    )
    caller = client.node.create_client(SetParameters, "/cpr_view/set_parameters")
    client.spin_until(caller.service_is_ready)
    caller.call_async(wrong)
    asked = GetParameters.Request(names=["use_sim_time"])
    answer = client.call(GetParameters, "/cpr_view/get_parameters", asked)
    assert [value.bool_value for value in answer.values] == [False]
    assert view.process.poll() is None
    client.node.destroy_client(caller)


def test_a_name_that_no_node_has_is_told(domain):
    done = subprocess.run(
        [sys.executable, "-m", "cpr_ros.cpr_view", "--port", "0", "--node", "cpr-node"],
        env=private_environment() | {"ROS_DOMAIN_ID": str(domain)},
        capture_output=True,
        text=True,
        timeout=60.0,
    )
    assert done.returncode == 1
    assert done.stdout == ""
    assert done.stderr.startswith("cpr_view: Invalid topic name")
    assert "Traceback" not in done.stderr


@pytest.fixture
def shown(domain):
    """A node of the page, in this process and without a browser."""
    rclpy.init(domain_id=domain, signal_handler_options=SignalHandlerOptions.NO)
    node = ViewNode("cpr_node", "127.0.0.1", 0)
    yield node
    node.page.close()
    node.destroy_node()
    rclpy.shutdown()


def test_a_slider_that_was_moved_before_is_no_step_away_from_where_nobody_sent_it(
    shown, monkeypatch
):
    """It stayed there in control, and the next key sent the robot there."""
    page, robot = shown.page, cpr_core.load_robot("rfrfr")
    home = cpr_core.solve_home(robot).motors.tolist()
    page.show_robot(robot, home)
    page.show_motors(home)
    slider = page._sliders._sliders[0].handle
    slider.value = 5.0  # by somebody, a moment before
    page._control.take()
    page.show_motors(home)
    assert slider.value == home[0]
    monkeypatch.setattr(motor_sliders, "_SETTING_OFF", 0.0)
    page._slid(0, 3.0)  # in control it is where it was sent, until others move the motor on
    for at, expected in ((home[0], 3.0), (3.0, 3.0), (3.5, 3.5), (3.0, 3.0), (home[0], home[0])):
        page.show_motors([at, home[1]])
        assert slider.value == expected
    page._slid(0, 3.0)
    page._control.give_back()
    page.show_motors(home)
    assert slider.value == home[0]


def test_a_slider_whose_setpoint_was_forgotten_goes_back_to_its_motor(shown, monkeypatch):
    """After a pause, or a hold, the next key sent the robot on, all the way."""
    monkeypatch.setattr(motor_sliders, "_SETTING_OFF", 0.0)
    page, robot = shown.page, cpr_core.load_robot("rfrfr")
    home = cpr_core.solve_home(robot).motors.tolist()
    page.show_robot(robot, home)
    page._control.take()
    page.show_motors(home)
    slider = page._sliders._sliders[0].handle

    def shown_at(state):
        shown._newest |= {"stability": StabilityMetrics(margin=0.9, state=state), "motors": home}
        shown._draw()
        page.show_motors(home)
        return slider.value

    for over in (
        StabilityMetrics.STATE_IDLE,
        StabilityMetrics.STATE_PAUSED,
        StabilityMetrics.STATE_STALE,
        StabilityMetrics.STATE_RETURNING,
    ):
        page._slid(0, 3.0)
        assert shown_at(over) == 3.0  # not sent yet
        page.take_asked()
        for waits in (
            StabilityMetrics.STATE_FOLLOWING,
            StabilityMetrics.STATE_HALTED,
            StabilityMetrics.STATE_ALIGNING,
        ):
            assert shown_at(waits) == 3.0
        assert shown_at(over) == home[0]


def test_another_page_is_named_and_this_one_is_not(shown):
    """Each said that setpoints come from nobody else."""
    other = rclpy.create_node("cpr_view")
    topic = MOTOR_SETPOINT.rpartition("/")[2]
    setpoints = other.create_publisher(JointState, MOTOR_SETPOINT, 10)
    assert shown._others() == [f"/cpr_view ({topic}, another page)"]
    shown._robot = cpr_core.load_robot("rfrfr")
    shown.page._control.take()
    shown._send()
    assert shown._setpoint is not None
    assert shown._others() == [f"/cpr_view ({topic}, another page)"]
    other.destroy_publisher(setpoints)
    assert shown._others() == []
    other.destroy_node()


def test_control_that_was_taken_before_there_was_a_robot_is_kept(shown):
    """It was given back, as another robot had come."""
    shown.page._control.take()
    for name, kept in (("rfrfr", True), ("six_rfs", False)):
        shown._hear_description(String(data=cpr_core.load_robot(name).description.text))
        assert shown.page.in_control == kept


def until_told(shown, executor, words, stability=None):
    """Spin until the page tells this of the node, which is heard as long as it publishes stability."""
    end = time.monotonic() + TIMEOUT
    while words not in shown.page._presence.content:
        if stability is not None:
            stability.publish(StabilityMetrics(margin=0.9))
        executor.spin_once(timeout_sec=0.02)
        assert time.monotonic() < end


def test_the_page_goes_on_while_simulated_time_stands_still(shown):
    """It showed a robot where it was before, and a node that had ended; it sent setpoints later."""
    assert shown.set_parameters([Parameter("use_sim_time", value=True)])[0].successful
    stability = shown.create_publisher(StabilityMetrics, "/cpr_node/stability", 10)
    executor = SingleThreadedExecutor()
    executor.add_node(shown)
    until_told(shown, executor, "is there", stability)
    until_told(shown, executor, "is gone")


def test_control_is_kept_while_the_page_is_held_up(shown, monkeypatch):
    """It was given back, as the node was gone: what came meanwhile had not been heard yet."""
    monkeypatch.setattr(shown, "_presence", Presence(silence=0.3))
    stability = shown.create_publisher(StabilityMetrics, "/cpr_node/stability", 10)
    executor = SingleThreadedExecutor()
    executor.add_node(shown)

    until_told(shown, executor, "is there", stability)
    shown.page._control.take()
    for _ in range(25):
        stability.publish(StabilityMetrics(margin=0.9))
        time.sleep(0.02)
    for _ in range(50):
        executor.spin_once(timeout_sec=0.02)
        stability.publish(StabilityMetrics(margin=0.9))
    assert shown.page.in_control
    assert "is there" in shown.page._presence.content
