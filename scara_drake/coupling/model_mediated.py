"""Model-mediated coupling: the slave sends a model of what it touches, the master renders it.

The slave fits equation (52), f = K (x - x_e) + B v, on each axis while there is contact, by
recursive least squares with forgetting (Xu et al., 2016)::

    theta += P phi (f - phi' theta) / (lambda + phi' P phi),   phi = [x, v, 1]

The master renders the newest model at its own rate, so no force crosses the channel and no delay is
in the loop that the hand feels. A model that changes under the hand would make a step of force:
the energy of the rendered spring may grow by `power` and no faster, beside the work of the hand.

The slave follows the master by a spring and a damper, as in `tdpa`: until the first model has
arrived, the master moves freely.
"""

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scara_drake.common import checks
from scara_drake.coupling.ends import (
    HEAD,
    HELD,
    NUMBER,
    OWN,
    PERIOD,
    Coupling,
    F,
    Kernel,
    X,
    admit,
    hold_velocity,
    meter,
    meter_device,
    receive,
)

Array = NDArray[np.float64]

STIFFNESS, DAMPING, DRIFT, SPEED, FADE, FORGET, TOUCH, LARGEST, POWER = range(OWN, OWN + 9)
# Payload up: x (3), v (3); down: models (3 x 4) of K, B, x_e and the side, +1 or -1 where the
# surface resists motion in that direction, 0 without a model.
UP_X, UP_V, UP_SIZE = 1, 4, 7
MODELS, MODEL, DOWN_SIZE = 1, 4, 13
MODEL_K, MODEL_B, MODEL_X, MODEL_SIDE = range(4)
# Memory of the master after the head: rendered rest positions (3).
RENDERED, MASTER_SIZE = HEAD, HEAD + 3
# Memory of the slave after the head, each axis: origin, samples, theta (3), P (9).
ORIGIN, SAMPLES, THETA, COVARIANCE, FIT = 0, 1, 2, 5, 14
SLAVE_SIZE = HEAD + 3 * FIT

# Units of the regressors, which make the three parameters alike: mm, dm/s, and 1.
UNITS = (1e-3, 0.1, 1.0)
FIRST_COVARIANCE, LARGEST_COVARIANCE = 1e3, 1e6
ENOUGH = 40.0  # samples, before a model is sent
MOVING = 1e-3  # [m/s]: a hold says nothing about K and B


@dataclass
class ModelMediated(Coupling):
    """A local model of the environment at the master.

    Attributes:
        stiffness: K_c from the received position to the tool [N/m].
        damping: B_c [N s/m].
        drift_gain: of the position error [1/s].
        max_speed: of the followed position at the device [m/s].
        fade_time: time constant of the received velocity while nothing arrives [s].
        forgetting: lambda of the least squares, each sample.
        touch_force: at the tool, above which there is contact [N].
        max_stiffness: that the master renders at most [N/m].
        power: at which a model may store energy under the hand [W].
    """

    stiffness: float = 1000.0  # [N/m]
    damping: float = 40.0  # [N s/m]
    drift_gain: float = 5.0  # [1/s]
    max_speed: float = 0.3  # [m/s]
    fade_time: float = 0.02  # [s]
    forgetting: float = 0.995
    touch_force: float = 0.5  # [N]
    max_stiffness: float = 1e4  # [N/m]
    power: float = 0.1  # [W]

    def validate(self, name: str) -> None:
        """Check the fields.

        Raises:
            ValueError: one line that names the field, its value and what is allowed.
        """
        super().validate(name)
        checks.number(f"{name}.stiffness", self.stiffness, 1.0, 1e5)
        checks.number(f"{name}.damping", self.damping, 0.0, 1e4)
        checks.number(f"{name}.drift_gain", self.drift_gain, 0.0, 100.0)
        checks.number(f"{name}.max_speed", self.max_speed, 1e-3, 10.0)
        checks.number(f"{name}.fade_time", self.fade_time, 1e-3, 10.0)
        checks.number(f"{name}.forgetting", self.forgetting, 0.9, 1.0)
        checks.number(f"{name}.touch_force", self.touch_force, 1e-3, 1e3)
        checks.number(f"{name}.max_stiffness", self.max_stiffness, 1.0, 1e5)
        checks.number(f"{name}.power", self.power, 0.0, 1e3)

    def kernels(self) -> tuple[Kernel, Kernel]:
        """The kernels of one tick at the master and at the slave."""
        return model_master, model_slave

    def sizes(self) -> tuple[int, int, int, int]:
        """Sizes of the packets up and down, and of the memories."""
        return UP_SIZE, DOWN_SIZE, MASTER_SIZE, SLAVE_SIZE

    def parameters(self, period: float) -> Array:
        """The constants of the kind, in the master's units."""
        scale = self.impedance_scale
        return np.array(
            [
                scale * self.stiffness,
                scale * self.damping,
                self.drift_gain,
                self.max_speed,
                math.exp(-period / self.fade_time),
                self.forgetting,
                self.force_scale * self.touch_force,
                self.max_stiffness,
                self.power,
            ]
        )


