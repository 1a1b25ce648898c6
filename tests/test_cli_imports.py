"""The help is there at once: only the command that runs imports what it needs."""

import subprocess
import sys
from pathlib import Path

import scara_drake
from scara_drake import ik
from scara_drake.cli.parser import IK_METHOD, IK_METHODS, make_parser

HEAVY = [
    "pydrake",
    "starlette",
    "uvicorn",
    "numba",
    "xarray",
    "matplotlib",
    "optuna",
    "meshcat",
    "pygame",
    "netCDF4",
]
# The package without its front, which imports the simulator.
PROGRAM = """
import sys, types
package = types.ModuleType("scara_drake")
package.__path__ = [sys.argv[1]]
sys.modules["scara_drake"] = package
from scara_drake.cli.main import main
try:
    main(sys.argv[2:])
except SystemExit as ended:
    assert ended.code == 0
print("loaded:", *{name.partition(".")[0] for name in sys.modules})
"""


def loaded(*arguments):
    """Return the packages that the command line has loaded, and what it printed."""
    folder = str(Path(scara_drake.__file__).parent)
    command = [sys.executable, "-c", PROGRAM, folder, *arguments]
    run = subprocess.run(command, capture_output=True, text=True, check=True)
    out, _, names = run.stdout.rpartition("loaded:")
    return set(names.split()), out


def test_the_help_of_every_command_loads_nothing_heavy():
    for arguments in (["--help"], ["--version"], ["run", "-h"], ["ik", "-h"], ["tune", "-h"]):
        names, out = loaded(*arguments)
        assert out
        assert names.isdisjoint(HEAVY), arguments


def test_the_methods_in_the_help_are_those_there_are():
    assert list(IK_METHODS) == list(ik.METHODS)
    assert IK_METHOD in IK_METHODS


def test_every_command_has_a_module():
    parser = make_parser()
    lines = (
        "run x",
        "station x",
        "compile",
        "show",
        "diagrams",
        "ik --position 1 2 3",
        "tune x",
        "sweep x",
        "replay x.nc",
        "recover x.journal",
        "compare x.nc y.nc",
        "export x.nc",
    )
    for line in lines:
        options = parser.parse_args(line.split())
        module = __import__(options.module, fromlist=["run"])
        assert callable(module.run)
        assert options.module == f"scara_drake.cli.{options.command}"
