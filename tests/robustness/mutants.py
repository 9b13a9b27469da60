"""Problem files with a few nodes changed: values swapped, dropped, of another unit, names misspelt."""

from __future__ import annotations

import copy
import random
import re
import shutil
import tomllib
from functools import cache
from pathlib import Path
from typing import Any

from vibopt.document.toml_writing import document_toml

ROOT = Path(__file__).parents[2] / "problems"
FILES = sorted(ROOT.glob("*/*.toml"))
ODD = [
    0, 1, -1, 2.5, 1e300, -0.0, float("nan"), float("inf"), True, False, "", "ground", "x", "\0", "é" * 200, 10**40,
    "0 rpm", "3000 rpm", "1 kN/m", "5 kg", "-3 mm", "1e29 kg", "1e-29 kg", "1e-320 kg", "0 N", "-200 dB", "1e5 dB",
    "0..0 rpm", "5..1 Hz", "10..20 Hz", "start-up", "speed^2", "peak", "60 km/h", "mm rms", "kg pp", [], {}, [[]],
    ["1 Hz", "2 Hz"], {"from": "1 N/m", "to": "2 N/m"}, {"from": 0, "to": 1}, {"one_of": ["1 kN/m", "2 kN/m"]},
    {"from": 1, "to": 5, "whole": True}, {"from": "0 rpm", "to": "100 Hz"}, "displacement", "insertion_loss", "count",
    "5 g at 30 deg", "90 deg", "12.5 mm/s rms", "choose", {"holes": 12}, {"value": "3 kg", "tolerance": "20 %"}, ["a"],
]  # fmt: skip
UNITS = ["mm", "kg", "kN", "N/m", "N s/m", "rpm", "Hz", "mm/s", "g", "%", "deg", "km/h", "g mm", "kg m2", "N m", "EUR"]
HOWS = ("drop", "rename", "misspell", "odd", "used", "unit", "number", "swap")
MILD = ("number", "number", "number", "drop", "swap")
_NUMBERS = ("0", "1", "7.5", "1e9", "1e-9", "-2", "3", "40", "600", "0.02", "2500")


def nodes(value: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Paths of everything in a document."""
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [path, *(found for key, one in inner for found in nodes(one, (*path, key)))]


def at(document: Any, path: tuple[Any, ...]) -> Any:
    for step in path:
        document = document[step]
    return document


@cache
def document(file: Path) -> dict[str, Any]:
    """A problem file without its records."""
    whole = tomllib.loads(file.read_text(encoding="utf-8"))
    return {key: one for key, one in whole.items() if key not in ("expected", "statement", "source")}


@cache
def used(folder: Path) -> list[Any]:
    """Every value that the files of a folder hold."""
    whole = [document(file) for file in FILES if file.parent == folder]
    return [at(one, path) for one in whole for path in nodes(one)[1:]]


def mutant(seed: int, files: list[Path] = FILES, *, mild: bool = False) -> tuple[Path, dict[str, Any]]:
    """A file, and what it says with one to three nodes changed; the same for the same seed.

    `mild` changes mostly leave a file that can be answered.
    """
    rolls = random.Random(f"mutant {seed}")
    file = rolls.choice(files)
    changed = copy.deepcopy(document(file))
    for _ in range(rolls.choice([1, 1, 2, 3])):
        least = 3 if mild else rolls.choice([1, 3, 3, 3])  # deep ones leave whole tables alone
        paths = [path for path in nodes(changed)[1:] if len(path) >= least]
        if mild:
            paths = [path for path in paths if re.match(r"[-+]?\d", str(at(changed, path)))]
        if paths:
            _change(rolls, changed, rolls.choice(paths), used(file.parent), MILD if mild else HOWS)
    return file, changed


def _change(
    rolls: random.Random, whole: dict[str, Any], path: tuple[Any, ...], others: list[Any], hows: tuple[str, ...]
) -> None:
    holder, key = at(whole, path[:-1]), path[-1]
    how, value = rolls.choice(hows), holder[key]
    if how == "drop":
        holder.pop(key)
    elif how in ("rename", "misspell") and isinstance(holder, dict):
        holder[_misspelt(rolls, str(key)) if how == "misspell" else f"{key}x"] = holder.pop(key)
    elif how == "misspell" and isinstance(value, str):
        holder[key] = _misspelt(rolls, value)
    elif how == "unit" and isinstance(value, str) and re.match(r"[-+\d.]", value):
        holder[key] = f"{value.split(' ')[0]} {rolls.choice(UNITS)}"
    elif how == "number" and isinstance(value, str):
        holder[key] = re.sub(r"\d+(\.\d+)?", rolls.choice(_NUMBERS), value, count=1)
    elif how == "swap" and isinstance(holder, (dict, list)) and len(holder) > 1:
        other = rolls.choice(list(holder) if isinstance(holder, dict) else range(len(holder)))
        holder[key], holder[other] = holder[other], holder[key]
    else:
        holder[key] = copy.deepcopy(rolls.choice(ODD if how in ("odd", "number", "unit") else others))


def _misspelt(rolls: random.Random, word: str) -> str:
    """A letter left out, doubled, or exchanged with the next."""
    if len(word) < 2:
        return word + "x"
    k = rolls.randrange(len(word) - 1)
    ways = (word[k + 1 :], word[k] + word[k:], word[k + 1] + word[k] + word[k + 2 :])
    return word[:k] + rolls.choice(ways)


def written(seed: int, folder: Path, files: list[Path] = FILES, *, mild: bool = False) -> Path:
    """A mutant as a problem file in `folder`, with the files that lie beside its original."""
    file, changed = mutant(seed, files, mild=mild)
    for beside in file.parent.iterdir():
        if beside.suffix != ".toml" and beside.is_file() and not (folder / beside.name).exists():
            shutil.copy(beside, folder)
    target = folder / f"mutant_{seed}.toml"
    target.write_text(document_toml(changed), encoding="utf-8")
    return target
