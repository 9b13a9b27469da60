"""Bounds of isolation that could be meant otherwise than they are read, or that nothing can keep."""

from __future__ import annotations

from typing import Any

import pytest

import vibopt as vo
from refusals import refused

FAN: dict[str, Any] = {
    "bodies": {"fan": {"mass": "100 kg"}},
    "links": {"mount": {"between": ["fan", "ground"], "stiffness": "200 kN/m"}},
    "excitations": {"rotor": {"kind": "force", "on": "fan", "amplitude": "10 N", "speed": "1500 rpm"}},
}


def said(family: str, words: dict[str, Any]) -> str:
    error = refused(
        vo.from_dict, {**FAN, family: {"kept": {"response": "isolation", "into": "ground", **words}}}, name="fan.toml"
    )
    return error.messages[0]


@pytest.mark.parametrize(
    ("key", "given", "words"),
    [
        (
            "at_least",
            "14 dB",
            '"14 dB" is a level, but isolation is a share of 1. Write "80.05 %", or response = "transmissibility" '
            'with at_most = "-14 dB".',
        ),
        (
            "at_most",
            "-20 dB",
            '"-20 dB" is a level, but isolation is a share of 1. Write "90 %", or response = "transmissibility" '
            'with at_least = "-20 dB".',
        ),
        ("at_least", "170 %", '"170 %" is as much as nothing coming through, or more. Write less than 100 %.'),
        ("at_least", "100 %", '"100 %" is as much as nothing coming through, or more. Write less than 100 %.'),
        ("at_least", 70, '70 is as much as nothing coming through, or more. Write "70 %".'),
    ],
)
def test_a_bound_that_is_no_share_below_one_is_refused(key: str, given: Any, words: str) -> None:
    assert said("limits", {key: given}) == f"fan.toml: limits.kept.{key} = {words}"


def test_it_is_not_shown_as_a_level() -> None:
    words = 'unit = "dB" is of levels, but isolation is a share. Write "%".'
    assert said("measures", {"unit": "dB"}) == f"fan.toml: measures.kept.{words}"


@pytest.mark.parametrize("given", ["-20 %", "0 %", "99.99 %", 0.7])
def test_shares_below_one_are_kept(given: Any) -> None:
    limits = {"kept": {"response": "isolation", "into": "ground", "at_least": given}}
    assert vo.from_dict({**FAN, "limits": limits}).limits["kept"].at_least is not None
