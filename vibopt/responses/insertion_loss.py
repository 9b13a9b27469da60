"""What a mount gains against bolting the machine down."""

from typing import ClassVar

from vibopt.arrays import ComplexArray
from vibopt.forms import Form, Modulus
from vibopt.mechanics.built import Motion
from vibopt.mechanics.machine import Machine
from vibopt.mechanics.model import Model
from vibopt.responses.response import HarmonicResponse
from vibopt.responses.response_rows import at_point
from vibopt.signals import Combine, Drive, Output


class InsertionLoss(HarmonicResponse):
    """`response = "insertion_loss"`: motion of the receiving body with the link rigid over that with the link.

    A ratio; write and read it in dB as 20 log10.  The receiver is the second end of the link.

    Keys
    ----
    across: A link between two bodies; the receiver is its second end: `across = "mount"`.
    """

    across: str
    names: ClassVar[dict[str, str]] = {"across": "joining link"}
    normalised: ClassVar[bool] = True
    less_is_worse: ClassVar[bool] = True
    unit_without: ClassVar[str] = "dB"

    @property
    def rigid_link(self) -> str:
        return self.across

    @property
    def ratio_to(self) -> tuple[str, str, str]:
        return "bodies", "insertion loss needs a force on a body", ""

    def output(self, model: Model) -> Output:
        return at_point(model, model.ends[self.across][1])

    def form(self, model: Model, drives: tuple[Drive, ...], combine: Combine) -> Form:
        return Modulus(self.output(model), drives, combine, rigid_link=self.across)

    def measure(self, machine: Machine, motion: Motion) -> ComplexArray:
        joint = next(one for one in machine.joints if one.name == self.across)
        return motion.points[joint.ends[1]]
