"""`systems` gathers every LeafSystem of the package."""

import importlib
import inspect
import pkgutil

from pydrake.systems.framework import LeafSystem

import scara_drake
from scara_drake import systems
from scara_drake.common.block import Block
from scara_drake.control.controller import JointController

OF_EXTRAS = {"scara_drake.exports.rerun_file"}  # imports what an extra installs
BASES = {Block, JointController}  # what others are made of


def leaf_systems():
    found = set()
    for module in pkgutil.walk_packages(scara_drake.__path__, "scara_drake."):
        if module.name.endswith("__main__") or module.name in OF_EXTRAS:
            continue
        for value in vars(importlib.import_module(module.name)).values():
            ours = inspect.isclass(value) and value.__module__.startswith("scara_drake")
            if ours and issubclass(value, LeafSystem):
                found.add(value)
    return found


def test_every_leaf_system_is_there():
    gathered = {getattr(systems, name) for name in systems.__all__}
    assert gathered == leaf_systems() - BASES
    assert len(gathered) == len(systems.__all__) > 20


def test_every_leaf_system_says_what_its_ports_are():
    for name in systems.__all__:
        documented = inspect.getdoc(getattr(systems, name)) or ""
        assert "ort" in documented, name  # "Ports", "Input port"
