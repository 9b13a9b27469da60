"""How sharp the peaks of a rotor's response to its unbalance are."""

from typing import ClassVar

from pydantic import model_validator

from vibopt.forms import Amplification, Form
from vibopt.mechanics.model import Model
from vibopt.responses.asked_speeds import Over
from vibopt.responses.motion import Displacement
from vibopt.responses.response import Response
from vibopt.signals import Combine, Drive
from vibopt.values import word


class AmplificationFactor(Response):
    """`response = "amplification_factor"`: N / (N2 - N1), greatest of all peaks of a whirl over speeds.

    N is the speed of a peak, N1 and N2 those beside it at which the whirl is 1/sqrt(2) of it; 0 where there is no peak.

    Keys
    ----
    of: A station or disc of a rotor, where the probe is: `of = "drive_end"`.
    over: Ranges of the spin in which peaks count, and they must be said: `over = ["2550..3450 rpm", "5100..6900 rpm"]`.
    due_to: The unbalance that drives it, where there are several: `due_to = ["wheel"]`.
    """

    of: str
    over: Over
    due_to: tuple[str, ...] | None = None
    of_rotors: ClassVar[bool] = True

    @model_validator(mode="after")
    def _over_ranges(self) -> "AmplificationFactor":
        bands = getattr(self.over, "bands", ())
        if not bands or any(band.is_point for band in bands):
            raise word('says no ranges in which peaks of the whirl count. Write over = "2550..3450 rpm".')
        return self

    @property
    def reading(self) -> Displacement:
        said = {"of": self.of, "over": self.over, "due_to": self.due_to}  # read and checked already
        read = Displacement.model_construct(response="displacement", **said)
        return read.model_copy(update={"placed": self.placed}) if self.placed else read

    @property
    def reaches(self) -> tuple[float, ...]:
        return (2.0 * max(band.high for band in self.over.bands),)

    def places(self) -> dict[str, tuple[str, str]]:
        return self.reading.places()

    def form(self, model: Model, drives: tuple[Drive, ...], combine: Combine) -> Form:
        return Amplification(self.reading.output(model), drives)
