"""Tolerances from data: the worst machine is one from the least to the greatest deviation, on neither side a mirror."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from refusals import refused
from texts import STIFFEST, absorber, best, choice, floor, press, table
from texts import one_mass as machine
from vibopt.jobs import answer, from_text
from vibopt.report.sheet.judgement import assumptions_of
from vibopt.scene.read import from_dict
from vibopt.scene.scene import Scene
from vibopt.scene.uncertain import uncertain
from vibopt.solve import solve
from vibopt.study.freeze import frozen
from vibopt.values.tolerance import Scatter

Span = tuple[float, float]
_ends = st.tuples(st.floats(-0.3, 0.3), st.floats(-0.3, 0.3)).filter(lambda one: max(map(abs, one)) > 1e-3)
_some = settings(derandomize=True, database=None, deadline=None, max_examples=15)
VALUES, UNITS = (100.0, 1e6, 4e3), ("kg", "N/m", "N s/m")
TOP = 3000.0 * 2.0 * np.pi / 60.0


def one_mass(said: list[dict[str, Any]], band: str) -> Scene:
    """A mass on a spring and a damper, which are said, under 1 kN."""
    return from_dict({
        "bodies": {"m": {"mass": said[0]}},
        "links": {"k": {"between": ["m", "ground"], "stiffness": said[1], "damping": said[2]}},
        "excitations": {"f": {"kind": "force", "on": "m", "amplitude": "1 kN", "speed": band, "varies": "constant"}},
        "limits": {"floor": {"response": "transmitted_force", "into": "ground", "at_most": "1 GN"},
                   "slow": {"response": "natural_frequency", "mode": 1, "at_least": "1 Hz"}},
    })  # fmt: skip


@given(
    spans=st.tuples(_ends, _ends, _ends), band=st.sampled_from(["12 Hz", "2..40 Hz", "25 Hz"]), seed=st.integers(0, 99)
)
@_some
def test_the_worst_of_data_is_that_of_the_same_machines_said_from_their_middle(
    spans: tuple[Span, Span, Span], band: str, seed: int
) -> None:
    """(1 + a) v to (1 + b) v is a middle value with a tolerance both ways; and by formula no machine is worse."""
    measured, middle = [], []
    for value, unit, (one, other) in zip(VALUES, UNITS, spans, strict=True):
        low, high = sorted((one, other))
        data = [high, 0.5 * (low + high), low]
        measured.append({"value": f"{value!r} {unit}", "tolerance": {"data": data}})
        half, about = 0.5 * (high - low), 1.0 + 0.5 * (low + high)
        middle.append({"value": f"{value * about!r} {unit}", "tolerance": half / about})
    found, same = (solve(one_mass(said, band)).limits for said in (measured, middle))
    for name in ("floor", "slow"):
        assert found[name].value.value == pytest.approx(same[name].value.value, rel=1e-7)
    low, _, high = band.removesuffix(" Hz").partition("..")
    omega = 2.0 * np.pi * np.linspace(float(low), float(high or low), 300)
    shares = np.random.default_rng(seed).random((3, 2000, 1))
    shares[:, :500] = np.round(shares[:, :500])
    m, k, c = (
        value * (1.0 + one + share * (other - one))
        for value, (one, other), share in zip(VALUES, spans, shares, strict=True)
    )
    held = k + 1j * omega * c
    worst = found["floor"].value.value
    assert (1e3 * np.abs(held / (held - omega**2 * m))).max() <= worst * (1.0 + 1e-9)
    assert np.sqrt(k / m).min() >= found["slow"].value.value * (1.0 - 1e-9)


def press_of(data: str) -> str:
    """The stiffest spring of which the deviations of some were measured."""
    return press(
        choice("1 MN/m", "20 MN/m", f", tolerance = {{ data = [{data}] }}"), "0 N s/m", floor("10 kN"), STIFFEST
    )


@given(low=st.floats(-0.3, 0.0), high=st.floats(0.0, 0.3))
@settings(derandomize=True, database=None, deadline=None, max_examples=6)
def test_a_design_uses_the_room_that_the_data_leave(low: float, high: float) -> None:
    """The stiffest mount built may be a quarter of m omega^2, the softest is what the goal counts."""
    if max(-low, high) < 1e-3:
        return
    design = answer(from_text(press_of(f"{low!r}, {high!r}, 0"), "press.toml"))
    stiffest = 0.25 * 300.0 * TOP**2
    assert design.status == "optimal"
    assert design.goal is not None
    assert design.x[0] * (1.0 + high) == pytest.approx(stiffest, rel=2e-6)
    assert design.goal[1].value == pytest.approx(stiffest * (1.0 + low) / (1.0 + high), rel=2e-6)


def test_a_search_does_not_begin_with_a_machine_that_is_never_built() -> None:
    words = (
        "press.toml line 5: links.mount.stiffness has deviations that are all {side} zero, and something is to be "
        'chosen, which begins with the machine as said. Add "0 %" to the data.'
    )
    for data, side in (('"+1 %", "+3 %"', "above"), ('"-1 %", "-3 %"', "below")):
        assert refused(from_text, press_of(data), "press.toml").messages == (words.format(side=side),)
        from_text(press_of(f'{data}, "0 %"'), "press.toml")


def test_the_sheet_says_both_sides_and_a_saved_design_keeps_them() -> None:
    design = answer(from_text(press_of('"-8 %", "0 %", "+1 %"'), "press.toml"))
    assert any("links.mount.stiffness -8 % to +1 % (data)" in one for one in assumptions_of(design))
    (kept,) = uncertain(frozen(design.scene, design.x))
    assert kept.tolerance == Scatter("data", 0.0, (-0.08, 0.0, 0.01))
    assert kept.ends == pytest.approx((0.92, 1.01))
    assert solve(frozen(design.scene, design.x)).status == "met"


def tuned(low: float, high: float) -> str:
    """The least damping under an absorber whose frequency is off."""
    off = f'{{ value = "20 Hz", tolerance = {{ data = [{low!r}, 0, {high!r}] }} }}'
    return machine(
        "press", "300 kg", {"stiffness": "4 MN/m", "damping": choice("1 kN s/m", "9 kN s/m")}, {},
        absorber("t", "press", "9 kg", frequency=off, damping_ratio=0.1),
        table("limits.slow", response="natural_frequency", mode=1, at_least="1 Hz"),
        best(minimise="damping", of="mount"),
    )  # fmt: skip


@given(low=st.floats(-0.3, 0.0), high=st.floats(0.0, 0.3))
@_some
def test_a_saved_absorber_is_off_as_its_frequency_was_said_to_be(low: float, high: float) -> None:
    """Its spring by the square of that: no tolerance of a spring says the same."""
    if max(-low, high) < 1e-3:
        return
    scene = from_text(tuned(low, high), "tuned.toml")
    kept = frozen(scene, (4e3,))
    assert uncertain(kept) == uncertain(scene)
    assert kept.document["absorbers"]["t"]["frequency"]["tolerance"] == {"data": [low, 0.0, high]}
