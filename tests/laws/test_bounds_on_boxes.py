"""Bounds on a box of designs hold at every design in it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from chain_machine import Chain, chains
from lone_mass import LoneMass, lone_masses
from test_chains import asked, read
from vibopt.forms import rational
from vibopt.forms.bounds import FormBounds
from vibopt.forms.rational import sampled, sampled_lines
from vibopt.program.pose import pose
from vibopt.program.program import Program
from vibopt.scene.read import from_dict
from vibopt.solve.branch import Judge, Proof, Search, first_speeds
from vibopt.solve.global_search import BranchAndBound
from vibopt.work import Budget

few = settings(derandomize=True, database=None, deadline=None, max_examples=25, suppress_health_check=list(HealthCheck))
many = settings(few, max_examples=150)


def hold(program: Program, seed: int) -> None:
    """Random boxes, some of them tiny; random designs inside, corners among them."""
    rng = np.random.default_rng(seed)
    low, high = np.maximum(program.low, 1e-9 * program.high), program.high
    middle = np.sqrt(low * high)
    for part in (*program.limits, *([program.aim] if program.aim else [])):
        bounds = FormBounds(part.model, part.form, middle)
        if not bounds.bounded:
            continue
        bounds.add(first_speeds(part.form))
        reach = np.array([1.0, 0.3, 1e-2, 1e-4])[:, None]
        centre = rng.uniform(size=(len(reach), len(low)))
        corners = [low * (high / low) ** np.clip(centre + side * reach / 2, 0, 1) for side in (-1, 1)]
        for a, b, below, above in zip(*corners, *bounds.on(*corners), strict=True):
            for _ in range(4):
                x = a * (b / a) ** rng.choice([rng.uniform(), 0.0, 1.0], len(a))
                most, fewest = (part.form.worst(part.model, x, least_wanted=least).value for least in (False, True))
                assert below <= most * (1 + 1e-9) + 1e-300, part.name
                assert above >= fewest * (1 - 1e-9), part.name


@given(case=lone_masses(wide=True), seed=st.integers(0, 2**32 - 1))
@few
def test_bounds_of_one_mass_hold(case: LoneMass, seed: int) -> None:
    hold(pose(from_dict(case.document)), seed)


@given(chain=chains(), seed=st.integers(0, 2**32 - 1))
@settings(few, max_examples=12)
def test_bounds_of_chains_hold(chain: Chain, seed: int) -> None:
    hold(pose(read(chain, some(chain, 5))), seed)


def some(chain: Chain, step: int) -> dict[str, Any]:
    """Each `step`-th of all possible limits."""
    return {name: words for name, (words, _, _) in list(asked(chain).items())[::step]}


@pytest.mark.slow
@given(case=lone_masses(wide=True), seed=st.integers(0, 2**32 - 1))
@many
def test_bounds_of_many_lone_masses_hold(case: LoneMass, seed: int) -> None:
    hold(pose(from_dict(case.document)), seed)


@pytest.mark.slow
@given(chain=chains(), seed=st.integers(0, 2**32 - 1))
@many
def test_bounds_of_many_chains_hold(chain: Chain, seed: int) -> None:
    hold(pose(read(chain, some(chain, 1))), seed)


SHAKEN = {"on": "b", "speed": "1..90 rad/s", "varies": "constant"}
TWO = {
    "bodies": {"a": {"mass": "3 kg"}, "b": {"mass": "2 kg"}},
    "links": {
        "low": {"between": ["a", "ground"], "stiffness": {"from": "1 kN/m", "to": "9 kN/m"}},
        "high": {"between": ["b", "a"], "stiffness": {"from": "1 kN/m", "to": "9 kN/m"}, "damping": "5 N s/m"},
    },
    "limits": {"motion": {"response": "displacement", "of": "a", "at_most": "1 mm", "combine": "sum"}},
    "goal": {"maximise": "stiffness", "of": "low"},
}


def test_speeds_taken_up_together_are_those_taken_up_one_by_one() -> None:
    """In their order, none twice: neither one that is the same but for rounding nor one that stands there before."""
    part = pose(from_dict(TWO | {"excitations": {"shaker": SHAKEN | {"kind": "force", "amplitude": "1 N"}}})).limits[0]
    speeds = [30.0, 10.0, 30.0 * (1.0 + 1e-14), 20.0, 10.0, float("inf"), 70.0]
    together, single = (FormBounds(part.model, part.form, np.array([3e3, 3e3])) for _ in range(2))
    assert together.add({"shaker": speeds, "another": [5.0]})
    assert [single.add({"shaker": speed}) for speed in speeds] == [True, True, False, True, False, False, True]
    assert together.speeds == single.speeds == {"shaker": [30.0, 10.0, 20.0, 70.0]}
    assert not together.add({"shaker": speeds})
    for low, high in (([1e3, 1e3], [9e3, 9e3]), ([2e3, 4e3], [2.1e3, 4.1e3])):
        corners = np.array([low]), np.array([high])
        np.testing.assert_allclose(together.on(*corners), single.on(*corners), rtol=1e-12)


def test_lines_of_an_excitation_are_sampled_together_as_each_alone() -> None:
    """Those in phase and those that are not, at each speed in the order of the lines."""
    orders = (("1", "0 deg"), ("2", "70 deg"), ("3", "0 deg"), ("5", "70 deg"), ("8", "0 deg"))
    rows = [{"order": int(one), "amplitude": f"{one} N", "phase": phase} for one, phase in orders]
    shaker = SHAKEN | {"kind": "harmonics", "harmonics": rows}
    part = pose(from_dict(TWO | {"excitations": {"shaker": shaker}})).limits[0]
    lines, output = part.form.harmonic.drives[0].lines, part.form.harmonic.output
    speeds, x, designs = np.array([4.0, 31.0, 77.0]), np.array([3e3, 3e3]), np.array([[2e3, 5e3], [8e3, 1e3]])
    found = sampled_lines(part.model, output, lines, speeds, x).square(designs).reshape(2, len(speeds), len(lines))
    assert len({line.vector.tobytes() for line in lines}) == 2
    for index, line in enumerate(lines):
        alone = sampled(part.model, output, line, speeds, x).square(designs)
        np.testing.assert_allclose(found[:, :, index], alone, rtol=1e-13)


@pytest.mark.sampled(3)
@pytest.mark.parametrize("combine", ["sum", "rss"])
@pytest.mark.parametrize("seed", range(3))
def test_bounds_of_several_harmonics_and_excitations_hold(combine: str, seed: int) -> None:
    orders = [{"order": 1, "amplitude": "3 N"}, {"order": 2.5, "amplitude": "2 N", "phase": "50 deg"}]
    shaken = {"gas": SHAKEN | {"kind": "harmonics", "harmonics": orders},
              "pump": SHAKEN | {"on": "a", "kind": "force", "amplitude": "1 N", "speed": "20..40 rad/s"}}  # fmt: skip
    motion = {"response": "displacement", "of": "a", "combine": combine}
    force = {"response": "transmitted_force", "through": "high", "combine": combine, "due_to": ["gas"]}
    limits = {"motion": motion | {"at_most": "1 mm"}, "force": force | {"at_least": "1 N"}}
    hold(pose(from_dict(TWO | {"excitations": shaken, "limits": limits})), seed)


@pytest.mark.parametrize("seed", range(3))
def test_bounds_of_the_damping_ratio_of_one_mass_hold(seed: int) -> None:
    link = {"between": ["a", "ground"], "stiffness": {"from": "1 kN/m", "to": "9 kN/m"}}
    damped = link | {"damping": {"from": "2 N s/m", "to": "900 N s/m"}}
    document = {"bodies": {"a": {"mass": {"from": "1 kg", "to": "7 kg"}}}, "links": {"low": damped},
                "limits": {"ratio": {"response": "damping_ratio", "at_least": "5 %"}},
                "goal": {"maximise": "stiffness", "of": "low"}}  # fmt: skip
    hold(pose(from_dict(document)), seed)


def on_equal_mounts(**words: Any) -> dict[str, Any]:
    """A machine in space on four equal mounts, or two pairs of them, the ground shaking."""
    open_ended = {"stiffness": {"from": "20 kN/m", "to": "1 MN/m"}, "shear_ratio": 0.6}
    foot = {"between": ["set", "floor"], "damping": {"from": "50 N s/m", "to": "9 kN s/m"}} | open_ended | words
    ends = [[[f"{x} m", f"{y} m", "0 m"] for y in (0.5, -0.5)] for x in (0.8, -0.8)]
    both = {"foot": foot | {"at": [*ends[0], *ends[1]]}}
    if words:
        both = {name: foot | {"at": end} for name, end in zip(("front", "rear"), ends, strict=True)}
    return {
        "bodies": {
            "set": {
                "mass": "300 kg",
                "centre": ["0.1 m", "0.03 m", "0.4 m"],
                "inertia": ["16 kg m2", "48 kg m2", "55 kg m2"],
            }
        },
        "bases": {"floor": {}},
        "mounts": both,
        "excitations": {
            "floor": {
                "kind": "base_motion",
                "on": "floor",
                "direction": "x",
                "displacement": "0.2 mm",
                "speed": "1..30 Hz",
                "varies": "constant",
            }
        },
        "limits": {"force": {"response": "transmitted_force", "into": "floor", "direction": "z", "at_most": "1 kN"}},
        "goal": {"minimise": "rotation", "of": "set", "axis": "y"},
    }


@pytest.mark.parametrize(
    ("words", "degrees"),
    [({}, [(7, 7), (6, 6)]), ({"damping": "800 N s/m"}, [(5, 5), (5, 5)])],
    ids=["four alike", "two pairs"],
)
def test_bounds_in_space_hold_and_are_no_longer_than_the_machine(
    words: dict[str, Any], degrees: list[tuple[int, ...]]
) -> None:
    """A determinant of six rows, or seven with what is read, holds no more factors than rows: ten were counted."""
    program = pose(from_dict(on_equal_mounts(**words)))
    kept = [part.form.groups(part.model) for part in program.parts]
    assert [one.degrees for one in kept if one is not None] == degrees
    hold(program, 5)


def numbers_of_a_box(document: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> tuple[float, int]:
    """Numbers multiplied to bound a goal on a box, and the work that is counted for it."""
    program, seen = pose(from_dict(document)), list[float]()
    assert program.aim is not None
    squares, values = rational._squares_added, rational._evaluated

    def squared(columns: Any, degrees: tuple[int, ...]) -> Any:
        seen.append(sum(len(column) * column.size for column in columns))
        return squares(columns, degrees)

    def valued(coefficients: Any, kappa: Any, lengths: tuple[int, ...]) -> Any:
        seen.append(4.0 * coefficients.shape[-1] * kappa.size / kappa.shape[-1])
        return values(coefficients, kappa, lengths)

    monkeypatch.setattr(rational, "_squares_added", squared)
    monkeypatch.setattr(rational, "_evaluated", valued)
    bounds = FormBounds(program.aim.model, program.aim.form, np.sqrt(program.low * program.high))
    bounds.add(first_speeds(program.aim.form))
    bounds.on(program.low[None], program.high[None])
    monkeypatch.undo()
    return sum(seen), bounds.work


def test_the_counted_work_of_a_box_grows_as_the_numbers_that_are_multiplied(monkeypatch: pytest.MonkeyPatch) -> None:
    """It grew as the coefficients alone, so that the work allowed lasted up to ten times as long in space."""
    wide = {"from": "50 N s/m", "to": "9 kN s/m"}
    machines = on_equal_mounts(), on_equal_mounts(damping="800 N s/m"), on_equal_mounts(damping=wide)
    numbers, work = np.array([numbers_of_a_box(one, monkeypatch) for one in machines]).T
    assert numbers[2] > 100.0 * numbers[1]
    assert np.ptp(np.log(work / numbers)) < np.log(1.3)


def test_a_search_of_boxes_ends_by_its_work_and_not_a_batch_later() -> None:
    search = Search(Judge(pose(from_dict(on_equal_mounts()))), gap=1e-9, work=Budget(200_000, "coefficients"))
    assert search.run().status == "open"
    each = sum(bounds.work for bounds in [*search.forms, *search.aim_bounds])
    assert 200_000 <= search.work.spent <= 200_000 + each


def test_what_is_left_open_bounds_what_was_dropped_too(monkeypatch: pytest.MonkeyPatch) -> None:
    """Boxes within the gap of the best are dropped: no bound is above them, though that of each open box is."""

    def step(search: Search, most: int) -> int:
        _, low, high = search.open.take(most)
        search.best, search.best_x = 1.0, low[0]
        search.open.add(np.array([0.9]), low, high)
        return 1

    monkeypatch.setattr(Search, "_step", step)
    search = Search(Judge(pose(from_dict(on_equal_mounts()))), gap=0.3, budget=Budget(1, "boxes"))
    assert search.run().bound == pytest.approx(0.7)


def test_a_design_at_the_bound_of_a_search_that_was_ended_is_proven(monkeypatch: pytest.MonkeyPatch) -> None:
    program = pose(from_dict(on_equal_mounts(damping="800 N s/m")))
    best = BranchAndBound().solve(program)
    assert best.x is not None
    value = Judge(program).goal(best.x).value

    def ended(part: float) -> Callable[..., Proof]:
        def run(search: Search, *_: object) -> Proof:
            search.best = value
            return Proof("open", best.x, value, part * value, 1)

        return run

    monkeypatch.setattr(Search, "run", ended(1.0))
    found = BranchAndBound().solve(program)
    assert (found.status, found.bound) == ("optimal", pytest.approx(value, rel=1e-6))
    monkeypatch.setattr(Search, "run", ended(0.9))
    assert "with a gap of 1.0e-01 of the goal" in BranchAndBound(alone=False).solve(program).claim