@njit(cache=True)
def fit_surface(x: float, v: float, f: float, forgetting: float, fit: Array) -> None:
    """One step of recursive least squares of f = K (x - x_e) + B v, in place.

    Args:
        x: [m].
        v: [m/s].
        f: [N].
        forgetting: lambda; 1 while the covariance is at its bound, so that it cannot blow up.
        fit: (14,), see the layout above; zero at first.
    """
    theta, P = fit[THETA : THETA + 3], fit[COVARIANCE:FIT].reshape((3, 3))
    if fit[SAMPLES] == 0.0:
        fit[ORIGIN] = x
        for i in range(3):
            P[i, i] = FIRST_COVARIANCE
    fit[SAMPLES] += 1.0
    phi = np.empty(3)
    phi[0], phi[1], phi[2] = (x - fit[ORIGIN]) / UNITS[0], v / UNITS[1], 1.0
    gain = np.zeros(3)
    for i in range(3):
        for j in range(3):
            gain[i] += P[i, j] * phi[j]
    if P[0, 0] + P[1, 1] + P[2, 2] > LARGEST_COVARIANCE:
        forgetting = 1.0
    scale = forgetting
    error = f
    for i in range(3):
        scale += phi[i] * gain[i]
        error -= phi[i] * theta[i]
    for i in range(3):
        theta[i] += gain[i] * error / scale
        for j in range(3):
            P[i, j] = (P[i, j] - gain[i] * gain[j] / scale) / forgetting


@njit(cache=True)
def read_surface(fit: Array, f: float, model: Array) -> None:
    """Write the model (4,) of a fit, if it is one; the force [N] tells the side."""
    stiffness = fit[THETA] / UNITS[0]
    if fit[SAMPLES] < ENOUGH or not stiffness > 0.0:
        return
    model[MODEL_K] = stiffness
    model[MODEL_B] = max(fit[THETA + 1] / UNITS[1], 0.0)
    model[MODEL_X] = fit[ORIGIN] - fit[THETA + 2] / stiffness
    model[MODEL_SIDE] = math.copysign(1.0, f)


@njit(cache=True)
def render(
    model: Array, x: float, v: float, rest: float, period: float, largest: float, power: float
) -> tuple[float, float]:
    """Return the force [N] of a model (4,) and the rest position [m] from which it is rendered.

    The rest position is that of the model, or nearer to the hand where its spring would otherwise
    hold more energy than before plus `power` times the period. The damping is at least what a
    spring needs that is sampled, and shown one to two periods late (Colgate).
    """
    side = model[MODEL_SIDE]
    if side == 0.0:
        return 0.0, x
    stiffness = min(model[MODEL_K], largest)
    held = max(side * (x - rest), 0.0)
    depth = side * (x - model[MODEL_X])
    if depth <= 0.0:
        return 0.0, model[MODEL_X]
    depth = min(depth, math.sqrt(held * held + 2.0 * power * period / stiffness))
    damping = max(model[MODEL_B], 2.5 * period * stiffness)
    return side * max(stiffness * depth + damping * side * v, 0.0), x - side * depth


@njit(cache=True)
def model_master(
    motion: Array,
    packet: Array,
    constants: Array,
    newest: Array,
    memory: Array,
    sent: Array,
    f: Array,
    energy: Array,
) -> None:
    """One tick at the master: render the newest models."""
    receive(packet, newest)
    meter_device(motion, f, constants, memory, energy)
    for i in range(3):
        f[i], memory[RENDERED + i] = render(
            newest[MODELS + MODEL * i : MODELS + MODEL * (i + 1)],
            motion[i],
            motion[3 + i],
            memory[RENDERED + i],
            constants[PERIOD],
            constants[LARGEST],
            constants[POWER],
        )
        sent[UP_X + i] = motion[i]
        sent[UP_V + i] = motion[3 + i]
    sent[NUMBER] += 1.0


@njit(cache=True)
def model_slave(
    motion: Array,
    f_env: Array,
    packet: Array,
    constants: Array,
    newest: Array,
    memory: Array,
    sent: Array,
    command: Array,
    energy: Array,
) -> None:
    """One tick at the slave: follow the master, and fit what is touched."""
    period, speed = constants[PERIOD], constants[SPEED]
    progress = receive(packet, newest)
    hold_velocity(progress, newest[UP_V : UP_V + 3], constants[FADE], memory)
    for i in range(3):
        v = memory[HELD + i] + constants[DRIFT] * (newest[UP_X + i] - memory[X + i])
        v = min(max(v, -speed), speed)
        meter(energy, i, -memory[F + i] * v * period)
        memory[X + i] += v * period
        f = constants[STIFFNESS] * (memory[X + i] - motion[i])
        f += constants[DAMPING] * (v - motion[3 + i])
        memory[F + i] = f
        admit(i, f, f_env[i], motion, constants, command)
        if abs(f_env[i]) > constants[TOUCH] and abs(motion[3 + i]) > MOVING:
            fit = memory[HEAD + FIT * i : HEAD + FIT * (i + 1)]
            fit_surface(motion[i], motion[3 + i], f_env[i], constants[FORGET], fit)
            read_surface(fit, f_env[i], sent[MODELS + MODEL * i : MODELS + MODEL * (i + 1)])
    sent[NUMBER] += 1.0
