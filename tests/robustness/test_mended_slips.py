"""Slips that everybody makes: read as they are meant where that is certain, else told with what to write instead."""

from __future__ import annotations

import copy
import csv
import io
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from refusals import refused
from vibopt.document.mistakes import Mistakes
from vibopt.document.toml_reading import placed
from vibopt.errors import InputError, counted, way_out
from vibopt.jobs import answer, from_text, of_document, open_job, with_changes
from vibopt.study.recorded import compare
from vibopt.study.scenarios import stepped, variants_of
from vibopt.study.sweep import sweep
from vibopt.study.whatif import whatif
from vibopt.study.window import window
from vibopt.values.fact_at import FactAt
from vibopt.work import TimeLimit

ROOT = Path(__file__).parents[2] / "problems"
PRESS, COMPRESSOR = ROOT / "isolation" / "rao_9_34.toml", ROOT / "mounts" / "compressor_on_bought_mounts.toml"


def changed(file: Path, old: str, new: str, folder: Path) -> Path:
    """The file with one text replaced, in a folder of its own."""
    text = file.read_text(encoding="utf-8")
    assert old in text
    target = folder / "slip.toml"
    target.write_text(text.replace(old, new), encoding="utf-8")
    return target


def said_of(file: Path) -> tuple[str, ...]:
    try:
        open_job(file)
    except InputError as error:
        return error.messages
    return ()


TOLD = {
    "objective": ("[goal]", "[objective]", 'line 45: unknown key "objective" at the top level. Did you mean "goal"?'),
    "max": ('at_most = "10 kN"', 'max = "10 kN"',
            'line 27: unknown key "max" in limits.floor_force. Did you mean "at_most"?'),
    "run-up": ('over = "0..3000 rpm"', 'over = "run-up"',
               'line 37: limits.start_up.over = "run-up" is no speed. Did you mean "start-up", every speed from '
               "rest to the highest own speed?"),
    "kg for a force": ('at_most = "10 kN"', 'at_most = "1000 kg"',
                       'line 27: limits.floor_force.at_most = "1000 kg" is a mass, but transmitted_force is a force. '
                       'Did you mean "kgf", with the weight of a kilogram (9.80665 N)?'),
    "kg/mm": ('to = "1 GN/m"', 'to = "100 kg/mm"',
              'line 14: links.mount.stiffness = { from = "10 kN/m", to = "100 kg/mm" } has a wrong to: "100 kg/mm" has '
              'the unit "kg/mm", but a stiffness is needed here. Did you mean "kgf/mm", with the weight of a kilogram '
              "(9.80665 N)?"),
    "no unit beside one": ('to = "1 GN/m"', 'to = "60"',
                           'line 14: links.mount.stiffness = { from = "10 kN/m", to = "60" } has a wrong to: "60" has '
                           'no unit. Write "60 kN/m".'),
    "decimal comma": ('at_most = "2.5 mm"', 'at_most = "2,5 mm"',
                      'line 32: limits.amplitude.at_most = "2,5 mm" has a decimal comma; write a point for the '
                      'decimals: "2.5 mm".'),
    "acceleration of a run-up": ('over = "0..3000 rpm"', 'over = "0..3000 rpm"\nacceleration = "5 rad/s2"',
                                 'line 38: unknown key "acceleration" in limits.start_up. Over start-up each speed '
                                 'counts as if it lasted; a run-up of a given rate is written run_up = { acceleration '
                                 '= "50 rpm/s" } on an unbalance or a force. The acceleration of a base stands in '
                                 'kind = "base_motion".'),
}  # fmt: skip


@pytest.mark.parametrize(("old", "new", "words"), TOLD.values(), ids=TOLD)
def test_a_slip_is_told_with_what_to_write(old: str, new: str, words: str, tmp_path: Path) -> None:
    assert said_of(changed(PRESS, old, new, tmp_path))[0] == f"slip.toml {words}"


