"""Valid documents with random nodes replaced: an answer or an InputError, and nothing else."""

from __future__ import annotations

import copy
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from vibopt.answer.answer import EXIT_CODES
from vibopt.errors import InputError
from vibopt.scene.read import from_dict
from vibopt.solve import solve

FOLDER = Path(__file__).parents[2] / "problems" / "isolation"
DOCUMENTS = [tomllib.loads(file.read_text(encoding="utf-8")) for file in sorted(FOLDER.glob("*.toml"))]
ODD = [
    0, 1, -1, 2.5, 1e300, -0.0, float("nan"), float("inf"), True, False, "", "ground", "x", "\0", "é" * 200, 10**40,
    "0 rpm", "3000 rpm", "1 kN/m", "5 kg", "-3 mm", "1e29 kg", "1e-29 kg", "1e-320 kg", "0 N", "-200 dB", "1e5 dB",
    "0..0 rpm", "5..1 Hz", "10..20 Hz", "start-up", "speed^2", "peak", "60 km/h", "mm rms", "kg pp", [], {}, [[]],
    ["1 Hz", "2 Hz"], {"from": "1 N/m", "to": "2 N/m"}, {"from": 0, "to": 1}, {"one_of": ["1 kN/m", "2 kN/m"]},
    {"from": 1, "to": 5, "whole": True}, {"from": "0 rpm", "to": "100 Hz"}, "displacement", "insertion_loss", "count",
]  # fmt: skip
WORK = 60_000.0
"""Most work of one answer [nominal ms]."""

few = settings(
    derandomize=True, database=None, deadline=None, max_examples=400, suppress_health_check=list(HealthCheck)
)


def nodes(value: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Paths of everything in a document."""
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [path, *(found for key, one in inner for found in nodes(one, (*path, key)))]


def at(document: Any, path: tuple[Any, ...]) -> Any:
    for step in path:
        document = document[step]
    return document


USED = [at(document, path) for document in DOCUMENTS for path in nodes(document)[1:] if path[0] != "expected"]


@st.composite
def mutants(draw: Callable[..., Any], *, deep: bool = False) -> dict[str, Any]:
    """A problem file with up to three nodes replaced, dropped or renamed; `deep` leaves whole tables alone."""
    document = copy.deepcopy(draw(st.sampled_from(DOCUMENTS)))
    document.pop("expected", None)
    for _ in range(draw(st.integers(1, 1 if deep else 3))):
        paths = [path for path in nodes(document)[1:] if len(path) >= (3 if deep else 1)]
        if not paths:
            break
        path = draw(st.sampled_from(paths))
        holder = at(document, path[:-1])
        how = draw(st.sampled_from(["drop", "rename", "odd", "odd", "used", "used"]))
        if how == "drop" and isinstance(holder, dict):
            holder.pop(path[-1])
        elif how == "rename" and isinstance(holder, dict):
            holder[f"{path[-1]}x"] = holder.pop(path[-1])
        else:
            holder[path[-1]] = copy.deepcopy(draw(st.sampled_from(ODD if how == "odd" else USED)))
    return document


def try_one(document: dict[str, Any]) -> None:
    try:
        design = solve(from_dict(document), explain=False)
    except InputError:
        return
    assert design.status in EXIT_CODES
    assert design.work < WORK


@given(document=mutants())
@few
def test_a_mutated_document_is_a_scene_or_an_input_error(document: dict[str, Any]) -> None:
    try_one(document)


@given(document=mutants(deep=True))
@few
def test_one_changed_value_is_answered_or_refused(document: dict[str, Any]) -> None:
    try_one(document)


@pytest.mark.slow
@given(document=mutants())
@settings(few, max_examples=5_000)
def test_many_mutated_documents_are_scenes_or_input_errors(document: dict[str, Any]) -> None:
    try_one(document)
