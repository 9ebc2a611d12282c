# Copyright 2026 The cpr_ros authors
# SPDX-License-Identifier: Apache-2.0

"""The node: setpoint following, services, state and stability of one robot."""

from __future__ import annotations

import gc
import sys
import time
import traceback
from collections.abc import Callable
from functools import partial

import numpy as np
import rclpy
from numpy.typing import NDArray
from rcl_interfaces.msg import SetParametersResult
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.parameter import Parameter
from sensor_msgs.msg import JointState

from cpr_core import CprError, load_robot
from cpr_core.model.assessment import crossed_thresholds

from .following.news import News
from .following.supervision import Action, below_warnings
from .interface.diagnostics import NodeHealth
from .interface.first_measured import MEASURED
from .interface.interfaces import Interfaces
from .interface.outputs import Outputs, Stream
from .maps.map_folder import MapFolder
from .messages.transforms import Transforms
from .middleware.impossible_transitions import answer_impossible_transitions
from .middleware.late_clients import LateClients
from .middleware.publishers import other_publishers
from .middleware.waiting_requests import WaitingRequests
from .operation.announcements import Announcements
from .operation.between_ticks import BetweenTicks
from .operation.live_changes import apply_live
from .operation.session import Session
from .operation.starting_place import HELD
from .process.giving_way import GivingWay
from .process.in_pieces import InPieces
from .process.once_a_second import ONCE_A_SECOND
from .process.parts import Parts
from .process.periodic import Periodic
from .process.stop_signal import Stopped, StopSignal
from .process.ticking import Ticking
from .settings.declared_parameters import declare, undeclared
from .settings.node_arguments import closest, files_of_others
from .settings.node_settings import LiveParameters, live_parameters, live_problem
from .settings.parameter_calls import answer_parameter_calls
from .warming import warm_up
from .whereabouts import Whereabouts

__all__ = ["CprNode"]

#: How often the file of the last state is looked at: others may remove it [Hz].
_FILE_RATE = 1.0

#: How long the node gives way after a command [s]. After a pause others take longer, too.
_GIVING_WAY, _GIVING_WAY_AFTER_PAUSE = 2e-4, 5e-4
#: Part of a tick that it gives way at most.
_MOST_OF_TICK = 0.1


