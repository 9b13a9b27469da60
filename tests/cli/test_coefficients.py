"""Coefficients that are saved and read again, what runs make of them, and the trim after a verification run."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from refusals import refused
from vibopt.jobs import answer, open_job

FAN = Path(__file__).parents[2] / "problems" / "balancing" / "fan_verification_run.toml"
NEXT = """
title = "the same fan, a year later"
influence = "coefficients.toml"
[conventions]
phase = "lead"
readings = "phase"
angles = "with rotation"
detector = "rms"
zero = "Reflective  tape"
[planes.left]
radius = "120 mm"
[planes.right]
radius = "150 mm"
[[runs]]
speed = "20 Hz"
readings = { a = "50 µm pp @ -20 deg", b = "30 µm pp @ 100 deg" }
"""
AFTER = """
[[runs]]
name = "after"
speed = "20 Hz"
weights = { left = "3 g @ 200 deg", right = "4 g @ 20 deg" }
verification = true
readings = { a = "12 µm pp @ 40 deg", b = "9 µm pp @ 250 deg" }
"""
Run = Callable[..., Any]


def phasor(size: float, degrees: float) -> complex:
    return complex(size * np.exp(1j * np.radians(degrees)))


@pytest.fixture
def saved(run: Run, tmp_path: Path) -> Path:
    """The coefficients of the fan in a file."""
    file = tmp_path / "coefficients.toml"
    done = run("solve", str(FAN), "--save-coefficients", str(file))
    assert (done.code, done.out.endswith(f"Written: {file}\n")) == (0, True)
    return file


def own(saved: Path) -> dict[tuple[str, str], complex]:
    """Coefficients of the file by hand [mm pp/(kg m)], angles in the sense of rotation, vibration as it leads."""
    found = re.findall(
        r'sensor = "(\w)"\nplane = "(\w+)"\nvalue = "(\S+) mil pp/\(g mm\) @ (\S+) deg"', saved.read_text()
    )
    return {(sensor, plane): phasor(float(size) * 25.4e3, -float(angle)) for sensor, plane, size, angle in found}


def test_saved_coefficients_balance_the_machine_at_another_radius_in_other_conventions(saved: Path) -> None:
    """The file counts lag against rotation at 150 mm, the next job lead with rotation at 120 mm."""
    file = saved.with_name("next.toml")
    file.write_text(NEXT)
    found = answer(open_job(file))
    H = own(saved)
    M = np.array([[H["a", "left"], H["a", "right"]], [H["b", "left"], H["b", "right"]]])
    u = np.linalg.solve(M, -np.array([phasor(0.050, -20.0), phasor(0.030, 100.0)]))
    assert found.status == "optimal"
    for name, radius, one in (("left", 0.12, u[0]), ("right", 0.15, u[1])):
        assert float(found.find(f"planes.{name}.mass").value) == pytest.approx(abs(one) / radius * 1e3 * 1e-3, rel=1e-9)
        turned = float(found.find(f"planes.{name}.angle").value)
        assert np.exp(1j * turned) == pytest.approx(one / abs(one), abs=1e-9)


def test_a_run_after_the_correction_refines_ready_coefficients_and_gives_the_trim(saved: Path) -> None:
    """Broyden's update by hand: of all coefficients that give both runs, those that change the old ones least."""
    file = saved.with_name("next.toml")
    file.write_text(NEXT + AFTER)
    found = answer(open_job(file))
    H = own(saved)
    M = np.array([[H["a", "left"], H["a", "right"]], [H["b", "left"], H["b", "right"]]])
    y0 = np.array([phasor(0.050, -20.0), phasor(0.030, 100.0)])
    y1 = np.array([phasor(0.012, 40.0), phasor(0.009, 250.0)])
    on = np.array([0.003 * 0.12 * phasor(1.0, 200.0), 0.004 * 0.15 * phasor(1.0, 20.0)])
    scaled = on / np.abs(on)
    missed = y1 - y0 - M @ on
    M = M + np.outer(missed, scaled.conj() / np.vdot(scaled, scaled).real) / np.abs(on)
    assert y0 + M @ on == pytest.approx(y1, rel=1e-12)
    u = np.linalg.solve(M, -y0)
    for name, radius, best, there in (("left", 0.12, u[0], on[0]), ("right", 0.15, u[1], on[1])):
        assert float(found.find(f"planes.{name}.mass").value) == pytest.approx(abs(best) / radius, rel=1e-8)
        assert float(found.find(f"trim.{name}.mass").value) == pytest.approx(abs(best - there) / radius, rel=1e-8)
        turned = np.exp(1j * float(found.find(f"trim.{name}.angle").value))
        assert turned == pytest.approx((best - there) / abs(best - there), abs=1e-8)
    assert "put back into a simulated rotor, which shows the same" in found.claim


