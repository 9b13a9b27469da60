"""What commands read: files and nothing else, of a size that is said, and never a word of a stranger's text."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import tracemalloc
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest

from refusals import refused
from vibopt.document.locate import Locator
from vibopt.errors import InputError
from vibopt.scene.read import from_text, read

Run = Callable[..., Any]
ROOT = Path(__file__).parents[2]
SECRET = "hunter2"
LONGEST = 400
VERBS: dict[str, tuple[str, ...]] = {
    "check": ("check", "FILE"),
    "solve": ("solve", "FILE"),
    "explain": ("explain", "FILE"),
    "whatif": ("whatif", "FILE", "--set", "a.b=1"),
    "compare": ("compare", "FILE", "OTHER"),
    "sweep": ("sweep", "FILE", "--vary", "a.b=1..2"),
    "plot": ("plot", "FILE", "-o", "out.svg"),
    "report": ("report", "FILE", "-o", "out.html"),
    "verify": ("verify", "FILE"),
    "chart": ("chart", "speed-accuracy", "FILE"),
}
NAMERS = {
    "catalogue": '[links.m]\nbetween = ["a", "ground"]\npart = { catalogue = "FILE" }\n',
    "mass": '[structures.s]\nmass = "FILE"\nstiffness = "FILE"\npoints = { a = 0 }\n',
    "matrices": '[structures.s]\nfile = "FILE"\npoints = { a = 0 }\n',
    "readings": 'readings = "FILE"\n[planes.left]\nradius = "1 m"\n',
}
"""Every key that names a file."""
WRONG = ("folder", "pipe", "device", "socket", "missing", "huge", "binary", "stranger", "blanks", "long")
BODY = '[bodies.a]\nmass = "1 kg"\n'


@pytest.fixture
def wrong(tmp_path: Path) -> Iterator[Callable[[str, str], str]]:
    """Makes something that is no good file, with an ending, and gives its name."""
    with ExitStack() as opened:

        def made(what: str, ending: str) -> str:
            file = tmp_path / f"w{ending}"
            if what == "folder":
                file.mkdir()
            elif what == "pipe":
                os.mkfifo(file)
            elif what == "device":
                file.symlink_to("/dev/zero")
            elif what == "socket":
                here = Path.cwd()
                os.chdir(tmp_path)  # a path to a socket may not be long
                opened.enter_context(socket.socket(socket.AF_UNIX)).bind(file.name)
                os.chdir(here)
            elif what == "long":
                return str(tmp_path / ("x" * 3000 + ending))
            elif what == "huge":
                with file.open("wb") as sparse:
                    sparse.truncate(3_000_000_000)
            elif what == "blanks":
                file.write_bytes(b"\n" * 1_900_000)
            elif what == "stranger":
                file.write_text(f"root:x:0:0;{SECRET};password={SECRET}\n" * 2)
            elif what == "binary":
                file.write_bytes(bytes(range(256)) * 40)
            return str(file)

        yield made


def judge(done: Any) -> None:
    assert done.code == 2, (done.out, done.err)
    assert done.err
    for line in done.err.splitlines():
        assert len(line) < LONGEST
        assert SECRET not in line


@pytest.mark.parametrize(
    ("verb", "what"), [(verb, what) for what in WRONG for verb in VERBS if (verb, what) != ("verify", "folder")]
)  # verify takes folders
def test_no_command_reads_what_is_no_problem_file(
    run: Run, wrong: Callable[[str, str], str], tmp_path: Path, what: str, verb: str
) -> None:
    words = {"FILE": wrong(what, ".toml"), "OTHER": str(ROOT / "problems" / "isolation" / "rao_9_34.toml")}
    done = run(*(words.get(one, one) for one in VERBS[verb]), "--json")
    if verb == "verify" and what in ("binary", "stranger", "blanks"):
        assert done.code == 6
        assert [row["ours"] for row in done.data["records"]] == ["input_error"]
        return
    assert (done.code, done.data["status"]) == (2, "input_error")
    for message in done.data["messages"]:
        assert len(message) < LONGEST
        assert SECRET not in message
    assert not (tmp_path / "out.svg").exists()


@pytest.mark.parametrize("key", NAMERS)
@pytest.mark.parametrize("what", WRONG)
def test_no_key_reads_what_is_no_file_of_its_kind(
    run: Run, wrong: Callable[[str, str], str], tmp_path: Path, what: str, key: str
) -> None:
    endings = {"mass": [".mtx", ".npz"], "matrices": [".npz"]}.get(key, [".csv"])
    for ending in endings:
        file = tmp_path / "scene.toml"
        body = "" if key == "readings" else BODY
        file.write_text(NAMERS[key].replace("FILE", wrong(what, ending)) + body, encoding="utf-8")
        judge(run("check", str(file)))


@pytest.mark.parametrize("key", NAMERS)
@pytest.mark.parametrize("name", ["\\u0000", "a\\u0000b.npz", "", "/dev/null", "\\u001b[2J.csv", "\\n"])
def test_no_name_of_a_file_is_a_crash(run: Run, tmp_path: Path, key: str, name: str) -> None:
    file = tmp_path / "scene.toml"
    file.write_text(NAMERS[key].replace("FILE", name) + ("" if key == "readings" else BODY), encoding="utf-8")
    done = run("check", str(file))
    judge(done)
    assert "\x1b" not in done.err


def test_a_name_with_the_sign_zero_is_told(run: Run) -> None:
    words = "has a sign of number 0 in its name, which no file name has. Take it out."
    assert run("check", "a\0b.toml").err == f"a?b.toml {words}\n"


def test_an_unreadable_file_is_told(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(BODY)

    def refuse(*words: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(os, "open", refuse)
    assert run("check", str(file)).err == "mine.toml cannot be read: Permission denied.\n"


MONSTERS = {
    "a key of 20000 steps": "a" + ".a" * 20_000 + " = 1\n",
    "a table of 20000 steps": "[" + "a" + ".a" * 20_000 + "]\n",
    "a key in braces of 20000 steps": "a = { a" + ".a" * 20_000 + " = 1 }\n",
    "brackets": "a = " + "[" * 100_000,
    "braces": "a = " + "{a=" * 100_000,
    "records in records": "".join(f"[[{'.'.join('a' * n)}]]\n" for n in range(1, 200)),
    "digits": "[bodies.a]\nmass = " + "9" * 100_000,
    "digits of sixteen": "[bodies.a]\nmass = 0x" + "f" * 100_000,
    "unknown keys": "".join(f"k{n} = 1\n" for n in range(3_000)),
    "unknown keys of a table": "[bodies.a]\n" + "".join(f"k{n} = 1\n" for n in range(3_000)),
    "bodies": "".join(f"[bodies.b{n}]\nmas = 1\n" for n in range(1_000)),
    "a long key": "[bodies.a]\n" + "k" * 100_000 + " = 1\n",
    "a long name": f"[bodies.{'k' * 100_000}]\nmass = 1\n",
    "a long unit": f'[bodies.a]\nmass = "1 {"kg " * 30_000}"\n',
    "blanks before a unit": f'[bodies.a]\nmass = "1{" " * 100_000}kg x"\n',
    "blanks in a unit": f'[bodies.a]\nmass = "1 m{" " * 100_000}x"\n',
    "blanks after all": f'[bodies.a]\nmass = "1 mm pp{" " * 100_000}x"\n',
    "commas": f'[bodies.a]\nmass = "{"1," * 50_000} kg"\n',
    "gaps": f'[bodies.a]\nmass = "{"100 " * 50_000}kg"\n',
    "dashes": f'[bodies.a]\nmass = "1{"-" * 100_000}kg"\n',
    "numbers": f'[bodies.a]\nmass = "{"1" * 100_000}"\n',
    "points": f'[bodies.a]\nmass = "1{".." * 50_000}2 kg"\n',
    "a list of a range": f'[excitations.a]\nkind = "force"\nspeed = [{"[" * 20}{"]" * 20}]\n',
    "signs of control": '[bodies."\\u0000\\u001b[2J\\n"]\nmass = 1\n',
    "another word for nothing": f'[bodies.a]\nmass = "{"nan" * 30_000}"\n',
}  # fmt: skip


@pytest.mark.parametrize("text", MONSTERS.values(), ids=MONSTERS)
def test_a_monstrous_file_is_refused_in_little_memory_and_few_words(text: str, tmp_path: Path) -> None:
    """Memory is measured, for time is not: what grows with the square of a text fills memory, or is seen below."""
    file = tmp_path / "m.toml"
    file.write_text(text, encoding="utf-8")
    tracemalloc.start()
    caught = refused(read, file)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 100e6
    assert len(caught.messages) <= 201
    for message in caught.messages:
        assert len(message) < LONGEST
        assert message.isprintable()


def steps_of(work: Callable[[], object]) -> int:
    """Function calls and lines that some work takes: a measure that is the same on every machine."""
    count = 0

    def seen(*words: object) -> Any:
        nonlocal count
        count += 1
        return seen

    sys.settrace(seen)
    try:
        work()
    finally:
        sys.settrace(None)
    return count


@pytest.mark.parametrize("text", ["a{} = 1\n", "[a.b{}]\nc = [1, 2]\n", "\n", "# a\n", "[[a]]\nb = {{ c = {} }}\n"])
def test_places_are_found_in_work_that_grows_with_the_text(text: str) -> None:
    once, twice = (
        steps_of(lambda n=n: Locator("".join(text.format(i) for i in range(n))).line_of(("a",))) for n in (200, 400)
    )
    assert twice < 2.2 * once


@pytest.mark.parametrize("sign", [" ", "\t", "x ", "[", "(", ") ", "1,", "-"])
def test_headings_of_any_length_are_read_at_once(sign: str, tmp_path: Path) -> None:
    """Forty thousand signs took hours where the work grew with their third power."""
    (tmp_path / "parts.csv").write_text(f"part;a{sign * 40_000}b [N];stiffness [N/mm]\nA;1;2\n")
    text = '[links.m]\nbetween = ["a", "ground"]\npart = { catalogue = "FOLDER/parts.csv" }\n' + BODY
    assert all(len(one) < LONGEST for one in refused(from_text, text.replace("FOLDER", str(tmp_path))).messages)
    rotor = tmp_path / "rotor.toml"
    rotor.write_text('readings = "parts.csv"\n[planes.left]\nradius = "1 m"\n')
    from vibopt.jobs import open_job

    with pytest.raises(InputError):
        open_job(rotor)


@pytest.mark.parametrize(
    "change",
    [
        "a" + ".a" * 20_000 + "=1",
        "bodies.a=" + "[" * 50_000,
        "x=" + "9" * 50_000,
        "bodies.a={ b" + ".b" * 20_000 + " = 1 }",
        "bodies.a.mass=" + "k" * 90_000,
    ],
)
def test_a_monstrous_change_is_refused_in_few_words(run: Run, tmp_path: Path, change: str) -> None:  # fmt: skip
    file = tmp_path / "mine.toml"
    link = '[links.m]\nbetween = ["a", "ground"]\nstiffness = "1 N/m"\n'
    file.write_text(f'{BODY}{link}[measures.f]\nresponse = "natural_frequency"\n')
    judge(run("solve", str(file), "--set", change))


NOWHERE = b"The answer cannot be written to standard output: "
STREAMS = {
    "closed": (">&-", 1, NOWHERE + b"it is closed. Send it to /dev/null to do without it.\n"),
    "all closed": (">&- 2>&- <&-", 1, b""),
    "full": ("> /dev/full", 1, NOWHERE + b"No space left on device.\n"),
    "left": ("| head -n 0", 0, b""),
    "thrown away": ("> /dev/null", 0, b""),
}  # fmt: skip


@pytest.mark.sampled(3)
@pytest.mark.parametrize(("where", "code", "said"), STREAMS.values(), ids=STREAMS)
@pytest.mark.parametrize("words", ["check problems/isolation/rao_9_35.toml", "--help", "schema", "--version"])
def test_an_output_that_takes_nothing_is_an_error_that_is_told(words: str, where: str, code: int, said: bytes) -> None:
    command = f"{sys.executable} -m vibopt {words} {where}"
    done = subprocess.run(["bash", "-o", "pipefail", "-c", command], capture_output=True, cwd=ROOT, check=False)
    assert (done.returncode, done.stderr) == (code, said)
