# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The node: its parameters, its life cycle, and what the thread that spins looks after."""

from __future__ import annotations

import gc
import sys
import time
import traceback
from collections.abc import Callable

import rclpy
from rcl_interfaces.msg import SetParametersResult
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.parameter import Parameter

from cpr_core import CprError, load_robot
from cpr_core.model.assessment import crossed_thresholds

from .following.supervision import below_warnings
from .interface.interfaces import Interfaces
from .interface.outputs import Outputs
from .maps.map_folder import MapFolder
from .messages.transforms import Transforms
from .middleware.impossible_transitions import answer_impossible_transitions
from .middleware.late_clients import LateClients
from .middleware.waiting_requests import WaitingRequests
from .operated_robot import OperatedRobot
from .operation.between_ticks import BetweenTicks
from .operation.session import Session
from .process.once_a_second import ONCE_A_SECOND
from .process.parts import Parts
from .process.periodic import Periodic
from .process.stop_signal import StopSignal
from .settings.declared_parameters import declare, live_values, undeclared
from .settings.node_arguments import closest, files_of_others
from .settings.node_settings import live_problem
from .settings.parameter_calls import answer_parameter_calls
from .warming import warm_up
from .whereabouts import Whereabouts

__all__ = ["CprNode"]

#: How often the file of the last state is looked at: others may remove it [Hz].
_FILE_RATE = 1.0


