"""Exact peaks against 50 digits: any damping, near modes, modes far apart, band ends on a resonance."""

from __future__ import annotations

from itertools import pairwise
from math import sqrt

import mpmath as mp
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from vibopt.mechanics.peaks import crossings, greatest, least
from vibopt.program.pose import pose
from vibopt.scene.read import from_dict
from vibopt.signals import Amplitude, Band, Line, Piece, sizes
from vibopt.verify.over_bands import Search

few = settings(derandomize=True, database=None, deadline=None, max_examples=60, suppress_health_check=list(HealthCheck))
NONE = np.zeros(0)


def power(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high).map(lambda e: float(10.0**e))


class Modes:
    """Sum of modes r / (w0^2 - w^2 + 2 i zeta w0 w), callable as the mechanics call a response."""

    def __init__(self, modes: list[tuple[float, float, float]]) -> None:
        self.modes = modes

    def __call__(self, speed: np.ndarray) -> np.ndarray:
        speed = np.asarray(speed, dtype=float)
        with np.errstate(all="ignore"):
            parts = [r / ((w0 - speed) * (w0 + speed) + 2j * zeta * w0 * speed) for w0, zeta, r in self.modes]
            return np.abs(sum(parts))

    @property
    def poles(self) -> np.ndarray:
        roots = [w0 * (side * np.sqrt(1 - zeta**2) + 1j * zeta) for w0, zeta, _ in self.modes for side in (1, -1)]
        return np.array(roots)

    def exactly(self, speed: mp.mpf) -> mp.mpf:
        parts = [r / (mp.mpf(w0) ** 2 - speed**2 + 2j * mp.mpf(zeta) * w0 * speed) for w0, zeta, r in self.modes]
        return abs(mp.fsum(parts))

    def top(self, low: float, high: float) -> mp.mpf:
        """The greatest value over the band in 50 digits: golden section around each resonance and at the ends."""
        with mp.workdps(50):
            best = max(self.exactly(mp.mpf(low)), self.exactly(mp.mpf(high)))
            for w0, zeta, _ in self.modes:
                for k in range(-40, 40):
                    a = max(mp.mpf(low), w0 * (1 + mp.mpf(zeta) * (k - 1) / 8))
                    b = min(mp.mpf(high), w0 * (1 + mp.mpf(zeta) * (k + 1) / 8))
                    middle = (a + b) / 2
                    if a < b and self.exactly(middle) > best * (1 - mp.mpf("0.02")):
                        best = max(best, self._section(a, b))
            return best

    def _section(self, a: mp.mpf, b: mp.mpf) -> mp.mpf:
        share = (mp.sqrt(5) - 1) / 2
        for _ in range(45):
            c, d = b - share * (b - a), a + share * (b - a)
            a, b = (a, d) if self.exactly(c) > self.exactly(d) else (c, b)
        return self.exactly((a + b) / 2)


@given(zeta=power(-9, -0.01), stiffness=power(0, 9), mass=power(-3, 4))
@few
def test_the_peak_of_one_mass_is_that_of_the_textbook(zeta: float, stiffness: float, mass: float) -> None:
    """F / (2 k zeta sqrt(1 - zeta^2)) for zeta below 1 / sqrt 2, else F / k at rest."""
    natural = float(np.sqrt(stiffness / mass))
    document = {
        "title": "one mass",
        "bodies": {"body": {"mass": f"{mass!r} kg"}},
        "links": {
            "link": {"between": ["body", "ground"], "stiffness": f"{stiffness!r} N/m", "damping_ratio": zeta}
        },
        "excitations": {
            "force": {
                "kind": "force", "on": "body", "amplitude": "1 N", "speed": f"{10 * natural!r} rad/s",
                "varies": "constant",
            }
        },
        "limits": {"top": {"response": "displacement", "of": "body", "over": "start-up", "at_most": "1 m"}},
    }  # fmt: skip
    limit = pose(from_dict(document)).limits[0]
    with mp.workdps(50):
        ratio = mp.mpf(zeta)
        inside = ratio < 1 / mp.sqrt(2)
        truth = 1 / (stiffness * 2 * ratio * mp.sqrt(1 - ratio**2)) if inside else 1 / mp.mpf(stiffness)
    assert limit.form.worst(limit.model, NONE).value == pytest.approx(float(truth), rel=2e-12)


@given(zeta=power(-8, -1), gap=power(-8, -1), part=st.floats(-1.0, 1.0))
@settings(few, max_examples=6)
def test_near_modes_are_told_apart(zeta: float, gap: float, part: float) -> None:
    modes = Modes([(10.0, zeta, 1.0), (10.0 * (1 + gap), zeta, part)])
    found = greatest(modes, (Band(1.0, 30.0),), modes.poles, NONE)
    assert found.value == pytest.approx(float(modes.top(1.0, 30.0)), rel=1e-7)


