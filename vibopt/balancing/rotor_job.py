"""A measured rotor as its file says it: planes, sensors, runs, limits and goal, in SI and the internal sense."""

from __future__ import annotations

from collections.abc import Container, Mapping
from dataclasses import field
from itertools import product
from math import inf
from typing import Any, ClassVar

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray, IntArray
from vibopt.balancing.conventions import Conventions
from vibopt.balancing.grades import Quality
from vibopt.balancing.planes import Corrected, Plane
from vibopt.balancing.written import Written
from vibopt.records import cached_property, dataclass, replace
from vibopt.units import Detector, show
from vibopt.units.showing import show_angle

AS_ASKED = 1e-9
"""Part of the greatest unbalance by which those of a pair may differ."""


@dataclass(frozen=True, slots=True)
class Sensor:
    """A vibration pickup; `dimension` of what it reads, `unit` and `detector` as the user writes its readings.

    `runout` is the internal phasor [SI peak] that is there without any unbalance; `importance` multiplies the
    amplitude in the goal.  Its amplitude is added to that of the sensor `added_to`, "" of none.
    """

    name: str
    dimension: str = "length"
    unit: str = "mm"
    detector: Detector = "pk"
    runout: complex = 0.0
    importance: float = 1.0
    added_to: str = ""

    @property
    def shown_unit(self) -> str:
        return f"{self.unit} {self.detector}"

    def show(self, amplitude: float, digits: int = 4) -> str:
        """A peak amplitude [SI] as the user writes it."""
        return show(amplitude, self.shown_unit, self.dimension, digits=digits)

    def show_phasor(self, y: complex, conventions: Conventions) -> str:
        """An internal reading as the user writes it, "8.6 mil pp @ 63 deg"."""
        amount = self.show(abs(y))
        return f"{amount} @ {show_angle(conventions.reading_angle(y))}" if conventions.readings else amount


@dataclass(frozen=True, eq=False)
class Run:
    """One measurement of the whole rotor.

    name
        As in the file, or its number.
    speed
        Index into the speeds of the job.
    given_speed
        As written [rad/s].
    weights
        Everything fitted during this run (n_planes,), internal [kg m].
    is_initial
        Whether nothing is fitted.
    readings
        Per sensor (n_sensors,), internal, runout not yet subtracted; without phase real and positive.
    fitted
        The weights of this run as written: (plane index, text).
    written
        Readings as they stand in the file; None where they have no angles.
    stayed
        Whether the weights of the run before are on as well.
    verification
        Whether its weights are the correction, which stays on the rotor.
    """

    name: str
    speed: int
    given_speed: float
    weights: ComplexArray
    is_initial: bool
    readings: ComplexArray
    fitted: tuple[tuple[int, str], ...] = ()
    written: Written | None = None
    stayed: bool = False
    verification: bool = False


@dataclass(frozen=True, slots=True)
class Scatter:
    """Standard deviation of a reading: `ratio` of its amplitude, or `amplitude` [SI peak], and `angle` [rad]."""

    ratio: float = 0.0
    amplitude: float = 0.0
    angle: float = 0.0


@dataclass(frozen=True, slots=True)
class ResidualLimit:
    """Greatest amplitude left [SI peak] at a sensor and a speed by index, None: at every one.

    `share` of all rotors that the scatter of the readings leaves possible shall keep it; None: the prediction.
    """

    name: str
    sensor: int | None
    speed: int | None
    at_most: float
    unit: str
    soft: float | None = None
    share: float | None = None


@dataclass(frozen=True, slots=True)
class CorrectionLimit:
    """Greatest correction of a plane (index; None: of all together) [kg, kg m for planes in unbalance]."""

    name: str
    plane: int | None
    at_most: float
    unit: str


@dataclass(frozen=True, slots=True)
class RotorGoal:
    """`goal` as in `Question`; `robust` is "worst", "mean" or "" (as the readings say); `huber` in SI peak."""

    goal: str = "rms"
    robust: str = ""
    huber: float = inf


