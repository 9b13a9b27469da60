"""Every verb on one job of each kind, a machine, a measured rotor, known masses and an engine, typed and in Python."""

from __future__ import annotations

from collections.abc import Callable
from math import isclose, pi
from pathlib import Path
from typing import Any

import pytest

import vibopt as vo
from vibopt import jobs
from vibopt.answer.entry import Entry

Run = Callable[..., Any]
PROBLEMS = Path(__file__).parents[2] / "problems"
FILES = {
    "machine": PROBLEMS / "isolation" / "rao_9_34.toml",
    "rotor": PROBLEMS / "balancing" / "fan_verification_run.toml",
    "known": PROBLEMS / "balancing" / "rao_9_14_b_capped.toml",
    "engine": PROBLEMS / "balancing" / "engine_share_capped.toml",
}
FACT = {
    "machine": ("bodies.press.mass", "290 kg", "310 kg"),
    "rotor": ("runs.4.readings.a.angle", "240 deg", "260 deg"),
    "known": ("planes.L.weight.to", "6 g", "12 g"),
    "engine": ("engine.rod", "140 mm", "150 mm"),
}
KEPT = {**FACT, "known": ("masses.m1.mass", "45 g", "55 g")}
"""A fact that may change where the design is kept."""
ROUND = {
    "machine": ("3",),
    "rotor": ("0.5 g", "5 deg"),
    "known": ("0.5 g", "planes.L.weight.angle=5 deg", "planes.R.weight.angle=1 deg"),
    "engine": ("2",),
}
BOUGHT = ("stiffness=7 MN/m", "damping=9 kN s/m")
kinds = pytest.mark.parametrize("kind", FILES)


def rounding(kind: str) -> list[str]:
    return [word for step in ROUND[kind] for word in ("--round", step)]


def words_of(verb: str, kind: str, folder: Path) -> list[str]:
    """The command line of a verb; options that take a file write into the folder."""
    file, (path, low, high) = str(FILES[kind]), KEPT[kind]
    one, span = ["--set", f"{path}={high}"], ["--vary", f"{path}={low}..{high}", "--points", "3"]
    return {
        "check": ["check", file],
        "solve": ["solve", file],
        "solve --set": ["solve", file, *one],
        "solve --round --save": ["solve", file, *rounding(kind), "--save", str(folder / "saved.toml")],
        "solve --save": ["solve", file, "--save", str(folder / "saved.toml")],
        "explain": ["explain", file],
        "whatif": ["whatif", file, *one],
        "whatif --keep-design": ["whatif", file, *one, "--keep-design"],
        "whatif --keep-design --round": ["whatif", file, *one, "--keep-design", *rounding(kind)],
        "sweep": ["sweep", file, *span, "--csv", str(folder / "s.csv"), "--figure", str(folder / "s.svg")],
        "sweep --keep-design": ["sweep", file, *span, "--keep-design", "--figure", str(folder / "k.svg")],
        "plot": ["plot", file, "-o", str(folder / "p.svg")],
        "report": ["report", file, "-o", str(folder / "r.html")],
        "verify": ["verify", file],
    }[verb]


VERBS = (
    "check", "solve", "solve --set", "solve --round --save", "solve --save", "explain", "whatif",
    "whatif --keep-design", "whatif --keep-design --round", "sweep", "sweep --keep-design", "plot", "report", "verify",
)  # fmt: skip


@kinds
@pytest.mark.parametrize("verb", VERBS)
def test_a_verb_takes_a_job_of_every_kind(run: Run, tmp_path: Path, verb: str, kind: str) -> None:
    words = words_of(verb, kind, tmp_path)
    done = run(*words)
    assert (done.code in (0, 7), done.err) == (True, ""), done.out
    assert done.out
    for word in words:
        assert not word.startswith(str(tmp_path)) or Path(word).stat().st_size > 0
    again = run(*words, "--json")
    assert (again.code, again.err) == (done.code, "")
    assert again.data


