"""Many designs of small devices on a large structure, at fixed frequencies.

The terms of a model that no design variable touches are solved once per frequency, for the rows at which
the variable terms act, the load and the reading.  A design then costs a problem of the size of the devices,
whatever the size of the structure.  A damper that is put at each row before the solution and taken away
again with the devices keeps everything finite where a frequency is an undamped resonance of the structure.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import field, replace

import numpy as np

from vibopt.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from vibopt.mechanics.model import INERTIA, STIFFNESS, Model, factors
from vibopt.records import cached_property, dataclass
from vibopt.signals import Line, Output

_SAME = 1e-13
_CHUNK = 16_000_000
_AT_ONCE, _TOGETHER = 16, 100_000
"""Designs that are solved for at once, and receptances beyond which they are fewer."""
Wanted = Callable[[ComplexArray], BoolArray]
"""Of which of some responses (n,) slopes are wanted, (n,)."""
Forces = tuple[ComplexArray, ComplexArray]


@dataclass(frozen=True, eq=False)
class Host:
    """What the fixed terms answer at the rows where variable terms act, at n frequencies.

    receptance
        Shape (p, p, n): motion of row a per force along row b [m/N], with `dash` at each row.
    loaded
        Shape (p, n): motion of the rows under the load alone.
    read
        Shape (p, n): reading per force along each row.
    direct
        Shape (n,): reading under the load alone.
    dash
        Damper added at each row [N s/m], taken away again with the devices.
    """

    receptance: ComplexArray
    loaded: ComplexArray
    read: ComplexArray
    direct: ComplexArray
    dash: float

    def receptance_times(self, forces: ComplexArray, *, unit: bool = False) -> ComplexArray:
        """Motion of the rows under forces: columns (c, p, n); or I + H Z for a matrix Z (p, p, n)."""
        if not unit:
            moved: ComplexArray = (self.receptance[None] * forces[:, None]).sum(axis=2)
            return moved
        whole: ComplexArray = (self.receptance[:, :, None] * forces[None]).sum(axis=1)
        for a in range(len(whole)):
            whole[a, a] += 1.0
        return whole


@dataclass(frozen=True, eq=False)
class Attached:
    """Response of a model and its slopes for many designs, at frequencies fixed beforehand.

    Coordinates that only variable terms touch (the mass of an absorber) are called inner ones.

    host
        What the rest of the model answers.
    omega
        Frequencies [rad/s], shape (n,).
    scale
        What a unit of response is multiplied with: amplitude and power of i omega, shape (n,).
    scales, exponents
        Coefficients of the variable terms as monomials, (t,) and (t, n_vars).
    groups
        Per variable term the group of terms with its vector, shape (t,).
    kinds
        Kind of each variable term, shape (t,).
    vectors
        Per group its row over [rows of the host, inner coordinates], shape (g, p + q).
    offsets
        Per group the extension that moving bases give it, complex, shape (g,).
    signs
        How much of each group's force the reading takes, shape (g,).
    inner_load, inner_row
        Load on and reading of the inner coordinates, each (q,).
    """

    host: Host
    omega: FloatArray
    scale: ComplexArray
    scales: FloatArray
    exponents: FloatArray
    groups: IntArray
    kinds: IntArray
    vectors: FloatArray
    offsets: ComplexArray
    signs: FloatArray
    inner_load: ComplexArray
    inner_row: FloatArray
    _phi: ComplexArray = field(init=False)

    def __post_init__(self) -> None:
        table = factors(np.arange(4), self.omega).T
        object.__setattr__(self, "_phi", np.ascontiguousarray(table))

    @classmethod
    def of(cls, model: Model, output: Output, line: Line, speeds: FloatArray) -> Attached:
        """Solve the fixed terms of a model once.

        Parameters
        ----------
        model
            The model; its variable terms are the devices.
        output
            What is read.
        line
            The harmonic that acts.
        speeds
            Speeds [rad/s], shape (n,); the frequency is the order times the speed.
        """
        return _Split(model, output, line, np.asarray(speeds, dtype=float)).attached()

    @property
    def n_rows(self) -> int:
        return len(self.host.loaded)

    def at_once(self, x: FloatArray) -> Iterator[tuple[Attached, FloatArray]]:
        """Designs x (count, n_vars), some at once, each with what has every frequency as often as there are of them."""
        host, step = self.host, max(1, min(_AT_ONCE, _TOGETHER // max(self.host.receptance.size, 1)))
        for some in np.array_split(x, range(step, len(x), step)):
            many = (len(some),)
            if many not in self._repeated:
                table, loaded, read = (np.tile(one, many) for one in (host.receptance, host.loaded, host.read))
                whole = Host(table, loaded, read, np.tile(host.direct, many), host.dash)
                self._repeated[many] = replace(
                    self, host=whole, omega=np.tile(self.omega, many), scale=np.tile(self.scale, many)
                )
            yield self._repeated[many], some

    @cached_property
    def _repeated(self) -> dict[tuple[int], Attached]:
        return {}

    def response(self, x: FloatArray) -> ComplexArray:
        """Response at each frequency at design x (n_vars,), complex peak, shape (n,).

        Of designs (count, n_vars) each takes its part of the frequencies, in turn.
        """
        kappa = self._spread @ self._terms(x)
        moved = self._solve(kappa)
        return self._read(self._forces(kappa, moved[0], self._extension(moved)[0]), moved[0])

    def slopes(self, x: FloatArray) -> tuple[ComplexArray, ComplexArray]:
        """Response (n,) and its slope in log x, shape (n, n_vars), at design x (n_vars,), or designs as above."""
        return slopes_of([self], x)[0]

    @cached_property
    def alike(self) -> tuple[bytes, ...]:
        """What is the same of those that read one machine under one load at the same frequencies."""
        told = (self.groups, self.vectors, self.omega, self.host.loaded, self.offsets, self.inner_load)
        return tuple([one.tobytes() for one in told])

    def _terms(self, x: FloatArray) -> ComplexArray:
        """Dynamic stiffness of each variable term, (t, n)."""
        p = self.scales * np.exp(np.log(x).reshape(-1, x.shape[-1]) @ self.exponents.T)
        each: ComplexArray = p.T[:, :, None] * self._phi[self.kinds].reshape(len(self.kinds), len(p), -1)
        return each.reshape(len(self.kinds), -1)

    @cached_property
    def _spread(self) -> FloatArray:
        """Which group each variable term belongs to, (g, t)."""
        return np.asarray(self.groups == np.arange(len(self.vectors))[:, None], dtype=float)

    @cached_property
    def _tables(self) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        """Tables (entries, g) that assemble the dynamic stiffness of the devices: rows, mixed, inner."""
        p = self.n_rows
        rows, inner = self.vectors[:, :p], self.vectors[:, p:]
        table = [np.einsum("ga,gb->abg", a, b) for a, b in ((rows, rows), (rows, inner), (inner, inner))]
        flat = [one.reshape(-1, len(self.vectors)).astype(complex) for one in table]
        return flat[0], flat[1], flat[2]

    @cached_property
    def _alone(self) -> bool:
        """Whether no two inner coordinates are joined."""
        q = self.vectors.shape[1] - self.n_rows
        joined = self._tables[2].reshape(q, q, -1).any(axis=-1)
        return not (joined & ~np.eye(q, dtype=bool)).any()

    @cached_property
    def _carried(self) -> list[tuple[int, IntArray]]:
        """Each inner coordinate with the rows of the host that it is joined to."""
        p, q = self.n_rows, self.vectors.shape[1] - self.n_rows
        joined = np.asarray(self._tables[1].reshape(p, q, -1).any(axis=-1))
        return [(k, np.flatnonzero(joined[:, k])) for k in range(q)]

    @cached_property
    def _quiet(self) -> bool:
        """Whether nothing acts on the devices or reads them but through the host."""
        return not (self.offsets.any() or self.signs.any() or self.inner_load.any() or self.inner_row.any())

    @cached_property
    def _vectors(self) -> ComplexArray:
        return self.vectors.astype(complex)

    @cached_property
    def _lift(self) -> ComplexArray:
        """Dynamic stiffness of the dampers to be taken away, shape (n,)."""
        return np.asarray(1j * self.omega * self.host.dash, dtype=complex)

    def _solve(self, kappa: ComplexArray, read: Sequence[Attached] = ()) -> ComplexArray:
        """Motion of rows and inner coordinates under the load, then under each reading, (1 + n_read, p + q, n)."""
        p, q, n = self.n_rows, self.vectors.shape[1] - self.n_rows, len(self.omega)
        host = self.host
        rows = (self._tables[0] @ kappa).reshape(p, p, n)
        if host.dash:
            rows[np.arange(p), np.arange(p)] -= self._lift
        quiet = self._quiet and all(one._quiet for one in read)
        sources = None if quiet else np.stack([self._pushed(kappa), *(one._drawn(kappa) for one in read)])
        right = np.stack([host.loaded, *(one.host.read for one in read)])
        if not q:
            right = right if sources is None else right + host.receptance_times(sources)
            return _small(host.receptance_times(rows, unit=True), right)
        mixed = (self._tables[1] @ kappa).reshape(p, q, n)
        if not self._alone:
            joined = (self._tables[2] @ kappa).reshape(q, q, n)
            return _whole(host, rows, mixed, joined, right, sources)
        inner = np.asarray(self._tables[2][:: q + 1] @ kappa, dtype=complex)
        if not inner.all():
            inner[inner == 0.0] = 1e-14j * np.abs(kappa).max()
        share = mixed / inner
        for k, ends in self._carried:
            rows[ends[:, None], ends] -= share[ends[:, None], k] * mixed[ends, k]
        if sources is not None:
            pushed = sources[:, :p] - (share[None] * sources[:, None, p:]).sum(axis=2)
            right = right + host.receptance_times(pushed)
        moved = _small(host.receptance_times(rows, unit=True), right)
        beyond = np.stack([-(share[ends, k] * moved[:, ends]).sum(axis=1) for k, ends in self._carried], axis=1)
        if sources is not None:
            beyond += sources[:, p:] / inner
        return np.concatenate([moved, beyond], axis=1)

    def _pushed(self, kappa: ComplexArray) -> ComplexArray:
        """What acts on the devices directly, (p + q, n): moving bases and loads."""
        load: ComplexArray = -self._vectors.T @ (kappa * self.offsets[:, None])
        load[self.n_rows :] += self.inner_load[:, None]
        return load

    def _drawn(self, kappa: ComplexArray) -> ComplexArray:
        """What is read of them directly, (p + q, n)."""
        read: ComplexArray = self._vectors.T @ (kappa * self.signs[:, None])
        read[self.n_rows :] += self.inner_row[:, None]
        return read

    def _extension(self, moved: ComplexArray) -> ComplexArray:
        """Extension of every group, (columns, g, n); the bases move only under the load."""
        found: ComplexArray = self._vectors @ moved
        if not self._quiet:
            found[0] += self.offsets[:, None]
        return found

    def _at(self, some: IntArray) -> Attached:
        """At some of its frequencies, (n_some,)."""
        host = self.host
        table, loaded, read = (one[..., some] for one in (host.receptance, host.loaded, host.read))
        part = Host(table, loaded, read, host.direct[some], host.dash)
        return replace(self, host=part, omega=self.omega[some], scale=self.scale[some])

    def _own_slopes(self, terms: ComplexArray, kappa: ComplexArray) -> ComplexArray:
        """Slopes in log x by terms (t, n) and the groups that they are in (g, n), shape (n, n_vars)."""
        if not len(self.omega):
            return np.zeros((0, self.exponents.shape[1]), dtype=complex)
        return self._slopes(terms, *self._extension(self._solve(kappa, [self])))

    def _slopes(self, terms: ComplexArray, extension: ComplexArray, back: ComplexArray) -> ComplexArray:
        """The same by the extensions under the load and under the reading, each (g, n)."""
        through = extension * (self.signs[:, None] - back) * self.scale
        slope: ComplexArray = (terms * through[self.groups]).T @ self.exponents
        return slope

    def _forces(self, kappa: ComplexArray, moved: ComplexArray, extension: ComplexArray) -> Forces:
        """Of groups (g, n), and what they and the dampers that are not there push the rows of the host with (p, n)."""
        p = self.n_rows
        force = kappa * extension
        pushed = self._vectors[:, :p].T @ force
        if self.host.dash:
            pushed -= self._lift * moved[:p]
        return force, pushed

    def _read(self, forces: Forces, moved: ComplexArray) -> ComplexArray:
        force, pushed = forces
        value = self.host.direct - (self.host.read * pushed).sum(axis=0)
        if self.signs.any():
            value = value + self.signs @ force
        if self.inner_row.any():
            value = value + self.inner_row @ moved[self.n_rows :]
        result: ComplexArray = value * self.scale
        return result


def slopes_of(
    alike: Sequence[Attached], x: FloatArray, wanted: Sequence[Wanted | None] = ()
) -> list[tuple[ComplexArray, ComplexArray]]:
    """`Attached.slopes` of several that read one machine under one load, which is solved for once.

    Slopes are (n_wanted, n_vars): those of the responses alone that `wanted` picks of each, of all where it is None.
    """
    first, picked = alike[0], wanted or [None] * len(alike)
    terms = first._terms(x)
    kappa = first._spread @ terms
    moved = first._solve(kappa, [one for one, pick in zip(alike, picked, strict=True) if pick is None])
    extension, *back = first._extension(moved)
    forces = first._forces(kappa, moved[0], extension)
    found, backs = [], iter(back)
    for one, pick in zip(alike, picked, strict=True):
        value = one._read(forces, moved[0])
        if pick is None:
            slope = one._slopes(terms, extension, next(backs))
        else:
            some = np.flatnonzero(pick(value))
            slope = one._at(some)._own_slopes(terms[:, some], kappa[:, some])
        found.append((value, slope))
    return found


def _small(matrix: ComplexArray, right: ComplexArray) -> ComplexArray:
    """Solve matrices (p, p, n) for right sides (columns, p, n); inf where a matrix is singular."""
    p = len(matrix)
    with np.errstate(divide="ignore", invalid="ignore"):
        if p == 1:
            single: ComplexArray = right / matrix[0]
            return single
        if p == 2:
            size = matrix[0, 0] * matrix[1, 1] - matrix[0, 1] * matrix[1, 0]
            turned = np.empty(right.shape, dtype=complex)
            turned[:, 0] = matrix[1, 1] * right[:, 0] - matrix[0, 1] * right[:, 1]
            turned[:, 1] = matrix[0, 0] * right[:, 1] - matrix[1, 0] * right[:, 0]
            turned /= size
            return turned
    if p == 0:
        return right
    return _stacked(matrix, right)


def _stacked(matrix: ComplexArray, right: ComplexArray) -> ComplexArray:
    flat, sides = np.moveaxis(matrix, -1, 0), np.moveaxis(right, -1, 0)
    size = np.abs(flat).max(axis=2, keepdims=True)
    size[size == 0.0] = 1.0
    try:
        solved = np.linalg.solve(flat / size, np.swapaxes(sides, 1, 2) / size)
    except np.linalg.LinAlgError:
        nudged = flat / size + 1e-14j * np.eye(len(matrix))
        solved = np.linalg.solve(nudged, np.swapaxes(sides, 1, 2) / size)
    return np.moveaxis(solved, (0, 1, 2), (2, 1, 0))


def _whole(
    host: Host,
    rows: ComplexArray,
    mixed: ComplexArray,
    inner: ComplexArray,
    right: ComplexArray,
    sources: ComplexArray | None,
) -> ComplexArray:
    """As `Attached._solve` where inner coordinates are joined with each other (devices in series)."""
    p, q, n = mixed.shape
    matrix = np.empty((p + q, p + q, n), dtype=complex)
    matrix[:p, :p] = host.receptance_times(rows, unit=True)
    matrix[:p, p:] = host.receptance_times(np.swapaxes(mixed, 0, 1)).swapaxes(0, 1)
    matrix[p:, :p] = np.swapaxes(mixed, 0, 1)
    matrix[p:, p:] = inner
    sides = np.zeros((len(right), p + q, n), dtype=complex)
    sides[:, :p] = right
    if sources is not None:
        sides[:, :p] += host.receptance_times(sources[:, :p])
        sides[:, p:] += sources[:, p:]
    return _stacked(matrix, sides)


class _Split:
    """Parts a model into what stays and what the design variables touch."""

    def __init__(self, model: Model, output: Output, line: Line, speeds: FloatArray) -> None:
        self.model, self.output, self.line, self.speeds = model, output, line, speeds
        self.omega = line.order * speeds
        n = model.n_free
        self.free = model.exponents.any(axis=1)
        fixed = model.vectors[~self.free, :n]
        self.outer = (fixed != 0.0).any(axis=0)
        self.groups, self.representatives = _grouped(model, np.flatnonzero(self.free), output.signs)

    def attached(self) -> Attached:
        model, output, line, n = self.model, self.output, self.line, self.model.n_free
        vectors = model.vectors[self.representatives]
        inner = vectors[:, :n][:, ~self.outer]
        rows, table = _distinct(vectors[:, :n][:, self.outer])
        free = np.flatnonzero(self.free)
        scale = np.asarray((1j * self.omega) ** output.power * line.amplitude.at(self.speeds), dtype=complex)
        host = self._host(rows)
        return Attached(
            host=host,
            omega=self.omega,
            scale=scale,
            scales=model.scales[free],
            exponents=model.exponents[free],
            groups=self.groups,
            kinds=model.kinds[free],
            vectors=np.hstack([table, inner]),
            offsets=vectors[:, n:] @ line.vector[n:],
            signs=output.signs[self.representatives],
            inner_load=line.vector[:n][~self.outer],
            inner_row=output.row[:n][~self.outer],
        )

    def _host(self, rows: FloatArray) -> Host:
        """Solve the fixed terms with a damper at each row, some frequencies at a time."""
        model, n = self.model, self.model.n_free
        size = int(self.outer.sum())
        p = len(rows)
        parts: list[ComplexArray] = []
        dash = self._dash(rows)
        step = max(1, _CHUNK // max(size * size, 1))
        for start in range(0, len(self.omega), step):
            z = model.scales * np.where(self.free, 0.0, 1.0) * factors(model.kinds, self.omega[start : start + step])
            both = np.matmul(model.vectors.T[:n] * z[:, None, :], model.vectors)
            stiff = both[:, :n, :n][:, self.outer][:, :, self.outer]
            stiff = stiff + 1j * self.omega[start : start + step, None, None] * dash * (rows.T @ rows)
            load = self.line.vector[:n] - both[:, :, n:] @ self.line.vector[n:]
            read = self.output.row + (self.output.signs * z) @ model.vectors
            parts.append(
                _quadratic(
                    stiff, rows, load[:, self.outer], read[:, :n][:, self.outer], read[:, n:] @ self.line.vector[n:]
                )
            )
        whole = np.concatenate(parts)
        return Host(
            receptance=np.ascontiguousarray(np.moveaxis(whole[:, :p, :p], 0, -1)),
            loaded=np.ascontiguousarray(whole[:, :p, p].T),
            read=np.ascontiguousarray(whole[:, :p, p + 1].T),
            direct=whole[:, p + 1, p].copy(),
            dash=dash,
        )

    def _dash(self, rows: FloatArray) -> float:
        """A damper of the size of what the host has: root of mass times stiffness."""
        model = self.model
        fixed = ~self.free
        if not len(rows):
            return 0.0
        p = np.where(fixed, model.scales, 0.0)
        n = model.n_free
        mass, stiff = (model.matrix(kind, p)[:n, :n][self.outer][:, self.outer] for kind in (INERTIA, STIFFNESS))
        size = [np.sqrt(np.trace(one) / max(len(one), 1)) for one in (mass, stiff)]
        return float(size[0] * size[1]) or 1.0


def _quadratic(
    stiff: ComplexArray, rows: FloatArray, load: ComplexArray, read: ComplexArray, base: ComplexArray
) -> ComplexArray:
    """[rows, load, read] D^-1 [rows, load, read], (k, p + 2, p + 2), with the reading of the bases added."""
    k = len(stiff)
    right = np.concatenate([np.broadcast_to(rows.T, (k, *rows.T.shape)), load[:, :, None], read[:, :, None]], axis=2)
    size = np.sqrt(np.abs(np.diagonal(stiff, axis1=1, axis2=2)).astype(float))[:, :, None]
    size[size == 0.0] = 1.0
    scaled = stiff / (size * np.swapaxes(size, 1, 2))
    try:
        solved = np.linalg.solve(scaled, right / size)
    except np.linalg.LinAlgError:
        solved = np.linalg.solve(scaled + 1e-14j * np.eye(stiff.shape[1]), right / size)
    found: ComplexArray = np.swapaxes(right / size, 1, 2) @ solved
    found[:, -1, -2] += base
    return found


def _grouped(model: Model, free: IntArray, signs: FloatArray) -> tuple[IntArray, IntArray]:
    """Group of each variable term, and the first term of each group: same vector, read alike."""
    known: dict[tuple[float, ...], int] = {}
    groups: list[int] = []
    first: list[int] = []
    for t in free:
        key = (float(signs[t]), *model.vectors[t].tolist())
        if key not in known:
            known[key] = len(first)
            first.append(int(t))
        groups.append(known[key])
    return np.array(groups, dtype=np.intp), np.array(first, dtype=np.intp)


def _distinct(rows: FloatArray) -> tuple[FloatArray, FloatArray]:
    """An independent set of rows (p, m), and every row in terms of it, (g, p)."""
    kept: list[FloatArray] = []
    for row in rows:
        if not row.any():
            continue
        if kept:
            basis = np.array(kept)
            rest = row - np.linalg.lstsq(basis.T, row, rcond=None)[0] @ basis
            if np.abs(rest).max() <= _SAME * np.abs(row).max():
                continue
        kept.append(row / np.abs(row).max())
    if not kept:
        return np.zeros((0, rows.shape[1])), np.zeros((len(rows), 0))
    basis = np.array(kept)
    table = np.linalg.lstsq(basis.T, rows.T, rcond=None)[0].T
    return basis, np.where(np.abs(table) < 1e-15, 0.0, table)
