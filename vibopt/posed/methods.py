"""`--method cvxpy` and `--method ipopt`: the programs in the open, solved and judged like any other answer."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from vibopt.arrays import ComplexArray
from vibopt.balancing import is_engine, is_rotor
from vibopt.balancing.engine.choose_weights import chosen
from vibopt.balancing.question import Question, Solved, breaks, felt, relative_gap, wider_words
from vibopt.errors import InputError
from vibopt.posed import conic
from vibopt.posed.nonlinear import ENDS, NonlinearProgram
from vibopt.posed.posed import PROVEN
from vibopt.posed.posed_job import posed
from vibopt.posed.weights import Named, convex, smooth
from vibopt.work import worked

CVXPY, IPOPT = "cvxpy", "ipopt"
MARGINS = (0.0, 2e-9, 2e-8)
"""Parts by which bounds are drawn in, one after the other, until the answer keeps the true ones to 1e-9."""
KEPT = 1e-9
_NOTHING = 1e-8
"""Part of what the readings would feel below which a weight is none."""
_REMAINDER = 1e-3
"""Part of what the solver leaves of a goal that is zero: more than that is left where it cannot be."""
_IPOPT = 5.0
"""Nominal work of a run of IPOPT [ms]."""


def solver_of(job: Any, method: str) -> Callable[..., Any]:
    """What answers the program of a balancing job; InputError, in words, where there is no such program."""
    if job.is_search if is_engine(job) else is_rotor(job) and (job.is_advice or not job.has_phase):
        opened = posed(job)
        (opened.cvxpy if method == CVXPY else opened.casadi)()
    paths = chosen(job) if is_engine(job) else tuple(f"planes.{plane.name}" for plane in job.planes)
    run = {CVXPY: _cvxpy, IPOPT: _ipopt}[method]

    def solver(question: Question) -> Solved:
        named = Named.plain(question, paths)
        why = named.not_smooth() or (named.not_convex() if method == CVXPY else "")
        if why:
            raise InputError(f"{job.name}: --method {method}: {why}.")
        found = run(named)
        if found.u is None:
            return found
        chosen = tuple(-1 if option is None else 0 for option in question.options)
        return replace(found, u=found.u + named.fixed if len(named.fixed) else found.u, chosen=chosen)

    return solver


def _cvxpy(named: Named) -> Solved:
    question, bound = named.question, -np.inf
    for margin in MARGINS:
        problem = convex(named, margin=margin)
        run = conic.solved(problem)
        if margin == 0.0:
            bound = run.bound * named.size
        if not run.claims:
            return _none(named, run.status)
        u = _weights(named, problem)
        u[np.abs(u) <= _NOTHING * felt(question.y0, question.H)] = 0.0  # no angle can be told of it
        u = _without_remainder(named, u)
        if _kept(named, u):
            break
    else:
        return Solved(None, "unproven", "what cvxpy returns breaks limits by more than rounding")
    value = question.value(u)
    gap = relative_gap(value, bound, named.size)
    status = "optimal" if gap <= PROVEN else "feasible"
    claim = f"the convex program in cvxpy, gap {gap:.1e} by our own dual bound"
    return Solved(u, status, claim, value, bound, gap)


def _without_remainder(named: Named, u: ComplexArray) -> ComplexArray:
    """The weights moved to where nothing is left, where they leave no more than the tolerance of the solver."""
    q = named.question
    value = q.value(u)
    if q.goal == "correction" or not 0.0 < value <= PROVEN * named.size:
        return u
    fitted = np.flatnonzero(u).tolist()
    turns = [k for k in fitted if named.ends[k] is None]
    lines = np.hstack([q.H[:, fitted], 1j * q.H[:, turns]])
    left = q.residual(u)
    step = np.linalg.lstsq(np.vstack([lines.real, lines.imag]), -np.concatenate([left.real, left.imag]), rcond=1e-12)[0]
    moved = u.copy()
    moved[fitted] += step[: len(fitted)]
    moved[turns] += 1j * step[len(fitted) :]
    return moved if q.value(moved) < _REMAINDER * value and _kept(named, moved) else u


def _kept(named: Named, u: ComplexArray) -> bool:
    """Whether every limit holds but for rounding; one of zero where next to nothing of the greatest reading is left."""
    question = replace(named.question, limits=np.maximum(named.question.limits, named.zero))
    return not breaks(question, u, KEPT)


def _weights(named: Named, problem: Any) -> ComplexArray:
    """The values of a solved problem, (n_planes,)."""
    u = np.zeros(named.question.n_planes, dtype=complex)
    for k in named.free:
        variable = problem.var_dict.get(named.planes[k])
        u[k] = 0.0 if variable is None else complex(variable.value)
    for first, second, ratio in named.question.pairs:
        u[second] = ratio * u[first]
    return named.within(u)


def _none(named: Named, status: str) -> Solved:
    """No answer: infeasible where the least common factor on all limits is proven to be above one."""
    q = named.question
    if status.startswith("infeasible") and np.isfinite(q.limits).any():
        least = Named.plain(replace(q, limits=np.maximum(q.limits, 2.0 * named.zero)))
        factor = conic.solved(convex(least, widened=True)).bound
        if factor > 1.0 + KEPT:
            return Solved(None, "infeasible", wider_words(q, factor), least_factor=factor)
    claim = f"cvxpy finds no correction (Clarabel: {status}), which is not proven here"
    return Solved(None, "unproven", claim)


def _ipopt(named: Named) -> Solved:
    program = smooth(named)
    question, word = named.question, ""
    for margin in MARGINS:
        values, word = ran(program, margin)
        u = named.within(np.array([values.get(path, 0.0) for path in named.planes], dtype=complex))
        u = _without_remainder(named, u)
        if _kept(named, u):
            return Solved(u, "feasible", _claim(word), question.value(u))
    return Solved(None, "unproven", f"IPOPT ends without a correction that keeps the limits: {word}")


def _claim(word: str) -> str:
    if word in ENDS:
        return f"a local optimum by IPOPT ({word}); that nothing better exists is not proven"
    return f"IPOPT stops on the way ({word}); every limit holds, and better ones may be near"


def ran(program: NonlinearProgram, margin: float = 0.0) -> tuple[dict[str, Any], str]:
    """What IPOPT ends at from the program's own start, and its word; bounds of rows are drawn in by `margin`.

    Where it gives up it is asked once more from there.
    """
    solver = program.nlpsol()
    inward = np.where(program.lbg == program.ubg, 0.0, margin)
    asked, word = {**program.bounds, "ubg": program.ubg - inward}, ""
    for _ in range(2):
        worked(_IPOPT)
        asked["x0"] = np.array(solver(**asked)["x"]).ravel()
        word = str(solver.stats()["return_status"])
        if word in ENDS or not np.isfinite(asked["x0"]).all():
            break
    return program.values(asked["x0"]), word
