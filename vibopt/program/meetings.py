"""Frequencies at which something begins or ends for a limit: where a free motion meets them, it may turn."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray, crossing
from vibopt.mechanics.free_whirls import solved
from vibopt.mechanics.model import DAMPING, STIFFNESS, Model
from vibopt.mechanics.modes import modes_at, poles
from vibopt.mechanics.orbits import Half, Spun, spun
from vibopt.program.program import Aim, Limit

_LIGHT, _SHARP, _STEPS, _ASIDE, _LAST, _NEAR = 0.05, 0.1, 12, 1e-6, 1e-14, 0.02
"""Part of the force of springs up to which a damper moves no frequency that matters; damping ratio up to which a whirl
is met in all coordinates; steps to that; parts of the range of the first, of the last, and of all of them."""
_MODES, _WHIRLS = 96, 32
"""Parts of the range at whose ends natural frequencies are looked at, and whirls."""
_ALL, _FOLLOWED = 1000, 16
"""More than there are motions at rest; whirls that are followed."""

Design = Callable[[float], FloatArray]


def watched(parts: Iterable[Limit | Aim]) -> FloatArray:
    """Orders of single speeds and of the ends of ranges, edges of forbidden bands, bounds of frequencies [rad/s]."""
    found: list[float] = []
    for part in parts:
        found += part.form.watched((part.bound, part.upper) if isinstance(part, Limit) else ())
    return np.array(list(dict.fromkeys(value for value in found if 0.0 < value < np.inf)))


def above(model: Model, x: FloatArray, asked: FloatArray) -> FloatArray:
    """How far each free motion is above each frequency `asked` [rad/s], in an order in which none leaps, shape (n,)."""
    return np.concatenate([_undamped(model, x[None], asked)[0], _damped(model, x, asked)])


def meetings(model: Model, asked: FloatArray, design: Design, least: int) -> list[float]:
    """Places from 0 to 1, each of a design (n_vars,), at which a free motion meets a frequency `asked` [rad/s].

    Undamped motions; and damped ones, where a damper may hold what springs let go.
    """
    places = np.linspace(0.0, 1.0, max(_MODES, least) + 1)
    designs = np.array([design(place) for place in places.tolist()])

    def undamped(place: float) -> FloatArray:
        return np.asarray(_undamped(model, design(place)[None], asked)[0])

    found = _met(undamped, places, _undamped(model, designs, asked))
    if not _braked(model, designs, float(asked.max())):
        return found
    whirls = model.spins or bool(model.bearings)
    places = np.linspace(0.0, 1.0, max(_WHIRLS if whirls else _MODES, least) + 1)
    for some in asked[:, None] if whirls else asked[None]:

        def damped(place: float, some: FloatArray = some) -> FloatArray:
            return _damped(model, design(place), some)

        met = _met(damped, places, np.array([damped(place) for place in places.tolist()]))
        found += [_settled(model, design, float(some[0]), place) for place in met] if whirls else met
    return found


def _met(off: Callable[[float], FloatArray], places: FloatArray, known: FloatArray) -> list[float]:
    """Where a column of what is `known` at places (k, n), and anywhere by `off`, passes zero."""
    found = []
    for index, column in np.argwhere(known[:-1] * known[1:] < 0.0).tolist():

        def gap(place: float, column: int = column) -> float:
            return float(off(place)[column])

        found.append(crossing(gap, float(places[index]), float(places[index + 1])))
    return found


def _undamped(model: Model, designs: FloatArray, asked: FloatArray) -> FloatArray:
    """Of undamped motions at designs (k, n_vars), shape (k, n); bearings that couple both planes have none alone."""
    if model.bearings:
        return np.zeros((len(designs), 0))
    return (modes_at(model, designs)[:, :, None] - asked).reshape(len(designs), -1)


def _damped(model: Model, x: FloatArray, asked: FloatArray) -> FloatArray:
    """Of damped motions, those of a rotor at a spin as fast as asked, shape (n,)."""
    if model.spins or model.bearings:
        rotor = _rotor(model, x)
        each = [_upward(rotor.rates(spin, _ALL)) - spin for spin in asked.tolist()]
    elif (model.kinds == DAMPING).any():
        each = [np.subtract.outer(np.sort(poles(model, model.values(x)).real), asked).ravel()]
    else:
        each = []
    return np.concatenate(each) if each else np.zeros(0)


def _upward(states: ComplexArray) -> FloatArray:
    """How fast the upper half of motions swing, the `_FOLLOWED` slowest: of those that do not swing half are there."""
    upper = np.sort(np.linalg.eigvals(states).imag)[len(states) // 2 :][:_FOLLOWED]
    return np.pad(upper, (0, _FOLLOWED - len(upper)), mode="edge")


def _rotor(model: Model, x: FloatArray) -> Spun:
    rotor = spun(model, x)
    return rotor if model.bearings else Half(rotor, 1.0)


def _braked(model: Model, designs: FloatArray, fastest: float) -> bool:
    """Whether at some design (k, n_vars) a damper pulls at a frequency [rad/s] by more than next to nothing."""
    if model.bearings:
        return True
    n, kinds = model.n_free, model.kinds
    rows = model.vectors[kinds == DAMPING, :n]
    for p in model.values(designs) if len(rows) else ():
        try:
            gives = np.einsum("rn,nr->r", rows, np.linalg.solve(model.sums(STIFFNESS, p)[:n, :n], rows.T))
        except np.linalg.LinAlgError:
            return True
        if not np.all(fastest * p[kinds == DAMPING] * gives <= _LIGHT):
            return True
    return False


def _settled(model: Model, design: Design, asked: float, place: float) -> float:
    """The place near one at which a whirl is as fast as asked [rad/s], in all coordinates; of a heavy one that one."""
    rotor = _rotor(model, design(place))
    rates, ways = np.linalg.eig(rotor.rates(asked, _ALL))
    nearest = int(np.abs(rates.imag - asked).argmin())
    rate, way = complex(-1j * rates[nearest]), rotor.motions(ways[:, [nearest]])[:, 0]
    if abs(rate.imag) > _SHARP * abs(rate):
        return place
    before, here, low = np.nan, place + (_ASIDE if place < 0.5 else -_ASIDE), np.nan
    for _ in range(_STEPS):
        rate, way = solved(_rotor(model, design(here)), asked, rate, way)
        high = rate.real - asked
        step = here - place if np.isnan(low) else high * (here - before) / (high - low) if high != low else 0.0
        before, here, low = here, here - step, high
        if not abs(here - place) <= _NEAR:
            return place
        if abs(step) <= _LAST:
            break
    return min(max(here, 0.0), 1.0)
