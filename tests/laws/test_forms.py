"""Every form: its value, slope and bounds against a machine of two masses worked out in mpmath, or words of refusal."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import mpmath as mp
import numpy as np
import pytest

from vibopt.arrays import FloatArray
from vibopt.forms import (
    FORMS,
    Added,
    Amplification,
    DampedCriticalSpeed,
    DecayRate,
    EnergyShare,
    Form,
    FreeMotion,
    LogDecrement,
    ModeDamping,
    ModeFrequency,
    ModeGap,
    ModeRatio,
    Modulus,
    Monomials,
    Orbit,
    PeakInRunUp,
    PeakInTime,
    PeakOverDurations,
    PeakRubbing,
    RootMeanSquare,
    Rubbing,
    RubbingOfSeveral,
    StaticBending,
    StaticForce,
    StaticLoad,
    StaticMoment,
    StaticRow,
    WhirlDamping,
    WhirlThreshold,
)
from vibopt.forms.bounds import FormBounds
from vibopt.mechanics.bearings import Bearing
from vibopt.mechanics.model import DAMPING, INERTIA, STIFFNESS, Model, Term
from vibopt.mechanics.monomial import Monomial
from vibopt.program.held import held
from vibopt.program.program import Axis, Limit, Program
from vibopt.signals import Amplitude, Band, Drive, Line, Noise, Output, Piece, Segment, Sweep

_GRAVITY = mp.mpf("9.80665")
_X = (900.0, 1400.0, 6.0)
"""Stiffness of the lower spring [N/m] and of the upper one, damping of both [N s/m]."""
_LOW, _TOP, _RATING = 3.0, 2.0, 40.0
_SPEED = 14.0
_TURNS = 5.0
"""Damping between both masses that turns [N s/m]."""
_ROW = np.array([0.0, 1.0])
_NONE = np.zeros(6)
_FILM = (0.3, 0.1, -0.05, 0.7, 2e-3, 1e-4, -1e-4, 1e-3)
"""Coefficients of a bearing below the lower mass, over the second number."""


def _model(kind: type[Form] | None = None) -> Model:
    """Two masses above each other on springs and dampers; the variables are those of `_X`.  One that rubs is alone."""
    if kind in (Rubbing, RubbingOfSeveral, PeakRubbing):
        first, third = np.eye(3)[[0, 2]]
        rows = [(INERTIA, _LOW, np.zeros(3)), (STIFFNESS, 1.0, first), (DAMPING, 1.0, third)]
        terms = tuple(
            Term(one, np.ones(1), scale, powers, "mount", scale, one != INERTIA) for one, scale, powers in rows
        )
        friction = {("mount", "friction_force"): Monomial(1e-3, {1: 1.0})}
        return Model({}, 1, terms, {"mount": np.ones(1)}, properties=friction)
    lower, upper, none = np.array([1.0, 0.0]), np.array([-1.0, 1.0]), np.zeros(3)
    first, second, third = np.eye(3)
    rows = [
        (INERTIA, lower, _LOW, none),
        (INERTIA, _ROW, _TOP, none),
        (STIFFNESS, lower, 1.0, first),
        (STIFFNESS, upper, 1.0, second),
        (DAMPING, lower, 1.0, third),
        (DAMPING, upper, 1.0, third),
    ]
    terms = tuple(Term(kind, row, scale, powers, "", scale, kind != INERTIA) for kind, row, scale, powers in rows)
    turns = (Term(DAMPING, upper, _TURNS, none, "", _TURNS, across=True),)
    whole = Model({}, 2, terms, rotating=() if kind is PeakInRunUp else turns)
    film = Bearing("film", lower, tuple(Monomial(one, {1: 1.0}) for one in _FILM), np.zeros(0), np.zeros(0))
    return replace(whole, bearings=(film,)) if kind is Orbit else whole


def _matrices(x: Any) -> tuple[Any, Any, Any]:
    k, upper, c = x
    chain = [[k + upper, -upper], [-upper, upper]]
    return mp.diag([_LOW, _TOP]), mp.matrix([[2 * c, -c], [-c, c]]), mp.matrix(chain)


def _state(x: Any) -> Any:
    """First-order matrix of free motion, displacements before velocities."""
    mass, damping, stiffness = _matrices(x)
    found = mp.zeros(4)
    found[0, 2] = found[1, 3] = 1
    for i in range(2):
        for j in range(2):
            found[2 + i, j], found[2 + i, 2 + j] = -stiffness[i, j] / mass[i, i], -damping[i, j] / mass[i, i]
    return found


def _sag(x: Any) -> Any:
    return mp.lu_solve(_matrices(x)[2], mp.matrix([_LOW * _GRAVITY, _TOP * _GRAVITY]))


def _modes(x: Any) -> list[tuple[Any, Any]]:
    """Natural frequencies and the upper motion over the lower one, by the quadratic formula."""
    _, _, k = _matrices(x)
    middle = (k[0, 0] / _LOW + k[1, 1] / _TOP) / 2
    apart = mp.sqrt(middle**2 - (k[0, 0] * k[1, 1] - k[0, 1] ** 2) / (mp.mpf(_LOW) * _TOP))
    squares = (middle - apart, middle + apart)
    return [(mp.sqrt(one), (k[0, 0] - _LOW * one) / -k[0, 1]) for one in squares]


def _poles(x: Any) -> list[Any]:
    return list(mp.eig(_state(x), left=False, right=False))


def _response(x: Any, speed: Any) -> Any:
    mass, damping, stiffness = _matrices(x)
    return abs(mp.lu_solve(stiffness + 1j * speed * damping - speed**2 * mass, mp.matrix([5, 0]))[1])


def _amplified(x: Any) -> Any:
    """Speed of the first peak of the upper mass over its width where it is half of its square."""
    peak = mp.findroot(lambda w: mp.diff(lambda at: _response(x, at) ** 2, w), (11, 13.5), solver="anderson", tol=1e-22)
    half = _response(x, peak) ** 2 / 2
    low, high = (
        mp.findroot(lambda w: _response(x, w) ** 2 - half, ends, solver="anderson", tol=1e-24)
        for ends in ((5, peak), (peak, 20))
    )
    return peak / (high - low)


def _orbit(x: Any) -> Any:
    """Greater half axis of the upper mass under a force on the lower one that goes round, in both planes at once."""
    mass, damping, stiffness = _matrices(x)
    turns, w = _TURNS * mp.matrix([[1, -1], [-1, 1]]), mp.mpf(_SPEED)
    whole = mp.zeros(4)
    own = stiffness + 1j * w * (damping + turns) - w**2 * mass
    whole[:2, :2], whole[2:, 2:], whole[:2, 2:], whole[2:, :2] = own, own, w * turns, -w * turns
    for (i, j), stiff, damp in zip(((0, 0), (0, 2), (2, 0), (2, 2)), _FILM[:4], _FILM[4:], strict=True):
        whole[i, j] += x[1] * (stiff + 1j * w * damp)
    moved = mp.lu_solve(whole, mp.matrix([5, 0, -5j, 0]))
    y, z = moved[1], moved[3]
    return mp.sqrt((abs(y) ** 2 + abs(z) ** 2 + abs(y**2 + z**2)) / 2)


def _spun(x: Any, spin: Any) -> list[Any]:
    """Rates of whirl at a spin, forward ones with a positive imaginary part."""
    mass, damping, stiffness = _matrices(x)
    turns = _TURNS * mp.matrix([[1, -1], [-1, 1]])
    system = mp.zeros(4)
    system[0, 2] = system[1, 3] = 1
    for i in range(2):
        for j in range(2):
            system[2 + i, j] = -(stiffness[i, j] - 1j * spin * turns[i, j]) / mass[i, i]
            system[2 + i, 2 + j] = -(damping[i, j] + turns[i, j]) / mass[i, i]
    return list(mp.eig(system, left=False, right=False))


def _whirls(x: Any) -> Any:
    """The spin at which the fastest growing whirl neither grows nor fades, by secants."""
    return mp.findroot(lambda spin: max(one.real for one in _spun(x, spin)), (40, 60), solver="anderson", tol=1e-25)


def _as_fast(x: Any) -> Any:
    """The spin at which the quicker forward whirl is as fast, by secants."""
    return mp.findroot(lambda spin: max(one.imag for one in _spun(x, spin)) - spin, (30, 40), tol=1e-25)


def _share(x: Any) -> Any:
    return max(_LOW / (_LOW + _TOP * ratio**2) for _, ratio in _modes(x))


def _after(x: Any) -> Any:
    return (mp.expm(_state(x) * mp.mpf("0.03")) * mp.matrix(["0.01", "0.02", 0, "0.1"]))[1]


def _mean_square(x: Any) -> Any:
    """P with A P + P A' + pi S B B' = 0, as linear equations."""
    a, load = _state(x), mp.matrix([0, 0, 1 / mp.mpf(_LOW), 0])
    table, right = mp.zeros(16), mp.zeros(16, 1)
    for i in range(4):
        for j in range(4):
            right[4 * i + j] = -mp.pi * mp.mpf("0.5") * load[i] * load[j]
            for m in range(4):
                table[4 * i + j, 4 * m + j] += a[i, m]
                table[4 * i + j, 4 * i + m] += a[j, m]
    return mp.sqrt(mp.lu_solve(table, right)[5])


def _peak(x: Any) -> Any:
    """The upper mass under a force of 5 N on the lower one: on as long as it rises to its first peak."""
    state = _state(x)
    whole = mp.zeros(5)
    whole[:4, :4] = state
    whole[2, 4] = 5 / mp.mpf(_LOW)

    def at(t: Any) -> Any:
        return mp.expm(whole * t) * mp.matrix([0, 0, 0, 0, 1])

    time = mp.mpf("0.19")
    for _ in range(5):  # Newton's method for the time at which it stands still
        moved = at(time)
        time -= moved[3] / (state[3, :] * moved[:4])[0]
    return at(time)[1]


def _run_up(x: Any) -> Any:
    """The upper mass under a force of 0.1 N s on the lower one times its speed, which rises by 24 rad/s in a second."""
    values, vectors = mp.eig(_state(x))
    parts = mp.lu_solve(vectors, mp.matrix([0, 0, 1 / mp.mpf(_LOW), 0]))

    bend, root = mp.mpc(0, 12), mp.sqrt(mp.mpc(0, -12))

    def whole(pole: Any, s: Any) -> Any:
        """Integral of s e^(bend s^2 - pole s), by the error function."""
        middle = pole / (2 * bend)
        fresnel = mp.sqrt(mp.pi) / (2 * root) * mp.erf(root * (s - middle)) * mp.exp(-bend * middle**2)
        return (mp.exp(bend * s**2 - pole * s) + pole * fresnel) / (2 * bend)

    def at(t: Any) -> tuple[Any, Any]:
        modes = [
            parts[m] * mp.mpf("2.4") * mp.exp(values[m] * t) * (whole(values[m], t) - whole(values[m], 0))
            for m in range(4)
        ]
        pushed = [values[m] * modes[m] + parts[m] * mp.exp(bend * t**2) * mp.mpf("2.4") * t for m in range(4)]
        upper = vectors[1, :]
        return sum(upper[m] * modes[m] for m in range(4)), sum(upper[m] * pushed[m] for m in range(4))

    def rises(t: Any) -> Any:
        here, rate = at(t)
        return mp.re(mp.conj(here) * rate)

    return abs(at(mp.findroot(rises, (mp.mpf("0.97"), mp.mpf("0.98")), solver="secant", tol=1e-14))[0])


def _ratio(x: Any) -> Any:
    return min(-one.real / abs(one) for one in _poles(x) if abs(one.imag) > 1e-9)


def _rubbed(x: Any) -> Any:
    """Den Hartog's formula (1931) for a force of 5 N and a friction of a thousandth of the second number."""
    natural = mp.sqrt(x[0] / _LOW)
    r, ratio, f = _SPEED / natural, x[2] / (2 * _LOW * natural), x[1] / 5000
    ring = mp.sqrt(1 - ratio**2)
    below = mp.cosh(ratio * mp.pi / r) + mp.cos(ring * mp.pi / r)
    g = (mp.sinh(ratio * mp.pi / r) - ratio / ring * mp.sin(ring * mp.pi / r)) / below
    h = mp.sin(ring * mp.pi / r) / (r * ring) / below
    return 5 / x[0] * (mp.sqrt(1 / ((1 - r**2) ** 2 + (2 * ratio * r) ** 2) - (h * f) ** 2) - g * f)


