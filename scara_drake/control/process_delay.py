"""Delays inside the control process, and three readings of the paper's statement about them.

Section VII-C brings "time-varying inputs and state delay functions", zeta(t) = 100 sin t and
d(t) = 100 cos t, into the loop, without units and without saying where. They can be read as

- A: delays of the loop in samples of 1 ms, zero where negative: zeta of the input, d of the state;
- B: perturbations, zeta added to the input u and d to the state's equation; their sum peaks at 141;
- C: a delay zeta of the command on its way to the controller, in samples of 1 ms.
"""

import dataclasses
import math
from dataclasses import dataclass
from typing import Any, Final

from scara_drake import joints
from scara_drake.channel.delays import ConstantDelay, SineDelay
from scara_drake.common import checks

AMPLITUDE = 100.0  # of zeta and d; in B in units of u [m/s², rad/s²]
SAMPLE = 1e-3  # [s]
LONGEST = 2.5  # [s]


@dataclass
class ProcessDelay:
    """Delays of the signals of the control process; None is none.

    Each is a `SignalDelay`, which costs one tick beside its delay, also where that is zero: an
    output written at a tick is read at the next one. One tick more is borne by the gains of the
    paper; with two, say zero delays at `actuation` and at `measurement`, the mast limit-cycles with
    those of Table 12.

    Attributes:
        actuation: of the effort on its way to the plant, zeta(t).
        measurement: of the measured state on its way to the controller, d(t).
        reference: of the desired state on its way to the controller. Its velocity is delayed as it
            is, so it differs from the rate of the delayed position by the rate of the delay.
    """

    actuation: ConstantDelay | SineDelay | None = None
    measurement: ConstantDelay | SineDelay | None = None
    reference: ConstantDelay | SineDelay | None = None

    def check_together(self, name: str) -> None:
        """Check that no delay is longer than 2.5 s.

        Raises:
            ValueError: one is.
        """
        for field in dataclasses.fields(self):
            delay = getattr(self, field.name)
            if delay is not None and delay.maximum() > LONGEST:
                raise ValueError(
                    f"{name}.{field.name}: a delay of up to {delay.maximum():g} s, allowed 0 to "
                    f"{LONGEST:g} s"
                )


def perturbation_reading(joint: str | None = None, amplitude: float = AMPLITUDE) -> dict[str, Any]:
    """Return reading B as overrides of a scenario: zeta + d on one joint, or on every joint.

    A sin t + A cos t is one sine, of amplitude A sqrt(2) and phase pi / 4.

    Args:
        joint: such as "theta2"; None is every joint.
        amplitude: A, of zeta and of d [m/s², rad/s²].

    Raises:
        ValueError: no such joint.
    """
    if joint is not None:
        checks.choice("joint", joint, joints.JOINT_NAMES)
    acts = [joint in (None, name) for name in joints.JOINT_NAMES]
    return {
        "perturbation.amplitude": [math.sqrt(2.0) * float(amplitude) * on for on in acts],
        "perturbation.frequency": [1.0] * 6,
        "perturbation.phase": [math.pi / 4] * 6,
    }


def _sine(phase: float = 0.0) -> dict[str, Any]:
    amplitude = AMPLITUDE * SAMPLE
    return {"_tag": "!SineDelay", "amplitude": amplitude, "frequency": 1.0, "phase": phase}


# Overrides for `load_scenario`, by the name of the reading.
CONTROL_DELAY_READINGS: Final[dict[str, dict[str, Any]]] = {
    "A": {
        "process_delay.actuation": _sine(),
        "process_delay.measurement": _sine(math.pi / 2),
    },
    "B": perturbation_reading(),
    "C": {"process_delay.reference": _sine()},
}
