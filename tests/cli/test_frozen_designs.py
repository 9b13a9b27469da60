"""Designs that are saved, rounded, kept and compared on the command line."""

import csv
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

Run = Callable[..., Any]
ROOT = Path(__file__).parents[2]
GENSET = str(ROOT / "problems" / "mounts" / "genset_front_and_rear.toml")
ROTOR = str(ROOT / "problems" / "balancing" / "rao_9_3.toml")


@pytest.fixture
def genset(run: Run, tmp_path: Path) -> str:
    """A saved design with bought mounts, in a folder of its own."""
    folder = tmp_path / "jobs"
    folder.mkdir()
    target = folder / "genset.toml"
    done = run("solve", GENSET, "--no-prices", "--save", str(target))
    assert (done.code, done.out.splitlines()[-1]) == (0, f"Written: {target}")
    return str(target)


def test_a_saved_design_goes_through_every_verb(run: Run, genset: str, tmp_path: Path) -> None:
    assert run("check", genset).code == 0
    data = run("solve", genset, "--json").data
    assert (data["status"], data["variables"]) == ("met", {})
    assert data["measures"]["minimised"]["shown"] == "167.2 EUR"
    heavy = run("whatif", genset, "--set", "bodies.genset.mass=2100 kg")
    assert heavy.code == 7
    assert "rear: rated load" in heavy.out
    assert run("sweep", genset, "--vary", "bodies.genset.mass=1800 kg..1900 kg", "--points", "2").code == 0
    assert run("plot", genset, "-o", str(tmp_path / "x.svg")).code == 0
    assert run("report", genset, "-o", str(tmp_path / "x.html")).code == 0
    assert run("explain", genset).code == 0


def test_no_file_is_written_where_there_is_no_design(run: Run, press: str, tmp_path: Path) -> None:
    target = tmp_path / "x.toml"
    done = run("solve", press, "--set", "limits.start_up.at_most=5 mm", "--save", str(target))
    assert done.code == 3
    assert done.err.strip() == "rao_9_34.toml: there is no design to save: infeasible. x.toml is not written."
    assert not target.exists()
    data = run("solve", press, "--set", "limits.start_up.at_most=5 mm", "--save", str(target), "--json").data
    assert (data["status"], data["written"]) == ("infeasible", [])
    assert data["messages"] == ["rao_9_34.toml: there is no design to save: infeasible. x.toml is not written."]


@pytest.mark.parametrize("asked", ["0", "-1", "1.5", "0 N/m", "links.mount.stiffness=-1 kN/m"])
@pytest.mark.parametrize("words", [("solve",), ("whatif", "--keep-design"), ("report", "--sheet", "-o", "x.html")])
def test_what_is_no_rounding_is_refused_before_anything_is_solved(
    run: Run, press: str, words: tuple[str, ...], asked: str
) -> None:
    """Where no design keeps the limits, too."""
    done = run(words[0], press, "--set", "limits.start_up.at_most=5 mm", *words[1:], f"--round={asked}")
    text = (
        f"--round {asked}: is neither a number of digits from 1 to 12 nor a step. Write --round 3, or a step with its "
        'unit, "0.5 g".'
        if asked[-1].isdigit()
        else f'--round {asked}: a step is greater than zero. Write one with its unit, "0.5 g".'
    )
    assert (done.code, done.err.strip()) == (2, text)


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (("--save", "x.txt"), "x.txt cannot be written: its ending tells the format, and it is none of .toml."),
        (("--round", "x"), "--round x: is neither a number of digits from 1 to 12 nor a step. Write --round 3, or "),
    ],
)
def test_what_cannot_be_saved_or_rounded_is_an_input_error(
    run: Run, press: str, words: tuple[str, ...], text: str
) -> None:
    done = run("solve", press, *words)
    assert done.code == 2
    assert done.err.startswith(text)


def test_the_problem_file_itself_is_never_written_over(run: Run, file: Callable[[str], str], press: str) -> None:
    mine = file(Path(press).read_text(encoding="utf-8"))
    done = run("solve", mine, "--save", mine)
    assert done.code == 2
    assert done.err.strip() == f"{mine} cannot be written: it is read in this run. Name another file."
    assert Path(mine).read_text(encoding="utf-8") == Path(press).read_text(encoding="utf-8")


