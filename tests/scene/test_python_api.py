"""The Python twin of the problem file: the same scenes, the same door, the same words."""

from __future__ import annotations

import ast
import inspect
import subprocess
import sys
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any, get_type_hints

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import vibopt as vo
from vibopt.devices import FAMILIES
from vibopt.excitations import KINDS as EXCITATIONS
from vibopt.responses import GOALS
from vibopt.responses import KINDS as RESPONSES
from vibopt.scene.language.responses import Responses

PROBLEMS = sorted((Path(__file__).parents[2] / "problems" / "isolation").glob("*.toml"))
NAMES = [file.stem for file in PROBLEMS]
BOUNDS = ("at_most", "at_least", "outside")


def press() -> vo.Machine:
    """The machine of the documentation."""
    machine = vo.Machine("Printing press on its mount")
    machine.body("press", mass="300 kg")
    machine.link(
        "mount",
        between=("press", "ground"),
        stiffness=vo.choose("10 kN/m", "1 GN/m"),
        damping=vo.choose("10 N s/m", "1 MN s/m"),
    )
    machine.force("press", on="press", amplitude="30 kN", speed="3000 rpm", varies="constant")
    return machine


def twin(document: dict[str, Any], name: str) -> vo.Scene:
    """The scene of a document, said through the builder."""
    machine: Any = vo.Machine(document["title"], **_some(document, "statement", "source"))
    for one, words in document["bodies"].items():
        machine.body(one, **words)
    for one in document.get("bases", {}):
        machine.base(one)
    for one, words in document.get("absorbers", {}).items():
        machine.absorber(one, **words)
    for one, words in document["links"].items():
        machine.link(one, **words)
    for one, words in document.get("inerters", {}).items():
        machine.inerter(one, **words)
    for one, words in document.get("excitations", {}).items():
        rest = dict(words)
        getattr(machine, rest.pop("kind"))(one, **rest)
    scene: vo.Scene = machine.scene(
        goal=_goal(machine, document.get("goal")),
        limits={one: _asked(machine, words) for one, words in document.get("limits", {}).items()},
        measures={one: _asked(machine, words) for one, words in document.get("measures", {}).items()},
        expected=document.get("expected", []),
        name=name,
    )
    return scene


def _some(table: dict[str, Any], *keys: str) -> dict[str, Any]:
    return {key: table[key] for key in keys if key in table}


def _asked(machine: Any, words: dict[str, Any], response: str = "") -> Any:
    """A measure, or the limit that a comparison makes of it."""
    rest = {key: value for key, value in words.items() if key not in (*BOUNDS, "response")}
    measure = getattr(machine, response or words["response"])(**rest)
    bounds = _some(words, *BOUNDS)
    if list(bounds) == ["at_most"]:
        return measure <= bounds["at_most"]
    if list(bounds) == ["at_least"]:
        return measure >= bounds["at_least"]
    return measure.limit(**bounds) if bounds else measure


def _goal(machine: Any, table: dict[str, Any] | None) -> dict[str, object] | None:
    for sense, make in (("maximise", vo.maximise), ("minimise", vo.minimise)):
        if table and sense in table:
            return make(_asked(machine, {key: one for key, one in table.items() if key != sense}, table[sense]))
    return vo.find_all(table["find_all"]) if table else None


@pytest.mark.parametrize("file", PROBLEMS, ids=NAMES)
def test_a_file_and_its_python_twin_are_the_same_scene(file: Path) -> None:
    scene = vo.read(file)
    said = twin(tomllib.loads(file.read_text(encoding="utf-8")), file.name)
    assert said.document == scene.document
    assert said == scene


@pytest.mark.parametrize("file", PROBLEMS, ids=NAMES)
def test_a_scene_written_reads_as_the_same_scene(file: Path, tmp_path: Path) -> None:
    scene = vo.read(file)
    vo.write(scene, tmp_path / file.name)
    again = vo.read(tmp_path / file.name)
    assert again.document == scene.document
    assert again == scene
    assert vo.to_toml(again) == vo.to_toml(scene)


