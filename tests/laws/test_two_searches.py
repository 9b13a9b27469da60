"""The worst speed is looked for twice, by searches that share nothing: a fault in either is seen, in every family."""

from __future__ import annotations

import ast
import copy
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import vibopt
from test_rotors import friswell, held
from vibopt.arrays import FloatArray
from vibopt.mechanics import peaks
from vibopt.mechanics.peaks import Place
from vibopt.scene.read import from_dict
from vibopt.signals import Band
from vibopt.solve import solve
from vibopt.verify.over_bands import Reached, Search

few = settings(derandomize=True, database=None, deadline=None, max_examples=60, suppress_health_check=list(HealthCheck))
NONE = np.zeros(0)

TWO = {
    "bodies": {"machine": {"mass": "100 kg"}, "frame": {"mass": "300 kg"}},
    "links": {
        "mount": {"between": ["machine", "frame"], "stiffness": "1 MN/m", "damping": "400 N s/m"},
        "feet": {"between": ["frame", "ground"], "stiffness": "0.5 MN/m", "damping": "200 N s/m"},
    },
}
ONE = {
    "bodies": {"machine": {"mass": "100 kg"}},
    "links": {"mount": {"between": ["machine", "ground"], "stiffness": "1 MN/m", "damping": "400 N s/m"}},
}
LOSSY = {
    "bodies": TWO["bodies"],
    "links": {
        "mount": {"between": ["machine", "frame"], "stiffness": "1 MN/m", "loss_factor": 0.05},
        "feet": {"between": ["frame", "ground"], "stiffness": "0.5 MN/m", "loss_factor": 0.1},
    },
}
JOINT = {
    "bodies": {**TWO["bodies"], "joint": {"mass": "0 kg"}},
    "links": {
        **TWO["links"],
        "held": {"between": ["machine", "joint"], "stiffness": "0.2 MN/m"},
        "dash": {"between": ["joint", "frame"], "damping": "900 N s/m"},
    },
}
ROTOR = {
    **{key: value for key, value in friswell().items() if key in ("rotors", "excitations")},
    "links": held(2e6, 3e3),
}
SPACE = {
    "bodies": {
        "machine": {"mass": "100 kg", "motion": "space", "inertia": ["4 kg m2", "5 kg m2", "6 kg m2"]},
    },
    "mounts": {
        "feet": {
            "between": ["machine", "ground"],
            "at": [[f"{x} m", f"{y} m", "-0.2 m"] for x in (0.3, -0.25) for y in (0.2, -0.2)],
            "stiffness": "250 kN/m", "shear_ratio": 0.6, "damping": "200 N s/m",
        },
    },
}  # fmt: skip


def force(*orders: float, varies: str = "constant", speed: str = "5..40 Hz", **more: Any) -> dict[str, Any]:
    if not orders:
        one = {"kind": "force", "amplitude": "300 N", "varies": varies}
    else:
        parts = [{"order": order, "amplitude": f"{300 / order} N"} for order in orders]
        one = {"kind": "harmonics", "harmonics": parts, "varies": varies}
    return {"excitations": {"shaker": {**one, "on": "machine", "speed": speed, **more}}}


def asked(response: str, least: bool = False, **words: Any) -> dict[str, Any]:
    return {"measures": {"worst": {"response": response, "worst": "least" if least else "greatest", **words}}}


FAMILIES: dict[str, dict[str, Any]] = {
    "one mass, two harmonics": {**ONE, **force(1, 2), **asked("displacement", of="machine", combine="sum")},
    "root of squares": {**TWO, **force(1, 2, 3), **asked("displacement", of="machine", combine="rss")},
    "true peak in time": {**TWO, **force(1, 2), **asked("displacement", of="machine", combine="peak")},
    "least of two masses": {**TWO, **force(), **asked("displacement", of="machine", least=True)},
    "least, loss factors": {
        **LOSSY, **force(varies="speed^2", amplitude_at="20 Hz"), **asked("displacement", of="machine", least=True),
    },
    "harmonics as speed^2": {
        **LOSSY, **force(1, 2, varies="speed^2", amplitude_at="20 Hz"),
        **asked("transmitted_force", into="ground", combine="sum"),
    },
    "insertion loss": {**TWO, **force(), **asked("insertion_loss", least=True, across="mount")},
    "a rotor that spins": {**ROTOR, **asked("displacement", of="first")},
    "a body in space": {
        **SPACE, **force(1, 2, direction="x", at=["0.1 m", "0.1 m", "0.3 m"]),
        **asked("acceleration", of="machine", direction="x", combine="sum"),
    },
    "joint without mass": {**JOINT, **force(1, 2), **asked("displacement", of="machine", combine="sum")},
}  # fmt: skip

