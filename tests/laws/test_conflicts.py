"""No design: the conflict cannot be made smaller, each loosening works, and a little less does not."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import vibopt as vo
from vibopt.answer.text import text_of
from vibopt.report.machine_words import conflict_words
from vibopt.scene.read import from_dict, read, with_changes
from vibopt.scene.scene import Design, Scene
from vibopt.solve import solve
from vibopt.study.nearest import with_nearest

few = settings(derandomize=True, database=None, deadline=None, max_examples=12)


def crowded(floor: float, sag: float, swing: float, start: float, damped: bool) -> Scene:
    """100 kg under 1 kN at 100 rad/s, with four limits that hardly go together."""
    mount: dict[str, Any] = {"between": ["fan", "ground"], "stiffness": {"from": "1 kN/m", "to": "10 MN/m"}}
    if damped:
        mount["damping"] = {"from": "10 N s/m", "to": "20 kN s/m"}
    else:
        mount["damping_ratio"] = 0.1
    document = {
        "title": "crowded",
        "bodies": {"fan": {"mass": "100 kg"}},
        "links": {"mount": mount},
        "excitations": {
            "fan": {"kind": "force", "on": "fan", "amplitude": "1 kN", "speed": "100 rad/s", "varies": "constant"}
        },
        "limits": {
            "floor": {"response": "transmitted_force", "into": "ground", "at_most": f"{floor!r} N"},
            "sag": {"response": "static_deflection", "of": "mount", "at_most": f"{sag!r} mm"},
            "swing": {"response": "displacement", "of": "fan", "at_most": f"{swing!r} mm"},
            "start": {"response": "displacement", "of": "fan", "over": "start-up", "at_most": f"{start!r} mm"},
        },
        "goal": {"maximise": "stiffness", "of": "mount"},
    }
    return from_dict(document)


def feasible(scene: Scene) -> bool:
    design = solve(scene, explain=False)
    assert design.status in ("optimal", "feasible", "infeasible"), design.claim
    return design.status != "infeasible"


def hold(scene: Scene, design: Design) -> None:
    conflict = design.conflict
    assert conflict is not None
    only = {name: dict(scene.document["limits"][name]) for name in conflict.limits}
    assert not feasible(with_changes(scene, {"limits": only})), "the conflict is none"
    for name in conflict.limits:
        fewer = {key: words for key, words in only.items() if key != name}
        assert feasible(with_changes(scene, {"limits": fewer})), f"{name} could be left out"
    for name, now, new in conflict.loosenings:
        unit = "N" if name == "floor" else "m"
        assert feasible(with_changes(scene, {f"limits.{name}.at_most": f"{new.value!r} {unit}"})), name
        less = now.value + 0.98 * (new.value - now.value) if new.value < 1.5 * now.value else 0.98 * new.value
        step = 10.0 ** (math.floor(math.log10(new.value)) - 2)  # the suggestion is rounded outward to three digits
        less = min(less, new.value - 1.02 * step)
        assert not feasible(with_changes(scene, {f"limits.{name}.at_most": f"{less!r} {unit}"})), name


@given(
    floor=st.floats(20.0, 600.0),
    sag=st.floats(0.3, 30.0),
    swing=st.floats(0.2, 3.0),
    start=st.floats(0.5, 20.0),
    damped=st.booleans(),
)
@few
def test_a_conflict_is_smallest_and_its_loosenings_work(
    floor: float, sag: float, swing: float, start: float, damped: bool
) -> None:
    scene = crowded(*(float(f"{one:.4g}") for one in (floor, sag, swing, start)), damped)
    design = solve(scene)
    if design.status == "infeasible":
        hold(scene, design)


def test_two_limits_that_cannot_hold_together_are_both_named() -> None:
    design = solve(crowded(50.0, 1.0, 3.0, 1e4, True))
    assert design.status == "infeasible"
    assert design.conflict is not None
    assert set(design.conflict.limits) == {"floor", "sag"}


def skid(vib: str) -> Scene:
    """A machine at two speeds with two absorbers, whose four numbers starts look for."""
    own = {
        "on": "skid", "mass": "20 kg", "frequency": {"from": "10 Hz", "to": "40 Hz"},
        "damping_ratio": {"from": 0.01, "to": 0.5},
    }  # fmt: skip
    foot = {"between": ["skid", "ground"], "stiffness": "11 MN/m", "damping_ratio": "2 %"}
    speeds = ["980 rpm", "1180 rpm"]
    pump = {"kind": "unbalance", "on": "skid", "unbalance": "30 kg mm", "speed": speeds}
    document = {
        "bodies": {"skid": {"mass": "800 kg"}},
        "links": {"feet": foot},
        "absorbers": {"a": own, "b": own},
        "excitations": {"pump": pump},
        "limits": {
            "vib": {"response": "velocity", "of": "skid", "at_most": vib},
            "stroke": {"response": "relative_displacement", "across": "a", "at_most": "3 mm"},
        },
        "goal": {"minimise": "displacement", "of": "skid"},
    }
    return from_dict(document)


def test_limits_of_a_design_that_starts_look_for_are_loosened_too() -> None:
    design = solve(skid("1 mm/s"))
    assert design.status == "infeasible"
    assert design.conflict is not None
    assert design.conflict.limits == ("vib",)
    [(name, _, enough)] = design.conflict.loosenings
    assert name == "vib"
    assert solve(skid(f"{enough.value!r} m/s"), explain=False).status == "optimal"
    assert solve(skid(f"{0.98 * enough.value!r} m/s"), explain=False).status == "infeasible"


def set_on_four(travel: str) -> Scene:
    """A machine in space: its limit on the travel of a group is one limit of many rows."""
    feet = [[f"{x} m", f"{y} m", 0] for x in (0.8, -0.8) for y in (0.5, -0.5)]
    mount = {"between": ["set", "ground"], "at": feet, "shear_ratio": 0.5, "loss_factor": 0.1}
    document = {
        "bodies": {"set": {"mass": "800 kg", "shape": {"box": ["1.6 m", "1 m", "0.8 m"]}}},
        "mounts": {"foot": {**mount, "stiffness": {"from": "100 kN/m", "to": "200 kN/m"}}},
        "excitations": {
            "shaker": {
                "kind": "force", "on": "set", "at": ["0.3 m", "0.2 m", 0], "direction": "z",
                "speed": "600 rpm", "varies": "constant", "amplitude": "1 kN",
            }
        },
        "limits": {
            "gap": {"response": "travel", "of": "foot", "direction": "z", "at_most": travel},
            "sway": {"response": "displacement", "of": "set", "direction": "z", "at_most": "10 mm"},
        },
        "goal": {"minimise": "stiffness", "of": "foot"},
    }  # fmt: skip
    return from_dict(document)


def test_a_limit_of_many_rows_is_loosened_as_one() -> None:
    design = solve(set_on_four("0.0005 mm"))
    assert design.status == "infeasible"
    assert design.conflict is not None
    assert design.conflict.limits == ("gap",)
    [(name, _, loosened)] = design.conflict.loosenings
    assert name == "gap"
    enough = loosened.value * 1e3
    assert solve(set_on_four(f"{enough!r} mm")).status == "optimal"
    assert solve(set_on_four(f"{0.98 * enough!r} mm")).status == "infeasible"


def test_a_limit_missed_by_rounding_alone_is_loosened_on_its_own_side(tmp_path: Path) -> None:
    """Next to standstill a transmissibility is one and a part in 1e24: no guess from what is left tells the side."""
    file = tmp_path / "slow.toml"
    file.write_text(
        '[bodies.machine]\nmass = "1200 kg"\n[links.mount]\nbetween = ["machine", "ground"]\n'
        'stiffness = { from = "7.5 kN/m", to = "4.4 MN/m" }\n[excitations.piston]\nkind = "unbalance"\n'
        'on = "machine"\nrotating_mass = "30 kg"\nradius = "0.19 m"\nspeed = "1e-9 rpm"\n[limits.isolated]\n'
        'response = "transmissibility"\ninto = "ground"\nat_most = 1\n[goal]\nmaximise = "stiffness"\nof = "mount"\n'
    )
    scene: Any = vo.read(file)
    answer = vo.solve(scene)
    assert answer.status == "infeasible"
    assert [name for name, _, _ in answer.conflict.loosenings] == ["isolated"]


WEIGHT = 100.0 * 9.80665
HOLDS = {
    "sag": lambda low, high, stiffness, price: WEIGHT / stiffness <= 4e-3,
    "cost": lambda low, high, stiffness, price: price <= 20.0,
    "mount: rated load (at most)": lambda low, high, stiffness, price: high >= WEIGHT,
    "mount: rated load (at least)": lambda low, high, stiffness, price: low <= WEIGHT,
}
"""Whether one part keeps each limit, by hand."""
part = st.tuples(
    *(st.sampled_from(one) for one in ([300.0, 600.0, 1200.0], [700.0, 1500.0], [2e5, 3e5], [15.0, 25.0]))
).filter(lambda one: one[0] < one[1])


@few
@given(st.lists(part, min_size=2, max_size=4, unique=True))
def test_bought_parts_clash_with_what_they_are_rated_for_too(
    tmp_path_factory: pytest.TempPathFactory, parts: list[tuple[float, ...]]
) -> None:
    """A smallest set of limits that no part keeps, ratings by their ends among them, and what each could be alone."""
    file = tmp_path_factory.mktemp("parts") / "parts.csv"
    rows = [f"P{i};{low};{high};{k};0.1;{price}" for i, (low, high, k, price) in enumerate(parts)]
    heads = "part;rated load min [N];rated load max [N];stiffness [N/m];loss factor;price [EUR]"
    file.write_text("\n".join([heads, *rows]))
    scene = from_dict(
        {
            "bodies": {"fan": {"mass": "100 kg"}},
            "links": {"mount": {"between": ["fan", "ground"], "part": {"catalogue": str(file)}}},
            "limits": {
                "sag": {"response": "static_deflection", "of": "mount", "at_most": "4 mm"},
                "cost": {"response": "price", "at_most": "20 EUR"},
            },
            "goal": {"minimise": "price"},
        }
    )
    design = with_nearest(solve(scene))
    some = any(all(holds(*one) for holds in HOLDS.values()) for one in parts)
    assert (design.status == "optimal") is some
    if some:
        return
    assert design.conflict is not None
    assert design.nearest is not None
    clash = design.conflict.limits
    assert not any(all(HOLDS[name](*one) for name in clash) for one in parts)
    for name in clash:
        assert any(all(HOLDS[other](*one) for other in clash if other != name) for one in parts)
    assert {name for name, _, _ in design.conflict.loosenings} <= set(clash)
    for key, row in design.nearest.limits.items():
        name = f"{row.name} ({row.side.replace('_', ' ')})" if row.name not in HOLDS else row.name
        assert design.nearest.least[key].enough == any(HOLDS[name](*one) for one in parts)


def test_an_end_of_the_load_range_is_named_where_it_clashes(tmp_path: Path) -> None:
    (tmp_path / "mounts.csv").write_text(
        "part;rated load min [N];rated load max [N];stiffness [N/mm];loss factor\nsoft;100;1800;50;0,1\n"
        "stiff;1500;4000;900;0,1\n"
    )
    (tmp_path / "fan.toml").write_text(
        """[bodies.fan]
mass = "100 kg"
[links.mount]
between = ["fan", "ground"]
part = { catalogue = "mounts.csv" }
[limits.sag]
response = "static_deflection"
of = "mount"
at_most = "2 mm"
[goal]
maximise = "stiffness"
of = "mount"
"""
    )
    design = with_nearest(solve(read(tmp_path / "fan.toml")))
    assert "its load is 34.6 % below the least that it is rated for." in design.reason
    assert conflict_words(design)[0] == 'These cannot hold together: "sag", "mount: rated load (at least)".'
    text = text_of(design)
    for words in ("980.7 N of 4000 N", "980.7 N of 100 N"):
        assert words in text