def _pushed(x: Any) -> Any:
    """How far 5 N that stay push what a friction of a thousandth of the second number holds."""
    ratio = x[2] / (2 * mp.sqrt(_LOW * x[0]))
    return (5 - x[1] / 1000) / x[0] * (1 + mp.exp(-mp.pi * ratio / mp.sqrt(1 - ratio**2)))


def _force(x: Any) -> Any:
    down = _sag(x)
    return x[1] * (down[1] - down[0])


_DRIVE = Drive("shaker", (Line(1.0, np.array([5.0 + 0j, 0.0]), Amplitude((Piece(Band(0.0, np.inf), 1.0),))),),
               (Band(_SPEED, _SPEED),))  # fmt: skip
_PUSH = Drive("shaker", (Line(1.0, np.array([5.0 + 0j]), Amplitude((Piece(Band(0.0, np.inf), 1.0),))),),
              (Band(_SPEED, _SPEED),))  # fmt: skip
_READ = Output(_ROW, _NONE)
_ON = Segment(3.0, np.array([1.0]), np.zeros((1, 1)), np.eye(1), np.zeros(1))
_RISING = Sweep((0.0, 24.0), (24.0,), (np.array([0.0, 0.1 + 0j]),), (0.0, 2.4))
_MODULUS, _PEAK = Modulus(_READ, (_DRIVE,), "sum"), PeakInTime(_READ, np.array([[5.0], [0.0]]), (_ON,))
_FACTOR = Monomials(np.array([1.0 / _RATING]), np.array([[1.0, 0.0, 0.0]]))
CASES: dict[type[Form], tuple[Form, Callable[[Any], Any]]] = {
    Added: (
        Added((_MODULUS, _PEAK), squares=True),
        lambda x: mp.sqrt(_response(x, _SPEED) ** 2 + _peak(x) ** 2),
    ),
    Amplification: (Amplification(_READ, (replace(_DRIVE, bands=(Band(5.0, 25.0),)),)), _amplified),
    DampedCriticalSpeed: (DampedCriticalSpeed(1.0, 2, (), 0.0), _as_fast),
    DecayRate: (DecayRate(), lambda x: min(-one.real for one in _poles(x))),
    EnergyShare: (EnergyShare(np.array([1.0, 0.0]), ""), _share),
    FreeMotion: (FreeMotion(_ROW, np.array([0.01, 0.02]), np.array([0.0, 0.1]), 0.03), _after),
    LogDecrement: (LogDecrement(1), lambda x: min(2 * mp.pi * -s.real / s.imag for s in _poles(x) if s.imag > 0)),
    ModeDamping: (ModeDamping(1), _ratio),
    ModeFrequency: (ModeFrequency(2), lambda x: _modes(x)[1][0]),
    ModeGap: (ModeGap(), lambda x: _modes(x)[1][0] - _modes(x)[0][0]),
    ModeRatio: (ModeRatio(1, _ROW, np.array([1.0, 0.0])), lambda x: _modes(x)[0][1]),
    Modulus: (_MODULUS, lambda x: _response(x, _SPEED)),
    Monomials: (
        Monomials(np.array([3.0, 0.2]), np.array([[0.5, 0.0, 1.0], [1.0, 1.0, -1.0]])),
        lambda x: 3 * mp.sqrt(x[0]) * x[2] + mp.mpf("0.2") * x[0] * x[1] / x[2],
    ),
    Orbit: (Orbit(_READ, (_DRIVE,), "sum"), _orbit),
    PeakInTime: (_PEAK, _peak),
    PeakOverDurations: (
        PeakOverDurations(_READ, np.array([[5.0], [0.0]]), lambda lasts: (replace(_ON, length=lasts),), 2.9, 3.0),
        _peak,  # which comes first, and of the longest there is as of the shortest
    ),
    PeakRubbing: (PeakRubbing(Output(np.ones(1), np.zeros(3)), np.array([[5.0]]), (_ON,)), _pushed),
    PeakInRunUp: (PeakInRunUp(_READ, np.array([1.0, 0.0]), _RISING), _run_up),
    RootMeanSquare: (RootMeanSquare(_READ, (Noise("hiss", np.array([1.0, 0.0]), 0.5),)), _mean_square),
    Rubbing: (Rubbing(Output(np.ones(1), np.zeros(3)), (_PUSH,), normalised=False), _rubbed),
    RubbingOfSeveral: (RubbingOfSeveral(Output(np.ones(1), np.zeros(3)), (_PUSH,), normalised=False), _rubbed),
    StaticBending: (
        StaticBending(np.array([0.0, 0.0, 0.0, -1.0, 0.0, 0.0]), _FACTOR),
        lambda x: abs(x[0] / _RATING * _force(x)),
    ),
    StaticForce: (StaticForce(np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0])), _force),
    StaticMoment: (
        StaticMoment(np.array([1.0, 0.0]), _FACTOR, Monomials(np.array([-0.002]), np.array([[0.0, 1.0, 0.0]]))),
        lambda x: abs(x[0] / _RATING * _sag(x)[0] - mp.mpf("0.002") * x[1]),
    ),
    StaticLoad: (StaticLoad(np.array([1.0, 0.0]), _FACTOR), lambda x: x[0] / _RATING * _sag(x)[0]),
    StaticRow: (StaticRow(_ROW), lambda x: _sag(x)[1]),
    WhirlDamping: (
        WhirlDamping(True, ((_SPEED, _SPEED),), 1e3, -1.0, 2),
        lambda x: max(-s.real / abs(s) for s in _spun(x, _SPEED) if s.imag < 0),
    ),
    WhirlThreshold: (WhirlThreshold(), _whirls),
}
"""Of each form one example on the two masses, and its value by formulas of its own."""


