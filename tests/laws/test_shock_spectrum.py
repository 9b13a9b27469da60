"""Shock spectra: closed forms of the literature, another integrator, and what is drawn and said of them."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import fftconvolve

import vibopt as vo
from refusals import refused
from vibopt.arrays import FloatArray
from vibopt.cli.main import main
from vibopt.excitations.pulse import Pulse
from vibopt.excitations.segments import line
from vibopt.mechanics.readout import Reading
from vibopt.mechanics.shock_spectrum import Spectrum, spectra
from vibopt.mechanics.transient import Transient
from vibopt.report.spectrum_views import spectrum_panels

few = settings(derandomize=True, database=None, deadline=None, max_examples=15)
ONE = np.ones(1)
TURNS = np.array([0.05, 0.21, 0.8157, 1.3, 4.6, 37.3])
RATIOS = np.array([0.0, 0.05, 0.7, 1.0, 1.0 + 1e-9, 2.5])
SHAPES = ("half sine", "versed sine", "sine", "rectangle", "triangle", "rising sawtooth", "falling sawtooth")


def pulse(shape: str) -> Pulse:
    return Pulse(kind="pulse", on="a", shape=shape, amplitude="1 N", duration="1 s")


def maximax(found: Spectrum) -> tuple[FloatArray, FloatArray]:
    return np.maximum(found.pseudo, found.pseudo_after), np.maximum(found.absolute, found.absolute_after)


def test_undamped_spectra_are_as_in_the_books() -> None:
    """Rectangle 2 or 2 sin(pi f T) and its residual; half sine 1.7685 at f T = 0.81 and its residual (Harris, 8)."""
    w = 2.0 * np.pi * TURNS
    found = spectra(ONE, pulse("rectangle").segments(), w, np.zeros(1))
    sine = np.abs(np.sin(np.pi * TURNS))
    assert maximax(found)[0] == pytest.approx(np.where(TURNS < 0.5, 2.0 * sine, 2.0), rel=1e-12)
    assert found.pseudo_after == pytest.approx(2.0 * sine, rel=1e-11)
    assert maximax(found)[1] == pytest.approx(maximax(found)[0], rel=1e-12)
    half = spectra(ONE, pulse("half sine").segments(), w, np.zeros(1))
    r = 0.5 / TURNS
    assert half.pseudo_after == pytest.approx(np.abs(2.0 * r * np.cos(np.pi * TURNS) / (1.0 - r * r)), rel=1e-10)
    near = 2.0 * np.pi * np.linspace(0.8, 0.83, 601)
    top = maximax(spectra(ONE, pulse("half sine").segments(), near, np.zeros(1)))[0]
    turns = np.pi / near
    assert top == pytest.approx(np.sin(2.0 * np.pi * turns / (1.0 + turns)) / (1.0 - turns), rel=1e-12)
    assert top.max() == pytest.approx(1.7685, abs=1e-4)
    assert near[top.argmax()] / (2.0 * np.pi) == pytest.approx(0.81, abs=1e-3)
    resonant = spectra(ONE, pulse("half sine").segments(), np.array([np.pi]), np.zeros(1))
    assert resonant.pseudo_after[0] == pytest.approx(0.5 * np.pi, rel=1e-12)


@pytest.mark.parametrize("ratio", [0.0, 0.03, 0.404, 0.99])
def test_a_step_of_velocity_has_the_spectrum_of_free_vibration(ratio: float) -> None:
    """v w e^(-z a / d) with tan(a) = d / z, d = root(1 - z^2); all of it is residual."""
    w, d = np.geomspace(1.0, 1e4, 9), np.sqrt(1.0 - ratio**2)
    drop = vo.from_dict(
        {
            "title": "x", "bases": {"box": {}}, "bodies": {"a": {"mass": "1 kg"}},
            "links": {"l": {"between": ["a", "box"], "stiffness": "1 N/m"}},
            "excitations": {"fall": {"kind": "drop", "on": "box", "velocity_change": "2 m/s"}},
            "measures": {"m": {"response": "peak_acceleration", "of": "a"}},
        }
    )  # fmt: skip
    once = drop.excitations["fall"].once
    assert once is not None
    found = spectra(ONE, once.segments(), w, np.array([ratio]))
    turn = np.arctan2(d, ratio)
    assert found.pseudo_after == pytest.approx(2.0 * w * np.exp(-ratio * turn / d), rel=1e-12)
    assert maximax(found)[0] == pytest.approx(found.pseudo_after, rel=1e-12)


def kicked(w: float, ratio: float, times: FloatArray) -> FloatArray:
    """y and q behind a q of one, (2, n): the free vibration in closed form."""
    d = w * np.sqrt(complex(1.0 - ratio**2)) + 1e-6 * w
    ahead, behind = (np.exp((sign * d - ratio * w) * times) for sign in (1j, -1j))
    y = w / d * (ahead - behind) / 2j
    return np.real(np.array([y, 0.5 * (ahead + behind) - ratio * y]))


@pytest.mark.parametrize("shape", SHAPES)
def test_duhamels_integral_comes_near_and_never_beyond(shape: str) -> None:
    """Sums of kicks, 16 000 of them, each in closed form; every damping, every part."""
    times, one = np.linspace(0.0, 1.0, 16_001), pulse(shape)
    load = one.signal(times) * times[1]
    load[0] *= 0.5
    later = np.linspace(0.0, 40.0, 80_001)
    found = spectra(ONE, one.segments(), 2.0 * np.pi * TURNS[1:5], RATIOS[:, None])
    for i, ratio in enumerate(RATIOS):
        for j, w in enumerate(2.0 * np.pi * TURNS[1:5]):
            kicks = kicked(w, ratio, times)
            kicks[:, 0] *= 0.5  # the trapezoidal rule
            y, q = (-w * fftconvolve(load, kick)[: len(times)] for kick in kicks)
            kick = kicked(w, ratio, later)
            free = (kick[1] + 2.0 * ratio * kick[0]) * y[-1] + kick[0] * q[-1]
            fades = -kick[0] * y[-1] + kick[1] * q[-1]
            for seen, best in (
                (y, found.pseudo), (y + 2.0 * ratio * q, found.absolute),
                (free, found.pseudo_after), (free + 2.0 * ratio * fades, found.absolute_after),
            ):  # fmt: skip
                assert np.abs(seen).max() == pytest.approx(best[i, j], rel=2e-5, abs=5e-6 * w)


@few
@given(seed=st.integers(0, 10_000), count=st.integers(1, 400), ratio=st.sampled_from([0.0, 0.1, 1.0, 3.0]))
def test_a_record_is_as_the_machine_itself_answers_it(seed: int, count: int, ratio: float) -> None:
    """Straight pieces of any size through the chain solver, at frequencies far below and above those of the record."""
    rng = np.random.default_rng(seed)
    points = rng.normal(size=count + 1) * 10.0 ** rng.uniform(-3, 3)
    segments = tuple(line(0.02, a, b) for a, b in pairwise(points))
    w = 10.0 ** rng.uniform(-1, 3, 3)
    both = maximax(spectra(ONE, segments, w, np.array([ratio])))
    table, none = np.array([[1.0, -1.0], [-1.0, 1.0]]), np.zeros(2)
    for j, rate in enumerate(w):
        machine = Transient(
            np.diag([1.0, 0.0]), 2.0 * ratio * rate * table, rate**2 * table, 1, np.array([[0.0], [1.0]]), segments
        )
        apart = machine.peak(Reading(np.array([1.0, -1.0]), none, none)).value
        moved = machine.peak(Reading(np.array([1.0, 0.0]), none, none, 2)).value
        assert both[0][j] == pytest.approx(abs(apart) * rate**2, rel=1e-8)
        assert both[1][j] == pytest.approx(abs(moved), rel=1e-8)


MOUNT: dict[str, Any] = {
    "title": "Instrument under a half sine",
    "bases": {"table": {}},
    "bodies": {"instrument": {"mass": "10 kg"}},
    "links": {"mount": {"between": ["instrument", "table"], "stiffness": "40 kN/m", "damping": "120 N s/m"}},
    "excitations": {
        "shock": {"kind": "pulse", "on": "table", "shape": "half sine", "acceleration": "30 g", "duration": "11 ms"}
    },
    "measures": {
        "rattle": {"response": "peak_relative_displacement", "across": "mount"},
        "shock": {"response": "peak_acceleration", "of": "instrument"},
    },
}


def test_the_machine_is_a_point_of_its_spectrum() -> None:
    design = vo.solve(vo.from_dict(MOUNT))
    parts, listed, moved = spectrum_panels(design)
    assert [one.label for one in parts.curves] == ["maximax", "primary, during the load", "residual, after it"]
    assert len(listed.curves) == 6
    rattle, shock = (design.measures[name].value.value for name in ("rattle", "shock"))
    assert [one.y for one in (*parts.marks, *listed.marks)] == pytest.approx([shock / 9.80665] * 2, rel=1e-9)
    assert moved.marks[0].y == pytest.approx(1e3 * rattle, rel=1e-9)
    assert parts.marks[0].x == pytest.approx(np.sqrt(4000.0) / (2.0 * np.pi), rel=1e-12)
    for panel in (parts, listed, moved):
        assert all(np.isfinite(curve.y).all() and curve.y.max() < panel.y_span[1] for curve in panel.curves)


def test_in_python_it_is_a_table() -> None:
    found = vo.shock_spectrum(vo.from_dict(MOUNT), frequencies=[1e-2, 74.2, 1e5], damping=[0.0])
    soft, top, hard = found.table()
    pulse_area = 30.0 * 9.80665 * 2.0 * 0.011 / np.pi
    assert soft["acceleration_maximax"] == pytest.approx(pulse_area * 2.0 * np.pi * 1e-2, rel=1e-4)
    assert soft["acceleration_maximax"] == soft["acceleration_residual"] > soft["acceleration_primary"]
    assert top["acceleration_maximax"] == pytest.approx(1.768 * 30.0 * 9.80665, rel=1e-3)
    assert hard["acceleration_maximax"] == pytest.approx(30.0 * 9.80665, rel=1e-3)
    assert hard["relative_displacement"] == pytest.approx(hard["pseudo_acceleration"] / (2e5 * np.pi) ** 2, rel=1e-12)
    assert found.heading() == ("Shock spectrum of shock on table",)
    blast = {"kind": "pulse", "on": "instrument", "shape": "rectangle", "amplitude": "2 kN", "duration": "11 ms"}
    both = vo.from_dict({**MOUNT, "excitations": {**MOUNT["excitations"], "blast": blast}})
    [pushed] = vo.shock_spectrum(both, on="instrument", frequencies=[200.0], damping=[0.0]).table()
    assert pushed["force_maximax"] == pytest.approx(4000.0, rel=1e-12)
    assert "relative_displacement" not in pushed


STEADY = {"kind": "force", "on": "instrument", "amplitude": "1 N", "speed": "600 rpm", "varies": "constant"}
WRONG: dict[str, tuple[dict[str, Any], dict[str, Any], str]] = {
    "steady": (
        {"excitations": {"s": STEADY}, "measures": {"d": {"response": "displacement", "of": "instrument"}}},
        {},
        "scene: a shock spectrum is of what comes once and is over, and nothing does. Add a pulse, a drop or a record.",
    ),
    "where": ({}, {"on": "tabel"}, 'scene: nothing comes once on tabel. Did you mean "table"?'),
    "frequency": (
        {},
        {"frequencies": [0.0, 1.0]},
        "scene: natural frequencies are above zero, in Hz, and damping ratios zero or more. Leave them out for the "
        "usual ones.",
    ),
    "any": (
        {
            "excitations": {
                "shock": {k: v for k, v in MOUNT["excitations"]["shock"].items() if k != "duration"}
                | {"duration_up_to": "11 ms"}
            }
        },
        {},
        "scene: a pulse that may have any duration has one shock spectrum for each. Write its duration.",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_has_no_spectrum_is_refused(name: str) -> None:
    changes, words, said = WRONG[name]
    assert str(refused(lambda: vo.shock_spectrum(vo.from_dict({**MOUNT, **changes}), **words))) == said


def test_plot_draws_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file, target = tmp_path / "shock.toml", tmp_path / "out.svg"
    vo.write(vo.from_dict(MOUNT), str(file))
    assert main(("plot", str(file), "--spectrum", "-o", str(target))) == 0
    assert "residual, after it" in target.read_text()
    assert main(("plot", str(file), "--spectrum", "--sketch", "-o", str(target), "--force")) == 2
    said = "--spectrum draws the load and --sketch or --map the machine: leave one of them out.\n"
    assert capsys.readouterr().err == said
