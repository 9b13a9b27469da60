"""What commands write: never over an input, never over a stranger's file, whole, and as it comes."""

from __future__ import annotations

import csv
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from refusals import refused
from texts import STIFFEST, choice, floor, shaken_fan
from vibopt import jobs
from vibopt.answer.answer import EXIT_CODES
from vibopt.cli.sweep_table import journal_of
from vibopt.errors import InputError
from vibopt.files import marks, reading
from vibopt.files.marks import is_ours, with_check
from vibopt.files.reading import forget
from vibopt.files.writing import checked_target, format_of, write_file

Run = Callable[..., Any]
ROOT = Path(__file__).parents[2]
PRESS = str(ROOT / "problems" / "isolation" / "rao_9_34.toml")
BOUND = "limits.force.at_most"
FAN = 'title = "fan"\n' + shaken_fan(
    {"stiffness": choice("10 kN/m", "1 MN/m")}, floor("20 N", "force"), STIFFEST, speed="1500 rpm"
)
WRITERS: dict[str, tuple[tuple[str, ...], str]] = {
    "solve": (("solve", "FILE", "--no-prices", "--save", "OUT"), ".toml"),
    "plot svg": (("plot", "FILE", "-o", "OUT"), ".svg"),
    "plot png": (("plot", "FILE", "-o", "OUT"), ".png"),
    "plot pdf": (("plot", "FILE", "-o", "OUT"), ".pdf"),
    "report": (("report", "FILE", "-o", "OUT"), ".html"),
    "sheet": (("report", "FILE", "--sheet", "-o", "OUT"), ".html"),
    "sweep": (("sweep", "FILE", "--vary", f"{BOUND}=10 N..30 N", "--points", "3", "--csv", "OUT"), ".csv"),
    "sweep figure": (("sweep", "FILE", "--vary", f"{BOUND}=10 N..30 N", "--points", "3", "--figure", "OUT"), ".svg"),
    "compare": (("compare", "FILE", PRESS, "--csv", "OUT"), ".csv"),
    "verify": (("verify", "FILE", "--save", "OUT"), ".json"),
    "new": (("new", "balance", "-o", "OUT"), ".toml"),
}  # fmt: skip
each = pytest.mark.parametrize(("words", "ending"), WRITERS.values(), ids=WRITERS)


@pytest.fixture
def fan(tmp_path: Path) -> Path:
    """A problem file in a folder of its own."""
    file = tmp_path / "in" / "fan.toml"
    file.parent.mkdir()
    file.write_text(FAN, encoding="utf-8")
    return file


def command(words: tuple[str, ...], file: Path, out: Path) -> list[str]:
    return [{"FILE": str(file), "OUT": str(out)}.get(one, one) for one in words]


@pytest.mark.sampled(2)
@each
def test_a_strangers_file_is_kept_without_force(
    run: Run, fan: Path, tmp_path: Path, words: tuple[str, ...], ending: str
) -> None:
    out = tmp_path / f"out{ending}"
    out.write_bytes(b"mine, not yours\n")
    done = run(*command(words, fan, out))
    assert (done.code, out.read_bytes()) == (2, b"mine, not yours\n")
    assert done.err.startswith(f"{out} ")
    assert "add --force." in done.err
    forced = run(*command(words, fan, out), "--force")
    assert forced.code == 0, forced.err
    assert out.read_bytes() != b"mine, not yours\n"
    assert sorted(os.listdir(tmp_path)) == ["in", out.name]


@pytest.mark.sampled(2)
@each
def test_a_file_of_vibopt_is_written_over_until_somebody_changes_it(
    run: Run, fan: Path, tmp_path: Path, words: tuple[str, ...], ending: str
) -> None:
    out = tmp_path / f"out{ending}"
    assert run(*command(words, fan, out)).code == 0
    again = run(*command(words, fan, out))
    if words[0] == "new":  # it is made to be filled in
        assert again.code == 2
        return
    assert again.code == 0, again.err
    if ending in (".toml", ".csv", ".json"):
        out.write_bytes(out.read_bytes().replace(b"e", b"E", 3) + b"x")
        assert run(*command(words, fan, out)).code == 2


