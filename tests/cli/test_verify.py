"""Records against answers: what agrees, what does not, and what is no record at all."""

import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from vibopt.scene.read import from_text, read
from vibopt.scene.scene import Design, Scene
from vibopt.solve import solve
from vibopt.study.recorded import compare
from vibopt.study.verify import problem_files, verify

ROOT = Path(__file__).parents[2]
Run = Callable[..., Any]
SPRING = """\
title = "spring"
[bodies.block]
mass = "1 kg"
[links.mount]
between = ["block", "ground"]
stiffness = "100 N/m"
damping_ratio = 0.1
[excitations.shaker]
kind = "force"
on = "block"
amplitude = "1 N rms"
speed = "10 rad/s"
[measures.motion]
response = "displacement"
of = "block"
unit = "mm pp"
[measures.ratio]
response = "transmissibility"
into = "ground"
[measures.frequency]
response = "natural_frequency"
"""


@pytest.fixture(scope="module")
def spring() -> Design:
    return solve(from_text(SPRING))


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("status", "met"),
        ("measures.motion.value", "50 mm rms"),
        ("measures.motion.value", "70.710678 mm"),
        ("measures.motion.value", "141.42136 mm pp"),
        ("measures.motion.value", "0.070710678 m pk"),
        ("measures.motion.worst_at", "95.492966 rpm"),
        ("measures.motion.worst_at.shaker", "1.5915494 Hz"),
        ("measures.ratio.value", 5.0990195),
        ("measures.ratio.value", "509.90195 %"),
        ("measures.frequency.value", "10 rad/s"),
    ],
)
def test_a_right_record_agrees_in_any_unit(spring: Design, path: str, value: object) -> None:
    row = compare(spring, {"what": "it", "path": path, "value": value})
    assert row.ok, row.why


def test_the_tolerance_is_relative_and_can_be_narrowed(spring: Design) -> None:
    record = {"what": "f", "path": "measures.frequency.value", "value": "10.000005 rad/s"}
    assert compare(spring, record).ok
    row = compare(spring, {**record, "rel_tol": 1e-7})
    assert not row.ok
    assert row.why == "10 rad/s instead of 10.000005 rad/s, relative difference 5e-07, allowed 1e-07."


@pytest.mark.parametrize(
    ("record", "why"),
    [
        ({"path": "measures.motoin.value"}, 'the answer has no measure "motoin". Did you mean "motion"?'),
        ({"path": "measures.motion"}, 'measures.motion has no "". Write value or worst_at.'),
        ({"path": "measures.frequency.worst_at"}, "the worst of frequency is at a speed of each of: none."),
        ({"path": "variables.links.mount.stiffness"}, 'the answer has no variable "links.mount.stiffness".'),
        ({"path": "goal"}, "the answer has no goal."),
        ({"path": "set", "value": []}, "the answer has no set"),
        ({"path": "sattus"}, 'there is no "sattus" in an answer. Did you mean "status"?'),
        ({"path": "measures.frequency.value", "value": "10 kg"}, "measures.frequency.value = 10 kg is a mass"),
        ({"path": "status", "rel_tol": 0}, "rel_tol = 0 is no number between 0 and 1."),
        (
            {"path": "measures.frequency.value", "rel_tol": 1e-3},
            "rel_tol = 0.001: a rel_tol_why says why it is more than 1e-06, and stands nowhere else.",
        ),
        (
            {"path": "measures.frequency.value", "rel_tol_why": "flat"},
            "rel_tol = 1e-06: a rel_tol_why says why it is more than 1e-06, and stands nowhere else.",
        ),
        ({"path": "status", "valeu": 1}, 'unknown key "valeu" in the record. Did you mean "value"?'),
        ({"path": "status", "verdict": "bad"}, 'verdict = "bad" is none of right, rounded'),
        ({"path": "status", "verdict": "wrong"}, "there is a verdict, but nothing printed that it judges."),
        ({"path": "status", "verdict": "wrong", "printed": "x"}, 'verdict = "wrong" needs a why.'),
    ],
)
def test_what_is_no_record_is_told(spring: Design, record: dict[str, Any], why: str) -> None:
    row = compare(spring, {"what": "it", "value": "10 rad/s", **record})
    assert not row.ok
    assert why in row.why


