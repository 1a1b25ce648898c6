"""Compiles the kernels before the tests run in several processes.

numba's cache has no lock: two processes that compile the same kernel do the work twice, and the
index of one may be lost to the other's. So what is done here side by side has little in common.
What is not reached here is compiled by the test that needs it.
"""

from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

from scara_drake import ik, kinematics, load_scenario, simulate
from scara_drake.ik.solve import METHODS
from scara_drake.operator.joint_motion import JointMotion
from scara_drake.scenario import scenario_names

X_WE = kinematics.forward_kinematics([5.0, 0.3, 0.2, 0.4, 0.5, 0.1])
SOLVERS = ""
COUPLINGS = [
    {"coupling": f"!{kind} {{}}"}
    for kind in ("Direct", "PositionDamping", "WaveVariables", "FourChannel", "ModelMediated")
]
PARTS = [
    {"channel.preset": "5g", "channel.playout": "recommended", "channel.codec": "{}"},
    {"channel.up": "!Packets {playout: !Playout {kind: adaptive}, shadow: {}}"},
    {"operator.policy": "!MoveAndWait {}"},
    {"operator.policy": "!Continuous {}"},
    {"operator.device": "touch"},
]


def compile_kernels() -> None:
    """Ask for the kernels of the solvers and of the shipped scenarios, in two processes.

    First the solvers beside the plant and the controllers, then what a supervisor adds beside all
    other scenarios, and at last what a bilateral scenario may have.
    """
    scenarios = {name: load_scenario(name) for name in scenario_names()}
    of_joints = [n for n, each in scenarios.items() if isinstance(each.operator, JointMotion)]
    supervised = [name for name, each in scenarios.items() if each.supervision is not None]
    others = [name for name in scenarios if name not in (*of_joints, *supervised)]
    with ProcessPoolExecutor(2, get_context("spawn")) as processes:
        for beside in (([SOLVERS], of_joints), (supervised, others)):
            list(processes.map(compile_some, beside))
        list(processes.map(compile_bilateral, (COUPLINGS, PARTS)))


def compile_some(names: Sequence[str]) -> None:
    """Compile the kernels of some scenarios, or those of the solvers."""
    for name in names:
        if name != SOLVERS:
            simulate(load_scenario(name), duration=0.01)
            continue
        for method in METHODS:
            ik.solve(X_WE, method)
        ik.solve_all(X_WE)


def compile_bilateral(settings: Sequence[dict[str, str]]) -> None:
    """Compile what the scenario `bilateral` needs with other settings, one after the other."""
    for each in settings:
        simulate(load_scenario("bilateral", each), duration=0.01, engine="drake")


if __name__ == "__main__":
    compile_kernels()
