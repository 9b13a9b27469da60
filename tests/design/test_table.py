"""The answer as text: every word of it, at 80 columns, without colour."""

from collections.abc import Callable
from dataclasses import replace

import pytest

from vibopt.answer.clashes import Conflict
from vibopt.answer.entry import Entry
from vibopt.answer.text import text_of
from vibopt.scene.scene import Design

Solved = Callable[[str], Design]

PRESS = """\
Printing press on its mount
optimal: greatest stiffness of mount is 6957 kN/m
  set here

What to build
  mount  spring of 6957 kN/m, damping 9909 N s/m, between press and ground

Springs and mounts
         Natural    Damping
         frequency  ratio    Static sag  Isolation
  mount  24.24 Hz   0.108    0.4229 mm   66.67 % at 3000 rpm

Limits
  Limit                            Worst        Allowed    Margin
  floor_force                      10 kN pk     at most    0 %
    transmitted force into ground  at 3000 rpm  10 kN pk   ACTIVE
  amplitude                        1.312 mm pk  at most    47.5 %
    displacement of press          at 3000 rpm  2.5 mm pk
  start_up                         20 mm pk     at most    0 %
    displacement of press          at 1437 rpm  20 mm pk   ACTIVE

Measures
  sag  static deflection of mount  0.4229 mm

What was chosen
  links.mount.stiffness  6957 kN/m   chosen from 10 kN/m to 1 GN/m
  links.mount.damping    9909 N s/m  chosen from 10 N s/m to 1 MN s/m

Method  by hand, 2.0 s
Notes   An amplitude is peak (pk, zero to peak) unless pp or rms is written
        behind its unit.
        press: the force keeps its amplitude at every speed.
Next    round the values for the drawing:
        vibopt solve rao_9_34.toml --round 3
"""


def test_a_design_is_told_word_for_word(solved: Solved) -> None:
    design = replace(solved("rao_9_34"), claim="set here", method="by hand", timings={"solve": 2.0}, notes=())
    assert text_of(design) == PRESS


@pytest.mark.parametrize("name", ["rao_9_34", "rao_9_1", "rao_9_35", "rao_9_38", "rao_9_65", "rao_9_39"])
@pytest.mark.parametrize("width", [60, 80, 120])
def test_no_line_is_wider_than_asked_and_none_has_escape_codes(solved: Solved, name: str, width: int) -> None:
    lines = text_of(solved(name), width=width).splitlines()
    assert max(map(len, lines)) <= width
    assert not any("\x1b" in line or line != line.rstrip() for line in lines)


def test_colour_changes_nothing_but_colour(solved: Solved) -> None:
    import re

    coloured = text_of(solved("rao_9_34"), colour=True)
    assert "\x1b[" in coloured
    assert re.sub(r"\x1b\[[0-9;]*m", "", coloured).split() == text_of(solved("rao_9_34")).split()


def test_an_infinite_value_says_where(solved: Solved) -> None:
    assert "displacement of car  infinite at 46.78 km/h" in text_of(solved("rao_9_1"))


def test_a_broken_limit_is_named(solved: Solved) -> None:
    text = text_of(solved("rao_9_34_printed_design"))
    assert 'violated: the machine breaks "start_up"' in text
    assert "20 mm pk   BROKEN" in text


def test_intervals_are_listed_and_the_whole_range_is_not_called_broken(solved: Solved) -> None:
    text = text_of(solved("rao_9_35"))
    assert "  0 rpm to 539.4 rpm\n  748.6 rpm to 14499 rpm\n" in text
    assert "Limits over the whole range of machine.speed" in text
    assert "BROKEN" not in text


def test_an_unbounded_goal_shows_no_values(solved: Solved) -> None:
    text = text_of(replace(solved("rao_9_34"), status="unbounded"))
    assert "unbounded: the goal has no best value\n" in text
    assert "6957" not in text


def test_a_conflict_names_the_limits_and_the_smallest_loosening(solved: Solved) -> None:
    now, then = Entry(0.02, "length", "mm"), Entry(0.024, "length", "mm")
    floor, more = Entry(1e4, "force", "kN"), Entry(1.13e4, "force", "kN")
    conflict = Conflict(("floor_force", "start_up"), (("start_up", now, then), ("floor_force", floor, more)), "proof")
    empty = replace(solved("rao_9_34"), goal=None, variables={}, x=(), limits={}, measures={})
    design = replace(empty, status="infeasible", conflict=conflict)
    text = text_of(design)
    assert "infeasible: no design meets all limits\n" in text
    assert 'These cannot hold together: "floor_force", "start_up".\n' in text
    words = "Smallest loosening of one: floor_force 10 kN -> 11.3 kN, or start_up 20 mm -> 24 mm."
    assert words in " ".join(text.split())