@kinds
def test_a_saved_design_is_a_job_of_its_own(run: Run, tmp_path: Path, kind: str) -> None:
    """It is measured as the answer said, stands beside it without a loss, and is swept and saved like any file."""
    saved = tmp_path / "saved.toml"
    assert run("solve", str(FILES[kind]), "--save", str(saved)).code == 0
    again = run("solve", str(saved), "--json")
    assert (again.code, again.data["status"]) == (0, "met")
    both = run("compare", str(FILES[kind]), str(saved), "--json")
    rows = [one for one in both.data["rows"] if one["kind"] in ("goal", "limit", "measure")]
    assert rows
    for row in rows:
        first, second = (cell["value"] for cell in row["cells"])
        assert isclose(first, second, rel_tol=1e-6, abs_tol=1e-9), row["name"]
    path, low, high = KEPT[kind]
    assert run("sweep", str(saved), "--vary", f"{path}={low}..{high}", "--points", "3").code == 0
    assert run("solve", str(saved), "--save", str(tmp_path / "twice.toml")).code == 0


@kinds
def test_each_point_of_a_sweep_is_the_answer_with_that_value(kind: str) -> None:
    job, (path, low, high) = vo.read(FILES[kind]), FACT[kind]
    swept = vo.sweep(job, path, f"{low}..{high}", 3)
    for point in swept.points:
        alone = vo.solve(vo.with_changes(job, swept.fact.changes(point.value.value)))
        assert point.status == alone.status
        assert point.goal is not None
        assert alone.goal is not None
        assert isclose(point.goal.value, alone.goal[1].value, rel_tol=1e-6, abs_tol=1e-12)


@kinds
def test_python_has_the_verbs_of_the_command_line(tmp_path: Path, kind: str) -> None:
    job, (path, low, high) = vo.read(FILES[kind]), KEPT[kind]
    answer = vo.solve(job)
    assert answer.report().startswith(job.title)
    assert vo.explain(job).answer.status == answer.status
    assert vo.explain(job).methods
    kept = vo.whatif(job, {path: high}, keep_design=True)
    assert (kept.before.status, kept.after.exit_code in (0, 7)) == (answer.status, True)
    assert len(vo.sweep(job, path, f"{low}..{high}", 3).points) == 3
    table = vo.compare({"as it is": job, "changed": vo.with_changes(job, {path: high})})
    assert table.names == ("as it is", "changed")
    vo.write(job, tmp_path / "again.toml")
    assert vo.to_toml(vo.read(tmp_path / "again.toml")) == vo.to_toml(job)


def test_reactions_of_a_kept_correction_grow_with_the_square_of_the_speed() -> None:
    swept = vo.sweep(vo.read(FILES["known"]), "shaft.speed", "500 rpm..1500 rpm", 3, keep_design=True)
    forces = [point.results["residual.bearings.A.reaction"].value for point in swept.points]
    assert [one / forces[0] for one in forces] == pytest.approx([1.0, 4.0, 9.0], rel=1e-9)


def test_forces_of_a_kept_engine_grow_with_the_square_of_the_speed() -> None:
    swept = vo.sweep(vo.read(FILES["engine"]), "engine.speed", "1000 rpm..3000 rpm", 3, keep_design=True)
    forces = [point.results["orders.2.force"].value for point in swept.points]
    assert [one / forces[0] for one in forces] == pytest.approx([1.0, 4.0, 9.0], rel=1e-9)


SINGLE = """
[engine]
stroke = "90 mm"
rod = "150 mm"
speed = "4500 rpm"
reciprocating = "0.6 kg"
rotating = "0.5 kg"
counterweight_share = { from = 0, to = 1 }
[[cylinders]]
crank = "0 deg"
[goal]
minimise = "primary_force"
"""


def primary(share: float) -> float:
    """Force [N] of one crank whose counterweight carries a share: the greater axis of an ellipse."""
    return 0.6 * 0.045 * (4500.0 * pi / 30.0) ** 2 * max(share, 1.0 - share)


