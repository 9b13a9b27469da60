"""Laws of every kind in a registry: it is registered, says both routes and has energy; broken ones are caught."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest

import vibopt.devices
import vibopt.excitations
import vibopt.responses
from every_question import answerable, machine
from vibopt.arrays import FloatArray
from vibopt.devices import FAMILIES
from vibopt.devices.device import Device
from vibopt.devices.inerter import InerterTable
from vibopt.devices.link import LinkTable
from vibopt.devices.symbols import Numbers, Symbols
from vibopt.errors import InputError
from vibopt.excitations import KINDS as EXCITATIONS
from vibopt.excitations import Excitation
from vibopt.mechanics.assembly import Assembly
from vibopt.mechanics.builder import ModelBuilder
from vibopt.mechanics.model import DAMPING, HYSTERETIC, INERTIA, STIFFNESS
from vibopt.mechanics.modes import poles
from vibopt.mechanics.rigid import SpaceMachine
from vibopt.responses import GOALS, HarmonicResponse, RandomResponse, Response, TransientResponse
from vibopt.responses import KINDS as RESPONSES
from vibopt.scene import places
from vibopt.scene.assemble import model_of
from vibopt.scene.read import from_dict
from vibopt.scene.scene import Scene
from vibopt.scene.uncertain import uncertain
from vibopt.solve import solve
from vibopt.units import DIMENSIONS, si_unit
from vibopt.values.fields import Fact, numbers_in, rule_of
from vibopt.verify.as_built import machine_of

REGISTRIES: dict[str, tuple[Any, type, Mapping[str, type]]] = {
    "devices": (vibopt.devices, Device, FAMILIES),
    "responses": (vibopt.responses, Response, GOALS),
    "excitations": (vibopt.excitations, Excitation, EXCITATIONS),
}


def _all_of(base: type) -> Iterator[type]:
    for one in base.__subclasses__():
        yield from (one, *_all_of(one))


def unregistered(package: Any, base: type, registry: Mapping[str, type], home: str) -> list[str]:
    """Classes of a package that no other is made from, and that no file can name."""
    for module in pkgutil.iter_modules(package.__path__):
        importlib.import_module(f"{package.__name__}.{module.name}")
    kinds = [one for one in _all_of(base) if one.__module__.startswith(home) and not one.__subclasses__()]
    return [one.__name__ for one in kinds if one not in registry.values()]


def silent(kind: type[Device]) -> list[str]:
    """Routes that a device does not say."""
    return [route for route in ("add_to", "built") if getattr(kind, route) is getattr(Device, route)]


@pytest.mark.parametrize("family", REGISTRIES)
def test_every_kind_can_be_named(family: str) -> None:
    package, base, registry = REGISTRIES[family]
    names = unregistered(package, base, registry, package.__name__)
    assert not names, f"{', '.join(names)}: no line of {package.__name__}/__init__.py names it"


@pytest.mark.parametrize("family", FAMILIES)
def test_every_device_says_both_routes(family: str) -> None:
    assert not (routes := silent(FAMILIES[family])), f"{FAMILIES[family].__name__} has no {' and no '.join(routes)}"


@pytest.mark.parametrize("name", RESPONSES)
def test_every_response_has_its_facts(name: str) -> None:
    kind = RESPONSES[name]
    assert kind.dimension in DIMENSIONS
    assert kind.moves in ("line", "axis", "")
    assert kind.in_space in ("direction", "axis", "whole", "place", "body", "")
    for twin in (kind.twin, kind.noise_twin, kind.transient_twin):
        assert twin in ("", *RESPONSES)
    if kind.twin:
        assert {kind.moves, RESPONSES[kind.twin].moves} == {"line", "axis"}
    if kind.noise_twin:
        assert RESPONSES[kind.noise_twin].sort == "random"
        if kind.transient_twin:
            assert RESPONSES[kind.transient_twin].sort == "transient"
    if kind.in_space in ("direction", "axis"):
        assert kind.in_space in kind.model_fields
    assert kind.of_mount in ("", "each", "axis", "axes", "alike", "group")


# Mistakes of a new device, each caught


class Ballast(Device):
    """A mass on a point, of which nobody said how it is built."""

    on: str

    def add_to(self, builder: ModelBuilder, name: str, symbols: Symbols) -> None:
        """Nothing."""


class Backward(InerterTable):
    """An inerter that pulls where it should push."""

    def built(self, assembly: Assembly, name: str, numbers: Numbers) -> None:
        super().built(assembly, name, Numbers(numbers.chosen, {f"inerters.{name}.inertance": -1.0}))


class Forgotten(InerterTable):
    """An inerter that only the optimiser knows."""

    def built(self, assembly: Assembly, name: str, numbers: Numbers) -> None:
        """Nothing."""


def test_a_device_that_cannot_be_built_is_caught() -> None:
    assert silent(Ballast) == ["built"]
    with pytest.raises(NotImplementedError, match="Ballast cannot be built"):
        Ballast(on="pump").built(Assembly(), "ballast", Numbers({}))


def test_a_device_that_is_not_registered_is_caught() -> None:
    assert "Ballast" in unregistered(vibopt.devices, Device, FAMILIES, __name__)


@pytest.mark.parametrize("kind", [Backward, Forgotten])
def test_a_device_whose_routes_differ_is_caught(kind: type[Device], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(FAMILIES, "inerters", kind)
    document = {
        "title": "pump",
        "bodies": {"pump": {"mass": "120 kg"}},
        "links": {"mount": {"between": ["pump", "ground"], "stiffness": "200 kN/m", "damping": "1 kN s/m"}},
        "inerters": {"flywheel": {"between": ["pump", "ground"], "inertance": "40 kg"}},
        "measures": {"mode": {"response": "natural_frequency"}},
    }
    design = solve(from_dict(document))
    assert design.status == "check_failed"
    other = {Backward: "50", Forgotten: "40.8248"}[kind]
    assert design.claim == (
        "the two routes to an answer do not agree: mode (natural_frequency) is 35.3553 rad/s in the model, "
        f"{other} rad/s on the machine as built"
    )


class Exact(InerterTable):
    """An inerter that is built as said, however far it may be off."""

    def built(self, assembly: Assembly, name: str, numbers: Numbers) -> None:
        super().built(assembly, name, numbers.said)


class Sure(LinkTable):
    """A link that does not say what of it may be off."""

    def parts(self) -> dict[str, str]:
        return {}


class Anonymous(InerterTable):
    """An inerter that does not say the name of its link."""

    @classmethod
    def links_in(cls, name: str, given: Mapping[str, Any]) -> tuple[str, ...]:
        return ()


@pytest.mark.parametrize(
    ("family", "kind", "words"),
    [
        ("inerters", Exact, "wheel.inertance is off otherwise by add_to"),
        ("links", Sure, "parts: nothing of links.girder is off"),
    ],
)
def test_a_device_that_is_off_otherwise_than_it_says_is_caught(
    family: str, kind: type[Device], words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(FAMILIES, family, kind)
    with pytest.raises(AssertionError, match=words):
        test_a_number_that_is_off_is_so_by_both_routes("line")


def test_a_device_that_does_not_name_its_link_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(FAMILIES, "inerters", Anonymous)
    with pytest.raises(AssertionError, match="links_in and joins name other links"):
        test_what_a_device_says_of_itself_is_what_it_adds("line")


def test_a_family_that_is_registered_is_read_checked_and_answered(monkeypatch: pytest.MonkeyPatch) -> None:
    """One class and one line: no other place knows the families of a scene."""
    monkeypatch.setitem(FAMILIES, "flywheels", Flywheel)
    document = {
        "title": "pump",
        "bodies": {"pump": {"mass": "120 kg"}},
        "links": {"mount": {"between": ["pump", "ground"], "stiffness": "200 kN/m"}},
        "flywheels": {"wheel": {"between": ["pump", "ground"], "inertance": "40 kg"}},
        "measures": {"mode": {"response": "natural_frequency"}},
    }
    design = solve(from_dict(document))
    assert design.status == "met"
    assert design.measures["mode"].value.value == pytest.approx(np.sqrt(200e3 / 160.0), rel=1e-12)


class Flywheel(InerterTable):
    """An inerter of another family."""

    def add_to(self, builder: ModelBuilder, name: str, symbols: Symbols) -> None:
        super().add_to(builder, name, symbols)


# Energy and symmetry


def machines() -> dict[str, dict[str, Any]]:
    """Documents that hold every family of devices, on a line, about an axis, in a plane and in space."""
    made: dict[str, dict[str, Any]] = {}
    for motion in ("space", "plane", "line"):
        document = machine(motion, opened=False)
        document["inerters"] = {"wheel": {"between": ["floor", "ground"], "inertance": "30 kg"}}
        document["inerters"]["twister"] = {"between": ["disc", "ground"], "torsional_inertance": "0.4 kg m2"}
        if motion != "line":
            stands = {"at": ["0.5 m", "0.1 m", "0.2 m"], "direction": [0.6, 0, 0.8]}
            document["inerters"]["leaning"] = {"between": ["pump", "floor"], "inertance": "60 kg", **stands}
        document["absorbers"]["low"] = {"on": "floor", "mass_ratio": 0.05, "frequency": "8 Hz", "loss_factor": 0.2}
        made[motion] = document
    modes = [{"frequency": "4 Hz", "damping_ratio": 0.02, "modal_mass": "3 t", "shape": {"mid": 1.0}}]
    made["structure"] = {
        "title": "on a floor",
        "bodies": {"pump": {"mass": "180 kg"}},
        "bases": {"base": {}},
        "structures": {"slab": {"modes": modes}},
        "links": {"mount": {"between": ["pump", "mid"], "stiffness": "90 kN/m", "damping": "0.4 kN s/m"}},
        "inerters": {"wheel": {"between": ["pump", "mid"], "mass_ratio": 0.3, "relative_to": "pump"}},
    }
    for document in made.values():
        document["measures"] = {"mode": {"response": "natural_frequency"}}
    return made


SPINNING = {"rotors", "bearings"}
"""Families whose inertia is that of a whirl, which need not be positive: see test_rotors.py and test_bearings.py."""


def test_every_family_is_in_some_machine() -> None:
    missing = set(FAMILIES) - SPINNING - {family for one in machines().values() for family in one}
    assert not missing, f"no machine of `machines` above has any {', '.join(missing)}: put one into it"


def _alone(some: Iterable[str], others: Iterable[str]) -> list[str]:
    """Names of some that no other is, or belongs to: foot.1.z is of foot.1."""
    ends = [f"{two}." for two in others]
    return [one for one in some if not any(f"{one}.".startswith(two) or two.startswith(f"{one}.") for two in ends)]


@pytest.mark.parametrize("name", machines())
def test_what_a_device_says_of_itself_is_what_it_adds(name: str) -> None:
    """Checks of a file ask the words of a device before anything is built."""
    scene = from_dict(machines()[name])
    model, built = model_of(scene), machine_of(scene, {})
    mounts = built.mounts if isinstance(built, SpaceMachine) else ()
    springs = {term.owner for term in model.terms if term.kind == STIFFNESS and term.across and term.scale}
    assert set(places.links(scene)) == set(places.ends(scene)), "links_in and joins name other links"
    for words, said, there in (
        ("joins and add_to", places.ends(scene), model.links),
        ("joins and built", places.ends(scene), [one.name for one in (*built.joints, *mounts)]),
        ("springs and add_to", places.springs(scene), springs),
    ):
        assert not (apart := _alone(said, there) + _alone(there, said)), f"{words} differ in {', '.join(apart)}"
    moving = int((~model.massless).sum())
    assert places.freedoms(scene) == moving, f"freedoms_in counts {places.freedoms(scene)} coordinates, add_to {moving}"


@pytest.mark.parametrize("name", machines())
def test_energy_is_kinetic_potential_and_lost_and_both_routes_have_it(name: str) -> None:
    """M is positive, C, K and H take nothing from nobody; free motion is that of the machine as built."""
    scene = from_dict(machines()[name])
    model, built = model_of(scene), machine_of(scene, {})
    p, n, heavy = model.values(np.zeros(0)), model.n_free, ~model.massless
    kinds = {"inertia": INERTIA, "damping": DAMPING, "stiffness": STIFFNESS, "hysteretic stiffness": HYSTERETIC}
    own = [model.matrix(kind, p)[:n, :n] for kind in kinds.values()]
    for route, four in (("add_to", own), ("built", built.matrices())):
        for (word, kind), one in zip(kinds.items(), four, strict=True):
            assert np.allclose(one, one.T, rtol=0.0, atol=1e-12 * np.abs(one).max()), f"{route}: {word} not symmetric"
            least = np.linalg.eigvalsh(one[np.ix_(heavy, heavy)] if kind == INERTIA else one).min()
            lost = least <= 0.0 if kind == INERTIA else least < -1e-12 * np.abs(one).max()
            assert not lost, f"{route}: a {word} below zero gives energy that nobody put in; is a sign wrong?"
    assert _alike(*_both(scene, {})), "add_to and built do not move freely alike"


def _numbers(name: str) -> dict[str, tuple[float, str]]:
    """Of a machine by path every number of a device that may be chosen [SI], and its SI unit."""
    found = {}
    for family, device, table in places.devices(from_dict(machines()[name])):
        for path, one, holder in numbers_in(f"{family}.{device}", table):
            rule = rule_of(type(holder), path.rpartition(".")[2])
            if rule is not None and rule.choice and isinstance(one, Fact) and one.value:
                found[path] = one.value, si_unit(rule.dimension)
    return found


def _saying(name: str, path: str, value: Any) -> Scene | None:
    """The machine with a number said otherwise; None where that is refused in words, or another key says it."""
    document = machines()[name]
    *steps, key = path.split(".")
    table: Any = document
    for step in steps:
        table = table[int(step) - 1] if isinstance(table, list) else table[step]
    if key not in table and key != "tolerance":
        return None
    table[key] = value
    try:
        return from_dict(document)
    except InputError:
        return None


def _both(scene: Scene, chosen: Mapping[str, float]) -> tuple[FloatArray, FloatArray]:
    """Poles of a machine by either route at a design."""
    model = model_of(scene)
    own = poles(model, model.values(np.array([chosen[one.path] for one in scene.variables])))
    return _sorted(own), _sorted(machine_of(scene, chosen).poles())


def _alike(one: FloatArray, other: FloatArray) -> bool:
    return one.shape == other.shape and bool(np.abs(one - other).max() <= 1e-9 * np.abs(one).max())


@pytest.mark.parametrize("name", machines())
def test_a_number_that_is_chosen_is_that_number_by_both_routes(name: str) -> None:
    for path, (value, unit) in _numbers(name).items():
        ends = {end: f"{part * value!r} {unit}" for end, part in (("from", 0.5), ("to", 2.0))}
        fact, chosen = _saying(name, path, f"{1.25 * value!r} {unit}"), _saying(name, path, ends)
        if fact is not None and chosen is not None:
            own, built = map(_alike, _both(chosen, {path: 1.25 * value}), _both(fact, {}))
            assert own, f"add_to: {path} is not what was chosen"
            assert built, f"built: {path} is not what was chosen"


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name == "plane")) for name in machines()]
)
def test_a_number_that_is_off_is_so_by_both_routes(name: str) -> None:
    """Off by itself, or as a part of a table that has a tolerance."""
    for path, (value, unit) in _numbers(name).items():
        fact, off = (
            _saying(name, path, said)
            for said in (f"{1.25 * value!r} {unit}", {"value": f"{value!r} {unit}", "tolerance": "25 %"})
        )
        if fact is not None and off is not None and not _alike(_both(fact, {})[0], _both(off, {})[0]):
            assert [one.path for one in uncertain(off)] == [path]
            _off(off)
    for family, device, table in places.devices(from_dict(machines()[name])):
        if "tolerance" in type(table).model_fields:
            wide = _saying(name, f"{family}.{device}.tolerance", "25 %")
            assert wide is not None, f"parts: nothing of {family}.{device} is off with its tolerance"
            _off(wide)


def _off(scene: Scene) -> None:
    """Each part of a scene that may be off is so, by either route alike."""
    for path in (one.path for one in uncertain(scene)):
        (own, built), still = _both(replace(scene, off={path: 1.25}), {}), _both(scene, {})[0]
        assert _alike(own, built), f"{path} is off otherwise by add_to than by built"
        assert not _alike(own, still), f"{path} is off neither by add_to nor by built"


def _sorted(found: Any) -> FloatArray:
    order = np.lexsort((np.round(found.real, 6), np.round(np.abs(found), 6)))
    return np.asarray(found[order])


# Every response, place, way, motion and excitation: both routes

RECORD = Path(__file__).parents[2] / "problems" / "shock" / "shake_table.csv"
SHAKERS: dict[str, dict[str, Any]] = {
    "force": {"kind": "force", "on": "pump", "amplitude": "90 N", "varies": "constant"},
    "unbalance": {"kind": "unbalance", "on": "pump", "unbalance": "40 g m"},
    "harmonics": {
        "kind": "harmonics",
        "on": "pump",
        "harmonics": [{"order": 1, "amplitude": "90 N"}, {"order": 2, "amplitude": "20 N", "phase": "40 deg"}],
        "varies": "constant",
    },
    "moment": {"kind": "moment", "on": "disc", "amplitude": "9 N m", "varies": "constant"},
    "base_motion": {"kind": "base_motion", "on": "deck", "velocity": "3 mm/s", "varies": "constant"},
    "road": {"kind": "road", "on": "deck", "amplitude": "2 mm", "wavelength": "4 m", "speed": "10..90 km/h"},
    "white_noise": {"kind": "white_noise", "on": "floor", "density": "100 N²/Hz"},
    "moment_harmonics": {"kind": "moment_harmonics", "on": "pump", "harmonics": [{"order": 2, "amplitude": "20 N m"}]},
    "pulse": {"kind": "pulse", "on": "floor", "shape": "half sine", "amplitude": "2 kN", "duration": "20 ms"},
    "drop": {"kind": "drop", "on": "deck", "height": "5 mm"},
    "release": {"kind": "release", "on": "floor", "displacement": "-4 mm", "velocity": "0.3 m/s"},
    "record": {"kind": "record", "on": "deck", "file": str(RECORD)},
}
ON_PUMP = ("white_noise", "pulse", "release")
"""Of what is not steady, what acts on a body in space, too."""
Motion = Literal["space", "plane", "line"]


def shaken(kind: str, motion: Motion, on: str = "") -> dict[str, Any]:
    """The machine of everything under one excitation; what a base moves stands on it."""
    document = machine(motion, opened=False)
    shaker = {"speed": "2..40 Hz", **SHAKERS[kind], **({"on": on} if on else {})}
    if EXCITATIONS[kind].sort != "steady":
        del shaker["speed"]
    inside = motion != "line"
    if kind == "release" and on and inside:  # nobody says where what slides on a body begins
        del document["absorbers"]
    if shaker["on"] == "pump" and inside:
        shaker |= {"axis": "y"} if kind == "moment_harmonics" else {"direction": [0.6, 0, 0.8]}
    document["excitations"] = {"shaker": shaker}
    if shaker["on"] == "deck":
        document["bases"] = {"deck": {}}
        document["links"]["girder"]["between"] = ["floor", "deck"]
    document["inerters"] = {"wheel": {"between": ["pump", "floor"], "inertance": "60 kg"}}
    if inside:
        document["inerters"]["wheel"] |= {"at": ["0.5 m", "0.1 m", "0.2 m"], "direction": [0.6, 0, 0.8]}
    return document


def test_every_excitation_shakes() -> None:
    assert set(SHAKERS) == set(EXCITATIONS)


def questions(kind: str) -> dict[str, dict[str, Any]]:
    """Each response that the excitation can cause, of each place and of the whole, along and about some ways."""
    asker = {"steady": HarmonicResponse, "random": RandomResponse, "transient": TransientResponse}
    added = [{"combine": one} for one in ("peak", "sum")] if "harmonics" in kind else [{}]
    found: list[dict[str, Any]] = []
    for name, response in RESPONSES.items():
        if issubclass(response, asker[EXCITATIONS[kind].sort]):
            keys = [key for key in ("of", "into", "through", "across") if key in response.model_fields]
            read = [{}, *({key: place} for key in keys for place in PLACES)]
            ways = [
                way for way in ({}, {"direction": [0.6, 0, 0.8]}, {"axis": "y"}) if {*way} <= {*response.model_fields}
            ]
            found += [{"response": name, **at, **way, **more} for at in read for way in ways for more in added]
    return {f"q{number}": one for number, one in enumerate(found)}


PLACES = ("pump", "floor", "disc", "eye", "girder", "shaft", "foot.2", "wheel", "tmd", "ground", "deck")


@pytest.mark.parametrize("motion", ["line", "space", pytest.param("plane", marks=pytest.mark.slow)])
@pytest.mark.parametrize(("kind", "on"), [*((kind, "") for kind in SHAKERS), *((kind, "pump") for kind in ON_PUMP)])
def test_every_response_to_every_excitation_has_one_value(kind: str, on: str, motion: Motion) -> None:
    """The form of the optimiser and the measurement of the machine as built agree, or the file is refused in words."""
    document = {**shaken(kind, motion, on), "measures": questions(kind)}
    if (kind, motion) in NOT_THERE:
        with pytest.raises(InputError, match=NOT_THERE[kind, motion]):
            from_dict(document)
        return
    design = solve(answerable(document), explain=False)
    assert design.status == "met", design.claim
    assert len(design.measures) >= 3


NOT_THERE = {
    ("moment_harmonics", "line"): 'is a moment, but pump moves along a line. Write kind = "harmonics" with amplitude',
}
"""What an excitation cannot act on, in the words of the refusal: the machine of everything stands on mounts."""
