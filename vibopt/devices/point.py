"""A named place on a body in space: asked about and acted on."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from vibopt.devices.device import Device
from vibopt.devices.symbols import Numbers, Symbols
from vibopt.mechanics.assembly import Assembly
from vibopt.mechanics.builder import ModelBuilder
from vibopt.values.directions import Place


class PointTable(Device):
    """`[points.NAME]`: a place that moves with a body.

    Keys
    ----
    on: The body in space that it belongs to: `on = "genset"`. Refused on a body on a line, which is a point itself.
    at: Its place from the common origin: `at = ["1.2 m", "0.3 m", "0.9 m"]`.
    """

    on: str
    at: Place

    @classmethod
    def moving_in(cls, name: str, given: Mapping[str, Any]) -> tuple[str, ...]:
        return (name,)

    @classmethod
    def freedoms_in(cls, name: str, given: Mapping[str, Any]) -> int:
        return 0

    def declare(self, builder: ModelBuilder, name: str) -> None:
        builder.fix(name, self.on, self.at)

    def add_to(self, builder: ModelBuilder, name: str, symbols: Symbols) -> None:
        """Nothing: it moves as its body does."""

    def built(self, assembly: Assembly, name: str, numbers: Numbers) -> None:
        assembly.fixed[name] = (self.on, np.array(self.at))