@given(slow=power(-9, -1), fast=power(-9, -1), share=power(-3, 9))
@settings(few, max_examples=6)
def test_one_hertz_beside_one_kilohertz(slow: float, fast: float, share: float) -> None:
    modes = Modes([(2 * np.pi, slow, 1.0), (2000 * np.pi, fast, share)])
    found = greatest(modes, (Band(1.0, 1e4),), modes.poles, NONE)
    assert found.value == pytest.approx(float(modes.top(1.0, 1e4)), rel=1e-7)


@pytest.mark.parametrize("band", [(0.0, 10.0), (10.0, 20.0), (5.0, 15.0), (10.0, 10.0)])
def test_an_undamped_resonance_in_the_band_or_at_its_end_is_infinite(band: tuple[float, float]) -> None:
    modes = Modes([(10.0, 0.0, 1.0)])
    found = greatest(modes, (Band(*band),), modes.poles, NONE)
    assert (found.value, found.speed) == (np.inf, pytest.approx(10.0, rel=1e-12))


def test_the_least_value_beside_an_undamped_resonance_is_at_an_end() -> None:
    modes = Modes([(10.0, 0.0, 1.0)])
    found = least(modes, (Band(5.0, 12.0),), modes.poles, NONE)
    assert found.value == pytest.approx(1 / 75.0, rel=1e-12)


@given(zeta=power(-6, -1), level=power(-2, 2))
@few
def test_every_crossing_of_one_mode_is_found_on_its_level(zeta: float, level: float) -> None:
    """(100 - w)^2 + 400 zeta^2 w = level^-2 in the square w of the speed."""
    modes = Modes([(10.0, zeta, 1.0)])
    found = crossings(modes, Band(0.0, 40.0), modes.poles, NONE, level)
    squares = np.roots([1.0, 400.0 * zeta**2 - 200.0, 1e4 - level**-2])
    truth = np.sqrt(np.sort(squares[(np.abs(squares.imag) == 0.0) & (squares.real > 0.0)].real))
    truth = truth[truth < 40.0]
    inner = [speed for speed in found if speed > 1e-6]  # a band may begin on the level itself
    assert inner == pytest.approx(list(truth), rel=1e-9)
    assert modes(np.array(found)) == pytest.approx(np.full(len(found), level), rel=1e-8)


@few
@given(
    gaps=st.lists(st.floats(0.02, 1.0), min_size=3, max_size=9).filter(lambda one: len(one) % 2 == 1),
    start=st.floats(0.05, 1.0),
    zetas=st.sampled_from([0.0, 0.0, 1e-9, 1e-4]),
    wide=st.booleans(),
)
def test_the_least_is_at_a_zero_between_poles_however_sharp(
    gaps: list[float], start: float, zetas: float, wide: bool
) -> None:
    """A driving point: poles and zeros take turns, and every zero without damping is one of the response."""
    places = start + np.cumsum([0.0, *gaps])
    own, zeros = places[::2], places[1::2][: len(places[::2]) - 1]

    def response(speed: np.ndarray) -> np.ndarray:
        w = np.asarray(speed, dtype=float)[..., None]
        with np.errstate(all="ignore"):
            above = ((zeros - w) * (zeros + w)).prod(axis=-1)
            return np.abs(above / ((own - w) * (own + w) + 2j * zetas * own * w).prod(axis=-1))

    poles = np.array([side * w0 * np.sqrt(1.0 - zetas**2) + 1j * zetas * w0 for w0 in own for side in (1.0, -1.0)])
    low, high = (0.5 * start, places[-1] + 1.0) if wide else (0.5 * (own[0] + zeros[0]), 0.5 * (zeros[0] + own[1]))
    found = least(response, (Band(float(low), float(high)),), poles, NONE)
    assert found.value <= 1e-9 * float(response(np.array([low]))[0])
    assert np.abs(zeros - found.speed).min() < 1e-9 * high


@pytest.mark.parametrize("band", [(0.1, 3.0), (0.7, 3.0), (0.7, 1.7)])
def test_two_undamped_masses_stand_still_at_the_own_frequency_of_the_second(band: tuple[float, float]) -> None:
    """Two masses of 1 kg on springs of 1 N/m, the first is shaken: rounding beside a pole hid what is at 1 rad/s."""

    def response(speed: np.ndarray) -> np.ndarray:
        w = np.asarray(speed, dtype=float)
        with np.errstate(all="ignore"):
            return np.abs((1.0 - w**2) / ((2.0 - w**2) * (1.0 - w**2) - 1.0))

    own = np.sqrt((3.0 + np.sqrt(5.0) * np.array([-1.0, 1.0])) / 2.0)
    found = least(response, (Band(*band),), np.concatenate([own, -own]) + 0j, NONE)
    assert found.value < 1e-11
    assert found.speed == pytest.approx(1.0, abs=1e-11)


