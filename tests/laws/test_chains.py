"""Chains and trees: what the optimiser believes is what the built machine does, and what the matrices by hand say."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings

from chain_machine import Chain, chains
from vibopt.program.pose import pose
from vibopt.program.program import Program
from vibopt.scene.read import from_dict
from vibopt.scene.scene import Scene
from vibopt.solve import solve
from vibopt.verify.certify import measure

few = settings(derandomize=True, database=None, deadline=None, max_examples=20, suppress_health_check=list(HealthCheck))
many = settings(few, max_examples=100)


def asked(chain: Chain) -> dict[str, tuple[dict[str, Any], str, str]]:
    """Every response that the chain can be asked for: (words, kind, place) by name."""
    made: dict[str, tuple[dict[str, Any], str, str]] = {}
    for name in chain.names:
        for kind, unit in (("displacement", "m"), ("velocity", "m/s"), ("acceleration", "m/s^2")):
            made[f"{kind}_{name}"] = ({"response": kind, "of": name, "at_most": f"1 {unit}"}, kind, name)
        made[f"into_{name}"] = ({"response": "transmitted_force", "into": name, "at_most": "1 N"}, "into", name)
        made[f"sag_{name}"] = ({"response": "static_deflection", "of": name, "at_most": "1 m"}, "static", name)
    for mode in range(1, len(chain.names) + 1):
        made[f"mode_{mode}"] = ({"response": "natural_frequency", "mode": mode, "at_most": "1 Hz"}, "mode", str(mode))
    for name in chain.links:
        across = {"response": "relative_displacement", "across": name, "at_most": "1 m"}
        made[f"across_{name}"] = (across, "relative_displacement", name)
        made[f"through_{name}"] = (
            {"response": "transmitted_force", "through": name, "at_most": "1 N"}, "through", name
        )  # fmt: skip
        made[f"pressed_{name}"] = ({"response": "static_deflection", "of": name, "at_most": "1 m"}, "static", name)
    return {name: one for name, one in made.items() if reached(chain, one[2]) or one[1] in ("static", "mode")}


def reached(chain: Chain, place: str) -> bool:
    """Whether the shaking arrives at a place: bodies hand it on, a base only begins it."""
    moved, todo = set(), [chain.on]
    while todo:
        here = todo.pop()
        moved.add(here)
        for words in chain.links.values():
            if here in words["between"]:
                todo += [end for end in words["between"] if end in chain.masses and end not in moved]
    ends = chain.links[place]["between"] if place in chain.links else [place]
    return any(end in moved for end in ends)


def read(chain: Chain, limits: dict[str, Any], goal: dict[str, Any] | None = None) -> Scene:
    return from_dict({**chain.document, "limits": limits, "goal": goal or {"minimise": "total_mass"}})


def by_hand(chain: Chain, x: dict[tuple[str, str, str], float], kind: str, place: str) -> float:
    if kind == "static":
        return chain.static(x, place)
    if kind == "mode":
        return chain.natural(x, int(place))
    return chain.greatest(x, kind, place)


def believed(program: Program, name: str, x: np.ndarray[Any, np.dtype[np.float64]]) -> float:
    limit = next(one for one in program.limits if one.name == name)
    return limit.form.worst(limit.model, x).value


def agree(chain: Chain) -> None:
    """The form on the full and the reduced model, the measurement, and the textbook, at one design."""
    questions = asked(chain)
    scene = read(chain, {name: words for name, (words, _, _) in questions.items()})
    full, small = pose(scene, reduce=False), pose(scene)
    design = chain.design(np.random.default_rng(7))
    chosen = {".".join(path): value for path, value in design.items()}
    x = np.array([chosen[variable.path] for variable in scene.variables])
    for name, (_, kind, place) in questions.items():
        truth = by_hand(chain, design, kind, place)
        found = [believed(full, name, x), believed(small, name, x)]
        found.append(measure(scene, chosen, scene.limits[name]).value)
        assert found == pytest.approx([truth] * 3, rel=1e-8), name


@given(chain=chains())
@few
def test_forms_full_and_reduced_equal_the_measurement_and_the_textbook(chain: Chain) -> None:
    agree(chain)


@pytest.mark.slow
@given(chain=chains())
@many
def test_forms_equal_measurements_in_many_chains(chain: Chain) -> None:
    agree(chain)


def best_of(chain: Chain, limits: list[tuple[str, str, float]], path: tuple[str, str, str], sense: float) -> float:
    """Goal of the best of some hundred designs, sampled and then contracted around the best; inf where none holds."""
    rng = np.random.default_rng(3)
    best, at = np.inf, None
    pool = [chain.design(rng) for _ in range(150)]
    for reach in (0.0, 0.3, 0.05, 0.01):
        if reach:
            if at is None:
                return best
            pool = [
                {
                    key: float(np.clip(at[key] * np.exp(reach * rng.standard_normal()), *ends))
                    for key, ends in chain.ranges.items()
                }
                for _ in range(40)
            ]
        for x in pool:
            if sense * x[path] < best and all(by_hand(chain, x, kind, place) <= bound for kind, place, bound in limits):
                best, at = sense * x[path], x
    return best


def hold_to_claim(chain: Chain) -> None:
    """Limits that one design meets with little to spare; nobody samples a better one than the claimed."""
    some = chain.design(np.random.default_rng(11))
    questions, limits, kept = asked(chain), {}, []
    for name in list(questions)[:: max(1, len(questions) // 3)][:3]:
        words, kind, place = questions[name]
        bound = float(f"{1.1 * by_hand(chain, some, kind, place):.6g}")
        unit = words["at_most"].split(" ", 1)[1] if kind != "mode" else "rad/s"
        limits[name] = {**words, "at_most": f"{bound!r} {unit}"}
        kept.append((kind, place, bound))
    path = next(iter(chain.ranges))
    for sense, word in ((1.0, "minimise"), (-1.0, "maximise")):
        design = solve(read(chain, limits, {word: path[2], "of": path[1]}), explain=False)
        assert design.status in ("optimal", "feasible", "unproven"), design.claim
        if not design.x:
            continue
        found = {key: design.variables[".".join(key)].value.value for key in chain.ranges}
        for kind, place, bound in kept:
            assert by_hand(chain, found, kind, place) <= bound * (1 + 3e-9), (kind, place)
        if design.status == "optimal":
            claimed = sense * found[path]
            assert best_of(chain, kept, path, sense) >= claimed - 1.1e-6 * abs(claimed)


@given(chain=chains())
@settings(few, max_examples=1)
def test_no_sampled_chain_beats_a_claim(chain: Chain) -> None:
    hold_to_claim(chain)


@pytest.mark.slow
@given(chain=chains())
@settings(few, max_examples=20)
def test_no_sampled_chain_beats_a_claim_in_many_scenes(chain: Chain) -> None:
    hold_to_claim(chain)


@given(chain=chains())
@settings(few, max_examples=4)
def test_the_order_of_tables_changes_nothing(chain: Chain) -> None:
    questions = asked(chain)
    limits = {name: words for name, (words, _, _) in questions.items()}
    scene = read(chain, limits)
    turned = {key: dict(reversed(one.items())) if isinstance(one, dict) else one for key, one in scene.document.items()}
    turned["goal"] = scene.document["goal"]
    other = from_dict(dict(reversed(turned.items())))
    chosen = {".".join(path): value for path, value in chain.design(np.random.default_rng(5)).items()}
    values = []
    for one in (scene, other):
        x = np.array([chosen[variable.path] for variable in one.variables])
        values.append([believed(pose(one), name, x) for name in limits])
    assert values[0] == pytest.approx(values[1], rel=1e-9)


@pytest.mark.parametrize(("count", "seed"), [(3, 0), (4, 1), (6, 2), (9, 3), (13, 4)])
def test_a_floating_chain_without_dampers_is_told_within_a_thousand_periods_of_a_step(count: int, seed: int) -> None:
    """Forces by modes of matrices by hand, sampled over all that time: 1 - cos of each, on what goes ever faster."""
    rng = np.random.default_rng(seed)
    masses, springs = rng.uniform(1.0, 10.0, count), 10.0 ** rng.uniform(3.0, 4.0, count - 1)
    document = {
        "bodies": {f"b{i}": {"mass": f"{mass!r} kg"} for i, mass in enumerate(masses.tolist())},
        "links": {
            f"l{i}": {"between": [f"b{i}", f"b{i + 1}"], "stiffness": f"{one!r} N/m"}
            for i, one in enumerate(springs.tolist())
        },
        "excitations": {"push": {"kind": "pulse", "on": "b0", "shape": "step", "amplitude": "100 N"}},
        "measures": {"force": {"response": "peak_force", "through": "l1"}},
    }
    rows = np.diff(np.eye(count), axis=0)
    root = np.diag(masses**-0.5)
    squares, shapes = np.linalg.eigh(root @ rows.T @ np.diag(springs) @ rows @ root)
    speeds, moved = np.sqrt(squares[1:]), root @ shapes[:, 1:]
    waves = 100.0 * (springs[1] * rows[1] @ moved) * moved[0] / squares[1:]
    times = np.arange(0.0, 2000.0 * np.pi / speeds[0], 0.08 / speeds[-1])
    sampled = [np.abs(waves.sum() - np.cos(np.outer(one, speeds)) @ waves).max() for one in np.array_split(times, 50)]
    design = solve(from_dict(document))
    assert design.status == "met", design.claim
    assert design.measures["force"].value.value == pytest.approx(max(sampled), rel=2e-3)
    assert design.measures["force"].value.value >= max(sampled) * (1.0 - 1e-9)
    assert design.measures["force"].value.value <= abs(waves.sum()) + np.abs(waves).sum()
