"""Where a body is, some time after the machine has been let go."""

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar

import numpy as np

from vibopt.errors import QuantityError
from vibopt.forms import Form, FreeMotion
from vibopt.mechanics.free_motion import propagated
from vibopt.mechanics.machine import Machine
from vibopt.mechanics.model import Model
from vibopt.records import dataclass
from vibopt.responses.response import Response
from vibopt.signals import Combine, Drive
from vibopt.units import read_quantity
from vibopt.values import Fact, number
from vibopt.values.fields import ReadBy, complaint

_KEYS = {"displacement": "length", "velocity": "velocity"}
_EXAMPLE = 'Write released = { first = { displacement = "10 mm", velocity = "0.3 m/s" } }.'
_LONGEST = 3600.0


@dataclass(frozen=True, slots=True)
class Start:
    """A body as it is let go: displacement [m] and velocity [m/s], both with their sign."""

    body: str
    displacement: float
    velocity: float


def _released(given: object) -> object:
    if isinstance(given, tuple):
        return given
    if not isinstance(given, Mapping) or not given:
        raise complaint(f"says of no body how it is let go. {_EXAMPLE}")
    try:
        return tuple(_start(body, words) for body, words in given.items())
    except QuantityError as error:
        raise complaint(str(error)) from None


def _start(body: str, words: object) -> Start:
    if not isinstance(words, Mapping) or not words:
        raise QuantityError(f"says neither displacement nor velocity of {body}. {_EXAMPLE}")
    unknown = sorted(set(words) - set(_KEYS))
    if unknown:
        raise QuantityError(f'has an unknown key "{unknown[0]}" for {body}. {_EXAMPLE}')
    read = {}
    for key, dimension in _KEYS.items():
        try:
            read[key] = read_quantity(words[key], dimension).value if key in words else 0.0
        except QuantityError as error:
            raise QuantityError(f"has a {key} of {body} that cannot be read: it {error}") from None
    return Start(body, read["displacement"], read["velocity"])


Released = Annotated[
    Any,
    ReadBy(_released, {"type": "object", "description": 'by body: { displacement = "10 mm", velocity = "0.3 m/s" }'}),
]


class FreeDisplacement(Response):
    """`response = "free_displacement"`: of a body, `after` a time of free damped vibration [m], with its sign.

    `released` says of each body how it is let go; a body that is not named begins at rest.  Bases stand still.

    Keys
    ----
    of: The body: `of = "first"`.
    after: Time since the machine was let go: `after = "0.4 s"`.
    released: How each body is let go; one that is not named begins at rest: `released = { first = { displacement =
        "10 mm", velocity = "0.3 m/s" } }`.
    """

    of: str
    after: Fact = number("time", choice=False, sign="not negative", most=_LONGEST, required=True)
    released: Released
    dimension: ClassVar[str] = "length"
    signed: ClassVar[bool] = True
    moves: ClassVar[str] = "line"

    @property
    def free_vibration(self) -> str:
        return "free vibration"

    def places(self) -> dict[str, tuple[str, str]]:
        return {"of": (self.of, "body"), **{f"released.{one.body}": (one.body, "body") for one in self.released}}

    def form(self, model: Model, drives: tuple[Drive, ...], combine: Combine) -> Form:
        names = [name for name, row in model.points.items() if row[: model.n_free].any()]
        rows = np.array([model.points[name][: model.n_free] for name in names])
        started = {one.body: (one.displacement, one.velocity) for one in self.released}
        both = np.linalg.solve(rows, np.array([started.get(name, (0.0, 0.0)) for name in names]))
        return FreeMotion(model.points[self.of], both[:, 0], both[:, 1], self.after.value)

    def measure_static(self, machine: Machine) -> float:
        started = {one.body: (one.displacement, one.velocity) for one in self.released}
        both = np.array([started.get(name, (0.0, 0.0)) for name in machine.masses])
        mass, damping, stiffness, _ = machine.matrices()
        return float(machine.row(self.of) @ propagated(mass, damping, stiffness, both, self.after.value))
