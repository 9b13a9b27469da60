"""What discs say of devices that hang on one place of a host: below every response, and bounds that nothing beats."""

from __future__ import annotations

from dataclasses import replace
from importlib import import_module
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vibopt.forms import hung_on_boxes
from vibopt.forms.hung_on_boxes import Hosted, Pulls, places_of
from vibopt.forms.read_on_places import read
from vibopt.program.pose import pose
from vibopt.program.program import Program
from vibopt.scene.read import from_dict
from vibopt.solve.ranges import closed

relaxed = import_module("vibopt.solve.relaxed")
few = settings(derandomize=True, database=None, deadline=None, max_examples=24)
HOST, SPRINGS, DAMPERS = (100.0, 60.0), (4.0e5, 2.4e6), (200.0, 90.0)
FORCE, MASS = 100.0, 3.0
W = 2.0 * np.pi * np.geomspace(4.0, 60.0, 30)


def hosts(on: int, count: int, spread: bool) -> list[int]:
    """The mass that each absorber hangs on: one and the same, or one after the other."""
    return [(on + i) % 2 if spread else on for i in range(count)]


def scene(
    on: int, count: int, word: str, goal: dict[str, str], moved: str, *, held: str = "", spread: bool = False
) -> dict[str, Any]:
    """Absorbers on the masses of a chain of two, of which the second or the floor is shaken.

    `held` names the link that is to be chosen, too: one of the chain, or a mount below the mass `on`.
    """
    links: dict[str, Any] = {
        f"l{i}": {
            "between": [f"b{i}", f"b{i - 1}" if i else "ground"],
            "stiffness": f"{k!r} N/m",
            "damping": f"{c} N s/m",
        }
        for i, (k, c) in enumerate(zip(SPRINGS, DAMPERS, strict=True))
    }
    own: dict[str, Any] = {
        "mass": {"mass": {"from": "1 kg", "to": "9 kg"}, "frequency": {"from": "5 Hz", "to": "50 Hz"}},
        "frequency": {"mass": f"{MASS} kg", "frequency": {"from": "5 Hz", "to": "50 Hz"}},
        "stiffness": {"mass": {"from": "1 kg", "to": "9 kg"}, "stiffness": {"from": "3 kN/m", "to": "300 kN/m"}},
    }[word]
    damped = (
        {"damping": {"from": "5 N s/m", "to": "800 N s/m"}}
        if word == "stiffness"
        else {"damping_ratio": {"from": 0.01, "to": 0.6}}
    )
    if held:
        if held == "mount":
            links["mount"] = {"between": [f"b{on}", "ground"], "damping": "0 N s/m"}
        links[held]["stiffness"] = {"from": "50 kN/m", "to": "2 MN/m"}
    shaken: dict[str, Any] = {
        "force": {"kind": "force", "on": "b1", "amplitude": f"{FORCE} N"},
        "base": {"kind": "base_motion", "on": "floor", "displacement": "1 mm"},
    }[moved]
    if moved == "base":
        links["l0"]["between"] = ["b0", "floor"]
    document = {
        "title": "t",
        "bodies": {f"b{i}": {"mass": f"{m!r} kg"} for i, m in enumerate(HOST)},
        "links": links,
        "absorbers": {f"a{i}": {"on": f"b{j}", **own, **damped} for i, j in enumerate(hosts(on, count, spread))},
        "excitations": {"e": {**shaken, "speed": "4 Hz..60 Hz", "varies": "constant"}},
        "goal": goal,
    }
    if goal["minimise"] == "transmitted_force":
        document["goal"] = {**goal, "into": "floor" if moved == "base" else "ground"}
    return document | ({"bases": {"floor": {}}} if moved == "base" else {})