@pytest.mark.parametrize(("words", "ending"), [one for one in WRITERS.values() if "FILE" in one[0]])
@pytest.mark.parametrize("way", ["itself", "symbolic", "hard"])
def test_an_input_is_never_written_over(run: Run, fan: Path, words: tuple[str, ...], ending: str, way: str) -> None:
    """By whatever name it goes, and with --force too."""
    named = fan.with_name(f"fan{ending}")
    if named != fan:
        fan.rename(named)
    out = named if way == "itself" else named.with_name(f"link{ending}")
    if way != "itself":
        (os.link if way == "hard" else os.symlink)(named, out)
    for more in ((), ("--force",)):
        done = run(*command(words, named, out), *more)
        assert (done.code, named.read_text(encoding="utf-8")) == (2, FAN)
        assert done.err == f"{out} cannot be written: it is read in this run. Name another file.\n"


def test_a_file_with_the_number_of_one_that_was_read_and_is_gone_is_another(tmp_path: Path) -> None:
    """A file system gives the number of a deleted file to the next one."""
    read, target = tmp_path / "gone.toml", tmp_path / "new.svg"
    target.write_text("a picture")
    found = target.stat()
    for there in (True, False):
        (os.link(target, read) if there else read.unlink())
        reading._read[found.st_dev, found.st_ino] = str(read)
        assert reading.was_read(target) == there
    forget()


def test_a_catalogue_and_readings_are_inputs_too(run: Run, tmp_path: Path) -> None:
    parts = "part;rated load max [N];stiffness [N/mm];price [EUR]\nA;2000;40;10\nB;2000;60;12\n"
    (tmp_path / "parts.csv").write_text(parts)
    wanted = 'stiffness = { from = "10 kN/m", to = "1 MN/m" }'
    text = FAN.replace(wanted, 'part = { catalogue = "parts.csv" }').replace(
        'maximise = "stiffness"', 'minimise = "price"'
    )
    text = text.removesuffix('of = "mount"\n')
    (tmp_path / "fan.toml").write_text(text)
    out = str(tmp_path / "parts.csv")
    done = run("compare", str(tmp_path / "fan.toml"), PRESS, "--csv", out, "--force")
    assert (done.code, done.err) == (2, f"{out} cannot be written: it is read in this run. Name another file.\n")
    assert (tmp_path / "parts.csv").read_text() == parts


def test_the_words_of_a_table_are_those_of_the_answers() -> None:
    assert set(EXIT_CODES) - {"input_error", "internal_error"} <= marks._STATUSES


def test_other_texts_are_nobodys(tmp_path: Path) -> None:
    assert is_ours(b"")
    assert is_ours(with_check("a = 1\n").encode())
    strangers = (
        b"a = 1\n", with_check("a = 1\n").replace("1", "2", 1).encode(), with_check("a\n").encode() + b"b\n",
        b"x,status\n1,good\n", b"x,status\n1\n", b"kind,row,unit\n1,2\n", b"\xff\xfe", b"%PDF-1.4\n%%EOF\n",
        b"<svg></svg>", b'time,status,"open\n',
    )  # fmt: skip
    assert [one for one in strangers if is_ours(one)] == []
    file = tmp_path / "empty.csv"
    file.touch()
    assert checked_target(str(file)) == file


def test_places_that_are_no_files_are_told(tmp_path: Path) -> None:
    forget()
    ring = tmp_path / "ring.csv"
    ring.symlink_to(ring)
    for name in ("", "a\0b.csv", "x" * 300 + ".csv", str(ring), str(tmp_path)):
        caught = refused(lambda name=name: write_file(checked_target(name), b"content"))
        assert "cannot be written" in str(caught)
        assert len(str(caught)) < 400


