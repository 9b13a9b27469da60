"""A program in which one link's stiffness and damping are chosen, as rows in the plane of (k, c).

With kappa = k + i w c the response at one speed is N / D with N = n0 + n1 kappa and D = d0 + d1 kappa,
whatever else the machine is, so |N|^2 <= h^2 |D|^2 is a disc, or the outside of one.  A third variable
v moves the coefficients; over an interval of it each coefficient is taken at its least, which only
widens what is allowed, since k and c are never negative.
"""

from __future__ import annotations

from dataclasses import field, replace
from typing import Any

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray
from vibopt.forms import Form, Monomials
from vibopt.forms.few import about_link
from vibopt.forms.rational import Groups, Sampled, to_bernstein
from vibopt.mechanics.model import DAMPING, INERTIA, STIFFNESS, Term
from vibopt.mechanics.monomial import product
from vibopt.mechanics.small import Moebius
from vibopt.program.program import Aim, Limit, Program
from vibopt.records import dataclass
from vibopt.solve.plane.conics import Conics

Interval = tuple[float, float]
_EXACT = 1e-12


@dataclass(frozen=True)
class LinkPlane:
    """Which variables make the plane, and what they are on it.

    spring, damper
        Indices of the two variables.
    other
        Index of the third variable; -1 where there is none.
    k_term, c_term
        Terms of the link: k and c are their coefficients.
    bend
        c_term's square grows with k to this power at constant `damper`: 0, or 1 for a damping ratio.
    mass_term
        The mass at the end of the link, where it is the third variable: k and c are then per unit of it,
        because at a given tuning the rows hardly move with the mass.
    """

    program: Program
    spring: int
    damper: int
    other: int
    k_term: Term
    c_term: Term
    bend: float
    mass_term: Term | None = None
    known: dict[int, tuple[dict[float, int], Sampled | None]] = field(default_factory=dict, compare=False)

    @classmethod
    def of(cls, program: Program) -> LinkPlane | None:
        """The plane of a program; None where there is none."""
        free = [i for i, axis in enumerate(program.axes) if axis.values is None]
        if len(free) < 2 or len(program.axes) > 3:
            return None
        model = program.model
        for damper in free:
            dampers = [t for t in model.terms if t.exponents[damper]]
            if len(dampers) != 1 or dampers[0].kind != DAMPING or dampers[0].exponents[damper] <= 0.0:
                continue
            for spring in free:
                made = cls._with(program, spring, damper, dampers[0]) if spring != damper else None
                if made is not None:
                    return made
        return None

    @classmethod
    def _with(cls, program: Program, spring: int, damper: int, c_term: Term) -> LinkPlane | None:
        touched = [t for t in program.model.terms if t.exponents[spring] and t is not c_term]
        if len(touched) != 1 or touched[0].kind != STIFFNESS or touched[0].exponents[spring] <= 0.0:
            return None
        k_term = touched[0]
        if k_term.owner != c_term.owner or not np.array_equal(k_term.vector, c_term.vector):
            return None
        bend = 2.0 * float(c_term.exponents[spring] / k_term.exponents[spring])
        if bend not in (0.0, 1.0):
            return None
        rest = [i for i in range(len(program.axes)) if i not in (spring, damper)]
        other = rest[0] if rest else -1
        axes = [program.axes[i] for i in (spring, damper)]
        if any(not np.isfinite(axis.high) for axis in axes):
            return None
        return cls(program, spring, damper, other, k_term, c_term, bend)._per_mass()

    def _per_mass(self) -> LinkPlane:
        """The plane per unit of the third variable's mass, where every response allows it."""
        moved = [t for t in self.program.model.terms if self.other >= 0 and t.exponents[self.other]]
        masses = [t for t in moved if t.kind == INERTIA]
        own = {id(term) for term in (self.k_term, self.c_term, *masses)}
        if len(masses) != 1 or any(id(term) not in own for term in moved):
            return self
        mass = masses[0]
        if mass.exponents[[self.spring, self.damper]].any() or not all(
            self._vanishes(part) for part in self.program.parts
        ):
            return self

        def per_mass(term: Term) -> Term:
            return replace(term, scale=term.scale / mass.scale, exponents=term.exponents - mass.exponents)

        return replace(self, k_term=per_mass(self.k_term), c_term=per_mass(self.c_term), mass_term=mass, known={})

    def _vanishes(self, part: Limit | Aim) -> bool:
        """Whether without the mass and without the link N and D of a response are zero: nothing holds the mass."""
        form = part.form
        if not form.ratio or not form.drives:
            return not form.ratio
        speeds = np.array([max(band.high, 1e-3) for band in form.drives[0].bands][:1])
        made = self._sampled(Limit("", part.model, form, "at_most", 1.0), speeds)
        group = self._link_group(made.groups)
        if group is None or group < 0:
            return False
        x = self._reference()[None]
        gone = np.array(x)
        gone[0, self.other] = 0.0
        here, there = (np.abs(self._affine(made, group, one)[0]).max(axis=(1, 2)) for one in (gone, x))
        return bool((here <= 1e-10 * there).all())

    def design(self, k: float, c: float, v: float) -> FloatArray:
        """The variables at a point of the plane, within their ranges, shape (n_vars,)."""
        x = np.ones(len(self.program.axes))
        if self.other >= 0:
            x[self.other] = v
        for term, index, value in ((self.k_term, self.spring, k), (self.c_term, self.damper, c)):
            power = float(term.exponents[index])
            rest = np.where(np.arange(len(x)) == index, 0.0, term.exponents)
            whole = term.scale * float(np.prod(np.where(rest == 0.0, 1.0, x**rest)))
            x[index] = max(value / whole, 0.0) ** (1.0 / power) if whole > 0.0 else 0.0
            axis = self.program.axes[index]
            x[index] = min(max(x[index], axis.low), axis.high)
        return x

    def point(self, x: FloatArray) -> tuple[float, float]:
        """k and c at a design x (n_vars,)."""
        return _value(self.k_term, x), _value(self.c_term, x)

    def accepts(self, limit: Limit) -> bool:
        """Whether a limit (or the goal as one) is made of rows."""
        form, powers = limit.form, limit.form.powers
        if powers is not None:
            return self._only_other(powers) or (len(powers.scale) == 1 and self._powers(powers) is not None)
        groups = form.groups(limit.model) if form.ratio else None
        if groups is None or (self._shared(limit) and limit.model.counts[self._shared(limit)].exponents):
            return False
        return self._link_group(groups) is not None

    @staticmethod
    def _shared(limit: Limit) -> str:
        """The link by whose mounts a response is divided."""
        return limit.form.harmonic.output.shared_by if limit.form.harmonic is not None else ""

    def power_of(self, form: Form) -> tuple[int, float]:
        """Which of k and c (0, 1) a form is a power of, but for a factor, and that power; 0.0 where it is none."""
        powers = self._powers(form.powers) if form.powers is not None and len(form.powers.scale) == 1 else None
        if powers is None or powers[2].any() or (powers[0] and powers[1]):
            return 0, 0.0
        return (1, powers[1]) if powers[1] else (0, powers[0])

    def _only_other(self, form: Monomials) -> bool:
        used = np.flatnonzero(form.exponents.any(axis=0))
        return all(i == self.other for i in used)

    def _powers(self, form: Monomials) -> tuple[float, float, FloatArray] | None:
        """Powers of k and c, and the rest of the exponents, of a single monomial; None where it is no row."""
        row = form.exponents[0]
        in_c = row[self.damper] / self.c_term.exponents[self.damper]
        rest = row - in_c * self.c_term.exponents
        in_k = rest[self.spring] / self.k_term.exponents[self.spring]
        rest = rest - in_k * self.k_term.exponents
        rest = np.where(np.abs(rest) < _EXACT, 0.0, rest)
        simple = (in_c == 0.0 and in_k != 0.0) or (in_c > 0.0 and (in_k == 0.0 or in_k == -0.5 * in_c))
        return (float(in_k), float(in_c), rest) if simple else None

    def _link_group(self, groups: Groups) -> int | None:
        """Index of the group of the link's terms (-1: the form does not know the link); None where there are two."""
        terms = groups.model.terms
        found = [
            g
            for g, members in enumerate(groups.members)
            if any(terms[t].exponents[self.spring] or terms[t].exponents[self.damper] for t in members)
        ]
        if not found:
            return -1
        return found[0] if len(found) == 1 else None

    def _beside(self, groups: Groups, group: int) -> list[int]:
        """Terms that move with the third variable and act where the link acts."""
        terms = groups.model.terms
        return [t for t in groups.members[group] if not terms[t].exponents[[self.spring, self.damper]].any()]

    def conics(self, limits: list[tuple[Limit, list[float]]], interval: Interval) -> Conics | None:
        """All rows over an interval of v; None where a limit on v alone leaves nothing of it.

        limits
            Each with the speeds [rad/s] to look at.
        """
        low, high, rows = self._box(interval)
        for limit, speeds in limits:
            form = limit.form.powers
            if form is not None and self._only_other(form):
                if not self._may_hold(limit, form, interval):
                    return None
            elif form is not None:
                rows.append(self._monomial_row(limit, form, interval))
            else:
                rows += list(self._rows(limit, np.array(speeds), interval))
        table = np.array(rows).reshape(-1, 5)
        if (low > high).any():
            return None
        return Conics(table, low, high)

    def _box(self, interval: Interval) -> tuple[FloatArray, FloatArray, list[FloatArray]]:
        """Box of (k, c) and the rows of the damper's own range, for every v of the interval."""
        corners = [self._ends(v) for v in dict.fromkeys(interval)]
        k_low, k_high = min(corner[0] for corner in corners), max(corner[1] for corner in corners)
        c_low, c_high = min(corner[2] for corner in corners), max(corner[3] for corner in corners)
        rows = []
        if self.bend == 1.0:
            least, most = min(corner[4] for corner in corners), max(corner[5] for corner in corners)
            rows = [np.array([0.0, 1.0, -most, 0.0, 0.0]), np.array([0.0, -1.0, least, 0.0, 0.0])]
        return np.array([k_low, c_low]), np.array([k_high, c_high]), rows

    def _ends(self, v: float) -> tuple[float, float, float, float, float, float]:
        """Least and greatest k, c and c^2/k at one v."""
        axes = self.program.axes
        found = []
        for s_end, d_end in (
            (axes[self.spring].low, axes[self.damper].low),
            (axes[self.spring].high, axes[self.damper].high),
        ):
            x = np.ones(len(axes))
            x[self.spring], x[self.damper] = s_end, d_end
            if self.other >= 0:
                x[self.other] = v
            k, c = self.point(x)
            x[self.spring] = 1.0
            unit_k, unit_c = self.point(x)
            found.append((k, c, unit_c**2 / unit_k))
        (k0, c0, g0), (k1, c1, g1) = found
        return k0, k1, c0, c1, g0, g1

    def _may_hold(self, limit: Limit, form: Monomials, interval: Interval) -> bool:
        n = len(self.program.axes)
        low, high = np.ones((1, n)), np.ones((1, n))
        low[0, self.other], high[0, self.other] = interval
        least, most = form.extent(low, high)
        room = 1e-12 * abs(limit.bound)
        return bool(least[0] <= limit.bound + room) if limit.side == "at_most" else bool(most[0] >= limit.bound - room)

    def _monomial_row(self, limit: Limit, form: Monomials, interval: Interval) -> FloatArray:
        """scale k^a c^b v^g <= bound (or >=) as a row, with the widest bound over the interval."""
        powers = self._powers(form)
        assert powers is not None
        in_k, in_c, rest = powers
        ends = []
        for v in interval:
            x = np.ones(len(self.program.axes))
            if self.other >= 0:
                x[self.other] = v
            scale = form.scale[0] * self.k_term.scale**-in_k * self.c_term.scale**-in_c
            ends.append(limit.bound / (scale * float(np.prod(np.where(rest == 0.0, 1.0, x**rest)))))
        upper = limit.side == "at_most"
        if in_c == 0.0 and in_k < 0.0:
            upper, ends = not upper, [1.0 / max(end, 1e-300) for end in ends]
        bound, sign = (max(ends), 1.0) if upper else (min(ends), -1.0)
        if in_c == 0.0:
            return sign * np.array([0.0, 0.0, 1.0, 0.0, -(max(bound, 0.0) ** (1.0 / abs(in_k)))])
        level = max(bound, 0.0) ** (2.0 / in_c)
        if in_k == 0.0:
            return sign * np.array([0.0, 1.0, 0.0, 0.0, -level])
        return sign * np.array([0.0, 1.0, -level, 0.0, 0.0])

    def _rows(self, limit: Limit, speeds: FloatArray, interval: Interval) -> FloatArray:
        """Rows (n_speeds, 5) of a response."""
        form = limit.form.harmonic
        if form is not None and self.other < 0 and (few := about_link(limit.model, form, speeds)) is not None:
            return _discs(limit, few, 1.0, 1j * form.drives[0].lines[0].order * speeds)
        made = self._sampled(limit, speeds)
        group = self._link_group(made.groups)
        assert group is not None
        degree = 2 * self._degree(made.groups, group)
        root = 1.0 if self.other < 0 else float(made.groups.roots[self.other])
        if interval[0] == interval[1]:
            degree = 0
        y = np.linspace(interval[0] ** (1.0 / root), interval[1] ** (1.0 / root), degree + 1)
        values = self._rows_at(limit, made, group, y**root)
        if degree == 0:
            return np.asarray(values[0])
        coefficients: FloatArray = np.tensordot(to_bernstein(degree), values, axes=1)
        widest: FloatArray = coefficients.min(axis=0)
        return widest

    def rough(self, part: Limit, speeds: FloatArray, x: FloatArray) -> FloatArray:
        """Value of a limit's form at designs x (n, n_vars), the worst of the given speeds only, shape (n,)."""
        if part.form.powers is not None:
            return part.form.powers.at(x)
        made = self._sampled(part, speeds)
        top, bottom = made.at(x)
        with np.errstate(divide="ignore", invalid="ignore"):
            value = np.abs(top) / np.abs(bottom)
        worst: FloatArray = value.max(axis=-1) if part.side == "at_most" else value.min(axis=-1)
        return worst

    def _degree(self, groups: Groups, group: int) -> int:
        if self.other < 0:
            return 0
        total = 0.0
        for g, members in enumerate(groups.members):
            own = self._beside(groups, g) if g == group else list(members)
            if own:
                total += float((groups.model.exponents[own, self.other] * groups.roots[self.other]).max())
        return round(total)

    def _sampled(self, limit: Limit, speeds: FloatArray) -> Sampled:
        """N and D of a response at its speeds; what was met already is kept."""
        form = limit.form
        reference = self._reference()
        if not form.drives:
            return form.sampled(limit.model, speeds, reference)
        asked = speeds.tolist()
        places, made = self.known.get(id(form), ({}, None))
        fresh = [speed for speed in dict.fromkeys(asked) if speed not in places]
        if fresh:
            more = form.sampled(limit.model, np.array(fresh), reference)
            places.update(zip(fresh, range(len(places), len(places) + len(fresh)), strict=True))
            made = more if made is None else made.joined(more)
            self.known[id(form)] = places, made
        assert made is not None
        chosen = [places[speed] for speed in asked]
        return made if chosen == [*range(made.count)] else made.chosen(np.array(chosen))

    def _reference(self) -> FloatArray:
        program = self.program
        return np.sqrt(np.maximum(program.low, 1e-6 * program.high) * program.high)

    def _rows_at(self, limit: Limit, made: Sampled, group: int, v: FloatArray) -> FloatArray:
        """Rows (n, n_speeds, 5) at each of some v (n,)."""
        x = np.ones((len(v), len(self.program.axes)))
        if self.other >= 0:
            x[:, self.other] = v
        (n0, d0), (n1, d1) = self._affine(made, group, x)
        fk, fc = self._factors(made, group)
        if self.mass_term is not None and limit.form.drives:
            mass = np.array([[_value(self.mass_term, one)] for one in x])
            n0, d0 = n0 / mass, d0 / mass
        if self._shared(limit):
            count = limit.model.counts[self._shared(limit)].scale
            n0, n1 = n0 / count, n1 / count
        return _discs(limit, (n0, n1, d0, d1), fk, fc)

    def moebius(self, limit: Limit, speeds: FloatArray) -> Moebius:
        """n0, n1, d0, d1 of a response (n0 + n1 kappa) / (d0 + d1 kappa) at its speeds [rad/s]; no third variable."""
        made = self._sampled(limit, speeds)
        group = self._link_group(made.groups)
        assert group is not None
        (n0, d0), (n1, d1) = self._affine(made, group, np.ones((1, len(self.program.axes))))
        return n0[0], n1[0], d0[0], d1[0]

    def _factors(self, made: Sampled, group: int) -> tuple[ComplexArray, ComplexArray]:
        """What k and c are multiplied by in kappa, each (n_speeds,)."""
        zero = np.zeros(made.count, dtype=complex)
        if group < 0:
            return zero, zero
        terms = made.groups.model.terms
        k_factor, c_factor = zero, zero
        for t in made.groups.members[group]:
            if not terms[t].exponents[[self.spring, self.damper]].any():
                continue
            if terms[t].kind == STIFFNESS:
                static = terms[t].static_scale / terms[t].scale if made.static else 1.0
                k_factor = made.factors[:, t] * static
            else:
                c_factor = made.factors[:, t]
        return k_factor, c_factor

    def _affine(self, made: Sampled, group: int, x: FloatArray) -> tuple[ComplexArray, ComplexArray]:
        """a and b of N and D as a + b kappa at designs x (n, n_vars), other groups as there; (2, n, n_speeds) each."""
        groups = made.groups
        table: ComplexArray = np.array([made.top, made.bottom]).reshape(2, 1, made.count, *([2] * len(groups.members)))
        if group >= 0:
            table = np.moveaxis(table, group + 3, -1)
        values = groups.model.values(x, static=made.static)

        def kappa(members: list[int]) -> ComplexArray:
            return np.asarray(values[:, members] @ made.factors[:, members].T)

        for g, members in enumerate(groups.members):
            if g != group:
                moved = kappa(list(members)) / made.scale[:, g]
                table = table[:, :, :, 0] + table[:, :, :, 1] * moved.reshape(*moved.shape, *([1] * (table.ndim - 4)))
        if group < 0:
            table = table + np.zeros((len(x), 1))
            return table, 0.0 * table
        slope = table[..., 1] / made.scale[:, group]
        slope = slope + np.zeros((len(x), 1))
        return table[..., 0] + slope * kappa(self._beside(groups, group)), slope


def _value(term: Term, x: FloatArray) -> float:
    return product(term.scale, x.tolist(), term.exponents.tolist())


def _discs(limit: Limit, parts: Moebius, fk: Any, fc: Any) -> FloatArray:
    """Rows (..., 5) of |n0 + n1 kappa| against the bound times |d0 + d1 kappa|, kappa = fk k + fc c."""
    n0, n1, d0, d1 = parts
    level = limit.bound**2
    sign = 1.0 if limit.side == "at_most" else -1.0
    square = np.abs(n1) ** 2 - level * np.abs(d1) ** 2
    mixed = np.conj(n0) * n1 - level * np.conj(d0) * d1
    rest = np.abs(n0) ** 2 - level * np.abs(d0) ** 2
    rows = np.stack(
        [
            square * np.abs(fk) ** 2,
            square * np.abs(fc) ** 2,
            2.0 * (mixed * fk).real,
            2.0 * (mixed * fc).real,
            rest,
        ],
        axis=-1,
    )
    return np.asarray(sign * rows, dtype=float)
