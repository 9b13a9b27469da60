"""A smooth program in CasADi, with its variables and limits by name."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import field, replace
from typing import Any

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.errors import InputError, way_out
from vibopt.program.casadi_nlp import IPOPT, QUIET
from vibopt.records import dataclass

OPTIONS: dict[str, Any] = {
    **IPOPT, "ipopt.max_iter": 300, "ipopt.tol": 1e-10, "ipopt.constr_viol_tol": 1e-10, "ipopt.acceptable_tol": 1e-9,
}  # fmt: skip
"""How IPOPT is asked; to ten digits."""
ENDS = ("Solve_Succeeded", "Solved_To_Acceptable_Level")
"""Words with which IPOPT calls a point a local optimum."""


@dataclass(frozen=True)
class NonlinearProgram:
    """minimise f(x)  with  lbx <= x <= ubx,  lbg <= g(x) <= ubg.

    x, f, g
        CasADi expressions: the unknowns (n, 1), the goal (scaled), the limits (m, 1), each scaled to order one.
    lbx, ubx, lbg, ubg, x0
        Bounds and a place to start, shape (n,) and (m,).
    names
        Of each row of g: the path of its limit in the file, and the reading and speed where there are some; what still
        has one name is counted.
    variables
        What is chosen, by its path in the file, as an expression of x in SI units: write constraints with these.
    again
        For peaks over ranges of speed: finds the worst speeds anew for a program with more limits.
    """

    x: Any
    f: Any
    g: Any
    lbx: FloatArray
    ubx: FloatArray
    lbg: FloatArray
    ubg: FloatArray
    x0: FloatArray
    names: tuple[str, ...]
    variables: Mapping[str, Any]
    again: Callable[[tuple[tuple[str, Any, float, float], ...]], NonlinearProgram] | None = field(
        default=None, repr=False, compare=False
    )
    own: tuple[tuple[str, Any, float, float], ...] = field(default=(), repr=False)

    @property
    def bounds(self) -> dict[str, FloatArray]:
        """The start and all bounds, as the solver is called: `solver(**program.bounds)`."""
        return {"x0": self.x0, "lbx": self.lbx, "ubx": self.ubx, "lbg": self.lbg, "ubg": self.ubg}

    def nlpsol(self, solver: str = "ipopt", **options: Any) -> Any:
        """`casadi.nlpsol` of the program: call it with `**program.bounds`, or with bounds of your own."""
        import casadi

        own = {**QUIET, **(OPTIONS if solver == "ipopt" else {})}
        return casadi.nlpsol("posed", solver, {"x": self.x, "f": self.f, "g": self.g}, {**own, **options})

    def values(self, x: Any) -> dict[str, Any]:
        """What is chosen at x [SI]: a float, a complex number for a weight."""
        import casadi

        point = np.array(x, dtype=float).ravel()
        found = {}
        for path, variable in self.variables.items():
            numbers = np.array(casadi.Function("value", [self.x], [variable])(point)).ravel()
            found[path] = complex(*numbers) if len(numbers) == 2 else float(numbers[0])
        return found

    def subject_to(self, name: str, expression: Any, low: float = -np.inf, high: float = np.inf) -> NonlinearProgram:
        """The program with one more limit: low <= expression <= high.

        Parameters
        ----------
        name
            By which it stands in `names`.
        expression
            Of `variables` (one row); written in numbers of order one it is solved most exactly.

        Notes
        -----
        Where a limit looks at a range of speeds, the worst speeds are those of the design with this limit.
        """
        import casadi

        if name in self.names:
            raise InputError(f"there is a limit {name} already. Choose another name.")
        more = (*self.own, (name, casadi.SX(expression), low, high))
        if self.again is not None:
            return self.again(more)
        return replace(
            self, g=casadi.vertcat(self.g, more[-1][1]), lbg=np.append(self.lbg, low), ubg=np.append(self.ubg, high),
            names=(*self.names, name), own=more,
        )  # fmt: skip

    def variable(self, path: str) -> Any:
        """The expression of one variable by its path; InputError with the nearest path where there is none."""
        if path not in self.variables:
            raise InputError(f"there is no variable {path}.{way_out(path, list(self.variables))}")
        return self.variables[path]


def told_apart(names: Sequence[str]) -> tuple[str, ...]:
    """Names of rows, those that stand several times counted: "limits.floor (2)"."""
    many, seen = Counter(names), Counter[str]()
    told = []
    for name in names:
        seen[name] += 1
        told.append(f"{name} ({seen[name]})" if many[name] > 1 else name)
    return tuple(told)


class Collected:
    """Unknowns with their ends and starts, and rows (name, expression <= 0, whether it is an equation)."""

    def __init__(self) -> None:
        self.unknowns: list[Any] = []
        self.box: list[tuple[float, float, float]] = []
        self.rows: list[tuple[str, Any, bool]] = []
        self.variables: dict[str, Any] = {}

    def unknown(self, name: str, low: float, high: float, start: float) -> Any:
        import casadi

        self.unknowns.append(casadi.SX.sym(name))
        self.box.append((low, high, start))
        return self.unknowns[-1]

    def below(self, name: str, *expressions: Any, equal: bool = False) -> None:
        """What is no more than zero, or zero."""
        self.rows += [(name, expression, equal) for expression in expressions]

    def program(self, goal: Any) -> NonlinearProgram:
        """All of it, with a goal."""
        import casadi

        low, high, start = (np.array(column, dtype=float) for column in zip(*self.box, strict=True))
        rows = casadi.vertcat(*[row for _, row, _ in self.rows]) if self.rows else casadi.SX(0, 1)
        return NonlinearProgram(
            casadi.vertcat(*self.unknowns), goal, rows, low, high,
            np.array([0.0 if same else -np.inf for *_, same in self.rows]), np.zeros(len(self.rows)), start,
            told_apart([name for name, *_ in self.rows]), self.variables,
        )  # fmt: skip
