"""The plane of one link's stiffness and damping: corners, rows, and answers that brute force cannot beat."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import vibopt as vo
from texts import skid
from vibopt.arrays import FloatArray
from vibopt.program.pose import pose
from vibopt.scene.read import from_dict, from_text
from vibopt.solve.branch import Judge
from vibopt.solve.global_search import BranchAndBound
from vibopt.solve.local import improved
from vibopt.solve.plane.absorber_newton import equal_peaks
from vibopt.solve.plane.conics import Conics, monomials
from vibopt.solve.plane.discs import DiscsOfOneLink
from vibopt.solve.plane.link_plane import LinkPlane
from vibopt.solve.ranges import closed, on_values


def scene(**changes: Any) -> dict[str, Any]:
    """A machine on a spring with a small mass on a chosen spring and damper."""
    document: dict[str, Any] = {
        "bodies": {"machine": {"mass": "100 kg"}, "small": {"mass": "5 kg"}},
        "links": {
            "base": {"between": ["ground", "machine"], "stiffness": "100 kN/m"},
            "tuner": {
                "between": ["machine", "small"],
                "stiffness": {"from": "1 kN/m", "to": "20 kN/m"},
                "damping": {"from": "1 N s/m", "to": "500 N s/m"},
            },
        },
        "excitations": {
            "shake": {
                "kind": "force",
                "on": "machine",
                "amplitude": "1 kN",
                "speed": "1..100 rad/s",
                "varies": "constant",
            }
        },
        "goal": {"minimise": "displacement", "of": "machine"},
    }
    return {**document, **changes}


def best_of(document: dict[str, Any]) -> tuple[Any, Any]:
    program = closed(pose(from_dict(document)))
    method = DiscsOfOneLink(most=500)
    assert method.refuses(program) is None
    return program, method.solve(program)


def bought(goal: dict[str, str]) -> dict[str, Any]:
    """A mass on a spring from a list beside an open mount; the spring of the resonance lies between the listed ones."""
    mount = {"stiffness": {"from": "1 kN/mm", "to": "4 kN/mm"}, "damping": {"from": "100 N s/m", "to": "4000 N s/m"}}
    return {
        "bodies": {"pump": {"mass": "300 kg"}},
        "links": {
            "bought": {"between": ["pump", "ground"], "stiffness": {"one_of": ["0.1 kN/mm", "60 kN/mm"]}},
            "mount": {"between": ["pump", "ground"], **mount},
        },
        "excitations": {
            "turning": {"kind": "force", "on": "pump", "amplitude": "3 kN", "speed": "3000 rpm", "varies": "constant"}
        },
        "goal": goal,
    }


def test_a_spring_from_a_list_beside_an_open_mount_is_one_that_is_listed() -> None:
    """The force into the ground over that on the pump, from |k + i w c| / |k - m w^2 + i w c| at every corner."""
    found = vo.solve(from_dict(bought({"maximise": "transmissibility", "into": "ground"})))
    w = 100.0 * np.pi
    k_bought, k, c = np.meshgrid([1e5, 6e7], np.geomspace(1e6, 4e6, 41), np.geomspace(100.0, 4000.0, 41))
    stiff = k_bought + k + 1j * w * c
    best = float(np.abs(stiff / (stiff - 300.0 * w**2)).max())
    assert found.status == "optimal"
    assert found.to_json()["goal"]["value"] == pytest.approx(best, rel=1e-9)
    assert found.to_json()["variables"]["links.bought.stiffness"]["value"] in (1e5, 6e7)


@pytest.mark.parametrize("goal", [{"minimise": "stiffness", "of": "mount"}, {"minimise": "total_mass"}])
def test_a_listed_spring_that_the_goal_does_not_feel_is_listed_too(goal: dict[str, str]) -> None:
    found = vo.solve(from_dict(bought(goal)))
    assert found.to_json()["variables"]["links.bought.stiffness"]["value"] in (1e5, 6e7)


def test_designs_and_tables_of_designs_are_moved_to_the_nearest_listed_values() -> None:
    program = closed(pose(from_dict(bought({"minimise": "stiffness", "of": "mount"}))))
    at = [axis.path for axis in program.axes].index("links.bought.stiffness")
    table = np.full((3, 3), 2e6)
    table[:, at] = [1.0, 3.1e7, 1e9]
    moved = on_values(program, table)
    assert moved[:, at].tolist() == [1e5, 6e7, 6e7]
    assert [on_values(program, one).tolist() for one in table] == moved.tolist()


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 10**6), count=st.integers(1, 7), begun=st.booleans())
def test_an_empty_set_of_corners_means_that_no_point_of_a_fine_grid_is_allowed(
    seed: int, count: int, begun: bool
) -> None:
    """Whichever rows are taken in first: those that hold some point back, or those that cut off the box."""
    rng = np.random.default_rng(seed)
    rows = rng.normal(size=(count, 5))
    rows[:, 1] = rows[:, 0] * rng.uniform(0.3, 3.0, count)
    if seed % 2:
        rows[:, 3] = 0.0
    low, high = np.array([0.1, 0.05]), np.array([2.0, 3.0])
    corners = Conics(rows, low, high).corners(rng.uniform(low, high) if begun else None)
    k, c = np.meshgrid(np.linspace(0.1, 2.0, 301), np.linspace(0.05, 3.0, 301))
    grid = np.stack([k.ravel(), c.ravel()], axis=-1)
    allowed = (rows @ monomials(grid) <= 0.0).all(axis=0)
    if allowed.any():
        assert len(corners)
    for point in corners:
        value = rows @ monomials(point[None, :])
        assert (value[:, 0] <= 1e-9 * np.abs(rows).sum(axis=1) * 10.0).all()


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 10**6), count=st.integers(1, 7), way=st.sampled_from([1.0, -1.0]))
def test_no_point_of_a_fine_grid_that_is_allowed_lies_beyond_the_extreme_corner(
    seed: int, count: int, way: float
) -> None:
    rng = np.random.default_rng(seed)
    rows = rng.normal(size=(count, 5))
    low, high = np.array([0.1, 0.05]), np.array([2.0, 3.0])
    extreme = Conics(rows, low, high).extreme(way)
    k, c = np.meshgrid(np.linspace(0.1, 2.0, 301), np.linspace(0.05, 3.0, 301))
    grid = np.stack([k.ravel(), c.ravel()], axis=-1)
    allowed = grid[(rows @ monomials(grid) <= 0.0).all(axis=0)]
    assert len(extreme) == 0 or np.ptp(extreme[:, 0]) <= 1e-12
    if len(allowed):
        assert way * extreme[0, 0] >= (way * allowed[:, 0]).max() - 1e-12
    assert (rows @ monomials(extreme) <= 1e-9 * np.abs(rows).sum(axis=1)[:, None] * 10.0).all()


def touching(seed: int, apart: float) -> tuple[Any, Any, Any]:
    """Two ellipses within a wide box that touch at a point, and lie apart from each other by a part of their size."""
    rng = np.random.default_rng(seed)
    meet, angle = rng.uniform(0.8, 1.2, 2), rng.uniform(0.0, 2.0 * np.pi)
    rows = []
    for way in (1.0, -1.0):
        half, size = rng.uniform(0.05, 0.3), rng.uniform(0.5, 2.0, 2)
        normal = way * np.array([np.cos(angle), np.sin(angle)])
        centre = meet + half * normal / size / np.sqrt((normal**2 / size).sum())
        half *= 1.0 - apart
        rest = float((size * centre**2).sum()) - half**2
        rows.append([*size, *(-2.0 * size * centre), rest])
    return np.array(rows), np.array([0.01, 0.01]), meet


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 10**6), apart=st.sampled_from([1e-2, 1e-4, 1e-6]))
def test_discs_that_do_not_meet_are_told_by_one_sum_of_their_rows(seed: int, apart: float) -> None:
    rows, low, meet = touching(seed, apart)
    high = np.array([3.0, 3.0])
    for lone in rows:  # one row alone leaves its disc
        assert not Conics(lone[None, :], low, high).left_empty(meet)
    assert Conics(rows, low, high).left_empty(meet)
    assert not len(Conics(rows, low, high).corners())
    overlapping = touching(seed, -apart)[0]
    assert not Conics(overlapping, low, high).left_empty(meet)
    assert len(Conics(overlapping, low, high).corners())


@settings(max_examples=200, deadline=None)
@given(seed=st.integers(0, 10**6), count=st.integers(1, 7))
def test_what_one_sum_of_rows_shows_to_be_empty_has_no_corner(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    rows = rng.normal(np.array([1.0, 1.0, 0.0, 0.0, 1.0]), 1.0, (count, 5))
    conics = Conics(rows, np.array([0.1, 0.05]), np.array([2.0, 3.0]))
    near = rng.uniform([0.1, 0.05], [2.0, 3.0])
    if conics.left_empty(near):
        assert not len(conics.corners())


def _worst_of_skid(motor: float, pads: float, k: FloatArray, c: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Way of the motor [m] and force on the floor [N] over 901 speeds, of mounts (n,)."""
    speed = np.linspace(600.0, 1500.0, 901) * np.pi / 30.0
    pad, mount = pads * 1e6 + 900j * speed, k[:, None] + 1j * speed * c[:, None]
    above, below = pad - speed**2 * motor, pad + mount - speed**2 * 420.0
    rest = above * below - pad**2
    push = 2e-3 * speed**2
    return np.abs(push * below / rest).max(axis=1), np.abs(mount * push * pad / rest).max(axis=1)


