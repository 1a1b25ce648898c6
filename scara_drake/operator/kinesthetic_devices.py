"""Kinesthetic devices that exist, as data for the simulated master.

The limits (force, stiffness and damping that can be rendered, radius of the workspace) are those
with which CHAI3D 3.2 describes each device to its programs (`cHapticDeviceInfo`). Mass, friction
and resolution are those of the makers' data sheets, quoted from memory, as far as `sheet` names
them; what it does not name is assumed. No maker states the viscous friction: all are assumed, low.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

OWN: Final = "own"  # a device that is described by the fields of the operator
CHAI3D: Final = "CHAI3D 3.2, cHapticDeviceInfo"
SHEET: Final = "data sheet of the maker, from memory"
ASSUMED: Final = "assumed"
_LIMITS: Final = ("force", "stiffness", "damping", "workspace")


@dataclass(frozen=True)
class KinestheticDevice:
    """One device; each axis has the same figures.

    Attributes:
        force: largest of the actuators [N].
        stiffness: largest that it can render [N/m].
        damping: largest that it can render [N s/m].
        workspace: radius [m].
        mass: apparent, at the tip [kg].
        friction: Coulomb's, at the tip [N].
        viscous: friction [N s/m].
        resolution: count of the encoders, at the tip [m].
        sheet: the names of those figures that are from a data sheet.
    """

    force: float
    stiffness: float
    damping: float
    workspace: float
    mass: float
    friction: float
    viscous: float
    resolution: float
    sheet: tuple[str, ...] = ()

    def source_of(self, figure: str) -> str:
        """Where a figure is from."""
        if figure in _LIMITS:
            return CHAI3D
        return SHEET if figure in self.sheet else ASSUMED


_ALL = ("mass", "friction", "resolution")
_FORCE_DIMENSION = ("resolution",)  # its sheets state neither mass nor friction
_OMEGA = KinestheticDevice(12.0, 5e3, 30.0, 0.075, 0.27, 0.2, 1.0, 1e-5, _FORCE_DIMENSION)

DEVICES: Final[dict[str, KinestheticDevice]] = {
    "touch": KinestheticDevice(3.3, 400.0, 4.0, 0.075, 0.045, 0.26, 0.1, 5.5e-5, _ALL),
    "omni": KinestheticDevice(3.3, 700.0, 5.0, 0.10, 0.045, 0.26, 0.1, 5.5e-5, _ALL),
    "desktop": KinestheticDevice(7.9, 1e3, 5.0, 0.10, 0.045, 0.06, 0.1, 2.3e-5, _ALL),
    "premium_1.5_6dof": KinestheticDevice(8.5, 800.0, 5.0, 0.12, 0.136, 0.04, 0.1, 3e-5, _ALL),
    "premium_3.0": KinestheticDevice(22.0, 1e3, 5.0, 0.25, 0.159, 0.2, 0.1, 2e-5, _ALL),
    "omega.3": _OMEGA,
    "omega.6": _OMEGA,
    "omega.7": _OMEGA,
    "sigma.7": KinestheticDevice(12.0, 4e3, 30.0, 0.075, 0.35, 0.2, 1.0, 1.5e-6, _FORCE_DIMENSION),
    "delta.3": KinestheticDevice(20.0, 5e3, 30.0, 0.15, 0.30, 0.3, 1.0, 2e-5, _FORCE_DIMENSION),
}