@pytest.fixture(autouse=True)
def _digits() -> Iterator[None]:
    with mp.workdps(20):
        yield


@pytest.mark.parametrize("kind", FORMS.values(), ids=lambda kind: kind.__name__)
def test_every_form_says_what_methods_ask(kind: type[Form]) -> None:
    """A value, and for each method an answer or a reason of its own."""
    assert kind in CASES, f"{kind.__name__} has no value here that is worked out by another road"
    model = _model(kind)
    assert kind.value is not Form.value, f"{kind.__name__} has no value"
    form, words = CASES[kind][0], (Form.rough, Form.not_convex, Form.no_bounds)
    assert form.not_smooth(model) not in words, f"{kind.__name__} has no word on CasADi"
    convex = kind.convex_limit is not Form.convex_limit or kind is Modulus  # whose rows hang on the limit
    assert convex or form.not_convex not in words, f"{kind.__name__} has no word on cvxpy"
    bounded = kind.on_boxes is not Form.on_boxes
    assert bounded or form.no_bounds not in words, f"{kind.__name__} has no word on boxes"


@pytest.mark.parametrize("kind", FORMS.values(), ids=lambda kind: kind.__name__)
def test_values_and_slopes_are_those_of_another_road(kind: type[Form]) -> None:
    form, right = CASES[kind]
    model, x = _model(kind), np.array(_X)
    assert form.value(model, x) == pytest.approx(float(right([mp.mpf(one) for one in _X])), rel=1e-9)
    assert form.worst(model, x).value == form.value(model, x)
    for i, found in enumerate(form.slope(model, x)):

        def log(y: Any, i: int = i) -> Any:
            return mp.log(right([mp.mpf(one) * (mp.exp(y) if j == i else 1) for j, one in enumerate(_X)]))

        step = mp.mpf("1e-6")
        wide = 2e-7 if kind is Amplification else 2e-8  # differences of a top known to 1e-11, over a step of 1e-4
        assert found == pytest.approx(float((log(step) - log(-step)) / (2 * step)), rel=1e-6, abs=wide)


