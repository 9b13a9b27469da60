"""The JSON of answers has the shape that `vibopt schema answer` prints, and the shape is strict."""

from __future__ import annotations

import json
from typing import Any

import pytest
from shapes import faults

import vibopt as vo
from vibopt.answer.jsonable import SCHEMA, json_text
from vibopt.manual.schema import schema_of_answers

SHAPE = schema_of_answers()
OF_EACH_KIND = ("isolation/rao_9_34", "balancing/rao_9_6_capped", "balancing/rao_9_14_b", "balancing/engine_v_twin")


def said(name: str) -> dict[str, Any]:
    answer = vo.solve(vo.read(f"problems/{name}.toml"))
    data: dict[str, Any] = json.loads(json_text(answer))
    return data


@pytest.mark.parametrize("name", OF_EACH_KIND)
def test_the_answer_of_each_kind_has_the_shape(name: str) -> None:
    data = said(name)
    assert data["schema"] == SCHEMA
    assert list(faults(data, SHAPE, SHAPE)) == []
    again = vo.solve(vo.read(f"problems/{name}.toml"))
    assert (data["kind"], data["proven"], data["status"]) == (again.job.kind, again.proven, again.status)


@pytest.mark.parametrize("name", OF_EACH_KIND)
@pytest.mark.parametrize("key", ["status", "kind", "limits", "goal", "schema", "notes"])
def test_an_answer_that_lacks_a_key_has_another_key_or_kind_is_found(name: str, key: str) -> None:
    data = said(name)
    assert list(faults({one: value for one, value in data.items() if one != key}, SHAPE, SHAPE))
    assert list(faults({**data, "statuss": "met"}, SHAPE, SHAPE))
    assert list(faults({**data, key: 5}, SHAPE, SHAPE))
    other = "engine" if data["kind"] != "engine" else "rotor"
    assert list(faults({**data, "kind": other}, SHAPE, SHAPE))


@pytest.mark.parametrize("name", OF_EACH_KIND[1:])
def test_the_path_of_a_number_is_its_path_in_the_json(name: str) -> None:
    answer = vo.solve(vo.read(f"problems/{name}.toml"))
    data = answer.to_json()
    for path, entry in answer.entries().items():
        if " " in path or path in ("status", "goal"):
            continue
        here = data
        for step in path.split("."):
            here = here[step] if isinstance(here, dict) and step in here else here
        assert here == entry.to_json() or (here["value"], here["shown"]) == (entry.value, entry.shown), path
