"""Pulses: a force on a body or the acceleration of a base that comes, once or a few times, and is over."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, Literal

import numpy as np
from pydantic import field_validator, model_validator

from vibopt.arrays import FloatArray
from vibopt.excitations.directed import Directed
from vibopt.excitations.excitation import Transient
from vibopt.excitations.segments import AFTER, lasting, line, moved, sine
from vibopt.signals import Segment
from vibopt.units import reads
from vibopt.values import Fact, number, word
from vibopt.values.fields import complaint

Shape = Literal[
    "half sine", "versed sine", "sine", "rectangle", "triangle", "rising sawtooth", "falling sawtooth", "decaying sine",
    "step",
]  # fmt: skip
_SUDDEN = ("rectangle", "rising sawtooth", "falling sawtooth", "step")
_LASTS = ("duration", "duration_up_to", "duration_from", "frequency", "damping_ratio", "times", "every")
_MOST = 1000
_ROUNDING = 1e-12
_FADED = 36.0
"""Decay after which a sine is rounding."""
_PARTS: dict[str, Callable[[float], tuple[Segment, ...]]] = {
    "half sine": lambda length: (sine(length, 1.0, 0.0, np.pi),),
    "versed sine": lambda length: (sine(length, 0.5, -0.5 * np.pi, 2.0 * np.pi, offset=0.5),),
    "sine": lambda length: (sine(length, 1.0, 0.0, 2.0 * np.pi),),
    "rectangle": lambda length: (line(length, 1.0, 1.0),),
    "triangle": lambda length: (line(0.5 * length, 0.0, 1.0), line(0.5 * length, 1.0, 0.0)),
    "rising sawtooth": lambda length: (line(length, 0.0, 1.0),),
    "falling sawtooth": lambda length: (line(length, 1.0, 0.0),),
}
_VALUES: dict[str, Callable[[FloatArray], FloatArray]] = {
    "half sine": lambda part: np.sin(np.pi * part),
    "versed sine": lambda part: np.sin(np.pi * part) ** 2,
    "sine": lambda part: np.sin(2.0 * np.pi * part),
    "rectangle": lambda part: np.ones(part.shape),
    "triangle": lambda part: 1.0 - np.abs(2.0 * part - 1.0),
    "rising sawtooth": lambda part: part,
    "falling sawtooth": lambda part: 1.0 - part,
    "step": lambda part: np.ones(part.shape),
}
"""Against the part of its duration that is over: for the second route, without any segment."""
_MOVED: dict[str, tuple[Callable[[FloatArray], FloatArray], dict[float, float]]] = {
    "half sine": (lambda part: -(np.pi**2) * np.sin(np.pi * part), {0.0: np.pi, 1.0: np.pi}),
    "versed sine": (lambda part: 2.0 * np.pi**2 * np.cos(2.0 * np.pi * part), {}),
    "sine": (lambda part: -4.0 * np.pi**2 * np.sin(2.0 * np.pi * part), {0.0: 2.0 * np.pi, 1.0: -2.0 * np.pi}),
    "triangle": (lambda part: 0.0 * part, {0.0: 2.0, 0.5: -4.0, 1.0: 2.0}),
}
"""Of a base by its displacement: acceleration against that part, and jumps of its velocity, both for a second."""

_OF_BASES = (("an acceleration", "acceleration", "acceleration"), ("a length", "length", "displacement"))
"""What is no force but the motion of a base: noun, dimension, key."""


class Pulse(Transient, Directed):
    """`kind = "pulse"`: a force on a body, or an acceleration of a base, that comes once or a few times and is over.

    Keys
    ----
    shape: How it rises and falls: `shape = "half sine"`. A step begins at once and stays for ever.
    amplitude: Greatest force, on a body; of a decaying sine the factor before it, which its greatest force stays
        below. One of `amplitude`, `acceleration` and `displacement`.
    acceleration: The same of a base: `acceleration = "300 m/s²"`.
    displacement: The same of a base that moves and comes back: `displacement = "20 mm"`. Refused of rectangles and
        sawtooths, which would move it at once.
    duration: How long one pulse takes: `duration = "11 ms"`. One of `duration`, `duration_up_to` and, of a decaying
        sine, `frequency`; a step has none of them.
    duration_up_to: How long it may take, where nobody knows: a response is then the greatest over every duration up to
        this: `duration_up_to = "20 ms"`.
    duration_from: The shortest that it may take; any without it: `duration_from = "5 ms"`.
    frequency: Of a decaying sine: `frequency = "10 Hz"`.
    damping_ratio: Of a decaying sine, amplitude sin(w t) e^(-damping_ratio w t): `damping_ratio = 0.1`.
    times: How often it comes: `times = 3`.
    every: Time from one beginning to the next: `every = "0.5 s"`.
    """

    shape: Shape
    amplitude: Fact | None = number("force", choice=False)
    acceleration: Fact | None = number("acceleration", choice=False)
    displacement: Fact | None = number("length", choice=False)
    duration: Fact | None = number("time", choice=False)
    duration_up_to: Fact | None = number("time", choice=False)
    duration_from: Fact | None = number("time", choice=False)
    frequency: Fact | None = number("angular_rate", choice=False)
    damping_ratio: Fact | None = number("ratio", choice=False)
    times: int = 1
    every: Fact | None = number("time", choice=False)

    @field_validator("amplitude", mode="before")
    @classmethod
    def _no_motion(cls, given: Any) -> Any:
        """What a test says of its table, "15 g" or "5 mm", is no force."""
        for noun, dimension, key in _OF_BASES:
            if reads(given, dimension):
                raise complaint(f'is {noun}, which only a base has. Write {key} = "{given}".')
        return given

    @model_validator(mode="after")
    def _consistent(self) -> "Pulse":
        sizes = [one for one in ("amplitude", "acceleration", "displacement") if getattr(self, one) is not None]
        if len(sizes) > 1:
            raise word(f"gives {' and '.join(sizes)}. Keep one: it is a force on a body, or the motion of a base.")
        if not sizes:
            raise word(
                "needs one of amplitude, a force on a body, and acceleration or displacement of a base. Write "
                'amplitude = "2 kN".'
            )
        if self.displacement is not None and self.shape in _SUDDEN:
            raise word(
                f"is a {self.shape}, which would displace its base at once. Write another shape, or its acceleration."
            )
        fades = self.shape == "decaying sine"
        lasts = [self.duration, self.duration_up_to].count(None)
        if self.duration_from is not None and (
            self.duration_up_to is None or self.duration_from.value >= self.duration_up_to.value
        ):
            raise word('has a duration_from, which needs a longer duration_up_to. Write duration_up_to = "20 ms".')
        if self.holds:
            given = next((key for key in _LASTS if key in self.model_fields_set), "")
            if given:
                raise word(f'is a step, which stays for ever. Remove {given}, or write shape = "rectangle".')
            return self
        if fades and (self.frequency is None or self.damping_ratio is None or lasts < 2):
            raise word(
                "is a decaying sine, which has a frequency and a damping_ratio, and no duration. Write "
                'frequency = "10 Hz" and damping_ratio = 0.1.'
            )
        if not fades and lasts == 0:
            raise word("has a duration and duration_up_to. Keep one: is the duration known or not?")
        if not fades and (lasts == 2 or self.frequency is not None or self.damping_ratio is not None):
            raise word(f'is a {self.shape}, which has a duration alone. Write duration = "11 ms".')
        if not 1 <= self.times <= _MOST:
            raise word(f"comes {self.times} times. Write a whole number from 1 to {_MOST}.")
        if (self.times > 1) != (self.every is not None):
            raise word('needs times and every together. Write times = 3 and every = "0.5 s".')
        if self.every is not None and self.every.value < self.length:
            raise word("comes again before it is over. Write a longer every, or two excitations.")
        return self

    @property
    def length(self) -> float:
        """How long one pulse takes [s], at most."""
        given = self.duration or self.duration_up_to
        if given is not None or self.holds:
            return given.value if given is not None else AFTER
        assert self.frequency is not None
        assert self.damping_ratio is not None
        return _FADED / (self.frequency.value * self.damping_ratio.value)

    @property
    def holds(self) -> bool:
        return self.shape == "step"

    @property
    def endless(self) -> bool:
        return self.holds

    @property
    def durations(self) -> tuple[float, float] | None:
        if self.duration_up_to is None:
            return None
        return self.duration_from.value if self.duration_from is not None else 0.0, self.duration_up_to.value

    def lasting(self, duration: float) -> "Pulse":
        if self.duration_up_to is None:  # known, whatever another lasts
            return self
        given = Fact(duration, "s")
        return self.model_copy(update={"duration": given, "duration_up_to": None, "duration_from": None})

    @property
    def fastest(self) -> float:
        if self.holds:
            return 0.0
        return super().fastest if self.frequency is None else self.frequency.value

    @property
    def size(self) -> float:
        """Greatest force [N], acceleration [m/s^2] or displacement [m]; of a decaying sine the factor before it."""
        given = self.amplitude or self.acceleration or self.displacement
        assert given is not None
        return given.value

    @property
    def family(self) -> str:  # type: ignore[override]  # only the key tells force from motion
        """Where it acts: a force on bodies, an acceleration of bases."""
        return "bodies" if self.amplitude is not None else "bases"

    @property
    def returns(self) -> bool:
        return self.displacement is not None

    @property
    def blows(self) -> dict[float, float]:
        found: dict[float, float] = {}
        for begin in self._begins if self.displacement is not None else ():
            for part, jump in self._jumps.items():
                found[begin + part * self.length] = found.get(begin + part * self.length, 0.0) + self.size * jump
        return found

    @property
    def _jumps(self) -> dict[float, float]:
        """Jumps of the velocity of a displacement of one [1/s], by the part of its duration."""
        if self.frequency is not None:
            return {0.0: self.frequency.value}
        return {part: jump / self.length for part, jump in _MOVED[self.shape][1].items()}

    @property
    def _begins(self) -> list[float]:
        """When each of the pulses begins [s]."""
        return [count * self.every.value if self.every is not None else 0.0 for count in range(self.times)]

    @property
    def joints(self) -> tuple[float, ...]:
        parts = (0.0, 0.5, 1.0) if self.shape == "triangle" else (0.0,) if self.holds else (0.0, 1.0)
        return tuple(sorted({begin + part * self.length for begin in self._begins for part in parts}))

    def segments(self) -> tuple[Segment, ...]:
        if self.holds:
            return (lasting(self.size),)
        own = _PARTS[self.shape](self.length) if self.frequency is None else (self._fading,)
        rest = self.every.value - self.length if self.every is not None else 0.0
        quiet = (line(rest, 0.0, 0.0),) if rest > _ROUNDING * self.length else ()
        found = tuple(replace(one, start=self.size * one.start) for one in (*((*own, *quiet) * (self.times - 1)), *own))
        return moved(found) if self.displacement is not None else found

    @property
    def _fading(self) -> Segment:
        assert self.frequency is not None
        return sine(self.length, 1.0, 0.0, self.frequency.value * self.length, decay=_FADED)

    def signal(self, time: FloatArray) -> FloatArray:
        own = time
        if self.every is not None:  # no pulse begins before the one before it has ended
            own = time - self.every.value * np.clip(np.floor(time / self.every.value), 0.0, self.times - 1.0)
        inside = (own >= 0.0) & ((own <= self.length) | self.holds)
        total = np.zeros(time.shape)
        total[inside] = self._shape(own[inside])
        return self.size * total

    def _shape(self, time: FloatArray) -> FloatArray:
        moves = self.displacement is not None
        if self.frequency is None:
            values = _MOVED[self.shape][0] if moves else _VALUES[self.shape]
            return values(time / self.length) / (self.length**2 if moves else 1.0)
        assert self.damping_ratio is not None
        rate, decay = self.frequency.value, self.damping_ratio.value
        turned = rate * time
        wave = np.sin(turned)
        if moves:
            wave = rate**2 * ((decay**2 - 1.0) * wave - 2.0 * decay * np.cos(turned))
        return np.asarray(np.exp(-decay * turned) * wave)