@pytest.mark.parametrize("kind", FORMS.values(), ids=lambda kind: kind.__name__)
def test_with_variables_held_it_is_the_same_number(kind: type[Form]) -> None:
    model, form, x = _model(kind), CASES[kind][0], np.array(_X)
    axes = tuple(Axis(name, 0.5 * one, 2.0 * one) for name, one in zip("kuc", _X, strict=True))
    program = Program(model, axes, (Limit("asked", model, form, "at_most", 1.0),), None)
    for free in ([0], [2, 1]):
        (limit,) = held(program, x, free).limits
        assert limit.form.value(limit.model, x[free]) == pytest.approx(form.value(model, x), rel=1e-12)
        slope = form.slope(model, x)[free]
        assert limit.form.slope(limit.model, x[free]) == pytest.approx(slope, rel=1e-8, abs=1e-8)


@pytest.mark.parametrize("kind", FORMS.values(), ids=lambda kind: kind.__name__)
def test_bounds_on_boxes_hold_all_values_in_them(kind: type[Form]) -> None:
    """Of what has bounds on such boxes; at a single design they are its value where that is exact."""
    form, right = CASES[kind]
    model, x, rng = _model(kind), np.array(_X), np.random.default_rng(len(kind.__name__))
    bounds = FormBounds(model, form, x)
    bounds.add({"shaker": _SPEED})
    assert bounds.bounded == form.bounded(model)
    assert bounds.known or not bounds.bounded or kind in (RootMeanSquare, DecayRate, ModeDamping, LogDecrement)
    if not bounds.bounded:
        return
    for wide in (0.5, 0.05, 1e-3):
        low, high = x * np.exp(-wide * rng.random(3)), x * np.exp(wide * rng.random(3))
        below, above = (float(one[0]) for one in bounds.on(low[None, :], high[None, :]))
        assert below <= above
        for design in (low, high, *(low + (high - low) * rng.random((6, 3)))):
            value = float(right([mp.mpf(one) for one in design.tolist()]))
            assert below * (1.0 - 1e-9) <= value <= above * (1.0 + 1e-9)
            if bounds.known:  # of mean squares and poles bounds alone are: they are measured where a value is wanted
                _at_points(bounds, design, value)