@example(motor=183.0, pads=3.21875, ratio=False)
@example(motor=183.0, pads=3.2, ratio=True)
@settings(max_examples=12, deadline=None)
@given(motor=st.floats(150.0, 220.0), pads=st.floats(2.5, 4.0), ratio=st.booleans())
def test_the_least_damping_of_a_mount_below_two_bodies_is_proven(motor: float, pads: float, ratio: bool) -> None:
    """What is allowed is no convex set: from many a design no way of small steps leads to the best."""
    damper = 'damping_ratio = { from = 0.0001, to = 2 }\nrelative_to = "skid"'
    damper = damper if ratio else 'damping = { from = "10 N s/m", to = "200 kN s/m" }'
    goal = "damping_ratio" if ratio else "damping"
    answer: Any = vo.solve(
        vo.from_text(skid(motor, pads, f'minimise = "{goal}"\nof = "mount"', damper)), method="discs", explain=False
    )
    assert answer.status == "optimal"
    best = answer.goal[1].value
    stiffness = np.geomspace(1e4, 1e8, 400)
    for part in (0.5, 0.8, 0.97, 0.999):
        size = 2.0 * np.sqrt(stiffness * 420.0) if ratio else np.ones(400)
        way, force = _worst_of_skid(motor, pads, stiffness, part * best * size)
        least = part * best < (1e-4 if ratio else 10.0)  # below the range
        assert least or not ((way <= 5e-5) & (force <= 150.0)).any()


