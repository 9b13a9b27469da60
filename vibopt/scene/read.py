"""Problem file (TOML) or dictionary to Scene, or all mistakes at once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any

from vibopt.devices import FAMILIES
from vibopt.document.locate import Locator, located
from vibopt.document.mistakes import Mistakes, named_tables, records_in, text_in, validated
from vibopt.document.toml_reading import changed, parsed, placed, text_of
from vibopt.errors import way_out
from vibopt.excitations import KINDS as EXCITATIONS
from vibopt.excitations import Excitation
from vibopt.files.reading import shown_name
from vibopt.responses import GOALS, Response
from vibopt.responses import KINDS as RESPONSES
from vibopt.scene.assemble import tuning_notes
from vibopt.scene.check_scene import check
from vibopt.scene.drives import with_own_bounds
from vibopt.scene.open_places import MOST, combinations, has_open_ends, open_places, open_positions, positioned, settled
from vibopt.scene.scene import MAXIMISE, MINIMISE, OWN_FIELDS, Goal, Scene, Variable
from vibopt.units import show
from vibopt.values import Fact, Table, rule_of
from vibopt.values.fields import Choice, numbers_in

if TYPE_CHECKING:
    from vibopt.devices.rotor import RotorTable

_HEAD = ["title", "statement", "source"]
_TAIL = ["excitations", "limits", "measures", "goal", "scenarios", "expected"]
_PROBES = ((0.5,), (0.0, 1.0), (1.0, 0.0), (0.0,), (1.0,), (0.38, 0.74, 0.17), (0.81, 0.27, 0.63), (0.12, 0.55, 0.92))
"""Positions at which a scene is checked, as parts of each range in turn."""


def read(path: str | FilePath) -> Scene:
    """The scene of a problem file.

    Parameters
    ----------
    path
        A TOML file in UTF-8.

    Raises
    ------
    InputError
        The file cannot be read, or what it says is wrong; the text lists all mistakes with lines.
    """
    file = path if isinstance(path, FilePath) else FilePath(path)
    text, name = text_of(file), shown_name(file.name)
    return from_dict(placed(parsed(text, name), file.parent), name=name, locator=located(text))


def from_text(text: str, *, name: str = "scene") -> Scene:
    """The scene of a TOML text; `name` stands in front of each message."""
    return from_dict(parsed(text, name), name=name, locator=located(text))


def from_dict(
    document: Mapping[str, Any], *, name: str = "scene", locator: Locator | None = None, like: Scene | None = None
) -> Scene:
    """The scene of a document already parsed; the keys are those of the file, its tables where `like` has them too."""
    links = [one for family in ("links", "absorbers") for one in _names(document.get(family))]
    bodies = _names(document.get("bodies"))
    known = dict.fromkeys(("across", "through", "mount"), links) | {"press": bodies}  # as examples of words name them
    mistakes = Mistakes(name, locator, places=known)
    parts = _Parts(document, mistakes, {} if like is None else vars(like).get("tables", {}))
    scene = parts.scene(name, locator)
    _check(scene, mistakes, parts.broken)
    mistakes.raise_any()
    notes = tuning_notes(scene)
    scene = replace(scene, notes=(*scene.notes, *notes)) if notes else scene
    vars(scene)["tables"] = parts.tables
    return scene


def _names(table: object) -> list[str]:
    """Names of a family of a document."""
    return list(table) if isinstance(table, (dict, Mapping)) else []


def _check(scene: Scene, mistakes: Mistakes, broken: set[str]) -> None:
    """Check the scene, or each that it may become where places are left open."""
    if open_positions(scene):
        _check_positions(scene, mistakes, broken)
    elif not open_places(scene):
        check(scene, mistakes, broken)
    elif combinations(scene) > MOST:
        path = next(iter(open_places(scene)))
        mistakes.add(
            tuple(path.split(".")),
            f"{path}: {combinations(scene)} combinations of places are more than the {MOST} that are looked at one by "
            "one. Name fewer places.",
        )
    elif has_open_ends(scene):
        from vibopt.scene.layouts import check_layouts

        check_layouts(scene, mistakes, broken)
    else:
        for _, one in settled(scene):
            check(one, mistakes, broken)


def _check_positions(scene: Scene, mistakes: Mistakes, broken: set[str]) -> None:
    """Mistakes that the scene has at each of some positions: those half way, if there is none without."""
    spans = list(open_positions(scene).values())
    first: Mistakes | None = None
    for parts in _PROBES:
        tried = Mistakes(mistakes.name, mistakes.locator)
        values = [span.low + parts[i % len(parts)] * (span.high - span.low) for i, span in enumerate(spans)]
        _check(positioned(scene, values), tried, broken)
        if not tried.found:
            return
        first = first or tried
    assert first is not None
    mistakes.found.extend(one for one in first.found if one not in mistakes.found)


def with_changes(scene: Scene, changes: Mapping[str, Any]) -> Scene:
    """The same scene with some values replaced, by path: {"limits.start_up.at_most": "8 mm"}.

    Raises
    ------
    InputError
        A path that the scene does not have, or a value that does not fit there.
    """
    return from_dict(changed(scene.document, changes), name=scene.name, like=scene)


class _Parts:
    """Reads the tables of a document one by one, but those known by path; `broken` are paths with a mistake."""

    def __init__(self, document: Mapping[str, Any], mistakes: Mistakes, known: Mapping[Any, tuple[Any, Table]]) -> None:
        self.document, self.mistakes, self.known = document, mistakes, known
        self.tables: dict[tuple[str, ...], tuple[Any, Table]] = {}
        self.broken: set[str] = set()
        self.variables: list[Variable] = []
        self.notes: list[str] = []

    def scene(self, name: str, locator: Locator | None) -> Scene:
        self._top()
        known = self.document
        devices: dict[str, Any] = {one: self._kinds(one, "", FAMILIES) if one in known else {} for one in FAMILIES}
        own = {family: devices.pop(family) for family in OWN_FIELDS}
        excitations: dict[str, Excitation] = self._kinds("excitations", "kind", EXCITATIONS)
        excitations = {name: self._weighed(name, excitation, own["rotors"]) for name, excitation in excitations.items()}
        limits: dict[str, Response] = self._kinds("limits", "response", RESPONSES)
        measures: dict[str, Response] = self._kinds("measures", "response", RESPONSES)
        goal, find_all = self._goal()
        return Scene(
            name=name,
            title=text_in(known, "title", name, self.mistakes),
            statement=text_in(known, "statement", "", self.mistakes),
            **own,
            others={family: tables for family, tables in devices.items() if tables},
            excitations=excitations,
            limits=with_own_bounds(limits, own["mounts"], excitations),
            measures=measures,
            goal=goal,
            find_all=find_all,
            variables=tuple(self.variables),
            expected=records_in(known, self.mistakes),
            document=self.document,
            notes=tuple(dict.fromkeys(self.notes)),
            locator=locator,
        )

    def _weighed(self, name: str, excitation: Excitation, rotors: Mapping[str, RotorTable]) -> Excitation:
        """An unbalance with the mass that its grade counts, that of its rotor where the file says none."""
        if getattr(excitation, "grade", None) is None or getattr(excitation, "rotor_mass", None) is not None:
            return excitation
        shaft = next((key for key, table in rotors.items() if excitation.on in table.names), "")
        heavy = rotors[shaft].mass if shaft else None
        if heavy is None:
            lacks = f"sizes of rotors.{shaft} are to be chosen" if shaft else f"{excitation.on} is on no rotor"
            self.mistakes.add(
                ("excitations", name, "grade"),
                f"excitations.{name}.grade counts the mass of a rotor, and {lacks}. Add rotor_mass, or write the "
                "unbalance itself.",
            )
        known = excitation.model_copy(update={"rotor_mass": Fact(heavy or 1.0, "kg")})
        size, mass = show(known.swung, "", "unbalance"), show(heavy or 1.0, "", "mass")
        self.notes.append(f"excitations.{name}.grade: {size}, of a rotor of {mass}")
        return known

    def _top(self) -> None:
        known = [*_HEAD, *FAMILIES, *_TAIL]
        for key in self.document:
            if key not in known:
                self.broken.add(key)
                self.mistakes.unknown_key((key,), known)
        text_in(self.document, "source", "", self.mistakes)

    def _tables(self, family: str) -> dict[str, dict[str, Any]]:
        if not isinstance(self.document.get(family, {}), (dict, Mapping)):
            self.broken.add(family)
        good = {}
        for name, table in named_tables(self.document, family, self.mistakes).items():
            if isinstance(table, (dict, Mapping)):
                good[name] = table if isinstance(table, dict) else dict(table)
            else:
                self.broken.add(f"{family}.{name}")
                self.mistakes.value(
                    (family, name), table, f"is not a table. Write [{family}.NAME] and its keys below it."
                )
        return good

    def _kinds(self, family: str, key: str, kinds: Mapping[str, type[Any]]) -> dict[str, Any]:
        """The tables of a family, by name; `key` says which of its kinds one is, "" where it has one kind alone."""
        read = {}
        for name, table in self._tables(family).items():
            kind = self._kind_of((family, name), table, key, kinds) if key else kinds[family]
            made = self._table((family, name), table, kind) if kind is not None else None
            if made is not None:
                read[name] = made
                self._values((family, name), made)
            else:
                self.broken.add(f"{family}.{name}")
        return read

    def _kind_of(
        self, path: tuple[str, ...], table: Mapping[str, Any], key: str, kinds: Mapping[str, type[Any]]
    ) -> type[Any] | None:
        given = table.get(key)
        if given is None:
            self.mistakes.add(path, f"{'.'.join(path)} has no {key}. Write one of: {', '.join(kinds)}.")
            return None
        if not isinstance(given, str) or given not in kinds:
            self.mistakes.value(
                (*path, key), given, f"is no {key} that vibopt knows.{way_out(str(given), list(kinds))}"
            )
            return None
        return kinds[given]

    def _table(self, path: tuple[str, ...], table: Mapping[str, Any], kind: type[Table]) -> Any | None:
        same, made = self.known.get(path, (None, None))
        if same is not table:
            made = validated(kind, path, table, self.mistakes)
        if made is None:
            self.broken.add(".".join(path))
        else:
            self.tables[path] = table, made
        return made

    def _values(self, path: tuple[str, ...], made: Table) -> None:
        """Note the design variables and the readings of a table's values, those of tables in it too."""
        for where, value, table in numbers_in(".".join(path), made):
            if value.echo:
                self.notes.append(f"{where}: {value.echo}")
            if isinstance(value, Choice):
                rule = rule_of(type(table), where.rpartition(".")[2])
                dimension = rule.dimension if rule is not None else "ratio"
                self.variables.append(Variable(where, value, dimension))

    def _goal(self) -> tuple[Goal | None, str | None]:
        table = self.document.get("goal")
        if table is None:
            return None, None
        if not isinstance(table, Mapping):
            self.mistakes.value(("goal",), table, "is not a table. Write [goal] and its keys below it.")
            return None, None
        asked = [key for key in (MAXIMISE, MINIMISE, "find_all") if key in table]
        if len(asked) != 1:
            self._no_goal(table, asked)
            return None, None
        if asked[0] == "find_all":
            return None, self._find_all(table)
        return self._best(table, asked[0]), None

    def _no_goal(self, table: Mapping[str, Any], asked: list[str]) -> None:
        self.broken.add("goal")
        if asked:
            self.mistakes.add(("goal",), f"goal has {' and '.join(asked)}. Keep one of them.")
            return
        known = [MAXIMISE, MINIMISE, "find_all"]
        for key in table:
            if way_out(key, known).startswith(" Did"):
                self.mistakes.unknown_key(("goal", key), known)
                return
        self.mistakes.add(("goal",), 'goal says neither maximise, minimise nor find_all. Write maximise = "stiffness".')

    def _find_all(self, table: Mapping[str, Any]) -> str | None:
        for key in table:
            if key != "find_all":
                self.mistakes.unknown_key(("goal", key), ["find_all"])
        given = table["find_all"]
        if not isinstance(given, str):
            self.mistakes.value(("goal", "find_all"), given, 'is not a text. Write find_all = "fan.speed".')
            self.broken.add("goal")
            return None
        return given

    def _best(self, table: Mapping[str, Any], sense: str) -> Goal | None:
        words = {key: value for key, value in table.items() if key != sense}
        if "response" in words:
            self.mistakes.unknown_key(("goal", "response"), [])
            return None
        words["response"] = table[sense]
        if not isinstance(words["response"], str) or words["response"] not in GOALS:
            known = list(GOALS)
            self.mistakes.value(
                ("goal", sense), table[sense], f"is no response that vibopt knows.{way_out(str(table[sense]), known)}"
            )
            self.broken.add("goal")
            return None
        for key in ("at_most", "at_least", "outside"):
            if key in words:
                self.mistakes.add(("goal", key), f"goal has a bound ({key}). Say bounds in [limits.NAME].")
                words.pop(key)
        made = self._table(("goal",), words, GOALS[words["response"]])
        return Goal(sense, str(table[sense]), made) if made is not None else None
