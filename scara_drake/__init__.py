"""Bilateral teleoperation of a 6-DOF SCARA for nuclear dismantling, as a Drake Diagram."""

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scara_drake.common.kernel_cache import prepare_kernel_cache

prepare_kernel_cache(Path(__file__).parent)  # before any kernel is loaded

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
    "summary",
    "sweep",
    "to_table",
    "verdict",
]

# The module of each name that is no module itself; what is imported takes seconds, so it is
# imported when it is asked for: the help of the command line is there at once.
_MODULES = {
    "Scenario": "scenario",
    "Study": "studies.study",
    "compare": "comparison",
    "export": "exports.formats",
    "load_recording": "recordings.files",
    "load_scenario": "scenario",
    "load_study": "studies.study",
    "make_diagram": "diagram",
    "recording": "recordings.recorder",
    "save_recording": "recordings.files",
    "save_trace": "operator.trace",
    "simulate": "simulation.run",
    "simulate_many": "simulation.many",
    "summary": "display.cards",
    "sweep": "studies.sweep",
    "to_table": "recordings.table",
    "verdict": "metrics.judgement",
}

if TYPE_CHECKING:
    from scara_drake import ik, kinematics, metrics, plotting
    from scara_drake.comparison import compare
    from scara_drake.diagram import make_diagram
    from scara_drake.display.cards import summary
    from scara_drake.exports.formats import export
    from scara_drake.metrics.judgement import verdict
    from scara_drake.operator.trace import save_trace
    from scara_drake.recordings.files import load_recording, save_recording
    from scara_drake.recordings.recorder import recording
    from scara_drake.recordings.table import to_table
    from scara_drake.scenario import Scenario, load_scenario
    from scara_drake.simulation.many import simulate_many
    from scara_drake.simulation.run import simulate
    from scara_drake.studies.study import Study, load_study
    from scara_drake.studies.sweep import sweep

    __version__: str
else:

    def __getattr__(name: str) -> Any:
        """Import what is asked for; without Drake, recordings can still be read and replayed."""
        if name == "__version__":
            found = import_module("importlib.metadata").version("scara-drake")
        elif name in _MODULES:
            found = getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)
        elif name in __all__:
            found = import_module(f"{__name__}.{name}")
        else:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        globals()[name] = found
        return found


def __dir__() -> list[str]:
    return sorted(__all__)