def test_an_infinite_value_is_only_infinite() -> None:
    design = solve(read(Path(__file__).parents[2] / "problems" / "isolation" / "rao_9_1.toml"))
    record = {"what": "it", "path": "measures.ride.value"}
    assert compare(design, {**record, "value": "infinite"}).ok
    assert not compare(design, {**record, "value": "1e6 mm"}).ok
    assert not compare(design, {"what": "f", "path": "measures.bounce.value", "value": "infinite"}).ok


@pytest.mark.parametrize(
    ("value", "ok"),
    [
        ([["0 rad/s", "56.487316 rad/s"], ["78.395603 rad/s", "1518.3801 rad/s"]], True),
        ([["0 rad/s", "56.5 rad/s"], ["78.395603 rad/s", "1518.3801 rad/s"]], False),
        ([["0 rad/s", "56.487316 rad/s"]], False),
        ([], False),
    ],
)
def test_a_set_must_agree_end_by_end(value: object, ok: bool) -> None:
    design = solve(read(Path(__file__).parents[2] / "problems" / "isolation" / "rao_9_35.toml"))
    assert compare(design, {"what": "set", "path": "set", "value": value}).ok is ok


def test_a_folder_is_searched_below_and_each_file_counts_once(tmp_path: Path) -> None:
    (tmp_path / "a" / "b").mkdir(parents=True)
    for name in ("a/one.toml", "a/b/two.toml", "a/note.md"):
        (tmp_path / name).write_text(SPRING)
    found = problem_files([tmp_path / "a", tmp_path / "a" / "one.toml"])
    assert [name for _, name in found] == ["b/two.toml", "one.toml"]


def test_a_file_without_an_answer_is_not_as_recorded(tmp_path: Path) -> None:
    (tmp_path / "bad.toml").write_text("title = 1")
    (tmp_path / "good.toml").write_text(SPRING)

    def fails(scene: Scene) -> Design:
        raise ZeroDivisionError("no")

    rows = verify([tmp_path], fails).rows
    assert [(row.file, row.ours, row.ok) for row in rows] == [
        ("bad.toml", "input_error", False),
        ("good.toml", "internal_error", False),
    ]


def test_an_answer_that_failed_its_check_is_never_as_recorded(tmp_path: Path, spring: Design) -> None:
    from dataclasses import replace

    (tmp_path / "one.toml").write_text(SPRING)
    refused = replace(spring, status="check_failed", claim="it breaks motion")
    (row,) = verify([tmp_path], lambda scene: refused).rows
    assert (row.ok, row.ours, row.why) == (False, "check_failed", "it breaks motion")


def test_the_verb_prints_every_record_and_its_exit_code_tells(run: Run, file: Callable[..., str]) -> None:
    record = '[[expected]]\nwhat = "own"\npath = "measures.frequency.value"\nvalue = "{} rad/s"\n'
    good = file(SPRING + record.format(10) + 'printed = "11 rad/s"\nverdict = "wrong"\nwhy = "slip"\n', "good.toml")
    done = run("verify", good)
    assert (done.code, done.err) == (0, "")
    assert done.out == (
        "What                 Printed      Right           Ours            Verdict    OK\n"
        "good.toml\n"
        "own                  11 rad/s     10 rad/s        10 rad/s        wrong      ok\n"
        "1 file, 1 record, 1 as recorded.\n"
    )
    bad = file(SPRING + record.format(12), "bad.toml")
    done = run("verify", good, bad)
    assert done.code == 6
    assert "bad.toml, own: 10 rad/s instead of 12 rad/s, relative difference 0.17, allowed 1e-06.\n" in done.out
    data = run("verify", bad, "--json").data
    assert (data["status"], data["files"], data["records"][0]["ok"]) == ("different", 1, False)


def test_an_empty_folder_is_an_input_error(run: Run, tmp_path: Path) -> None:
    done = run("verify", str(tmp_path))
    assert done.code == 2
    assert "holds no problem file" in done.err