@dataclass(frozen=True)
class RotorJob(Corrected):
    """A balancing job from a measured rotor.

    speeds
        Of the groups of runs [rad/s]; `speed_units` as first written.
    influence
        Ready coefficients by (speed, sensor, plane), internal [SI peak per kg m].
    pairs
        (name, plane, plane, ratio of the unbalances).
    has_phase
        Whether the readings have angles.
    odd
        Runs that are left out because the others contradict them, by index.
    results
        What the paths of that begin which the answer measures.
    """

    kind: ClassVar[str] = "rotor"
    name: str
    title: str
    conventions: Conventions
    planes: tuple[Plane, ...] = ()
    sensors: tuple[Sensor, ...] = ()
    runs: tuple[Run, ...] = ()
    speeds: tuple[float, ...] = ()
    speed_units: tuple[str, ...] = ()
    influence: Mapping[tuple[int, int, int], complex] = field(default_factory=dict)
    scatter: Scatter | None = None
    residual_limits: tuple[ResidualLimit, ...] = ()
    correction_limits: tuple[CorrectionLimit, ...] = ()
    goal: RotorGoal = RotorGoal()
    pairs: tuple[tuple[str, int, int, float], ...] = ()
    rotor_mass: float | None = None
    trial_force: float = 0.1
    quality: Quality | None = None
    has_phase: bool = True
    expected: tuple[Mapping[str, Any], ...] = ()
    notes: tuple[str, ...] = ()
    document: Mapping[str, Any] = field(default_factory=dict)
    odd: tuple[int, ...] = ()
    results: ClassVar[tuple[str, ...]] = ("sensors.",)

    @property
    def aim(self) -> str:
        """What is made least; "" where there is nothing to fit."""
        return ("correction" if self.goal.goal == "correction" else "residual") if self.runs else ""

    @cached_property
    def choices(self) -> tuple[str, ...]:
        """The same, none of a grade alone."""
        return super().choices if self.runs else ()

    @property
    def every_limit(self) -> tuple[ResidualLimit | CorrectionLimit, ...]:
        """On what is left, then on what is fitted."""
        return (*self.residual_limits, *self.correction_limits)

    @property
    def asks_shares(self) -> tuple[str, ...]:
        """Limits with a probability."""
        return tuple(limit.name for limit in self.residual_limits if limit.share is not None)

    def limited_to(self, kept: Container[str]) -> RotorJob:
        """The same with only these limits, by name."""
        residual = tuple(limit for limit in self.residual_limits if limit.name in kept)
        correction = tuple(limit for limit in self.correction_limits if limit.name in kept)
        return replace(self, residual_limits=residual, correction_limits=correction)

    @property
    def total_cap(self) -> float:
        """Greatest correction of all planes together [kg]; inf without one."""
        return min((limit.at_most for limit in self.correction_limits if limit.plane is None), default=inf)

    @cached_property
    def added(self) -> tuple[int, ...]:
        """Per sensor the one with which it is limited: the one that it is added to, or itself."""
        places = {sensor.name: k for k, sensor in enumerate(self.sensors)}
        return tuple(places[sensor.added_to or sensor.name] for sensor in self.sensors)

    @cached_property
    def sums(self) -> IntArray:
        """Per row a number, that of the rows to which it is added (n_rows,); empty where nothing is added up."""
        if self.added == tuple(range(len(self.sensors))):
            return np.empty(0, dtype=np.int64)
        many = len(self.sensors)
        return np.concatenate([k * many + np.array(self.added, dtype=np.int64) for k in range(len(self.speeds))])

    @property
    def n_rows(self) -> int:
        """Readings of all sensors at all speeds."""
        return len(self.speeds) * len(self.sensors)

    @cached_property
    def readings(self) -> tuple[tuple[int, int], ...]:
        """(speed, sensor) of each row of the problem."""
        return tuple(product(range(len(self.speeds)), range(len(self.sensors))))

    @cached_property
    def free(self) -> tuple[int, ...]:
        """Planes that may be changed."""
        return tuple(index for index, plane in enumerate(self.planes) if not plane.keep)

    @cached_property
    def runout(self) -> ComplexArray:
        """Per sensor [SI peak]."""
        return np.array([sensor.runout for sensor in self.sensors], dtype=complex)

    @property
    def is_advice(self) -> bool:
        """Whether nothing but runs as found is there yet, and a first trial weight is asked for."""
        return self.rotor_mass is not None and not self.influence and all(run.is_initial for run in self.runs)

    @cached_property
    def importance(self) -> FloatArray:
        """Per row."""
        return np.array([sensor.importance for sensor in self.sensors] * len(self.speeds))

    def beyond(self, decided: Corrected) -> list[str]:
        """The same, and pairs whose two unbalances are not what is asked."""
        u = [plane.made(plane.fitted or (), self.conventions) for plane in decided.planes]
        size = max(map(abs, u), default=0.0)
        apart = [name for name, one, other, ratio in self.pairs if abs(u[other] - ratio * u[one]) > AS_ASKED * size]
        return [*super().beyond(decided), *(f"pairs.{name}" for name in apart)]

    def row_name(self, row: int) -> str:
        """A row in words, with what is added to it: "a at 1200 rpm"."""
        speed, sensor = self.readings[row]
        return f"{self.sensor_name(sensor)} at {self.show_speed(speed)}"

    def sensor_name(self, sensor: int) -> str:
        """A sensor with those that are added to it: "a", "a + b"."""
        return " + ".join(self.sensors[k].name for k, first in enumerate(self.added) if first == self.added[sensor])

    def show_speed(self, index: int) -> str:
        return show(self.speeds[index], self.speed_units[index], "angular_rate")

    @cached_property
    def places(self) -> tuple[tuple[int, ...], ...]:
        """Per speed the indices of the runs that are not left out."""
        found: list[list[int]] = [[] for _ in self.speeds]
        for index, run in enumerate(self.runs):
            if index not in self.odd:
                found[run.speed].append(index)
        return tuple(map(tuple, found))

    @cached_property
    def weights(self) -> ComplexArray:
        """Everything fitted in each run (n_runs, n_planes) [kg m]."""
        return np.array([run.weights for run in self.runs])

    @cached_property
    def measured(self) -> ComplexArray:
        """Readings of each run, runout subtracted (n_runs, n_sensors) [SI peak]."""
        return np.array([run.readings for run in self.runs]) - self.runout

    def runs_at(self, speed: int) -> tuple[Run, ...]:
        """The runs at a speed that are not left out."""
        return tuple(map(self.runs.__getitem__, self.places[speed]))

    @cached_property
    def as_found(self) -> ComplexArray:
        """What was read as found per row, runout subtracted, the mean where it was read more than once [SI peak].

        A run that is left out counts only where there is no other.
        """
        found = []
        for speed, places in enumerate(self.places):
            kept = [place for place in places if self.runs[place].is_initial]
            own = kept or [k for k, run in enumerate(self.runs) if run.speed == speed and run.is_initial]
            found.append(self.measured[own[0]] if len(own) == 1 else self.measured[own].mean(axis=0))
        return np.concatenate(found)
