"""A scene as a convex program in cvxpy, where it is one.

What follows from stiffness and mass alone is affine, a sum of reciprocals, or a matrix inequality: sag, K u = w with as
many springs as coordinates; lowest natural frequency, K - w^2 M >= 0.  One mass m on springs K with damping C under
harmonic forces is convex in K and q = C^2:

    force handed on, bound T < F at the speed w:  (F^2/T^2 - 1) ((K / m w^2)^2 + q / (m w)^2) + 2 K / m w^2 <= 1
    passage under a constant force, P = F / X:    K >= m P^2 / s + s / 4 m  for some s <= q
    passage under an unbalance, r = m_e e / m X:  q >= 2 K m (1 - sqrt(1 - r^2))
    motion at one speed:                          outside of a disc; convex where the other limits leave one side of it

The variable of a damper is then the square of its damping, "links.mount.damping^2".
"""

from __future__ import annotations

from dataclasses import field
from typing import Any

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.forms import ModeDamping, ModeFrequency, Modulus, Monomials, StaticRow
from vibopt.forms.extremes import extremes_of
from vibopt.mechanics.constants import GRAVITY
from vibopt.mechanics.model import DAMPING, HYSTERETIC, INERTIA, STIFFNESS, Model
from vibopt.posed import conic
from vibopt.program.program import Aim, Limit, Program
from vibopt.records import dataclass
from vibopt.signals import Band, Line
from vibopt.solve.branch import Judge
from vibopt.solve.ranges import natural_size
from vibopt.work import late

EXACT = 1e-9
_SPREAD, _ROUNDS = 9, 30
_FAR = 3.0
"""Logs between the answer and the sizes of its variables from which it is scaled anew."""


class NotConvexError(Exception):
    """Why a scene is no convex program, in words."""