def test_two_runs_with_nearly_the_same_weights_do_not_turn_coefficients_round(saved: Path) -> None:
    """Weights that differ by a hundredth differ in their readings by errors: in their direction nothing is learnt."""
    file = saved.with_name("next.toml")
    file.write_text(NEXT + AFTER)
    once = answer(open_job(file))
    near = AFTER.replace("3 g", "3.02 g").replace('name = "after"', 'name = "again"').replace("12 µm", "13 µm")
    file.write_text(NEXT + AFTER.replace("verification = true\n", "") + near)
    twice = answer(open_job(file))
    for name in ("left", "right"):
        first, second = (float(one.find(f"planes.{name}.mass").value) for one in (once, twice))
        assert second == pytest.approx(first, rel=0.1)


def test_trim_and_plan_come_together_to_the_same_rotor() -> None:
    found = answer(open_job(FAN))
    on = {"left": 0.011 * phasor(1.0, 325.0), "right": 0.006 * phasor(1.0, 65.0)}
    for name, there in on.items():
        parts = [
            float(found.find(f"{family}.{name}.mass").value)
            * np.exp(1j * float(found.find(f"{family}.{name}.angle").value))
            for family in ("trim", "planes")
        ]
        assert there + parts[0] == pytest.approx(parts[1], rel=1e-12)


def test_the_trim_says_what_to_add_and_in_holes_what_to_fit_instead(tmp_path: Path) -> None:
    file = tmp_path / "fan.toml"
    text = FAN.read_text(encoding="utf-8").partition("[[expected]]")[0]
    file.write_text(text, encoding="utf-8")
    said = answer(open_job(file)).plan.words
    assert said[0] == 'The weights of run "correction fitted" stay on. What changes them into the best ones:'
    assert said[1:3] == (
        "left: add 1.175 g at radius 150 mm, 137.6 deg against rotation from the reflective tape.",
        "right: add 0.8101 g at radius 150 mm, 144.4 deg against rotation from the reflective tape.",
    )
    assert said[3] == "Or take every weight off and fit the whole anew, on the rotor as found:"
    cap = 'weight = { from = "0 g", to = "60 g" }'
    file.write_text(text.replace(cap, 'holes = 24\nshelf = ["5 g", "10 g"]', 1), encoding="utf-8")
    said = answer(open_job(file)).plan.words
    assert said[1] == (
        "left: take off what is fitted; fit 10 g at radius 150 mm in hole 23 at 330 deg against rotation from the "
        "reflective tape."
    )