def by_matrices(
    program: Program, x: np.ndarray, on: int, count: int, goal: str, moved: str, spread: bool = False
) -> np.ndarray:
    """The response at each of `W` by matrices of its own."""
    value = {axis.path: float(one) for axis, one in zip(program.axes, x, strict=True)}
    n = 2 + count
    matrix, load = np.zeros((len(W), n, n), dtype=complex), np.zeros((len(W), n), dtype=complex)

    def add(i: int, j: int, z: np.ndarray) -> None:
        for a, b, sign in ((i, i, 1.0), (j, j, 1.0), (i, j, -1.0), (j, i, -1.0)):
            if min(a, b) >= 0:
                matrix[:, a, b] += sign * z

    links = [value.get(f"links.l{i}.stiffness", SPRINGS[i]) + 1j * W * DAMPERS[i] for i in range(2)]
    for i, m in enumerate(HOST):
        matrix[:, i, i] -= W**2 * m
        add(i, i - 1, links[i])
    mount = value.get("links.mount.stiffness", 0.0)
    add(on, -1, mount + 0.0j * W)
    for i, j in enumerate(hosts(on, count, spread)):
        own = f"absorbers.a{i}."
        m = value.get(own + "mass", MASS)
        f = value.get(own + "frequency", 0.0)
        k = value.get(own + "stiffness", m * f**2)
        c = value.get(own + "damping", 2.0 * m * f * value.get(own + "damping_ratio", 0.0))
        matrix[:, 2 + i, 2 + i] -= W**2 * m
        add(2 + i, j, k + 1j * W * c)
    floor = 1e-3 * (moved == "base")
    load[:, 1] = FORCE * (moved == "force")
    load[:, 0] = links[0] * floor
    u = np.linalg.solve(matrix, load[..., None])[..., 0]
    seen = {
        "b0": u[:, 0], "b1": u[:, 1], "stroke": u[:, 2] - u[:, on],
        "force": links[0] * (u[:, 0] - floor) + mount * u[:, on] * (moved == "force"),
    }  # fmt: skip
    return np.asarray(np.abs(seen[goal]))


def hosted_of(program: Program) -> Hosted | None:
    """The machine of the goal as a host with places."""
    assert program.aim is not None
    form = program.aim.form.harmonic
    assert form is not None
    assert form.line is not None
    return places_of(program.aim.model, form.line.vector, form.output.signs)


GOALS = {
    "b0": {"minimise": "displacement", "of": "b0"},
    "b1": {"minimise": "displacement", "of": "b1"},
    "stroke": {"minimise": "stroke", "of": "a0"},
    "force": {"minimise": "transmitted_force"},
}


@few
@given(
    st.integers(0, 1), st.integers(1, 3), st.sampled_from(["mass", "frequency", "stiffness"]),
    st.sampled_from(sorted(GOALS)), st.sampled_from(["force", "base"]), st.sampled_from(["", "mount", "l0", "l1"]),
    st.booleans(), st.integers(0, 999), st.floats(-4.0, 0.0),
)  # fmt: skip
def test_no_response_on_a_box_is_below_what_discs_say(
    on: int, count: int, word: str, goal: str, moved: str, held: str, spread: bool, seed: int, size: float
) -> None:
    """At corners and inside, of any masses; of a box without width it is the response itself."""
    program = pose(from_dict(scene(on, count, word, GOALS[goal], moved, held=held, spread=spread)))
    assert program.aim is not None
    hosted, rng = hosted_of(program), np.random.default_rng(seed)
    assert hosted is not None
    known = read(program.aim.form, hosted, W)
    assert known is not None
    assert known.asked.all()
    low, high = np.log(program.low), np.log(program.high)
    middle = low + (high - low) * rng.random((20, len(low)))
    half = 10.0**size * rng.random(middle.shape)
    pulls = Pulls(hosted, W, {known.of})
    least = known.least(*pulls.on(np.exp(middle - half), np.exp(middle + half)))
    points = known.least(*pulls.on(np.exp(middle), np.exp(middle)))
    for box in range(20):
        true = by_matrices(program, np.exp(middle[box]), on, count, goal, moved, spread).max()
        assert points[box] == pytest.approx(true, rel=1e-9, abs=0.0)
        for turn in range(4):
            way = rng.uniform(-1.0, 1.0, len(low))
            x = np.exp(middle[box] + half[box] * (np.sign(way) if turn % 2 else way))
            assert least[box] <= by_matrices(program, x, on, count, goal, moved, spread).max() * (1.0 + 1e-9)
    assert size > -3.0 or np.median(least / points) > 0.9


