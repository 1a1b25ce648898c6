"""Compiles the kernels before the tests run in several processes.

numba's cache has no lock: two processes that compile the same kernel do the work twice, and the
index of one may be lost to the other's. What is not reached here is compiled by the test that
needs it.
"""

from scara_drake import ik, kinematics, load_scenario, simulate
from scara_drake.ik.solve import METHODS
from scara_drake.scenario import scenario_names

X_WE = kinematics.forward_kinematics([5.0, 0.3, 0.2, 0.4, 0.5, 0.1])


def compile_kernels() -> None:
    """Ask for the kernels of the solvers and of the shipped scenarios."""
    for method in METHODS:
        ik.solve(X_WE, method)
    ik.solve_all(X_WE)
    for name in scenario_names():
        simulate(load_scenario(name), duration=0.01)


if __name__ == "__main__":
    compile_kernels()
