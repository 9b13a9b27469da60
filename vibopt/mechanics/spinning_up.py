"""Run-up of a rotor whose whirl hangs on its spin: gyroscopic moments, dampers that turn with it, bearings by speed.

The spin W changes at a given rate a, and y + i z = F e^{i p} + conj(B e^{i p}), where p' = W:

    M F" + (C + C_i - i W G) F' + (K - i W C_i) F = m e (W^2 - i a) e^{i p},   B alike with -W and no load,

coupled by what bearings do.  The torque on each piece goes along the axis of that piece as it is tilted, so that the
acceleration adds no moment.  In the frame that turns with the spin all this is smooth but for free whirls that fade:
polynomials on panels, by collocation at Gauss's points, each panel as long as its last coefficients allow.  Motions are
those that forces at the unbalance, dampers and bearings drive.
"""

from __future__ import annotations

from contextlib import suppress
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.polynomial import legendre
from numpy.polynomial.polynomial import polyval

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.mechanics.model import DAMPING, INERTIA, STIFFNESS
from vibopt.mechanics.orbits import Half, spun
from vibopt.mechanics.peaks_in_time import Peak
from vibopt.mechanics.ringing import HORIZON
from vibopt.records import cached_property
from vibopt.signals import Output, Sweep

if TYPE_CHECKING:
    from vibopt.mechanics.model import Model

_POINTS = 10
_NODES, _WEIGHTS = legendre.leggauss(_POINTS)
_TIMES = 0.5 * (1.0 + _NODES)
_INTO = (legendre.legvander(_NODES, _POINTS - 1) * _WEIGHTS[:, None]).T * (np.arange(_POINTS)[:, None] + 0.5)
"""Coefficients of Legendre's polynomials from values at the points."""
_ONCE = np.array([0.5 * legendre.legval(_NODES, legendre.legint(row, lbnd=-1)) for row in np.eye(_POINTS)]).T @ _INTO
"""Integral from the beginning to each point, of values at the points, over the length of a panel."""
_TWICE, _WHOLE = _ONCE @ _ONCE, 0.5 * _WEIGHTS
_FINE = np.linspace(-1.0, 1.0, 65)
_LEFT, _CAREFUL, _BETWEEN, _SHORTER = 1e-7, 0.9, (0.3, 4.0), 0.8
"""Part of the greatest that the last coefficients may be; how the next panel is measured by what one leaves over."""
_MOST, _TOPS, _ZOOMS = 20_000, 8, 4
"""Panels in all; those that are looked at closely, and how often."""
_REACH, _KEPT, _FAST = 1.5, 1e-5, 3.0
"""Frequency over the greatest spin up to which motions are kept; part of them by which one must differ from the others;
frequency over the greatest spin from which on a motion follows a jump of the force at once."""
_ANGLES, _SPINS = 10, 3
"""Frequencies of either sense, and spins, at which motions are taken."""
_SURE, _NOTHING, _GAINED = 1e-12, 1e-14, 1e-9
"""Rounding of a part, and of a period squared; part of a frequency that is no growth."""


