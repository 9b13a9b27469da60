"""Greatest whirl of a rotor as built in a run-up, by an implicit Runge-Kutta method (Radau, of fifth order).

The other road: pieces of the shaft by their waves, each plane by itself where bearings are not alike in both, the
lowest motions at rest and the deflections under each force, and steps that an error estimate sets; the greatest is
read off the steps by polynomials through those beside it.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.excitations.excitation import Excitation
from vibopt.excitations.run_up import ends_of, rate_of
from vibopt.mechanics.built import GROUND, Course
from vibopt.mechanics.orbiting import OrbitingMachine
from vibopt.mechanics.rotating import RotatingMachine
from vibopt.records import cached_property, dataclass
from vibopt.responses import TransientResponse
from vibopt.work import worked

_WORK = 0.04
"""Work of a rate of change, or of a state that is read [nominal ms]."""
_FINELY, _AGAIN, _NEAR = 100.0, 3, 1e-5
"""Frequency over the last speed for which the shaft is cut to pieces; how often deflections under forces are followed
by those under their inertia; part of them by which one must differ from the others."""
_ABOVE, _RELATIVE, _ABSOLUTE = 5.0, 1e-7, 1e-7
"""Frequency over the last speed up to which motions at rest are taken; errors of a step."""
_BESIDE, _HIGH, _FINE = 4, 0.98, 2001
"""Steps on either side of a top, part of the greatest that one has, and points between."""
_PERIODS, _LOOKS, _FADED, _GROWS = 6.0, 40, 1e-9, 1e-9
"""Periods of the slowest whirl in a look behind, and how many there are; faded; part of a speed that is no growth."""


@dataclass(frozen=True)
class SpunUp:
    """A built machine with rotors, and an unbalance whose speed rises or falls and then stays."""

    machine: RotatingMachine
    excitation: Excitation

    def peak(self, response: TransientResponse) -> tuple[float, float]:
        """Greatest size of a response over every angle at which the unbalance begins, and the speed then [rad/s]."""
        low, high = ends_of(self.excitation)
        state, last = self._steady(low), self._steady(high)
        rates = np.linalg.eigvals(self._system(high, 0.0)[0]) if np.isfinite(last).all() else np.array([np.inf])
        if not np.isfinite(state).all() or float(rates.real.max()) > _GROWS * high:
            return np.inf, low if not np.isfinite(state).all() else high
        best = max(self._top(response, *run) for run in self._runs)
        steady = float(np.abs(self.built.size(self._values(response, np.array([high]), 0.0, last[:, None])))[0])
        look, most = _PERIODS * 2.0 * np.pi / float(np.abs(rates + 1j * high).min()), 0.0
        for number in range(_LOOKS):
            if number == len(self._looks):
                self._looks.append(self._through((self._looks or self._runs)[-1][2][:, -1], high, 0.0, look))
            top = self._top(response, *self._looks[number])
            best, most = max(best, top), max(most, abs(top[0] - steady))
            left = float(np.linalg.norm(self._looks[number][2][:, -1] - last))
            if left <= _FADED * float(np.linalg.norm(last)) or steady + 2.0 * most < best[0]:
                break
        return (steady, high) if steady >= best[0] else best

    @cached_property
    def _runs(self) -> list[tuple[FloatArray, float, ComplexArray, FloatArray]]:
        """Speeds, their rate, states and times of each part of the run-up on which nothing bends."""
        (low, high), rate = ends_of(self.excitation), rate_of(self.excitation)
        bends = sorted((at for at in self._knots if min(low, high) < at < max(low, high)), reverse=rate < 0.0)
        found, state = [], self._steady(low)
        for a, b in pairwise([low, *bends, high]):
            found.append(self._through(state, a, rate, (b - a) / rate))
            state = found[-1][2][:, -1]
        return found

    @cached_property
    def _looks(self) -> list[tuple[FloatArray, float, ComplexArray, FloatArray]]:
        """The same behind, so far."""
        return []

    @cached_property
    def built(self) -> RotatingMachine:
        """In pieces along which waves hardly bend."""
        return self.machine.cut_for(_FINELY * max(ends_of(self.excitation)))

    @property
    def _knots(self) -> list[float]:
        """Speeds at which a table of a bearing bends [rad/s]."""
        tables = self.built.tables if isinstance(self.built, OrbitingMachine) else []
        return [float(at) for at in np.unique(np.concatenate(tables))] if tables else []

    @property
    def _planes(self) -> int:
        return 2 if isinstance(self.built, OrbitingMachine) else 1

    @cached_property
    def _held(self) -> list[tuple[Any, FloatArray]]:
        """Bearings in planes, each with the row (n,) of its stretch."""
        if not isinstance(self.built, OrbitingMachine):
            return []
        return [(bearing, self._row(*bearing.ends)) for bearing in self.built.bearings.values()]

    def _row(self, first: str, second: str = GROUND) -> FloatArray:
        """Of the second place less the first, over the coordinates of slow motion."""
        found, at = np.zeros(len(self.built.slow[0])), self.built.slow_places
        for place, sign in ((first, -1.0), (second, 1.0)):
            if place in at:
                found[at[place]] += sign
        return found

    @cached_property
    def _few(self) -> tuple[FloatArray, ...]:
        """Motions (n, m) of unit mass, and damping at rest, turning, stiffness and polar inertia in them."""
        machine = self.built
        mass, damping, stiffness, _, polar = machine.slow
        held = stiffness.copy()
        for bearing, row in self._held:
            held += 0.5 * float(np.trace(bearing.stiffness.mean(axis=0))) * np.outer(row, row)
        root = np.linalg.inv(np.linalg.cholesky(held))
        heavy, turned = root @ mass @ root.T, root @ polar @ root.T
        squares, ways = np.linalg.eigh(heavy)
        slow = ways[:, squares > (_ABOVE * max(ends_of(self.excitation))) ** -2]
        rows = [self._row(self.excitation.on), *(self._row(*joint.ends) for joint in machine.joints)]
        bent = [root @ np.array(rows).T]
        for _ in range(_AGAIN):
            bent += [heavy @ bent[-1], turned @ bent[-1]]
        more = np.hstack([one / np.linalg.norm(one, axis=0) for one in bent if one.any()])
        for _ in range(2):
            more = more - slow @ (slow.T @ more)
        more, sizes, _ = np.linalg.svd(more, full_matrices=False)
        shapes = root.T @ np.hstack([slow, more[:, sizes > _NEAR]])
        shapes = shapes @ np.linalg.inv(np.linalg.cholesky(shapes.T @ mass @ shapes)).T
        return shapes, *(shapes.T @ one @ shapes for one in (damping, machine.turning_damping, stiffness, polar))

    @cached_property
    def _ends(self) -> FloatArray:
        """Spins between which damping and stiffness are straight [rad/s]: the rows of tables, or any two."""
        return np.array(self._knots if len(self._knots) > 1 else [0.0, max(ends_of(self.excitation))])

    @cached_property
    def _lines(self) -> dict[int, tuple[float, ComplexArray, ComplexArray]]:
        """Of the stretches that were looked at where they begin, damping and stiffness there, and how these rise."""
        return {}

    def _resisting(self, spin: float) -> ComplexArray:
        """Damping and stiffness at a spin at rest, of y + i z, or of y and z, (2, k, k)."""
        piece = min(max(int(np.searchsorted(self._ends, spin)) - 1, 0), len(self._ends) - 2)
        if piece not in self._lines:
            low, high = self._ends[piece : piece + 2].tolist()
            first, last = (np.array(self._resisting_at(end)) for end in (low, high))
            self._lines[piece] = low, first, (last - first) / (high - low)
        low, first, slope = self._lines[piece]
        return first + (spin - low) * slope

    def _resisting_at(self, spin: float) -> tuple[ComplexArray, ComplexArray]:
        """The same of one spin, part by part."""
        _, damping, turning, stiffness, polar = self._few
        if self._planes == 1:
            return damping + turning - 1j * spin * polar, stiffness - 1j * spin * turning
        both, turned = np.eye(2), np.array([[0.0, 1.0], [-1.0, 0.0]])
        drag = np.kron(both, damping + turning) + spin * np.kron(turned, polar)
        spring = np.kron(both, stiffness) + spin * np.kron(turned, turning)
        for bearing, row in self._held:
            stiff, damp = bearing.at(np.array([spin]))
            square = np.outer(row @ self._few[0], row @ self._few[0])
            drag, spring = drag + np.kron(damp[0], square), spring + np.kron(stiff[0], square)
        return drag.astype(complex), spring.astype(complex)

    def _system(self, spin: float, rate: float) -> tuple[ComplexArray, ComplexArray]:
        """Rates of positions and their rates beside the turning (2 k, 2 k), and what the unbalance adds to them."""
        drag, spring = self._resisting(spin)
        n, unit = len(drag), np.eye(len(drag))
        moved = np.zeros((2 * n, 2 * n), dtype=complex)
        moved[:n, n:], moved[n:, n:] = unit, -drag - 2j * spin * unit
        moved[n:, :n] = -spring - 1j * spin * drag + (spin**2 - 1j * rate) * unit
        return moved, self._push * (spin**2 - 1j * rate)

    @cached_property
    def _push(self) -> ComplexArray:
        """What the unbalance adds to rates of the states, over the square of its speed."""
        push = -self._row(self.excitation.on) @ self._few[0] * self.excitation.swung
        pushed = np.kron(np.array([1.0, -1j])[: self._planes], push)
        return np.concatenate([0.0 * pushed, pushed])

    def _steady(self, spin: float) -> ComplexArray:
        """Steady whirl at a spin as a state; infinite where nothing resists it."""
        system, push = self._system(spin, 0.0)
        try:
            return np.asarray(np.linalg.solve(system, -push))
        except np.linalg.LinAlgError:
            return np.full(len(push), np.inf, dtype=complex)

    def _through(
        self, state: ComplexArray, low: float, rate: float, length: float
    ) -> tuple[FloatArray, float, ComplexArray, FloatArray]:
        """Go on from a state for a time [s] at a rate of the speed [rad/s^2]."""
        from scipy.integrate import solve_ivp

        unit = np.repeat([1.0, max(ends_of(self.excitation))], len(state) // 2)

        def parts(matrix: ComplexArray) -> FloatArray:
            return np.block([[matrix.real, -matrix.imag], [matrix.imag, matrix.real]])

        def changes(time: float, now: Any) -> Any:
            worked(_WORK)
            moved, push = self._system(low + rate * time, rate)
            found = (moved @ (now.reshape(2, -1).T @ [1.0, 1j] * unit) + push) / unit
            return np.concatenate([found.real, found.imag])

        def jacobian(time: float, now: Any) -> Any:
            return parts(self._system(low + rate * time, rate)[0] * unit / unit[:, None])

        size = float(np.abs(self._steady(max(ends_of(self.excitation))) / unit).max())
        run: Any = solve_ivp(
            changes, (0.0, length), np.concatenate([(state / unit).real, (state / unit).imag]), method="Radau",
            jac=jacobian, rtol=_RELATIVE, atol=_ABSOLUTE * size,
        )  # fmt: skip
        real, imaginary = np.split(run.y, 2)
        states, times = (real + 1j * imaginary) * unit[:, None], run.t
        return low + rate * times, rate, states, times

    def _top(
        self, response: TransientResponse, spins: FloatArray, rate: float, states: ComplexArray, times: FloatArray
    ) -> tuple[float, float]:
        """Greatest size within some steps, and its speed [rad/s]."""
        worked(_WORK * len(spins))
        values = self._values(response, spins, rate, states)
        sizes = np.abs(self.built.size(values))
        beside = np.pad(sizes, 1)
        tops = np.flatnonzero((sizes >= beside[:-2]) & (sizes >= beside[2:]) & (sizes >= _HIGH * sizes.max()))
        best = max((float(sizes[k]), float(spins[k])) for k in (0, -1))
        for k in tops.tolist():
            near = slice(max(k - _BESIDE, 0), k + _BESIDE + 1)
            fine = np.linspace(times[max(k - 1, 0)], times[min(k + 1, len(times) - 1)], _FINE)
            found = np.abs(self.built.size(_between(times[near], values[..., near], fine)))
            at = int(found.argmax())
            best = max(best, (float(found[at]), float(np.interp(fine[at], times, spins))))
        return best

    def _values(
        self, response: TransientResponse, spins: FloatArray, rate: float, states: ComplexArray
    ) -> ComplexArray:
        """The response at spins (k,) in states (., k), in the frame that turns, (k,) or (2, k)."""
        moved, fast = np.split(states, 2)
        quick = np.split(np.array([self._rates(*one, rate) for one in zip(spins, states.T, strict=True)]).T, 2)[1]
        course = moved, fast + 1j * spins * moved, quick + 2j * spins * fast + (1j * rate - spins**2) * moved
        shapes, shape = self._few[0], (3, self._planes, -1, len(spins))
        seen = np.einsum("ij,apjk->iapk", shapes, np.array(course).reshape(shape))
        seen = seen if self._planes == 2 else seen[:, :, 0]
        at = self.built.slow_places
        points: dict[str, Any] = {name: seen[i] for name, i in at.items()}
        points |= {name: np.zeros_like(seen[0]) for name in (*self.built.bases, GROUND)}
        force = self.excitation.swung * (spins**2 - 1j * rate)
        pushed: dict[str, Any] = dict.fromkeys(self.built.masses, 0.0 * force)
        pushed |= {self.excitation.on: force if self._planes == 1 else np.array([force, -1j * force])}
        read: Any = response.trace(self.built, Course(points, pushed, spins=spins))
        return np.asarray(read)

    def _rates(self, spin: float, state: ComplexArray, rate: float) -> ComplexArray:
        system, push = self._system(spin, rate)
        return np.asarray(system @ state + push)


def _between(times: FloatArray, values: ComplexArray, fine: FloatArray) -> ComplexArray:
    """The polynomial through values (..., k) at times, at others (n,)."""
    from scipy.interpolate import BarycentricInterpolator

    return np.asarray(BarycentricInterpolator(times, np.moveaxis(values, -1, 0))(fine).T)
