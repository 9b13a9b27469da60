"""A design that holds for every machine within its tolerances.

The limits are asked of a few machines, the worst that nature could make of the last design; each
answer shows which machines are worse still, until none is.  Few machines are fewer limits, so what is
proven best for them bounds what is best for all.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field, replace

import numpy as np

from vibopt.answer.entry import TOLERANCE
from vibopt.arrays import FloatArray
from vibopt.errors import counted
from vibopt.program.over import MARGIN
from vibopt.program.program import Limit, Program
from vibopt.program.worst_case import Hit, around, missed
from vibopt.records import dataclass
from vibopt.scene.scene import Scene
from vibopt.solve.branch import Judge
from vibopt.solve.by_name import called
from vibopt.solve.catalogue.why import reason_of
from vibopt.solve.choose import choose
from vibopt.solve.local import refined
from vibopt.solve.method import Found, Method, Progress
from vibopt.solve.proof import breaks, parts_of, settled, tight, worst_machines
from vibopt.solve.several import GOAL, Several, keys_of
from vibopt.solve.spared import sure_of_none
from vibopt.work import Budget

_BROKEN = 0.9 * TOLERANCE
_ROUNDS = 20
_WHOLE = 4
_MOST_LOOKS, _MOST_MACHINES, _COST = 60, 200, 20.0


Among = Mapping[tuple[str, str], FloatArray]
"""Machines (n, n_uncertain), by factors, on which a limit shall hold, by its name and its side as the user counts."""


@dataclass(frozen=True)
class Robust:
    """A design and the machines that are worst for it.

    found
        The answer; its status speaks of all machines within the tolerances.
    hits
        Per limit of the program, and -1 for the goal.
    open
        Limits, "the goal" and measures ("measures.level") of which the worst machine is found but not proven to be so.
    reason
        Why there is no design, where parts are chosen.
    program
        The question on the machines that prove that there is no design.
    measured
        Of each measure, once it is looked at.
    """

    found: Found
    hits: Mapping[int, Hit] = field(default_factory=dict)
    open: tuple[str, ...] = ()
    reason: str = ""
    program: Program | None = None
    measured: Mapping[str, Hit] = field(default_factory=dict)

    @property
    def doubt(self) -> str:
        """Of what the worst machine is found and not proven, in words; "" where all of it is."""
        tried = sum(hit.tried for hit in (*self.hits.values(), *self.measured.values()))
        worst = f"the worst of {counted(tried, 'machines')} found"
        return f"{worst}, not proven for {', '.join(self.open)}" if self.open else ""


def judged(scene: Scene, x: FloatArray) -> Robust:
    """The worst machines around a given design x (n_vars,), proven where that can be done."""
    program = around(scene, x)
    hits, undecided = settled(program, worst_machines(program, {}))
    return Robust(Found("", np.asarray(x), "", ""), hits, undecided)


def robust(
    scene: Scene,
    nominal: Found,
    method: str | Method | None,
    progress: Progress | None = None,
    among: Among | None = None,
) -> Robust:
    """The best design over the tolerances; `nominal` is the answer without them.

    Limits in `among` hold on those machines only.
    """
    if nominal.x is None or nominal.status == "unbounded":
        words = {"infeasible": "even without tolerances", "unbounded": "without tolerances"}
        before = words.get(nominal.status, "already without tolerances")
        status = "unproven" if nominal.status == "unbounded" else nominal.status
        return Robust(replace(nominal, status=status, x=None, claim=f"{before}: {nominal.claim}"))
    return _Run(scene, method, progress, among or {}).answer(nominal)


def nearby(scene: Scene, x: FloatArray, among: Among) -> FloatArray | None:
    """A design to which slopes lead from x (n_vars,), and which holds over the tolerances; None where none is met.

    Limits in `among` hold on those machines only.
    """
    run = _Run(scene, None, None, among)
    run.look(x)
    there, good = run.locally(x)
    return there if good else None


class _Run:
    def __init__(self, scene: Scene, method: str | Method | None, progress: Progress | None, among: Among) -> None:
        self.scene, self.method, self.progress, self.among = scene, method, progress, among
        self.machines = Several(scene)
        self.undecided: tuple[str, ...] = ()
        self.budget = Budget(_MOST_LOOKS, "looks at worst machines", _COST)

    @property
    def _over(self) -> bool:
        return self.budget.over or self.machines.count > _MOST_MACHINES

    def answer(self, nominal: Found) -> Robust:
        assert nominal.x is not None
        return self._of_parts(nominal) if "picks" in nominal.details else self._by_rounds(nominal)

    def _by_rounds(self, nominal: Found) -> Robust:
        assert nominal.x is not None
        x: FloatArray = nominal.x
        safe: FloatArray | None = None
        self.look(x)
        found = nominal
        for step in range(_WHOLE):
            x, good = self.locally(x)
            safe = x if good else safe
            if self.progress is not None:
                self.progress("tolerances", (step + 0.5) / _WHOLE)
            program = self.machines.program()
            found = sure_of_none(program, _at_open_ends(program, self._searched(program)), self._searched)
            if found.status == "infeasible":
                return self._hopeless(found, program=program)
            if found.x is None or found.status == "unbounded":
                break
            hits, broken = self.look(found.x)
            if not broken:
                return self._done(found, hits)
            x = found.x
            if self._over:
                break
        return self._stopped(found, safe)

    def _searched(self, program: Program) -> Found:
        return choose(program, called(self.method)).solve(program, self.progress)

    def _of_parts(self, nominal: Found) -> Robust:
        """Parts from catalogues: searched anew with every machine that one of the best choices failed on."""
        found = self._whole(nominal)
        kept = {key: nominal.details[key] for key in ("free",) if key in nominal.details}
        while True:
            assert found.x is not None
            known = self.machines.asked
            hits, broken = self.look(found.x)
            undecided, picks = self.undecided, found.details["picks"]
            for count, pick in enumerate(picks[1:], start=1):  # each teaches something, broken or not
                if self._over:  # what was not asked is not shown as if it held
                    found = replace(found, details={**found.details, "picks": picks[:count]})
                    break
                broken |= self._fails(np.array(pick["x"]))
            self.undecided = undecided
            if not broken:
                return self._done(found, hits)
            if self._over or self.machines.asked == known:
                return self._stopped(found, None)
            program = self.machines.program()
            searched = sure_of_none(program, self._searched(program), self._searched)
            if searched.status == "infeasible":
                return self._hopeless(searched, reason_of(program, searched), program)
            if searched.x is None:
                return self._stopped(searched, None)
            found = self._whole(replace(searched, details={**kept, **searched.details}))

    def _whole(self, found: Found) -> Found:
        """The answer in the variables of the scene, without the columns of tolerances."""
        assert found.x is not None
        count = len(self.scene.variables)
        picks = [{**one, "x": one["x"][:count]} for one in found.details["picks"]]
        return replace(found, x=found.x[:count], details={**found.details, "picks": picks})

    def _hopeless(self, found: Found, reason: str = "", program: Program | None = None) -> Robust:
        claim = f"{found.claim}, on {counted(self.machines.count, 'machines')} within the tolerances"
        return Robust(replace(found, claim=claim), reason=reason, program=program)

    def _stopped(self, found: Found, safe: FloatArray | None) -> Robust:
        """What is left when the worst machines did not settle: the last design that holds for all of them."""
        if safe is None:
            claim = "no design found that holds for all machines within the tolerances, which proves nothing"
            return Robust(replace(found, status="unproven", x=None, claim=claim))
        hits, _ = self.look(safe)
        claim = "a design that holds over the tolerances; that nothing better exists is not proven"
        return self._done(replace(found, status="feasible", x=safe, claim=claim), hits)

    def _done(self, found: Found, hits: dict[int, Hit]) -> Robust:
        assert found.x is not None
        program = around(self.scene, found.x)
        done = Robust(found, hits, self.undecided)
        status, words = found.status, "over the tolerances: all of it proven"
        if any(tight(program, index, hit) for index, hit in hits.items()):
            words += f" (to {100.0 * MARGIN:g} % of the bound where a limit is tight)"
        if done.open:
            words = f"over the tolerances: {done.doubt}"
            status = "feasible" if status == "optimal" else status
        details = {**found.details, "machines": self.machines.count}
        claimed = replace(found, status=status, claim=f"{found.claim}; {words}", details=details)
        return replace(done, found=claimed)

    def locally(self, x: FloatArray) -> tuple[FloatArray, bool]:
        """A design near x that holds on all machines that are worst for it; whether there is one."""
        for _ in range(_ROUNDS):
            program = self.machines.program()
            there = refined(program, x)
            if there is None or not Judge(program).feasible(there):
                return x, False
            x = there
            _, broken = self.look(x, quick=True)
            if not broken:
                return x, True
            if self._over:
                break
        return x, False

    def look(self, x: FloatArray, *, quick: bool = False) -> tuple[dict[int, Hit], bool]:
        """The worst machines for a design; those that break a limit or the goal are kept. Whether any does."""
        self.budget.spend()
        program = around(self.scene, x)
        known = {index: self.machines.near(x, key) for index, key in keys_of(program).items()}
        told = {
            i: _worst_among(limit, self.among[key])
            for i, limit in enumerate(program.limits)
            if (key := (limit.name, limit.user_side)) in self.among
        }
        hits = worst_machines(program, known, quick=quick, told=told)
        if not quick:
            hits, self.undecided = settled(program, hits)
        return hits, self._learn(program, x, hits)

    def _fails(self, x: FloatArray) -> bool:
        """Whether some machine breaks a limit of a design, or the goal that it is known to reach; it is kept."""
        self.budget.spend()
        program = around(self.scene, x)
        hits, keys = {}, keys_of(program)
        for index, part in parts_of(program).items():
            found = breaks(part, program.axes, self.machines.near(x, keys[index]))
            if found is not None:
                hits[index] = found
        return self._learn(program, x, hits)

    def _learn(self, program: Program, x: FloatArray, hits: Mapping[int, Hit]) -> bool:
        """Keep the machines that break a limit or the goal, and the first of every limit; whether any does."""
        broken, level, keys = False, self._level(program, x), keys_of(program)
        for index, hit in hits.items():
            if index >= 0:
                bad = missed(program.limits[index], hit.value) > _BROKEN
            else:
                assert program.aim is not None
                fresh = level == -np.inf and bool((hit.factors != 1.0).any())
                bad = fresh or program.aim.sense * hit.value > level + _BROKEN * abs(level)
            if bad or keys[index] not in self.machines.worst:
                self.machines.add(keys[index], self.machines.parts_off(x, hit.factors))
            broken |= bad
        return broken

    def _level(self, program: Program, x: FloatArray) -> float:
        """The goal (to be minimised) on the machines known."""
        if GOAL not in self.machines.worst or program.aim is None:
            return -np.inf
        aim = program.aim
        machines = [self.machines.factors(x, one) for one in self.machines.worst[GOAL]]
        return max(piece.sense * piece.worst(machine).value for piece in aim.pieces for machine in machines)


def _worst_among(limit: Limit, machines: FloatArray) -> Hit:
    """The worst of machines (n, n_uncertain) that are all there are."""
    values = np.array([limit.worst(one).value for one in machines])
    k = int(np.argmax([missed(limit, value) for value in values]))
    return Hit(machines[k], float(values[k]), True, len(machines))


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
