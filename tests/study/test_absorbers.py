"""What happens without an absorber, its damper or its freedom, against numbers found in other ways."""

import numpy as np
import pytest

from texts import absorber, best, choice, moves, swayed, table
from vibopt.scene.read import from_text
from vibopt.scene.scene import Design
from vibopt.solve import solve
from vibopt.study.absorbers import Consequence, consequences, study_absorbers
from vibopt.study.explain import explain
from vibopt.study.prices import priced

SMALL = {"stiffness": "45 kN/m", "damping": "130 N s/m"}
FRAME = swayed(
    "frame", "1..60 Hz", absorber("tmd", "frame", "5 kg", **SMALL), moves("frame", "1 mm", "shake"),
    table("limits.travel", response="stroke", of="tmd", at_most="10 mm"), title="Frame", damping_ratio=0.01,
)  # fmt: skip

CHAIN = swayed(
    "frame", "1..60 Hz", table("links.stay", between=["tmd", "ground"], stiffness="1 kN/m"),
    absorber("tmd", "frame", "5 kg", **SMALL), absorber("second", "tmd", "1 kg", stiffness="9 kN/m"),
    table("excitations.tap", kind="force", on="tmd", amplitude="1 N", speed="1..60 Hz"),
    moves("frame", "5 mm", "shake", combine="sum"),
    table("limits.through_stay", response="transmitted_force", through="stay", due_to=["push"], at_most="5 kN"),
    title="Chain", damping_ratio=0.01,
)  # fmt: skip

FAR = absorber("far", "frame", choice("1 kg", "20 kg"), frequency="40 Hz", damping_ratio=0.05)
PAIR = swayed(
    "frame", "1..25 Hz",
    absorber("one", "frame", choice("1 kg", "20 kg"), frequency=choice("10 Hz", "20 Hz"), damping_ratio=0.12),
    FAR, moves("frame", "1 mm", "shake"), best(minimise="absorber_mass"),
    title="Two where one is enough", damping_ratio=0.01,
)  # fmt: skip

HERTZ = np.linspace(1.0, 60.0, 300_001)
W = 2.0 * np.pi * HERTZ
CRITICAL = 2.0 * 0.01 * np.sqrt(1e6 * 100.0)


def worst(mass: float, absorber: float = 0.0, stiffness: float = 0.0, damping: float = 0.0) -> float:
    """Greatest motion of the frame [m] by the textbook's equations, its mount as built."""
    own = 1e6 - mass * W**2 + 1j * W * CRITICAL
    if absorber:
        link = stiffness + 1j * W * damping
        own = own - absorber * W**2 * link / (link - absorber * W**2)
    return float(np.abs(100.0 / own).max())


def by_what(design: Design, name: str = "tmd") -> dict[str, Consequence]:
    return {one.what: one for one in consequences(design) if one.absorber == name}


def test_what_is_measured_again_agrees_with_the_equations() -> None:
    found = by_what(solve(from_text(FRAME)))
    assert list(found) == ["no_damper", "locked", "lost"]
    for what, value in (
        ("no_damper", worst(100.0, 5.0, 45e3)),
        ("locked", worst(105.0)),
        ("lost", worst(100.0)),
    ):
        broken = {one.name: one for one in found[what].breaks}
        assert broken["shake"].value.value == pytest.approx(value, rel=1e-6)
        assert found[what].status == "violated"
    assert "travel" in {one.name for one in found["no_damper"].breaks}
    assert found["lost"].words == "breaks shake: 5 mm pk at 15.91 Hz, at most 1 mm pk"
    assert found["lost"].head == "tmd lost"


def test_the_goal_is_said_where_it_is_a_response() -> None:
    text = FRAME.replace("damping_ratio = 0.01", "").replace('at_most = "1 mm"', 'at_most = "100 mm"')
    text = text.replace('stiffness = "45 kN/m"', 'stiffness = { from = "10 kN/m", to = "90 kN/m" }')
    text += '[goal]\nminimise = "displacement"\nof = "frame"\n'
    found = by_what(solve(from_text(text)))
    assert found["no_damper"].goal is not None
    assert found["no_damper"].goal.value == np.inf
    assert found["no_damper"].words.startswith("displacement of frame infinite at ")
    assert " instead of 0.6" in found["lost"].words
    assert "displacement of frame infinite at 15.92 Hz" in found["lost"].words