class CprNode(LifecycleNode):
    """Managed node around a :class:`Session`. One single-threaded executor serves everything."""

    def __init__(self, stop: StopSignal) -> None:
        """Declare the parameters and make the interfaces.

        Args:
            stop: Tells when the process is to end.

        Raises:
            CprError: Parameters that cannot be used together.
        """
        super().__init__("cpr_node")
        self.parameters = declare(self)
        problem = live_problem(self._live({}))
        if problem:
            raise CprError(problem)
        self.problem = ""  # why the last transition failed
        self._started = time.monotonic()
        self._stop = stop
        self._whereabouts: Whereabouts | None = None
        self._active, self._frozen = False, False
        self._streams, self._health = Periodic(), Periodic()
        self._late_clients = LateClients(self, time.monotonic)
        self._waiting = WaitingRequests(time.monotonic)
        self._last_action = Action.NONE  # that a supervisor was told
        self._ticking = Ticking(
            1.0 / self.parameters.tick_rate,
            self._tick,
            lambda: self._required_session().at_rest and self._announcements.at_rest,
        )
        self._telling = InPieces(self._ticking)
        self._operate(None)
        self._giving_way = GivingWay(_MOST_OF_TICK / self.parameters.tick_rate)
        prefix, names = self.parameters.frame_prefix, self.parameters.frames
        self.transforms = Transforms(self, *(prefix + name for name in names))
        self.outputs = Outputs(self, self.transforms, self.parameters)
        self.interfaces: Interfaces | None = None
        self._announcements = Announcements()
        self.add_on_set_parameters_callback(self._on_parameters)
        self.add_post_set_parameters_callback(self._log_parameters)
        self._health.begin(self._started)
        self._health.add(self.parameters.diagnostics_rate, self._publish_diagnostics)
        self._health.add(_FILE_RATE, self._look_after_file)
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
                if not self.problem:
                    self.get_logger().error("the node could not be activated")
                return False
        return True

    def destroy_node(self) -> None:
        """End what the node started, and the node."""
        if self.interfaces is not None:
            self.interfaces.close()
        super().destroy_node()
        # rclpy leaves it, and what DDS has in shared memory, to the end of Python, which may not come.
        self._state_machine.destroy_when_not_in_use()
        self._lose_whereabouts()

    def active_session(self) -> Session | None:
        """The robot in operation; None while the node is not active."""
        return self._session if self._active else None

    def _operate(self, session: Session | None) -> None:
        """Have this robot in operation, or none."""
        self._session = session
        between = () if session is None else (BetweenTicks(session, lambda: self._ticking.resting),)
        self._parts = Parts(
            (
                self._ticking,
                self._streams,
                self._health,
                self._late_clients,
                self._waiting,
                *between,
                self._telling,
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
            self._deactivate,
            lambda: super(CprNode, self).on_deactivate(state),
            lambda: self._announce(News(information="inactive: holds and is silent")),
        )

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Forget the robot."""
        return self._transition(
            self._forget,
            lambda: super(CprNode, self).on_cleanup(state),
            lambda: self._announce(News(information="cleaned up: the robot is forgotten")),
        )

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Be silent for good; the process ends with a signal."""
        return self._transition(
            self._forget,
            lambda: super(CprNode, self).on_shutdown(state),
            lambda: self._announce(News(information="shut down")),
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
            self.problem = str(error)
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
        frames, live = self.transforms.frames, self._live({})
        session = self._stop.wait_for(lambda: Session(robot, frames, self.parameters, live))
        index = session.solver.current.index
        logger.info(f"at home after {time.monotonic() - begin:.1f} s, index {index}")
        if index > 0:
            logger.warning(
                "home is unstable, no robot is there and no motion is followed from there: does every "
                "leg bow to the side it should?"
            )
        self._whereabouts = Whereabouts(self, self.parameters, session, self._stop, self._started)
        logger.info(self._stop.wait_for(self._whereabouts.begin))
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
        session = self._required_session()
        session.stand()
        self._announcements = Announcements()
        if self._whereabouts is not None:
            self._whereabouts.look()
        if self.interfaces is not None:
            self.interfaces.forget_messages()  # setpoints that came while it looked
        self._active = True
        now = time.monotonic()
        self._last_action = session.verdict(now).action
        self._ticking.start(now)
        self._streams.begin(now)
        for stream in self.outputs.streams:
            self._streams.add(stream.rate, partial(self._tell, stream, session), stream.wanted)
        self.outputs.description(session)
        self.get_logger().info("ready")

    def _deactivate(self) -> None:
        if self.interfaces is not None and self._session is not None:
            self.interfaces.stop_motions(self._session)
            if self._active and self._session.orders.hold_commands():
                self.get_logger().warning(f"commands were on their way: {HELD}, once active again")
        self._active = False
        self._ticking.stop()
        self._streams.begin(0.0)
        self._telling.stop()

    def _forget(self) -> None:
        self._deactivate()
        if self.interfaces is not None:
            self.interfaces.stop_maps()
        self._operate(None)
        self._lose_whereabouts()

    def _lose_whereabouts(self) -> None:
        if self._whereabouts is not None:
            self._whereabouts.close()
            self._whereabouts = None

    def _listen(self) -> None:
        """Offer services and take messages; from the first time on for ever."""
        if self.interfaces is None:
            frames, folder = self.transforms.frames, MapFolder.of(self.parameters)
            self.interfaces = Interfaces(
                self, frames, self.active_session, self._place, self._feel, folder, self._waiting
            )
            self.interfaces.apply(self._live({}))
            self._late_clients.watch()

    def _place(self, motors: NDArray[np.float64]) -> None:
        """Be where the motors, (n,), are measured; where that cannot be, be inactive and say why."""
        if self._whereabouts is None:
            return
        try:
            self.get_logger().info(self._whereabouts.place(motors))
            if other_publishers(self, MEASURED) > 1:
                self._required_session().moved_by_others.prove(time.monotonic())
        except Stopped:
            return
        except CprError as error:
            self.problem = str(error)
            self.get_logger().error(f"deactivated: {error}")
            self.trigger_deactivate()

    def _look_after_file(self) -> None:
        if self._whereabouts is not None:
            self._whereabouts.look_after_file()

    def _feel(self, session: Session, message: JointState, now: float) -> None:
        """Tell what pushes on the platform, where measured motors say so and somebody asks."""
        if self.outputs.wrench_wanted:
            self.outputs.felt_wrench(session, message, now)
            self._announce(session.felt.announcement(now))

    def _tick(self, now: float) -> None:
        session = self._required_session()
        outcome = session.tick(now, self._command, self._keep)
        self._announce(self._announcements.after_tick(outcome, now))
        if outcome.moved:
            self.outputs.step(session, now)
        before, self._last_action = self._last_action, session.verdict(now).action
        if self._last_action != before and self.outputs.stability.wanted(now):
            self._tell(self.outputs.stability, session)  # out of turn: a supervisor does not wait
        if outcome.home_missed:
            self.get_logger().error(
                "the motors are at home, but this is another equilibrium than home"
            )
        if self.interfaces is not None:
            self.interfaces.after_tick(session, now)

    def _command(self, motors: NDArray[np.float64], ahead: bool) -> None:
        """Send the motors, (n,), on their way, and give way to a controller on this computer."""
        self.outputs.motor_commands(motors)
        self._giving_way.sleep(_GIVING_WAY_AFTER_PAUSE if ahead else _GIVING_WAY)

    def _keep(self) -> None:
        """Remember where the robot is."""
        if self._whereabouts is not None:
            self._whereabouts.keep()

    def _announce(self, news: News) -> None:
        if news.warning:
            self.get_logger().warning(news.warning)
        if news.information:
            self.get_logger().info(news.information)

    def _tell(self, stream: Stream, session: Session) -> None:
        """Tell what is due of a stream, or begin to."""
        work = stream.tell(session, time.monotonic())
        if work is not None:
            self._telling.begin(stream.name, work)

    def _publish_diagnostics(self) -> None:
        session, now = self.active_session(), time.monotonic()
        commanders = ""
        if session is not None:
            commanders = self.outputs.other_commanders.look(now)
            unmeasured, again = session.senses.missing_motors(now), session.senses.motors_again(now)
            self._announce(self._announcements.of_motors(unmeasured, again=again))
            self._announce(self._announcements.of_wrench(session.senses.missing_wrench(now)))
            self._announce(self._announcements.of_commanders(commanders))
        if session is not None and self.outputs.wrench_wanted:
            self._announce(session.felt.announcement(now))
        dropped = self.interfaces.dropped if self.interfaces else None
        health = NodeHealth(
            life=self._state_machine.current_state[1],
            dropped=dropped.counts if dropped else {},
            newly_dropped=dropped.newest() if dropped else {},
            late_ticks=self._ticking.late,
            commanders=commanders,
        )
        self.outputs.diagnostics(health, session)

    def _required_session(self) -> Session:
        if self._session is None:
            raise CprError("the node is not configured")
        return self._session

    def _on_parameters(self, parameters: list[Parameter]) -> SetParametersResult:
        """Take over new values, all of one call together."""
        live = self._live({parameter.name: parameter for parameter in parameters})
        names = [parameter.name for parameter in parameters]
        problem = live_problem(live, names)
        if problem:
            return SetParametersResult(successful=False, reason=problem)
        if self._session is not None and apply_live(self._session, live, time.monotonic()):
            self.get_logger().info("parameters changed: the setpoint is forgotten")
        if self.interfaces is not None:
            self.interfaces.apply(live)
        if any(name.endswith(("_warning", "_stop")) for name in names):
            for line in crossed_thresholds(live.settings.thresholds):
                self.get_logger().warning(line)
        return SetParametersResult(successful=True)

    def _log_parameters(self, parameters: list[Parameter]) -> None:
        if parameters:
            told = ", ".join(f"{parameter.name} {parameter.value}" for parameter in parameters)
            self.get_logger().info(f"set: {told}")

    def _live(self, changed: dict[str, Parameter]) -> LiveParameters:
        return live_parameters(lambda name: (changed.get(name) or self.get_parameter(name)).value)