Candidates = Callable[..., list[Place]]


def _without_best(found: list[Place], sign: float) -> list[Place]:
    best = max(found, key=lambda one: sign * one[0])
    kept = [one for one in found if abs(one[1] - best[1]) > 1e-3 * best[1]]
    return kept or found


def misses_the_best(true: Candidates) -> Candidates:
    def found(*args: Any, **words: Any) -> list[Place]:
        return _without_best(true(*args, **words), -1.0 if words["least"] else 1.0)

    return found


def misses_an_end(true: Candidates) -> Candidates:
    def found(response: Any, bands: tuple[Band, ...], *args: Any, **words: Any) -> list[Place]:
        ends = {end for band in bands for end in (band.low, band.high)}
        every = true(response, bands, *args, **words)
        inside = 0.5 * (bands[0].low + bands[0].high)
        return [one for one in every if one[1] not in ends] or [(float(response(np.array([inside]))[0]), inside)]

    return found


def returns_a_neighbour(true: Candidates) -> Candidates:
    def found(response: Any, bands: tuple[Band, ...], *args: Any, **words: Any) -> list[Place]:
        every = true(response, bands, *args, **words)
        speeds = np.clip([one[1] * 1.003 for one in every], bands[0].low * 1.002, bands[0].high * 0.998)
        return list(zip(response(speeds).tolist(), speeds.tolist(), strict=True))

    return found


def without_tops(_: Any) -> Any:
    return lambda self, speeds, values: []


def beside_tops(true: Any) -> Any:
    return lambda self, speeds, values: [1.003 * one for one in true(self, speeds, values)]


def within_ends(true: Any) -> Any:
    def over(self: Search, bands: tuple[Band, ...], turning: Any = None) -> Reached:
        return true(self, tuple(Band(band.low * 1.002, band.high * 0.998) for band in bands), turning)

    return over


FIRST = {"top": misses_the_best, "end": misses_an_end, "neighbour": returns_a_neighbour}
"""Faults of the model's search, at which it is planted in `peaks._candidates`."""
SECOND = {
    "top": ("_closed_in", without_tops),
    "end": ("over", within_ends),
    "neighbour": ("_closed_in", beside_tops),
}
"""Faults of the search on the machine as built: of which function, and what of it is made."""


def answer(family: str, speed: str = "") -> Any:
    document = copy.deepcopy({"title": "searched twice", **FAMILIES[family]})
    for table in document["excitations"].values():
        table["speed"] = speed or table["speed"]
    return solve(from_dict(document))


@cache
def where(family: str) -> float:
    """The worst speed, inside the range [rad/s]."""
    design = answer(family)
    assert design.status == "met", design.claim
    [at] = design.measures["worst"].worst_at.values()
    return float(at.value)