class SpinUp:
    """The rotor of a model at a design x (n_vars,) in a run-up, and what is read of it.

    Motions are forward, and backward behind, of unit stiffness without bearings that are not alike in both planes.
    """

    def __init__(self, model: Model, x: FloatArray, output: Output, load: FloatArray, sweep: Sweep) -> None:
        self.model, self.x, self.output, self.sweep = model, x, output, sweep
        whole, n = spun(model, x), model.n_free
        self.rotor = whole if model.bearings else Half(whole, 1.0)
        self.senses = np.array([1.0, -1.0] if model.bearings else [1.0])
        self.top, self.knots = max(sweep.speeds), whole.knots
        self._known: dict[float, tuple[ComplexArray, ComplexArray]] = {}
        turning = [term.vector[:n] for term in model.rotating if term.across]
        damped = model.vectors[(model.kinds == DAMPING) & (whole.p != 0.0), :n]
        pushes = np.array([load[:n], *damped, *(bearing.row[:n] for bearing in model.bearings), *turning])
        self.shapes = _motions(whole.held, whole.mass, whole.polar, pushes, self.top)
        self.load = load[:n] @ self.shapes
        self._both = np.kron(np.eye(len(self.senses)), self.shapes)
        self._heavy = np.kron(np.eye(len(self.senses)), self.shapes.T @ whole.mass @ self.shapes)
        self._pushed = np.concatenate([self.load, np.zeros(len(self.load) * (len(self.senses) - 1))])

    def resisting(self, spin: float) -> tuple[ComplexArray, ComplexArray]:
        """Damping and stiffness at a spin, over all motions: straight between rows of tables."""
        knots = self.knots if len(self.knots) else np.array([0.0, self.top])
        k = int(np.clip(np.searchsorted(knots, spin) - 1, 0, len(knots) - 2))
        part = (spin - knots[k]) / (knots[k + 1] - knots[k])
        (damp, stiff), (more, stiffer) = self._resisting(float(knots[k])), self._resisting(float(knots[k + 1]))
        return damp + part * (more - damp), stiff + part * (stiffer - stiff)

    def _resisting(self, spin: float) -> tuple[ComplexArray, ComplexArray]:
        if spin not in self._known:
            both = -1j * self.rotor.powers(spin)[0], self.rotor.dynamic(0.0, spin)
            self._known[spin] = self._both.T @ both[0] @ self._both, self._both.T @ both[1] @ self._both
        return self._known[spin]

    def still(self, spin: float, size: float) -> ComplexArray:
        """Steady whirl at a spin under a force of a size; raises LinAlgError where nothing resists."""
        damp, stiff = self.resisting(spin)
        return np.asarray(np.linalg.solve(stiff + 1j * spin * damp - spin**2 * self._heavy, self._pushed * size))

    def reading(self, spin: FloatArray, moved: ComplexArray, fast: ComplexArray, quick: ComplexArray) -> ComplexArray:
        """Forward and backward part (s, k) of what is read, by motion and its rates (k, .) beside the turning."""
        parts = [one.reshape(len(spin), len(self.senses), -1) for one in (moved, fast, quick)]
        along, by, power = self._rows, -1j * spin[:, None] * self.senses, self.output.power
        seen = sum(parts[min(i + power, 2)] @ along[i] for i in range(3 - power))
        seen = seen + by * (parts[1] @ along[3] + parts[0] @ along[4])
        for bearing in self.model.bearings:
            if share := dict(self.output.held).get(bearing.name):
                row, (held, drag) = bearing.row[: self.model.n_free] @ self.shapes, bearing.whirling(self.x, spin)
                force = held @ (parts[0] @ row)[..., None] + drag @ (parts[1] @ row)[..., None]
                seen = seen + share * force[..., 0]
        return np.asarray(seen.T)

    @cached_property
    def _rows(self) -> FloatArray:
        """Position, velocity, acceleration that are read, and velocity and position times -i W, (5, m)."""
        model, n, found = self.model, self.model.n_free, np.zeros((5, self.model.n_free))
        found[0] = self.output.row[:n]
        polar = np.array([term.polar for term in model.terms])
        pulled = (self.output.signs * model.values(self.x))[:, None] * model.vectors[:, :n]
        for i, kind in enumerate((STIFFNESS, DAMPING, INERTIA)):
            found[i] += pulled[(model.kinds == kind) & ~polar].sum(axis=0)
        found[3] = -pulled[polar].sum(axis=0)
        for term in model.rotating:
            size = term.scale * float(np.prod(self.x**term.exponents))
            found[[1, 4]] += dict(self.output.held).get(term.owner, 0.0) * size * term.vector[:n]
        return np.asarray(found @ self.shapes)

    @cached_property
    def _fast(self) -> tuple[FloatArray, FloatArray]:
        """How far a force of one moves each motion that is so fast that it follows at once, (k, .), and how fast."""
        squares, each = np.linalg.eigh(self._heavy[: len(self.load), : len(self.load)])
        fast = squares < (_FAST * self.top) ** -2
        rates = 1.0 / np.sqrt(np.maximum(squares[fast], _NOTHING * squares.max()))
        return np.kron(self.senses > 0.0, (each * (self.load @ each))[:, fast].T), rates

    def follows(self, force: complex) -> ComplexArray:
        """How far the fast motions go under a jump of the force; the free whirl that it sets off is left out."""
        return np.asarray(self._fast[0].sum(axis=0) * force)

    @property
    def left_out(self) -> float:
        """What these free whirls, set off as the change of speed begins and ends, may add at most."""
        sweep, (moved, rates) = self.sweep, self._fast
        jumps = [abs(polyval(sweep.speeds[i], sweep.powers[i]) - sweep.still[i]) for i in (0, -1)]
        path, turns = moved.astype(complex), (1j * rates[:, None]).astype(complex)
        each = self.reading(0.0 * rates, path, turns * path, turns**2 * path)
        return float(np.abs(each).sum() * sum(jumps))

    def steady(self, reading: object, speeds: FloatArray) -> FloatArray:
        """Greater half axis of the steady whirl at spins of the run-up [rad/s], (n,)."""
        found = np.full(len(speeds), np.inf)
        for k, spin in enumerate(speeds.tolist()):
            with suppress(np.linalg.LinAlgError):
                found[k] = self.size_of(spin, self.still(spin, self.force(spin)))
        return found

    def force(self, spin: float) -> float:
        """Size of the force at a steady speed [rad/s]; what the change of speed adds is out of step with it."""
        return float(polyval(spin, self.sweep.powers[0].real))

    def size_of(self, spin: float, moved: ComplexArray) -> float:
        """Greater half axis of what is read in a steady whirl at a spin [rad/s]."""
        at, path = np.array([spin]), moved[None]
        return float(np.abs(self.reading(at, path, 1j * spin * path, -(spin**2) * path)).sum())

    @cached_property
    def _course(self) -> _Course:
        return _Course(self)

    def peak(self, reading: object = None) -> Peak:
        """Greatest size of what is read over every angle at which it begins, from the beginning on, for ever."""
        try:
            return self._course.peak()
        except np.linalg.LinAlgError:
            return Peak(np.inf, 0.0)

    def history(self, reading: object, times: FloatArray) -> FloatArray:
        """Greatest size of what is read over every angle, at times of the run-up [s], (n,)."""
        return self._course.at(times)


