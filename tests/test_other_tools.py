"""models/scara6.urdf in other programs: read in silence, and the same robot there as in Drake."""

from __future__ import annotations

import logging
import shutil
import subprocess
import warnings
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from kinds import of_kind
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import Context
from strategies import examples
from strategies.postures import postures
from urdf_readers import DYNAMIC, LINKS, READERS, TOOL, URDF, Dynamic, reader

# Extra `test` has this one; the others come with `benchmarks`.
SMALL = ("mujoco",)
# A motion of less than 1e-8 is none to yourdfpy.
ROUNDED = postures().map(lambda q: np.round(q, 6))
ARMATURE = np.diag([0.0, 40.0, 25.0, 20.0, 4.0, 1.0])  # of the drives [kg, kg m²]


def programs(names: list[str]) -> pytest.MarkDecorator:
    """The cases, a program each; the large ones are for `make test-slow`."""
    marks = {name: () if name in SMALL else (pytest.mark.slow,) for name in names}
    cases = [pytest.param(name, marks=marks[name]) for name in names]
    return pytest.mark.parametrize("program", cases)


def have(program: str) -> None:
    """Skip where a program is not installed."""
    pytest.importorskip(program, reason=f"{program} is not installed: extra `benchmarks`")


@cache
def plant_and_context() -> tuple[MultibodyPlant, Context]:
    """Drake's robot, read as strictly as Drake can."""
    plant = MultibodyPlant(time_step=0.0)
    parser = Parser(plant)
    parser.SetStrictParsing()
    parser.AddModels(Path(URDF))
    plant.Finalize()
    return plant, plant.CreateDefaultContext()


def at(q: np.ndarray) -> tuple[MultibodyPlant, Context]:
    plant, context = plant_and_context()
    plant.SetPositions(context, q)
    return plant, context


def test_drake_reads_it_strictly_and_says_nothing(caplog, capfd):
    plant_and_context.cache_clear()
    with caplog.at_level(logging.DEBUG, logger="drake"):
        plant, _ = plant_and_context()
    assert plant.num_positions() == 6
    assert [each.getMessage() for each in caplog.records if each.levelno > logging.INFO] == []
    assert capfd.readouterr() == ("", "")


@pytest.mark.check_urdf
@pytest.mark.skipif(shutil.which("check_urdf") is None, reason="no check_urdf")
def test_check_urdf_finds_a_tree_from_the_world_to_the_tool():
    found = subprocess.run(["check_urdf", URDF], capture_output=True, text=True, check=False)
    assert (found.returncode, found.stderr) == (0, "")
    lines = [line.split(":")[-1].split() for line in found.stdout.splitlines()[2:]]
    names = [words[0] for words in lines]
    assert names == ["world", "base", *LINKS, TOOL]


@programs(list(READERS))
def test_a_program_reads_it_in_silence(program, tmp_path, monkeypatch, caplog, capfd):
    have(program)
    monkeypatch.chdir(tmp_path)
    capfd.readouterr()
    reader.cache_clear()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = reader(program)
    assert caplog.records == []
    assert capfd.readouterr() == ("", "")
    assert list(tmp_path.iterdir()) == []  # MuJoCo writes its warnings into a file
    np.testing.assert_allclose(found.masses(), [345.9, 88.0, 139.7, 129.4, 20.8, 11.7])


@programs(list(READERS))
@examples(50)
@given(q=ROUNDED)
def test_its_tool_is_where_drake_has_it(program, q):
    have(program)
    plant, context = at(q)
    X_WE = plant.GetFrameByName(TOOL).CalcPoseInWorld(context).GetAsMatrix4()
    found = reader(program)
    np.testing.assert_allclose(found.tool(q), X_WE, rtol=0, atol=found.exact)


@programs(DYNAMIC)
@examples(50)
@given(q=ROUNDED)
def test_its_mass_matrix_and_weight_are_drakes(program, q):
    have(program)
    plant, context = at(q)
    found = of_kind(Dynamic, reader(program))  # type: ignore[type-abstract] # a protocol that is asked for at run time
    M = plant.CalcMassMatrix(context)
    np.testing.assert_allclose(found.mass_matrix(q) + ARMATURE, M, rtol=0, atol=1e-12 * M.max())
    weight = -plant.CalcGravityGeneralizedForces(context)
    np.testing.assert_allclose(found.gravity(q), weight, rtol=0, atol=1e-12 * abs(weight).max())