@pytest.mark.parametrize("word", ["startup", "start_up", "Start-up", "start up"])
def test_start_up_is_read_in_every_spelling(word: str, tmp_path: Path) -> None:
    job: Any = open_job(changed(PRESS, 'over = "0..3000 rpm"', f'over = "{word}"', tmp_path))
    assert job.limits["start_up"].over == "start-up"


@pytest.mark.parametrize("grade", ["G6.3", "G 6,3", "g6.3 mm/s"])
def test_a_grade_by_its_name_is_the_velocity_and_the_answer_says_so(grade: str, tmp_path: Path) -> None:
    file = ROOT / "balancing" / "rao_9_22.toml"
    text = 'rotor.mass = "1 kg"\n' if "[quality]" not in file.read_text(encoding="utf-8") else ""
    assert text  # a job that asks for nothing else
    target = tmp_path / "grade.toml"
    target.write_text(
        f'[quality]\ngrade = "{grade}"\nmass = "500 kg"\nspeed = "3000 rpm"\ncentre_of_mass = "450 mm"\n'
        'bearings = { A = "0 mm", B = "900 mm" }\n', encoding="utf-8",
    )  # fmt: skip
    job: Any = open_job(target)
    assert job.quality.grade == pytest.approx(6.3e-3, rel=1e-12)
    assert job.notes == (f'quality.grade: "{grade}" read as 6.3 mm/s, the velocity that the grade stands for.',)


