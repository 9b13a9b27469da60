"""Answers of the last files are kept: the page is the same, and nothing that has changed is answered by them."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from vibopt import jobs
from vibopt.answer.stored import NotStoredError, packed, unpacked
from vibopt.cli import answer_cache
from vibopt.cli.answer_cache import Asked, folder, keep, kept
from vibopt.cli.options import read_job
from vibopt.cli.solve_command import answered
from vibopt.study.prices import priced
from vibopt.work import each_answer_within

Run = Callable[..., Any]
ROOT = Path(__file__).parents[2] / "problems"
KINDS = (
    "isolation/rao_9_34", "absorbers/frame_three_storeys",
    "mounts/compressor_on_bought_mounts", "balancing/fan_16_blades", "balancing/foiles_min_max", "balancing/rao_9_3",
    "balancing/engine_v_twin", "balancing/rao_9_22", "absorbers/rao_9_64_quiet_speeds",
    "isolation/rao_9_28_printed_design",
)  # fmt: skip
PRESS = ROOT / "isolation" / "rao_9_34.toml"


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of its own for what is kept."""
    monkeypatch.setenv(answer_cache.OFF, str(tmp_path / "kept"))
    monkeypatch.setattr(answer_cache, "LEAST_WORK", 0.0)
    return tmp_path / "kept"


def keep_now(asked: Asked, answer: Any) -> None:
    keep(asked, "answer", answer, asked.stamps(), answer.work)


