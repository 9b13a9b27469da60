"""Several responses, each the greatest by itself, added up: never too small, whatever the times between them."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.forms.form import Against, AtWorst, Form, Local, Worst, by_differences, log_of
from vibopt.records import dataclass

if TYPE_CHECKING:
    from vibopt.forms.modulus import Modulus
    from vibopt.forms.reduce import Reach
    from vibopt.mechanics.model import Model


@dataclass(frozen=True, slots=True)
class Added(AtWorst):
    """Sum of forms that are no less than zero; `squares`: the root of the sum of their squares.

    With `peaks` each is at its greatest over its speeds, also where the least of the whole is asked for.
    """

    parts: tuple[Form, ...]
    squares: bool = False
    peaks: bool = False
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

    def swinging(self, other: Modulus) -> Added:
        return replace(self, parts=tuple(part if part.swings is None else other for part in self.parts))

    def against(self, model: Model, x: FloatArray, name: str, *, least_wanted: bool) -> Against:
        part = next(part for part in self.parts if any(drive.name == name for drive in part.shaken))
        rest = self._together([other.value(model, x) for other in self.parts if other is not part])
        alone = part.against(model, x, name, least_wanted=least_wanted)
        return replace(alone, others=rest, squares=self.squares) if self.peaks else replace(alone, beside=rest)

    def worst(self, model: Model, x: FloatArray, *, least_wanted: bool = False) -> Worst:
        least = least_wanted and not self.peaks
        each = [part.worst(model, x, least_wanted=least) for part in self.parts]
        return Worst(self._together([one.value for one in each]), {k: v for one in each for k, v in one.speeds.items()})

    def extremes(self, model: Model, x: FloatArray, *, least_wanted: bool, within: float = 0.5) -> list[Local]:
        """The one that is made of the worst of each."""

        def value(at: FloatArray) -> float:
            return self.worst(model, at, least_wanted=least_wanted).value

        least = least_wanted and not self.peaks
        first = [part.extremes(model, x, least_wanted=least)[0] for part in self.parts]
        values = np.exp(np.array([local.value for local in first]))
        whole = self._together(values)
        if not 0.0 < whole < np.inf:
            return [Local(log_of(value(x)), by_differences(value, x))]
        shares = (values / whole) ** (2 if self.squares else 1)
        return [Local(log_of(whole), np.asarray(shares @ np.array([local.slope for local in first])))]

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
