"""What we show in the place of the paper's drawings: Figure 2, the axes; 3, the flow chart."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import make_axes_picture
import make_flow_chart
import numpy as np
import pytest

from scara_drake import kinematics
from scara_drake.common.resources import resource
from scara_drake.common.urdf import LinkTree
from scara_drake.display.block_diagram import source_of_svg
from scara_drake.ik.options import PARAMETERS, TUNED
from scara_drake.joints import HOME, JOINT_NAMES

DOCS = Path(__file__).parents[1] / "docs"


def test_the_shipped_flow_chart_is_that_of_the_parameters():
    """`python docs/make_flow_chart.py` draws it anew."""
    svg = (DOCS / "dpso.svg").read_text()
    assert source_of_svg(svg) == make_flow_chart.dot_source()


def test_the_flow_chart_follows_the_parameters(monkeypatch):
    before = make_flow_chart.dot_source()
    other = TUNED._replace(pso2=TUNED.pso2._replace(particles=77))
    monkeypatch.setitem(PARAMETERS, "tuned", other)
    assert "77 particles" in make_flow_chart.dot_source()
    assert "77 particles" not in before


@pytest.mark.parametrize("moving", [5, 6])
def test_the_flow_chart_has_the_papers_population(moving):
    # N = n_dof d_N / (t_allow E_Tp), (20)
    assert f" {round(moving * 10 / (0.25 * 5))} (" in make_flow_chart.dot_source()


def test_the_axes_drawn_are_those_about_which_the_tool_turns():
    urdf = ET.fromstring(resource("models", "scara6.urdf").read_bytes())
    X_WL = LinkTree(urdf).poses(dict(zip(JOINT_NAMES, HOME, strict=True)))
    J_WE = kinematics.jacobian(HOME)
    tool = kinematics.forward_kinematics(HOME)[:3, 3]
    drawn = ["link_1", *make_axes_picture.LABELS]  # joints 1 and 2 have the same axis
    for joint, link in enumerate(drawn):
        axis, origin = X_WL[link][:3, 2], X_WL[link][:3, 3]
        turn = axis if joint else np.zeros(3)
        move = np.cross(axis, tool - origin) if joint else axis
        np.testing.assert_allclose(J_WE[:, joint], [*turn, *move], atol=1e-9)