@pytest.mark.parametrize("fault", FIRST)
@pytest.mark.parametrize("family", FAMILIES)
def test_a_fault_in_either_search_is_seen(family: str, fault: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The worst stands inside the range; of a range that is cut off before it, at an end."""
    near = f"{0.9 * where(family)!r}..{0.97 * where(family)!r} rad/s" if fault == "end" else ""
    right = answer(family, near)
    assert right.status == "met", right.claim
    with monkeypatch.context() as planted:
        planted.setattr(peaks, "_candidates", FIRST[fault](peaks._candidates))
        assert refused(answer(family, near))
    name, made = SECOND[fault]
    with monkeypatch.context() as planted:
        planted.setattr(Search, name, made(getattr(Search, name)))
        assert refused(answer(family, near))


def refused(design: Any) -> bool:
    agrees = "the two routes to an answer do not agree: worst ("
    return bool(
        design.status == "check_failed" and design.claim.startswith(agrees) and " in the model with " in design.claim
    )


def test_a_goal_is_looked_for_by_both(monkeypatch: pytest.MonkeyPatch) -> None:
    """A design that is best for a search that misses a peak is no best design, though both measure it alike."""
    document = copy.deepcopy({"title": "searched twice", **TWO, **force(1, 2)})
    document["links"]["mount"]["stiffness"] = {"from": "0.9 MN/m", "to": "1.1 MN/m"}
    document["goal"] = {"minimise": "displacement", "of": "frame", "combine": "sum"}
    assert solve(from_dict(document)).status in ("optimal", "feasible")
    monkeypatch.setattr(peaks, "_candidates", misses_the_best(peaks._candidates))
    design = solve(from_dict(document))
    assert (design.status, design.exit_code) == ("check_failed", 6)


def test_the_sentence_says_both_values_and_both_speeds(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(peaks, "_candidates", misses_the_best(peaks._candidates))
    assert answer("one mass, two harmonics").claim == (
        "the two routes to an answer do not agree: worst (displacement of machine) is greatest in the model with "
        "0.000580451 m at 5 Hz of shaker, on the machine as built with 0.00755154 m at 15.91 Hz of shaker"
    )


def test_the_second_search_shares_nothing_with_the_first() -> None:
    """No file of the second route imports the first one's searches; what compares the two asks forms alone."""
    for file in (Path(vibopt.__file__).parent / "verify").glob("*.py"):
        modules = [one.module or "" for one in ast.walk(ast.parse(file.read_text())) if isinstance(one, ast.ImportFrom)]
        found = {
            one
            for one in modules
            if one.endswith(("mechanics.peaks", "forms.extremes", "forms.few", "mechanics.highest"))
        }
        assert not found, f"{file.name} imports {found}"


class Quotient:
    """N(i w) / D(i w) of polynomials with real coefficients, descending in s; callable as a response."""

    def __init__(self, above: FloatArray, below: FloatArray) -> None:
        self.above, self.below = above, below

    def __call__(self, speed: FloatArray) -> FloatArray:
        s = 1j * np.asarray(speed, dtype=float)
        return np.abs(np.polyval(self.above, s) / np.polyval(self.below, s))

    @property
    def poles(self) -> Any:
        return -1j * np.roots(self.below)

    def speeds_at(self, level: float) -> FloatArray:
        """Every speed at which it is as high as a level: real roots of |N|^2 - level^2 |D|^2 in w^2."""
        squares = [np.convolve(one, one * (-1.0) ** np.arange(len(one))[::-1]) for one in (self.above, self.below)]
        first, second = (np.real(one * (1j) ** np.arange(len(one))[::-1])[::2] for one in squares)
        roots = np.roots(np.polysub(first, level**2 * second))
        real = roots[(np.abs(roots.imag) <= 1e-7 * np.abs(roots)) & (roots.real > 0.0)].real
        return np.sqrt(real)


@few
@given(seed=st.integers(0, 10**6), modes=st.integers(1, 4), sharp=st.floats(-2.0, -0.3), least=st.booleans())
def test_no_speed_gives_more_than_what_was_found(seed: int, modes: int, sharp: float, least: bool) -> None:
    """A certificate: at a level a millionth beyond what was found, the curve is crossed nowhere in the band."""
    random = np.random.default_rng(seed)
    below = np.ones(1)
    for own, part in zip(
        10.0 ** random.uniform(-0.5, 0.5, modes), 10.0 ** random.uniform(sharp, 0.0, modes), strict=True
    ):
        below = np.convolve(below, [1.0, 2.0 * part * own, own**2])
    above = random.normal(size=2 * modes - 1) * 10.0 ** random.uniform(-0.5, 0.5)
    curve = Quotient(above, below)
    band = Band(*np.sort(10.0 ** random.uniform(-1.0, 1.0, 2)).tolist())
    found = Search(curve, curve.poles, NONE, least).over((band,))
    sign = -1.0 if least else 1.0
    assert found.value == curve(np.array(found.speed))
    if found.value > 1e-6 * curve(np.array([band.low, band.high])).max():
        beyond = curve.speeds_at(found.value * (1.0 + sign * 1e-6))
        assert not ((beyond > band.low) & (beyond < band.high)).any()


@pytest.mark.slow
def test_where_every_top_is_rounding_the_highest_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    from vibopt.forms import extremes

    place = {"response": "displacement", "of": "c", "over": "0..3000 rpm", "at_most": "1 m"}
    ends = [("a", "ground"), ("b", "a"), ("c", "b")]
    force = {"kind": "force", "on": "a", "amplitude": "1 N", "speed": "3000 rpm", "varies": "constant"}
    chain = {
        "title": "chain",
        "bodies": {name: {"mass": "1 kg", "tolerance": "5 %"} for name in "abc"},
        "links": {f"to_{a}": {"between": [a, b], "stiffness": "9 kN/m", "damping": "5 N s/m"} for a, b in ends},
        "excitations": {"force": force},
        "limits": {"place": place},
    }
    before = solve(from_dict(chain)).limits["place"].value.value
    for name in ("highest", "closed_form", "of_few"):
        monkeypatch.setattr(extremes, name, lambda *_: None)
    monkeypatch.setattr(extremes, "_is_peak", lambda _response, _drive, found: [False] * len(found))
    assert solve(from_dict(chain)).limits["place"].value.value == pytest.approx(before, rel=1e-9)