@pytest.mark.parametrize("bound", ["65 mm", "80 mm", "200 mm"])
@pytest.mark.parametrize("sense", ["maximise", "minimise"])
def test_the_stiffness_that_exchange_finds_is_the_best_of_branch_and_bound(bound: str, sense: str) -> None:
    limits = {"amplitude": {"response": "displacement", "of": "machine", "at_most": bound}}
    program, found = best_of(scene(limits=limits, goal={sense: "stiffness", "of": "tuner"}))
    other = BranchAndBound().solve(program)
    assert found.status == other.status == "optimal"
    assert found.details["goal"] == pytest.approx(other.details["goal"], rel=2e-6)
    assert Judge(program).limit(program.limits[0], found.x)[0] == pytest.approx(0.0, abs=1e-11)


def test_the_absorber_on_an_undamped_mass_reaches_the_least_possible_peak() -> None:
    """Nishihara and Asami, mass ratio 0.05: 6.40792076800462 static deflections of 10 mm, at a known design."""
    _, found = best_of(scene())
    assert found.status == "optimal"
    assert found.details["goal"] == pytest.approx(6.40792076800462e-2, rel=1e-11)
    tuning, ratio = 0.95237204433511, 0.133937726515742
    own = np.sqrt(1e5 / 100.0)
    assert found.x == pytest.approx([5.0 * (tuning * own) ** 2, 2.0 * ratio * 5.0 * tuning * own], rel=1e-5)