def test_any_number_of_workers_gives_the_same_table_in_the_order_of_the_files(
    run: Run, file: Callable[..., str]
) -> None:
    record = '[[expected]]\nwhat = "own {0}"\npath = "measures.frequency.value"\nvalue = "{0} rad/s"\n'
    files = [file(SPRING + record.format(number), f"{number}.toml") for number in (10, 11, 9, 12)]
    one, three = (run("verify", *files, "--workers", number) for number in ("1", "3"))
    assert one == three
    assert one.code == 6
    assert [line[:5] for line in one.out.splitlines() if line.startswith("own")] == ["own 1", "own 1", "own 9", "own 1"]


def test_two_files_of_one_name_are_told_apart_by_their_folders(tmp_path: Path) -> None:
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "same.toml").write_text(SPRING)
    names = [name for _, name in problem_files([tmp_path / "a", tmp_path / "b"])]
    assert names == [f"{tmp_path}/a/same.toml", f"{tmp_path}/b/same.toml"]


@pytest.mark.parametrize("workers", ["0", "-1", "many"])
def test_a_number_of_workers_that_is_none_is_refused(run: Run, press: str, workers: str) -> None:
    done = run("verify", press, "--workers", workers)
    assert done.code == 2
    assert "Invalid value for '--workers'" in done.err


def children(process: int | str) -> list[str]:
    """Numbers of the processes that a process has started."""
    listed = Path(f"/proc/{process}/task/{process}/children")
    return listed.read_text().split() if listed.exists() else []


