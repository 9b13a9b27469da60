"""The spin beyond which what turns with a shaft, or its bearings, make its whirl grow."""

from typing import ClassVar

from vibopt.forms import Form, WhirlThreshold
from vibopt.mechanics.machine import Machine
from vibopt.mechanics.model import Model
from vibopt.responses.response import Response
from vibopt.signals import Combine, Drive

_BEYOND, _GROWING = 1.5, 2
"""Times a limit up to which a threshold is looked for; how many of the lowest whirls may grow first."""


class StabilityThreshold(Response):
    """`response = "stability_threshold"`: least spin beyond which a free whirl grows [rad/s].

    By damping that turns with a shaft, `rotating_damping` or `material_damping`, of one disc w_n (1 + c_e / c_i); or by
    bearings that couple both planes, oil films and seals.  It is "none up to" some spin where none is found so far,
    and "none" where nothing can feed a whirl.
    """

    dimension: ClassVar[str] = "angular_rate"
    less_is_worse: ClassVar[bool] = True
    unit_without: ClassVar[str] = "rpm"

    @property
    def free_vibration(self) -> str:
        return "stability threshold of free whirl"

    @property
    def modes(self) -> int:
        """Lowest whirls that the shaft must keep: what grows is mostly the first."""
        return _GROWING

    @property
    def absent(self) -> str:
        return "none"

    @property
    def _top(self) -> float:
        """Highest spin that is looked at where bearings are not alike in both planes [rad/s]; 0 where nobody says."""
        return _BEYOND * self.at_least.value if self.at_least is not None else 0.0

    @property
    def unbound(self) -> Response:
        """Itself: the bound says how far it is looked."""
        return self

    def looked_to(self, machine: Machine) -> float:
        return machine.settled_to(self._top)

    def form(self, model: Model, drives: tuple[Drive, ...], combine: Combine) -> Form:
        return WhirlThreshold(self._top)

    def measure_static(self, machine: Machine) -> float:
        return machine.threshold(self._top)