@pytest.fixture
def solved(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Names of the jobs that are solved from here on."""
    names: list[str] = []
    solve = jobs.answer

    def told(job: Any, **words: Any) -> Any:
        names.append(job.name)
        return solve(job, **words)

    monkeypatch.setattr(jobs, "answer", told)
    return names


@pytest.mark.parametrize("name", KINDS)
def test_an_answer_made_again_says_the_same_to_the_last_bit(name: str, home: Path) -> None:
    file = str(ROOT / f"{name}.toml")
    job = jobs.open_job(file)
    answer: Any = jobs.answer(job)
    answer = priced(answer) if jobs.is_scene(job) else answer
    asked = Asked(file, job)
    assert kept(asked, "answer") is None
    keep_now(asked, answer)
    again = kept(Asked(file, jobs.open_job(file)), "answer")
    assert again is not None
    assert again.report() == answer.report()
    assert json.dumps(again.to_json()) == json.dumps(answer.to_json())
    assert again.job.document == answer.job.document


@pytest.mark.parametrize(
    ("file", "words"),
    [(PRESS, ["plot"]), (ROOT / "balancing" / "rao_9_3.toml", ["report"]), (PRESS, ["report", "--sheet"])],
)
def test_a_page_of_a_kept_answer_is_that_of_a_fresh_one_and_solves_nothing(
    file: Path, words: list[str], run: Run, home: Path, tmp_path: Path, solved: list[str]
) -> None:
    page = tmp_path / ("page.svg" if words == ["plot"] else "page.html")
    both = []
    for fresh in (["--fresh"], []):
        done = run(words[0], str(file), *words[1:], "-o", str(page), *fresh)
        both.append((done.code, done.out, page.read_bytes()))
    assert both[0] == both[1]
    assert len(solved) == 1


def test_what_changes_the_answer_is_solved_anew(
    home: Path, tmp_path: Path, solved: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "press.toml"
    file.write_bytes(PRESS.read_bytes())

    def solves(*changes: str, method: str | None = None, fresh: bool = False) -> bool:
        before = len(solved)
        answered(Asked(str(file), read_job(str(file), changes), changes, method), fresh=fresh)
        return len(solved) > before

    assert solves()
    assert not solves()
    assert solves("limits.floor_force.at_most=9 kN")
    assert not solves("limits.floor_force.at_most=9 kN")
    assert solves(method="branch_and_bound")
    assert solves(fresh=True)
    with each_answer_within(100.0):
        assert solves()
    file.write_text(PRESS.read_text(encoding="utf-8").replace("300 kg", "310 kg"), encoding="utf-8")
    assert solves()
    assert not solves()
    monkeypatch.setattr(answer_cache, "program", lambda: ["another version"])
    assert solves()


def test_another_catalogue_is_another_question(run: Run, home: Path, tmp_path: Path, solved: list[str]) -> None:
    source = ROOT / "mounts" / "compressor_on_bought_mounts.toml"
    file, parts = tmp_path / "bought.toml", tmp_path / "mounts.csv"
    file.write_bytes(source.read_bytes())
    parts.write_bytes((source.parent / "mounts.csv").read_bytes())
    asked = Asked(str(file), jobs.open_job(file))
    key, before = asked.key("answer"), asked.stamps()
    parts.write_bytes(parts.read_bytes() + b"\n")
    assert asked.key("answer") not in ("", key)
    keep(asked, "answer", jobs.answer(asked.job), before, 1e9)
    assert not home.exists()  # what was read is no longer what lies there


@pytest.mark.parametrize("damage", ["cut", "digit", "empty", "other"])
def test_a_damaged_entry_is_as_good_as_none(damage: str, home: Path) -> None:
    job = jobs.open_job(PRESS)
    asked = Asked(str(PRESS), job)
    keep_now(asked, jobs.answer(job))
    entry = home / f"{asked.key('answer')}.json"
    text = entry.read_text(encoding="utf-8")
    wrong = {"cut": text[:-9], "digit": text.replace("6956917", "6956918"), "empty": "", "other": f"[]\n{text}"}
    assert kept(asked, "answer") is not None
    entry.write_text(wrong[damage], encoding="utf-8")
    assert kept(asked, "answer") is None


def test_no_more_is_kept_than_is_said_and_the_oldest_goes_first(home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(answer_cache, "MOST_ANSWERS", 3)
    job = jobs.open_job(PRESS)
    answer, keys = jobs.answer(job), []
    for count in range(5):
        asked = Asked(str(PRESS), job, (f"title=no {count}",))
        keys.append(asked.key("answer"))
        keep_now(asked, answer)
        os.utime(home / f"{keys[-1]}.json", ns=(count, count))
    assert sorted(one.stem for one in home.iterdir()) == sorted(keys[2:])
    monkeypatch.setattr(answer_cache, "MOST_BYTES", 10)
    keep_now(Asked(str(PRESS), job), answer)
    assert list(home.iterdir()) == []


@pytest.mark.parametrize(("work", "is_kept"), [(8.7, False), (8.9, True)])
def test_many_values_that_are_sooner_found_again_are_not_kept(
    work: float, is_kept: bool, home: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = ROOT / "balancing" / "foiles_min_max.toml"
    asked = Asked(str(file), jobs.open_job(file))
    answer = replace(jobs.answer(asked.job), work=work)
    assert len(answer.values) == 88
    monkeypatch.setattr(answer_cache, "MANY_VALUES", 87)
    keep_now(asked, answer)
    assert (kept(asked, "answer") is not None) is is_kept
    monkeypatch.setattr(answer_cache, "MANY_VALUES", 88)
    keep_now(asked, answer)
    assert kept(asked, "answer") is not None


@pytest.mark.parametrize(("beyond", "is_kept"), [(0.0, True), (0.1, False)])
def test_a_machine_that_is_sooner_solved_is_not_kept(
    beyond: float, is_kept: bool, home: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(answer_cache, "LEAST_WORK", float("inf"))
    work = answered(Asked(str(PRESS), jobs.open_job(PRESS)), fresh=True).work
    monkeypatch.setattr(answer_cache, "LEAST_WORK", work + beyond)
    asked = Asked(str(PRESS), jobs.open_job(PRESS))
    assert answered(asked, fresh=True).work == work
    assert (kept(asked, "answer") is not None) is is_kept


def test_the_press_and_what_its_limits_buy_are_sooner_found_than_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nor are the files of the program looked through where nothing of a file is kept."""
    monkeypatch.setenv(answer_cache.OFF, str(tmp_path / "kept"))
    monkeypatch.setattr(answer_cache, "program", lambda: pytest.fail("looked through"))
    answer = answered(Asked(str(PRESS), jobs.open_job(PRESS)), fresh=False, prices=True)
    assert answer.limits["floor_force"].price is not None
    assert not (tmp_path / "kept").exists()


def test_two_runs_at_once_read_whole_answers_or_none(home: Path) -> None:
    job = jobs.open_job(PRESS)
    answer, asked = jobs.answer(job), Asked(str(PRESS), job)
    key, said = asked.key("answer"), answer.report()

    def both(_: int) -> bool:
        keep_now(asked, answer)
        found = kept(asked, "answer")
        return found is None or found.report() == said

    with ThreadPoolExecutor(4) as pool:
        assert all(pool.map(both, range(12)))
    assert [one.name for one in home.iterdir()] == [f"{key}.json"]


def test_nothing_is_kept_where_it_is_turned_off_or_where_nothing_can_be_written(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(answer_cache.OFF, "off")
    assert folder() is None
    (tmp_path / "file").write_text("x", encoding="utf-8")
    monkeypatch.setenv(answer_cache.OFF, str(tmp_path / "file" / "in"))
    done = run("solve", str(PRESS))
    assert (done.code, done.err) == (0, "")


def test_it_lies_in_the_users_folder_for_what_may_be_thrown_away(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.delenv(answer_cache.OFF, raising=False)
    monkeypatch.setattr("sys.platform", "linux")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert folder() == tmp_path / "vibopt" / "answers"
    monkeypatch.setattr("sys.platform", "win32")
    monkeypatch.setenv("LOCALAPPDATA", str(tmp_path / "local"))
    assert folder() == tmp_path / "local" / "vibopt" / "answers"


def test_only_what_an_answer_is_built_of_is_made() -> None:
    with pytest.raises(NotStoredError):
        packed(Path("x"), str)
    for kind in ("Path", "os.system", "Scene"):
        with pytest.raises(KeyError):
            unpacked({"is": kind, "of": {}}, str)