def test_a_pipe_that_nobody_reads_is_no_wait(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    assert str(refused(write_file, checked_target(str(tmp_path / "pipe")), b"content")) == (
        f"{tmp_path / 'pipe'} cannot be written: it is a pipe, and nobody reads from it. Name a file, or begin to read "
        "first."
    )


PICTURES = {name: words for name, (words, ending) in WRITERS.items() if ending == ".svg"}


@pytest.mark.parametrize("words", PICTURES.values(), ids=PICTURES)
@pytest.mark.parametrize(("device", "code"), [("/dev/null", 0), ("/dev/full", 2)])
def test_a_picture_for_a_device_without_an_ending_is_svg(
    run: Run, fan: Path, words: tuple[str, ...], device: str, code: int
) -> None:
    done = run(*command(words, fan, Path(device)))
    assert (done.code, done.err) == (code, f"{device} cannot be written: no space left on device.\n" if code else "")


@pytest.mark.parametrize("ending", ["", ".svg", ".PNG", ".dat"])
def test_the_format_of_a_stream_is_its_ending_or_the_first_there_is(tmp_path: Path, ending: str) -> None:
    os.mkfifo(tmp_path / f"pipe{ending}")
    found = format_of(checked_target(str(tmp_path / f"pipe{ending}"), (".svg", ".png")), (".svg", ".png"))
    assert found == ("png" if ending == ".PNG" else "svg")


def test_a_path_is_varied_or_set_and_not_both(run: Run, fan: Path) -> None:
    done = run("sweep", str(fan), "--vary", f"{BOUND}=1 N..2 N", "--set", f"{BOUND}=3 N")
    assert (done.code, done.err) == (2, f"{BOUND} is given by --vary and by --set. Leave out the --set.\n")


def test_an_option_given_twice_is_refused(run: Run, fan: Path, tmp_path: Path) -> None:
    done = run("sweep", str(fan), "--vary", f"{BOUND}=1 N..2 N", "--vary", f"{BOUND}=1 N..3 N")
    assert (done.code, done.err) == (2, f"--vary {BOUND} is given twice. Give it once.\n")
    out = str(tmp_path / "a.svg")
    twice = run("solve", str(fan), "--set", f"{BOUND}=1 N", "--set", f"{BOUND}=2 N")
    assert (twice.code, twice.err) == (2, f"--set {BOUND} is given twice. Give it once.\n")
    assert "is given twice. Give it once." in run("plot", str(fan), "-o", out, "-o", out).err


@pytest.mark.parametrize(
    ("first", "second", "message"),
    [
        ("3", "2", "--round 3 and --round 2 are both digits of all values. Give one of them."),
        (
            "0.5 g",
            "2 kg",
            "--round 0.5 g and --round 2 kg are both steps of the same values. Give one of them, or name a value "
            "before each: --round PATH=STEP.",
        ),
        (
            "links.mount.stiffness=5 kN/m",
            "links.mount.stiffness=1 kN/m",
            "--round links.mount.stiffness is given twice. Give it once.",
        ),
    ],
)
def test_a_rounding_given_twice_is_refused_before_anything_is_solved(
    run: Run, fan: Path, monkeypatch: pytest.MonkeyPatch, first: str, second: str, message: str
) -> None:
    monkeypatch.setattr(jobs, "answer", None)
    for rest in (["--round", second], ["--round", "3 deg", "--round", second]):
        done = run("solve", str(fan), "--round", first, *rest)
        assert (done.code, done.err) == (2, f"{message}\n")


def test_two_outputs_in_one_file_are_refused(run: Run, fan: Path, tmp_path: Path) -> None:
    (tmp_path / "a.svg").touch()
    (tmp_path / "a.csv").symlink_to(tmp_path / "a.svg")
    words = ("--csv", str(tmp_path / "a.csv"), "--figure", str(tmp_path / "a.svg"))
    done = run("sweep", str(fan), "--vary", f"{BOUND}=1 N..2 N", *words)
    assert (done.code, done.err) == (2, f"--csv and --figure name one file, {tmp_path / 'a.csv'}. Name two.\n")


STOPPED = """
import sys
from vibopt.study import many as study
from vibopt.cli.main import main
alone, count = study.one_point, 0
def third(*words):
    global count
    count += 1
    if count == 3:
        {how}
    return alone(*words)
study.one_point = third
sys.exit(main(sys.argv[1:]))
"""


COUNTED = """
import sys
from vibopt.cli.main import main
from vibopt.study import many, edges
alone, count = many.one_point, 0
def counting(*words):
    global count
    count += 1
    return alone(*words)
many.one_point = counting
edges.boundaries = lambda *words: ()
from vibopt.study import sweep
sweep.boundaries = edges.boundaries
code = main(sys.argv[1:])
print(count, "answered", file=sys.stderr)
sys.exit(code)
"""


@pytest.mark.parametrize(
    ("how", "code"),
    [("raise KeyboardInterrupt", 130), ("import os, signal; os.kill(os.getpid(), signal.SIGKILL)", -signal.SIGKILL)],
    ids=["interrupted", "killed"],
)
def test_a_sweep_that_is_stopped_keeps_its_points_and_goes_on(run: Run, fan: Path, how: str, code: int) -> None:
    out = fan.with_name("out.csv")
    words = ["sweep", str(fan), "--vary", f"{BOUND}=10 N..30 N", "--points", "5", "--csv", str(out)]
    program = [sys.executable, "-c", STOPPED.format(how=how), *words]
    done = subprocess.run(program, capture_output=True, text=True, cwd=ROOT, check=False)
    assert done.returncode == code, done.stderr
    rows = list(csv.reader(out.read_text(encoding="utf-8").splitlines()))
    assert [row[:2] for row in rows] == [
        ["limits.force.at_most [N]", "status"],
        ["10.0", "optimal"],
        ["15.0", "optimal"],
    ]
    assert sorted(os.listdir(fan.parent)) == ["fan.toml", "out.csv", "out.csv.points"]
    if code == 130:
        goes_on = "; the same command with --resume goes on."
        assert done.stderr.strip() == f"Stopped. {out} holds 2 of 5 points{goes_on}"
    assert is_ours(out.read_bytes())
    whole = fan.with_name("whole.csv")
    assert run(*words[:-1], str(whole)).code == 0
    journal = fan.with_name("out.csv.points")
    told = journal.read_text(encoding="utf-8")
    journal.write_text(told + told.splitlines()[-1][:40], encoding="utf-8")  # a last line that was cut
    out.write_text(out.read_text(encoding="utf-8")[:-40], encoding="utf-8")
    assert not is_ours(out.read_bytes())
    counted = [sys.executable, "-c", COUNTED, *words, "--resume"]
    done = subprocess.run(counted, capture_output=True, text=True, cwd=ROOT, check=False)
    assert (done.returncode, done.stderr.strip()) == (0, "3 answered")
    assert out.read_bytes() == whole.read_bytes()
    assert sorted(os.listdir(fan.parent)) == ["fan.toml", "out.csv", "whole.csv"]


def test_what_cannot_be_gone_on_with_is_said(run: Run, fan: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.csv"
    journal = tmp_path / "out.csv.points"
    words = ["sweep", str(fan), "--vary", f"{BOUND}=10 N..30 N", "--points", "3", "--resume"]
    done = run(*words)
    assert (done.code, done.err) == (2, "--resume goes on with the points beside a --csv FILE. Name it.\n")
    done = run(*words, "--csv", str(out))
    said = f"--resume: there is no {journal} to go on with. Leave --resume out to begin.\n"
    assert (done.code, done.err) == (2, said)
    journal.write_text("vibopt sweep 12\n", encoding="utf-8")
    done = run(*words, "--csv", str(out))
    said = (
        f"--resume: {journal} is of another problem, other ranges or another version of vibopt. Leave --resume out to "
        "begin anew.\n"
    )
    assert (done.code, done.err) == (2, said)
    journal.write_text('vibopt sweep 12\n{"varied": {}}\n', encoding="utf-8")
    kept = journal_of(out, "12")
    with pytest.raises(InputError, match=r"^--resume: .* is damaged\. Leave --resume out to begin anew\.$"):
        kept.take_up()
    done = run(*words, "--csv", "/dev/null")
    assert (done.code, done.err) == (2, "--resume: /dev/null is no file, and keeps no points. Name a file.\n")
    journal.write_text("my points\n", encoding="utf-8")
    done = run(*words[:-1], "--csv", str(out))
    said = f"{journal} cannot be written: it is there already, and vibopt did not write it. Name another --csv.\n"
    assert (done.code, done.err) == (2, said)
    assert journal.read_text(encoding="utf-8") == "my points\n"
