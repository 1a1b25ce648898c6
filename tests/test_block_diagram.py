import shutil
import xml.etree.ElementTree as ElementTree

import pytest

from scara_drake import load_scenario, make_diagram
from scara_drake.common.resources import resource
from scara_drake.display.block_diagram import dot_source, render_svg, source_of_svg
from scara_drake.scenario import scenario_names


@pytest.mark.parametrize("name", scenario_names())
def test_the_shipped_drawing_is_that_of_the_diagram(name):
    """`make svg` draws them anew."""
    drawing = resource("diagrams", f"{name}.svg").read_text()
    assert source_of_svg(drawing) == dot_source(make_diagram(load_scenario(name)))


@pytest.mark.drawing
@pytest.mark.skipif(shutil.which("dot") is None, reason="Graphviz (dot) is not installed")
def test_a_drawing_shows_every_system_by_name():
    diagram = make_diagram(load_scenario("teleoperation"))
    svg = render_svg(diagram)
    text = " ".join(ElementTree.fromstring(svg).itertext())
    for system in diagram.GetSystems():
        listens = system.get_name() in ("recorded_signals", "recorder")
        assert (system.get_name() in text) == (not listens)
    assert source_of_svg(svg) == dot_source(diagram)


def test_without_graphviz_the_error_says_so(monkeypatch):
    monkeypatch.setattr(shutil, "which", lambda name: None)
    with pytest.raises(ValueError, match=r"^dot: not found"):
        render_svg(make_diagram(load_scenario("joint_sine")))


def test_a_drawing_has_the_connections_of_the_loop():
    source = dot_source(make_diagram(load_scenario("teleoperation")))
    for edge in (
        "joystick:y0:e -> mapping:u0:w",
        "mapping:y0:e -> uplink:u0:w",
        "uplink:y0:e -> inverse_kinematics:u0:w",
        "inverse_kinematics:y0:e -> controller:u1:w",
        "controller:y0:e -> plant_in:u",
        "contact:y1:e -> joint_forces:u0:w",
        "joint_forces:y0:e -> plant_in:u",
        "contact:y0:e -> downlink:u0:w",
        "downlink:y0:e -> haptics:u0:w",
    ):
        assert edge in source