def _heeds_ctrl_c() -> None:
    """What a shell starts behind its back ignores Ctrl-C, and so do its children."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


@pytest.mark.skipif(not Path(f"/proc/{os.getpid()}/task").exists(), reason="children are counted as Linux lists them")
def test_ctrl_c_ends_every_process_with_one_sentence(tmp_path: Path) -> None:
    for number in range(500):  # far more than are done before the signal comes, on a busy machine too
        (tmp_path / f"{number}.toml").write_text(SPRING)
    command = [sys.executable, "-m", "vibopt", "verify", str(tmp_path), "--workers", "2"]
    with subprocess.Popen(
        command, start_new_session=True, text=True, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        preexec_fn=_heeds_ctrl_c,
    ) as process:  # fmt: skip
        while not any(children(one) for one in children(process.pid)):  # a worker, under what it is forked from
            assert process.poll() is None
        os.killpg(process.pid, signal.SIGINT)
        out, err = process.communicate()  # ends when nobody holds the other ends any more: no process is left
    assert (process.returncode, out) == (130, "")
    assert err == "Stopped before every file was solved; nothing was compared.\n"


def test_answers_are_kept_and_compared_file_by_file(run: Run, file: Callable[..., str], tmp_path: Path) -> None:
    soft, hard = file(SPRING, "soft.toml"), file(SPRING.replace("100 N/m", "400 N/m"), "hard.toml")
    kept = str(tmp_path / "kept.json")
    done = run("verify", soft, hard, "--save", kept)
    assert (done.code, done.out.splitlines()[-1]) == (0, f"Written: {kept}")
    assert "timings" not in Path(kept).read_text()
    done = run("verify", soft, hard, "--against", kept, "--workers", "1")
    assert done.code == 0
    assert done.out.splitlines()[-4:] == [
        f"Against {kept}:",
        "soft.toml: byte-equal",
        "hard.toml: byte-equal",
        "2 files: 2 byte-equal, 0 equal to 1e-9, 0 different.",
    ]
    file(SPRING.replace("100 N/m", "300 N/m"), "hard.toml")
    done = run("verify", hard, "--against", kept)
    assert done.code == 6
    told = done.out.split(f"Against {kept}:\n")[1].splitlines()
    assert told[0] == "hard.toml: differs; the problem file or a file that it names has changed since"
    assert told[1] == "  measures.frequency.value: 17.3205080757 instead of 20, difference 0.13"
    assert told[-2:] == ["1 file: 0 byte-equal, 0 equal to 1e-9, 1 different.", "1 more kept answer not asked for."]
    data = run("verify", hard, "--against", kept, "--json").data
    assert (data["status"], data["compared"][0]["verdict"]) == ("different", "differs")


def test_an_answer_does_not_depend_on_where_its_file_lies(run: Run, press: str, tmp_path: Path) -> None:
    kept, copy = str(tmp_path / "kept.json"), tmp_path / "elsewhere" / Path(press).name
    copy.parent.mkdir()
    copy.write_bytes(Path(press).read_bytes())
    assert run("verify", press, "--save", kept).code == 0
    assert f"{copy.name}: byte-equal\n" in run("verify", str(copy), "--against", kept).out


def test_keeping_answers_writes_over_nothing_else(run: Run, file: Callable[..., str], tmp_path: Path) -> None:
    soft, mine = file(SPRING), tmp_path / "mine.json"
    mine.write_text("{}")
    done = run("verify", soft, "--save", str(mine))
    assert (done.code, mine.read_text()) == (2, "{}")
    assert done.err == (
        f"{mine} cannot be written: it is there already, and vibopt did not write it or it has been changed since. "
        "Name another file, or add --force.\n"
    )
    assert run("verify", soft, "--save", str(mine), "--force").code == 0
    assert run("verify", soft, "--save", str(mine)).code == 0
    done = run("verify", soft, "--save", str(mine), "--against", str(mine))
    assert done.err == f"{mine} cannot be written: it is read in this run. Name another file.\n"


def test_a_file_without_an_answer_is_not_kept_and_that_is_said(
    run: Run, file: Callable[..., str], tmp_path: Path
) -> None:
    kept = str(tmp_path / "kept.json")
    done = run("verify", file(SPRING, "good.toml"), file("title = 1", "bad.toml"), "--save", kept)
    assert done.code == 6
    assert done.err == "Without an answer, so not kept: bad.toml.\n"


@pytest.mark.parametrize("verb", ["solve", "check", "verify", "explain"])
def test_an_empty_name_is_no_folder(run: Run, verb: str) -> None:
    done = run(verb, "")
    assert (done.code, done.err) == (2, "No file is named: the name is empty. Name a problem file (.toml).\n")


def test_a_device_is_refused_and_counts_as_no_file_that_differs(run: Run) -> None:
    done = run("verify", "/dev/zero")
    assert (done.code, done.err) == (
        2,
        "/dev/zero is a device, and only files are read. Name a problem file (.toml).\n",
    )


def test_answers_that_are_not_there_say_how_they_are_kept(run: Run, file: Callable[..., str]) -> None:
    done = run("verify", file(SPRING), "--against", "nope.json")
    assert (done.code, done.err) == (
        2,
        "nope.json is not there. Keep answers with vibopt verify PATH... --save FILE.\n",
    )


def test_kept_answers_are_found_however_the_path_is_written(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for folder, stiffness in (("one", "100 N/m"), ("two", "400 N/m")):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "x.toml").write_text(SPRING.replace("100 N/m", stiffness), encoding="utf-8")
    kept = str(tmp_path / "kept.json")
    monkeypatch.chdir(tmp_path)
    assert run("verify", "one", "two", "--save", kept).code == 0
    done = run("verify", "two", "--against", kept)
    assert (done.code, done.out.splitlines()[-3:]) == (
        0,
        [
            "x.toml: byte-equal; kept as two/x.toml",
            "1 file: 1 byte-equal, 0 equal to 1e-9, 0 different.",
            "1 more kept answer not asked for.",
        ],
    )
    (tmp_path / "two" / "x.toml").rename(tmp_path / "two" / "y.toml")
    done = run("verify", "two", "--against", kept)
    assert (done.code, "y.toml: differs\n  no answer of it was kept.\n" in done.out) == (6, True)


def test_a_file_without_records_has_no_table(run: Callable[..., Any], tmp_path: Path) -> None:
    link = '[links.m]\nbetween = ["fan", "ground"]\nstiffness = "9 N/m"\n'
    measure = '[measures.f]\nresponse = "natural_frequency"\n'
    (tmp_path / "bare.toml").write_text(f'[bodies.fan]\nmass = "3 kg"\n{link}{measure}')
    said = run("verify", str(tmp_path))
    assert (
        said.out == "1 file without a record: what is right stands in [[expected]]. See `vibopt help verification`.\n"
    )
    assert said.code == 0
