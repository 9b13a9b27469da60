"""Slips in every table of good files: a sentence with its place, never a fault of vibopt."""

from __future__ import annotations

import copy
import random
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from vibopt.cli.main import main
from vibopt.document.toml_writing import document_toml
from vibopt.errors import InputError
from vibopt.jobs import open_job
from vibopt.scene.read import from_dict

ROOT = Path(__file__).parents[2] / "problems"
FILES = (
    "isolation/rao_9_34.toml", "isolation/rao_9_35.toml", "absorbers/rao_9_51_tuned_freely.toml",
    "absorbers/footbridge_marching.toml", "mounts/focalised_engine.toml", "mounts/generator_set_on_six.toml",
    "mounts/compressor_on_bought_mounts.toml",
)  # fmt: skip
SLIPS: tuple[Any, ...] = (
    "40 t", 3, -1, 2.5, True, [], {}, "nobody", "", ["nobody"], [[]], {"x": 1}, [{}], "ground", float("nan"),
    ["nobody", "ground"], {"one_of": ["nobody", "x"]}, {"from": "1 m", "to": "2 m"}, {"value": "1 kg"}, "0..1 Hz",
    10**25,
)  # fmt: skip


def paths(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Paths of everything in a document."""
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, one in inner:
        yield (*path, key)
        yield from paths(one, (*path, key))


def slipped(document: dict[str, Any], path: tuple[Any, ...], slip: Any) -> dict[str, Any]:
    """The document with one node replaced; dropped or renamed for the words None and "?"."""
    new = copy.deepcopy(document)
    holder: Any = new
    for step in path[:-1]:
        holder = holder[step]
    if slip is None or (slip == "?" and isinstance(path[-1], str)):
        gone = holder.pop(path[-1])
        if slip == "?":
            holder[f"{path[-1]}x"] = gone
    else:
        holder[path[-1]] = slip
    return new


@pytest.mark.parametrize("name", FILES)
def test_one_slip_anywhere_is_a_job_or_sentences(name: str, tmp_path: Path) -> None:
    """Of each node some slips by a fixed seed, read from a file as `check` reads it."""
    given = tomllib.loads((ROOT / name).read_text(encoding="utf-8"))
    given.pop("expected", None)
    if "compressor" in name:
        (tmp_path / "mounts.csv").write_bytes((ROOT / "mounts" / "mounts.csv").read_bytes())
    draw, file, said = random.Random(11), tmp_path / "slip.toml", []
    every = list(paths(given))
    for path in every[:: max(1, len(every) // 30)]:
        for slip in (*draw.sample(SLIPS, 2), None, "?"):
            file.write_text(document_toml(slipped(given, path, slip)), encoding="utf-8")
            try:
                open_job(file)
            except InputError as error:
                said += error.messages
    assert len(said) > 40
    assert [one for one in said if not (len(one) < 400 and one.startswith(("slip.toml", str(tmp_path))))] == []


BRIDGE = """\
[bodies.deck]
mass = "40 t"
[links.girder]
between = ["deck", "ground"]
stiffness = "6.3 MN/m"
[absorbers.tmd]
on = "deck"
mass_ratio = 0.01
tuning = 0.98
damping_ratio = 0.1
[excitations.walkers]
kind = "force"
on = "deck"
amplitude = "600 N"
speed = "2 Hz"
[measures.sway]
response = "displacement"
of = "deck"
"""
SKID = """\
[bodies.set]
mass = "1850 kg"
inertia = ["310 kg m2", "620 kg m2", "590 kg m2"]
[mounts.foot]
between = ["set", "ground"]
at = [["1 m", "1 m", "0 m"], ["1 m", "-1 m", "0 m"], ["-1 m", "1 m", "0 m"], ["-1 m", "-1 m", "0 m"]]
stiffness = "1 MN/m"
shear_ratio = 0.5
[excitations.engine]
kind = "force"
on = "set"
direction = "z"
at = ["1 m", "0 m", "0 m"]
amplitude = "1 kN"
speed = "20 Hz"
[measures.sway]
response = "displacement"
of = "set"
direction = "z"
"""
SAID: dict[str, tuple[str, str, str, str]] = {
    "an unknown end beside a tuned absorber": (
        BRIDGE, '"ground"', '"grund"',
        'line 4: links.girder.between = ["deck", "grund"] names "grund", which is no body, base or ground. '
        'Did you mean "ground"?',
    ),
    "a body without keys": (
        BRIDGE, '[bodies.deck]\nmass = "40 t"', '[bodies]\ndeck = "40 t"',
        'line 2: bodies.deck = "40 t" is not a table. Write [bodies.NAME] and its keys below it.',
    ),
    "an unknown body in space": (
        SKID, 'on = "set"', 'on = "sett"',
        'line 11: excitations.engine.on = "sett" names no body of this scene. Did you mean "set"?',
    ),
    "mounts that are no table": (
        SKID, SKID[SKID.index("[mounts") : SKID.index("[exc")], "[x]\n",
        "line 1: mounts = [] is not a table. Write [mounts.NAME].",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("text", "old", "new", "words"), SAID.values(), ids=SAID)
@pytest.mark.parametrize("verb", ["check", "solve"])
def test_a_slip_is_told_word_for_word(
    text: str, old: str, new: str, words: str, verb: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert old in text
    file = tmp_path / "slip.toml"
    broken = text.replace(old, new)
    file.write_text("mounts = []\n" + broken.replace("[x]\n", "") if "[x]" in broken else broken, encoding="utf-8")
    assert main([verb, str(file)]) == 2
    assert capsys.readouterr().err.splitlines()[0] == f"slip.toml {words}"


def test_nothing_that_holds_a_body_in_space_is_told() -> None:
    document = tomllib.loads(SKID)
    del document["mounts"]
    with pytest.raises(InputError, match=r"nothing holds bodies\.set"):
        from_dict(document)
