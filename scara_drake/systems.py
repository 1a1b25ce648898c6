"""The LeafSystems of the package, gathered; each lives with its subject."""

from scara_drake.control.integral_sliding_mode import IntegralSlidingModeController
from scara_drake.control.pid import PidController
from scara_drake.control.sliding_mode import SlidingModeController
from scara_drake.drives import ActuatorLagSystem, JointFrictionSystem
from scara_drake.encoder import EncoderSystem
from scara_drake.environment import ImpedanceContact
from scara_drake.ik.system import InverseKinematicsSystem
from scara_drake.perturbation import JointPerturbationSource
from scara_drake.reference import JointMotionSource
from scara_drake.teleop.haptics import HapticOutput
from scara_drake.teleop.joystick import JoystickSource
from scara_drake.teleop.kinesthetic import KinestheticOutput
from scara_drake.teleop.mapping import JoystickToPose
from scara_drake.teleop.packet_channel import PacketChannel
from scara_drake.teleop.signal_delay import SignalDelay

__all__ = [
    "ActuatorLagSystem",
    "EncoderSystem",
    "HapticOutput",
    "ImpedanceContact",
    "IntegralSlidingModeController",
    "InverseKinematicsSystem",
    "JointFrictionSystem",
    "JointMotionSource",
    "JointPerturbationSource",
    "JoystickSource",
    "JoystickToPose",
    "KinestheticOutput",
    "PacketChannel",
    "PidController",
    "SignalDelay",
    "SlidingModeController",
]