def test_a_scene_said_in_python_is_written_as_an_engineer_would_write_it() -> None:
    machine = press()
    scene = machine.scene(
        goal=vo.maximise(machine.stiffness(of="mount")),
        limits=[machine.transmitted_force(into="ground") <= "10 kN", machine.displacement(of="press") <= "2.5 mm"],
    )
    assert vo.to_toml(scene) == (
        'title = "Printing press on its mount"\n\n'
        '[bodies.press]\nmass = "300 kg"\n\n'
        '[links.mount]\nbetween = ["press", "ground"]\n'
        'stiffness = { from = "10 kN/m", to = "1 GN/m" }\ndamping = { from = "10 N s/m", to = "1 MN s/m" }\n\n'
        '[excitations.press]\nkind = "force"\non = "press"\namplitude = "30 kN"\nspeed = "3000 rpm"\n'
        'varies = "constant"\n\n'
        '[limits.transmitted_force_ground]\nresponse = "transmitted_force"\ninto = "ground"\nat_most = "10 kN"\n\n'
        '[limits.displacement_press]\nresponse = "displacement"\nof = "press"\nat_most = "2.5 mm"\n\n'
        '[goal]\nmaximise = "stiffness"\nof = "mount"\n'
    )


_TEXTS = st.text(max_size=12)
_NAMES = st.text(st.characters(exclude_categories=("C", "Z"), exclude_characters="."), min_size=1, max_size=12)
_NUMBERS = st.integers(-(2**63), 2**63 - 1) | st.floats(allow_nan=False)
_LEAVES = _TEXTS | st.booleans() | _NUMBERS | st.dates() | st.times()
_VALUES = st.recursive(
    _LEAVES, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(_TEXTS, inner, max_size=3), max_leaves=8
)


@given(statement=_TEXTS, record=st.dictionaries(_TEXTS, _VALUES, max_size=4), name=_NAMES)
def test_whatever_toml_can_hold_is_written_exactly(statement: str, record: dict[str, Any], name: str) -> None:
    document = {
        "title": name,
        "statement": statement,
        "bodies": {f"b{name}": {"mass": "1 kg"}},
        "measures": {name: {"response": "total_mass"}},
        "expected": [record],
    }
    assert tomllib.loads(vo.to_toml(vo.from_dict(document))) == document


def test_what_no_file_can_hold_is_not_written(tmp_path: Path) -> None:
    document = {
        "bodies": {"a": {"mass": "1 kg"}},
        "measures": {"m": {"response": "total_mass", "unit": None}},
        "expected": [{"value": 1j}],
    }
    with pytest.raises(vo.InputError) as caught:
        vo.to_toml(vo.from_dict(document))
    assert str(caught.value) == "1j cannot be written in a problem file. Write a text, a number, a list or a table."
    scene = vo.from_dict({**document, "expected": []})
    with pytest.raises(vo.InputError) as caught:
        vo.write(scene, tmp_path)
    assert str(caught.value) == f"{tmp_path} cannot be written: is a directory."
    assert "unit" not in vo.to_toml(scene)


def test_limits_of_a_list_are_named_after_response_and_place() -> None:
    machine = press()
    move = machine.displacement(of="press")
    scene = machine.scene(
        goal=vo.maximise(machine.stiffness(of="mount")),
        limits=[
            move <= "2.5 mm",
            machine.displacement(of="press", over="start-up") <= "20 mm",
            machine.transmitted_force(through="mount") <= "10 kN",
            machine.natural_frequency().limit(outside="20..30 Hz"),
        ],
        measures=[move, machine.relative_displacement(across="mount"), machine.total_mass()],
    )
    assert list(scene.limits) == [
        "displacement_press",
        "displacement_press_2",
        "transmitted_force_mount",
        "natural_frequency",
    ]
    assert list(scene.measures) == ["displacement_press", "relative_displacement_mount", "total_mass"]


def test_a_bound_may_stand_on_either_side() -> None:
    measure: Any = press().isolation(into="ground")
    for limit in (measure >= 0.9, 0.9 <= measure, np.float64(0.9) <= measure, measure.limit(at_least=0.9)):  # noqa: SIM300
        assert limit.words == {"response": "isolation", "into": "ground", "at_least": 0.9}
    assert ("6 kN" >= measure).words["at_most"] == "6 kN"  # noqa: SIM300


def test_both_bounds_of_a_limit_are_one_limit() -> None:
    limit = press().static_deflection(of="mount").limit(at_least="1 mm", at_most="3 mm")
    assert repr(limit) == 'static_deflection(of="mount").limit(at_most="3 mm", at_least="1 mm")'
    assert limit.words == {"response": "static_deflection", "of": "mount", "at_most": "3 mm", "at_least": "1 mm"}