def test_what_is_kept_of_the_ranges_of_a_device_is_what_is_said_of_them_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    """Boxes that share ranges, more of them than are kept, with a mount to be chosen and a stroke that is read."""
    monkeypatch.setattr(hung_on_boxes, "_KEPT", 12 * len(W))
    program = pose(from_dict(scene(0, 2, "mass", GOALS["stroke"], "base", held="mount")))
    hosted, rng = hosted_of(program), np.random.default_rng(7)
    assert hosted is not None
    pulls = Pulls(hosted, W, {0})
    ends = program.low + (program.high - program.low) * np.linspace(0.0, 0.9, 5)[:, None]
    for _ in range(8):
        at = rng.integers(0, 5, (9, len(program.low)))
        low = np.take_along_axis(ends, at, axis=0)
        totals, moved = pulls.on(low, 1.1 * low)
        for box in range(9):
            sums, motion = Pulls(hosted, W, {0}).on(low[[box]], 1.1 * low[[box]])
            assert moved.keys() == motion.keys() == {0}
            for many, alone in zip([*totals, moved[0]], [*sums, motion[0]], strict=True):
                assert all(np.array_equal(one[box], other[0]) for one, other in zip(many, alone, strict=True))


def test_what_acts_on_five_places_is_left_to_others() -> None:
    """Masses with an absorber each."""
    document = scene(0, 0, "mass", GOALS["b1"], "force")
    for i in range(2, 5):
        document["bodies"][f"b{i}"] = {"mass": "50 kg"}
        document["links"][f"l{i}"] = document["links"]["l1"] | {"between": [f"b{i}", f"b{i - 1}"]}
    own = {"mass": "3 kg", "frequency": {"from": "5 Hz", "to": "50 Hz"}, "damping_ratio": 0.1}
    document["absorbers"] = {f"a{i}": {"on": f"b{i}", **own} for i in range(4)}
    four = hosted_of(pose(from_dict(document)))
    assert four is not None
    assert len(four.places) == 4
    document["absorbers"]["a4"] = {"on": "b4", **own}
    assert hosted_of(pose(from_dict(document))) is None


@pytest.mark.parametrize(("count", "word", "open_"), [(1, "mass", 1e-5), (1, "stiffness", 1e-5), (3, "frequency", 0.5)])
def test_nothing_beats_the_bound_and_it_is_near(count: int, word: str, open_: float, monkeypatch: Any) -> None:
    """Of random designs, and of the best of starts: one absorber of free mass is proven, three are bounded."""
    monkeypatch.setattr(relaxed, "MOST", 10_000)
    program = closed(pose(from_dict(scene(1, count, word, GOALS["b1"], "force"))))
    assert program.aim is not None
    boxes = relaxed._Relaxed(program, program.aim.pieces)
    assert boxes.hung is not None
    best = found_best(program)
    bound = float(np.exp(boxes.search(np.log(best) - 1e-6)))
    assert bound <= best
    assert best / bound - 1.0 < open_
    rng = np.random.default_rng(count)
    x = np.exp(rng.uniform(np.log(program.low), np.log(program.high), (200, len(program.low))))
    assert min(by_matrices(program, one, 1, count, "b1", "force").max() for one in x) >= bound


