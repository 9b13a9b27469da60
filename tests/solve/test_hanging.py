"""What hangs by a spring that is to be chosen: the same whether it is said as an absorber or as a body on a link."""

from __future__ import annotations

from typing import Any

import pytest

from vibopt.program.pose import pose
from vibopt.scene.read import from_dict
from vibopt.solve.hanging import MassOnSpring, masses_on_springs
from vibopt.solve.ranges import closed
from vibopt.solve.solve import solve

SPRING = {"stiffness": {"from": "60 N/m", "to": "4 MN/m"}}
DAMPER = {"damping": {"from": "0.07 N s/m", "to": "35 kN s/m"}}


def tower(hung: dict[str, Any], *, links: bool, **more: Any) -> dict[str, Any]:
    """Two floors, the lower one shaken and looked at, and masses by their names: (mass, what they hang from)."""
    document: dict[str, Any] = {
        "title": "t",
        "bodies": {"low": {"mass": "100 kg"}, "high": {"mass": "40 kg"}},
        "links": {
            "stand": {"between": ["low", "ground"], "stiffness": "1 MN/m"},
            "column": {"between": ["high", "low"], "stiffness": "300 kN/m"},
        },
        "absorbers": {},
        "excitations": {"e": {"kind": "force", "on": "low", "amplitude": "100 N", "speed": "3 Hz..30 Hz"}},
        "goal": {"minimise": "displacement", "of": "low"},
        **more,
    }
    for name, (mass, host) in hung.items():
        if links:
            document["bodies"][name] = {"mass": mass}
            document["links"][f"{name}_spring"] = {"between": [host, name], **SPRING}
            document["links"][f"{name}_damper"] = {"between": [name, host], **DAMPER}
        else:
            document["absorbers"][name] = {"on": host, "mass": mass, **SPRING, **DAMPER}
    return document


def hanging(document: dict[str, Any]) -> list[tuple[MassOnSpring, dict[str, str]]]:
    """What hangs, and the variables of each by their words."""
    program = closed(pose(from_dict(document)))
    found = masses_on_springs(program)
    return [(one, {word: program.axes[i].path for word, i in one.axes.items()}) for one in found]


OPEN = {"from": "1 kg", "to": "5 kg"}
WAYS = {
    "on two floors": {"a": ("2 kg", "low"), "b": ("3 kg", "high")},
    "on each other": {"a": ("4 kg", "high"), "b": ("1 kg", "a")},
    "of any mass": {"a": (OPEN, "low"), "b": (OPEN, "high")},
}


@pytest.mark.parametrize("way", WAYS)
def test_bodies_on_links_hang_as_absorbers_do(way: str) -> None:
    said = [hanging(tower(WAYS[way], links=links)) for links in (False, True)]
    assert len(said[0]) == len(WAYS[way])
    for (one, its), (other, theirs) in zip(*said, strict=True):
        assert (one.mass, one.depth, one.last, one.host) == (other.mass, other.depth, other.last, other.host)
        assert set(its) == set(theirs)
        assert (one.weight >= 0) == (other.weight >= 0) == (way == "of any mass")
        assert theirs["damping"].endswith("_damper.damping")


@pytest.mark.parametrize(
    ("more", "left"),
    [
        ({"limits": {"l": {"response": "displacement", "of": "a", "at_most": "1 m"}}}, ["b"]),
        ({"limits": {"l": {"response": "relative_displacement", "across": "a_spring", "at_most": "1 m"}}}, ["a", "b"]),
        ({"excitations": {"e": {"kind": "force", "on": "b", "amplitude": "1 N", "speed": "3 Hz..30 Hz"}}}, ["a"]),
    ],
)
def test_what_is_loaded_or_asked_about_itself_does_not_hang(more: dict[str, Any], left: list[str]) -> None:
    found = hanging(tower(WAYS["on two floors"], links=True, **more))
    assert [theirs["stiffness"] for _, theirs in found] == [f"links.{name}_spring.stiffness" for name in left]


def test_a_machine_on_a_mount_does_not_hang() -> None:
    document = tower({"a": ("2 kg", "low")}, links=True)
    document["links"]["stand"] |= SPRING
    document["links"]["between"] = {"between": ["high", "ground"], "stiffness": "1 kN/m"}
    assert [theirs["stiffness"] for _, theirs in hanging(document)] == ["links.a_spring.stiffness"]


@pytest.mark.slow
def test_four_bodies_on_links_are_tuned_as_well_as_a_search_of_another_kind_does() -> None:
    """Descents on powers of the response from 60 random tunings, made sharp by linear programs on all peaks (scipy)."""
    hung = [
        ("25.78 kg", "high", (26870, 6045000), (1.665, 24970)), ("6.092 kg", "low", (6349, 1429000), (0.3933, 5900)),
        ("45.28 kg", "low", (47190, 10620000), (2.924, 43850)), ("24.97 kg", "high", (26020, 5855000), (1.612, 24180)),
    ]  # fmt: skip
    column = {"stiffness": "2026400 N/m", "damping": "41.072 N s/m"}
    document: dict[str, Any] = {
        "title": "t",
        "bodies": {"low": {"mass": "842.744 kg"}, "high": {"mass": "52.028 kg"}},
        "links": {
            "stand": {"between": ["low", "ground"], "stiffness": "26052 kN/m", "damping": "2963.5 N s/m"},
            "column": {"between": ["high", "low"], **column},
        },
        "excitations": {"e": {"kind": "force", "on": "low", "amplitude": "18.5 N", "speed": "12.84..35.97 Hz"}},
        "goal": {"minimise": "displacement", "of": "low"},
    }
    for i, (mass, host, springs, dampers) in enumerate(hung):
        document["bodies"][f"a{i}"] = {"mass": mass}
        document["links"][f"d{i}"] = {
            "between": [f"a{i}", host],
            "stiffness": {"from": f"{springs[0]} N/m", "to": f"{springs[1]} N/m"},
            "damping": {"from": f"{dampers[0]} N s/m", "to": f"{dampers[1]} N s/m"},
        }
    found = solve(from_dict(document))
    assert found.goal is not None
    assert found.goal[1].value <= 2.0123395e-06


def test_the_mount_below_bodies_on_links_is_chosen_as_well_as_they_are() -> None:
    """The same search of another kind; begun with one mount alone, the answer is 6 % above that."""
    document: dict[str, Any] = {
        "title": "t",
        "bodies": {"b0": {"mass": "224.3 kg"}, "b1": {"mass": "17.95 kg"}, "b2": {"mass": "5.336 kg"}},
        "links": {},
        "excitations": {"e": {"kind": "unbalance", "on": "b0", "unbalance": "35.3 kg m", "speed": "5.517 Hz"}},
        "goal": {"minimise": "displacement", "of": "b0", "over": "5.517..31.56 Hz"},
    }
    springs, dampers = (8925.0, 647.1, 192.4), ((17.16, 51490.0), (1.244, 3733.0), (0.3699, 1110.0))
    for i, (k, c) in enumerate(zip(springs, dampers, strict=True)):
        document["links"][f"l{i}"] = {
            "between": [f"b{i}", "b0" if i else "ground"],
            "stiffness": {"from": f"{k} N/m", "to": f"{2000.0 * k} N/m"},
            "damping": {"from": f"{c[0]} N s/m", "to": f"{c[1]} N s/m"},
        }
    found = solve(from_dict(document))
    assert found.goal is not None
    assert found.goal[1].value <= 0.07235513
