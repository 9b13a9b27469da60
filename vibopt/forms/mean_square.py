"""Root mean square under white noise, through a Lyapunov equation, with its exact slope.

White noise of one-sided density S (over the angular frequency) drives x' = A x + B w; then P solves
A P + P A^T + pi S B B^T = 0 and the mean square of y = c x is c P c^T.  Its slope comes from the
adjoint equation, with the slopes of A, B and c by complex steps.

A base whose acceleration is white drifts away without end.  What follows it (relative motion, link
forces) is written in coordinates that ride on the base.  Where ground holds the machine back, and where the
displacement of a base is white, the base is among the states (`noise_states`).
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from vibopt.arrays import BoolArray, FloatArray
from vibopt.forms.form import kept
from vibopt.forms.noise_states import (
    States,
    beside_base,
    decaying,
    held_first,
    on_carrier,
    slow,
    under_displacement,
    under_force,
)
from vibopt.forms.reduce import closure
from vibopt.mechanics.harmonic import mount_count
from vibopt.mechanics.model import DAMPING, INERTIA, STIFFNESS, Model
from vibopt.records import dataclass
from vibopt.signals import Noise, Output

if TYPE_CHECKING:
    from vibopt.forms.root_mean_square import RootMeanSquare

Numbers = np.ndarray[Any, np.dtype[Any]]
"""Real, or complex with the imaginary part as a slope."""
Matrices = Callable[[Numbers], States | None]
"""States at coefficients p (n_terms,)."""
_NOTHING = 1e-11
"""Part of its own size below which an excitation or a reading has no share in something."""
_STEP = 1e-30
_APART, _AGAIN, _TOGETHER = 1e5, 8, 0.99
"""Fastest over slowest rate from which a solution is made better, how often at most, and up to which correlation."""
_CANCELS, LOST = 1e-4, 1e-15
"""Part of what the states would come to together up to which digits are lost, and a mean square is rounding."""


def root_mean_square(model: Model, form: RootMeanSquare, x: FloatArray) -> float:
    """Root mean square of the response at design x (n_vars,); inf where it is infinite."""
    return float(np.sqrt(max(sum(_squares(model, form, x)), 0.0))) / mount_count(model, form.output, x)


def _squares(model: Model, form: RootMeanSquare, x: FloatArray) -> list[float]:
    """The mean square under each noise at design x (n_vars,)."""

    def measured(every: FloatArray) -> list[list[float]]:
        return [[_mean_square(model, form.output, noise, p) for noise in form.noises] for p in map(model.values, every)]

    return kept(model, form, x[None], measured)[0]


def root_mean_square_slope(model: Model, form: RootMeanSquare, x: FloatArray) -> FloatArray:
    """Slope of its log in log x, shape (n_vars,); zero where it is infinite or nothing moves."""
    p = model.values(x)
    total, slope = 0.0, np.zeros(model.n_vars)
    for noise, square in zip(form.noises, _squares(model, form, x), strict=True):
        total += square
        if np.isfinite(square) and square > 0.0:
            slope += _slope(model, form.output, noise, p)
    found = slope / (2.0 * total) if 0.0 < total < np.inf else np.zeros(model.n_vars)
    if form.output.shared_by:
        found = found - model.counts[form.output.shared_by].row(model.n_vars)
    return found


@dataclass(frozen=True)
class _Frame:
    """Coordinates in which one noise is answered, at one design.

    basis
        Motions that are damped, (n_free, d), mass-normalised; the first `held` are held by springs.
    held
        Number of motions that springs hold.
    rate
        Typical rate [rad/s]: time is counted in its inverse.
    ride
        Motion of the free coordinates with a base, (n_free,); None for forces, and where ground holds them back.
    loose
        Whether the place of a motion that no spring holds is read: the integral of its velocity.
    """

    model: Model
    output: Output
    noise: Noise
    basis: FloatArray
    held: int
    rate: float
    ride: FloatArray | None
    loose: bool = False

    def states(self, p: Numbers) -> States:
        """The m = held + d states at coefficients p (n_terms,), real or complex."""
        n, model, held = self.model.n_free, self.model, self.held
        free = model.vectors[:, :n] @ self.basis
        mass, stiff, damping = ((free.T * (p * (model.kinds == kind))) @ free for kind in (INERTIA, STIFFNESS, DAMPING))
        inverse = np.linalg.inv(mass)
        stiff, damping = inverse @ stiff / self.rate**2, inverse @ damping / self.rate
        size = held + len(mass)
        a = np.zeros((size, size), dtype=p.dtype)
        a[:held, held:] = np.eye(held, len(mass))
        a[held:, :held] = -stiff[:, :held]
        a[held:, held:] = -damping
        c0, c1 = self._reading(p, free, stiff, damping)
        b, c = np.zeros(size, dtype=p.dtype), np.concatenate([c0[:held], c1])
        b[held:] = inverse @ self._load(p, free) / self.rate**1.5
        if self.loose:
            velocities = np.zeros_like(c)
            velocities[2 * held :] = c0[held:]
            c = c + np.linalg.solve(a.T, velocities)
        return States(a, b, c, np.concatenate([np.zeros_like(self.basis[:, :held]), self.basis], axis=1), self.rate)

    def runs_away(self, p: FloatArray) -> bool:
        """Whether a motion that no spring holds is read, and pushed without anything to stop it."""
        if not self.loose:
            return False
        found = self.states(p)  # of motions that are damped: what is not held settles at a speed of its own
        read = self.output.row[: self.model.n_free] @ self.basis[:, self.held :]
        return not _small(np.linalg.solve(found.a.T, np.concatenate([np.zeros(2 * self.held), read])), found.b)

    def _load(self, p: Numbers, free: FloatArray) -> Numbers:
        """Forces of the noise on the motions, (d,)."""
        if self.ride is None:
            return np.asarray(self.basis.T @ self.noise.vector[: self.model.n_free])
        riding = (p * _own_inertia(self.model)) * (self.model.vectors[:, : self.model.n_free] @ self.ride)
        return np.asarray(-free.T @ riding)

    def _reading(self, p: Numbers, free: FloatArray, stiff: Numbers, damping: Numbers) -> tuple[Numbers, Numbers]:
        """Parts of the response per position and per velocity (times 1 / rate), each (d,)."""
        model, output = self.model, self.output
        row = (output.row[: model.n_free] @ self.basis).astype(p.dtype)
        if output.signs.any():
            weight = output.signs * p
            return (weight * (model.kinds == STIFFNESS)) @ free + row, (
                weight * (model.kinds == DAMPING)
            ) @ free * self.rate
        if output.power == 0:
            return row, np.zeros_like(row)
        if output.power == 1:
            return np.zeros_like(row), row * self.rate
        return -(row @ stiff) * self.rate**2, -(row @ damping) * self.rate**2


def _as_states(model: Model, output: Output, noise: Noise, p: FloatArray) -> Matrices | None:
    """States of a machine that is `_in_states`, as functions of the coefficients; None where infinite."""
    n = model.n_free
    ride = _riding(model, noise, p) if noise.vector[n:].any() and not noise.displaced else None
    if ride is not None:
        full = np.concatenate([ride, noise.vector[n:]])
        if output.power < 2 and output.row.any() and not _small(output.row, full):
            return None

    def matrices(at: Numbers) -> States | None:
        if noise.displaced:
            return under_displacement(model, output, noise, at)
        if ride is not None:
            return on_carrier(model, output, at, ride)
        return (beside_base if noise.vector[n:].any() else under_force)(model, output, noise, at)

    return matrices if matrices(p) is not None else None


def _in_states(model: Model, noise: Noise, p: FloatArray) -> bool:
    """Whether there are joints, a base is displaced, or one that is accelerated does not carry all."""
    beside = noise.vector[model.n_free :].any() and _riding(model, noise, p) is None
    return bool(model.massless.any() or noise.displaced or beside)


def _mean_square(model: Model, output: Output, noise: Noise, p: FloatArray) -> float:
    if _in_states(model, noise, p):
        matrices = _as_states(model, output, noise, p)
        return _of_states(model, matrices(p) if matrices is not None else None, noise, p)
    frame = _frame(model, output, noise, p)
    if frame is None:
        return float("inf")
    if not frame.basis.shape[1]:
        return 0.0
    states = frame.states(p)
    reach, c = _reach(states, model, p), states.c
    square, parts = float(c @ reach @ c), float(np.abs(c) @ np.sqrt(np.abs(np.diag(reach)))) ** 2
    return float(np.pi * noise.density * square) if square > LOST * parts else 0.0  # as where all is symmetric


def reached(model: Model, form: RootMeanSquare, x: FloatArray) -> float:
    """How great the reading could be of states as large; zero of what is `_in_states`."""
    total, p = 0.0, model.values(x)
    for noise in form.noises:
        frame = _frame(model, form.output, noise, p) if not _in_states(model, noise, p) else None
        if frame is not None and frame.basis.shape[1]:
            states = frame.states(p)
            total += (
                np.pi * noise.density * float(states.c @ states.c) * float(np.abs(np.trace(_reach(states, model, p))))
            )
    return float(np.sqrt(total)) / mount_count(model, form.output, x)


def _of_states(model: Model, found: States | None, noise: Noise, p: FloatArray) -> float:
    """The mean square of what states read; infinite where there are none, or what lasts is read."""
    dying = decaying(found, model, p) if found is not None else None
    if dying is None:
        return float("inf")
    c, reach = dying.c, _reach(dying, model, p)
    square, parts = float((c @ reach @ c.conj()).real), float(np.abs(c) @ np.sqrt(np.abs(np.diag(reach)))) ** 2
    if square <= _CANCELS * parts:  # what each free motion has of the reading cancels less
        _, rates, shapes = dying.eigen(model, p)
        each = (c @ shapes) * np.linalg.solve(shapes, dying.b)
        square = -float((np.outer(each, each.conj()) / (rates[:, None] + rates.conj())).sum().real)
    return float(np.pi * noise.density * square)


def _slope(model: Model, output: Output, noise: Noise, p: FloatArray) -> FloatArray:
    """d(mean square) / d log x, shape (n_vars,)."""
    matrices = _matrices_of(model, output, noise, p)
    if matrices is None:
        return _slope_by_steps(model, output, noise, p)
    states = _made(matrices, p)
    reach, seen, b, c = _reach(states, model, p), _reach(states, model, p, seen=True), states.b, states.c
    slope = np.zeros(model.n_vars)
    if not (np.isfinite(reach).all() and np.isfinite(seen).all()):
        return slope  # from where it has no end no way leads down
    for i in range(model.n_vars):
        off = _made(matrices, p * (1.0 + 1j * _STEP * model.exponents[:, i]))
        da, db, dc = (one.imag / _STEP for one in (off.a, off.b, off.c))
        slope[i] = 2.0 * (np.sum(seen * (da @ reach)) + b @ seen @ db + c @ reach @ dc)
    return np.asarray(np.pi * noise.density * slope)


def _made(matrices: Matrices, p: Numbers) -> States:
    """States, where they are known to be there."""
    found = matrices(p)
    assert found is not None
    return found


def _matrices_of(model: Model, output: Output, noise: Noise, p: FloatArray) -> Matrices | None:
    """States as functions of the coefficients; None where some must be left out that change with them."""
    if not _in_states(model, noise, p):
        frame = _frame(model, output, noise, p)
        assert frame is not None
        return frame.states
    matrices = _as_states(model, output, noise, p)
    assert matrices is not None
    found = _made(matrices, p)
    dying = decaying(found, model, p)
    return None if dying is None or len(dying.c) < len(found.c) else matrices


def _slope_by_steps(model: Model, output: Output, noise: Noise, p: FloatArray) -> FloatArray:
    """d(mean square) / d log x by differences, shape (n_vars,)."""
    ends = [
        [_mean_square(model, output, noise, p * np.exp(step * model.exponents[:, i])) for step in (-1e-5, 1e-5)]
        for i in range(model.n_vars)
    ]
    return np.array([(up - down) / 2e-5 for down, up in ends])


def _reach(states: States, model: Model, p: FloatArray, *, seen: bool = False) -> Numbers:
    """X with a X + X a^H + b b^H = 0; or `seen`, what is read of them, with a^T X + X a* + c c^H = 0."""
    a, load = (states.a.T, states.c) if seen else (states.a, states.b)
    rates = np.linalg.eigvals(a)
    if not slow(rates).any():
        found = _lyapunov(a, load)
        apart = np.abs(rates).max(initial=0.0) > _APART * np.abs(rates).min(initial=np.inf)
        return _refined(a, load, found) if apart and np.isfinite(found).all() else found
    _, rates, shapes = states.eigen(model, p)
    return _by_states(a, load, rates, np.linalg.inv(shapes).T if seen else shapes)


def _lyapunov(a: Numbers, b: Numbers) -> Numbers:
    """X with a X + X a^H + b b^H = 0."""
    from scipy.linalg import solve_continuous_lyapunov

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            found = np.asarray(solve_continuous_lyapunov(a, -np.outer(b, b.conj())))
        except RuntimeWarning:  # two states that hardly decay beside others that do at once
            return _by_states(a, b, *np.linalg.eig(a))
        size = np.sqrt(np.abs(np.diag(found)))
        if not (np.isfinite(size).all() and size.min() > 0.0):
            return found
        load = b / size
        try:  # once more, each state by its own size, where those do not make it singular
            scaled = solve_continuous_lyapunov(a * size / size[:, None], -np.outer(load, load.conj()))
        except RuntimeWarning:
            return found
    return np.asarray(scaled * np.outer(size, size))


def _refined(a: Numbers, b: Numbers, found: Numbers) -> Numbers:
    """The same from a first solution, by what it leaves over: Schur's form loses slow rates beside fast ones.

    Of states that go together what is left over has no digits for the rest.
    """
    from scipy.linalg import solve_continuous_lyapunov

    size = np.sqrt(np.abs(np.diag(found)))
    size[size == 0.0] = 1.0
    scaled, load, before = a * size / size[:, None], b / size, np.inf
    found = found / np.outer(size, size)
    together = np.abs(found - np.diag(np.diag(found))).max(initial=0.0) > _TOGETHER
    for _ in range(0 if together else _AGAIN):
        half = scaled @ found
        change = solve_continuous_lyapunov(scaled, -(half + half.conj().T + np.outer(load, load.conj())))
        off = float(np.abs(change).max())
        if not off < 0.5 * before:
            break
        found, before = found + change, off
    return np.asarray(found * np.outer(size, size))


def _by_states(a: Numbers, b: Numbers, rates: Numbers, shapes: Numbers) -> Numbers:
    """The same by rates (N,) and shapes (N, N) of states; infinite where rounding leaves one that does not decay."""
    if rates.real.max() >= 0.0:
        return np.full_like(a, np.inf)
    load = np.linalg.solve(shapes, b)
    found: Numbers = shapes @ (-np.outer(load, load.conj()) / (rates[:, None] + rates.conj())) @ shapes.conj().T
    return found if np.iscomplexobj(a) or np.iscomplexobj(b) else found.real


def _frame(model: Model, output: Output, noise: Noise, p: FloatArray) -> _Frame | None:
    """Coordinates for one noise; None where the response is infinite."""
    n = model.n_free
    ride, load = None, noise.vector[:n].copy()
    row = _row(model, output, p)
    if noise.vector[n:].any():
        ride = _riding(model, noise, p)
        assert ride is not None, "a base that does not carry all is among the states"
        full = np.concatenate([ride, noise.vector[n:]])
        if output.power < 2 and output.row.any() and not _small(output.row, full):
            return None
        load = -model.matrix(INERTIA, p * _own_inertia(model))[:n, :n] @ ride
    mass, stiff, damping = (model.matrix(kind, p)[:n, :n] for kind in (INERTIA, STIFFNESS, DAMPING))
    root = np.linalg.inv(np.linalg.cholesky(mass)).T
    if output.power == 2 and not noise.vector[n:].any() and not _small(row @ root, root.T @ load):
        return None
    if output.power == 2 and ride is not None:  # what an inerter passes on of the base's own acceleration
        direct = output.row[:n] @ (ride + root @ root.T @ load)
        if abs(direct) > _NOTHING * float(np.abs(output.row[:n]) @ np.abs(ride)):
            return None
    damped, undamped = _split(model, root, stiff, p)
    if _rings(undamped, root.T @ stiff @ root, root.T @ load, row @ root):
        return None
    basis, held = held_first(model, root @ damped, p)
    shapes = np.linalg.eigh(basis[:, :held].T @ stiff @ basis[:, :held])[1]
    basis = np.concatenate([basis[:, :held] @ shapes, basis[:, held:]], axis=1)
    loose = bool(output.row.any() and not output.power and not _nothing_of(row @ basis[:, held:], row @ basis))
    rate = float(np.sqrt(np.abs(basis.T @ stiff @ basis).max(initial=0.0)))
    rate = rate or float(np.abs(basis.T @ damping @ basis).max(initial=0.0)) or 1.0
    found = _Frame(model, output, noise, basis, held, rate, ride, loose)
    return None if found.runs_away(p) else found


def _row(model: Model, output: Output, p: FloatArray) -> FloatArray:
    """What is read, over the free coordinates, to tell whether a motion is seen at all."""
    links = (output.signs * p * (model.kinds != INERTIA)) @ model.vectors
    return np.asarray((output.row + links)[: model.n_free])


def _own_inertia(model: Model) -> BoolArray:
    """Inertia terms of bodies, which resist a motion with the base too; inerters do not, (n_terms,)."""
    return np.asarray((model.kinds == INERTIA) & ~model.inerters)


def _riding(model: Model, noise: Noise, p: FloatArray) -> FloatArray | None:
    """Motion with the base in which no spring and no damper is strained; None where there is none."""
    n = model.n_free
    active = ~_own_inertia(model) & (p > 0.0)
    rows = model.vectors[active] / np.linalg.norm(model.vectors[active], axis=1, keepdims=True)
    pulled = rows[:, n:] @ noise.vector[n:]
    ride = np.asarray(np.linalg.lstsq(rows[:, :n], -pulled, rcond=None)[0])
    strained = rows[:, :n] @ ride + pulled
    return ride if np.abs(strained).max(initial=0.0) <= _NOTHING else None


def _split(model: Model, root: FloatArray, stiff: FloatArray, p: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Orthonormal bases of the motions that dampers reach and of those that they do not, mass-normalised."""
    n = model.n_free
    dampers = root.T @ model.vectors[(model.kinds == DAMPING) & (p > 0.0), :n].T
    damped = closure(dampers, [root.T @ stiff @ root], np.zeros((n, 0)))
    if damped.shape[1] == n:
        return np.eye(n), np.zeros((n, 0))
    whole = np.linalg.qr(np.concatenate([damped, np.eye(n)], axis=1))[0]
    return damped, whole[:, damped.shape[1] :]


def _rings(undamped: FloatArray, stiff: FloatArray, load: FloatArray, row: FloatArray) -> bool:
    """Whether an undamped motion is both shaken and seen."""
    if not undamped.shape[1]:
        return False
    squares, shapes = np.linalg.eigh(undamped.T @ stiff @ undamped)
    shapes = undamped @ shapes
    size = float(np.abs(stiff).max(initial=0.0)) or 1.0
    for square in squares:
        alike = shapes[:, np.abs(squares - square) <= 1e-9 * size]
        if not _small(row @ alike, alike.T @ load, float(np.linalg.norm(row) * np.linalg.norm(load))):
            return True
    return False


def _small(row: FloatArray, vector: FloatArray, size: float | None = None) -> bool:
    """Whether row . vector is nothing but rounding."""
    scale = size if size is not None else float(np.linalg.norm(row) * np.linalg.norm(vector))
    return bool(abs(row @ vector) <= _NOTHING * scale)


def _nothing_of(part: FloatArray, whole: FloatArray) -> bool:
    return bool(np.abs(part).max(initial=0.0) <= _NOTHING * np.abs(whole).max(initial=0.0))