@pytest.mark.parametrize("rounding", [1e-9, 1e-7, 1e-5])
@pytest.mark.parametrize("modes", [[(3.0, 0.02, 1.0)], [(2.0, 0.3, 1.0), (5.0, 1e-3, 1e-2)]])
def test_rounding_is_not_taken_for_structure(modes: list[tuple[float, float, float]], rounding: float) -> None:
    """Beside links a billion times too stiff a response has few digits: it is measured no oftener, and as well."""
    clean, seen = Modes(modes), 0

    def rough(speed: np.ndarray) -> np.ndarray:
        nonlocal seen
        seen += np.size(speed)
        return clean(speed) * (1.0 + rounding * np.sin(1e12 * np.asarray(speed)))

    found, true = (greatest(one, (Band(1.0, 9.0),), clean.poles, NONE) for one in (rough, clean))
    assert found.value == pytest.approx(true.value, rel=3.0 * rounding)
    assert seen <= 10_000


@pytest.mark.parametrize("share", [1.0, 1e-3, 1e-6, 1e-8, 1e-9, 0.0])
def test_an_undamped_resonance_that_is_hardly_coupled_has_no_end_either(share: float) -> None:
    """Of two modes one is hardly seen, however near; where it is not seen at all it counts for nothing."""
    modes = Modes([(10.0, 0.0, share), (300.0, 0.0, 3e4)])
    bands = (Band(1.0, 20.0),)
    for found in (
        greatest(modes, bands, modes.poles, NONE),
        Search(modes, modes.poles, NONE, least=False).over(bands),
    ):
        assert found.value == (np.inf if share else pytest.approx(3e4 / (300.0**2 - 20.0**2), rel=1e-12))
        assert found.speed == pytest.approx(10.0 if share else 20.0, rel=1e-12)


@st.composite
def harmonics(draw: st.DrawFn) -> list[Line]:
    """Lines of one, or of several powers of the speed, some of them in two pieces."""
    powers = draw(st.sampled_from([(0,), (1,), (2,), (-1,), (0, 2)]))
    lines = []
    for order in range(1, draw(st.integers(1, 4)) + 1):
        ends = draw(st.sampled_from([(0.0, np.inf), (0.0, 30.0, np.inf)]))
        bands = [Band(low, high) for low, high in pairwise(ends)]
        parts = [
            Piece(band, draw(power(-3, 3)), draw(st.floats(-1.0, 1.0)), draw(st.sampled_from(powers))) for band in bands
        ]
        lines.append(Line(float(order), np.ones(1, dtype=complex), Amplitude(tuple(parts))))
    return lines


@few
@given(harmonics(), st.sampled_from([(), (3,), (2, 3)]))
def test_sizes_of_lines_together_are_those_of_each(lines: list[Line], shape: tuple[int, ...]) -> None:
    speed = np.linspace(10.0, 60.0, int(np.prod(shape))).reshape(shape)
    assert np.array_equal(sizes(lines, speed), np.array([line.amplitude.at(speed) for line in lines]))


@given(stiffness=power(-6.0, 9.0), ratio=power(0.0, 6.0))
@few
def test_the_greatest_on_a_heavy_damper_keeps_its_digits(stiffness: float, ratio: float) -> None:
    """What one mass lets through is greatest where w (1 + sqrt(1 + 8 z^2)) = 2 k/m, whatever the damping."""
    damping, top = 2.0 * ratio * sqrt(stiffness), 2.0 * sqrt(stiffness)
    mount = {"between": ["fan", "ground"], "stiffness": f"{stiffness!r} N/m", "damping": f"{damping!r} N s/m"}
    force = {"kind": "force", "on": "fan", "amplitude": "1 N", "speed": f"0..{top!r} rad/s", "varies": "constant"}
    through = {"response": "transmissibility", "into": "ground", "at_most": 1e9}
    scene = {"bodies": {"fan": {"mass": "1 kg"}}, "links": {"mount": mount}}
    [part] = pose(from_dict({**scene, "excitations": {"e": force}, "limits": {"through": through}})).limits
    at = 2.0 / (1.0 + sqrt(1.0 + 8.0 * ratio**2))
    known = sqrt(1.0 + at * (2.0 - at) / ((1.0 - at) ** 2 + 4.0 * ratio**2 * at))
    assert part.form.worst(part.model, np.zeros(0)).value == pytest.approx(known, rel=1e-14)