@dataclass
class Convex:
    """The convex program of a scene.

    speeds
        Per limit over ranges the speeds [rad/s] that stand for them; the worst ones of the answer are added.
    margin
        Part by which the bounds of responses are drawn in.
    si
        Whether the variables are in SI units; for solvers they are of order one.
    """

    program: Program
    margin: float = 0.0
    speeds: dict[str, list[float]] = field(default_factory=dict)
    rounds: int = 0
    si: bool = False

    def __post_init__(self) -> None:
        import cvxpy as cp

        self.cp = cp
        self.sizes = np.array([natural_size(self.program, axis) for axis in self.program.axes])
        self.squared = self._dampers()
        names = [f"{axis.path}^2" if i in self.squared else axis.path for i, axis in enumerate(self.program.axes)]
        self.own = [cp.Variable(name=name) for name in names]
        self.restated()

    def design(self) -> FloatArray:
        """The values of the solved problem, (n_vars,)."""
        found = np.maximum(np.array([float(one.value) for one in self.x]), 0.0)
        found[self.squared] = np.sqrt(np.maximum(found[self.squared], 0.0))
        return np.asarray(np.clip(found, self.program.low, self.program.high))

    def solve(self) -> tuple[conic.Conic, float]:
        """How cvxpy ends after the exchange of speeds, with the greatest part by which a limit is missed."""
        judge, run, bound, missed = Judge(self.program, EXACT), conic.Conic("", -np.inf), -np.inf, np.inf
        for self.rounds in range(1, _ROUNDS + 1):
            run = conic.solved(self.problem)
            if not run.claims:
                return run, np.inf
            bound = run.bound if self.margin == 0.0 else bound
            x = self.design()
            if self.rounds == 1 and not self.si and self._rescaled(x):
                continue
            missed = max((judge.limit(limit, x)[0] for limit in self.program.limits), default=0.0)
            if missed <= EXACT or late("the exchange of speeds"):
                break
            if not self._learn(x):
                if self.margin > 1e-8:
                    break
                self.margin = 10.0 * self.margin or 2e-9
            self.restated()
        return conic.Conic(run.status, bound), missed

    def _rescaled(self, x: FloatArray) -> bool:
        """Whether the answer is far from the sizes that the program was scaled by, which are then those of it."""
        near = np.clip(x, 1e-9 * self.sizes, 1e9 * self.sizes)
        if np.abs(np.log(near / self.sizes)).max(initial=0.0) < _FAR:
            return False
        self.sizes = near
        self.restated()
        return True

    def restated(self) -> Any:
        """The problem with all speeds found so far, scaled by `sizes`."""
        self.heads = self.sizes ** np.where(np.isin(np.arange(len(self.sizes)), self.squared), 2.0, 1.0)
        self.x = [one if self.si else one * head for one, head in zip(self.own, self.heads.tolist(), strict=True)]
        self.problem = self._stated()
        return self.problem

    def value(self, x: FloatArray) -> float:
        """The objective at a design."""
        powers = np.where(np.isin(np.arange(len(x)), self.squared), 2.0, 1.0)
        for one, value, head in zip(self.own, (x**powers).tolist(), self.heads.tolist(), strict=True):
            one.value = value if self.si else value / head
        return float(self.problem.objective.value)

    def _learn(self, x: FloatArray) -> bool:
        fresh = False
        for limit in self.program.limits:
            known = self.speeds.get(limit.name, [])
            form = limit.form.harmonic
            if form is None or not known:
                continue
            for drive in form.drives:
                found = extremes_of(limit.model, form, drive, x, least_wanted=False, within=0.7)[:3]
                new = [one.speed for one in found if all(abs(one.speed - old) > EXACT * old for old in known)]
                known += new
                fresh |= bool(new)
        return fresh

    def _dampers(self) -> list[int]:
        """Variables that are dampers of one mass; elsewhere what damps has no part in what is convex."""
        found: set[int] = set()
        for part in self.program.parts:
            poles = part.form.poles
            if part.form.drives or (poles is not None and poles.relative):
                rows = part.model.exponents
                elsewhere = rows[part.model.kinds != DAMPING].any(axis=0)
                found |= set(np.flatnonzero(rows[part.model.kinds == DAMPING].any(axis=0) & ~elsewhere).tolist())
        return sorted(found)

    def _stated(self) -> Any:
        self.rows: list[Any] = []
        for i, axis in enumerate(self.program.axes):
            power = 2 if i in self.squared else 1
            size = self.sizes[i] ** power
            if not axis.open_low or axis.low > 0.0:
                self._hold(f"{axis.path}.from", self.x[i] / size >= axis.low**power / size)
            if np.isfinite(axis.high) and not axis.open_high:
                high = max(axis.high**power / size, 1.0)  # rows of order one
                self._hold(f"{axis.path}.to", self.x[i] / (size * high) <= axis.high**power / (size * high))
        later = []
        for limit in self.program.limits:
            later += self._limit(limit)
        for limit, line, band in later:
            self._motion(limit, line, band)
        return self.cp.Problem(self.cp.Minimize(self._goal()), self.rows)

    def _hold(self, name: str, constraint: Any) -> None:
        self.rows.append(conic.named(constraint, name))

    def _goal(self) -> Any:
        aim = self.program.aim
        if aim is None:
            return self.cp.Constant(0.0)
        if aim.others:
            raise NotConvexError(f"{aim.name} is the worst of several mounts")
        if aim.form.drives:
            raise NotConvexError(f"the goal {aim.name} is a vibration, a ratio of polynomials of the design")
        return aim.sense * self._rising(aim)

    def _rising(self, aim: Aim) -> Any:
        """What rises with the goal and is convex (concave where it is made greatest)."""
        found = aim.form.convex_goal(self, aim)
        if found is None:
            raise NotConvexError(f"the goal {aim.name} is no convex function of the design")
        return found

    def powers_goal(self, aim: Aim, form: Monomials) -> Any:
        if len(form.scale) == 1:
            i, power = self._lone(aim.name, form.exponents[0])
            own = 2.0 if i in self.squared else 1.0
            return np.sign(power) * self.x[i] / self.sizes[i] ** own
        total = self._affine(aim.name, form.scale, form.exponents)
        return total / float(np.abs(form.scale) @ np.prod(self.sizes**form.exponents, axis=1))

    def frequency_goal(self, aim: Aim, form: ModeFrequency) -> Any:
        model = aim.model
        mass = self._constant_matrix(aim.name, model)
        root = np.linalg.inv(np.linalg.cholesky(mass))
        stiff = root @ self._matrix(aim.name, model, STIFFNESS) @ root.T
        size = float(natural_frequency_size(model, self.sizes)) ** 2
        if model.n_free == 1:
            return self.cp.sum(stiff) / size
        if form.mode == 1 and aim.sense < 0:
            return self.cp.lambda_min(stiff / size)
        return self.cp.lambda_max(stiff / size) if form.mode == model.n_free and aim.sense > 0 else None

    def _limit(self, limit: Limit) -> list[tuple[Limit, Line, Band]]:
        """Hold one limit; what is convex only between the others comes back."""
        if limit.form.harmonic is not None:
            return self._harmonic(limit, limit.form.harmonic)
        if limit.side == "outside":
            raise NotConvexError(f"{limit.name} keeps natural frequencies out of a band: above it or below")
        sense, bound = (1.0, limit.bound * (1.0 - self.margin)) if limit.side == "at_most" else (
            -1.0, limit.bound * (1.0 + self.margin))  # fmt: skip
        row = limit.form.convex_limit(self, limit, sense, bound)
        if row is None:
            raise NotConvexError(f"{limit.name} {limit.form.not_convex}")
        self._hold(f"limits.{limit.name}", row)
        return []

    def damping(self, limit: Limit, form: ModeDamping, sense: float, bound: float) -> Any:
        stiff, damping, mass = self._one_mass(limit)
        size = mass * float(np.max(self.sizes))
        return sense * (damping - 4.0 * bound**2 * mass * stiff) / size <= 0.0

    def _lone(self, name: str, exponents: FloatArray) -> tuple[int, float]:
        """The one variable of a power, and its exponent."""
        used = np.flatnonzero(exponents)
        if len(used) != 1:
            paths = " and ".join(self.program.axes[i].path for i in used) or "no variable"
            raise NotConvexError(f"{name} is a product of powers of {paths}")
        return int(used[0]), float(exponents[used[0]])

    def _affine(self, name: str, scales: FloatArray, exponents: FloatArray) -> Any:
        """sum of scale * x, of terms with one variable each in its first power."""
        total = self.cp.Constant(0.0)
        for scale, row in zip(scales, exponents, strict=True):
            if not row.any():
                total = total + scale
                continue
            i, power = self._lone(name, row)
            if power != 1.0 or i in self.squared:
                raise NotConvexError(f"{name} is not affine in {self.program.axes[i].path}")
            total = total + scale * self.x[i]
        return total

    def powers(self, limit: Limit, form: Monomials, sense: float, bound: float) -> Any:
        if len(form.scale) == 1 and form.exponents.any():
            i, power = self._lone(limit.name, form.exponents[0])
            own = 2.0 if i in self.squared else 1.0
            end = (bound / form.scale[0]) ** (own / power)
            return np.sign(power) * sense * (self.x[i] / end - 1.0) <= 0.0
        return sense * (self._affine(limit.name, form.scale, form.exponents) / bound - 1.0) <= 0.0

    def _springs(self, name: str, model: Model) -> tuple[FloatArray, list[Any]]:
        """Rows of springs that stand apart, (n_rows, n_free), and their static stiffnesses."""
        rows: list[FloatArray] = []
        values: list[list[tuple[float, FloatArray]]] = []
        for term, scale in zip(model.terms, model.static_scales, strict=True):
            if term.kind != STIFFNESS or not term.vector[: model.n_free].any():
                continue
            row = term.vector[: model.n_free]
            for k, known in enumerate(rows):
                part = float(row @ known) / float(known @ known)
                if np.allclose(row, part * known, atol=1e-12 * np.abs(row).max()):
                    values[k].append((float(scale) * part**2, term.exponents))
                    break
            else:
                rows.append(row)
                values.append([(float(scale), term.exponents)])
        stiff = [self._affine(name, np.array([s for s, _ in own]), np.array([e for _, e in own])) for own in values]
        return np.array(rows).reshape(len(rows), model.n_free), stiff

    def _stretch(self, name: str, model: Model, form: StaticRow) -> list[tuple[Any, Any]]:
        """Sag as a sum of weight / stiffness: pairs of what rests on a spring, with its lever, and its stiffness."""
        rows, stiff = self._springs(name, model)
        if len(rows) != model.n_free or np.linalg.matrix_rank(rows) < model.n_free:
            raise NotConvexError(f"{name} is a sag that several springs share as their stiffnesses decide")
        back, n = np.linalg.inv(rows), model.n_free
        weigh = [t for t, term in enumerate(model.terms) if term.kind == INERTIA and model.static_scales[t]]
        levers = form.row[:n] @ back
        pairs = []
        for k in np.flatnonzero(np.abs(levers) > 1e-12 * np.abs(levers).max()):
            shares = np.array([GRAVITY * float(model.terms[t].vector[:n] @ back[:, k]) for t in weigh])
            scales = levers[k] * shares * model.static_scales[weigh]
            pairs.append((self._affine(name, scales, model.exponents[weigh]), stiff[k]))
        return pairs

    def sag(self, limit: Limit, form: StaticRow, sense: float, bound: float) -> Any:
        name, pairs = limit.name, self._stretch(limit.name, limit.model, form)
        if len(pairs) == 1:
            load, stiff = pairs[0]
            turn = np.sign(self._typical(load)) or 1.0
            size = self._typical(stiff)
            return sense * (turn * load / bound - stiff) / size <= 0.0
        if sense < 0:
            raise NotConvexError(f"{name} is a sag of several springs that is to be great, the outside of a convex set")
        return self._reciprocals(name, pairs) / bound <= 1.0

    def _reciprocals(self, name: str, pairs: list[tuple[Any, Any]]) -> Any:
        loads = [self._typical(load) for load, _ in pairs]
        turn = np.sign(loads[0]) or 1.0
        if any(not load.is_constant() for load, _ in pairs) or any(turn * load < 0.0 for load in loads):
            raise NotConvexError(f"{name} is a sag in which masses are chosen, or springs work against each other")
        sizes = [self._typical(stiff) for _, stiff in pairs]
        parts = [turn * load / size * self.cp.inv_pos(stiff / size)
                 for load, size, (_, stiff) in zip(loads, sizes, pairs, strict=True)]  # fmt: skip
        return sum(parts[1:], parts[0])

    def sag_goal(self, aim: Aim, form: StaticRow) -> Any:
        pairs = self._stretch(aim.name, aim.model, form)
        if len(pairs) == 1 and pairs[0][0].is_constant():
            return -pairs[0][1] / self._typical(pairs[0][1])
        if aim.sense < 0:
            raise NotConvexError(f"the goal {aim.name} is a sag of several springs that is to be great")
        total = self._reciprocals(aim.name, pairs)
        return total / self._typical(total)

    def _typical(self, expression: Any) -> float:
        """Value at the natural size of every variable."""
        for one, head in zip(self.own, self.heads.tolist(), strict=True):
            one.value = head if self.si else 1.0
        return float(np.asarray(expression.value).ravel()[0])

    def _matrix(self, name: str, model: Model, kind: int) -> Any:
        """Mass or stiffness on the free coordinates, affine."""
        n, total = model.n_free, self.cp.Constant(np.zeros((model.n_free, model.n_free)))
        for term, scale, row in zip(model.terms, model.scales, model.exponents, strict=True):
            if term.kind == kind and term.vector[:n].any():
                own = self._affine(name, np.array([scale]), row[None, :])
                total = total + own * np.outer(term.vector[:n], term.vector[:n])
        return total

    def _constant_matrix(self, name: str, model: Model) -> FloatArray:
        mass = self._matrix(name, model, INERTIA)
        if not mass.is_constant():
            raise NotConvexError(f"{name} is a natural frequency to be made best where masses are chosen")
        return np.asarray(mass.value, dtype=float).reshape(model.n_free, model.n_free)

    def frequency(self, limit: Limit, form: ModeFrequency, sense: float, bound: float) -> Any:
        model = limit.model
        if model.n_free > 1 and form.mode != (1 if sense < 0 else model.n_free):
            word = "the lowest at least" if sense < 0 else "the highest at most"
            raise NotConvexError(f"{limit.name} bounds natural frequency {form.mode}; only {word} is a convex set")
        difference = sense * (self._matrix(limit.name, model, STIFFNESS)
                              - bound**2 * self._matrix(limit.name, model, INERTIA))  # fmt: skip
        self._typical(self.x[0])
        mass = np.asarray(self._matrix(limit.name, model, INERTIA).value).reshape(model.n_free, model.n_free)
        own = np.diag(1.0 / (bound * np.sqrt(np.diag(mass))))
        scaled = own @ difference @ own
        return scaled << 0.0 if model.n_free > 1 else self.cp.sum(scaled) <= 0.0

    def _one_mass(self, limit: Limit) -> tuple[Any, Any, float]:
        """K, C^2 and m of one mass on its springs and dampers."""
        model = limit.model
        if model.n_free > 1:
            raise NotConvexError(f"{limit.name} is a vibration of more than one mass on fixed ground")
        if model.n_free != 1 or model.n_coords != 1:
            raise NotConvexError(f"{limit.name} is a vibration on a support that moves, and not on fixed ground")
        if (model.kinds == HYSTERETIC).any():
            raise NotConvexError(f"{limit.name} has a loss factor in it")
        heads = model.vectors[:, 0] ** 2
        parts = {kind: (model.kinds == kind) & (heads > 0.0) for kind in (INERTIA, STIFFNESS, DAMPING)}
        if model.exponents[parts[INERTIA]].any():
            raise NotConvexError(f"{limit.name} depends on a mass that is chosen")
        mass = float((model.scales * heads)[parts[INERTIA]].sum())
        springs = parts[STIFFNESS]
        stiff = self._affine(limit.name, (model.scales * heads)[springs], model.exponents[springs])
        chosen = parts[DAMPING]
        scales, rows = (model.scales * heads)[chosen], model.exponents[chosen]
        if not rows.any():
            return stiff, self.cp.Constant(float(scales.sum()) ** 2), mass
        which, power = self._lone(limit.name, rows[0])
        if len(rows) != 1 or power != (1.0 if which in self.squared else 0.5):
            raise NotConvexError(f"{limit.name} has damping whose square is not affine in what is chosen")
        return stiff, float(scales[0]) ** 2 * self.x[which], mass

    def _harmonic(self, limit: Limit, form: Modulus) -> list[tuple[Limit, Line, Band]]:
        one = len(form.drives) == 1 and len(form.drives[0].lines) == 1
        if limit.side != "at_most" or not one or form.rigid_link or form.output.power or form.output.shared_by:
            raise NotConvexError(f"{limit.name} is no upper bound of a force or a displacement under one harmonic")
        stiff, damping, mass = self._one_mass(limit)
        drive = form.drives[0]
        line = drive.lines[0]
        if not form.output.signs.any():
            return [(limit, line, band) for band in drive.bands]
        ends = limit.model.vectors[:, 0]
        reads = form.output.signs[(limit.model.kinds != INERTIA) & (ends != 0.0)]
        levers = np.abs(ends[(limit.model.kinds != INERTIA) & (ends != 0.0)])
        if (
            form.output.row.any()
            or limit.model.with_beams
            or np.ptp(reads) > 0.0
            or np.ptp(levers) > EXACT * levers.max()
        ):
            raise NotConvexError(f"{limit.name} is the force of some links only")
        known = self.speeds.setdefault(limit.name, [])
        if not known:
            for band in drive.bands:
                some = [band.high] if band.is_point else np.linspace(band.low, band.high, _SPREAD).tolist()
                known += [speed for speed in some if speed > 0.0]
        forces = np.abs(line.amplitude.at(np.array(known)) * line.vector[0] / levers[0])
        bound = limit.bound * (1.0 - self.margin)
        for speed, force in zip(line.order * np.array(known), forces, strict=True):
            if force <= bound:
                raise NotConvexError(
                    f"{limit.name} permits more than the exciting force at {speed:.4g} rad/s; what lies above "
                    "resonance and below it are two sets"
                )
            slow = stiff / (mass * speed**2)
            bent = self.cp.square(slow) + damping / (mass * speed) ** 2
            self._hold(f"limits.{limit.name}", ((force / bound) ** 2 - 1.0) * bent + 2.0 * slow <= 1.0)
        return []

    def _motion(self, limit: Limit, line: Line, band: Band) -> None:
        """A displacement at one speed, or on the way from rest."""
        stiff, damping, mass = self._one_mass(limit)
        piece = line.amplitude.pieces[0]
        if len(line.amplitude.pieces) > 1 or piece.slope or piece.power not in (0, 2):
            raise NotConvexError(f"{limit.name} has a force that is neither constant nor that of an unbalance")
        assert limit.form.harmonic is not None
        read = limit.form.harmonic.output.row[0]
        pull = abs(piece.constant * line.vector[0] * read) / (limit.bound * (1.0 - self.margin))
        speed, name = line.order * band.high, f"limits.{limit.name}"
        if band.is_point:
            self._beside(limit, stiff, damping, mass * speed**2, pull * (band.high**2 if piece.power else 1.0), speed)
            return
        if band.low > 0.0:
            raise NotConvexError(
                f"{limit.name} does not begin at rest: softer and stiffer mounts keep it, not those between"
            )
        if piece.power:
            ratio = pull / (mass * line.order**2)
            if ratio >= 1.0:
                raise NotConvexError(f"{limit.name} permits what an unbalance moves a free mass by")
            root = np.sqrt(1.0 - ratio**2)
            self._below(limit, stiff, mass * speed**2 * root)
            size = mass**2 * speed**2
            self._hold(name, (2.0 * mass * (1.0 - root) * stiff - damping) / size <= 0.0)
            return
        self._below(limit, stiff, mass * speed**2)
        part = self.cp.Variable(name=f"{name}: damping^2 that counts")
        size = 2.0 * mass * pull
        self._hold(name, part <= damping / size)
        self._hold(name, 0.5 * self.cp.inv_pos(part) + 0.5 * part <= stiff / pull)

    def _range(self, expression: Any, sense: float) -> float:
        """Greatest (sense 1) or least value under the rows so far; infinite where nothing bounds it."""
        size = abs(self._typical(expression)) or 1.0
        run = conic.solved(self.cp.Problem(self.cp.Minimize(-sense * expression / size), self.rows))
        return -sense * run.bound * size if np.isfinite(run.bound) else sense * np.inf

    def _below(self, limit: Limit, stiff: Any, most: float) -> None:
        if self._range(stiff, 1.0) > most * (1.0 + EXACT):
            raise NotConvexError(
                f"{limit.name} is kept by mounts with their resonance above the range as well, and both sets together "
                f"are not convex. Bound the stiffness by {most:.4g} N/m"
            )

    def _beside(self, limit: Limit, stiff: Any, damping: Any, inertia: float, pull: float, speed: float) -> None:
        name = f"limits.{limit.name}"
        if self._range(stiff, 1.0) <= inertia - pull:
            self._hold(name, stiff / inertia <= (inertia - pull) / inertia)
        elif self._range(stiff, -1.0) >= inertia + pull:
            self._hold(name, stiff / inertia >= (inertia + pull) / inertia)
        elif self._range(damping, -1.0) * speed**2 >= pull**2:
            self._hold(name, damping / (pull / speed) ** 2 >= 1.0)
        else:
            raise NotConvexError(
                f"{limit.name} is kept outside of a disc in stiffness and squared damping, above resonance and below it"
            )


def natural_frequency_size(model: Model, sizes: FloatArray) -> float:
    """Some natural frequency of the machine at typical values [rad/s]."""
    from vibopt.mechanics.modes import natural_frequencies

    return float(natural_frequencies(model, model.values(sizes))[-1]) or 1.0


def not_convex(program: Program) -> str:
    """Why the program is not convex, in words; "" where it is."""
    try:
        Convex(program)
    except NotConvexError as why:
        return str(why)
    return ""