def test_a_scene_does_not_change_with_its_machine() -> None:
    machine = press()
    goal = vo.minimise(machine.stiffness(of="mount"))
    pair = ["mount", "other"]
    scene = machine.scene(goal=goal)
    machine.body("other", mass="1 kg")
    machine.link("second", between=pair, stiffness="1 N/m")
    pair.reverse()
    goal["of"] = "second"
    assert list(scene.document["bodies"]) == ["press"]
    assert scene.document["goal"] == {"minimise": "stiffness", "of": "mount"}


def test_numbers_of_numpy_are_numbers() -> None:
    machine: Any = vo.Machine("Four mounts")
    machine.body("box", mass="80 kg")
    words = {"count": np.int64(4), "damping_ratio": np.float32(0.5)}
    machine.link("feet", between=("box", "ground"), stiffness="1 kN/m", **words)
    scene = machine.scene(measures=[machine.total_mass()])
    assert scene.document["links"]["feet"]["count"] == 4
    assert type(scene.document["links"]["feet"]["count"]) is int
    assert type(scene.document["links"]["feet"]["damping_ratio"]) is float


def test_choices_are_those_of_the_file() -> None:
    assert vo.choose("1 kN/m", "2 kN/m") == {"from": "1 kN/m", "to": "2 kN/m"}
    assert vo.choose(to="2 kN/m") == {"to": "2 kN/m"}
    assert vo.choose(1, 8, whole=True) == {"from": 1, "to": 8, "whole": True}
    assert vo.one_of("1 MN/m", "2 MN/m") == {"one_of": ["1 MN/m", "2 MN/m"]}


# Errors


def _chained() -> object:
    return "1 mm" <= press().displacement(of="press") <= "2 mm"


def _goal_is(goal: Any) -> Callable[[], object]:
    return lambda: press().scene(goal=goal)


def _limits_are(limits: Any) -> Callable[[], object]:
    return lambda: press().scene(limits=limits)


UNDECIDED = (
    'displacement(of="press") {} is a limit, and neither true nor false before the scene is solved. For a value '
    'between two bounds write .limit(at_least="...", at_most="..."); for several limits write a list of them.'
)
MOVE = press().displacement(of="press")
FORCE = press().transmitted_force(into="ground", over=["0..10 Hz"])
REFUSED_AT_ONCE: dict[str, tuple[Callable[[], object], str]] = {
    "chain": (
        _chained,
        UNDECIDED.format('>= "1 mm"'),
    ),
    "and": (
        lambda: (MOVE <= "1 mm") and (FORCE <= "1 kN"),
        UNDECIDED.format('<= "1 mm"'),
    ),
    "less": (
        lambda: MOVE < "2 mm",
        'displacement(of="press") < "2 mm" is no limit: a limit includes its bound. '
        'Write displacement(of="press") <= "2 mm".',
    ),
    "greater": (
        lambda: FORCE > "2 kN",
        'transmitted_force(into="ground", over=[\'0..10 Hz\']) > "2 kN" is no limit: a limit includes its bound. '
        'Write transmitted_force(into="ground", over=[\'0..10 Hz\']) >= "2 kN".',
    ),
    "equal": (
        lambda: MOVE == "2 mm",
        'displacement(of="press") == "2 mm" is no limit: no machine meets a value exactly. '
        'Write <= or >=, or both as .limit(at_least="...", at_most="...").',
    ),
    "unequal": (
        lambda: MOVE != 2,
        'displacement(of="press") == 2 is no limit: no machine meets a value exactly. '
        'Write <= or >=, or both as .limit(at_least="...", at_most="...").',
    ),
    "two responses": (
        lambda: MOVE <= press().displacement(of="frame"),  # noqa: SIM300
        'displacement(of="press") <= displacement(of="frame") compares two responses. '
        'Compare a response with a value and its unit, for example "6 kN".',
    ),
    "bound as a word": (
        lambda: press().displacement(of="press", at_most="2 mm"),
        'displacement(of="press", at_most="2 mm") has a bound (at_most). '
        "Write a bound as a comparison, as .limit(at_most=...).",
    ),
    "goal without sense": (
        _goal_is(MOVE),
        'goal = displacement(of="press") is a response. Write maximise(...) for more of it, minimise(...) for less.',
    ),
    "goal of no response": (
        lambda: vo.maximise("stiffness"),
        "maximise('stiffness'): this is no response. Write maximise(machine.stiffness(of=\"mount\")), for example.",
    ),
    "limits no list": (
        _limits_are(MOVE <= "2 mm"),
        "limits is neither a list nor a dictionary. Write limits=[...] or limits={...}.",
    ),
    "limit in a list": (
        _limits_are([MOVE <= "2 mm", "2 mm"]),
        'limits[2] is no limit. Write a comparison, for example machine.displacement(of="press") <= "2 mm".',
    ),
    "limit by name": (
        _limits_are({"start_up": True}),
        'limits.start_up is no limit. Write a comparison, for example machine.displacement(of="press") <= "2 mm".',
    ),
    "measure": (
        lambda: press().scene(measures=["sag"]),
        'measures[1] is no measure. Write a response, for example machine.displacement(of="press").',
    ),
    "limit name": (
        _limits_are({3: MOVE <= "2 mm"}),
        'limits: 3 is no name. Write a text, for example "press".',
    ),
    "body name": (
        lambda: press().body(None, mass="1 kg"),
        'bodies: None is no name. Write a text, for example "press".',
    ),
    "name with a point": (
        lambda: press().body("a.b", mass="1 kg"),
        'bodies: "a.b" has a point, which parts the steps of a path as bodies.press.mass. Write "a-b".',
    ),
    "twice": (
        lambda: press().body("press", mass="1 kg"),
        "bodies.press is there already. Choose another name.",
    ),
}


