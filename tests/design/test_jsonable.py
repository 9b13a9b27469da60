"""The JSON of an answer: strict, SI, complete."""

import json
from collections.abc import Callable
from dataclasses import replace
from math import inf, nan

import numpy as np
import pytest

from vibopt.answer.jsonable import json_text, number, plain
from vibopt.scene.scene import Design

Solved = Callable[[str], Design]


def strictly(text: str) -> object:
    """The document, refusing the tokens NaN and Infinity that Python's reader would take."""

    def refuse(token: str) -> None:
        raise AssertionError(f"{token} is not JSON")

    return json.loads(text, parse_constant=refuse)


@pytest.mark.parametrize("name", ["rao_9_34", "rao_9_1", "rao_9_35", "rao_9_38", "rao_9_34_printed_design"])
def test_every_answer_is_strict_json(solved: Solved, name: str) -> None:
    assert strictly(json_text(solved(name))) == solved(name).to_json()


def test_a_design_has_si_values_with_unit_and_shown_text(solved: Solved) -> None:
    data = solved("rao_9_34").to_json()
    stiffness = data["variables"]["links.mount.stiffness"]
    assert (stiffness["unit"], stiffness["shown"], stiffness["at_bound"]) == ("N/m", "6957 kN/m", "")
    assert stiffness["value"] == pytest.approx(6956917.2, rel=1e-6)
    assert (data["goal"]["name"], data["goal"]["sense"], data["goal"]["unit"]) == ("stiffness", "maximise", "N/m")
    limit = data["limits"]["start_up"]
    assert limit["value"] == pytest.approx(0.02)
    assert (limit["limit"], limit["unit"], limit["active"], limit["met"]) == (0.02, "m", True, True)
    assert limit["worst_at"]["press"]["unit"] == "rad/s"
    assert data["set"] is None


def test_an_infinite_value_is_a_word(solved: Solved) -> None:
    ride = solved("rao_9_1").to_json()["measures"]["ride"]
    assert (ride["value"], ride["shown"]) == ("infinite", "infinite")
    assert ride["worst_at"]["waves"]["shown"] == "46.78 km/h"


def test_a_complete_set_is_a_list_of_pairs(solved: Solved) -> None:
    pairs = solved("rao_9_35").to_json()["set"]
    assert [[one["shown"] for one in pair] for pair in pairs] == [["0 rpm", "539.4 rpm"], ["748.6 rpm", "14499 rpm"]]


def test_numbers_that_json_has_no_word_for() -> None:
    assert [number(one) for one in (inf, -inf, nan, 1.5)] == ["infinite", "minus infinite", None, 1.5]


def test_arrays_and_nested_values_become_plain(solved: Solved) -> None:
    design = replace(solved("rao_9_34"), details={"gap": np.float64(inf), "steps": np.arange(2), "of": ("a", {1: nan})})
    assert design.to_json()["details"] == {"gap": "infinite", "steps": [0, 1], "of": ["a", {"1": None}]}
    assert plain(np.bool_(True)) is True


def test_ascii_only_text_says_the_same() -> None:
    text = json_text({"unit": "m/s²"}, ascii_only=True)
    assert text.isascii()
    assert json.loads(text) == {"unit": "m/s²"}
