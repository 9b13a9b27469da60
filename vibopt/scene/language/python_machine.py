"""A machine said in Python, and the scenes that ask something of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Unpack

from vibopt.devices import FAMILIES
from vibopt.document.mistakes import name_fault
from vibopt.errors import InputError, way_out
from vibopt.scene.language.limit import Bound, Limit, Measure, Speeds, plain_table
from vibopt.scene.language.python_words import (
    AbsorberWords,
    Acting,
    BaseMotionWords,
    BearingWords,
    BodyWords,
    Directed,
    DropWords,
    ForceWords,
    InerterWords,
    LinkWords,
    MomentWords,
    MountWords,
    PulseWords,
    RecordWords,
    ReleaseWords,
    RoadWords,
    RotorWords,
    StructureWords,
    UnbalanceWords,
)
from vibopt.scene.language.responses import Responses
from vibopt.scene.read import from_dict
from vibopt.scene.scene import Scene


class Machine(Responses):
    """Bodies, links and what shakes them: the tables of a problem file, one call each.

    Parameters
    ----------
    title
        What stands above every report.
    statement, source
        The problem in words, and where it is from.

    Notes
    -----
    Calls only collect words; `scene` checks them all, exactly as for a file.

    >>> machine = Machine("Pump on its mount")
    >>> machine.body("pump", mass="120 kg")
    >>> machine.link("mount", between=("pump", "ground"), stiffness="200 kN/m")
    >>> machine.scene(measures=[machine.static_deflection(of="mount")]).title
    'Pump on its mount'
    """

    def __init__(self, title: str, *, statement: str | None = None, source: str | None = None) -> None:
        self._facts = plain_table({"title": title, "statement": statement, "source": source})
        self._families: dict[str, dict[str, object]] = {}

    def body(self, name: str, **words: Unpack[BodyWords]) -> None:
        """A rigid body.  Words: mass or weight; inertia or disc where it turns; geared_to; rolling."""
        self._add("bodies", name, words)

    def base(self, name: str) -> None:
        """A support that moves in a prescribed way."""
        self._add("bases", name, {})

    def link(self, name: str, *, between: Sequence[str] | Mapping[str, object], **words: Unpack[LinkWords]) -> None:
        """Springs and dampers, alike and in parallel, `between` two points, or the best `one_of` pairs of points.

        Words: stiffness (or beam) and one of damping, damping_ratio (with relative_to), loss_factor;
        friction_force; count; dynamic_to_static; between bodies that turn torsional_stiffness (or shaft) and
        torsional_damping.
        """
        self._add("links", name, dict(between=between, **words))

    def bearing(self, name: str, *, between: Sequence[str], **words: Unpack[BearingWords]) -> None:
        """What holds a rotor, other along y than z.  Words: k_yy, k_zz, c_yy, c_zz, k_yz and so on; or a table."""
        self._add("bearings", name, dict(between=between, **words))

    def inerter(
        self, name: str, *, between: Sequence[str] | Mapping[str, object], **words: Unpack[InerterWords]
    ) -> None:
        """A force proportional to the relative acceleration of two points, or of the best `one_of` pairs of points.

        Words: inertance, or mass_ratio (with relative_to); about an axis torsional_inertance; in space at, direction.
        """
        self._add("inerters", name, dict(between=between, **words))

    def point(self, name: str, *, on: str, at: Sequence[Bound]) -> None:
        """A place on a body in space, to be asked about and acted on."""
        self._add("points", name, {"on": on, "at": at})

    def mount(
        self,
        name: str,
        *,
        between: Sequence[str],
        at: Sequence[object] | Mapping[str, object],
        **words: Unpack[MountWords],
    ) -> None:
        """Identical mounts `between` two bodies or a body and a support, `at` a place, a list of them, or one_of sets.

        A coordinate of a place may be `choose("0.6 m", "1 m")`, and so may the x, y and z of `shift`, which moves all.

        Words: stiffness and shear_ratio; damping or loss_factor; direction, across; dynamic_to_static, rating, gap.
        """
        self._add("mounts", name, dict(between=between, at=at, **words))

    def structure(self, name: str, **words: Unpack[StructureWords]) -> None:
        """A structure with named points, which act as bodies do.

        Words: modes; or mass, stiffness and damping (or file), points, loss_factor.  Files are seen from the folder
        in which Python runs.
        """
        self._add("structures", name, words)

    def rotor(self, name: str, **words: Unpack[RotorWords]) -> None:
        """A shaft that spins, with discs and stations, which act as bodies do; an unbalance drives its whirl.

        Words: sections (or matrices), discs, stations; modulus, density, poisson_ratio, shear_modulus,
        shear_coefficient.
        """
        self._add("rotors", name, words)

    def absorber(self, name: str, *, on: str | Mapping[str, object], **words: Unpack[AbsorberWords]) -> None:
        """A small mass on a spring and a damper, `on` a body, an absorber, or the best `one_of("a", "b")`.

        Words: mass, mass_ratio; stiffness, frequency, tuning, length; damping, damping_ratio, loss_factor; those about
        an axis; in space at and direction.
        """
        self._add("absorbers", name, dict(on=on, **words))

    def force(self, name: str, *, on: str, amplitude: Bound, speed: Speeds, **words: Unpack[ForceWords]) -> None:
        """A harmonic force on a body, peak [N].  Words: varies, amplitude_at, run_up, begins, at, direction."""
        self._add("excitations", name, dict(kind="force", on=on, amplitude=amplitude, speed=speed, **words))

    def moment(self, name: str, *, on: str, amplitude: Bound, speed: Speeds, **words: Unpack[MomentWords]) -> None:
        """A harmonic moment on a body that turns, peak [N m].  Words: varies, amplitude_at; in space axis."""
        self._add("excitations", name, dict(kind="moment", on=on, amplitude=amplitude, speed=speed, **words))

    def unbalance(self, name: str, *, on: str, speed: Speeds, **words: Unpack[UnbalanceWords]) -> None:
        """A rotating unbalance on a body or rotor.  Words: unbalance, or rotating_mass and radius, or grade; run_up."""
        self._add("excitations", name, dict(kind="unbalance", on=on, speed=speed, **words))

    def harmonics(
        self, name: str, *, on: str, speed: Speeds, harmonics: Sequence[Mapping[str, object]], **words: Unpack[Acting]
    ) -> None:
        """Several orders of one speed on a body: tables of order, amplitude (peak [N]) and phase.

        Words: varies, amplitude_at.
        """
        self._add("excitations", name, dict(kind="harmonics", on=on, speed=speed, harmonics=harmonics, **words))

    def moment_harmonics(
        self,
        name: str,
        *,
        on: str,
        speed: Speeds,
        harmonics: Sequence[Mapping[str, object]],
        **words: Unpack[MomentWords],
    ) -> None:
        """Several orders of a moment on a body in space: tables of order, amplitude (peak [N m]) and phase.

        Words: axis, varies, amplitude_at.
        """
        self._add("excitations", name, dict(kind="moment_harmonics", on=on, speed=speed, harmonics=harmonics, **words))

    def base_motion(self, name: str, *, on: str, speed: Speeds, **words: Unpack[BaseMotionWords]) -> None:
        """Motion of a base, peak.  Words: displacement, velocity, acceleration; amplitude_at, varies, begins."""
        self._add("excitations", name, dict(kind="base_motion", on=on, speed=speed, **words))

    def road(self, name: str, *, on: str, amplitude: Bound, speed: Speeds, **words: Unpack[RoadWords]) -> None:
        """A wavy road under a base, amplitude peak [m], at a speed of the vehicle.  Words: wavelength or wavenumber."""
        self._add("excitations", name, dict(kind="road", on=on, amplitude=amplitude, speed=speed, **words))

    def white_noise(self, name: str, *, on: str, density: Bound, **words: Unpack[Directed]) -> None:
        """White noise: a force on a body ("100 N²/Hz") or the acceleration of a base, one-sided density per Hz."""
        self._add("excitations", name, dict(kind="white_noise", on=on, density=density, **words))

    def pulse(self, name: str, *, on: str, shape: str, **words: Unpack[PulseWords]) -> None:
        """A pulse of force on a body or of motion of a base.  Words: amplitude, acceleration or displacement; duration,
        or duration_up_to and duration_from where it is unknown, or frequency and damping_ratio of a decaying sine;
        times, every; in space direction and, on a body, at.
        """
        self._add("excitations", name, dict(kind="pulse", on=on, shape=shape, **words))

    def drop(self, name: str, *, on: str, **words: Unpack[DropWords]) -> None:
        """The velocity of a base changes at once.  Words: height and rebound, or velocity_change."""
        self._add("excitations", name, dict(kind="drop", on=on, **words))

    def release(self, name: str, *, on: str, **words: Unpack[ReleaseWords]) -> None:
        """A body is let go.  Words: displacement and velocity, with their signs; one of them or both."""
        self._add("excitations", name, dict(kind="release", on=on, **words))

    def record(self, name: str, *, on: str, file: str, **words: Unpack[RecordWords]) -> None:
        """A record of force on a body or of acceleration of a base, a CSV file.  Words: column, interval, factor."""
        self._add("excitations", name, dict(kind="record", on=on, file=file, **words))

    def device(self, family: str, name: str, **words: object) -> None:
        """A device of any family, by the words of a file: what `[FAMILY.NAME]` and its keys say."""
        if not isinstance(family, str) or family not in FAMILIES:
            raise InputError(f'"{family}" is no family of devices.{way_out(family, list(FAMILIES))}')
        self._add(family, name, words)

    def scene(
        self,
        *,
        goal: Mapping[str, object] | None = None,
        limits: Mapping[str, Limit] | Sequence[Limit] = (),
        measures: Mapping[str, Measure] | Sequence[Measure] = (),
        expected: Sequence[Mapping[str, object]] = (),
        name: str = "scene",
    ) -> Scene:
        """The machine as it is now, with what is asked of it.

        Parameters
        ----------
        goal
            Made by `maximise`, `minimise` or `find_all`; without one the scene is an analysis.
        limits, measures
            By name; those of a list are named after response and place, as "displacement_press".
        expected
            Records for `vibopt verify`, with the keys of `[[expected]]`.
        name
            Stands in front of every message, as the name of a file does.

        Raises
        ------
        InputError
            What is said is wrong or incomplete; the text lists all mistakes with their paths.
        """
        if isinstance(goal, (Measure, Limit)):
            way_out = "Write maximise(...) for more of it, minimise(...) for less."
            raise InputError(f"goal = {goal!r} is a response. {way_out}")
        asked = {"limits": _named("limits", limits), "measures": _named("measures", measures)}
        asked = {family: tables for family, tables in asked.items() if tables}
        document = {**self._facts, **self._families, **asked, "goal": goal, "expected": expected or None}
        return from_dict(plain_table(document), name=name)

    def _add(self, family: str, name: str, words: Mapping[str, object]) -> None:
        _check_name(family, name)
        tables = self._families.setdefault(family, {})
        if name in tables:
            raise InputError(f"{family}.{name} is there already. Choose another name.")
        tables[name] = plain_table(words)


_WRITE = {
    "limits": 'a comparison, for example machine.displacement(of="press") <= "2 mm"',
    "measures": 'a response, for example machine.displacement(of="press")',
}


def _named(family: str, given: object) -> dict[str, object]:
    """Tables by name; without names they are called after response and place."""
    if isinstance(given, Mapping):
        items = list(given.items())
    elif isinstance(given, (list, tuple)):
        items = [(None, one) for one in given]
    else:
        raise InputError(f"{family} is neither a list nor a dictionary. Write {family}=[...] or {family}={{...}}.")
    named: dict[str, object] = {}
    for number, (name, one) in enumerate(items, start=1):
        if not isinstance(one, (Measure, Limit)):
            where = f"{family}[{number}]" if name is None else f"{family}.{name}"
            raise InputError(f"{where} is no {family[:-1]}. Write {_WRITE[family]}.")
        if name is not None:
            _check_name(family, name)
        named[_free_name(one, named) if name is None else name] = one.words
    return named


def _free_name(one: Measure | Limit, taken: Mapping[str, object]) -> str:
    """Response and place, as "displacement_press"; the second of that name ends in _2."""
    places = [one.words[key] for key in ("into", "through", "of", "across") if key in one.words]
    stem = "_".join(str(part) for part in (one.words["response"], *places))
    name, number = stem, 1
    while name in taken:
        number += 1
        name = f"{stem}_{number}"
    return name


def _check_name(family: str, name: object) -> None:
    if not isinstance(name, str):
        raise InputError(f'{family}: {name!r} is no name. Write a text, for example "press".')
    if wrong := name_fault(name):
        raise InputError(f'{family}: "{name}" {wrong}')