@pytest.mark.parametrize(("make", "text"), REFUSED_AT_ONCE.values(), ids=REFUSED_AT_ONCE)
def test_what_cannot_be_meant_is_refused_where_it_is_written(make: Callable[[], object], text: str) -> None:
    with pytest.raises(vo.InputError) as caught:
        make()
    assert str(caught.value) == text


def _scene_with(**asked: Any) -> Callable[[], object]:
    return lambda: press().scene(**{"goal": vo.maximise(press().stiffness(of="mount")), **asked})


def _with_body(**words: Any) -> Callable[[], object]:
    def make() -> object:
        machine = press()
        machine.body("frame", **words)
        return machine.scene(goal=vo.maximise(machine.stiffness(of="mount")))

    return make


REFUSED_AT_THE_DOOR: dict[str, tuple[Callable[[], object], list[str]]] = {
    "dimension": (
        _scene_with(limits={"floor": FORCE <= "6 mm"}),
        [
            'scene: limits.floor.at_most = "6 mm" is a length, but transmitted_force is a force. '
            'Write a force, for example "6 kN".'
        ],
    ),
    "key": (_with_body(mas="300 kg", mass="1 kg"), ['scene: unknown key "mas" in bodies.frame. Did you mean "mass"?']),
    "no unit": (
        _with_body(mass=480),
        ['scene: bodies.frame.mass = 480 has no unit. Write "480 kg".'],
    ),
    "no place": (
        _scene_with(limits={"floor": press().transmitted_force() <= "6 kN"}),
        ['scene: limits.floor needs either into (a place) or through (a link). Write into = "ground".'],
    ),
    "unknown place": (
        _scene_with(limits=[press().displacement(of="pres") <= "6 mm"]),
        ['scene: limits.displacement_pres.of = "pres" names no body of this scene. Did you mean "press"?'],
    ),
    "a measure among limits": (
        _scene_with(limits={"move": MOVE}),
        ["scene: limits.move has no bound. Add at_most or at_least, or move it to [measures.move]."],
    ),
    "a limit among measures": (
        _scene_with(measures={"move": MOVE <= "2 mm"}),
        ["scene: measures.move has a bound (at_most), but a measure has none. Move it to [limits.move]."],
    ),
    "a goal with a bound": (
        _scene_with(goal=vo.maximise(MOVE <= "2 mm")),
        ["scene: goal has a bound (at_most). Say bounds in [limits.NAME]."],
    ),
    "all at once": (
        _scene_with(name="press.py", limits={"floor": FORCE <= "6 mm", "move": MOVE <= 2}),
        [
            'press.py: limits.floor.at_most = "6 mm" is a length, but transmitted_force is a force. '
            'Write a force, for example "6 kN".',
            'press.py: limits.move.at_most = 2 has no unit. Write "2 mm".',
        ],
    ),
}


