"""Conventions of measured data, and phasors as text: the one place where lag, lead and mark positions are told apart.

Inside, everything is written for exp(+i omega t): the angle of a reading says how far the vibration leads the
reference, and the angle of a weight is counted in the sense of rotation.  A weight that sits further on in the sense of
rotation makes its vibration come earlier by the same angle, so y = y0 + H u with H free of the zero mark.
At the door the angle of a reading changes its sign where it is a lag, or a mark position counted with the rotation
(under the flash the mark stands as far on as the vibration is late); the angle of a weight where it is counted against
the rotation.
"""

from __future__ import annotations

import cmath
from collections.abc import Mapping
from math import degrees, tau

from vibopt.errors import QuantityError
from vibopt.records import dataclass
from vibopt.units import Detector, read_quantity
from vibopt.units.parsing import TO_PEAK
from vibopt.units.showing import plain
from vibopt.units.spelling import split_detector

AMPLITUDES = ("length", "velocity", "acceleration")
"""What a sensor may read."""

LAG, LEAD, PHASE, MARK, WITH, AGAINST = "lag", "lead", "phase", "mark", "with rotation", "against rotation"
CHOICES: Mapping[str, tuple[tuple[str, ...], str]] = {
    "phase": ((LAG, LEAD), "whether the angle of a reading says how far the vibration lags or leads the reference"),
    "readings": (
        (PHASE, MARK),
        "whether readings are phase angles or positions of the stroboscope mark (a mirror image)",
    ),
    "angles": ((AGAINST, WITH), "in which sense the angles of weights are counted from zero"),
    "detector": (("pk", "pp", "rms"), "what an amplitude without a word means"),
}


@dataclass(frozen=True, slots=True)
class Conventions:
    """How the user writes angles and amplitudes.

    phase
        "lag" or "lead"; "" where no reading has a phase angle.
    readings
        "phase" or "mark" (positions of the mark on the stator, counted in the sense of `angles`); "" without any angle.
    angles
        "with rotation" or "against rotation": sense of the angles of weights; "" where nothing is said of it.
    detector
        Of amplitudes without a word.
    zero
        Where angle zero is, in words.
    """

    phase: str
    readings: str
    angles: str
    detector: Detector
    zero: str

    @property
    def weight_sense(self) -> int:
        """Internal angle of a weight over the angle written: +1 or -1."""
        return 1 if self.angles == WITH else -1

    @property
    def reading_sense(self) -> int:
        """Internal angle of a reading over the angle written: +1 or -1."""
        if self.readings == MARK:
            return -self.weight_sense
        return -1 if self.phase == LAG else 1

    def weight(self, size: float, angle: float) -> complex:
        """Internal phasor of a weight of `size` at the written `angle` [rad]."""
        return cmath.rect(size, self.weight_sense * angle)

    def reading(self, size: float, angle: float) -> complex:
        """Internal phasor of a reading with peak `size` and the written `angle` [rad]."""
        return cmath.rect(size, self.reading_sense * angle)

    def weight_angle(self, u: complex) -> float:
        """Angle to write for an internal weight, 0 to 2 pi [rad]."""
        return _turn(self.weight_sense * cmath.phase(u))

    def reading_angle(self, y: complex) -> float:
        """Angle to write for an internal reading, 0 to 2 pi [rad]."""
        return _turn(self.reading_sense * cmath.phase(y))

    def said(self) -> dict[str, str]:
        """The words by their keys in the file."""
        return {key: getattr(self, key) for key in (*CHOICES, "zero")}

    def sentences(self, has_readings: bool = True) -> tuple[str, ...]:
        """The conventions in plain words, to stand above every answer; none where the file has none."""
        if not self.angles:
            return ()
        said = [f"Angles of weights are counted {self.angles} from zero, which is at: {self.zero}."]
        if not has_readings:
            return tuple(said)
        if self.readings == MARK:
            said.append(
                "Readings are positions of the stroboscope mark on a scale that stands still, "
                f"counted {self.angles}; the mark moves the other way round than the weight."
            )
        elif self.phase:
            said.append(f"The angle of a reading is how far the vibration {self.phase}s the reference pulse.")
        else:
            said.append("Readings are amplitudes without angle.")
        said.append(f"An amplitude without a word is {self.detector}.")
        return tuple(said)