@pytest.mark.parametrize("ratio", [0.01, 0.02, 0.05])
@pytest.mark.parametrize("goal", ["displacement", "velocity", "acceleration"])
def test_an_absorber_alone_needs_no_search(ratio: float, goal: str) -> None:
    """Newton on equal peaks gives the best design, and one sum of rows the proof; a search from afar finds the same."""
    document = scene(goal={"minimise": goal, "of": "machine"})
    document["bodies"]["small"]["mass"] = f"{100 * ratio} kg"
    document["links"]["tuner"]["stiffness"] = {"from": "100 N/m", "to": "200 kN/m"}
    document["links"]["tuner"]["damping"]["to"] = "5 kN s/m"
    program = closed(pose(from_dict(document)))
    x = equal_peaks(LinkPlane.of(program))
    found = DiscsOfOneLink().solve(program)
    assert found.status == "optimal"
    assert found.details["rounds"] == 0
    assert found.x == pytest.approx(x, rel=0.0, abs=0.0)
    afar = improved(program, np.sqrt(program.low * program.high), Judge(program))
    assert Judge(program).goal(afar).value >= Judge(program).goal(found.x).value * (1.0 - 1e-12)


@pytest.mark.parametrize("mass", ["0 kg", "1e-9 kg"])
def test_a_link_to_what_weighs_nothing_is_proven(mass: str) -> None:
    """It has no second peak that could be as high as the first."""
    document = scene()
    document["bodies"] = {"machine": {"mass": "100 kg"}, "foot": {"mass": mass}}
    document["links"]["base"]["between"] = ["machine", "foot"]
    document["links"]["tuner"]["between"] = ["foot", "ground"]
    document["links"]["tuner"]["damping"]["to"] = "5 kN s/m"
    _, found = best_of(document)
    assert found.status == "optimal"
    speeds = np.linspace(1.0, 100.0, 4000)

    def size(k: float, c: float) -> float:
        held = 1.0 / (1.0 / 1e5 + 1.0 / (k + 1j * speeds * c))
        return float((1e3 / np.abs(held - 100.0 * speeds**2)).max())

    best = found.details["goal"]
    assert size(*found.x) == pytest.approx(best, rel=1e-6)
    every = [size(k, c) for k in np.geomspace(1e3, 2e4, 40) for c in np.geomspace(1.0, 5e3, 60)]
    assert min(every) >= best * (1.0 - 2e-6)


@pytest.mark.parametrize(
    "said",
    [{"damping_ratio": 0.1}, *(pytest.param(one, marks=pytest.mark.slow) for one in ({"loss_factor": 0.2}, {}))],
)
def test_a_mount_is_chosen_beside_an_absorber_whose_spring_goes_with_its_mass(said: dict[str, float]) -> None:
    """No design drawn at random is stiffer; the absorber's own spring moves with the third variable."""
    chosen = {"stiffness": {"from": "10 kN/m", "to": "1 MN/m"}, "damping": {"from": "100 N s/m", "to": "10 kN s/m"}}
    document = scene(
        bodies={"machine": {"mass": "100 kg"}},
        links={"base": {"between": ["ground", "machine"], **chosen}},
        absorbers={
            "small": {"on": "machine", "mass": {"from": "1 kg", "to": "20 kg"}, "frequency": "30 rad/s", **said}
        },
        limits={"floor": {"response": "transmitted_force", "into": "ground", "at": "100 rad/s", "at_most": "200 N"}},
        goal={"maximise": "stiffness", "of": "base"},
    )
    answer: Any = vo.solve(from_dict(document), explain=False)
    assert answer.status in ("optimal", "feasible")
    least, most, w = np.array([1e4, 1e2, 1.0]), np.array([1e6, 1e4, 20.0]), 100.0
    drawn = (least * (most / least) ** np.random.default_rng(5).random((20000, 3))).T

    def floor(k: Any, c: Any, mass: Any) -> Any:
        spring = 900.0 * (1.0 + 1j * said.get("loss_factor", 0.0)) + 60j * w * said.get("damping_ratio", 0.0)
        held, moved = k + 1j * w * c, spring * -(w**2) / (spring - w**2)
        return 1e3 * np.abs(held / (held - 100.0 * w**2 + mass * moved))

    paths = "links.base.stiffness", "links.base.damping", "absorbers.small.mass"
    best = [answer.variables[path].value.value for path in paths]
    assert floor(best[0], best[1], best[2]) <= 200.0 * (1.0 + 1e-8)
    assert drawn[0][floor(*drawn) <= 200.0].max() <= best[0]


