"""What all weights of a plane weigh together: as it is capped, as it is told, and where nothing is to be fitted."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from itertools import combinations, product

import numpy as np
import pytest

from rotor_jobs import FAN, solve_text
from vibopt.answer.answer import Answer
from vibopt.arrays import FloatArray
from vibopt.balancing.known import KnownJob, read_known, solve_known
from vibopt.document.mistakes import Mistakes
from vibopt.study.prices import asked_of

SHAFT = """[shaft]
bearings = {{ A = "0 mm", B = "600 mm" }}
speed = "3000 rpm"
{masses}{planes}[limits.most]
response = "correction"
at_most = "{most} g"
{of}
[goal]
minimise = "unbalance"
combine = "{combine}"
"""
Mass = tuple[float, float, float]
MASSES = [(18500, 96, 330), (13300, 338, 980), (6540, 109, 470)]
"""Unbalance [g mm], angle [deg] and place [mm]."""
BETWEEN = [(22980, 246, 210), (13640, 101, 170), (14880, 77, 190), (7980, 234, 240)]
BESIDE = """[planes.p0]
at = "250 mm"
radius = "80 mm"
holes = 8
shelf = ["20 g", "50 g", "120 g"]
most_weights = 2
[planes.p1]
at = "400 mm"
radius = "80 mm"
"""


def text_of(planes: str, most: float, of: str, combine: str = "rms", masses: Sequence[Mass] = MASSES) -> str:
    each = [
        f'[masses.m{k}]\nunbalance = "{u} g mm"\nangle = "{angle} deg"\nat = "{at} mm"\n'
        for k, (u, angle, at) in enumerate(masses)
    ]
    return SHAFT.format(planes=planes, most=most, of=of, combine=combine, masses="".join(each))


def shaft(planes: str, most: float, of: str, combine: str = "rms", masses: Sequence[Mass] = MASSES) -> Answer[KnownJob]:
    text = text_of(planes, most, of, combine, masses)
    return solve_known(read_known(tomllib.loads(text), Mistakes("shaft.toml")))


def turned(degrees: float) -> complex:
    return complex(np.exp(1j * np.radians(degrees)))


def levers(z: float) -> FloatArray:
    """What a unit at z [mm] is at both bearings, (2,)."""
    return np.array([(600 - z) / 600, z / 600])


def least(most: float) -> float:
    """Of every filling of the holes that weighs so much at most [g], beside the best free weight: rms [g mm]."""
    known = [(u * turned(angle), at) for u, angle, at in MASSES]
    found = sum(u * levers(z) for u, z in known)
    single = list(product(range(8), (20, 50, 120)))
    pairs = [(one, two) for one, two in combinations(single, 2) if one[0] != two[0]]
    best = np.inf
    for filling in [(), *((one,) for one in single), *pairs]:
        if sum(mass for _, mass in filling) <= most:
            left = found + levers(250) * sum(80 * mass * turned(45 * hole) for hole, mass in filling)
            h = levers(400)
            best = min(best, float(np.linalg.norm(left - h * (h @ left) / (h @ h)) / np.sqrt(2)))
    return best


@pytest.mark.parametrize("most", [60.0, 110.0, 223.0, 239.0])
def test_a_limit_on_a_shelf_plane_is_one_on_the_sum_of_its_weights(most: float) -> None:
    """Two weights apart do less together than they weigh: 120 and 120 g an eighth of a turn apart act as 222 g."""
    answer = shaft(BESIDE, most, 'of = "p0"')
    assert answer.status == "optimal"
    assert answer.goal is not None
    assert float(answer.goal[1].value) * 1e6 == pytest.approx(least(most), rel=1e-6)
    assert sum(one.mass for one in answer.plan.planes[0].weights) * 1e3 <= most
    assert answer.limits["most"].met


def test_a_plane_in_which_nothing_helps_is_told_without_weights() -> None:
    """Far outside both bearings a weight of the total does more harm than one between them does good."""
    between = '[planes.p0]\nat = "250 mm"\nradius = "50 mm"\nholes = 8\nsplit = true\n'
    outside = '[planes.p1]\nat = "1000 mm"\nradius = "80 mm"\nholes = 8\nsplit = true\n'
    outside += 'forbidden = ["21.5..221.5 deg"]\n'
    both, alone = (shaft(one, 191.0, "total = true", "worst", BETWEEN) for one in (between + outside, between))
    assert [plane.words for plane in both.plan.planes[1:]] == ["p1: no weight."]
    assert both.goal is not None
    assert alone.goal is not None
    assert float(both.goal[1].value) == pytest.approx(float(alone.goal[1].value), rel=1e-6)


def test_where_nothing_has_to_be_corrected_nothing_is_fitted() -> None:
    """The limits hold of the shaft as it is, so that the least correction is none."""
    planes = '[planes.p0]\nat = "100 mm"\nradius = "80 mm"\nholes = 12\nsplit = true\n[planes.p1]\nat = "250 mm"\n'
    planes += 'radius = "100 mm"\nremove = true\n[planes.p2]\nat = "800 mm"\nradius = "80 mm"\n'
    planes += 'holes = 8\nshelf = ["9 g"]\n'
    text = text_of(planes, 9000, "total = true")
    text = text.partition("[limits")[0] + '[limits.a]\nresponse = "bearing_reaction"\nat_most = "9 kN"\n'
    answer = solve_known(read_known(tomllib.loads(text + '[goal]\nminimise = "correction"\n'), Mistakes("shaft.toml")))
    assert [plane.words for plane in answer.plan.planes] == [f"p{k}: no weight." for k in range(3)]
    assert answer.goal is not None
    assert answer.goal[1].value == 0.0


def test_the_mass_of_a_plane_is_that_of_all_its_weights() -> None:
    """In a table of values, in JSON and beside the single weights."""
    box = 'holes = 12\nmost_weights = 2\nshelf = ["3 g", "5 g", "8 g"]\n'
    cut = "holes = 12\nsplit = true\n"
    text = FAN.replace('[planes.left]\nradius = "150 mm"\n', f'[planes.left]\nradius = "150 mm"\n{box}')
    plan = solve_text(text.replace('[planes.right]\nradius = "150 mm"\n', f'[planes.right]\nradius = "150 mm"\n{cut}'))
    for plane in plan.plan.planes:
        whole = sum(one.mass for one in plane.weights)
        assert len(plane.weights) == 2
        assert whole * 0.15 > abs(plane.u) * (1 + 1e-6)
        assert float(plan.find(f"planes.{plane.name}.mass").value) == whole
        assert plane.to_json()["mass"]["value"] == whole
        assert float(plan.find(f"planes.{plane.name}.acts_as").value) * 0.15 == pytest.approx(abs(plane.u), rel=1e-12)


def test_a_trim_that_with_what_is_on_passes_the_cap_says_so() -> None:
    """A cap holds for the whole as one weight; beside what stays on, the trim is a second one."""
    run = '[[runs]]\nspeed = "1200 rpm"\nverification = true\nweights = { left = "7 g @ 300 deg" }\n'
    run += 'readings = { a = "6.57 mil @ 81 deg", b = "5.0 mil @ 217 deg" }\n'
    said = []
    for cap in ("9 g", "90 g"):
        capped = FAN.replace("[planes.right]", f'weight = {{ from = "0 g", to = "{cap}" }}\n[planes.right]')
        said.append(next(one for one in solve_text(capped + run).plan.words if one.startswith("left: add")))
    beyond = (
        " With the 7 g that are on these are more than the cap of 9 g, which holds for the whole as one weight: fit it "
        "anew where the sum counts."
    )
    assert said[0].endswith(beyond)
    assert "cap" not in said[1]


def test_what_misses_a_limit_over_the_scatter_is_told_of_the_worst_rotor() -> None:
    """As the readings say the nearest plan would keep the limit; the worst rotor within the scatter does not."""
    asked = (
        '[limits.all]\nresponse = "residual"\nat_most = "0.6 mil"\n[goal]\nminimise = "residual"\ncombine = "worst"\n'
    )
    scatter = '[scatter]\namplitude = "5 %"\nangle = "3 deg"\n'
    plan = solve_text(FAN + scatter + asked + 'robust = "worst"\n')
    assert plan.status == "infeasible"
    assert plan.nearest is not None
    limit = plan.nearest.limits["all"]
    assert not limit.met
    assert limit.limit is not None
    for sensor in "ab":
        assert float(plan.nearest.values[f"sensors.{sensor}.residual"].value) < float(limit.limit.value)
    assert limit.place.endswith("in the worst of 201 rotors within the scatter")
    assert float(limit.value.value) == pytest.approx(float(plan.nearest.least["all"].value.value), rel=1e-6)
    wide = asked.replace("0.6 mil", f"{float(limit.value.value) * 1.0001!r} m pk")
    assert solve_text(FAN + scatter + wide + 'robust = "worst"\n').status == "optimal"


def test_weights_of_the_goal_are_no_facts_to_argue_about() -> None:
    goal = '[goal]\nminimise = "residual"\ncombine = "huber"\nhuber_at = "1 mil"\n'
    plan = solve_text(FAN + goal + "[sensors.a]\nimportance = 0.5\n[sensors.b]\n" + '[rotor]\nmass = "80 kg"\n')
    paths = [fact.path for fact, _ in asked_of(plan)[0]]
    assert "rotor.mass" in paths
    assert not [path for path in paths if "importance" in path or "huber" in path]
