"""The paper's figures, drawn from our data: `FIGURES[number].draw(experiment.data)`."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Final, NamedTuple

import xarray as xr
from matplotlib.figure import Figure

from scara_drake.experiments.plots import control, inverse_kinematics, table_7, teleoperation


class Picture(NamedTuple):
    """How a figure, a table or an equation of the paper is drawn.

    Attributes:
        experiment: its name in EXPERIMENTS.
        draw: of its data.
        caption: what is seen, and what differs from the paper, a sentence.
    """

    experiment: str
    draw: Callable[[xr.Dataset], Figure]
    caption: str


ik, arm, loop = inverse_kinematics, control, teleoperation
BOTH: Final = ("literal DPSOIJ", "default DPSOIJ")

# By the number of the paper's figure. Those that are no curves (1 to 7) are not here.
FIGURES: Final[dict[int, Picture]] = {
    8: Picture(
        "figures_8_9",
        partial(ik.convergence, solver="PSO"),
        "The best particle of PSO at each posture, in the first draw that meets both tolerances; "
        "the coefficients are those of our search, the paper's being lost.",
    ),
    9: Picture(
        "figures_8_9",
        partial(ik.convergence, solver="DPSO"),
        "The best particle of DPSO likewise: its errors rise where a stage begins, and all "
        "stages together take longer than PSO, where the paper has DPSO quicker.",
    ),
    10: Picture(
        "figures_10_11",
        partial(ik.path_errors, which="position"),
        "Errors of position along 50 points: all but IJ stay within the tolerance; in the paper "
        "IJ does too, at 1 mm.",
    ),
    11: Picture(
        "figures_10_11",
        partial(ik.path_errors, which="rotation"),
        "Errors of orientation along 50 points: DPSO and our default stay within the tolerance; "
        "the paper's own DPSOIJ starts within it and drifts out.",
    ),
    12: Picture(
        "figures_12_15",
        partial(ik.joint_path, joint="theta3", solvers=["DPSO"]),
        "Joint 3 by DPSO at each point, which jumps between mirrored postures on some paths and "
        "not on others; the paper shows one path that jumps.",
    ),
    13: Picture(
        "figures_12_15",
        partial(ik.joint_path, joint="theta4", solvers=["DPSO"]),
        "Joint 4 by DPSO on the same paths, which jumps too, at fewer points and by less.",
    ),
    14: Picture(
        "figures_12_15",
        partial(ik.joint_path, joint="theta3", solvers=BOTH),
        "Joint 3 by DPSOIJ, smooth as in the paper; the literal method leaves the path's own "
        "joints, for it keeps the position alone.",
    ),
    15: Picture(
        "figures_12_15",
        partial(ik.joint_path, joint="theta4", solvers=BOTH),
        "Joint 4 by DPSOIJ, smooth as in the paper, by the literal method and by our default.",
    ),
    16: Picture(
        "figures_16_17",
        arm.mast,
        "The mast on its polynomial, on which all runs lie over each other; the paper does not "
        "give its own.",
    ),
    17: Picture(
        "figures_16_17",
        arm.mast_error,
        "The error of the mast, which its weight leaves only where the law is taken in mm and N, "
        "and then by about half of the paper's 2 mm.",
    ),
    18: Picture(
        "figures_18_19",
        arm.sines,
        "Joints 2 and 4 on the paper's sine, with the nominal arm and with three that the law is "
        "not told of.",
    ),
    19: Picture(
        "figures_18_19",
        arm.sine_errors,
        "Their errors, where the paper has curves without a number; the start, from rest, goes "
        "beyond the axes.",
    ),
    20: Picture(
        "figures_20_27",
        loop.tool_way,
        "The way of the tool from above, over its command and its reference; the motion is ours, "
        "the paper's recording is not published.",
    ),
    21: Picture(
        "figures_20_27",
        loop.tool_error,
        "The distance of the tool from its command, and what each cause adds; the channel and "
        "our limiter of commands, which Figure 21 of the paper has not, make nearly all of it.",
    ),
    22: Picture(
        "figure_22",
        loop.answers,
        "Joint 2 by DPSO at each sample and by DPSOIJ, as in the paper; below, what the arm "
        "makes of it within its speeds.",
    ),
    23: Picture(
        "figures_20_27",
        partial(loop.joint, name="theta2"),
        "Joint 2 over its reference, by a recorded operator.",
    ),
    24: Picture(
        "figures_20_27",
        loop.actual_and_expected,
        "The error of joint 2: the actual one exceeds the expected one as in the paper, but by "
        "the lag of our limiter of commands, not by the inverse kinematics.",
    ),
    25: Picture(
        "figures_20_27",
        partial(loop.joint, name="theta4"),
        "Joint 4 over its reference, by a recorded operator.",
    ),
    26: Picture(
        "figures_20_27",
        loop.stick_errors,
        "The error of joint 4, which fluctuates more where the stick is taken as it is, as the "
        "paper says of its joystick.",
    ),
    27: Picture(
        "figures_20_27",
        loop.mast_error,
        "The error of the mast while an operator moves: with the law in mm and N it hangs below "
        "the reference, by about half of the paper's 2 mm, and by more while it rises.",
    ),
    28: Picture(
        "figure_28",
        loop.haptic,
        "The force that the operator feels, by each reading of the delay: it comes later than "
        "without one, except where 0.2 sin t is below zero and cut.",
    ),
    29: Picture(
        "figures_29_30",
        partial(arm.delayed, controllers=["ISMC"]),
        "Joint 2 by ISMC under each reading of zeta(t) and d(t): lost with the paper's numbers "
        "in the loop (A) or as a perturbation (B), late with the command (C), undisturbed where "
        "the drive can meet the perturbation.",
    ),
    30: Picture(
        "figures_29_30",
        partial(arm.delayed, controllers=["SMC", "SMC, high gain"]),
        "Joint 2 by SMC likewise: where the drive can meet the perturbation it errs more than "
        "ISMC, as in the paper; elsewhere the two are alike.",
    ),
}
# By the number of the table, and of the last of the equations, where a picture says more.
TABLES: Final[dict[int, Picture]] = {
    5: Picture(
        "table_5",
        ik.reached,
        "How near the best posture comes: with the mast all four are within the tolerances as in "
        "the paper, with the arm alone one is.",
    ),
    6: Picture(
        "table_6",
        ik.inverse_jacobian,
        "Where IJ ends from each random start: by all rows within both tolerances or at a "
        "compromise, by the position rows mostly at the position with any orientation, which is "
        "what the paper's errors look like.",
    ),
    7: Picture(
        "table_7",
        table_7.table_7,
        "The candidates of the search by their coefficients: the lower, the nearer to all "
        "statements.",
    ),
    8: Picture(
        "table_8",
        ik.swarms,
        "Where PSO and DPSO end by each draw; unpolished, the tuned swarms stop just within the "
        "tolerances, and the paper's errors lie below.",
    ),
    10: Picture(
        "table_10",
        arm.step_responses,
        "What is left of a unit step under each disturbance, which decides whether ISMC or SMC "
        "settles first; circles are the paper's times.",
    ),
}
EQUATIONS: Final[dict[int, Picture]] = {
    31: Picture(
        "equivalent_control",
        arm.reaching,
        "Sigma of SMC falls into its layer under each disturbance below rho, and not under one "
        "beyond it; inside the layer it follows the disturbance.",
    ),
    39: Picture(
        "equivalent_control",
        arm.equivalent,
        "The control u1 of ISMC follows the perturbation, the closer the thinner the layer; "
        "sign(s), for which the paper's proof holds, has no layer.",
    ),
    42: Picture(
        "equivalent_control",
        arm.decay,
        "Sigma of ISMC decays as exp(-k t) under each disturbance below rho, the closer the "
        "thinner the layer.",
    ),
    51: Picture(
        "stability",
        arm.lyapunov,
        "V of each joint, which falls outside of the layer where the control exceeds the "
        "perturbation; inside, for which the paper's proof does not hold, it rises too.",
    ),
}