def test_an_analysis_is_saved_with_its_changes(run: Run, press: str, tmp_path: Path) -> None:
    first, second = tmp_path / "a.toml", tmp_path / "b.toml"
    run("solve", press, "--round", "3", "--save", str(first))
    done = run("solve", str(first), "--set", "links.mount.stiffness=6 MN/m", "--save", str(second))
    assert (done.code, done.out.splitlines()[-1]) == (7, f"Written: {second}")
    assert 'stiffness = "6 MN/m"' in second.read_text(encoding="utf-8")
    assert second.read_text(encoding="utf-8").startswith(
        "# Design of a.toml with links.mount.stiffness=6 MN/m, saved by vibopt: nothing is left to choose.\n"
    )


def test_rounded_values_stand_beside_the_exact_ones(run: Run, press: str, tmp_path: Path) -> None:
    target = tmp_path / "drawn.toml"
    done = run("solve", press, "--round", "3", "--save", str(target))
    assert done.code == 0
    assert done.out.splitlines()[1].startswith("feasible: stiffness of mount is 6950 kN/m with rounded values;")
    assert "  links.mount.stiffness  6957 kN/m   6950 kN/m\n" in done.out
    assert "  goal: stiffness        6957 kN/m   6950 kN/m\n" in done.out
    assert 'stiffness = "6950 kN/m"\ndamping = "9920 N s/m"\n' in target.read_text(encoding="utf-8")
    data = run("solve", press, "--round", "3", "--json").data
    assert data["status"] == "feasible"
    assert data["details"]["rounded"]["exact"]["status"] == "optimal"
    assert data["details"]["rounded"]["worse_by"] == pytest.approx(0.00099429, rel=1e-4)
    assert data["variables"]["links.mount.stiffness"]["shown"] == "6950 kN/m"
    proof = run("solve", press, "--round", "3", "--require-proof")
    assert (proof.code, proof.err.strip()) == (5, "feasible is not proven, and --require-proof was asked for.")


def test_a_step_of_its_own_for_one_value(run: Run, press: str) -> None:
    data = run("solve", press, "--round", "links.mount.stiffness=100 kN/m", "--json").data
    assert data["variables"]["links.mount.stiffness"]["value"] % 1e5 == 0.0
    assert list(data["details"]["rounded"]["values"]) == ["links.mount.stiffness"]


ENGINE = """title = "One cylinder, two counterweights"
[engine]
stroke = "86 mm"
rod = "140 mm"
speed = "1500 rpm"
reciprocating = "0.78 kg"
[[cylinders]]
crank = "300 deg"
[counterweights.front]
at = "-40 mm"
unbalance = { from = "0 g mm", to = "8000 g mm" }
[counterweights.rear]
at = "100 mm"
unbalance = { from = "0 g mm", to = "8000 g mm" }
[goal]
minimise = "force"
order = %d
"""


@pytest.mark.parametrize("order", [1, 4])
def test_rounded_weights_of_an_engine_are_saved_also_where_none_is_best(run: Run, tmp_path: Path, order: int) -> None:
    """Against the fourth order no counterweight helps: both are 0 g mm, and that can be written."""
    file, target = tmp_path / "engine.toml", tmp_path / "drawn.toml"
    file.write_text(ENGINE % order, encoding="utf-8")
    done = run("solve", str(file), "--round", "2", "--save", str(target))
    assert (done.code, done.out.splitlines()[-1]) == (0, f"Written: {target}")
    assert ('unbalance = "0 g mm"' in target.read_text(encoding="utf-8")) == (order == 4)
    left = run("solve", str(file), "--round", "2", "--json").data["goal"]["value"]
    again = run("solve", str(target), "--json").data
    assert (again["status"], again["measures"]["minimised"]["value"]) == ("met", left)


def test_jobs_of_two_kinds_are_not_compared(run: Run, press: str) -> None:
    done = run("compare", press, ROTOR)
    name = Path(press).stem
    assert (done.code, done.err.strip()) == (
        2,
        f"{name} is a machine and rao_9_3 is a shaft with known masses: what is measured on one does not exist on "
        "another. Compare jobs of one kind.",
    )