@pytest.mark.parametrize(("make", "texts"), REFUSED_AT_THE_DOOR.values(), ids=REFUSED_AT_THE_DOOR)
def test_the_door_of_files_refuses_with_the_words_of_files(make: Callable[[], object], texts: list[str]) -> None:
    with pytest.raises(vo.InputError) as caught:
        make()
    assert list(caught.value.messages) == texts


# Words: the builder's are those of the tables


def _words_of(method: Callable[..., object]) -> set[str]:
    """Named parameters, and the keys that **words may hold."""
    parameters = inspect.signature(method).parameters
    named = {one.name for one in parameters.values() if one.kind is inspect.Parameter.KEYWORD_ONLY}
    if "words" in parameters:
        named |= set(get_type_hints(get_type_hints(method)["words"].__args__[0]))
    return named


@pytest.mark.parametrize("kind", RESPONSES)
def test_each_response_is_a_method_with_the_words_of_the_file(kind: str) -> None:
    words = set(RESPONSES[kind].model_fields) - {"response", *BOUNDS}
    method = getattr(vo.Machine, kind)
    assert _words_of(method) == words
    assert inspect.getdoc(method) == inspect.getdoc(RESPONSES[kind])


@pytest.mark.parametrize("kind", EXCITATIONS)
def test_each_excitation_is_a_method_with_the_words_of_the_file(kind: str) -> None:
    refused = {"speed"} if EXCITATIONS[kind].sort != "steady" else set()
    assert _words_of(getattr(vo.Machine, kind)) == set(EXCITATIONS[kind].model_fields) - {"kind"} - refused


def test_each_part_is_a_method_with_the_words_of_the_file() -> None:
    methods: dict[str, Any] = {"bodies": vo.Machine.body, "bases": vo.Machine.base, "links": vo.Machine.link}
    methods["absorbers"] = vo.Machine.absorber
    methods["structures"] = vo.Machine.structure
    methods["rotors"] = vo.Machine.rotor
    methods["points"] = vo.Machine.point
    methods["inerters"] = vo.Machine.inerter
    methods["bearings"] = vo.Machine.bearing
    methods["mounts"] = vo.Machine.mount
    assert set(methods) == set(FAMILIES)
    tables: dict[str, Any] = dict(FAMILIES)
    for family, table in tables.items():
        assert _words_of(methods[family]) == set(table.model_fields)


def test_no_method_is_named_after_a_response_that_is_gone() -> None:
    assert {name for name in vars(Responses) if not name.startswith("_")} == set(GOALS)


# The front door


def _bare(code: str) -> str:
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return done.stdout.strip()


def test_importing_vibopt_loads_next_to_nothing() -> None:
    """Only where answers find the words of their kind."""
    known = "{'types', '__future__'}"
    code = f"import sys; before = set(sys.modules); import vibopt; print(sorted(set(sys.modules) - before - {known}))"
    assert _bare(code) == "['vibopt', 'vibopt.answer', 'vibopt.answer.views']"


def test_saying_a_machine_loads_no_solver() -> None:
    heavy = ("casadi", "cvxpy", "clarabel", "scipy", "matplotlib", "jinja2", "rich", "click")
    code = f"import sys, vibopt; vibopt.Machine('A'); print([one for one in {heavy} if one in sys.modules])"
    assert _bare(code) == "[]"


def _exports() -> tuple[dict[str, str], Any]:
    """Homes of the names as the type checker sees them, and the module."""
    tree = ast.parse(Path(str(vo.__file__)).read_text(encoding="utf-8"))
    found = {
        alias.name: str(node.module)
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and str(node.module).startswith("vibopt.")
        for alias in node.names
        if alias.asname == alias.name
    }
    return found, vo


def test_each_export_has_the_home_that_the_type_checker_sees() -> None:
    found, module = _exports()
    assert found == module._HOME_OF


@pytest.mark.parametrize("name", sorted(_exports()[0]))
def test_each_export_is_there_and_listed(name: str) -> None:
    assert callable(getattr(vo, name))
    assert name in dir(vo)


@pytest.mark.parametrize("first", ["import vibopt.solve.method", "vo.solve; import vibopt.solve.method"])
def test_the_verb_solve_stays_a_verb_beside_the_package_of_its_name(first: str) -> None:
    assert _bare(f"import vibopt as vo; {first}; print(type(vo.solve).__name__)") == "function"


def test_an_unknown_name_is_refused() -> None:
    module: Any = vo
    with pytest.raises(AttributeError) as caught:
        _ = module.slove
    assert str(caught.value) == "vibopt has no 'slove'"