def test_the_least_mass_under_a_limit_is_proven() -> None:
    document = scene(
        bodies={"machine": {"mass": "100 kg"}, "small": {"mass": {"from": "0.5 kg", "to": "20 kg"}}},
        limits={"amplitude": {"response": "displacement", "of": "machine", "at_most": "64.0792076800462 mm"}},
        goal={"minimise": "mass", "of": "small"},
    )
    _, found = best_of(document)
    assert found.status == "optimal"
    assert found.details["goal"] == pytest.approx(5.0, rel=2e-6)


def test_a_limit_below_the_least_possible_peak_is_proven_infeasible() -> None:
    limits = {"amplitude": {"response": "displacement", "of": "machine", "at_most": "64.079 mm"}}
    _, found = best_of(scene(limits=limits, goal={"minimise": "damping", "of": "tuner"}))
    assert found.status == "infeasible"


def test_an_amplitude_that_can_be_zero_is_proven_to_be_the_best() -> None:
    document = scene()
    document["links"]["tuner"]["damping"] = {"from": "0 N s/m", "to": "500 N s/m"}
    document["excitations"]["shake"]["speed"] = "40 rad/s"
    program, found = best_of(document)
    assert found.status == "optimal"
    assert Judge(program).goal(found.x).value <= 1e-12


def test_an_undamped_absorber_that_stills_its_host_is_proven_at_once() -> None:
    """One variable, and a goal of zero: no gap in parts of the goal could ever be reached."""
    document = scene()
    document["links"]["tuner"].pop("damping")
    document["excitations"]["shake"]["speed"] = "31 rad/s"
    design = vo.solve(from_dict(document))
    assert design.status == "optimal"
    assert design.claim == "proven: what the goal counts is zero, up to rounding, and cannot be less"
    assert design.x[0] == pytest.approx(5.0 * 31.0**2, rel=1e-9)


@pytest.mark.parametrize("unit", ["", "%"])
@pytest.mark.parametrize("method", ["discs", "branch_and_bound"])
def test_an_isolation_that_leaves_nothing_is_whole(method: str, unit: str) -> None:
    """Tuned to the speed, an undamped absorber stills its host, of which then nothing reaches the ground."""
    document = scene()
    document["links"]["tuner"].pop("damping")
    if method == "discs":
        document["links"]["tuner"]["damping"] = {"from": "0 N s/m", "to": "500 N s/m"}
    document["excitations"]["shake"]["speed"] = "31 rad/s"
    document["goal"] = {"maximise": "isolation", "into": "ground", **({"unit": unit} if unit else {})}
    design = vo.solve(from_dict(document), method=method)
    assert design.status == "optimal"
    assert design.x[0] == pytest.approx(5.0 * 31.0**2, rel=1e-9)
    assert (design.goal[1].value, design.goal[1].shown) == (1.0, "100 %" if unit else "1")


def random_scene(rng: np.random.Generator, *, free_mass: bool) -> dict[str, Any]:
    """A chain of one to three bodies, any damping, with a small mass anywhere; sometimes a limit on its travel."""
    n = int(rng.integers(1, 4))
    bodies: dict[str, Any] = {f"b{i}": {"mass": f"{10 ** rng.uniform(1, 3):.6g} kg"} for i in range(n)}
    links: dict[str, Any] = {}
    for i in range(n):
        ends = ["ground" if i == 0 else f"b{i - 1}", f"b{i}"]
        links[f"s{i}"] = {"between": ends, "stiffness": f"{10 ** rng.uniform(4, 7):.6g} N/m"}
        ratio = float(rng.choice([0.0, 0.001, 0.02, 0.1]))
        if ratio:
            links[f"s{i}"] |= {"damping_ratio": ratio, "relative_to": f"b{i}"}
    host = f"b{rng.integers(0, n)}"
    mass = float(bodies[host]["mass"].split()[0])
    bodies["small"] = {"mass": f"{mass * 10 ** rng.uniform(-2, -0.5):.6g} kg"}
    if free_mass:
        bodies["small"] = {"mass": {"from": f"{0.01 * mass:.6g} kg", "to": f"{0.3 * mass:.6g} kg"}}
    links["tuner"] = {"between": [host, "small"], "stiffness": {"from": "100 N/m", "to": "100 MN/m"}}
    if rng.random() < 0.5:
        links["tuner"]["damping"] = {"from": "0.1 N s/m", "to": "100 kN s/m"}
    else:
        links["tuner"] |= {"damping_ratio": {"from": 0.001, "to": 2.0}, "relative_to": "small"}
    low, high = sorted(10 ** rng.uniform(0.5, 2.7, 2))
    shake = {"kind": "force", "on": f"b{rng.integers(0, n)}", "amplitude": "1 kN", "varies": "constant"}
    document = {
        "bodies": bodies,
        "links": links,
        "excitations": {"shake": {**shake, "speed": f"{low:.6g}..{high:.6g} rad/s"}},
        "goal": {"minimise": "displacement", "of": f"b{rng.integers(0, n)}"},
    }
    if rng.random() < 0.5:
        travel = f"{10 ** rng.uniform(-3, 0):.6g} m"
        document["limits"] = {"travel": {"response": "relative_displacement", "across": "tuner", "at_most": travel}}
    return document


