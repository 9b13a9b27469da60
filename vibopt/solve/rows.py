"""Limits at fixed speeds as polynomial inequalities, exact and few.

One variable: a polynomial in y (x = y**root).  One mass on (k, c): alpha k^2 + beta k + gamma +
delta c^2 <= 0, linear in q = c^2, so that for given k each row bounds q from one side.
"""

from __future__ import annotations

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.mechanics.model import Model
from vibopt.program.program import Limit, Program
from vibopt.records import dataclass

_MOST_DEGREE = 4
"""Degree of N and D in the variable up to which their squares keep their digits: a mount in space has three springs."""


def single_lines(limit: Limit) -> bool:
    """Whether a limit is one harmonic of one excitation, or knows neither speeds nor poles nor noise."""
    return limit.form.one_line and limit.side != "outside"


@dataclass(frozen=True)
class LineRows:
    """Rows of a program with one variable: polynomials in y, <= 0 where the limit holds.

    root
        x = y**root.
    """

    program: Program
    root: float
    reference: float

    @classmethod
    def of(cls, program: Program) -> LineRows:
        exponents = program.model.exponents[:, 0]
        half = bool((np.abs(exponents * 2 % 2) == 1).any())
        axis = program.axes[0]
        reference = float(np.sqrt(max(axis.low, axis.high * 1e-8) * axis.high))
        return cls(program, 2.0 if half else 1.0, reference)

    def at(self, limit: Limit, speeds: FloatArray) -> list[FloatArray]:
        """Ascending coefficients in y / y_ref, one polynomial per speed (a single one without speeds)."""
        sign = 1.0 if limit.side == "at_most" else -1.0
        own = limit.form.polynomial(self, limit.model, limit.bound)
        if own is not None:
            return [sign * own]
        made = limit.form.sampled(limit.model, speeds, np.array([self.reference]))
        degree = made.groups.degrees[0]
        nodes = np.array([0.0, 1.0, 2.0, 0.5, 3.0])[: degree + 1]
        y = nodes * self.reference ** (1.0 / self.root)
        top, bottom = made.at((y**self.root)[:, None])
        inverse = np.linalg.inv(np.vander(nodes, degree + 1, increasing=True))
        n, d = inverse @ top, inverse @ bottom
        rows = []
        for column in range(n.shape[1]):
            square = np.convolve(n[:, column], np.conj(n[:, column])) - limit.bound**2 * np.convolve(
                d[:, column], np.conj(d[:, column])
            )
            rows.append(sign * square.real / max(float(np.abs(square).max()), 1e-300))
        return rows

    def total(self, model: Model, kind: int) -> FloatArray:
        """Sum of the terms of a kind on one mass, ascending."""
        row = np.zeros(round(self.root * float(model.exponents.max(initial=0.0))) + 1)
        for term in model.terms:
            if term.kind == kind:
                power = round(float(term.exponents[0]) * self.root)
                row[power] += term.scale * self.reference ** float(term.exponents[0]) * float(term.vector[0]) ** 2
        return row

    def accepts(self, limit: Limit) -> bool:
        """Whether the limit is a polynomial inequality."""
        if not single_lines(limit) or (limit.model.exponents < 0.0).any():
            return False
        return limit.form.is_polynomial(limit.model, _MOST_DEGREE)
