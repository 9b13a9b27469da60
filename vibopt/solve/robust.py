"""A design that holds for every machine within its tolerances.

The limits are asked of a few machines, the worst that nature could make of the last design; each
answer shows which machines are worse still, until none is.  Few machines are fewer limits, so what is
proven best for them bounds what is best for all.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from vibopt.forms import FloatArray, Modulus
from vibopt.program.nature import Hit, around, hit, missed
from vibopt.program.over import MARGIN, Cover
from vibopt.program.pose import pose
from vibopt.program.program import Aim, Limit, Program
from vibopt.scene.scene import Scene
from vibopt.scene.uncertain import uncertain
from vibopt.solve.box import closed
from vibopt.solve.branch import Judge
from vibopt.solve.choose import choose
from vibopt.solve.local import sharpened
from vibopt.solve.method import Found, Progress

TOLERANCE = 1e-9
_BROKEN = 9e-10
_ROUNDS = 20
_WHOLE = 4
_SECONDS = 60.0
_PROOF_SECONDS = 4.0


@dataclass(frozen=True)
class Robust:
    """A design and the machines that are worst for it.

    found
        The answer; its status speaks of all machines within the tolerances.
    hits
        Per limit of the program, and -1 for the goal.
    open
        Names of limits (and the goal) of which the worst machine is found but not proven to be the worst.
    """

    found: Found
    hits: Mapping[int, Hit] = field(default_factory=dict)
    open: tuple[str, ...] = ()

    @property
    def tried(self) -> int:
        """Machines looked at around the design."""
        return sum(one.tried for one in self.hits.values())


def judged(scene: Scene, x: FloatArray) -> Robust:
    """The worst machines around a given design x (n_vars,), proven where that can be done."""
    program = around(scene, x)
    hits = _hits(program, {}, quick=False)
    return Robust(Found("", np.asarray(x), "", ""), hits, _open(program, hits))


def robust(scene: Scene, nominal: Found, method: str | None, progress: Progress | None = None) -> Robust:
    """The best design over the tolerances; `nominal` is the answer without them."""
    if nominal.x is None or nominal.status == "unbounded":
        words = {"infeasible": "even without tolerances", "unbounded": "without tolerances"}
        before = words.get(nominal.status, "already without tolerances")
        status = "unproven" if nominal.status == "unbounded" else nominal.status
        return Robust(replace(nominal, status=status, x=None, claim=f"{before}: {nominal.claim}"))
    return _Run(scene, method, progress).answer(nominal)


class _Run:
    def __init__(self, scene: Scene, method: str | None, progress: Progress | None) -> None:
        self.scene, self.method, self.progress = scene, method, progress
        self.paths = [one.path for one in uncertain(scene)]
        self.machines: dict[int, list[FloatArray]] = {}
        self.posed: dict[bytes, Program] = {}
        self.deadline = time.perf_counter() + _SECONDS

    def answer(self, nominal: Found) -> Robust:
        assert nominal.x is not None
        x: FloatArray = nominal.x
        safe: FloatArray | None = None
        self._look(x)
        found = nominal
        for step in range(_WHOLE):
            x, good = self._locally(x)
            safe = x if good else safe
            if self.progress is not None:
                self.progress("tolerances", (step + 0.5) / _WHOLE)
            program = self.program()
            found = choose(program, self.method).solve(program, self.progress)
            found = _at_open_ends(program, found)
            if found.status == "infeasible":
                claim = f"{found.claim}, on {self.count} machines within the tolerances"
                return Robust(replace(found, claim=claim))
            if found.x is None or found.status == "unbounded":
                break
            hits, broken = self._look(found.x)
            if not broken:
                return self._done(found, hits)
            x = found.x
            if time.perf_counter() > self.deadline:
                break
        return self._stopped(found, safe)

    @property
    def count(self) -> int:
        """Machines that limits are asked of."""
        return len({one.tobytes() for many in self.machines.values() for one in many})

    def _stopped(self, found: Found, safe: FloatArray | None) -> Robust:
        """What is left when the worst machines did not settle: the last design that holds for all of them."""
        if safe is None:
            claim = "no design found that holds for all machines within the tolerances, which proves nothing"
            return Robust(replace(found, status="unproven", x=None, claim=claim))
        hits, _ = self._look(safe)
        claim = "a design that holds over the tolerances; that nothing better exists is not proven"
        return self._done(replace(found, status="feasible", x=safe, claim=claim), hits)

    def _done(self, found: Found, hits: dict[int, Hit]) -> Robust:
        assert found.x is not None
        program = around(self.scene, found.x)
        undecided = _open(program, hits)
        status, words = found.status, "over the tolerances: all of it proven"
        if any(_tight(program, index, one) for index, one in hits.items()):
            words += f" (to {MARGIN:.0e} of the bound where a limit is tight)"
        if undecided:
            tried = sum(one.tried for one in hits.values())
            words = f"over the tolerances: the worst of {tried} machines found, not proven for {', '.join(undecided)}"
            status = "feasible" if status == "optimal" else status
        details = {**found.details, "machines": self.count}
        return Robust(replace(found, status=status, claim=f"{found.claim}; {words}", details=details), hits, undecided)

    def _locally(self, x: FloatArray) -> tuple[FloatArray, bool]:
        """A design near x that holds on all machines that are worst for it; whether there is one."""
        for _ in range(_ROUNDS):
            program = self.program()
            there = sharpened(program, x)
            if there is None or not Judge(program).feasible(there):
                return x, False
            x = there
            _, broken = self._look(x, quick=True)
            if not broken:
                return x, True
            if time.perf_counter() > self.deadline:
                break
        return x, False

    def _look(self, x: FloatArray, *, quick: bool = False) -> tuple[dict[int, Hit], bool]:
        """The worst machines for a design; those that break a limit or the goal are kept. Whether any does."""
        program = around(self.scene, x)
        hits = _hits(program, self.machines, quick=quick)
        broken = False
        level = self._level(x)
        for index, one in hits.items():
            if index >= 0:
                bad = missed(program.limits[index], one.value) > _BROKEN
            else:
                assert program.aim is not None
                bad = program.aim.sense * one.value > level + _BROKEN * abs(level)
            fresh = index not in self.machines
            if bad or fresh:
                self.machines.setdefault(index, []).append(one.factors)
            broken |= bad
        return hits, broken

    def _level(self, x: FloatArray) -> float:
        """The goal (to be minimised) on the machines known."""
        return Judge(self.program()).goal(x).value if -1 in self.machines else -np.inf

    def _asked(self, factors: FloatArray) -> Program:
        key = factors.tobytes()
        if key not in self.posed:
            off = dict(zip(self.paths, factors.tolist(), strict=True))
            self.posed[key] = closed(pose(replace(self.scene, off=off)))
        return self.posed[key]

    def program(self) -> Program:
        """Every limit and the goal, each on the machines that are worst for it."""
        nominal = self._asked(np.ones(len(self.paths)))
        limits: list[Limit] = []
        aims: list[Aim] = []
        for index in range(len(nominal.limits)):
            limits += [self._asked(one).limits[index] for one in self.machines.get(index, ())]
        for one in self.machines.get(-1, ()):
            aim = self._asked(one).aim
            assert aim is not None
            aims.append(aim)
        whole = replace(aims[0], others=tuple(aims[1:])) if aims else nominal.aim
        return replace(nominal, limits=tuple(limits), aim=whole, several=True)


def _hits(program: Program, known: Mapping[int, list[FloatArray]], *, quick: bool) -> dict[int, Hit]:
    parts: dict[int, Limit | Aim] = dict(enumerate(program.limits))
    if program.aim is not None:
        parts[-1] = program.aim
    return {
        index: hit(part, program.axes, near=tuple(known.get(index, ()))[-2:], quick=quick)
        for index, part in parts.items()
    }


def _at_open_ends(program: Program, found: Found) -> Found:
    """Nothing is proven where a range has no end, and the search had to take one."""
    opened = [axis.path for axis in program.axes if axis.open_high]
    if found.x is None:
        if found.status != "infeasible" or not opened:
            return found
        return replace(found, status="unproven", claim=f"no design found; nothing is proven of larger {opened[0]}")
    for axis, value in zip(program.axes, found.x, strict=True):
        if (axis.open_high and value >= 0.999 * axis.high) or (axis.open_low and value <= 1.001 * axis.low):
            claim = f"every limit holds; the goal comes ever nearer to its best value at the open end of {axis.path}"
            return replace(found, status="feasible", claim=claim)
    return found


def _tight(program: Program, index: int, one: Hit) -> bool:
    """Whether a proof could only be given with a margin."""
    if one.proven:
        return False
    return index < 0 or missed(program.limits[index], one.value) > -1.01 * MARGIN


def _open(program: Program, hits: Mapping[int, Hit]) -> tuple[str, ...]:
    """Limits (and the goal) not decided over the whole box: neither broken nor proven to be kept everywhere."""
    left = []
    for index, one in hits.items():
        if one.proven or (index >= 0 and missed(program.limits[index], one.value) > TOLERANCE):
            continue
        part: Limit | Aim
        if index >= 0:
            part = program.limits[index]
            least, level, name = part.side == "at_least", part.bound, part.name
            margin = 0.0 if missed(part, one.value) < -1.01 * MARGIN else MARGIN
        else:
            assert program.aim is not None
            part, margin, name = program.aim, MARGIN, "the goal"
            least, level = program.aim.sense < 0, one.value
        level *= 1.0 - margin if least else 1.0 + margin
        if not _covered(part, program, level, least):
            left.append(name)
    return tuple(dict.fromkeys(left))


def _covered(part: Limit | Aim, program: Program, level: float, least: bool) -> bool:
    """Whether a level is kept on the whole box; several excitations each by themselves, the level shared out."""
    form = part.form
    if not isinstance(form, Modulus):
        return False
    if len(form.drives) == 1:
        return Cover(part, program.axes, level, least).proven(_PROOF_SECONDS)
    if least:
        return False
    alone = [replace(part, form=replace(form, drives=(drive,))) for drive in form.drives]
    tops = np.array([hit(one, program.axes).value for one in alone])
    total = float(np.sqrt((tops**2).sum())) if form.combine == "rss" else float(tops.sum())
    if not 0.0 < total < level:
        return False
    return all(
        Cover(one, program.axes, float(top) * level / total).proven(_PROOF_SECONDS)
        for one, top in zip(alone, tops, strict=True)
        if top > 0.0
    ) and bool((tops > 0.0).all())


__all__ = ["Robust", "judged", "robust"]
