"""Responses against speed as series in the user's units: what a figure draws, before anything is drawn."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import isfinite, log10

import numpy as np

from vibopt.answer.blocks import SIDES, spoken, value_at
from vibopt.answer.entry import Checked
from vibopt.arrays import BoolArray, FloatArray
from vibopt.forms import Form
from vibopt.forms.drive_response import drive_extreme
from vibopt.forms.form import Against
from vibopt.mechanics.model import Model
from vibopt.mechanics.modes import natural_frequencies, poles
from vibopt.program.pose import form_of, pose
from vibopt.records import dataclass
from vibopt.report.absorber_curves import equal_peaks, form_without, model_without
from vibopt.report.friction_views import friction_panels
from vibopt.report.histories import histories
from vibopt.report.limiting_views import limiting_panels
from vibopt.report.series import Curve, Mark, Panel, Zone, heights
from vibopt.responses import HarmonicResponse, Response
from vibopt.scene.drives import bands_for, names_for
from vibopt.scene.places import place_of
from vibopt.scene.scene import MINIMISE, Design, Scene
from vibopt.scene.space import members
from vibopt.signals import Band, Drive
from vibopt.units import best_unit, show, to_unit
from vibopt.units.spelling import split_detector
from vibopt.verify.as_built import factors_of, machine_of

POINTS = 500
MOST_CURVES = 6
MOST_PAIRS = 2
"""Curves in one panel beside which the machine without absorbers is still drawn."""


@dataclass(frozen=True, slots=True)
class _Entry:
    """A limit or measure of one excitation, or the goal, which has no row in the answer."""

    name: str
    response: HarmonicResponse
    checked: Checked | None
    is_limit: bool


def panels(design: Design) -> list[Panel]:
    """Every harmonic limit and measure of an answer as curves, and the goal; none where there is no design.

    Limits that read the same response share a panel; measures of one kind share one without limits.  With
    absorbers, the machine without them is drawn beside.
    """
    scene = design.scene
    if len(design.x) != len(scene.variables):
        return []
    model, without = pose(scene).model, model_without(scene)
    if model.rubbing is not None:
        return friction_panels(design, model) + histories(design, model) + limiting_panels(design)
    if model.bearings:
        from vibopt.report.orbit_views import orbit_panels

        return orbit_panels(design, model) + histories(design, model)
    drawn = []
    for excitation, entries in _groups(design, model):
        panel = _Drawing(design, model, without, excitation, entries).panel()
        if panel is not None:
            drawn.append(panel)
    return drawn + histories(design, model) + limiting_panels(design)


def _drawable(scene: Scene, model: Model, response: Response) -> list[tuple[Form, Form, Response]]:
    """Per place that a response stands for its form, what of that is one over speeds, and what it is there."""
    asked = [(form := form_of(scene, model, each), form.swings or form, each) for each in members(scene, response)]
    return [one for one in asked if one[1].drives]


def _groups(design: Design, model: Model) -> list[tuple[str, list[_Entry]]]:
    """Entries that share one panel, limits first."""
    scene = design.scene
    entries = [
        _Entry(name, response, checked[name], is_limit)
        for responses, checked, is_limit in (
            (scene.limits, design.limits, True),
            (scene.measures, design.measures, False),
        )
        for name, response in responses.items()
        if isinstance(response, HarmonicResponse) and name in checked
    ]
    limited = {_same(scene, one) for one in entries if one.is_limit}
    entries += [one for one in _aimed(design) if _same(scene, one) not in {_same(scene, other) for other in entries}]
    groups: dict[tuple[object, ...], list[_Entry]] = {}
    for one in (each for each in entries if _drawable(scene, model, each.response)):
        alike = _same(scene, one)
        for excitation in names_for(scene, one.response):
            key = (excitation, *alike) if alike in limited else (excitation, _quantity(one.response), "measures")
            groups.setdefault(key, []).append(one)
    return [(str(key[0]), group) for key, group in groups.items()]


def _aimed(design: Design) -> list[_Entry]:
    """The goal, where it is a response against speed."""
    goal = design.scene.goal
    if goal is None or design.goal is None or not isinstance(goal.response, HarmonicResponse):
        return []
    return [_Entry("goal", goal.response, None, False)]


def _quantity(response: HarmonicResponse) -> str:
    """Isolation is drawn as the transmissibility that it belongs to."""
    return "transmissibility" if response.complement else response.response


def _same(scene: Scene, entry: _Entry) -> tuple[object, ...]:
    """What tells curves apart; with several excitations each limit is its own, for the others stand at its worst."""
    names = names_for(scene, entry.response)
    alone = entry.name if len(names) > 1 else ""
    return _quantity(entry.response), place_of(entry.response), names, entry.response.combine, alone


@dataclass(frozen=True, slots=True)
class _Speeds:
    """Speeds to draw [rad/s]: from where to where, on which axis, and those of marks, which lie on the curve."""

    span: tuple[float, float]
    log: bool
    marked: tuple[float, ...]


@dataclass(frozen=True)
class _Drawing:
    """One panel in the making."""

    design: Design
    model: Model
    without: Model | None
    excitation: str
    entries: list[_Entry]

    @property
    def scene(self) -> Scene:
        return self.design.scene

    @property
    def x(self) -> FloatArray:
        return np.array(self.design.x, dtype=float)

    def panel(self) -> Panel | None:
        alike: dict[tuple[object, ...], list[_Entry]] = {}
        for one in self.entries:
            alike.setdefault(_same(self.scene, one), []).append(one)
        groups = list(alike.values())[:MOST_CURVES]
        shown = [one for group in groups for one in group]
        span, log_x = self._speeds(shown)
        unit = self._unit(shown)
        marks = tuple(mark for one in shown if (mark := self._mark(one, unit)) is not None)
        speeds = _Speeds(span, log_x, tuple(one.x / self._factor() for one in marks))
        without = [self._before(group[0], unit, speeds, len(groups)) for group in groups]
        before = [curve for curve in without if curve is not None]
        worst = self._worst(groups, unit, speeds)
        how = "with absorbers" if before else "as designed" if worst else ""
        after = [self._curve(group[0], unit, speeds, len(groups) > 1, how) for group in groups]
        curves = (*after, *worst, *before)
        zones = tuple(zone for one in shown if one.is_limit for zone in self._zones(one, unit))
        y_span, log_y = heights(curves, zones, marks, unit)
        shown_span = (self._to_x(span[0]), self._to_x(span[1]))
        return Panel(
            title=self._title(groups),
            x_label=self._x_label(),
            y_label=self._y_label(groups, unit),
            curves=curves,
            zones=zones,
            marks=marks,
            own=self._own(),
            excitation=self.excitation,
            log_x=log_x,
            log_y=log_y,
            x_span=shown_span,
            y_span=y_span,
            good=self._good(),
            notes=self._notes(shown, curves),
            equal=tuple(mark for group in groups for mark in self._equal(group[0], unit)),
        )

    def _title(self, groups: list[list[_Entry]]) -> str:
        response = groups[0][0].response
        quantity = spoken(_quantity(response))
        words = f"{quantity} {place_of(response)}" if len(groups) == 1 else quantity
        if len(names_for(self.scene, response)) > 1:
            words += f", against {self.excitation}"
        return words[:1].upper() + words[1:]

    def _x_label(self) -> str:
        """Vehicle speed, frequency or speed of rotation, in the user's unit."""
        excitation = self.scene.excitations[self.excitation]
        unit = excitation.speed.unit
        if excitation.of_vehicle:
            return f"vehicle speed [{unit}]"
        return f"{'frequency' if unit in ('Hz', 'kHz') else 'speed'} of {self.excitation} [{unit}]"

    def _y_label(self, groups: list[list[_Entry]], unit: str) -> str:
        response = groups[0][0].response
        bare, _, word = split_detector(unit)
        word = word or ("pk" if response.amplitude else "")
        brackets = " ".join(filter(None, (bare, word)))
        return spoken(_quantity(response)) + (f" [{brackets}]" if brackets else "")

    def _notes(self, shown: list[_Entry], curves: tuple[Curve, ...]) -> tuple[str, ...]:
        notes = []
        if any(entry.response.complement for entry in shown):
            notes.append("isolation = 1 - transmissibility")
        if any(not curve.known.all() for curve in curves):
            notes.append("dashed: as if the excitation kept its amplitude")
        if any(len(names_for(self.scene, entry.response)) > 1 for entry in shown):
            notes.append("the other excitations at their worst speeds")
        return tuple(notes)

    def _to_x(self, omega: float) -> float:
        """A speed of the excitation [rad/s] in the user's unit."""
        return float(self._factor() * omega)

    def _factor(self) -> float:
        """User's units of speed per rad/s; all of them are proportional."""
        excitation = self.scene.excitations[self.excitation]
        return to_unit(excitation.from_rotation(1.0), excitation.speed.unit, excitation.speed.dimension)

    def _own(self) -> tuple[tuple[float, float], ...]:
        excitation = self.scene.excitations[self.excitation]
        if excitation.speed.asked:
            return ()
        return tuple((self._to_x(band.low), self._to_x(band.high)) for band in excitation.own_bands())

    def _good(self) -> tuple[tuple[float, float], ...]:
        if self.design.found is None or self.scene.find_all != f"{self.excitation}.speed":
            return ()
        speed = self.scene.excitations[self.excitation].speed
        return tuple(
            (to_unit(low.value, speed.unit, speed.dimension), to_unit(high.value, speed.unit, speed.dimension))
            for low, high in self.design.found
        )

    def _bands(self, entry: _Entry) -> tuple[Band, ...]:
        return bands_for(self.scene, entry.response, self.excitation)

    def _resonances(self) -> FloatArray:
        """Speeds at which a harmonic of the excitation meets a natural frequency [rad/s]."""
        modes = natural_frequencies(self.model, self.model.values(self.x))
        orders = [line.order for line in self.scene.excitations[self.excitation].lines(np.ones(1))]
        speeds: FloatArray = np.concatenate([modes / order for order in orders])
        return speeds[np.isfinite(speeds) & (speeds > 0.0)]

    def _speeds(self, shown: list[_Entry]) -> tuple[tuple[float, float], bool]:
        """First and last speed to draw [rad/s], and whether on a logarithmic axis."""
        excitation = self.scene.excitations[self.excitation]
        own = () if excitation.speed.asked else excitation.own_bands()
        bands = [*own, *(band for entry in shown for band in self._bands(entry))]
        top = max(band.high for band in bands)
        resonances = self._resonances()
        near = resonances[resonances < 3.0 * top] if top else np.sort(resonances)[:1]
        high = max(1.08 * top, 1.3 * float(near.max(initial=0.0))) or 1.0  # what stands still is drawn, too
        marks = [*near[near > 1e-4 * top], *(band.low for band in bands if band.low > 0.0)]
        low = min([*marks, high])
        if low < high / 12.0:
            return (10.0 ** (np.floor(3.0 * log10(low / 3.0)) / 3.0), high), True
        return (0.0 if self.without is None else 0.7 * low, high), False

    def _unit(self, shown: list[_Entry]) -> str:
        """Unit of the y axis: of the first bound, else of the first measure, else by size."""
        for one in shown:
            if one.response.complement:
                continue
            bound = one.response.at_most or one.response.at_least
            if one.response.unit or (bound is not None and bound.unit):
                return str(one.response.unit or bound.unit)
        response = shown[0].response
        if response.complement:
            return ""
        values = [one.checked.value.value for one in shown if one.checked is not None]
        if not values and self.design.goal is not None:
            values = [self.design.goal[1].value]
        return best_unit(max((value for value in values if isfinite(value)), default=0.0), response.dimension)

    def _curve(self, entry: _Entry, unit: str, speeds: _Speeds, labelled: bool, how: str) -> Curve:
        form, drive = self._form(entry)
        combined = f"({entry.response.combine})" if entry.response.combine else ""
        label = (place_of(entry.response), combined) if labelled else ()
        said = " ".join(filter(None, (how, *label)))
        return self._drawn(entry, unit, self.model, form, self._samples(self.model, drive, speeds), said)

    def _off(self, entry: _Entry) -> Mapping[str, float]:
        """By how much numbers are off where an entry is worst; empty without tolerances."""
        if entry.checked is not None:
            return entry.checked.off
        return self.design.tolerances.goal_off if self.design.tolerances is not None else {}

    def _at(self, off: Mapping[str, float]) -> _Drawing:
        """The same panel of the machine that is off so far."""
        if not off:
            return self
        scene = replace(self.scene, off=factors_of(self.scene, off))
        return replace(self, design=replace(self.design, job=scene), model=pose(scene).model)

    def _worst(self, groups: list[list[_Entry]], unit: str, speeds: _Speeds) -> list[Curve]:
        """Of every limit the worst machine within the tolerances; each machine once."""
        machines = {
            (k, *sorted(self._off(one).items())): (one, self._off(one))
            for k, group in enumerate(groups)
            for one in group
            if self._off(one)
        }
        found = []
        for one, off in machines.values():
            name = f" for {one.name}" if len(machines) > 1 else ""
            said = f"worst machine within the tolerances{name}"
            found.append(replace(self._at(off)._curve(one, unit, speeds, False, said), worst=True))
        return found

    def _before(self, entry: _Entry, unit: str, speeds: _Speeds, pairs: int) -> Curve | None:
        """The same response without absorbers, with its worst in words."""
        without = self.without
        if without is None or pairs > MOST_PAIRS:
            return None
        asked = [form_without(self.scene, without, each) for each in members(self.scene, entry.response)]
        form = max(filter(None, asked), key=lambda one: one.value(without, self.x), default=None)
        drive = next((drive for drive in form.drives if drive.name == self.excitation), None) if form else None
        if form is None or drive is None:
            return None
        worst = drive_extreme(without, form, drive, self.x, False)
        value = float(self._against(without, form).whole(np.array(worst.value)))
        place = f" {place_of(entry.response)}" if pairs > 1 else ""
        words = f"without absorbers{place}: worst {self._words(entry, value, worst.speed)}"
        samples = self._samples(without, drive, speeds)
        return replace(self._drawn(entry, unit, without, form, samples, words), before=True)

    def _words(self, entry: _Entry, value: float, speed: float) -> str:
        """A value and its speed, each in the user's unit."""
        excitation = self.scene.excitations[self.excitation]
        bound = entry.response.at_most or entry.response.at_least
        unit = entry.response.unit or (bound.unit if bound is not None else "") or ""
        shown = show(value, unit, entry.response.dimension, amplitude=entry.response.amplitude)
        at = show(excitation.from_rotation(speed), excitation.speed.unit, excitation.speed.dimension)
        return f"{shown} at {at}"

    def _beside(self, entry: _Entry) -> float:
        """What adds to it at every speed."""
        if type(entry.response).beside is HarmonicResponse.beside:
            return 0.0
        chosen = self.scene.named(self.design.x)
        _, member = self._member(entry)
        return member.beside(machine_of(self.scene, chosen)) if isinstance(member, HarmonicResponse) else 0.0

    def _member(self, entry: _Entry) -> tuple[Form, Response]:
        """Of the places that a response stands for the one where it is greatest: over speeds, and what it is there."""
        asked = _drawable(self.scene, self.model, entry.response)
        return (max(asked, key=lambda one: one[0].value(self.model, self.x)) if len(asked) > 1 else asked[0])[1:]

    def _form(self, entry: _Entry) -> tuple[Form, Drive]:
        form, _ = self._member(entry)
        return form, next(drive for drive in form.drives if drive.name == self.excitation)

    def _against(self, model: Model, form: Form) -> Against:
        return form.against(model, self.x, self.excitation, least_wanted=False)

    def _drawn(self, entry: _Entry, unit: str, model: Model, form: Form, speeds: FloatArray, label: str) -> Curve:
        """A response of some model at given speeds, the other excitations at their worst."""
        values = self._against(model, form)(speeds) + self._beside(entry)
        known = np.ones(speeds.shape, dtype=bool)
        if not entry.response.normalised:
            bands = self.scene.excitations[self.excitation].known_bands
            known = np.any([_inside(band, speeds) for band in bands], axis=0)
        return Curve(label, self._factor() * speeds, _in_unit(values, unit, entry.response.dimension), known)

    def _equal(self, entry: _Entry, unit: str) -> list[Mark]:
        """Peaks that are as high as the greatest, of a machine with absorbers."""
        if not self.scene.absorbers or entry.response.complement:
            return []
        form, drive = self._form(entry)
        if form.harmonic is None:
            return []
        against, marks = self._against(self.model, form), []
        for peak in equal_peaks(self.model, form.harmonic, drive, self.x):
            value = float(against.whole(np.array(peak.value)))
            height = float(_in_unit(np.array([value]), unit, entry.response.dimension)[0])
            marks.append(Mark(entry.name, self._words(entry, value, peak.speed), self._to_x(peak.speed), height))
        return marks

    def _samples(self, model: Model, drive: Drive, speeds: _Speeds) -> FloatArray:
        """Speeds to draw, closer around resonances [rad/s]."""
        low, high = speeds.span
        even = np.geomspace(low, high, POINTS) if speeds.log else np.linspace(low, high, POINTS)
        singular = poles(model, model.values(self.x))
        near = np.concatenate([[0.0], np.geomspace(1e-4, 0.3, 40)])
        about = np.abs(np.concatenate([singular.real / line.order for line in drive.lines]))
        close = np.outer(about, np.concatenate([1.0 - near, 1.0 + near])).ravel()
        edges = [end for band in drive.bands for end in (band.low, band.high)]
        breaks = [speed * (1.0 + d) for line in drive.lines for speed in line.amplitude.breaks() for d in (-1e-9, 1e-9)]
        found = np.unique(np.concatenate([even, close, edges, breaks, speeds.marked]))
        return found[(found >= low) & (found <= high)]

    def _zones(self, entry: _Entry, unit: str) -> list[Zone]:
        zones = []
        for side in ("at_most", "at_least"):
            bound = getattr(entry.response, side)
            if bound is None:
                continue
            value = 1.0 - bound.value if entry.response.complement else bound.value
            shown = show(bound.value, bound.unit, entry.response.dimension, amplitude=entry.response.amplitude)
            isolation = "isolation " if entry.response.complement else ""
            words = f"{entry.name}: {isolation}{SIDES[side]} {shown}"
            above = (side == "at_most") != entry.response.complement
            height = float(_in_unit(np.array([value]), unit, entry.response.dimension)[0])
            zones += [
                Zone(entry.name, words, self._to_x(band.low), self._to_x(band.high), height, above)
                for band in self._bands(entry)
            ]
        return zones

    def _mark(self, entry: _Entry, unit: str) -> Mark | None:
        if entry.checked is None:
            return self._goal_mark(entry, unit)
        if self.excitation not in entry.checked.worst_at:
            return None
        speed = self.scene.excitations[self.excitation].speed
        x = to_unit(entry.checked.worst_at[self.excitation].value, speed.unit, speed.dimension)
        value = entry.checked.value.value
        y = 1.0 - value if entry.response.complement else value
        height = float(_in_unit(np.array([y]), unit, entry.response.dimension)[0])
        return Mark(entry.name, f"{entry.name} {value_at(entry.checked)}", x, height)

    def _goal_mark(self, entry: _Entry, unit: str) -> Mark | None:
        """The worst that the goal speaks of."""
        here = self._at(self._off(entry))
        form, _ = here._form(entry)
        least_wanted = self.scene.goal is not None and self.scene.goal.sense != MINIMISE
        worst = form.worst(here.model, self.x, least_wanted=least_wanted)
        speed = worst.speeds[self.excitation]
        value = worst.value if len(form.drives) == 1 else float(self._against(here.model, form)(np.array([speed]))[0])
        height = float(_in_unit(np.array([value]), unit, entry.response.dimension)[0])
        words = f"goal {self._words(entry, value, speed)}"
        return Mark("goal", words, self._to_x(speed), height) if not entry.response.complement else None


def _inside(band: Band, speeds: FloatArray) -> BoolArray:
    room = 1e-9 * max(band.high, 1e-300) if isfinite(band.high) else 0.0
    inside: BoolArray = (speeds >= band.low - room) & (speeds <= band.high + room)
    return inside


def _in_unit(values: FloatArray, unit: str, dimension: str) -> FloatArray:
    """SI values (peak) in a unit of the user's."""
    if split_detector(unit)[0] == "dB":
        with np.errstate(divide="ignore"):
            level: FloatArray = 20.0 * np.log10(values)
        return level
    return values * to_unit(1.0, unit, dimension)