def test_whatif_rounds_only_what_is_kept(run: Run, press: str) -> None:
    done = run("whatif", press, "--set", "bodies.press.mass=301 kg", "--round", "3")
    assert done.code == 2
    assert done.err.strip() == (
        "--round goes with --keep-design: what is chosen anew has no rounded values to keep. Add it."
    )
    kept = run("whatif", press, "--set", "bodies.press.mass=300.2 kg", "--round", "3", "--keep-design")
    assert kept.code == 0
    assert "  maximised    6950 kN/m                6950 kN/m\n" in kept.out
    assert "The first crossing is exact to the last" in kept.out


def test_whatif_says_where_there_is_no_room(run: Run, press: str) -> None:
    done = run("whatif", press, "--set", "limits.amplitude.at_most=2 mm", "--keep-design")
    assert done.code == 0
    assert "  bodies.press.mass            300 kg      at once        at once\n" in done.out


def test_variants_stand_in_one_table(run: Run, press: str, tmp_path: Path) -> None:
    drawn, table = tmp_path / "drawn.toml", tmp_path / "t.csv"
    run("solve", press, "--round", "2", "--save", str(drawn))
    done = run("compare", press, str(drawn), "--csv", str(table))
    assert done.code == 0
    assert done.out.splitlines()[0].split() == ["rao_9_34", "drawn"]
    (line,) = (one for one in done.out.splitlines() if one.startswith("links.mount.stiffness"))
    assert line.split() == ["links.mount.stiffness", "6957", "kN/m", "6900", "kN/m"]
    assert done.out.endswith(f"* best of its row; of a limit, the most room.\nWritten: {table}\n")
    rows = {row["row"]: row for row in csv.DictReader(table.read_text().splitlines())}
    assert float(rows["links.mount.stiffness"]["drawn"]) == 6.9e6
    assert rows["verdict"]["rao_9_34"] == "optimal"
    assert float(rows["margin of floor_force"]["drawn"]) > 0.0
    data = run("compare", press, str(drawn), "--json").data
    assert set(data["variants"]) == {"rao_9_34", "drawn"}
    (goal,) = (row for row in data["rows"] if row["kind"] == "goal")
    assert [cell["best"] for cell in goal["cells"]] == [True, False]


def test_variants_that_all_fail_say_why(run: Run, press: str, tmp_path: Path) -> None:
    drawn = tmp_path / "drawn.toml"
    run("solve", press, "--round", "2", "--save", str(drawn))
    done = run("compare", str(drawn), press, "--set", "limits.start_up.at_most=5 mm")
    assert done.code == 7
    assert "drawn: breaks start_up\n" in done.out
    assert "rao_9_34: cannot hold together: floor_force, start_up\n" in done.out


def test_mistakes_of_all_variants_are_said_together(run: Run, press: str, tmp_path: Path) -> None:
    done = run("compare", press, str(tmp_path / "no.toml"), "--set", "limits.nope.at_most=5 mm")
    assert done.code == 2
    assert done.err.splitlines() == [
        f'{press}: --set limits.nope.at_most: there is no "nope" in this file. Known: floor_force, amplitude, '
        "start_up.",
        f"{tmp_path / 'no.toml'} is not there. Name an existing problem file (.toml).",
    ]
    one = run("compare", press)
    assert one.err.strip() == "compare needs at least two variants. Name two problem files or saved designs."
    twice = run("compare", press, press)
    assert twice.err.strip() == f"{press} is named twice. Name each variant once."


def test_every_answer_of_compare_is_strict_json(run: Run, press: str, tmp_path: Path) -> None:
    undamped = tmp_path / "undamped.toml"
    drawn = tmp_path / "drawn.toml"
    run("solve", press, "--round", "2", "--save", str(drawn))
    text = drawn.read_text(encoding="utf-8").replace('damping = "10000 N s/m"\n', "")
    undamped.write_text(
        "\n".join(line for line in text.splitlines() if not line.startswith("damping")), encoding="utf-8"
    )
    done = run("compare", str(drawn), str(undamped), "--json")
    assert json.loads(done.out)["variants"]["undamped"]["limits"]["start_up"]["value"] == "infinite"


def test_thresholds_over_tolerances_say_what_they_count(run: Run) -> None:
    rubber = str(ROOT / "problems" / "isolation" / "press_on_rubber.toml")
    done = run("whatif", rubber, "--set", "limits.floor_force.at_most=11 kN", "--keep-design")
    assert done.code == 0
    assert done.out.endswith("Over the tolerances each value counts for the worst machine that was found.\n")