def tries(low: FloatArray, high: FloatArray, x: FloatArray | None, rng: np.random.Generator, count: int) -> FloatArray:
    """Random designs over the whole box, and half of them near x."""
    spread = np.exp(rng.uniform(np.log(low), np.log(high), (count, len(low))))
    if x is None:
        return spread
    near = x * np.exp(rng.normal(size=spread.shape) * 10 ** rng.uniform(-5, 0, (count, 1)))
    return np.concatenate([spread[: count // 2], np.clip(near[: count // 2], low, high)])


def never_beaten(seed: int, count: int, *, free_mass: bool) -> None:
    rng = np.random.default_rng(seed)
    program, found = best_of(random_scene(rng, free_mass=free_mass))
    judge = Judge(program)
    best = judge.goal(found.x).value if found.x is not None else np.inf
    if found.x is not None:
        assert judge.feasible(found.x)
    if found.status not in ("optimal", "infeasible"):
        return
    for x in tries(program.low, program.high, found.x, rng, count):
        if judge.feasible(x):
            assert judge.goal(x).value >= best * (1.0 - 1e-6), x


@settings(max_examples=12, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_no_random_design_beats_a_proven_one(seed: int) -> None:
    never_beaten(seed, 60, free_mass=False)


@settings(max_examples=4, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_no_random_design_beats_a_proven_one_with_free_mass(seed: int) -> None:
    never_beaten(seed, 60, free_mass=True)


@pytest.mark.slow
@settings(max_examples=150, deadline=None)
@given(seed=st.integers(0, 10**6), free_mass=st.booleans())
def test_thousands_of_random_designs_beat_no_proven_one(seed: int, free_mass: bool) -> None:
    never_beaten(seed, 400, free_mass=free_mass)


HEAVY = """
[bodies.machine]
mass = "155.6 kg"
[links.mount]
between = ["machine", "ground"]
stiffness = { from = "0 N/m", to = "9 MN/m" }
damping = { from = "0 N s/m", to = "42 kN s/m" }
[excitations.push]
kind = "force"
on = "machine"
amplitude = "100 N"
varies = "constant"
speed = "0..180 rad/s"
[limits.stiff]
response = "natural_frequency"
mode = 1
at_least = "165 rad/s"
[goal]
minimise = "transmitted_force"
through = "mount"
"""


def test_a_goal_is_not_zero_because_other_designs_resonate_without_end() -> None:
    """It was told as zero, and its two routes were not compared: next to no damping lay within reach."""
    found = vo.solve(from_text(HEAVY))
    assert found.status == "optimal"
    assert found.goal is not None
    (k, c), w = np.array(found.x), np.linspace(0.0, 180.0, 5000)
    force = 100.0 * np.abs((k + 1j * w * c) / (k + 1j * w * c - 155.6 * w**2))
    assert found.goal[1].value == pytest.approx(force.max(), rel=1e-6)


def test_what_is_told_as_zero_and_is_not_fails_the_check(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Judge, "vanishes", lambda judge, x: True)
    found = vo.solve(from_text(HEAVY))
    assert found.status == "check_failed"
    assert found.claim == "the goal is told as zero, but on the built machine it is 121.5 N pk"