def numbers_in(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, one in inner:
        if isinstance(one, (int, float)) and not isinstance(one, bool):
            yield (*path, key)
        yield from numbers_in(one, (*path, key))


def test_true_is_no_number_anywhere() -> None:
    """Law over every kind of place in the problem files that holds a plain number."""
    seen, taken = set(), []
    for file in sorted(ROOT.rglob("*.toml")):
        given = tomllib.loads(file.read_text(encoding="utf-8"))
        given.pop("expected", None)
        for path in numbers_in(given):
            place = (file.parent.name, *(step for k, step in enumerate(path) if isinstance(step, str) and k != 1))
            if place in seen:
                continue
            seen.add(place)
            wrong = copy.deepcopy(given)
            holder: Any = wrong
            for step in path[:-1]:
                holder = holder[step]
            holder[path[-1]] = True
            try:
                of_document(placed(wrong, file.parent), Mistakes(file.name))
                taken.append((file.name, path))
            except InputError as error:
                taken += [] if "true" in str(error) else [(file.name, path)]
    assert taken == []
    assert len(seen) > 20


def test_all_mistakes_of_a_limit_are_said_at_once(tmp_path: Path) -> None:
    """A bound that cannot be read does not hide an unknown key beside it."""
    said = said_of(changed(PRESS, 'at_most = "2.5 mm"', 'at_most = "2,5 mm"\ncolour = "red"', tmp_path))
    assert [one.split(": ")[1].split(" ")[0] for one in said] == ["limits.amplitude.at_most", "unknown"]


def test_mistakes_of_what_is_asked_are_said_beside_those_of_the_readings(tmp_path: Path) -> None:
    file = ROOT / "balancing" / "foiles_min_max.toml"
    text = file.read_text(encoding="utf-8")
    given = tomllib.loads(text)
    reading = next(iter(given["runs"][0]["readings"].values()))
    target = tmp_path / "slip.toml"
    target.write_text(text.replace(reading, reading.replace("@", "§"), 1).replace("[goal]", "[goal]\ncombin = 1"))
    said = said_of(target)
    assert any("§" in one for one in said)
    assert any('unknown key "combin" in goal' in one for one in said)


def parts(folder: Path, **changes: str) -> Path:
    """The compressor on parts of a catalogue whose cells or headings are changed."""
    text = (COMPRESSOR.parent / "mounts.csv").read_text(encoding="utf-8-sig")
    for old, new in changes.values():
        assert old in text
        text = text.replace(old, new, 1)
    (folder / "mounts.csv").write_text(text, encoding="utf-8")
    (folder / "slip.toml").write_bytes(COMPRESSOR.read_bytes())
    return folder / "slip.toml"


def test_a_catalogue_in_kilograms_is_asked_about_and_nothing_else_is_blamed(tmp_path: Path) -> None:
    said = said_of(parts(tmp_path, load=("rated load max [N]", "rated load max [kg]"), rate=("[N/mm]", "[kg/mm]")))
    assert said == (
        'slip.toml line 15: mounts.csv row 1, column D ("rated load max [kg]"): is a mass, but a force is needed here. '
        'Did you mean "kgf", with the weight of a kilogram (9.80665 N)?',
        'slip.toml line 15: mounts.csv row 1, column E ("stiffness [kg/mm]"): has the unit "kg/mm", but a stiffness is '
        'needed here. Did you mean "kgf/mm", with the weight of a kilogram (9.80665 N)?',
    )


def test_a_cell_that_repeats_the_unit_of_its_heading_is_read(tmp_path: Path) -> None:
    text = (COMPRESSOR.parent / "mounts.csv").read_text(encoding="utf-8-sig")
    rows = list(csv.reader(io.StringIO(text), delimiter=";"))
    cell = rows[1][rows[0].index("rated load max [N]")]
    plain: Any = open_job(parts(tmp_path))
    both: Any = open_job(parts(tmp_path, cell=(f";{cell};", f";{cell} N;")))
    assert both.links["feet"].part.parts.columns["rated_max"] == pytest.approx(
        plain.links["feet"].part.parts.columns["rated_max"], rel=0.0
    )


@pytest.mark.parametrize(
    ("cell", "words"),
    {
        "5 mil pp": (),
        "5 mm": ('runs.csv row 2, column C ("a amplitude [mil pp]"): "5 mm" has a unit of its own. Write the number '
                 'alone, in "mil pp".',),
    }.items(),
)  # fmt: skip
def test_a_reading_may_repeat_the_unit_of_its_heading_and_no_other(
    cell: str, words: tuple[str, ...], tmp_path: Path
) -> None:
    (tmp_path / "runs.csv").write_text(
        "run;speed [rpm];a amplitude [mil pp];a angle [deg];one mass [g];one angle [deg]\n"
        f"found;1200;{cell};30;;\ntrial;1200;4;90;10;0\n", encoding="utf-8",
    )  # fmt: skip
    (tmp_path / "job.toml").write_text(
        'readings = "runs.csv"\n[conventions]\nangles = "against rotation"\nphase = "lag"\nzero = "keyphasor"\n'
        '[planes.one]\nradius = "100 mm"\n[sensors.a]\n', encoding="utf-8",
    )  # fmt: skip
    said = tuple(one for one in said_of(tmp_path / "job.toml") if "conventions" not in one)
    assert said == words


@pytest.mark.parametrize(
    ("count", "things", "words"),
    [
        (1, "boxes", "1 box"), (2, "boxes", "2 boxes"), (0, "slices", "0 slices"), (1, "sets of runs", "1 set of runs"),
        (1, "exact measurements", "1 exact measurement"), (1.0, "choices", "1 choice"),
        (2.5e9, "choices", "2.5 billion choices"), (9.26633e7, "choices", "92.7 million choices"),
        (123456.0, "choices", "123456 choices"), (2.5e17, "choices", "2.5e+17 choices"),
        (1, "looks at worst machines", "1 look at worst machines"), (1, "batches of machines", "1 batch of machines"),
    ],
)  # fmt: skip
def test_what_is_counted_once_is_said_in_the_singular(count: float, things: str, words: str) -> None:
    assert counted(count, things) == words


def test_a_time_limit_repeats_no_count() -> None:
    limit = TimeLimit(2.0, 0.0, "67 boxes")
    assert limit.added_to("stopped after 65 boxes") == "stopped after 65 boxes; the time limit of 2 s ended the search"
    assert limit.added_to("best") == "best; the time limit of 2 s ended the search after 67 boxes"


def test_what_users_call_a_thing_is_proposed_where_it_is_known() -> None:
    assert way_out("zeta", ["mass", "damping_ratio"]) == ' Did you mean "damping_ratio"?'
    assert way_out("zeta", ["mass", "speed"]) == " Known: mass, speed."


def test_a_part_of_a_bound_is_read_as_the_bound_and_the_answer_says_so() -> None:
    job: Any = open_job(PRESS, {"limits.floor_force.at_most": "-20 %"})
    assert job.limits["floor_force"].at_most.value == 8000.0
    assert job.notes[-1] == 'limits.floor_force.at_most: "-20 %" read as 8 kN, from 10 kN'
    found = whatif(open_job(PRESS), {"limits.floor_force.at_most": "+20 %"})
    assert dict(found.changes) == {"limits.floor_force.at_most": "12 kN"}


def test_a_percentage_with_a_sign_is_a_part_of_an_isolation_too() -> None:
    """The same part wherever it is asked; without a sign an isolation itself, and below zero that is a number."""
    path = "limits.isolation.at_least"
    isolation = '[limits.isolation]\nresponse = "isolation"\ninto = "ground"\nat_least = "60 %"\n'
    less = f'[scenarios.less]\n"{path}" = "-5 %"\n'
    job: Any = from_text(PRESS.read_text(encoding="utf-8") + isolation + less, "press")
    for said, value in (
        ("+5 %", 0.63),
        ("-5 %", 0.57),
        ("−5 %", 0.57),
        ("5 %", 0.05),
        ("-0.05", -0.05),
        (-0.05, -0.05),
    ):
        assert with_changes(job, {path: said}).limits["isolation"].at_least.value == pytest.approx(value, abs=1e-15)
    note = (
        f'{path}: "-5 %" read as 57 %, from 60 %; a sign makes it a part of that, and the value itself is written -0.05'
    )
    assert with_changes(job, {path: "-5 %"}).notes[-1] == note
    scenario: Any = variants_of(job)["less"]
    assert scenario.limits["isolation"].at_least.value == pytest.approx(0.57)
    assert dict(stepped(job, ("-5 %",)).rows)[path][0][0] == "57 %"
    varied = sweep(job, path, "-5 %..5 %", 3).points
    assert [point.value.value for point in varied] == pytest.approx([0.57, 0.6, 0.63])
    below = with_changes(job, {path: "-0.2"})
    assert with_changes(below, {path: "-50 %"}).limits["isolation"].at_least.value == pytest.approx(-0.1)


def test_a_value_below_zero_of_a_share_is_moved_in_numbers() -> None:
    """Studies write values into the file: with a sign before a % they would be parts of what the number is."""
    fact = FactAt("limits.isolation.at_least", -0.2, "%", "ratio")
    assert (fact.text(-0.2), fact.text(0.2), fact.now(0.5)) == (-0.2, "20 %", "-0.1")


def test_a_part_of_a_number_of_an_engine_is_read_and_told() -> None:
    found = answer(open_job(ROOT / "balancing" / "engine_share_capped.toml", {"engine.speed": "-10 %"}))
    assert found.notes[0] == 'engine.speed: "-10 %" read as 1350 rpm, from 1500 rpm'


@pytest.mark.parametrize(
    ("file", "path", "value", "words"),
    [
        (PRESS, "limits.floor_force.at_most", "20 %",
         'rao_9_34.toml: limits.floor_force.at_most = "20 %" may be a part of 10 kN in two ways. Write "+20 %" for '
         '12 kN, "-20 %" for 8 kN, "-80 %" for 2 kN.'),
        (PRESS, "links.mount.stiffness", "-5 %",
         'rao_9_34.toml: links.mount.stiffness = "-5 %" is a part of a number, and this one is chosen from a range. '
         "Write a value, or move an end of the range: --set links.mount.stiffness.to=..."),
    ],
)  # fmt: skip
def test_a_part_that_cannot_be_read_is_told_with_the_value(file: Path, path: str, value: str, words: str) -> None:
    assert refused(open_job, file, {path: value}).messages == (words,)


def test_a_number_alone_gets_a_tolerance_by_its_path() -> None:
    job: Any = open_job(PRESS, {"bodies.press.mass.tolerance": "5 %"})
    assert job.document["bodies"]["press"]["mass"] == {"value": "300 kg", "tolerance": "5 %"}
    assert refused(window, job).messages == (
        "rao_9_34.toml: window finds the tolerances that a design bears, and the file has tolerances already. Leave "
        'them out: --set bodies.press.mass.tolerance="0 %".',
    )
    assert window(with_changes(job, {"bodies.press.mass.tolerance": "0 %"})).spans


def test_a_variable_that_is_varied_is_held_at_each_value() -> None:
    """Each point is the answer with that value as a fact; a kept design is measured around it."""
    path, job = "links.mount.damping", open_job(PRESS)
    found = sweep(job, path, "15 kN s/m..21 kN s/m", 2)
    assert found.held
    for point, given in zip(found.points, ("15 kN s/m", "21 kN s/m"), strict=True):
        alone = answer(with_changes(job, {path: given}))
        assert (point.status, point.goal.value) == (alone.status, alone.goal[1].value)
    around = sweep(job, path, "-10 %..+10 %", 3, keep_design=True)
    chosen = answer(job).variables[path].value.value
    assert around.points[1].value.value == pytest.approx(chosen, rel=1e-11)
    assert [one.status for one in around.points][1] in ("met", "violated")


OTHER = {
    "spring": ("stiffness [N/mm]", "Federrate"), "load": ("rated load max [N]", "Traglast (N)"),
    "what": ("note;", "Farbe;"),
}  # fmt: skip


def renamed(folder: Path, columns: str) -> Path:
    """The compressor on the same parts under other headings, with `columns` of its part."""
    file = parts(folder, **OTHER)
    text = file.read_text(encoding="utf-8")
    old = 'catalogue = "mounts.csv" }'
    assert old in text
    file.write_text(text.replace(old, f'catalogue = "mounts.csv", columns = {columns} }}'), encoding="utf-8")
    return file


def test_a_catalogue_with_other_headings_is_read_by_the_names_that_the_file_gives(tmp_path: Path) -> None:
    columns = '{ stiffness = "Federrate [N/mm]", rated_load_max = "Traglast", note = ["Farbe"] }'
    other: Any = open_job(renamed(tmp_path, columns))
    plain: Any = open_job(COMPRESSOR)
    both = [one.links["feet"].part.parts for one in (other, plain)]
    assert both[0].names == both[1].names
    assert {key: one.tolist() for key, one in both[0].columns.items()} == {
        key: one.tolist() for key, one in both[1].columns.items()
    }


@pytest.mark.parametrize(
    ("columns", "words"),
    [
        ('{ stifness = "Federrate [N/mm]" }',
         'mounts.csv row 1: columns names "stifness", which is no column of a catalogue. Did you mean "stiffness"?'),
        ('{ note = "Farbton" }',
         'mounts.csv row 1: has no column "Farbton". It has "Farbe", "part", "rated load min [N]", "Traglast (N)", '
         '"Federrate", "shear stiffness [N/mm]", "static stiffness [N/mm]", "loss factor", "tolerance [%]", '
         '"price [EUR]".'),
        ("{ note = 3 }",
         'links.feet.part.columns = { note = 3 } is no table of headings. Write { stiffness = "Federrate [N/mm]", '
         'note = ["Farbe"] }.'),
    ],
)  # fmt: skip
def test_wrong_columns_are_told_with_those_of_the_file(columns: str, words: str, tmp_path: Path) -> None:
    assert f"slip.toml line 15: {words}" in said_of(renamed(tmp_path, columns))


def test_a_record_without_a_unit_is_offered_that_of_the_answer() -> None:
    found = answer(open_job(PRESS))
    row = compare(found, {"what": "sag", "path": "measures.sag.value", "value": 0.42})
    assert row.why == 'measures.sag.value = 0.42 has no unit. Write "0.42 mm".'
