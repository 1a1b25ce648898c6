"""Evidence of stability: poles, delay margins, Lyapunov's function, robustness, certificates."""

from scara_drake.stability.certificates import Certificate, Certificates, certify
from scara_drake.stability.delay_margin import (
    arm_onset,
    crossover,
    delay_margin,
    mass_ratios,
    onset,
    phase_margin,
    simulated_onset,
    spectral_radius,
)
from scara_drake.stability.linear import (
    Linearised,
    closed_loop_poles,
    layer_matrix,
    layer_poles,
    least_mass_ratio,
    linearise,
    sliding_poles,
)
from scara_drake.stability.lyapunov import lyapunov, perturbation
from scara_drake.stability.robustness import CONTROLLERS, VARIATIONS, robustness_map

__all__ = [
    "CONTROLLERS",
    "VARIATIONS",
    "Certificate",
    "Certificates",
    "Linearised",
    "arm_onset",
    "certify",
    "closed_loop_poles",
    "crossover",
    "delay_margin",
    "layer_matrix",
    "layer_poles",
    "least_mass_ratio",
    "linearise",
    "lyapunov",
    "mass_ratios",
    "onset",
    "perturbation",
    "phase_margin",
    "robustness_map",
    "simulated_onset",
    "sliding_poles",
    "spectral_radius",
]