def found_best(program: Program) -> float:
    """What a start leads to."""
    from vibopt.solve.nlp import Nlp

    found = Nlp(1, brief=True).solve(program)
    assert found.x is not None
    assert program.aim is not None
    return program.aim.form.value(program.aim.model, found.x)


def test_what_can_be_chosen_and_moves_nothing_is_at_no_place() -> None:
    """As the spring of a mount across which a machine turns."""
    aim = pose(from_dict(scene(0, 1, "mass", GOALS["b1"], "force", held="mount"))).aim
    assert aim is not None
    form = aim.form.harmonic
    assert form is not None
    assert form.line is not None
    model, idle = aim.model, np.zeros(aim.model.n_coords)
    load, signs = form.line.vector, np.zeros(len(model.terms))
    still = [replace(term, vector=idle) if term.exponents.any() else term for term in model.terms]
    assert places_of(replace(model, terms=tuple(still)), load, signs) is None
    more = replace(model.terms[-1], vector=idle, exponents=np.ones(model.n_vars))
    known = places_of(model, load, signs)
    same = places_of(replace(model, terms=(more, *model.terms)), load, np.zeros(len(signs) + 1))
    assert known is not None
    assert same is not None
    assert [len(one.plain) for one in same.places] == [len(one.plain) for one in known.places]


def test_a_mass_and_its_mount_that_are_chosen_alone_are_proven_best_for_another_mass() -> None:
    """Nothing hangs there; at first no box says anything of what is read elsewhere."""
    document = scene(0, 0, "mass", GOALS["b1"], "force")
    document["bodies"]["b0"]["mass"] = {"from": "50 kg", "to": "5000 kg"}
    document["links"]["l0"] |= {
        "stiffness": {"from": "10 kN/m", "to": "100 MN/m"},
        "damping": {"from": "10 N s/m", "to": "1 MN s/m"},
    }
    program = closed(pose(from_dict(document)))
    assert program.aim is not None
    boxes, best = relaxed._Relaxed(program, program.aim.pieces), found_best(program)
    assert boxes.hung is not None
    assert np.log(best) - 1e-3 < boxes.search(np.log(best) - 1e-6) <= np.log(best)


def test_coefficients_below_zero_are_at_no_place() -> None:
    """As corrections of a span whose length may be chosen: a sum with them is not least at the ends of its parts."""
    program = pose(from_dict(scene(0, 1, "mass", GOALS["b1"], "force", held="mount")))
    assert hosted_of(program) is not None
    assert program.aim is not None
    model = program.aim.model
    below = [replace(term, scale=-term.scale) if term.owner == "mount" else term for term in model.terms]
    turned = replace(program.aim, model=replace(model, terms=tuple(below)))
    assert hosted_of(replace(program, aim=turned)) is None


def test_absorbers_on_unlike_masses_are_bounded_near_to_the_best(monkeypatch: pytest.MonkeyPatch) -> None:
    """Three on two masses, of given mass: no box by rows said anything of most such hosts."""
    monkeypatch.setattr(relaxed, "MOST", 100_000)
    program = closed(pose(from_dict(scene(0, 3, "frequency", GOALS["b1"], "force", spread=True))))
    assert program.aim is not None
    boxes, best = relaxed._Relaxed(program, program.aim.pieces), found_best(program)
    bound = float(np.exp(boxes.search(np.log(best) - 1e-6)))
    assert bound <= best < 1.1 * bound


