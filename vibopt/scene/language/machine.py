"""A machine said in Python, and the scenes that ask something of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TypedDict, Unpack

from vibopt.errors import InputError
from vibopt.scene.language.limit import Limit, Measure
from vibopt.scene.language.responses import Responses
from vibopt.scene.language.values import Bound, Given, Speeds, plain_table
from vibopt.scene.read import from_dict
from vibopt.scene.scene import Scene


class BodyWords(TypedDict, total=False):
    """Keys of `[bodies.NAME]`: mass [kg], or weight on earth [N]."""

    mass: Given
    weight: Bound


class LinkWords(TypedDict, total=False):
    """Keys of `[links.NAME]`; values are those of one single mount."""

    stiffness: Given
    damping: Given
    damping_ratio: Given
    relative_to: str
    loss_factor: Given
    count: Given
    dynamic_to_static: Bound


class Varied(TypedDict, total=False):
    """How an amplitude varies away from its own speed: "constant", "speed", "speed^2" or rows [speed, factor]."""

    varies: str | Sequence[Sequence[Bound]]
    amplitude_at: str


class UnbalanceWords(TypedDict, total=False):
    """Unbalance [kg m], or a rotating mass [kg] and its radius [m]."""

    unbalance: Bound
    rotating_mass: Bound
    radius: Bound


class BaseMotionWords(Varied, total=False):
    """One of displacement [m], velocity [m/s] and acceleration [m/s^2], peak."""

    displacement: Bound
    velocity: Bound
    acceleration: Bound


class RoadWords(TypedDict, total=False):
    """Wavelength [m] or wavenumber [rad/m]."""

    wavelength: Bound
    wavenumber: Bound


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
        """A rigid body.  Words: mass or weight."""
        self._add("bodies", name, words)

    def base(self, name: str) -> None:
        """A support that moves in a prescribed way."""
        self._add("bases", name, {})

    def link(self, name: str, *, between: Sequence[str], **words: Unpack[LinkWords]) -> None:
        """Springs and dampers, alike and in parallel, `between` two points.

        Words: stiffness and one of damping, damping_ratio (with relative_to), loss_factor; count; dynamic_to_static.
        """
        self._add("links", name, dict(between=between, **words))

    def force(self, name: str, *, on: str, amplitude: Bound, speed: Speeds, **words: Unpack[Varied]) -> None:
        """A harmonic force on a body, peak [N].  Words: varies, amplitude_at."""
        self._add("excitations", name, dict(kind="force", on=on, amplitude=amplitude, speed=speed, **words))

    def unbalance(self, name: str, *, on: str, speed: Speeds, **words: Unpack[UnbalanceWords]) -> None:
        """A rotating unbalance on a body.  Words: unbalance, or rotating_mass and radius."""
        self._add("excitations", name, dict(kind="unbalance", on=on, speed=speed, **words))

    def harmonics(
        self, name: str, *, on: str, speed: Speeds, harmonics: Sequence[Mapping[str, object]], **words: Unpack[Varied]
    ) -> None:
        """Several orders of one speed on a body: tables of order, amplitude (peak [N]) and phase.

        Words: varies, amplitude_at.
        """
        self._add("excitations", name, dict(kind="harmonics", on=on, speed=speed, harmonics=harmonics, **words))

    def base_motion(self, name: str, *, on: str, speed: Speeds, **words: Unpack[BaseMotionWords]) -> None:
        """Harmonic motion of a base, peak.  Words: displacement, velocity or acceleration; varies, amplitude_at."""
        self._add("excitations", name, dict(kind="base_motion", on=on, speed=speed, **words))

    def road(self, name: str, *, on: str, amplitude: Bound, speed: Speeds, **words: Unpack[RoadWords]) -> None:
        """A wavy road under a base, amplitude peak [m], at a speed of the vehicle.  Words: wavelength or wavenumber."""
        self._add("excitations", name, dict(kind="road", on=on, amplitude=amplitude, speed=speed, **words))

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
    if not isinstance(name, str) or not name:
        raise InputError(f'{family}: {name!r} is no name. Write a text, for example "press".')
