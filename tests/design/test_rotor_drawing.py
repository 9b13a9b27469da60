"""A rotor is drawn from the side, to scale, with every disc and bearing of its file."""

from __future__ import annotations

import math
from pathlib import Path

from vibopt.report.figures.rotor_drawing import rotor_figure
from vibopt.report.rotor_parts import rotors_of
from vibopt.report.space_views import machine_figure
from vibopt.scene.read import read
from vibopt.solve import solve

TURBINE = Path(__file__).parents[2] / "problems" / "shafts" / "three_disc_turbine.toml"


def test_a_rotor_is_drawn_with_its_sections_discs_and_bearings() -> None:
    design = solve(read(TURBINE))
    (rotor,) = rotors_of(design)
    table = next(iter(design.scene.rotors.values()))
    assert rotor.sections[-1][1] == table.long
    assert [at for _, at, _, _ in rotor.discs] == [one.at.value for one in table.discs]
    assert [math.isnan(wide) for _, _, wide, _ in rotor.discs] == [one.outer_diameter is None for one in table.discs]
    figure = machine_figure(design, "turbine")
    assert figure is not None
    words = " ".join(text.get_text() for text in figure.axes[0].texts)
    assert all(one in words for one in ("first", "second", "third", "front_bearing", "rear_bearing"))


def test_two_rotors_have_a_panel_each() -> None:
    (rotor,) = rotors_of(solve(read(TURBINE)))
    assert len(rotor_figure([rotor, rotor], "both").axes) == 2
