"""The wiring from the references and the measured state to the plant's forces.

::

    state_desired -> (reference_delay) -> (governor) -> controller -> (limit, delay, lag) -> plant
    state -> (encoder) -> (measurement_delay) -----------------^  (friction, perturbation) --^

Where a robot is supervised a guard follows the measurement, and brakes come before the plant.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.framework import DiagramBuilder, OutputPort

from scara_drake.channel.signal_delay import SignalDelay
from scara_drake.control.contact_estimate import ContactForceEstimator
from scara_drake.control.contract import make_controller
from scara_drake.control.effort_limit import EffortLimit
from scara_drake.plant.brakes import Brakes
from scara_drake.plant.joint_forces import JointForces
from scara_drake.supervision.measurement import MeasurementGuard
from scara_drake.wiring import Signals, chain, connect_by_name, outputs, plant_of
from scara_drake.wiring.live import add_gain_scale
from scara_drake.wiring.operators import first_reference

if TYPE_CHECKING:
    from scara_drake.scenario import Scenario

Array = NDArray[np.float64]


def add_control(
    builder: DiagramBuilder, scenario: Scenario, q_start: Array, signals: Signals
) -> Signals:
    """Add the controller, what it measures with, and what its references pass through."""
    period = scenario.time_step
    system = make_controller(scenario.controller, period)
    controller = builder.AddNamedSystem("controller", system)
    made = dict(outputs(controller))
    if not getattr(controller, "limited", False):
        made |= _limited(builder, made)
    state = _measured(builder, scenario, q_start, signals)
    if "drives_engaged" in signals:  # the robot is supervised
        guard = MeasurementGuard(np.concatenate([q_start, np.zeros(6)]), period)
        made["state_sensed"] = state
        state = chain(builder, "measurement_guard", guard, state)
    desired = signals["state_desired"]
    delays = scenario.process_delay
    if delays is not None and delays.reference is not None:
        delay = SignalDelay(delays.reference, first_reference(scenario, q_start), period)
        desired = chain(builder, "reference_delay", delay, desired)
    if scenario.governor is not None:
        governor = builder.AddNamedSystem("governor", scenario.governor.make_system(period))
        made |= connect_by_name(
            builder, governor, {**made, "state": state, "state_desired": desired}
        )
        desired = made["state_desired_governed"]
    builder.Connect(state, controller.GetInputPort("state"))
    builder.Connect(desired, controller.GetInputPort("state_desired"))
    add_gain_scale(builder, scenario, controller, signals)
    # A controller of the user's own need not say whether it observes.
    if getattr(scenario.controller, "observes_perturbation", False):
        estimator = builder.AddNamedSystem("contact_estimate", ContactForceEstimator())
        made |= connect_by_name(builder, estimator, {**made, "state": state})
    return signals | made


def _limited(builder: DiagramBuilder, made: Signals) -> Signals:
    """Lead the effort of a controller through the limits of the drives, and keep what it asks for.

    Every other part then sees, and the recording has, the effort that acts.
    """
    limit = builder.AddNamedSystem("effort_limit", EffortLimit("controller"))
    made = {"actuation_commanded": made["actuation"], **made}
    builder.Connect(made["actuation"], limit.GetInputPort("actuation_asked"))
    builder.Connect(made["actuation_commanded"], limit.GetInputPort("actuation_commanded"))
    return made | dict(outputs(limit))


def _measured(
    builder: DiagramBuilder, scenario: Scenario, q_start: Array, signals: Signals
) -> OutputPort:
    """Lead the plant's state through the sensors and their delay; return what is measured."""
    period, delays, state = scenario.time_step, scenario.process_delay, signals["state"]
    if scenario.drives.encoder is not None:
        encoder = scenario.drives.encoder.make_system(period, scenario.seed_of("encoder"))
        state = chain(builder, "encoder", encoder, state)
    if delays is not None and delays.measurement is not None:
        at_rest = np.concatenate([q_start, np.zeros(6)])
        delay = SignalDelay(delays.measurement, at_rest, period)
        state = chain(builder, "measurement_delay", delay, state)
    return state


def add_drives(
    builder: DiagramBuilder, scenario: Scenario, q_start: Array, signals: Signals
) -> Signals:
    """Lead the controller's effort through the drives to the plant."""
    period, delays, drives = scenario.time_step, scenario.process_delay, scenario.drives
    plant = plant_of(builder)
    made: Signals = {}
    actuation = signals["actuation"]
    if delays is not None and delays.actuation is not None:
        delay = SignalDelay(delays.actuation, np.zeros(6), period)
        actuation = chain(builder, "actuation_delay", delay, actuation)
    if drives.lag is not None:
        actuation = chain(builder, "actuator_lag", drives.lag.make_system(period), actuation)
        made["actuation_delivered"] = actuation
    if "drives_engaged" in signals:
        brakes = builder.AddNamedSystem("brakes", Brakes(period))
        connect_by_name(builder, brakes, {**signals, "actuation": actuation})
        actuation = brakes.GetOutputPort("actuation_braked")
    builder.Connect(actuation, plant.get_actuation_input_port())
    if drives.friction is not None:
        friction = drives.friction.make_system(period)
        made["friction_force"] = chain(builder, "joint_friction", friction, signals["state"])
    return signals | made


def add_forces(
    builder: DiagramBuilder, scenario: Scenario, q_start: Array, signals: Signals
) -> Signals:
    """Lead the forces on the joints, beside those of the drives, to the plant.

    Forces from outside come by two inputs of the Diagram, zero where they are not connected:
    `applied_generalized_force` and `applied_spatial_force`.
    """
    plant = plant_of(builder)
    forces: Signals = {
        name: signals[name] for name in ("generalized_force", "friction_force") if name in signals
    }
    if scenario.perturbation is not None:
        source = builder.AddNamedSystem("perturbation", scenario.perturbation.make_system())
        forces["perturbation_force"] = source.get_output_port()
    outside = plant.get_applied_generalized_force_input_port()
    if forces:
        total = builder.AddNamedSystem("joint_forces", JointForces())
        connect_by_name(builder, total, forces)
        builder.Connect(total.get_output_port(), outside)
        outside = total.GetInputPort("applied_generalized_force")
    builder.ExportInput(outside, "applied_generalized_force")
    builder.ExportInput(plant.get_applied_spatial_force_input_port(), "applied_spatial_force")
    return signals
