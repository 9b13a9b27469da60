"""Balancing in the charts; planes, sensors and speeds that are declared and that the answer did not need."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from vibopt.arrays import ComplexArray
from vibopt.balancing.continuous import solve_continuous
from vibopt.balancing.question import Question, Solved
from vibopt.charts.balancing_questions import Asked, asked, families, normal, plain, stock, worst
from vibopt.charts.balancing_rivals import GIVEN_CLARABEL, METHODS, judged_question
from vibopt.charts.cutting_planes import least_worst
from vibopt.charts.fidelity import Fidelity, of_kinds, seconds
from vibopt.charts.trial import Table
from vibopt.jobs import answer, from_text
from vibopt.solve.rivals.hsbalance import installed

ALIKE, BINDS = 1e-10, 1e-5
"""Share of a plane's effect that the others must leave for it to count, and of the goal within which a row binds."""
_SENSORS = 4
Rows = NDArray[np.intp]

_V_TWIN = """title = "V twin"

[engine]
stroke = "72 mm"
rod = "130 mm"
speed = "7000 rpm"
reciprocating = "0.4 kg"
counterweight_share = 0.5
{}

[[cylinders]]
throw = "pin"
crank = "0 deg"
bank = "-45 deg"
at = "0 mm"

[[cylinders]]
throw = "pin"
bank = "45 deg"
at = "0 mm"

[measures.force]
response = "force"
"""


def speed(*, quick: bool) -> Table:
    """Least squares, smallest worst residual and discrete weights, timed in one run."""
    left = ("5000 readings in 8 planes", "5 runs instead of 2", f"methods {', '.join(SLOWER)}") if quick else ()
    return replace(table_of(stock(quick=quick), 2 if quick else 5, SLOWER if quick else ()), left=left)


def hard(*, quick: bool) -> Table:
    """Planes alike, dead and spoilt sensors, units and scatter."""
    left = ("further decades of condition numbers, of units and of planes alike", "scatter of 1 % and 50 %")
    lines = tuple(name for name in METHODS if name.startswith(("cvxpy", "milp")) and name != "cvxpy 1e-08")
    return replace(table_of(families(quick=quick), 1, lines), drops=True, left=left if quick else ())


SLOWER = ("cvxpy 0.0001", "cvxpy 1e-10", "milp 32", "milp 64", "milp 128")


def table_of(cases: Sequence[Asked], runs: int, less: Sequence[str] = SLOWER) -> Table:
    """Questions of rotors given to every method but some; a rival that is not installed is named once."""
    methods = {
        name: method for name, method in METHODS.items()
        if name not in less and (name != GIVEN_CLARABEL or installed())
    }  # fmt: skip
    warm = asked("", worst(8, 2), 1.0, "")
    return Table([(case.case, case) for case in cases], methods, judged_question, runs, [(warm.case, warm)])


def fidelity(*, quick: bool) -> list[tuple[str, Callable[[], Sequence[Fidelity]]]]:
    """Rotors with planes that act alike, and with sensors and speeds that do not bind; cranks by few orders."""
    runs = 3 if quick else 15
    solve_continuous(worst(8, 2))
    planes, sensors, speeds = (((4, 2),), (24,), (12,)) if quick else (((4, 2), (8, 3)), (8, 24), (3, 12, 96))
    rows: list[tuple[str, Callable[[], Sequence[Fidelity]]]] = []
    rows += [(f"rotor, {counts[0]} planes", partial(_planes, *counts, runs)) for counts in planes]
    rows += [(f"rotor, {n} sensors", partial(_sensors, n, runs)) for n in sensors]
    rows += [(f"rotor, {n} speeds", partial(_speeds, n, runs)) for n in speeds]
    cranks = {"textbook": 'kinematics = "truncated"', **{f"{n} orders": f"orders = {n}" for n in (2, 4, 6)}}
    return rows + [(f"V twin, {words}", partial(_crank, words, said, runs)) for words, said in cranks.items()]


def independent(H: ComplexArray) -> Rows:
    """Planes that the others do not replace, those of great effect first."""
    left = H / np.linalg.norm(H, axis=0)
    kept: list[int] = []
    while len(kept) < min(H.shape):
        size = np.linalg.norm(left, axis=0)
        plane = int(np.argmax(size))
        if size[plane] <= ALIKE:
            break
        kept.append(plane)
        unit = left[:, plane] / size[plane]
        left = left - np.outer(unit, unit.conj() @ left)
    return np.array(sorted(kept), dtype=np.intp)


