"""A scene with some values replaced is the scene that its whole document reads as, whatever of it was read before."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import Any

import pytest

from vibopt.document.toml_reading import changed
from vibopt.errors import InputError
from vibopt.scene.facts import facts
from vibopt.scene.read import from_dict, read, with_changes
from vibopt.scene.scene import Scene

PROBLEMS = Path(__file__).parents[2] / "problems"
FILES = (
    "isolation/rao_9_34.toml", "mounts/generator_set_on_six.toml", "absorbers/machine_tool_three_speeds.toml",
    "shafts/rao_9_17_diameters.toml",
)  # fmt: skip


def _read(of: Callable[..., Scene], *given: Any) -> Scene | str:
    """The scene, or why there is none."""
    try:
        return of(*given)
    except InputError as error:
        return str(error)


@pytest.mark.parametrize("file", FILES)
def test_each_fact_changed_reads_as_a_whole(file: str) -> None:
    scene = replace(read(PROBLEMS / file), name="scene")
    here = scene
    known = [fact for fact in facts(scene) if fact.value and not fact.place]
    assert known
    for fact in islice(known, 0, None, max(1, len(known) // 6)):
        change = {fact.path: fact.text(1.001 * fact.value)}
        whole, made = _read(from_dict, changed(here.document, change)), _read(with_changes, here, change)
        assert made == whole
        assert made != here
        here = made if isinstance(made, Scene) else here  # each is read beside what the last one left


def test_what_was_read_of_another_machine_is_not_taken() -> None:
    scene = read(PROBLEMS / FILES[0])
    other = with_changes(scene, {"bodies.press.mass": "400 kg"})
    back = from_dict({**other.document, "bodies": dict(scene.document["bodies"])}, name=scene.name, like=other)
    assert back.bodies == scene.bodies != other.bodies
