import dataclasses
import re

import make_scenario_reference as reference
import pytest

from scara_drake.common.fields import KEY
from scara_drake.scenario import Scenario

PARTS = sorted({part for _, part in reference.parts(Scenario)}, key=lambda part: part.__name__)


def test_the_page_is_that_of_the_code():
    assert reference.PAGE.read_text() == reference.page(), (
        "run python docs/make_scenario_reference.py"
    )


@pytest.mark.parametrize("part", [Scenario, *PARTS], ids=lambda part: part.__name__)
def test_every_field_is_explained_and_every_number_has_its_bounds(part):
    told, hints = reference.meanings(part), {f.name: f.type for f in dataclasses.fields(part)}
    assert told.keys() == hints.keys()
    for entry in dataclasses.fields(part):
        default = getattr(part(), entry.name)
        number = isinstance(default, float) or (
            isinstance(default, list) and "float" in str(entry.type)
        )
        if number:
            assert KEY in entry.metadata, entry.name
            assert entry.metadata[KEY].unit, entry.name
        assert not re.search(r"\[(m|s|N|rad|1)[^\]]*\]$", told[entry.name]), told[entry.name]