def test_the_stroke_of_a_stiff_absorber_and_the_motion_of_a_soft_one_are_known_to_their_own_digits() -> None:
    """What is left of the motion of its mass less that of its place is no rounding of theirs."""
    for sizes, word in (((5e4, 5e7), "stroke"), ((5e-6, 5e-4), "a0")):
        goal = GOALS["stroke"] if word == "stroke" else {"minimise": "displacement", "of": "a0"}
        document = scene(0, 1, "frequency", goal, "force")
        document["absorbers"]["a0"]["frequency"] = {"from": f"{sizes[0]} Hz", "to": f"{sizes[1]} Hz"}
        program = pose(from_dict(document))
        hosted, rng = hosted_of(program), np.random.default_rng(3)
        assert program.aim is not None
        assert hosted is not None
        known = read(program.aim.form, hosted, W)
        assert known is not None
        x = np.exp(rng.uniform(np.log(program.low), np.log(program.high), (200, 2)))
        least = known.least(*Pulls(hosted, W, {known.of}).on(x, x))
        own = dict(zip([axis.path.rsplit(".", 1)[1] for axis in program.axes], x.T[..., None], strict=True))
        held = own["frequency"] ** 2 + 2j * own["damping_ratio"] * own["frequency"] * W
        first, second = (k + 1j * W * c for k, c in zip(SPRINGS, DAMPERS, strict=True))
        above = second - W**2 * HOST[1]
        below = first + second - W**2 * (HOST[0] + MASS * held / (held - W**2))
        host = np.abs(FORCE * second / (below * above - second**2))
        true = (host * np.abs((W**2 if word == "stroke" else held) / (held - W**2))).max(axis=1)
        assert (least <= true * (1.0 + 1e-9)).all()
        assert (least >= true * (1.0 - 1e-3)).all()
        assert np.median(true / host.max(axis=1)) < 1e-5


def test_a_mass_that_another_absorber_holds_still_is_not_said_to_move() -> None:
    """At the one speed an undamped one that is bought does: what is left of the motion is the host's rounding."""
    document = scene(0, 1, "frequency", GOALS["b1"], "force")
    document["absorbers"]["bought"] = {"on": "b1", "mass": "3 kg", "stiffness": "14700 N/m"}
    document["excitations"]["e"]["speed"] = "70 rad/s"
    program = pose(from_dict(document))
    hosted, rng = hosted_of(program), np.random.default_rng(3)
    assert program.aim is not None
    assert hosted is not None
    known = read(program.aim.form, hosted, np.array([70.0]))
    assert known is not None
    x = np.exp(rng.uniform(np.log(program.low), np.log(program.high), (20, 2)))
    assert (known.least(*Pulls(hosted, np.array([70.0]), {-1}).on(x, 1.01 * x)) == 0.0).all()


@pytest.mark.parametrize("goal", ["b0", "force"])
def test_a_mass_that_nothing_known_holds_is_told_of_too(goal: str) -> None:
    """Mass and mount are chosen of one that carries another absorber: without the pulls there the host is singular."""
    document = scene(0, 1, "mass", GOALS[goal], "base", held="l0")
    document["bodies"]["b0"]["mass"] = {"from": "50 kg", "to": "200 kg"}
    document["links"]["l0"]["damping"] = {"from": "100 N s/m", "to": "300 N s/m"}
    document["bodies"].pop("b1")
    document["links"].pop("l1")
    program = pose(from_dict(document))
    hosted, rng = hosted_of(program), np.random.default_rng(3)
    assert program.aim is not None
    assert hosted is not None
    known = read(program.aim.form, hosted, W)
    assert known is not None
    x = np.exp(rng.uniform(np.log(program.low), np.log(program.high), (50, len(program.low))))
    least = known.least(*Pulls(hosted, W, {known.of}).on(x, x))
    own = dict(zip([axis.path for axis in program.axes], x.T[..., None], strict=True))
    z = own["links.l0.stiffness"] + 1j * W * own["links.l0.damping"]
    m, f, part = (own[f"absorbers.a0.{key}"] for key in ("mass", "frequency", "damping_ratio"))
    held = f**2 + 2j * part * f * W
    pull = -(W**2) * (own["bodies.b0.mass"] + m * held / (held - W**2))
    true = 1e-3 * np.abs(z / (z + pull) * (1.0 if goal == "b0" else pull)).max(axis=1)
    assert least == pytest.approx(true, rel=1e-9)