@pytest.mark.parametrize("file", ["balancing/fan_verification_run", "shafts/three_disc_turbine"])
@pytest.mark.parametrize("second", ["one.toml", "./folder/../one.toml"])
def test_a_design_and_coefficients_are_not_written_over_each_other(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, file: str, second: str
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder").mkdir()
    done = run("solve", str(FAN.parents[1] / f"{file}.toml"), "--save", "one.toml", "--save-coefficients", second)
    message = "one.toml is to hold the design and the coefficients: name two files.\n"
    assert (done.code, done.out, done.err) == (2, "", message)
    assert not (tmp_path / "one.toml").exists()


def test_what_was_taken_away_stays_away_and_a_saved_plan_takes_the_trim_away(run: Run, tmp_path: Path) -> None:
    file, saved = tmp_path / "drilled.toml", tmp_path / "plan.toml"
    cap = 'weight = { from = "0 g", to = "60 g" }'
    file.write_text(FAN.read_text(encoding="utf-8").partition("[[expected]]")[0].replace(cap, "remove = true", 1))
    first = run("solve", str(file), "--save", str(saved), "--json").data["words"]
    again = run("solve", str(saved), "--json").data["words"]
    assert first[1].startswith("left: take away 1.175 g at radius 150 mm, 317.6 deg")
    assert (again[1], again[4]) == (first[1], first[4])


def test_the_balancing_job_of_a_rotor_of_discs_is_written_again_until_somebody_changes_it(
    run: Run, tmp_path: Path
) -> None:
    job, design = tmp_path / "job.toml", tmp_path / "design.toml"
    words = ("solve", str(FAN.parents[1] / "shafts/three_disc_turbine.toml"), "--save-coefficients", str(job))
    first, again = run(*words, "--no-prices"), run(*words, "--no-prices")
    assert (first.code, again.code, again.err) == (0, 0, "")
    job.write_text(job.read_text(encoding="utf-8").replace("title = ", "title  = "), encoding="utf-8")
    assert run(*words, "--save", str(design)).code == 2
    assert not design.exists()


@pytest.mark.parametrize("options", [(), ("--round", "0.5 g", "--round", "5 deg")])
def test_a_plan_that_is_saved_or_rounded_never_says_to_add_the_whole_to_what_is_on(
    run: Run, tmp_path: Path, options: tuple[str, ...]
) -> None:
    """Each sentence that adds to the weights that stay on adds the trim, not the weight that takes their place."""
    saved = tmp_path / "plan.toml"
    first = run("solve", str(FAN), *options, "--save", str(saved), "--json").data
    again = run("solve", str(saved), "--json").data
    for name in ("left", "right"):
        assert again["trim"][name]["mass"]["value"] == pytest.approx(first["trim"][name]["mass"]["value"], rel=1e-9)
    for data in (first, again) if options else (again,):
        stays, left, right, anew, *whole = data["words"]
        assert stays == 'The weights of run "correction fitted" stay on. What changes them into the best ones:'
        assert anew == "Or take every weight off and fit the whole anew, on the rotor as found:"
        assert [left, right] == [one.replace(": fit", ": take off what is fitted; fit") for one in whole]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            'zero = "Reflective  tape"',
            'zero = "keyway"',
            'coefficients.toml line 10: counts angles from "reflective tape", this job from "keyway": nothing says how '
            "the two lie to each other. Write the same words where they are one mark; else measure the coefficients "
            "anew.",
        ),
        (
            'influence = "coefficients.toml"',
            'influence = "coeficients.toml"',
            "next.toml line 3: coeficients.toml is not there. Name the file that solve --save-coefficients has "
            "written, relative to the problem file.",
        ),
        (
            'influence = "coefficients.toml"',
            'influence = "empty.toml"',
            "next.toml line 3: empty.toml is empty. Name a file that solve --save-coefficients has written (.toml).",
        ),
        (
            'speed = "20 Hz"',
            'speed = "30 Hz"',
            "coefficients.toml line 12: no coefficient is for a plane, a sensor and a speed of this job. Name another "
            "file.",
        ),
        (
            'weights = { left = "3 g @ 200 deg", right = "4 g @ 20 deg" }\n',
            "",
            'next.toml line 21: run "after" has verification = true, but no weights: the weights of the correction are '
            "on in a verification run. Write them, or leave verification out.",
        ),
    ],
)
def test_what_does_not_fit_is_told(saved: Path, old: str, new: str, message: str) -> None:
    file = saved.with_name("next.toml")
    file.write_text((NEXT + AFTER).replace(old, new))
    saved.with_name("empty.toml").touch()
    error = refused(open_job, file)
    there = [re.sub(r"\S*/", "", one) for one in error.messages]
    assert there == [message]


def test_coefficients_that_are_not_known_are_not_saved(run: Run, tmp_path: Path) -> None:
    target, silent = tmp_path / "x.toml", tmp_path / "silent.toml"
    done = run("solve", str(FAN.with_name("rao_9_3.toml")), "--save-coefficients", str(target))
    assert (done.code, done.err) == (
        2,
        "rao_9_3.toml: a shaft with known masses has no influence coefficients: they are learnt from the runs of a "
        "measured rotor. Leave --save-coefficients out.\n",
    )
    text = re.sub(r"(mil|µm pp) @ [-\d]+ deg", r"\1", FAN.read_text(encoding="utf-8"))
    text = re.sub(r"(phase|readings|scatter) = (\"|{ amplitude).*\n", "", text).replace("verification = true\n", "")
    more = "".join(f"""[[runs]]
speed = "1200 rpm"
weights = {{ left = "10 g @ {angle} deg" }}
readings = {{ a = "7 mil", b = "6 mil" }}
""" for angle in (30, 150))  # fmt: skip
    more += "".join(f"""[[runs]]
speed = "1200 rpm"
weights = {{ right = "10 g @ {angle} deg" }}
readings = {{ a = "7 mil", b = "6 mil" }}
""" for angle in (30, 290))  # fmt: skip
    silent.write_text(text.partition("[[expected]]")[0] + more, encoding="utf-8")
    done = run("solve", str(silent), "--save-coefficients", str(target))
    assert (done.code, done.err) == (
        2,
        "silent.toml: readings without phase tell no influence coefficient: its angle is not known. Leave "
        "--save-coefficients out.\n",
    )
    assert not target.exists()


def test_ready_coefficients_are_told_as_refined_where_runs_with_weights_refine_them(run: Run, saved: Path) -> None:
    file = saved.with_name("next.toml")
    for text, words in ((NEXT, "ready; condition"), (NEXT + AFTER, "ready, refined by runs with weights in their")):
        file.write_text(text)
        assert f"coefficients  {words}" in run("explain", str(file)).out