def test_a_share_of_an_engine_is_held_at_each_value_and_what_was_made_least_is_measured() -> None:
    job, path = vo.from_text(SINGLE, "single.toml"), "engine.counterweight_share"
    swept = vo.sweep(job, path, "0.1..0.9", 3)
    forces = [point.results["orders.1.force"].value for point in swept.points]
    assert (swept.held, forces) == ((path,), pytest.approx([primary(one) for one in (0.1, 0.5, 0.9)], rel=1e-9))
    parts = vo.sweep(job, path, "-20 %..+20 %", 3)
    assert [point.varied[path].value for point in parts.points] == pytest.approx([0.4, 0.5, 0.6], rel=1e-6)
    given = vo.solve(vo.with_changes(job, {path: 0.3}))
    assert (given.status, given.goal) == ("met", None)
    assert given.measures["minimised"].value.value == pytest.approx(primary(0.3), rel=1e-9)


def test_shares_of_an_engine_that_are_rounded_are_still_what_to_build(run: Run, file: Callable[[str], str]) -> None:
    text = run("solve", file(SINGLE.replace("to = 1", "to = 0.333")), "--round", "2").out
    assert "values rounded to 2 digits" in text
    assert "What to build\n  opposite crank 1: a counterweight of 31.41 kg mm (mass times radius): 0.33 of" in text


def test_residuals_of_a_kept_plan_are_affine_in_a_reading() -> None:
    """What is left is a fixed mixture of the readings: along one amplitude its phasor moves on a straight line."""
    job = vo.read(FILES["rotor"])
    swept = vo.sweep(job, "runs.1.readings.a.amplitude", "8 mil..10 mil", 3, keep_design=True)
    left = [point.results["sensors.a.residual"].value for point in swept.points]
    squares = [one**2 for one in left]
    bend = squares[0] - 2.0 * squares[1] + squares[2]
    four = vo.sweep(job, "runs.1.readings.a.amplitude", "8 mil..11 mil", 4, keep_design=True)
    last = four.points[3].results["sensors.a.residual"].value ** 2
    assert last == pytest.approx(squares[2] + (squares[2] - squares[1]) + bend, rel=1e-9)