def _at_points(bounds: FormBounds, design: FloatArray, value: float) -> None:
    """Many designs at once: the value itself, at the only speed asked for as well."""
    most, least = bounds.at(design[None, :])
    assert (most[0], least[0]) == (pytest.approx(value, rel=1e-9), pytest.approx(value, rel=1e-9))


def test_a_form_that_lacks_something_is_caught_by_name(monkeypatch: pytest.MonkeyPatch) -> None:
    class Unfinished(Form):
        """Says nothing of itself."""

    with pytest.raises(AssertionError, match="Unfinished has no value here"):
        test_every_form_says_what_methods_ask(Unfinished)
    monkeypatch.setitem(CASES, Unfinished, (Unfinished(), lambda x: x[0]))
    with pytest.raises(AssertionError, match="Unfinished has no value"):
        test_every_form_says_what_methods_ask(Unfinished)
    Unfinished.value = lambda self, model, x: float(x[0])
    with pytest.raises(AssertionError, match="Unfinished has no word on CasADi"):
        test_every_form_says_what_methods_ask(Unfinished)
    Unfinished.rough = Unfinished.not_convex = "is unfinished"
    with pytest.raises(AssertionError, match="Unfinished has no word on boxes"):
        test_every_form_says_what_methods_ask(Unfinished)
    Unfinished.no_bounds = "is unfinished"
    Unfinished.slope = lambda self, model, x: np.ones(3)
    test_every_form_says_what_methods_ask(Unfinished)
    with pytest.raises(AssertionError):
        test_values_and_slopes_are_those_of_another_road(Unfinished)


def test_a_power_that_is_zero_has_the_slope_of_its_exponents() -> None:
    """A damper that is best left out is none: in logs what it adds fades as it does, and a nan warned the user."""
    power, x = Monomials(np.array([2.0]), np.array([[1.0, 0.5]])), np.array([0.0, 3.0])
    model = _model()
    assert power.slope(model, x).tolist() == [1.0, 0.5]
    assert power.bend(model, x).tolist() == [[0.0, 0.0], [0.0, 0.0]]
