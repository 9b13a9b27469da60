"""What a terminal shows while it works, what is said of work that is stopped, and what a shell completes."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from vibopt.cli.main import VERBS, main
from vibopt.cli.progress import Bar
from vibopt.frontier import Frontier
from vibopt.study import prices
from vibopt.work import Budget, spoken_time

Run = Callable[..., Any]
ROOT = Path(__file__).parents[2]


class Clock:
    """A clock that stands until it is set."""

    now = 0.0

    def __call__(self) -> float:
        return self.now


@pytest.mark.parametrize(
    ("steps", "words"),
    [
        ((), "vibopt: solving, 60 s so far"),
        (((10.0, "discs, 40 slices", 0.25),), "vibopt: discs, 40 slices, 25 % of it, 60 s so far, at most 3 min more"),
        (((30.0, "discs, 4 slices", 0.5), (50.0, "prices", 0.0)), "vibopt: prices, 60 s so far"),
        (((30.0, "sweep", 0.5), (50.0, "sweep", 0.1), (60.0, "sweep", 0.5)),
         "vibopt: sweep, 50 % of it, 60 s so far, about 10 s more"),
    ],
)  # fmt: skip
def test_a_line_says_stage_part_time_so_far_and_time_left(
    steps: tuple[tuple[float, str, float], ...], words: str
) -> None:
    clock = Clock()
    bar = Bar(clock)
    for at, doing, part in steps:
        clock.now = at
        bar(doing, part)
    clock.now = 60.0
    assert bar.line == words


@pytest.mark.parametrize(("seconds", "words"), [(0.2, "1 s"), (59.7, "60 s"), (180.0, "3 min"), (7800.0, "2 h 10 min")])
def test_times_are_said_in_what_matters(seconds: float, words: str) -> None:
    assert spoken_time(seconds) == words


def test_on_a_pipe_a_line_comes_a_minute_and_the_bar_ends_it(capsys: pytest.CaptureFixture[str]) -> None:
    with Bar(Clock()) as bar:
        first = bar._timer
        assert first is not None
        assert first.interval == 60.0
        bar._tell()
        again = bar._timer
        assert again is not first
    bar._tell()
    first.cancel()
    assert capsys.readouterr().err == "vibopt: solving, 1 s so far\n"


@pytest.mark.parametrize("verb", ["solve", "explain", "whatif", "compare", "sweep", "plot", "report"])
def test_every_verb_that_answers_takes_fresh(verb: str, run: Run) -> None:
    assert "--fresh" in run(verb, "--help").out


def test_solving_afresh_is_solving(run: Run, press: str) -> None:
    plain, again = (run("solve", press, "--json", *more).data for more in ((), ("--fresh",)))
    assert {**plain, "timings": {}} == {**again, "timings": {}}


@pytest.mark.parametrize("status", ["optimal", "infeasible"])
def test_what_is_worked_out_beside_an_answer_shows_what_it_is(
    status: str, run: Run, press: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    said: list[str] = []
    monkeypatch.setattr(Bar, "__call__", lambda _, doing, part: said.append(doing))
    tight = ("--set", "limits.start_up.at_most=1 mm") if status == "infeasible" else ()
    assert run("solve", press, "--json", *tight).data["status"] == status
    assert ("the design that comes nearest" in said) is (status == "infeasible")
    assert ("what loosening a limit buys" in said) is (status == "optimal")


def test_a_search_counts_what_it_has_looked_at() -> None:
    said: list[tuple[str, float]] = []
    search = Frontier(Budget(8, "boxes", spent=2), lambda doing, part: said.append((doing, part)), "branch and bound")
    assert not search.over
    assert said == [("branch and bound, 2 boxes", 0.25)]


@pytest.mark.parametrize(
    ("where", "cache", "words"),
    [
        ("answer", "off",
         "Stopped. Nothing was written: with --time-limit SECONDS a search ends by itself, with the best it has "
         "found."),
        ("prices", "off", "Stopped. Nothing was written."),
        ("prices", "",
         "Stopped. The answer that was found is kept in HOME: plot and report of the same file do not solve again."),
    ],
)  # fmt: skip
def test_whoever_stops_it_reads_what_is_left(
    where: str, cache: str, words: str, run: Run, press: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stop(*_: Any, **__: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setenv("VIBOPT_CACHE", cache or str(tmp_path / "kept"))
    monkeypatch.setattr("vibopt.cli.answer_cache.LEAST_WORK", 0.0)
    words = words.replace("HOME", str(tmp_path / "kept"))
    if where == "answer":
        monkeypatch.setattr("vibopt.jobs.answer", stop)
    else:
        monkeypatch.setattr(prices, "priced", stop)
    done = run("solve", press)
    assert (done.code, done.out, done.err.strip()) == (130, "", words)
    done = run("solve", press, "--json")
    assert (done.code, done.data) == (130, {"status": "interrupted", "messages": [words]})


ASKED = {
    ("vibopt", "so"): ["solve"],
    ("vibopt", "solve", "isolation/rao_9_34_p"): ["isolation/rao_9_34_printed_design.toml"],
    ("vibopt", "report", "isol"): ["isolation"],
    ("vibopt", "whatif", "isolation/rao_9_34.toml", "--set", "links.mount.st"): ["links.mount.stiffness="],
    ("vibopt", "solve", "isolation/rao_9_34.toml", "--method", "branch"): ["branch_and_bound"],
    ("vibopt", "help", "toleranc"): ["tolerances"],
    ("vibopt", "nonsense", "x"): [],
}  # fmt: skip


@pytest.mark.skipif(shutil.which("bash") is None or os.name != "posix", reason="no bash")
def test_bash_completes_verbs_files_paths_options_methods_and_topics(run: Run, tmp_path: Path) -> None:
    """In bash itself, by the lines that `vibopt completion bash` prints."""
    program = tmp_path / "vibopt"
    program.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m vibopt "$@"\n', encoding="utf-8")
    program.chmod(0o755)
    lines = [run("completion", "bash").out]
    for words in ASKED:
        quoted = " ".join(f"'{one}'" for one in words)
        lines += [f"COMP_WORDS=({quoted}); COMP_CWORD={len(words) - 1}; COMPREPLY=()", "_vibopt_completion vibopt 2>&1"]
        lines += ['echo "=${COMPREPLY[*]}"']
    paths = f"{tmp_path}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        ["bash", "--norc", "-c", "\n".join(lines)], capture_output=True, text=True, check=True, cwd=ROOT / "problems",
        env={**os.environ, "PATH": paths, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    said = [one for one in done.stdout.splitlines() if "compopt" not in one]
    assert said == [f"={' '.join(found)}" for found in ASKED.values()]


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_every_shell_has_its_lines(shell: str, run: Run) -> None:
    done = run("completion", shell)
    assert (done.code, done.err) == (0, "")
    assert f"_VIBOPT_COMPLETE={shell}_complete" in done.out
    assert run("completion", shell, "--json").data["script"] == done.out.rstrip("\n") + "\n"


def test_verbs_are_completed_without_loading_them() -> None:
    program = (
        "import sys\nfrom vibopt.cli.main import vibopt\nfrom click.shell_completion import BashComplete\n"
        "found = BashComplete(vibopt, {}, 'vibopt', 'X').get_completions([], '')\n"
        "print(*[one.value for one in found])\nprint(*[one for one in sys.modules if one.endswith('_command')])"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True, cwd=ROOT)
    assert done.stdout.splitlines() == [" ".join(VERBS), ""]


def test_an_unknown_shell_is_refused(run: Run) -> None:
    assert main(["completion", "tcsh"]) == 2