def test_rounding_keeps_caps_and_says_what_it_costs() -> None:
    """At a cap of 8.2 g no weight is rounded up to 8.5 g."""
    from vibopt.study.rounded_plan import drawn

    job = vo.with_changes(vo.read(FILES["known"]), {"planes.L.weight.to": "8.3 g"})
    done = drawn(job, vo.solve(job), ("0.5 g", "1 deg"))
    masses = {path: one.rounded.value for path, one in done.values.items() if path.endswith("mass")}
    assert masses["planes.L.weight.mass"] == pytest.approx(0.008)
    assert (done.design.status, done.broken) == ("feasible", "")
    assert done.worse_by is not None
    assert done.worse_by > 0.0
    goal = vo.solve(done.kept).goal
    assert goal is not None
    assert done.goal is not None
    assert isinstance(goal[1], Entry)
    assert goal[1].value == pytest.approx(done.goal.value, rel=1e-12)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (
            ("whatif", FILES["known"], "--set", "planes.L.weight.to=9 g", "--keep-design"),
            "planes.L.weight.to says from what a design is chosen, and with --keep-design none is. Leave this change "
            "out, or leave --keep-design out.",
        ),
        (
            ("whatif", FILES["rotor"], "--set", "planes.left.keep=true", "--keep-design"),
            "planes.left.keep says from what a design is chosen, and with --keep-design none is. Leave this change "
            "out, or leave --keep-design out.",
        ),
        (
            ("sweep", FILES["rotor"], "--vary", "runs.4.readings.a=1 mil..2 mil"),
            "runs.4.readings.a holds 2 numbers. Name one: runs.4.readings.a.amplitude or runs.4.readings.a.angle.",
        ),
        (
            ("sweep", FILES["engine"], "--vary", "engine.rodd=100 mm..120 mm"),
            'there is no fact called engine.rodd. Did you mean "engine.rod"?',
        ),
        (
            ("sweep", FILES["rotor"], "--vary", "conventions.detector=pp, rms"),
            "there is no fact called conventions.detector. Known: scatter.amplitude, scatter.angle, "
            "planes.left.radius, planes.left.weight.from, planes.left.weight.to, planes.right.radius, "
            "planes.right.weight.from, planes.right.weight.to, runs.1.speed, runs.1.readings.a.amplitude, "
            "runs.1.readings.a.angle and 25 more.",
        ),
        (
            ("sweep", FILES["engine"], "--vary", "engine.rod=1 kg..2 kg"),
            '--vary engine.rod="1 kg..2 kg" has the upper end "2 kg", which is a mass, but a length is needed here. '
            'Write a length, for example "20 mm".',
        ),
        (
            ("sweep", FILES["engine"], "--vary", "engine.rod=20 mm..120 mm", "--points", "2"),
            "engine_share_capped.toml: engine has a rod that is not longer than the crank radius: such a crank cannot "
            "turn. Write a longer rod.",
        ),
        (
            ("sweep", FILES["known"], "--vary", "planes.L.weight=0 g..5 g"),
            "planes.L.weight holds 2 numbers. Name one: planes.L.weight.from or planes.L.weight.to.",
        ),
        (
            ("solve", FILES["known"], "--set", "planes.L.at.to=5 mm"),
            '--set planes.L.at.to: planes.L.at is one value, "0 mm". Write --set planes.L.at=VALUE.',
        ),
        (
            ("solve", FILES["machine"], "--method", "catalogue"),
            "--method catalogue: no part of a catalogue is to be chosen. Leave --method out: vibopt takes one that "
            "can.",
        ),
        (
            ("solve", PROBLEMS / "isolation" / "rao_9_34_printed_design.toml", "--method", "slsqp"),
            "rao_9_34_printed_design.toml: --method slsqp: nothing is chosen, and what is asked is measured, whatever "
            "the method. Leave --method out.",
        ),
        (
            ("explain", PROBLEMS / "isolation" / "rao_9_1_speeds.toml", "--method", "ipopt"),
            "rao_9_1_speeds.toml: --method ipopt: find_all answers with the ends of intervals, which are found one by "
            "one, whatever the method. Leave --method out.",
        ),
        (
            ("report", PROBLEMS / "shafts" / "where_a_fan_is_borne.toml", "--method", "nlp", "-o", "x.html"),
            "where_a_fan_is_borne.toml: --method nlp: find_all answers with the ends of intervals, which are found one "
            "by one, whatever the method. Leave --method out.",
        ),
        (
            (
                "solve",
                FILES["machine"],
                "--method",
                "nlp",
                "--set",
                f"links.mount.{BOUGHT[0]}",
                "--set",
                f"links.mount.{BOUGHT[1]}",
            ),
            "rao_9_34.toml: --method nlp: nothing is chosen, and what is asked is measured, whatever the method. Leave "
            "--method out.",
        ),
        (
            ("plot", PROBLEMS / "balancing" / "rao_9_14_a.toml", "--method", "cvxpy", "-o", "x.svg"),
            "rao_9_14_a.toml: --method cvxpy: nothing is chosen, and what is asked is measured, whatever the method. "
            "Leave --method out.",
        ),
        (
            ("solve", FILES["engine"], "--set", 'goal.then=["secondary_cuople"]'),
            'engine_share_capped.toml: goal.then[1] = "secondary_cuople" is none of the values that then may have. '
            'Write "primary_force", "primary_couple", "secondary_force", "secondary_couple", "force" or "couple".',
        ),
        (
            ("solve", FILES["known"], "--set", "planes.L=3"),
            "rao_9_14_b_capped.toml: planes.L = 3 is not a table. Write [planes.L] and its keys below it.",
        ),
        (
            ("solve", FILES["rotor"], "--set", "planes.left.radius=0 mm"),
            'fan_verification_run.toml: planes.left.radius = "0 mm" is not greater than zero. Write a positive value, '
            'for example "20 mm".',
        ),
        (
            ("solve", FILES["rotor"], "--set", "scatter.amplitude=-0.03"),
            "fan_verification_run.toml: scatter.amplitude = -0.03 is negative. Write zero or more.",
        ),
        (
            ("solve", FILES["known"], "--round", "1 N"),
            "--round 1 N: is neither a number of digits from 1 to 12 nor a step. Write --round 3, or --round "
            'planes.L.weight.mass="0.01 g".',
        ),
        (
            ("solve", PROBLEMS / "balancing" / "rao_9_12_holes.toml", "--round", "3"),
            "rao_9_12_holes.toml: there is nothing to round: what is chosen are weights of the shelf, or cranks.",
        ),
        (
            ("solve", PROBLEMS / "balancing" / "rao_9_14_a.toml", "--round", "3"),
            "rao_9_14_a.toml: there is nothing to round: nothing is chosen.",
        ),
        (
            ("plot", FILES["engine"], "-o", "x.svg", "--map"),
            "engine_share_capped.toml: a map has two numbers of a machine as its axes, and weights of an engine "
            "have each a size and an angle, as the plot shows them. Leave --map out.",
        ),
        (
            ("chart", "fidelity", FILES["rotor"]),
            "fan_verification_run.toml: chart is for a machine on its mounts, and this is a measured rotor. --family "
            "balancing charts stock cases of balancing.",
        ),
        (
            ("compare", FILES["engine"], FILES["known"]),
            "engine_share_capped is an engine and rao_9_14_b_capped is a shaft with known masses: what is measured on "
            "one does not exist on another. Compare jobs of one kind.",
        ),
    ],
)
def test_what_cannot_be_is_refused_with_its_reason(
    run: Run, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, words: tuple[object, ...], message: str
) -> None:
    monkeypatch.chdir(tmp_path)
    done = run(*map(str, words))
    assert (done.code, done.out, done.err) == (2, "", f"{message}\n")


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        ("rotor", ["--map"], "a map has two numbers of a machine as its axes, and weights of a measured rotor have "
         "each a size and an angle, as the plot shows them. Leave --map out."),
        ("known", ["--sketch"], "--sketch draws machines; here the plot has the shaft in it. Leave --sketch out."),
        ("engine", ["--spectrum"], "--spectrum is of a load that comes once on a machine. Leave --spectrum out."),
        ("machine", ["--campbell"], "--campbell is of rotors that are modelled, [rotors.NAME]. Leave it out."),
        ("machine", ["--map", "--set", f"links.mount.{BOUGHT[1]}"], "a map needs exactly two variables that are not "
         "whole or listed."),
        ("machine", ["--map", "absorbers.tmd"], "there is no absorber called tmd."),
    ],
)  # fmt: skip
def test_a_picture_that_cannot_be_is_refused_before_anything_is_solved(
    run: Run, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, name: str, options: list[str], message: str
) -> None:
    monkeypatch.setattr(jobs, "answer", None)
    done = run("plot", str(FILES[name]), "-o", str(tmp_path / "x.svg"), *options)
    assert (done.code, done.out, done.err) == (2, "", f"{FILES[name].name}: {message}\n")


@kinds
def test_what_is_no_value_no_method_or_no_job_is_refused_in_python(kind: str) -> None:
    job, (path, *_) = vo.read(FILES[kind]), FACT[kind]
    with pytest.raises(vo.InputError, match=r"method 3"):
        vo.solve(job, method=3)  # type: ignore[arg-type]
    if kind == "engine":
        with pytest.raises(vo.InputError) as said:
            vo.with_changes(job, {path: None})
        assert f"{path} = None is no value with a unit, but a length is needed here." in str(said.value)
    for ask in (vo.solve, vo.explain, vo.posed):
        with pytest.raises(TypeError, match=r"int is no job\. Take one from vibopt\.read, or make a scene\."):
            ask(3)  # type: ignore[operator]


def test_an_engine_without_an_answer_tells_no_force_of_one() -> None:
    job = vo.with_changes(vo.from_text(f'{SINGLE}[limits.a]\nresponse = "secondary_force"\nat_most = "1 N"\n', "a"), {})
    found = vo.solve(job)
    assert found.status == "infeasible"
    assert not [note for note in found.notes if "Two orders alone" in note]