class _Course:
    """The run-up panel by panel: beginnings and lengths [s], and readings at Gauss's points (n, s, points)."""

    def __init__(self, whirl: SpinUp) -> None:
        self.whirl, sweep, top = whirl, whirl.sweep, whirl.top
        moved = whirl.still(sweep.speeds[0], sweep.still[0])
        self.state = np.array([moved, 0.0 * moved], dtype=complex)
        size = max(abs(whirl.force(top)), *sweep.still)
        quiet = np.asarray(np.linalg.solve(whirl.resisting(top)[1], whirl._pushed * size), dtype=complex)
        self.most, self.strong = whirl.size_of(top, quiet), float(np.linalg.norm(quiet))
        self.reached = 0.0  # `most` begins with a size to compare with, which may never be reached
        self.begun: list[float] = []
        self.long: list[float] = []
        self.seen: list[ComplexArray] = []
        self.time, self.full, step, before = 0.0, False, float(sweep.times[-1]) / 16.0, complex(sweep.still[0])
        for low, high, rate, powers in zip(sweep.speeds, sweep.speeds[1:], sweep.rates, sweep.powers, strict=False):
            self.state[0] += whirl.follows(complex(polyval(low, powers)) - before)
            before, knots = complex(polyval(high, powers)), whirl.knots
            inside = knots[(knots > min(low, high)) & (knots < max(low, high))]
            for a, b in pairwise([low, *(inside if high > low else inside[::-1]).tolist(), high]):
                step = self._through((a, b), rate, (b - a) / rate, powers, step)
        self.state[0] += whirl.follows(sweep.still[1] - before)
        self.behind = self._behind(step)

    def _through(
        self, ends: tuple[float, float], rate: float, length: float, powers: ComplexArray, step: float
    ) -> float:
        """Go on for a time without a bend from one spin to another; returns the length of a panel that would do."""
        first = self.whirl.resisting(ends[0])
        per = [(b - a) / (ends[1] - ends[0] or 1.0) for a, b in zip(first, self.whirl.resisting(ends[1]), strict=True)]
        straight, done = [*zip(first, per, strict=True)], 0.0
        while done < length * (1.0 - _SURE) and not self.full:
            span = min(step, length - done)
            left, state, seen = self._panel(straight, (ends[0], ends[0] + rate * done), rate, span, powers)
            grows = float(np.clip(_CAREFUL * max(left, _SURE) ** (-1.0 / (_POINTS - 1)), *_BETWEEN))
            if left > 1.0 and span > _SURE * length:
                step = min(grows, _SHORTER) * span
                continue
            self.begun.append(self.time + done)
            self.long.append(span)
            self.seen.append(seen)
            self.state, done = state, done + span
            self.reached = max(self.reached, float(np.abs(seen).sum(axis=0).max()))
            self.most = max(self.most, self.reached)
            self.strong = max(self.strong, float(np.linalg.norm(state[0])))
            self.full = len(self.seen) >= _MOST
            step = max(grows * span, step if span < step else 0.0)
        self.time += length
        return step

    def _panel(
        self, straight: list[tuple[ComplexArray, ComplexArray]], spins: tuple[float, float], rate: float, span: float,
        powers: ComplexArray,
    ) -> tuple[float, ComplexArray, ComplexArray]:  # fmt: skip
        """What one panel leaves over, in parts of what it may; the state at its end, and what is read on it."""
        heavy, times = self.whirl._heavy, _TIMES * span
        spin = spins[1] + rate * times
        at = spin[:, None, None]
        damp, stiff = (first + (at - spins[0]) * per for first, per in straight)
        damp, stiff = damp + 2j * at * heavy, stiff + 1j * at * damp + (1j * rate - at**2) * heavy
        moved, fast = self.state
        push = polyval(spin, powers)[:, None] * self.whirl._pushed - stiff @ moved
        push -= (damp + times[:, None, None] * stiff) @ fast
        once, twice = (one[:, None, :, None] for one in (_ONCE / span, _TWICE))
        whole = damp[:, :, None] * once + stiff[:, :, None] * twice
        whole[range(_POINTS), :, range(_POINTS)] += heavy / span**2
        bent = np.linalg.solve(whole.reshape(push.size, push.size), push.ravel()).reshape(push.shape)
        path, rates, at = moved + times[:, None] * fast + _TWICE @ bent, fast + _ONCE @ bent / span, spin[:, None]
        quick = bent / span**2 + 2j * at * rates + (1j * rate - at**2) * path
        seen = self.whirl.reading(spin, path, rates + 1j * at * path, quick)
        tail = float(np.linalg.norm(np.abs(_INTO[-2:] @ path).max(axis=0))) / self.strong
        shown = float(np.abs(seen @ _INTO[-2:].T).max()) / max(self.most, float(np.abs(seen).max()), 1e-300)
        end = np.array([moved + span * fast + (_WHOLE * (1.0 - _TIMES)) @ bent, fast + _WHOLE @ bent / span])
        return max(tail, shown) / _LEFT, end, seen

    def _behind(self, step: float) -> tuple[float, bool]:
        """Go on at the last spin until nothing greater can come; the steady size there, and whether it may yet."""
        whirl, spin, size = self.whirl, self.whirl.sweep.speeds[-1], self.whirl.sweep.still[1]
        still, unit = whirl.still(spin, size), np.eye(len(whirl._heavy))
        steady, n, begun = whirl.size_of(spin, still), len(still), self.time
        damp, stiff = (np.linalg.solve(whirl._heavy, one) for one in whirl.resisting(spin))
        rates, ways = np.linalg.eig(np.block([[0.0 * unit, unit], [-stiff, -damp]]))
        slow = float(np.abs(rates).min())
        if rates.real.max() > _GAINED * slow:
            return np.inf, False
        off = self.state[0] - still
        ways = ways * np.linalg.solve(ways, np.concatenate([off, self.state[1] + 1j * spin * off]))
        each = whirl.reading(np.full(2 * n, spin), ways[:n].T, ways[n:].T, (ways[n:] * rates).T)
        powers = np.array([size], dtype=complex)
        period = 2.0 * np.pi / slow
        while self.time - begun < HORIZON * period and not self.full:
            fading = float(np.abs(each).sum(axis=0) @ np.exp(rates.real * (self.time - begun)))
            best = max(self.reached, steady)
            if steady + fading <= best * (1.0 + _SURE) or fading <= _LEFT * best:
                return steady, False
            step = self._through((spin, spin), 0.0, min(4.0 * period, step * 64.0), powers, step)
        return steady, True

    def peak(self) -> Peak:
        """The greatest on all panels, between their points."""
        steady, more = self.behind
        if not np.isfinite(steady):
            return Peak(np.inf, np.inf)
        long, begun, best = np.array(self.long), np.array(self.begun), (0.0, 0.0)
        fine = np.abs(np.array(self.seen) @ (legendre.legvander(_FINE, _POINTS - 1) @ _INTO).T).sum(axis=1)
        for k in np.argsort(-fine.max(axis=1), kind="stable")[:_TOPS].tolist():
            at, reach = float(_FINE[int(fine[k].argmax())]), float(_FINE[1] - _FINE[0])
            for _ in range(_ZOOMS):
                near = begun[k] + 0.5 * long[k] * (1.0 + np.clip(np.linspace(at - reach, at + reach, 33), -1.0, 1.0))
                sizes = self.at(near, k)
                top = int(sizes.argmax())
                at, reach = 2.0 * (near[top] - begun[k]) / long[k] - 1.0, reach / 16.0
            best = max(best, (float(sizes[top]), float(near[top])))
        if steady > best[0] * (1.0 + _LEFT):
            return Peak(steady, np.inf, open=more)
        return Peak(*best, open=more)

    def at(self, times: FloatArray, panel: int | None = None) -> FloatArray:
        """Size of what is read at times up to the end of the last panel [s], (n,); on one panel, where it is said."""
        begun = np.array(self.begun)
        which = (
            np.clip(np.searchsorted(begun, times, side="right") - 1, 0, None) if panel is None else np.array([panel])
        )
        part = np.clip(2.0 * (times - begun[which]) / np.array(self.long)[which] - 1.0, -1.0, 1.0)
        rows = legendre.legvander(part, _POINTS - 1) @ _INTO
        return np.asarray(np.abs((np.array(self.seen)[which] @ rows[..., None])[..., 0]).sum(axis=1))


def _motions(held: FloatArray, mass: FloatArray, polar: FloatArray, pushes: FloatArray, top: float) -> FloatArray:
    """Motions (n, m), of unit stiffness, that forces (r, n) drive at whirls and spins up to about `top` [rad/s]."""
    root = np.linalg.inv(np.linalg.cholesky(held))
    heavy, spins, drives = root @ mass @ root.T, root @ polar @ root.T, root @ pushes.T
    angles = _REACH * top * np.cos(np.pi * (np.arange(_ANGLES) + 0.5) / (2 * _ANGLES))
    found = [drives]
    for spin in np.linspace(0.0, top, _SPINS):
        for whirl in (*angles, *-angles):
            found.append(np.linalg.solve(np.eye(len(held)) - whirl**2 * heavy + whirl * spin * spins, drives))
    every = np.concatenate(found, axis=1)
    ways, sizes, _ = np.linalg.svd(every / np.linalg.norm(every, axis=0), full_matrices=False)
    return np.asarray(root.T @ ways[:, sizes > _KEPT * sizes[0]])
