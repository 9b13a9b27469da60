"""How much room there is in the limits: a goal that asks no response of its own."""

from typing import ClassVar

from vibopt.responses.response import Response


class Margin(Response):
    """`maximise = "margin"`: the part of its bound that every limit has left over at least; a goal and nothing else.

    Bounds that are all tightened by this part are still kept, so it is the least number in the column Margin of an
    answer: the design in the middle of what its limits permit.

    Keys
    ----
    limits: The limits that count, the others just hold: `limits = ["floor_force", "start_up"]`. Without it all count,
        and what parts are rated for. Refused of a limit with `outside` or with the bound zero, of which no part is left
        over, and beside tolerances.
    """

    limits: tuple[str, ...] | None = None
    dimension: ClassVar[str] = "ratio"
    less_is_worse: ClassVar[bool] = True
    unit_without: ClassVar[str] = "%"
    of_limits: ClassVar[bool] = True
    against_friction: ClassVar[str] = ""

    @property
    def said_of(self) -> str:
        return f"in {'every limit' if self.limits is None else ' and '.join(self.limits)}"

    def speaks_for(self, name: str) -> bool:
        """Whether a limit of this name, or a rating, counts."""
        return self.limits is None or name in self.limits
