"""Thresholds of whole numbers say what is true at the numbers named and at their neighbours."""

from __future__ import annotations

import re
from functools import lru_cache

from hypothesis import assume, given, settings
from hypothesis import strategies as st

from texts import floor, sags, shaken_fan
from vibopt.cli.whatif_command import edge_words
from vibopt.scene.read import from_text, with_changes
from vibopt.scene.scene import Scene
from vibopt.solve import solve
from vibopt.study.thresholds import thresholds


def fan_of(mass: int, count: int, force: int, sag: float) -> str:
    """A fan on so many mounts, whose force [N] and sag [mm] have bounds."""
    mount = {"stiffness": "100 kN/m", "damping": "300 N s/m", "count": count}
    asked, turning = (floor(f"{force} N"), sags("fan", f"{sag} mm")), {"kind": "unbalance", "unbalance": "0.02 kg m"}
    return shaken_fan(mount, *asked, mass=f"{mass} kg", speed="1500 rpm", **turning)


@lru_cache(maxsize=256)
def _holds(scene: str, count: int) -> bool:
    return solve(with_changes(from_text(scene), {"links.mount.count": count}), explain=False).status == "met"


def _words(scene: Scene) -> tuple[str, str]:
    (found,) = thresholds(scene, only=["links.mount.count"])
    return edge_words(found, found.below, found.limits[0]), edge_words(found, found.above, found.limits[1])


def test_three_and_five_that_fail_are_named_beside_four_that_holds() -> None:
    scene = fan_of(mass=150, count=4, force=70, sag=4.5)
    assert [_holds(scene, n) for n in (3, 4, 5)] == [False, True, False]
    assert _words(from_text(scene)) == ("4 (3 fails)\n  sag", "4 (5 fails)\n  floor")


@settings(max_examples=40)
@given(mass=st.integers(60, 600), count=st.integers(1, 8), force=st.integers(50, 3000), sag=st.floats(0.5, 20.0))
def test_the_words_are_true_of_every_number_up_to_the_ones_named(mass: int, count: int, force: int, sag: float) -> None:
    text = fan_of(mass=mass, count=count, force=force, sag=sag)
    assume(_holds(text, count))
    for words, way, end in zip(_words(from_text(text)), (-1, 1), (1, 10 * count), strict=True):
        if words == "-":
            assert all(_holds(text, n) for n in range(count, end + way, way))
            continue
        good, bad = map(int, re.match(r"(\d+) \((\d+) fails\)", words).groups())
        assert bad == good + way
        assert all(_holds(text, n) for n in range(count, good + way, way))
        assert not _holds(text, bad)