def test_a_chain_loses_what_hangs_on_it_and_locks_what_ends_at_it() -> None:
    design = solve(from_text(CHAIN))
    found = by_what(design)
    own = 1e6 - 100.0 * W**2 + 1j * W * CRITICAL
    assert found["lost"].status == "violated" or found["lost"].status == "met"
    assert [one.name for one in found["lost"].breaks] == ["shake"]
    assert found["lost"].breaks[0].value.value == pytest.approx(float(np.abs(100.0 / own).max()), rel=1e-6)
    carried = 1e6 + 1e3 - 105.0 * W**2 + 1j * W * CRITICAL - W**2 * 9e3 / (9e3 - W**2)
    locked = {one.name: one.value.value for one in found["locked"].breaks}
    # the tap now acts on the frame; an undamped mass on a spring keeps the frame finite off its two resonances
    assert locked["shake"] == pytest.approx(float(np.abs(101.0 / carried).max()), rel=1e-4)


@pytest.fixture(scope="module")
def pair() -> Design:
    return solve(from_text(PAIR), method="nlp")


def test_one_absorber_less_is_tried_where_one_rests_on_the_least_mass(pair: Design) -> None:
    design = pair
    hint = (
        "absorbers.far.mass rests on the least that is allowed: one absorber may do; try without it "
        "(vibopt explain does)."
    )
    assert hint in design.notes
    found = {(one.absorber, one.what): one for one in consequences(design)}
    less = found["far", "left_out"]
    alone = solve(from_text(PAIR.replace(FAR, "")))
    assert alone.goal is not None
    assert design.goal is not None
    assert less.goal is not None
    assert less.goal.value == pytest.approx(alone.goal[1].value, rel=1e-5)
    start = "its mass rests on the least that is allowed; without it: least absorber mass is"
    assert less.words.startswith(f"{start} {alone.goal[1].shown} instead of {design.goal[1].shown}")
    assert ("one", "left_out") not in found


def test_explain_says_it_all() -> None:
    told = explain(from_text(FRAME)).absorbers
    assert told is not None
    titles = [title for title, _ in told.blocks]
    assert titles == ["What to build", "How far each spring may be off", "What if"]
    assert (
        explain(
            from_text(
                FRAME.replace('[absorbers.tmd]\non = "frame"', "[bodies.tmd]")
                .replace('stiffness = "45 kN/m"\ndamping = "130 N s/m"\n', "")
                .replace('[limits.travel]\nresponse = "stroke"\nof = "tmd"\nat_most = "10 mm"\n', "")
                .replace("damping_ratio = 0.01", 'damping = "1 N s/m"')
                + '[links.held]\nbetween = ["tmd", "ground"]\nstiffness = "45 kN/m"\n'
            )
        ).absorbers
        is None
    )


def test_nothing_is_said_where_no_design_was_found() -> None:
    open_spring = FRAME.replace('"45 kN/m"', '{ from = "10 kN/m", to = "90 kN/m" }')
    goal = '[goal]\nminimise = "stroke"\nof = "tmd"\n'
    design = solve(from_text(open_spring.replace('"1 mm"', '"1 nm"') + goal), explain=False)
    assert design.status == "infeasible"
    assert study_absorbers(design) is None


def test_prices_begin_at_the_design_found_and_are_those_of_a_fresh_start(pair: Design) -> None:
    design = priced(pair)
    (price,) = [one.price for one in design.limits.values() if one.price is not None]
    fresh = solve(from_text(PAIR.replace('at_most = "1 mm"', f'at_most = "{price.loosened.value:.17g} m"')))
    assert fresh.goal is not None
    assert price.goal.value == pytest.approx(fresh.goal[1].value, rel=1e-5)
