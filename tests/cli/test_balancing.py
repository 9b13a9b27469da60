"""The command line on balancing files."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import vibopt as vo
from vibopt.study.recorded import compare

Run = Callable[..., Any]
ROOT = Path(__file__).parents[2]
PROBLEMS = ROOT / "problems" / "balancing"
HEAVY = (
    "casadi",
    "cvxpy",
    "clarabel",
    "scipy.optimize",
    "scipy.linalg",
    "scipy.sparse",
    "matplotlib",
    "jinja2",
    "rich",
)
CSV = """\
run;speed [rpm];left mass [g];left angle [deg];right mass [g];right angle [deg];a amplitude [mil pp];a angle [deg]
as found;1200;;;;;8,6;63
trial left;1200;10;270;;;5,9;123
trial right;1200;;;12;180;6,2;36
"""
JOB = """\
title = "fan"
readings = "job.csv"
[conventions]
phase = "lag"
readings = "phase"
angles = "against rotation"
detector = "pp"
zero = "tape"
[planes.left]
radius = "150 mm"
[planes.right]
radius = "150 mm"
keep = true
"""


@pytest.fixture
def job(tmp_path: Path) -> str:
    """A job whose readings are a CSV as Excel writes it."""
    (tmp_path / "job.csv").write_text(CSV, encoding="utf-8-sig")
    (tmp_path / "job.toml").write_text(JOB, encoding="utf-8")
    return str(tmp_path / "job.toml")


@pytest.fixture
def new(run: Run, tmp_path: Path) -> str:
    """What `vibopt new balance` writes."""
    target = str(tmp_path / "new.toml")
    assert run("new", "balance", "-o", target).code == 0
    return target


def test_the_new_file_is_accepted_as_it_stands_and_solved(run: Run, new: str) -> None:
    done = run("check", new)
    assert (done.code, done.err) == (0, "")
    assert done.out.startswith(
        f"{new}: no mistakes. 1 limit, 2 planes, 2 sensors, 3 runs, 1 speed; goal: minimise residual (least squares).\n"
        "  planes.left: at 150 mm, up to 60 g\n"
    )
    assert run("solve", new).code == 0


def test_the_remarks_of_the_new_file_are_accepted_when_the_signs_are_taken_away(run: Run, new: str) -> None:
    text = Path(new).read_text(encoding="utf-8")
    before, sign, after = text.partition("# [quality]")
    Path(new).write_text(before + (sign + after).replace("\n# ", "\n").removeprefix("# "), encoding="utf-8")
    assert run("solve", new, "--json").data["quality"]["met"] == "yes"


def test_a_file_that_is_there_is_never_written_over(run: Run, new: str) -> None:
    done = run("new", "balance", "-o", new)
    way = "Name another file with -o, or add --force."
    assert (done.code, done.err) == (2, f"{new} is there already and stays as it is. {way}\n")
    assert run("new", "balance", "-o", "-").out == Path(new).read_text(encoding="utf-8")
    assert run("new", "blance").err == 'there is no file of the kind "blance". Did you mean "balance"?\n'


def test_a_csv_beside_the_file_gives_the_plan_in_text_and_json(run: Run, job: str) -> None:
    done = run("solve", job)
    assert done.code == 0
    assert "right: leave untouched." in done.out
    data = run("solve", job, "--json").data
    assert data["status"] == "optimal"
    assert data["conventions"]["zero"] == "tape"
    assert data["planes"]["right"]["action"] == "keep"
    assert set(data["planes"]["left"]) == {"action", "mass", "angle", "radius", "weights", "words"}


def test_a_wrong_cell_of_the_csv_is_told_with_row_and_column(run: Run, job: str) -> None:
    csv = Path(job).with_name("job.csv")
    csv.write_text(CSV.replace("5,9", "-5,9"), encoding="utf-8")
    done = run("check", job)
    assert done.code == 2
    assert done.err.startswith('job.csv row 3, column G ("a amplitude [mil pp]"): ')


def test_set_reaches_into_lists(run: Run, new: str) -> None:
    data = run("solve", new, "--set", "runs.1.readings.a=4.3 mil @ 63 deg", "--json").data
    assert data["sensors"]["a"]["found"]["shown"] == "4.3 mil pp"
    done = run("solve", new, "--set", "runs.9.speed=1 rpm")
    assert (done.code, done.err) == (
        2,
        "--set runs.9.speed: 9 is no entry of this list. Write a number from 1 to 3.\n",
    )


def test_a_method_that_a_balancing_job_does_not_have_is_refused(run: Run, new: str) -> None:
    for verb in ("solve", "explain"):
        done = run(verb, new, "--method", "nlp")
        assert (done.code, done.out, done.err) == (
            2,
            "",
            "new.toml: --method nlp: goal and limits decide the method of a balancing job. Leave it out, or write "
            "cvxpy or ipopt.\n",
        )


def test_explain_gives_the_answer_with_every_price(run: Run, new: str) -> None:
    plain = run("solve", new, "--json").data
    for more in ((), ("--thorough",)):
        done = run("explain", new, *more, "--json")
        assert (done.code, done.data["status"], done.data["design"]["planes"]) == (0, plain["status"], plain["planes"])
        assert [one["name"] for one in done.data["methods"]] == ["closed form", "convex program"]
    assert "closed form     cannot: takes no limits (running)" in run("explain", new).out


def test_plot_and_report_write_their_files(run: Run, job: str, tmp_path: Path) -> None:
    picture, page = tmp_path / "plan.svg", tmp_path / "plan.html"
    assert run("plot", job, "-o", str(picture)).code == 0
    assert picture.read_text(encoding="utf-8").startswith("<?xml")
    done = run("report", job, "-o", str(page), "--json")
    assert done.data["written"] == [str(page)]
    assert "Fitted by (name)" in page.read_text(encoding="utf-8")
    refused = run("plot", job, "-o", str(picture), "--map")
    assert (refused.code, refused.err) == (
        2,
        "job.toml: a map has two numbers of a machine as its axes, and weights of a measured rotor have each "
        "a size and an angle, as the plot shows them. Leave --map out.\n",
    )


def test_a_balancing_job_does_not_mix_with_bodies(run: Run, new: str) -> None:
    file = Path(new)
    file.write_text(file.read_text(encoding="utf-8") + '[bodies.a]\nmass = "1 kg"\n', encoding="utf-8")
    done = run("check", new)
    assert done.code == 2
    assert done.err.endswith("a balancing job does not mix with [bodies]. Put each into a file of its own.\n")


def test_check_loads_no_solver_and_no_picture_maker(job: str) -> None:
    files = [job, str(PROBLEMS / "rao_9_12.toml"), str(PROBLEMS / "engine_v_twin.toml")]
    program = (
        f"import sys\nfrom vibopt.cli.main import main\ncode = main(['check', *{files!r}])\n"
        f"heavy = [name for name in {HEAVY!r} if name in sys.modules]\nassert (code, heavy) == (0, []), heavy\n"
    )
    subprocess.run([sys.executable, "-c", program], capture_output=True, cwd=ROOT, check=True)


def test_verify_covers_every_kind_of_job(run: Run) -> None:
    files = [str(PROBLEMS / f"{name}.toml") for name in ("rao_9_7", "rao_9_12", "engine_v_twin", "feese_two_speeds")]
    done = run("verify", *files)
    assert done.code == 0
    assert done.out.splitlines()[-1].startswith("4 files, ")


@pytest.mark.parametrize(
    ("path", "value", "ok", "why"),
    [
        ("planes.flywheel.angle", "317.91674 deg", True, ""),
        ("planes.flywheel.angle", "-42.08326 deg", True, ""),
        ("planes.flywheel.mass", "44.44487 g", True, ""),
        ("sensors.bearing.residual", "0 mm pk", True, ""),
        ("sensors.bearing.found", "0.3 mm pp", True, ""),
        (
            "sensors.bearing.found",
            "0.15 mm",
            False,
            'sensors.bearing.found = 0.15 mm says neither pk, pp nor rms. Write "0.15 mm pk".',
        ),
        ("status", "optimal", True, ""),
    ],
)
def test_records_of_a_plan(path: str, value: str, ok: bool, why: str) -> None:
    plan = vo.solve(vo.read(PROBLEMS / "rao_9_7.toml"))
    row = compare(plan, {"what": "this", "path": path, "value": value})
    assert (row.ok, row.why) == (ok, why)


def test_a_record_of_nothing_names_the_nearest_path() -> None:
    plan = vo.solve(vo.read(PROBLEMS / "rao_9_7.toml"))
    row = compare(plan, {"what": "this", "path": "planes.flywheel.masse", "value": "1 g"})
    assert (
        row.why
        == 'the answer has no such path: unknown path "planes.flywheel.masse". Did you mean "planes.flywheel.mass"?'
    )


@pytest.mark.parametrize("kind", ["rotor", "known", "engine"])
def test_there_is_a_schema_for_each_kind_of_job(run: Run, kind: str) -> None:
    import tomllib

    from vibopt.jobs import kind_of

    data = run("schema", kind).data
    assert data["additionalProperties"] is False
    for path in PROBLEMS.glob("*.toml"):
        document = tomllib.loads(path.read_text(encoding="utf-8"))
        if kind_of(document) == kind:
            assert set(document) <= set(data["properties"])


def test_check_says_what_a_grade_alone_asks(tmp_path: Path, run: Run) -> None:
    file = tmp_path / "grade.toml"
    file.write_text(
        '[quality]\ngrade = "6.3 mm/s"\nmass = "80 kg"\nspeed = "1200 rpm"\ncentre_of_mass = "450 mm"\n'
        'bearings = { A = "0 mm", B = "900 mm" }\n'
    )
    ran = run("check", str(file))
    assert ran.code == 0
    assert ran.out.endswith("grade.toml: no mistakes. a quality grade, nothing to choose.\n")
