"""The LeafSystems of the package, gathered; each lives with its subject."""

from scara_drake.channel.codec import Codec
from scara_drake.channel.live_delay import LiveDelay
from scara_drake.channel.packets import PacketChannel
from scara_drake.channel.shadow import RadioShadow
from scara_drake.channel.signal_delay import SignalDelay
from scara_drake.channel.watch import CommandWatchSystem
from scara_drake.control.contact_estimate import ContactForceEstimator
from scara_drake.control.effort_limit import EffortLimit
from scara_drake.control.gain_scale import GainScale
from scara_drake.control.governor import ReferenceGovernorSystem
from scara_drake.control.integral_sliding_mode import IntegralSlidingModeController
from scara_drake.control.inverse_dynamics import FiniteStates, IntegralAction
from scara_drake.control.observer_sliding_mode import ObserverSlidingModeController
from scara_drake.control.pid import PidController
from scara_drake.control.sliding_mode import SlidingModeController
from scara_drake.coupling.ends import MasterEnd, SlaveEnd
from scara_drake.display.annotations import SceneAnnotations
from scara_drake.display.task import TaskAnnotations
from scara_drake.environment import ImpedanceContact, PipeCutting
from scara_drake.ik.system import InverseKinematicsSystem
from scara_drake.operator.buzz import Buzz, FeltForce
from scara_drake.operator.device_encoder import DeviceEncoder
from scara_drake.operator.external import ExternalSource
from scara_drake.operator.haptics import HapticOutput
from scara_drake.operator.joint_motion import JointMotionSource
from scara_drake.operator.joystick import JoystickSource
from scara_drake.operator.kinesthetic import KinestheticOutput
from scara_drake.operator.mapping import JoystickToPose
from scara_drake.operator.master import SimulatedMaster
from scara_drake.operator.policy import OperatorPolicy
from scara_drake.operator.stick_filter import StickFilter
from scara_drake.operator.supervised_mapping import SupervisedMapping
from scara_drake.operator.supervisor import OperatorSupervisor
from scara_drake.operator.trainee import ToolPosition, TraineeSource
from scara_drake.plant.brakes import Brakes
from scara_drake.plant.drives import ActuatorLagSystem
from scara_drake.plant.encoder import EncoderSystem
from scara_drake.plant.friction import JointFrictionSystem
from scara_drake.plant.joint_forces import JointForces
from scara_drake.plant.perturbation import JointPerturbationSource
from scara_drake.recordings.recorder import SignalBundle
from scara_drake.stability.linear import ContinuousLayer
from scara_drake.station.feed import StationFeed
from scara_drake.supervision.arm_watch import ArmWatch
from scara_drake.supervision.energy import ChannelEnergy
from scara_drake.supervision.frames import (
    CommandFramePacker,
    CommandFrameSplitter,
    RobotReportPacker,
    RobotReportSplitter,
)
from scara_drake.supervision.link_watch import LinkWatch
from scara_drake.supervision.measurement import MeasurementGuard
from scara_drake.supervision.robot import RobotSupervisor

__all__ = [
    "ActuatorLagSystem",
    "ArmWatch",
    "Brakes",
    "Buzz",
    "ChannelEnergy",
    "Codec",
    "CommandFramePacker",
    "CommandFrameSplitter",
    "CommandWatchSystem",
    "ContactForceEstimator",
    "ContinuousLayer",
    "DeviceEncoder",
    "EffortLimit",
    "EncoderSystem",
    "ExternalSource",
    "FeltForce",
    "FiniteStates",
    "GainScale",
    "HapticOutput",
    "ImpedanceContact",
    "IntegralAction",
    "IntegralSlidingModeController",
    "InverseKinematicsSystem",
    "JointForces",
    "JointFrictionSystem",
    "JointMotionSource",
    "JointPerturbationSource",
    "JoystickSource",
    "JoystickToPose",
    "KinestheticOutput",
    "LinkWatch",
    "LiveDelay",
    "MasterEnd",
    "MeasurementGuard",
    "ObserverSlidingModeController",
    "OperatorPolicy",
    "OperatorSupervisor",
    "PacketChannel",
    "PidController",
    "PipeCutting",
    "RadioShadow",
    "ReferenceGovernorSystem",
    "RobotReportPacker",
    "RobotReportSplitter",
    "RobotSupervisor",
    "SceneAnnotations",
    "SignalBundle",
    "SignalDelay",
    "SimulatedMaster",
    "SlaveEnd",
    "SlidingModeController",
    "StationFeed",
    "StickFilter",
    "SupervisedMapping",
    "TaskAnnotations",
    "ToolPosition",
    "TraineeSource",
]
