"""Several responses, each the greatest by itself, added up: never too small, whatever the times between them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.forms.form import Form, by_differences
from vibopt.records import dataclass

if TYPE_CHECKING:
    from vibopt.forms.modulus import Modulus
    from vibopt.forms.reduce import Reach
    from vibopt.mechanics.model import Model


@dataclass(frozen=True, slots=True)
class Added(Form):
    """Sum of forms that are no less than zero; `squares`: the root of the sum of their squares."""

    parts: tuple[Form, ...]
    squares: bool = False
    no_bounds = "is a sum of what is greatest each by itself: it has no bounds on boxes of designs"
    not_convex = "is a sum of what is greatest each by itself, which is not convex in stiffness and damping"
    rough = "is a sum of what is greatest each by itself, each of which jumps from one peak to another"

    @property
    def searched(self) -> str:
        return next((part.searched for part in self.parts if part.searched), "")

    @property
    def swings(self) -> Modulus | None:
        moving = [part.swings for part in self.parts if part.swings is not None]
        return moving[0] if len(moving) == 1 else None

    def value(self, model: Model, x: FloatArray) -> float:
        return self._together([part.worst(model, x).value for part in self.parts])

    def slope(self, model: Model, x: FloatArray) -> FloatArray:
        first = [part.extremes(model, x, least_wanted=False)[0] for part in self.parts]
        values = np.exp(np.array([one.value for one in first]))
        if not 0.0 < self._together(values) < np.inf:
            return by_differences(lambda at: self.value(model, at), x)
        shares = (values / self._together(values)) ** (2 if self.squares else 1)
        return np.asarray(shares @ np.array([one.slope for one in first]))

    def _together(self, values: list[float] | FloatArray) -> float:
        return float(np.linalg.norm(values) if self.squares else np.sum(values))

    def reach(self, model: Model) -> Reach | None:
        from vibopt.forms.reduce import Reach

        every = [part.reach(model) for part in self.parts]
        known = [one for one in every if one is not None]
        if len(known) < len(every):
            return None
        return Reach([load for one in known for load in one.loads], known[0].read)

    def cost(self, model: Model) -> float:
        return sum(part.cost(model) for part in self.parts)


__all__ = ["Added"]
