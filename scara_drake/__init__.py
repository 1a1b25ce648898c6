"""Bilateral teleoperation of a 6-DOF SCARA for nuclear dismantling, as a Drake Diagram."""

from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scara_drake.common.kernel_cache import prepare_kernel_cache

prepare_kernel_cache(Path(__file__).parent)  # before any kernel is loaded

from scara_drake import kinematics  # noqa: E402 - see above
from scara_drake.exports.formats import export  # noqa: E402
from scara_drake.operator.trace import save_trace  # noqa: E402
from scara_drake.recordings.files import load_recording, save_recording  # noqa: E402
from scara_drake.recordings.table import to_table  # noqa: E402

# Without Drake, which has no wheel for Windows, recordings can still be read and replayed.
try:
    import pydrake as _drake  # noqa: F401 - whether it is there
except ModuleNotFoundError:
    pass
else:
    from scara_drake import ik
    from scara_drake.diagram import make_diagram
    from scara_drake.metrics.judgement import verdict
    from scara_drake.recordings.recorder import recording
    from scara_drake.scenario import Scenario, load_scenario
    from scara_drake.simulation.many import simulate_many
    from scara_drake.simulation.run import simulate
    from scara_drake.studies.study import Study, load_study
    from scara_drake.studies.sweep import sweep

__version__ = version("scara-drake")

__all__ = [
    "Scenario",
    "Study",
    "__version__",
    "compare",
    "export",
    "ik",
    "kinematics",
    "load_recording",
    "load_scenario",
    "load_study",
    "make_diagram",
    "metrics",
    "plotting",
    "recording",
    "save_recording",
    "save_trace",
    "simulate",
    "simulate_many",
    "sweep",
    "to_table",
    "verdict",
]

if TYPE_CHECKING:
    from scara_drake import metrics, plotting
    from scara_drake.comparison import compare
else:

    def __getattr__(name: str) -> Any:
        """Import what takes a while to import when it is asked for."""
        if name in ("metrics", "plotting"):
            return import_module(f"{__name__}.{name}")
        if name == "compare":
            return import_module(f"{__name__}.comparison").compare
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
