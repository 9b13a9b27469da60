"""Scenarios of a file: each by itself, one design for all, and every limit moved."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import vibopt as vo
from refusals import refused
from vibopt.document.toml_reading import changed
from vibopt.jobs import open_job, scenarios_of
from vibopt.study.scenarios import one_for_all, stepped, variants_of

ROOT = Path(__file__).parents[2] / "problems"
Run = Callable[..., Any]
MORE = """
[scenarios.overload]
"excitations.press.amplitude" = "33 kN"

[scenarios.light]
bodies.press.mass = "270 kg"
limits.start_up.at_most = "22 mm"
"""
PUMP = """
title = "Pump"
[bodies.pump]
mass = {mass}
[links.spring]
between = ["pump", "ground"]
stiffness = "1 MN/m"
[limits.sag]
response = "static_deflection"
of = "spring"
at_most = "9 mm"
"""


@pytest.fixture
def press(tmp_path: Path) -> Path:
    text = (ROOT / "isolation" / "rao_9_34.toml").read_text(encoding="utf-8").partition("[[expected]]")[0]
    file = tmp_path / "press.toml"
    file.write_text(text + MORE, encoding="utf-8")
    return file


@pytest.mark.parametrize("path", ["scenarios.light.foo", "scenarios.light.bodies.press.mass", "scenarios.other.x"])
def test_a_scenario_is_not_changed_by_a_path(press: Path, path: str) -> None:
    """It was changed without a word, and the answer was that without it."""
    error = refused(vo.with_changes, open_job(press), {path: "260 kg"})
    assert str(error) == (
        f"press.toml: {path} is part of a scenario, and of no answer without it. "
        "Change the scenario in the file, or give the path behind its name."
    )


def test_a_scenario_is_its_changes(run: Run, press: Path) -> None:
    job = open_job(press)
    assert scenarios_of(job)["light"] == {"bodies.press.mass": "270 kg", "limits.start_up.at_most": "22 mm"}
    alone = vo.solve(vo.with_changes(job, {"excitations.press.amplitude": "33 kN"}))
    done = run("solve", str(press), "--scenario", "overload", "--json")
    assert done.data["goal"]["value"] == pytest.approx(alone.goal[1].value, rel=1e-12)
    again = run("solve", str(press), "--scenario", "overload", "--set", "excitations.press.amplitude=30 kN", "--json")
    assert again.data["goal"]["value"] == pytest.approx(vo.solve(job).goal[1].value, rel=1e-12)
    assert any("Scenarios of the file, overload, light, are no part of this answer" in one for one in job.notes)


def test_compare_sets_scenarios_beside_each_other(run: Run, press: Path) -> None:
    done = run("compare", str(press), "--scenarios", "--json")
    assert list(done.data["variants"]) == ["as it is", "overload", "light"]
    for name, job in variants_of(open_job(press)).items():
        assert done.data["variants"][name]["goal"]["value"] == pytest.approx(vo.solve(job).goal[1].value, rel=1e-12)


def test_one_design_keeps_every_limit_in_every_scenario_and_none_is_much_better(run: Run, press: Path) -> None:
    found = one_for_all(open_job(press))
    assert found.status == "optimal"
    values = {path: f"{one.value:.17g} {one.si}" for path, one in found.variables.items()}
    stiffness = "links.mount.stiffness"
    for name, job in variants_of(open_job(press)).items():
        document = dict(job.document)
        mount = {**document["links"]["mount"], **{path.rpartition(".")[2]: text for path, text in values.items()}}
        document |= {"links": {"mount": mount}}
        for key in ("goal", "scenarios"):
            document.pop(key, None)
        measured = vo.solve(vo.from_dict(document), explain=False)
        assert measured.status == "met", name
        assert {key: one.value.value for key, one in measured.limits.items()} == pytest.approx(
            {key: one.value.value for key, one in found.limits[name].items()}, rel=1e-9
        )
        alone = vo.solve(job, explain=False)
        assert found.goal is not None
        assert found.goal[1].value <= alone.goal[1].value * (1.0 + 1e-9)
    # stiffer is forbidden by the worst two together: each at this stiffness leaves no damping for both
    damping = []
    for job in variants_of(open_job(press)).values():
        stiffer = f"{found.variables[stiffness].value * (1.0 + 1e-5):.17g} N/m"
        ends = []
        for sense in ("minimise", "maximise"):
            goal = {sense: "damping", "of": "mount"}
            document = {**vo.with_changes(job, {stiffness: stiffer}).document, "goal": goal}
            document.pop("scenarios")
            answer = vo.solve(vo.from_dict(document), explain=False)
            ends.append(answer.variables["links.mount.damping"].value.value if answer.goal is not None else None)
        damping.append(ends)
    alone = any(None in one for one in damping)
    assert alone or max(low for low, _ in damping) > min(high for _, high in damping)


def test_without_one_design_the_limits_that_clash_are_named_with_their_scenario(run: Run, press: Path) -> None:
    press.write_text(press.read_text(encoding="utf-8").replace('"22 mm"', '"0.1 mm"'), encoding="utf-8")
    found = one_for_all(open_job(press))
    assert (found.status, found.limits) == ("infeasible", {})
    names = found.reason.partition(": ")[2].partition(".")[0].split(", ")
    assert "start_up in light" in names
    assert not {"start_up", "start_up in overload"} & set(names)  # wider, so they follow from it
    assert found.reason in " ".join(run("solve", str(press), "--all-scenarios").out.split())


def test_one_for_all_on_the_command_line(run: Run, press: Path) -> None:
    done = run("solve", str(press), "--all-scenarios")
    assert (done.code, done.err) == (0, "")
    assert "optimal: stiffness is " in done.out
    assert " in the worst of all scenarios" in done.out
    assert "overload" in done.out
    for option in ("--round=3", "--no-prices", "--force", "--fewest-planes"):
        assert run("solve", str(press), "--all-scenarios", option).err == (
            "--all-scenarios goes with --set, --save, --time-limit, --json and --require-proof alone. Leave the other "
            "options out.\n"
        )


FOOTBRIDGE = """
[bodies.deck]
mass = "40 t"
[links.girder]
between = ["deck", "ground"]
stiffness = "6.3 MN/m"
damping = "8 kN s/m"
[absorbers.tmd]
on = "deck"
mass_ratio = 0.02
tuning = { from = 0.8, to = 1.1 }
damping_ratio = { from = 0.05, to = 0.3 }
[excitations.walkers]
kind = "force"
on = "deck"
amplitude = "600 N"
speed = "1.6..2.4 Hz"
varies = "constant"
[limits.sway]
response = "displacement"
of = "deck"
at_most = "2 mm"
[goal]
minimise = "acceleration"
of = "deck"
[scenarios.crowd]
"bodies.deck.mass" = "48 t"
[scenarios.run]
"excitations.walkers.amplitude" = "500 N"
"""
FILES = {
    "machine": "isolation/rao_9_34.toml", "rotor": "balancing/foiles_min_max_capped.toml",
    "known": "balancing/rao_9_14_b_capped.toml", "engine": "balancing/engine_share_capped.toml",
}  # fmt: skip
OTHERWISE = {
    "machine": '"excitations.press.amplitude" = "33 kN"', "rotor": '"runs.1.readings.r1" = "57 µm @ 250 deg"',
    "known": '"shaft.speed" = "1400 rpm"', "engine": '"engine.speed" = "1400 rpm"',
}  # fmt: skip


def of_all(variants: dict[str, Any]) -> dict[str, dict[str, float]]:
    """Every limit and measure of each variant measured by itself."""
    found = {name: vo.solve(job, explain=False) for name, job in variants.items()}
    return {
        name: {key: row.value.value for key, row in {**one.limits, **one.measures}.items()}
        for name, one in found.items()
    }


def test_an_absorber_is_the_same_one_in_every_scenario(run: Run, file: Callable[[str], str], tmp_path: Path) -> None:
    """Its tuning refers to the deck as the file is: with a crowd on the deck no spring is exchanged."""
    saved = tmp_path / "saved.toml"
    done = run("solve", file(FOOTBRIDGE), "--all-scenarios", "--json", "--save", str(saved))
    assert (done.code, done.data["status"], done.data["written"]) == (0, "optimal", [str(saved)])
    kept = of_all(variants_of(open_job(saved)))
    for name, rows in done.data["scenarios"].items():
        assert kept[name]["sway"] == pytest.approx(rows["limits"]["sway"]["value"], rel=1e-9)
    worst = max(one["minimised"] for one in kept.values())
    assert worst == pytest.approx(done.data["goal"]["value"], rel=1e-9)
    absorber = tomllib.loads(saved.read_text(encoding="utf-8"))["absorbers"]["tmd"]
    stiffness, damping = (float(absorber[key].split()[0]) for key in ("stiffness", "damping"))
    for factor in (0.99, 1.01):  # nothing near is better in the worst of all scenarios
        for changes in ({"stiffness": f"{factor * stiffness} N/m"}, {"damping": f"{factor * damping} N s/m"}):
            other = {f"absorbers.tmd.{key}": text for key, text in changes.items()}
            again = of_all(variants_of(vo.with_changes(open_job(saved), other)))
            assert max(one["minimised"] for one in again.values()) > worst


def test_what_no_part_can_be_the_same_for_is_refused(file: Callable[[str], str]) -> None:
    text = FOOTBRIDGE.replace('damping = "8 kN s/m"', 'damping = "8 kN s/m"\ncount = 2')
    job = open_job(file(text.replace('"bodies.deck.mass" = "48 t"', '"links.girder.count" = 3')))
    assert str(refused(one_for_all, job)) == (
        "mine.toml: scenario crowd changes links.girder.count, which mass_ratio, tuning and damping_ratio of "
        "absorbers.tmd refer to: it would be another part in each scenario. Write its mass, frequency and damping."
    )


@pytest.mark.parametrize("kind", FILES)
def test_one_design_for_all_is_saved_with_the_scenarios_that_it_was_made_for(
    run: Run, file: Callable[[str], str], tmp_path: Path, kind: str
) -> None:
    """Solved again as it is and in each scenario it measures what was told."""
    text = (ROOT / FILES[kind]).read_text(encoding="utf-8").partition("[[expected]]")[0]
    path, saved = file(f"{text}[scenarios.other]\n{OTHERWISE[kind]}\n"), tmp_path / "saved.toml"
    done = run("solve", path, "--all-scenarios", "--json", "--save", str(saved))
    assert (done.code, done.data["written"]) == (0, [str(saved)])
    again = {name: vo.solve(job, explain=False) for name, job in variants_of(open_job(saved)).items()}
    for name, rows in done.data["scenarios"].items():
        assert again[name].status == "met"
        assert rows["limits"] or kind in ("rotor", "known")  # there the goal alone is told
        for key, row in rows["limits"].items():
            assert again[name].limits[key].value.value == pytest.approx(row["value"], rel=1e-9)
    assert run("solve", path, "--all-scenarios", "--save", str(saved)).out.endswith(f"Written: {saved}\n")


def test_where_there_is_no_one_design_none_is_saved(run: Run, press: Path, tmp_path: Path) -> None:
    press.write_text(press.read_text(encoding="utf-8").replace('"22 mm"', '"0.1 mm"'), encoding="utf-8")
    done = run("solve", str(press), "--all-scenarios", "--save", str(tmp_path / "saved.toml"))
    assert (done.code, done.err) == (
        3, "press.toml: there is no design to save: infeasible. saved.toml is not written.\n",
    )  # fmt: skip
    assert not (tmp_path / "saved.toml").exists()


def test_a_time_limit_ends_the_search_for_one_design_and_is_told(run: Run, file: Callable[[str], str]) -> None:
    text = (ROOT / "mounts" / "generator_set.toml").read_text(encoding="utf-8").partition("[[expected]]")[0]
    name = file(f'{text}[scenarios.heavy]\n"bodies.genset.mass" = "1900 kg"\n')
    ended = run("solve", name, "--all-scenarios", "--time-limit", "1e-9", "--json").data
    assert (ended["status"], ended["proven"]) == ("feasible", False)
    assert "the time limit of 1e-09 s ended the search after" in ended["claim"]


@pytest.mark.parametrize("file", ["isolation/rao_9_34.toml", "balancing/engine_share_capped.toml"])
def test_every_limit_moved_is_the_answer_with_that_bound(file: str) -> None:
    job = vo.read(ROOT / file)
    found = stepped(job, ("-10 %", "+20 %"))
    assert [path for path, _ in found.rows] == [f"limits.{name}.at_most" for name in job.document["limits"]]
    for path, cells in found.rows:
        for bound, status, goal in cells:
            alone = vo.solve(vo.with_changes(job, {path: bound}), explain=False)
            assert alone.status == status
            assert (goal is None) == (alone.goal is None or alone.exit_code != 0)
            if goal is not None and alone.goal is not None:
                assert goal.value == pytest.approx(alone.goal[1].value, rel=1e-9)


def test_limits_moved_on_the_command_line(run: Run, press: Path, tmp_path: Path) -> None:
    table = tmp_path / "limits.csv"
    done = run("compare", str(press), "--limits", "-20 %, +20 %", "--csv", str(table))
    assert (done.code, done.err) == (0, "")
    assert "start_up     16 mm pk: " in done.out  # one bound goes by its name
    assert len(table.read_text(encoding="utf-8").splitlines()) == 7


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('[scenarios.same]\n"limits.start_up.at_most" = "20 mm"\n',
         "scenarios.same changes nothing: the file says all of it already. Leave it out."),
        ('[scenarios.same]\nbodies.press.mass = "0.3 t"\n"limits.start_up.at_most" = "0.02 m pk"\n',
         "scenarios.same changes nothing: the file says all of it already. Leave it out."),
        ("[scenarios.none]\n",
         'scenarios.none changes nothing. Write changes by path below it: "limits.start_up.at_most" = "25 mm".'),
        ('[scenarios.lost]\n"limits.startup.at_most" = "25 mm"\n', "scenarios.lost: "),
        ("scenarios = 3\n", "scenarios"),
    ],
    ids=["same", "same in other units", "none", "lost", "number"],
)  # fmt: skip
def test_a_scenario_that_says_nothing_is_refused(tmp_path: Path, text: str, words: str) -> None:
    base = (ROOT / "isolation" / "rao_9_34.toml").read_text(encoding="utf-8").partition("[[expected]]")[0]
    file = tmp_path / "press.toml"
    file.write_text(text + base if text.startswith("scenarios") else base + text, encoding="utf-8")
    assert words in str(refused(open_job, file))


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("solve", "FILE", "--scenario", "overlaod"),
         'press.toml: there is no scenario "overlaod". Did you mean "overload"?\n'),
        (("compare", "FILE", "--limits", "20"),
         '--limits "20" is no part of a bound. Write --limits "-20 %, +20 %".\n'),
        (("compare", "FILE", "FILE2", "--scenarios"),
         "--scenarios and --limits are for one file, each by itself. Name one file, and one of them.\n"),
    ],
)  # fmt: skip
def test_what_is_no_scenario_is_said(run: Run, press: Path, words: tuple[str, ...], said: str) -> None:
    other = press.with_name("other.toml")
    other.write_bytes(press.read_bytes())
    names = {"FILE": str(press), "FILE2": str(other)}
    done = run(*(names.get(one, one) for one in words))
    assert (done.code, done.err) == (2, said)


SHELF = """\
part;rated load max [N];stiffness [N/mm];loss factor;tolerance [%];price [EUR]
A;1800;470;0.1;10;18
B;1800;255;0.1;;26
"""
BOUGHT = """
[bodies.pump]
mass = {}
[links.feet]
between = ["pump", "ground"]
part = {{ catalogue = "shelf.csv" }}
count = {{ from = 4, to = 8, whole = true }}{}
[excitations.shaft]
kind = "unbalance"
on = "pump"
unbalance = "0.09 kg m"
speed = "970 rpm"
[limits.floor]
response = "transmitted_force"
into = "ground"
at_most = "2 kN"
[goal]
minimise = "price"
[scenarios.more]
"excitations.shaft.unbalance" = "0.1 kg m"
"""
NONE = '\ntolerance = "0 %"'


@pytest.mark.parametrize(
    ("mass", "feet", "way"),
    [
        ('"620 kg"', "", 'Write tolerance = "0 %" into links.feet, in place of the catalogue\'s'),
        ('{ value = "620 kg", tolerance = "5 %" }', NONE, "Leave the tolerances out"),
        ('{ value = "620 kg", tolerance = "5 %" }', "",
         'Leave the tolerances out and write tolerance = "0 %" into links.feet, in place of the catalogue\'s'),
        ('"620 kg"', NONE, ""),
    ],
)  # fmt: skip
def test_one_design_for_all_says_where_tolerances_are_left_out(tmp_path: Path, mass: str, feet: str, way: str) -> None:
    (tmp_path / "shelf.csv").write_text(SHELF, encoding="utf-8")
    file = tmp_path / "pump.toml"
    file.write_text(BOUGHT.format(mass, feet), encoding="utf-8")
    if not way:
        assert one_for_all(open_job(file)).status == "optimal"
        return
    assert str(refused(one_for_all, open_job(file))) == (
        "pump.toml: one design for all scenarios does not go with tolerances: each scenario has a worst machine of its "
        f"own. {way}, or vibopt compare FILE --scenarios."
    )


@pytest.mark.parametrize("file", ["fan_verification_run.toml", "rao_9_3.toml", "engine_share_capped.toml"])
def test_jobs_of_every_kind_have_scenarios(tmp_path: Path, file: str) -> None:
    text = (ROOT / "balancing" / file).read_text(encoding="utf-8").partition("[[expected]]")[0]
    job = vo.read(ROOT / "balancing" / file)
    from vibopt.jobs import facts

    fact = next(one for one in facts(job) if one.value and not one.place and one.unit)
    target = tmp_path / file
    target.write_text(f'{text}\n[scenarios.more]\n"{fact.path}" = "{fact.now(1.1)}"\n', encoding="utf-8")
    for csv in (ROOT / "balancing").glob("*.csv"):
        (tmp_path / csv.name).write_bytes(csv.read_bytes())
    variants = variants_of(open_job(target))
    assert list(variants) == ["as it is", "more"]
    assert vo.compare(variants).names == ("as it is", "more")


@pytest.mark.parametrize(
    ("given", "changes", "mass", "tolerance"),
    [
        ('{ value = "300 kg", tolerance = "5 %" }', "270 kg", 270.0, 0.05),
        ('{ value = "300 kg", tolerance = "5 %" }', "-10 %", 270.0, 0.05),
        ('{ value = "300 kg", tolerance = { normal = "1 %" } }', "270 kg", 270.0, 0.03),
        ('{ value = "300 kg", tolerance = "5 %" }', {"value": "270 kg", "tolerance": "2 %"}, 270.0, 0.02),
        ('{ value = "300 kg", tolerance = "5 %" }', {"value": "270 kg", "tolerance": "0 %"}, 270.0, 0.0),
        ('"300 kg"', "270 kg", 270.0, 0.0),
    ],
)
def test_a_number_that_is_changed_keeps_its_tolerance(given: str, changes: Any, mass: float, tolerance: float) -> None:
    """Unless the change says another: the worst machine is no lighter than its tolerance makes it."""
    text = PUMP.format(mass=given)
    for how in (vo.with_changes(vo.from_text(text), {"bodies.pump.mass": changes}), None):
        if how is None and isinstance(changes, str):
            scenario = f'{text}[scenarios.light]\nbodies.pump.mass = "{changes}"\n'
            job = vo.from_text(scenario)
            how = vo.with_changes(job, scenarios_of(job)["light"])
        if how is not None:
            found = vo.solve(how)
            assert found.limits["sag"].value.value == pytest.approx(mass * (1.0 + tolerance) * 9.80665 / 1e6, rel=1e-9)
            assert (found.tolerances is not None) == (tolerance > 0.0)


def test_a_variable_that_is_fixed_keeps_its_tolerance() -> None:
    spring = {"from": "0.5 MN/m", "to": "5 MN/m", "tolerance": "10 %"}
    fixed = changed({"links": {"spring": {"stiffness": spring}}}, {"links.spring.stiffness": "1 MN/m"})
    assert fixed["links"]["spring"]["stiffness"] == {"value": "1 MN/m", "tolerance": "10 %"}
    again = changed(fixed, {"links.spring.stiffness": {"from": "1 MN/m", "to": "2 MN/m"}})
    assert again["links"]["spring"]["stiffness"] == {"from": "1 MN/m", "to": "2 MN/m"}


def test_one_for_all_as_json_has_the_shape_of_an_answer(run: Run, press: Path) -> None:
    said = run("solve", str(press), "--all-scenarios", "--json").data
    plain = run("solve", str(press), "--json").data
    assert said.keys() - plain.keys() == {"scenarios"}
    assert said["goal"].keys() == plain["goal"].keys()
    assert {key: said[key] for key in ("schema", "kind", "name", "title", "proven")} == {
        key: plain[key] for key in ("schema", "kind", "name", "title", "proven")
    }
    assert said["variables"].keys() == plain["variables"].keys()
    assert list(said["scenarios"]) == ["as it is", "overload", "light"]
    for name, row in said["limits"].items():
        assert row.keys() == plain["limits"][name].keys()
        rows = [one["limits"][name] for one in said["scenarios"].values()]
        assert row in rows
        assert row["margin"] == min(one["margin"] for one in rows)


def test_a_goal_of_several_words_is_told_in_words(run: Run, press: Path) -> None:
    text = press.read_text(encoding="utf-8")
    goal = '[goal]\nminimise = "transmitted_force"\ninto = "ground"\n'
    press.write_text(re.sub(r"(?s)\[goal\].*?\n(?=\[|$)", goal, text, count=1), encoding="utf-8")
    assert "transmitted force is " in run("solve", str(press), "--all-scenarios").out


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('"bodies.nope.mass" = "3 kg"\n',
         'scenarios.odd: --set bodies.nope.mass: there is no "nope" in this file. Known: press.'),
        ('"bodies.press.mass" = "0.3 t"\n',
         "scenarios.odd changes nothing: the file says all of it already. Leave it out."),
        ("", 'scenarios.odd changes nothing. Write changes by path below it: "limits.start_up.at_most" = "25 mm".'),
    ],
)  # fmt: skip
def test_a_scenario_is_tried_whichever_way_the_job_is_read(text: str, words: str, tmp_path: Path) -> None:
    whole = (ROOT / "isolation" / "rao_9_34.toml").read_text(encoding="utf-8").partition("[[expected]]")[0]
    whole += f"\n[scenarios.odd]\n{text}"
    file = tmp_path / "job.toml"
    file.write_text(whole, encoding="utf-8")
    for read, given in ((vo.read, file), (vo.from_text, whole), (vo.from_dict, tomllib.loads(whole))):
        assert words in str(refused(read, given))


def test_a_saved_design_leaves_out_what_scenarios_change_of_a_range_and_is_read_again(run: Run, press: Path) -> None:
    ranged = '\n[scenarios.soft]\n"links.mount.stiffness.to" = "3 MN/m"\n"bodies.press.mass" = "270 kg"\n'
    stiff = '[scenarios.stiff]\n"links.mount.stiffness.to" = "2 MN/m"\n'
    press.write_text(press.read_text(encoding="utf-8") + ranged + stiff, encoding="utf-8")
    saved = press.parent / "saved.toml"
    assert run("solve", str(press), "--save", str(saved)).code == 0
    words = saved.read_text(encoding="utf-8")
    said = "links.mount.stiffness.to of soft, links.mount.stiffness.to of stiff"
    assert f"# Left out of the scenarios, for it has no place in a design or changes nothing: {said}.\n" in words
    assert scenarios_of(open_job(saved)) == {
        "overload": {"excitations.press.amplitude": "33 kN"},
        "light": {"bodies.press.mass": "270 kg", "limits.start_up.at_most": "22 mm"},
        "soft": {"bodies.press.mass": "270 kg"},
    }


def test_limits_that_parts_cannot_move_are_named(run: Run, press: Path) -> None:
    outside = '\n[limits.resonance]\nresponse = "natural_frequency"\noutside = "200..300 Hz"\n'
    press.write_text(press.read_text(encoding="utf-8") + outside, encoding="utf-8")
    words = "Not moved: resonance. Only at_most and at_least that are above zero and no level in dB are moved by parts."
    assert words in " ".join(run("compare", str(press), "--limits", "-20 %").out.split())
    assert stepped(open_job(press), ("-20 %",)).to_json()["notes"] == [words]


def test_bounds_that_are_moved_have_the_digits_of_any_other(run: Run, press: Path) -> None:
    level = (
        '\n[limits.level]\nresponse = "transmissibility"\ninto = "ground"\nover = "0..3000 rpm"\nat_most = "14 dB"\n'
    )
    press.write_text(press.read_text(encoding="utf-8") + level, encoding="utf-8")
    assert "13.55 dB: " in run("compare", str(press), "--limits", "-5 %").out


def test_a_bound_that_no_file_may_ask_leaves_the_others_of_the_table(run: Run, press: Path) -> None:
    isolation = '\n[limits.isolation]\nresponse = "isolation"\ninto = "ground"\nat_least = "60 %"\n'
    press.write_text(press.read_text(encoding="utf-8") + isolation, encoding="utf-8")
    done = run("compare", str(press), "--limits", "-20 %, +70 %")
    assert (done.code, done.err) == (0, "")
    assert "102 %: not asked" in done.out
    why = 'limits.isolation.at_least = "102 %" is as much as nothing coming through, or more. Write less than 100 %.'
    assert f"Not asked: {why}" in " ".join(done.out.split())
    rows = dict(stepped(open_job(press), ("-20 %", "+70 %")).rows)
    assert [(bound, status) for bound, status, _ in rows["limits.isolation.at_least"]] == [
        ("48 %", "optimal"), ("102 %", "refused"),
    ]  # fmt: skip
    assert [status for _, status, _ in rows["limits.floor_force.at_most"]] == ["optimal", "optimal"]


@pytest.mark.parametrize(
    ("vary", "words"),
    [
        ("start_up=1 mm..2 mm", 'there is no fact called start_up. Did you mean "limits.start_up.at_most"?'),
        (
            "limits.start_up.at_most=-20..20 %",
            '--vary limits.start_up.at_most="-20..20 %": each part needs its %. Write "-20 %..+20 %".',
        ),
    ],
)
def test_what_is_varied_by_half_a_path_or_half_a_part_is_told_in_full(
    run: Run, press: Path, vary: str, words: str
) -> None:
    done = run("sweep", str(press), "--vary", vary)
    assert done.code == 2
    assert words in done.err
    whole = "limits.start_up.at_most=" + (words.partition('Write "')[2].removesuffix('".') or "18 mm..22 mm")
    assert run("sweep", str(press), "--vary", whole, "--points", "2").code == 0


def test_a_normal_tolerance_in_a_unit_is_told_as_such(tmp_path: Path) -> None:
    file = tmp_path / "pump.toml"
    file.write_text(PUMP.format(mass='{ value = "300 kg", tolerance = { normal = "10 kg" } }'), encoding="utf-8")
    (said,) = refused(open_job, file).messages
    words = 'has a normal tolerance of "10 kg", which is no ratio. Write { normal = "2 %" } for a standard deviation, '
    assert words in said


@pytest.mark.parametrize(
    ("file", "said"),
    [
        ("isolation/rao_9_28.toml", "bodies."),
        ("balancing/feese_two_planes.toml", ""),
        ("balancing/rao_9_14_b.toml", ""),
        ("balancing/engine_share_capped.toml", "engine."),
    ],
)
def test_a_file_without_scenarios_is_told_one_of_its_own(run: Run, file: str, said: str) -> None:
    """The line that is proposed is one that the file takes."""
    done = run("compare", f"problems/{file}", "--scenarios")
    path, value = re.findall(r'"([^"]*)"', done.err)[:2]
    assert (done.code, path.startswith(said)) == (2, True), done.err
    job = open_job(Path("problems") / file)
    assert vo.to_toml(vo.with_changes(job, {path: value})) != vo.to_toml(job)


def test_a_job_without_bounds_is_told_what_moves_its_other_numbers(run: Run) -> None:
    fan = ROOT / "balancing" / "fan_verification_run.toml"
    assert " ".join(run("compare", str(fan), "--limits", "-10 %").err.split()) == (
        "fan_verification_run.toml: has no limits with a bound to move. Add [limits.NAME] with an at_most. What caps "
        "and facts buy says vibopt whatif FILE."
    )