def binding(question: Question, solved: Solved) -> Rows:
    """Readings that the goal "worst" touches; the others may be left out, since the program is convex."""
    if solved.u is None:
        return np.arange(question.n_readings)
    size = question.importance * np.abs(question.residual(solved.u))
    return np.flatnonzero(size >= solved.value * (1.0 - BINDS))


def _crank(words: str, said: str, runs: int) -> list[Fidelity]:
    """The shaking force of a V twin through a turn of its crank, and by the orders of a series."""

    def greatest(kinematics: str) -> float:
        return float(answer(from_text(_V_TWIN.format(kinematics), name="job")).measures["force"].value.value)

    whole, simple = partial(greatest, "orders = 20"), partial(greatest, said)
    return of_kinds(f"V twin, {words}", ("turn", "series"), whole, simple, runs)


def _planes(declared: int, rank: int, runs: int) -> list[Fidelity]:
    base = worst(16, rank, capped=False)
    mix = np.random.default_rng(7).normal(size=(rank, declared)) + 0j
    question = plain(base.y0, base.H @ mix, "worst")
    kept = independent(question.H)
    small = replace(question, H=question.H[:, kept], caps=question.caps[kept])
    why = "the effect of the others is a sum of theirs"
    return _compared(f"rotor, {declared} planes", (declared, len(kept)), why, question, small, 1.0, runs)


def _sensors(count: int, runs: int) -> list[Fidelity]:
    question = worst(count, 2, capped=False)
    kept = binding(question, solve_continuous(question))
    case, why = f"rotor, {count} sensors", "only these come up to the worst residual"
    return _compared(case, (count, len(kept)), why, question, _only(question, kept), 1.0, runs)


def _speeds(count: int, runs: int) -> list[Fidelity]:
    """Two bending modes passed at `count` speeds, four sensors, three planes."""
    speeds = np.linspace(0.3, 2.2, count)
    shapes = (np.random.default_rng(8).normal(size=(2, _SENSORS)), np.random.default_rng(9).normal(size=(2, 3)))
    modal = np.stack([speeds**2 / (w * w - speeds**2 + 0.06j * w * speeds) for w in (1.0, 1.9)], axis=-1)
    H = np.einsum("vm,ms,mp->vsp", modal, *shapes).reshape(count * _SENSORS, 3)
    y0 = H @ np.array([1.0, -0.6j, 0.4]) + 0.2 * normal(np.random.default_rng(1), count * _SENSORS)
    question = plain(y0, H, "worst", 1.0)
    used = np.unique(binding(question, solve_continuous(question)) // _SENSORS)
    kept = (used[:, None] * _SENSORS + np.arange(_SENSORS)).ravel()
    case, why = f"rotor, {count} speeds", "only these have a sensor that comes up to the worst residual"
    best, _ = least_worst(question)
    return _compared(case, (count, len(used)), why, question, _only(question, kept), best, runs)


def _only(question: Question, rows: Rows) -> Question:
    return replace(
        question, y0=question.y0[rows], H=question.H[rows], importance=question.importance[rows],
        limits=question.limits[rows],
    )  # fmt: skip


def _compared(
    case: str, counts: tuple[int, int], why: str, full: Question, small: Question, best: float, runs: int
) -> list[Fidelity]:
    """Both solved and timed.

    The answer of the small one is measured at every reading of the full one; `best` is the goal that can be had
    there, known by another road.
    """
    solving_full, there = seconds(lambda: solve_continuous(full), runs)
    solving, here = seconds(lambda: solve_continuous(small), runs)
    if here.u is None or there.u is None:
        raise RuntimeError(f"{case}: {here.claim}; {there.claim}")
    u, v = here.u, there.u
    judge = full if small.n_planes == full.n_planes else small
    return [Fidelity(
        case=case,
        declared=counts[0],
        used=counts[1],
        why=why,
        measuring=seconds(lambda: small.value(u), 20 * runs)[0],
        measuring_full=seconds(lambda: full.value(v), 20 * runs)[0],
        solving=solving,
        solving_full=solving_full,
        value_error=abs(judge.value(u) - here.value) / best,
        goal_error=abs(judge.value(u) - best) / best,
    )]  # fmt: skip
