"""Parts from a catalogue: seconds to the proven best, against looking at every combination one by one.

    python tests/bench/catalogue.py [parts ...]

line   two masses on two groups of four mounts each, or of one to four; limits on the static load of each mount, the
       lowest natural frequency, the amplitude over the whole run-up, and the price
space  one body of six coordinates on two groups of four mounts, each at its place; limits on each mount's load, the
       highest natural frequency, and the sway over the whole run-up

Least force into the floor, and least price.
"""

from __future__ import annotations

import sys
import tempfile
import time
from itertools import product
from pathlib import Path

import numpy as np

from vibopt.document.toml_reading import placed
from vibopt.program.pose import pose
from vibopt.program.program import Program
from vibopt.scene.read import from_dict, with_changes
from vibopt.scene.scene import Scene
from vibopt.solve import solve
from vibopt.solve.branch import Judge
from vibopt.solve.catalogue.choices import Choices, factors_of
from vibopt.solve.catalogue.parts import Catalogue

MOST_ENUMERATED = 100_000
HEADS = "part;rated load min [N];rated load max [N];stiffness [N/mm];loss factor;price [EUR]"


def catalogue(folder: Path, parts: int) -> None:
    """Parts spread over loads, hardness and prices as makers spread them."""
    rng = np.random.default_rng(parts)
    rows = [HEADS]
    for index in range(parts):
        load = 10 ** rng.uniform(2.6, 4.3)
        stiff = 1e-3 * load / rng.uniform(2e-3, 12e-3)
        price = 3.0 + 0.4 * load**0.55 * rng.uniform(0.8, 1.3)
        cells = (0.15 * load, load, stiff, rng.uniform(0.05, 0.25), price)
        rows.append(f"P{index};" + ";".join(f"{one:.5g}" for one in cells))
    (folder / "parts.csv").write_text("\n".join(rows), encoding="utf-8")


def scene(folder: Path, goal: dict[str, str], *, counts: bool) -> Scene:
    """A machine on a frame on a floor."""
    part = {"part": {"catalogue": "parts.csv"}, "count": {"from": 1, "to": 4, "whole": True} if counts else 4}
    document = {
        "bodies": {"machine": {"mass": "900 kg"}, "frame": {"mass": "1200 kg"}},
        "links": {
            "upper": {"between": ["machine", "frame"], **part},
            "lower": {"between": ["frame", "ground"], **part},
        },
        "excitations": {
            "shaft": {"kind": "unbalance", "on": "machine", "unbalance": "0.1 kg m", "speed": "1200..1500 rpm"}
        },
        "limits": {
            "bounce": {"response": "natural_frequency", "at_least": "3 Hz", "at_most": "8 Hz"},
            "run_up": {"response": "displacement", "of": "machine", "over": "start-up", "at_most": "1.5 mm"},
            "price": {"response": "price", "at_most": "400 EUR"},
        },
        "goal": goal,
    }
    return from_dict(placed(document, folder), name="bench.toml")


def space(folder: Path, goal: dict[str, str]) -> Scene:
    """A generator set on eight mounts in two groups."""
    corners = [[f"{x} m", f"{y} m", "0 m"] for x in (0.9, 0.4) for y in (0.4, -0.4)]
    part = {"between": ["genset", "ground"], "part": {"catalogue": "parts.csv"}, "shear_ratio": 0.4}
    force = {"kind": "force", "on": "genset", "direction": "z", "at": ["0.3 m", "0 m", "0.5 m"], "amplitude": "2 kN"}
    document = {
        "bodies": {
            "genset": {
                "mass": "1850 kg",
                "motion": "space",
                "centre": ["0.1 m", "0 m", "0.45 m"],
                "inertia": ["310 kg m2", "620 kg m2", "590 kg m2"],
            }
        },
        "mounts": {
            "front": {**part, "at": corners},
            "rear": {**part, "at": [[f"-{x}", y, z] for x, y, z in corners]},
        },
        "excitations": {"e": {**force, "speed": "1200..1500 rpm", "varies": "speed^2", "amplitude_at": "1500 rpm"}},
        "limits": {
            "sway": {
                "response": "displacement",
                "of": "genset",
                "direction": "x",
                "over": "start-up",
                "at_most": "1 mm",
            },
            "modes": {"response": "natural_frequency", "mode": 6, "at_most": "18 Hz"},
        },
        "goal": goal | ({"direction": "z"} if "into" in goal else {}),
    }
    return from_dict(placed(document, folder), name="bench.toml")


def enumerated(program: Program) -> tuple[float, float]:
    """Least goal over all combinations, and seconds."""
    began = time.perf_counter()
    judge, choices = Judge(program), Choices(factors_of(program), len(program.axes))
    best = np.inf
    for entries in product(*(range(len(one.table)) for one in choices.factors)):
        x = choices.designs(np.array([entries]))[0]
        if judge.feasible(x):
            best = min(best, judge.goal(x).value)
    return best, time.perf_counter() - began


def main() -> None:
    """A table of sizes."""
    sizes = [int(one) for one in sys.argv[1:]] or [20, 70, 150, 300, 1000]
    goals = {"force": {"minimise": "transmitted_force", "into": "ground"}, "price": {"minimise": "price"}}
    print(
        f"{'':>5} {'parts':>6} {'goal':>6} {'combinations':>13} {'seconds':>8} {'measured':>9} {'one by one':>11}  same"
    )
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for parts, (goal, words), kind in product(sizes, goals.items(), ("line", "line, 1 to 4", "space")):
            catalogue(folder, parts)
            if kind == "space":
                program = pose(space(folder, words))
            else:
                program = pose(scene(folder, words, counts=kind != "line"))
            print(f"{kind[:5]:>5} {parts:6} {goal:>6} {row(program)}", flush=True)
        print("\nspace, rubber off by 20 %: seconds to the choice that is proven best over the tolerances")
        for parts, (goal, words) in product(sizes, goals.items()):
            catalogue(folder, parts)
            print(f"{'space':>5} {parts:6} {goal:>6} {over_tolerances(space(folder, words))}", flush=True)


def over_tolerances(nominal: Scene) -> str:
    """The whole answer, certificate included."""
    began = time.perf_counter()
    design = solve(with_changes(nominal, {f"mounts.{one}.tolerance": "20 %" for one in nominal.mounts}), explain=False)
    seconds = time.perf_counter() - began
    return f"{design.details['combinations']:13} {seconds:8.2f} {design.details['measured']:9}  {design.status}"


def row(program: Program) -> str:
    """Both ways on one program."""
    began = time.perf_counter()
    found = Catalogue().solve(program)
    seconds = time.perf_counter() - began
    total = found.details["combinations"]
    line = f"{total:13} {seconds:8.2f} {found.details['measured']:9}"
    if total > MOST_ENUMERATED:
        return f"{line} {'-':>11}  -"
    best, slow = enumerated(program)
    same = abs(found.bound - best) <= 1e-9 * abs(best) if found.x is not None else not np.isfinite(best)
    return f"{line} {slow:9.1f} s  {'yes' if same else 'NO'}"


if __name__ == "__main__":
    main()
