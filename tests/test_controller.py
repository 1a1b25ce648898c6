"""The socket of a controller, and a law in plain Python in it."""

from dataclasses import dataclass

import numpy as np
import pytest
from leaf import outputs, ports, tick

from scara_drake import joints, load_scenario, robot, simulate
from scara_drake.common.block import Memory, Output
from scara_drake.common.fields import check, number
from scara_drake.control.controller import JointController, Law
from scara_drake.control.integral_sliding_mode import IntegralSlidingMode
from scara_drake.control.observer_sliding_mode import ObserverSlidingMode
from scara_drake.control.pid import Pid
from scara_drake.control.sliding_mode import SlidingMode

TS = 1e-3


def spring(state, state_desired, gains, count, actuation, actuation_commanded):
    stiffness, damping = gains
    lead = state_desired[:6] + TS * state_desired[6:]
    rate = state_desired[6:] - state[6:]
    wanted = stiffness * (lead - state[:6]) + damping * rate
    actuation_commanded[:] = robot.nominal_inertias() * wanted
    actuation[:] = np.clip(actuation_commanded, -joints.EFFORT, joints.EFFORT)
    count += 1.0


def double(count, twice):
    twice[:] = 2.0 * count


@dataclass
class Spring:
    """A user's own.

    Attributes:
        stiffness: of each joint.
        damping: likewise.
    """

    stiffness: float = number(2500.0, "1/s²", 0.0)
    damping: float = number(100.0, "1/s", 0.0)

    def make_system(self, period):
        return JointController(
            period,
            Law(update=spring),
            parameters={"gains": (self.stiffness, self.damping)},
            memory={"count": Memory(1)},
            outputs={"twice": Output(1, double)},
        )


def test_a_law_in_plain_python_runs_in_the_loop():
    gains = Spring()
    check(gains, "controller")
    scenario = load_scenario("joint_sine")
    scenario.controller = gains
    run = simulate(scenario, duration=0.2)
    k = 150
    q = run.q_desired[k - 1] + TS * run.v_desired[k - 1] - run.q_measured[k]
    wanted = 2500.0 * q + 100.0 * (run.v_desired[k - 1] - run.v_measured[k])
    np.testing.assert_allclose(
        run.tau_commanded[k], robot.nominal_inertias() * wanted, rtol=1e-9, atol=1e-9
    )


def test_its_ports_and_what_the_gate_does_of_itself():
    controller = Spring().make_system(TS)
    assert ports(controller) == (
        {"state": 12, "state_desired": 12, "engaged": 1},
        {"actuation": 6, "actuation_commanded": 6, "saturation": 6, "twice": 1},
    )
    context = controller.CreateDefaultContext()
    state = np.concatenate([joints.HOME, np.zeros(6)])
    controller.GetInputPort("state").FixValue(context, state)
    controller.GetInputPort("state_desired").FixValue(context, state + 0.01)
    tick(controller, context)
    assert (controller.GetOutputPort("actuation").Eval(context) != 0.0).all()
    controller.GetInputPort("engaged").FixValue(context, [0.0])
    tick(controller, context)
    np.testing.assert_array_equal(outputs(controller, context), [0.0] * 18 + [2.0])


def test_a_kernel_that_asks_for_what_nobody_named_is_refused():
    with pytest.raises(ValueError, match="JointController: argument 'count' of spring, allowed t,"):
        JointController(TS, Law(update=spring), {"gains": (1.0, 1.0)}, {})


@pytest.mark.parametrize(
    "gains", [IntegralSlidingMode(), ObserverSlidingMode(), SlidingMode(), Pid()]
)
def test_a_law_that_begins_with_the_drives_off_takes_over_as_one_that_stood_still(gains):
    """At rest on a reference at rest: whenever the drives come, the effort is that of the start."""
    efforts = []
    for off in (0, 5):
        controller = gains.make_system(TS)
        context = controller.CreateDefaultContext()
        state = np.concatenate([joints.HOME, np.zeros(6)])
        offset = np.concatenate([np.linspace(1e-5, 6e-5, 6), np.zeros(6)])
        controller.GetInputPort("state").FixValue(context, state)
        controller.GetInputPort("state_desired").FixValue(context, state + offset)
        engaged = controller.GetInputPort("engaged")
        engaged.FixValue(context, [0.0 if off else 1.0])
        controller.ExecuteInitializationEvents(context)
        if off:
            np.testing.assert_array_equal(controller.GetOutputPort("actuation").Eval(context), 0.0)
            for _ in range(off):
                tick(controller, context)
            engaged.FixValue(context, [1.0])
            tick(controller, context)
        efforts.append(controller.GetOutputPort("actuation_commanded").Eval(context).copy())
    np.testing.assert_allclose(efforts[0], efforts[1], rtol=1e-9, atol=1e-9)


def test_only_the_part_with_an_observer_says_that_it_observes():
    assert ObserverSlidingMode.observes_perturbation
    for part in (IntegralSlidingMode, SlidingMode, Pid):
        assert not getattr(part, "observes_perturbation", False)