@dataclass(frozen=True, slots=True)
class Amplitude:
    """An amplitude as read: `value` peak [SI], `dimension`, and its unit and detector as they will be shown."""

    value: float
    dimension: str
    unit: str
    detector: Detector
    echo: str | None = None

    @property
    def shown_unit(self) -> str:
        return f"{self.unit} {self.detector}"


def split_angle(text: str, example: str) -> tuple[str, float | None]:
    """Text in front of the "@" and the angle behind it as written [rad], None where there is no "@"."""
    if text.count("@") > 1:
        raise QuantityError(f'has more than one "@". Write one amount and one angle, for example "{example}".')
    front, sign, behind = text.partition("@")
    return front.strip(), read_angle(behind.strip(), whose=True) if sign else None


def read_angle(text: object, *, whose: bool = False) -> float:
    """An angle as written [rad]; `whose`: it is a part of the value complained about."""
    try:
        angle = read_quantity(text, "angle").value
    except QuantityError as error:
        raise QuantityError(f'has the angle "{text}", which {error.complaint}' if whose else error.complaint) from None
    if abs(angle) > tau * (1.0 + 1e-12):
        turned = plain(degrees(angle % tau), 6)
        raise QuantityError(f'has an angle above 360 deg. Write "{turned} deg", or correct it.')
    return angle


def read_amplitude(text: str, detector: Detector, unit: str = "") -> Amplitude:
    """An amplitude at the door; `unit` is taken where the text has none, `detector` where neither has a word."""
    if unit and not split_detector(behind := behind_number(text))[0]:
        own = split_detector(text)[2]
        bare = split_detector(unit)[0] if own else unit
        text = f"{text.strip().removesuffix(behind).strip()} {bare} {own}".strip()
    failed: list[QuantityError] = []
    for dimension in AMPLITUDES:
        try:
            quantity = read_quantity(text, dimension, amplitude=True)
        except QuantityError as error:
            failed.append(error)
            continue
        if quantity.value < 0.0:
            raise QuantityError("is a negative amplitude. Write it positive and turn the angle by 180 deg.")
        kind = quantity.detector or detector
        value = quantity.value if quantity.detector else quantity.value * TO_PEAK[detector]
        return Amplitude(value, dimension, split_detector(quantity.unit)[0], kind, quantity.echo)
    raise _no_amplitude(text, failed[0])


def read_reading(text: object, conventions: Conventions, unit: str = "") -> tuple[Amplitude, complex, bool]:
    """A reading such as "8.6 mil pp @ 63 deg": its amplitude, internal phasor, and whether it has an angle."""
    if not isinstance(text, str):
        raise QuantityError('is no reading. Write an amplitude and an angle, for example "8.6 mil pp @ 63 deg".')
    front, angle = split_angle(text, "8.6 mil pp @ 63 deg")
    amplitude = read_amplitude(front, conventions.detector, unit)
    return amplitude, conventions.reading(amplitude.value, angle or 0.0), angle is not None


def behind_number(text: str) -> str:
    """What stands behind a number: its unit."""
    return text.strip().lstrip("+-0123456789.eE ")


def _no_amplitude(text: str, error: QuantityError) -> QuantityError:
    if "which" in error.complaint or (
        "is a length" not in error.complaint and "a length is needed" not in error.complaint
    ):
        return error
    return QuantityError(
        f'has "{text}", which is no displacement, velocity or acceleration. Write for example "8.6 mil pp".'
    )


def _turn(angle: float) -> float:
    turned = angle % tau
    return 0.0 if turned >= tau - 1e-12 * tau else turned