class CprNode(LifecycleNode):
    """Managed node around one robot. One single-threaded executor serves everything.

    Attributes:
        parameters: Those that are fixed at start.
        transforms: Names of the frames, and who sends them.
        robot: What the node operates.
    """

    def __init__(self, stop: StopSignal) -> None:
        """Declare the parameters and make the interfaces.

        Args:
            stop: Tells when the process is to end.

        Raises:
            CprError: Parameters that cannot be used together.
        """
        super().__init__("cpr_node")
        self.parameters = declare(self)
        problem = live_problem(live_values(self))
        if problem:
            raise CprError(problem)
        self._problem = ""  # why the last transition failed
        self._started = time.monotonic()
        self._stop = stop
        self._frozen = False
        prefix, names = self.parameters.frame_prefix, self.parameters.frames
        self.transforms = Transforms(self, *(prefix + name for name in names))
        outputs = Outputs(self, self.transforms, self.parameters)
        self.robot = OperatedRobot(self, outputs, self.parameters.tick_rate)
        self._health = Periodic()
        self._late_clients = LateClients(self, time.monotonic)
        self._waiting = WaitingRequests(time.monotonic)
        self._operate(None)
        self.add_on_set_parameters_callback(self._on_parameters)
        self.add_post_set_parameters_callback(self._log_parameters)
        self._health.begin(self._started)
        self._health.add(self.parameters.diagnostics_rate, self._publish_diagnostics)
        self._health.add(_FILE_RATE, self.robot.look_after_file)
        answer_impossible_transitions(self)
        answer_parameter_calls(self)
        self._late_clients.watch()
        for name in undeclared(self):
            self.get_logger().warning(f"unknown parameter {name}{closest(name)}; it is left aside")
        for line in files_of_others(sys.argv[1:], self.get_fully_qualified_name()):
            self.get_logger().warning(line)
        if not self.parameters.autostart:
            self._listen()
            self.get_logger().info("unconfigured: autostart is off, ~/change_state begins")

    def start(self) -> bool:
        """Configure and activate, unless a signal comes; False if that failed: the log says why."""
        for transition in (self.trigger_configure, self.trigger_activate):
            done = transition() == TransitionCallbackReturn.SUCCESS
            if self._stop.requested or not rclpy.ok():
                return True
            if not done:
                if not self._problem:
                    self.get_logger().error("the node could not be activated")
                return False
        return True

    def destroy_node(self) -> None:
        """End what the node started, and the node."""
        if self.robot.interfaces is not None:
            self.robot.interfaces.close()
        super().destroy_node()
        # rclpy leaves it, and what DDS has in shared memory, to the end of Python, which may not come.
        self._state_machine.destroy_when_not_in_use()
        self.robot.lose_whereabouts()

    def _operate(self, session: Session | None) -> None:
        """Have this robot in operation, or none."""
        self.robot.session, ticking = session, self.robot.ticking
        between = () if session is None else (BetweenTicks(session, lambda: ticking.resting),)
        self._parts = Parts(
            (
                ticking,
                self.robot.streams,
                self._health,
                self._late_clients,
                self._waiting,
                *between,
                self.robot.telling,
            ),
            self.log_exception,
        )

    def do_what_is_due(self) -> None:
        """Tick and publish; whoever spins calls it after every callback, and when something is due."""
        self._parts.look()

    def log_exception(self) -> None:
        """Tell what was raised just now, which is not to end the node."""
        if rclpy.ok():
            self.get_logger().error(traceback.format_exc(), **ONCE_A_SECOND)

    def until_due(self) -> float:
        """Time until something is due [s]."""
        return max(0.0, self._parts.due - time.monotonic())

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Load the robot, find its home and compile the kernels."""
        return self._transition(self._configure, lambda: super(CprNode, self).on_configure(state))

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Take setpoints, publish, answer."""
        return self._transition(
            lambda: None, lambda: super(CprNode, self).on_activate(state), self._activate
        )

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Hold and be silent; where the robot is stays known."""
        return self._transition(
            self.robot.deactivate,
            lambda: super(CprNode, self).on_deactivate(state),
            lambda: self.get_logger().info("inactive: holds and is silent"),
        )

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Forget the robot."""
        return self._transition(
            self._forget,
            lambda: super(CprNode, self).on_cleanup(state),
            lambda: self.get_logger().info("cleaned up: the robot is forgotten"),
        )

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Be silent for good; the process ends with a signal."""
        return self._transition(
            self._forget,
            lambda: super(CprNode, self).on_shutdown(state),
            lambda: self.get_logger().info("shut down"),
        )

    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Be unconfigured again."""
        return self._transition(self._forget, lambda: super(CprNode, self).on_error(state))

    def _transition(
        self,
        first: Callable[[], None],
        inherited: Callable[[], TransitionCallbackReturn],
        last: Callable[[], None] = lambda: None,
    ) -> TransitionCallbackReturn:
        """A transition that says why it failed; rclpy swallows exceptions."""
        try:
            first()
            result = inherited()
            last()
        except Exception as error:
            self._problem = str(error)
            if rclpy.ok() and not self._stop.requested:
                text = str(error) if isinstance(error, CprError) else traceback.format_exc()
                self.get_logger().error(text)
            return TransitionCallbackReturn.FAILURE
        return result

    def _configure(self) -> None:
        try:
            self._set_up()
        except Exception:
            self._forget()  # rclpy calls nothing: a retry would find the state file locked by this one
            raise

    def _set_up(self) -> None:
        logger, begin = self.get_logger(), time.monotonic()
        robot = self._stop.wait_for(
            lambda: load_robot(self.parameters.robot, modes=self.parameters.modes or None)
        )
        self.parameters.check_tracker(robot)
        logger.info(f"{robot.description.source}: motors {', '.join(robot.motor_names)}")
        logger.info("finding home (after an installation the kernels are compiled, about a minute)")
        frames, live = self.transforms.frames, live_values(self)
        session = self._stop.wait_for(lambda: Session(robot, frames, self.parameters, live))
        index = session.solver.current.index
        logger.info(f"at home after {time.monotonic() - begin:.1f} s, index {index}")
        if index > 0:
            logger.warning(
                "home is unstable, no robot is there and no motion is followed from there: does every "
                "leg bow to the side it should?"
            )
        whereabouts = Whereabouts(self, self.parameters, session, self._stop, self._started)
        self.robot.whereabouts = whereabouts
        logger.info(self._stop.wait_for(whereabouts.begin))
        steps = warm_up(session, frames)
        while compiled := self._stop.wait_for(lambda: next(steps, "")):
            logger.info(f"compiled {compiled} after {time.monotonic() - begin:.1f} s")
        start, tracked = session.solver.current, session.tracking is not None
        for line in below_warnings(start, live.settings.thresholds, tracked=tracked):
            logger.warning(line)
        self._operate(session)
        self._listen()
        self._freeze_what_stays()
        logger.info("configured")

    def _freeze_what_stays(self) -> None:
        """Keep it from Python's collector, which would look at it all now and then, for 0.1 s.

        Nothing ticks meanwhile.
        """
        if self._frozen:  # robots of before do not stay
            gc.unfreeze()
        gc.collect()
        gc.freeze()
        self._frozen = True

    def _activate(self) -> None:
        self.robot.activate()
        self.get_logger().info("ready")

    def _forget(self) -> None:
        self.robot.deactivate()
        if self.robot.interfaces is not None:
            self.robot.interfaces.stop_maps()
        self._operate(None)
        self.robot.lose_whereabouts()

    def _listen(self) -> None:
        """Offer services and take messages; from the first time on for ever."""
        if self.robot.interfaces is None:
            frames, folder = self.transforms.frames, MapFolder.of(self.parameters)
            interfaces = Interfaces(self, frames, self.robot, folder, self._waiting)
            interfaces.apply(live_values(self))
            self.robot.interfaces = interfaces
            self._late_clients.watch()

    def _on_parameters(self, parameters: list[Parameter]) -> SetParametersResult:
        """Take over new values, all of one call together."""
        live = live_values(self, {parameter.name: parameter for parameter in parameters})
        names = [parameter.name for parameter in parameters]
        problem = live_problem(live, names)
        if problem:
            return SetParametersResult(successful=False, reason=problem)
        self.robot.apply(live)
        if any(name.endswith(("_warning", "_stop")) for name in names):
            for line in crossed_thresholds(live.settings.thresholds):
                self.get_logger().warning(line)
        return SetParametersResult(successful=True)

    def _publish_diagnostics(self) -> None:
        self.robot.publish_diagnostics(self._state_machine.current_state[1])

    def _log_parameters(self, parameters: list[Parameter]) -> None:
        if parameters:
            told = ", ".join(f"{parameter.name} {parameter.value}" for parameter in parameters)
            self.get_logger().info(f"set: {told}")
