"""Files that are written: whole or not at all, and never a surprise."""

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from vibopt.errors import InputError
from vibopt.files.writing import checked_target, write_file

Run = Callable[..., Any]
MAGIC = {"svg": b"<?xml", "png": b"\x89PNG", "pdf": b"%PDF"}


@pytest.mark.parametrize("form", MAGIC)
def test_plot_writes_the_format_of_the_ending(run: Run, press: str, tmp_path: Path, form: str) -> None:
    target = tmp_path / f"out.{form}"
    done = run("plot", press, "-o", str(target))
    assert (done.code, done.err) == (0, "")
    assert target.read_bytes().startswith(MAGIC[form])
    assert done.out.endswith(f"Written: {target}\n")
    assert os.listdir(tmp_path) == [target.name]


def test_plot_draws_the_map_when_asked(run: Run, press: str, tmp_path: Path) -> None:
    assert run("plot", press, "--map", "-o", str(tmp_path / "map.svg")).code == 0
    one = str(Path(press).with_name("rao_9_36.toml"))
    done = run("plot", one, "--map", "-o", str(tmp_path / "no.svg"))
    assert done.code == 2
    assert done.err == "rao_9_36.toml: a map needs exactly two variables that are not whole or listed.\n"
    assert not (tmp_path / "no.svg").exists()


def test_report_is_written_and_its_exit_code_is_that_of_the_answer(run: Run, press: str, tmp_path: Path) -> None:
    target = tmp_path / "page.html"
    done = run("report", press, "-o", str(target), "--set", "limits.start_up.at_most=8 mm", "--json")
    assert done.code == 3
    assert done.data["written"] == [str(target)]
    assert "limits.start_up.at_most=8 mm" in target.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("out.jpg", "out.jpg cannot be written: its ending tells the format, and it is none of .svg, .png, .pdf."),
        ("no/out.svg", "cannot be written: there is no folder"),
        ("folder.svg", "cannot be written: it is a folder. Name a file in it."),
    ],
)
def test_a_bad_place_is_told_before_anything_is_solved(
    run: Run, press: str, tmp_path: Path, name: str, text: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    import vibopt.cli.solve_command as verb

    monkeypatch.setattr(verb, "_answer", lambda *words: pytest.fail("solved"))
    (tmp_path / "folder.svg").mkdir()
    done = run("plot", press, "-o", str(tmp_path / name))
    assert done.code == 2
    assert text in done.err


def test_a_file_is_replaced_whole_with_its_rights_and_through_links(tmp_path: Path) -> None:
    target = tmp_path / "real.csv"
    target.write_text("old")
    target.chmod(0o640)
    link = tmp_path / "link.csv"
    link.symlink_to(target)
    write_file(checked_target(str(link), force=True), b"new")
    assert link.is_symlink()
    assert target.read_bytes() == b"new"
    assert target.stat().st_mode & 0o777 == 0o640
    assert sorted(os.listdir(tmp_path)) == ["link.csv", "real.csv"]


def test_nothing_is_left_when_writing_fails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    target = tmp_path / "out.csv"
    target.write_text("old")

    def refuse(old: object, new: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", refuse)
    with pytest.raises(InputError, match=r"out.csv cannot be written: no space left on device\.$"):
        write_file(target, b"new")
    assert target.read_text() == "old"
    assert os.listdir(tmp_path) == ["out.csv"]


def test_a_device_is_written_straight(tmp_path: Path) -> None:
    write_file(checked_target("/dev/null"), b"gone")
    assert not Path("/dev/null").is_file()


def test_a_map_on_which_a_line_of_equal_goal_has_no_point_is_drawn(run: Run, tmp_path: Path) -> None:
    """Some levels of the goal are on no part of the plane: matplotlib hands out a line without points."""
    (tmp_path / "case.toml").write_text(
        'title = "Instrument case"\n[bases.floor]\n[bodies.instrument]\nmass = "8 kg"\n'
        '[links.foam]\nbetween = ["instrument", "floor"]\nstiffness = { from = "1 kN/m", to = "1 MN/m" }\n'
        'damping = { from = "1 N s/m", to = "5 kN s/m" }\n'
        '[excitations.fall]\nkind = "pulse"\non = "floor"\nshape = "half sine"\nacceleration = "300 m/s2"\n'
        'duration = "8 ms"\n[limits.room]\nresponse = "peak_relative_displacement"\nacross = "foam"\n'
        'at_most = "25 mm"\n'
        '[goal]\nminimise = "peak_acceleration"\nof = "instrument"\n',
        encoding="utf-8",
    )
    done = run("plot", str(tmp_path / "case.toml"), "--map", "-o", str(tmp_path / "map.svg"))
    assert (done.code, done.err) == (0, "")
    assert (tmp_path / "map.svg").stat().st_size > 0
