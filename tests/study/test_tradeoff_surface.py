"""Three quantities weighed: no design is better in all, each curve ends where solve says, wrong asking is told."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import vibopt as vo
from refusals import refused
from vibopt.answer.console import Console
from vibopt.cli import tradeoff_command
from vibopt.report.figures import tradeoff_figure
from vibopt.study.sweep_series import fronts_of
from vibopt.study.tradeoff_surface import Surface

PRESS = Path(__file__).parents[2] / "problems" / "isolation" / "rao_9_34.toml"
MASS, FORCE, SPEED = 300.0, 30e3, 100.0 * np.pi
BOTH = ("limits.floor_force", "limits.start_up")


@pytest.fixture(scope="module")
def surface() -> Surface:
    return vo.tradeoff_surface(job(), BOTH, 5)


def job() -> Any:
    ends = {"stiffness.from": "1 MN/m", "stiffness.to": "20 MN/m", "damping.from": "1 kN s/m"}
    return vo.with_changes(vo.read(PRESS), {f"links.mount.{path}": value for path, value in ends.items()})


def behind(k: Any, c: Any) -> tuple[Any, Any, Any]:
    """Force on the floor [N] and amplitude at speed [m], and the greatest amplitude on the way there, by formulas."""
    at_speed = FORCE / np.abs(k - MASS * SPEED**2 + 1j * c * SPEED)
    ratio = c / (2.0 * np.sqrt(k * MASS))
    top = np.sqrt(np.maximum(k / MASS * (1.0 - 2.0 * ratio**2), 0.0))
    greatest = FORCE / np.abs(k - MASS * np.minimum(top, SPEED) ** 2 + 1j * c * np.minimum(top, SPEED))
    return at_speed * np.hypot(k, c * SPEED), at_speed, greatest


def test_every_point_is_what_formulas_say_and_no_mount_is_better_in_all(surface: Surface) -> None:
    """Stiffness, damping, force and greatest amplitude of each; a million random mounts that keep the third limit."""
    got = np.array([[one.value for one in pair] for pair in surface.reached])
    k, c = np.array([[point.variables[f"links.mount.{name}"].value for name in ("stiffness", "damping")]
                     for point in surface.points]).T  # fmt: skip
    floor, _, start = behind(k, c)
    np.testing.assert_allclose(got, np.stack([floor, start], axis=1), rtol=1e-8)
    rng = np.random.default_rng(3)
    tried = np.exp(rng.uniform(np.log(1e6), np.log(2e7), 10**6)), np.exp(rng.uniform(np.log(1e3), np.log(1e6), 10**6))
    floor, at_speed, start = behind(*tried)
    keeps = at_speed <= 2.5e-3
    for stiffness, (force, motion) in zip(k, got, strict=True):
        better = (tried[0] > stiffness) & (floor < force) & (start < motion) & keeps
        assert not np.any(better & ((tried[0] > stiffness * (1.0 + 1e-6)) | (floor < force * (1.0 - 1e-6))))


def test_each_curve_ends_where_solve_says_and_its_points_are_near(surface: Surface) -> None:
    assert surface.gap <= 2.0 / 4.0 * (1.0 + 1e-6)
    curves = [indices for indices in list(surface.curves.values())[1:] if len(indices) > 1]  # the first is one design
    assert len(curves) >= 3
    for indices in curves:
        first, motion = surface.points[indices[0]], surface.reached[indices[0]][1].value
        force = f"{first.value.value * (1.0 + 1e-9):.17g} N"
        for part, status in ((1.0 - 3e-6, "infeasible"), (1.0 + 3e-6, "optimal")):
            changes = {"limits.floor_force.at_most": force, "limits.start_up.at_most": f"{motion * part:.17g} m"}
            assert vo.solve(vo.with_changes(job(), changes), explain=False).status == status


def test_curves_are_told_as_rows_and_drawn_with_their_names(surface: Surface) -> None:
    rows = surface.table()
    assert list(rows[0])[:4] == [
        "floor_force [N]", "start_up [m]", "limits.floor_force.at_most [N]", "limits.start_up.at_most [m]"
    ]  # fmt: skip
    assert len(rows) == len(surface.points) == sum(map(len, surface.curves.values()))
    fronts = fronts_of(surface)
    assert fronts[0].name == "floor_force 1.099 kN pk"
    assert (fronts[0].x_label, fronts[0].y_label) == ("start_up [mm pk]", "stiffness of mount [MN/m]")
    tradeoff_figure(*fronts)


@pytest.mark.parametrize("count", [0, 1, 2])
def test_designs_that_are_not_proven_are_told(surface: Surface, count: int) -> None:
    """Of the whole surface, of one, and of two: what is not proven best may be bettered."""
    points = tuple(replace(one, status="feasible" if k < count else "optimal") for k, one in enumerate(surface.points))
    console = Console(200)
    tradeoff_command._list_curves(replace(surface, points=points), console)
    told = (
        f"{len(points)} designs on {len(surface.curves)} curves, none {'of them ' if count else ''}better in all three"
    )
    assert told in console.text.splitlines()[1]
    some = {0: "", 1: "1 design is not proven best", 2: "2 of the designs are not proven best"}[count]
    text = " ".join(console.text.split())
    assert text.endswith(f"{some}: others may be better in all three there.") == bool(count)
    assert "but where nothing lies between, or only designs that another curve betters." in text


@pytest.mark.slow
def test_a_bound_loosened_far_hides_no_digits_of_what_is_reached() -> None:
    """A step v of velocity gives v / w of way and v w of acceleration: their product is v^2, w from both ends."""
    job = vo.read(PRESS.parents[1] / "shock" / "rao_9_49.toml")
    found = vo.tradeoff_surface(job, ("limits.rattle", "limits.shock"), 3)
    got = np.array([[one.value for one in pair] for pair in found.reached])
    np.testing.assert_allclose(got.prod(axis=1), 0.01**2, rtol=1e-9)
    np.testing.assert_allclose(got[[0, -1], 1], 0.01 * np.sqrt([1e5, 0.1]), rtol=2e-6)


def test_two_responses_in_words_are_weighed() -> None:
    found = vo.tradeoff_surface(job(), ("displacement of press over 0..3000 rpm", "most static_deflection of mount"), 3)
    assert found.names == ("displacement", "static_deflection")
    assert len(found.points) >= 3


@pytest.mark.parametrize(
    ("against", "points", "words"),
    [
        ((*BOTH, "measures.sag"), 5, "rao_9_34.toml: --against is given 3 times. A trade-off has one or two of them."),
        ((BOTH[0], BOTH[0]), 5,
         "rao_9_34.toml: --against limits.floor_force is given twice. Name another limit, or leave one out."),
        (BOTH, 2, "--points 2 is not between 3 and 60 for a trade-off of three quantities."),
        ((BOTH[0], "limits.start"), 5,
         'rao_9_34.toml: --against limits.start is no limit with at_most or at_least. Did you mean "limits.start_up"?'),
    ],
)  # fmt: skip
def test_what_cannot_be_weighed_is_told(against: tuple[str, ...], points: int, words: str) -> None:
    assert str(refused(lambda: vo.tradeoff_surface(vo.read(PRESS), against, points))) == words
