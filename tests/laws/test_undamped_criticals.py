"""Undamped critical speeds in bearings that are not alike in both planes: closed forms, published figures, laws."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from test_bearings import borne
from test_rotors import BENDING, RPM, asked, friswell, light
from vibopt.report.what_to_build import machine_in
from vibopt.report.whirl_views import whirls_of
from vibopt.scene.read import from_dict
from vibopt.solve import solve

PATH = "bearings.left_film.k_zz"


def speeds(document: dict[str, Any], many: int, whirl: str = "", **words: Any) -> list[float]:
    """The lowest critical speeds [rad/s], agreed on by both routes."""
    said = {"whirl": whirl} if whirl else {}
    modes = {f"m{k}": {"response": "critical_speed", "mode": k, **said, **words} for k in range(1, many + 1)}
    return list(asked(document, **modes).values())


@settings(max_examples=8)
@given(level=st.floats(1e6, 1e8), more=st.floats(1.01, 30.0), polar=st.floats(0.1, 1.8))
def test_a_disc_that_tilts_in_the_middle_of_a_light_shaft_is_the_closed_form(
    level: float, more: float, polar: float
) -> None:
    """Up and down by k / m; tilting by (t_y - w^2 I) (t_z - w^2 I) = w^4 P^2, shaft and bearings in series."""
    upward = more * level
    disc = {"name": "disc", "at": "0.5 m", "mass": "20 kg", "diametral": "0.3 kg m2", "polar": f"{0.3 * polar!r} kg m2"}
    document = borne(light(discs=[disc]), level, 0.0, 0.0, upward, 3e3, 0.0, 0.0, 5e3)
    moves, tilts = np.array(
        [(1.0 / (1.0 / (48.0 * BENDING) + 0.5 / k), 1.0 / (1.0 / (12.0 * BENDING) + 2.0 / k)) for k in (level, upward)]
    ).T / [[20.0], [0.3]]
    squares = np.roots([1.0 - polar**2, -tilts.sum(), tilts.prod()])
    right = np.sort(np.sqrt([*moves, *squares[squares > 0.0]]))
    assert speeds(document, len(right)) == pytest.approx(right, rel=1e-8)
    assert speeds(document, 2, "forward")[0] == pytest.approx(math.sqrt(moves.min()), rel=1e-8)  # along a line: both
    assert speeds(document, 2, "backward")[0] == pytest.approx(right[0], rel=1e-8)


def test_three_discs_in_bearings_of_a_textbook_are_as_published() -> None:
    """Lalanne and Ferraris (1998), three discs: their elements, dampers left out or not, move nothing by 2e-3."""
    disc = {"inner_diameter": "100 mm", "density": "7800 kg/m3"}
    sizes = {"first": ("0.2 m", "50 mm", "240 mm"), "second": ("0.5 m", "50 mm", "400 mm")}
    sizes |= {"third": ("1 m", "60 mm", "400 mm")}
    document = friswell(
        sections=[{"length": "1.3 m", "diameter": "100 mm"}],
        stations={"left": "0 m", "right": "1.3 m"},
        discs=[
            {"name": name, "at": at, "width": wide, "outer_diameter": outer, **disc}
            for name, (at, wide, outer) in sizes.items()
        ],
        modulus="200 GPa",
        shear_modulus="76.923 GPa",
        density="7800 kg/m3",
    )
    document = borne(document, 5e7, 0.0, 0.0, 7e7, 5e2, 0.0, 0.0, 7e2)
    published = np.array([3620.4, 3798.1, 10018.0, 11279.0]) * RPM
    found = speeds(document, 4)
    assert found == pytest.approx(published, rel=2e-3)
    assert found == pytest.approx(speeds(document, 4, damped=True), rel=2e-5)


def test_what_nothing_damps_has_a_decrement_of_nothing_wherever_it_is_told() -> None:
    document = borne(friswell(), 1e6, 0.0, 0.0, 4e6, 0.0, 0.0, 0.0, 0.0)
    fades = {"response": "logarithmic_decrement", "at": "1500 rpm", "up_to": "9000 rpm"}
    design = solve(from_dict({**document, "measures": {"fades": fades}}))
    told = whirls_of(design, machine_in(design))
    assert len(told) > 4
    assert {whirl.logarithmic_decrement.value for whirl in told} == {0.0} == {design.measures["fades"].value.value}


def test_bearings_that_are_nearly_alike_have_the_critical_speeds_of_alike_ones() -> None:
    document = friswell()
    alike = borne(document, 1e6, 0.0, 0.0, 1e6, 0.0, 0.0, 0.0, 0.0)
    nearly = borne(document, 1e6, 0.0, 0.0, 1e6 * (1.0 + 1e-9), 0.0, 0.0, 0.0, 0.0)
    for whirl in ("forward", "backward"):
        assert speeds(nearly, 3, whirl) == pytest.approx(speeds(alike, 3, whirl), rel=1e-8)


def test_bearings_that_couple_by_a_potential_are_others_turned_by_an_angle() -> None:
    document = friswell()
    plain = borne(document, 1e6, 0.0, 0.0, 4e6, 0.0, 0.0, 0.0, 0.0)
    turned = borne(document, 1.75e6, -0.75e6 * math.sqrt(3.0), -0.75e6 * math.sqrt(3.0), 3.25e6, 0.0, 0.0, 0.0, 0.0)
    assert speeds(turned, 5) == pytest.approx(speeds(plain, 5), rel=1e-8)


def test_stiffness_is_permitted_up_to_where_a_critical_speed_meets_a_band() -> None:
    document = borne(friswell(), 1e6, 0.0, 0.0, 4e6, 1e3, 0.0, 0.0, 2e3)
    document["bearings"]["left_film"]["k_zz"] = {"from": "0.5 MN/m", "to": "50 MN/m"}
    apart = {"response": "critical_speed", "outside": "850..970 rpm"}
    design = solve(from_dict({**document, "measures": {}, "limits": {"apart": apart}, "goal": {"find_all": PATH}}))
    assert design.status == "met", design.claim
    ends = [end.value for two in design.found or () for end in two][1:-1]
    assert len(ends) == 2
    for end in ends:
        document["bearings"]["left_film"]["k_zz"] = f"{end!r} N/m"
        assert min(abs(one / RPM - edge) for one in speeds(document, 4) for edge in (850.0, 970.0)) < 1e-5
