"""Every mistake in a catalogue and around a part is said in its own words, with row, column and the way out."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from refusals import refused
from vibopt.scene.read import read
from vibopt.solve import solve

HEADS = "part;rated load min [N];rated load max [N];stiffness [N/mm];loss factor;price [EUR]"
GOOD = f"{HEADS}\nM40;200;800;80;0,1;12,5\nM60;400;1600;160;0,1;20\n"
FILE = """
[bodies.pump]
mass = "240 kg"

[links.feet]
between = ["pump", "ground"]
count = 4
part = {part}
{more}
[measures.bounce]
response = "natural_frequency"

[goal]
minimise = "{goal}"
"""
PART = '{ catalogue = "parts.csv" }'


def said(
    folder: Path, csv: str | None, part: str = PART, *, more: str = "", goal: str = "price", encoding: str = "utf-8"
) -> str:
    """What reading the file and its catalogue says."""
    if csv is not None:
        (folder / "parts.csv").write_bytes(csv.encode(encoding))
    file = folder / "pump.toml"
    file.write_text(FILE.replace("{part}", part).replace("{more}", more).replace("{goal}", goal), encoding="utf-8")
    caught = refused(read, file)
    return str(caught).replace(str(folder), "FOLDER")


LINE = "pump.toml line 8: parts.csv"
WRONG_FILES = {
    "empty": (
        "",
        "pump.toml line 8: parts.csv is empty. Its first row names the columns: part, rated load max [N], stiffness "
        "[N/mm], ...",
    ),
    "open quotation mark": (
        GOOD.replace("M60", '"M60'),
        f"{LINE} row 3 has a quotation mark that is never closed. Close it, or remove it.",
    ),
    "beyond all parts": (
        GOOD.replace(";80;", ";1e40;"),
        f'{LINE} row 2, column D ("stiffness [N/mm]"): 1e40 is beyond what any part has.',
    ),
    "no part": (HEADS, f"{LINE} row 1: there is no part below the heading. Add one row a part."),
    "text in a number cell": (
        GOOD.replace(";80;", ";eighty;"),
        f'{LINE} row 2, column D ("stiffness [N/mm]"): "eighty" is no number. Write one in the unit of the heading, '
        "without it.",
    ),
    "empty cell": (
        GOOD.replace(";80;", ";;"),
        f'{LINE} row 2, column D ("stiffness [N/mm]"): is empty. Write a number, or leave the part out.',
    ),
    "negative rating": (
        GOOD.replace(";1600;", ";-1600;"),
        f'{LINE} row 3, column C ("rated load max [N]"): -1600 is negative. Write its size.',
    ),
    "zero stiffness": (
        GOOD.replace(";80;", ";0;"),
        f'{LINE} row 2, column D ("stiffness [N/mm]"): 0 is not greater than zero.',
    ),
    "least above greatest": (
        GOOD.replace(";200;800;", ";900;800;"),
        f'{LINE} row 2, column B ("rated load min [N]"): 900 is a least load above the greatest. Exchange the two.',
    ),
    "duplicate names": (
        GOOD.replace("M60", "M40"),
        f'{LINE} row 3, column A ("part"): "M40" is the name of the part in row 2 too. Give each its own.',
    ),
    "no stiffness": (
        "part;rated load max [N]\nM40;800\n",
        f'{LINE} row 1: no column holds the stiffness. Add a column "stiffness [N/mm]".',
    ),
    "no rating": (
        "part;stiffness [N/mm]\nM40;80\n",
        f'{LINE} row 1: no column holds the rated load. Add a column "rated load max [N]".',
    ),
    "no name": (
        "rated load max [N];stiffness [N/mm]\n800;80\n",
        f'{LINE} row 1: no column holds the part. Add a column "part".',
    ),
    "unknown heading": (
        GOOD.replace("stiffness [N/mm]", "stifness [N/mm]"),
        f'{LINE} row 1, column D ("stifness [N/mm]"): is no column that vibopt knows. Did you mean "stiffness"?',
    ),
    "heading without unit": (
        GOOD.replace("stiffness [N/mm]", "stiffness"),
        f'{LINE} row 1, column D ("stiffness"): has no unit. Write "stiffness [N/mm]".',
    ),
    "wrong unit": (
        GOOD.replace("stiffness [N/mm]", "stiffness [mm]"),
        f'{LINE} row 1, column D ("stiffness [mm]"): is a length, but a stiffness is needed here. Write a stiffness, '
        'for example "2 MN/m".',
    ),
    "ratio in dB": (
        GOOD.replace("loss factor", "loss factor [dB]"),
        f'{LINE} row 1, column E ("loss factor [dB]"): is in dB, but this column holds plain ratios. Write % or no '
        "unit.",
    ),
    "the same twice": (
        GOOD.replace("rated load min [N]", "greatest load [N]"),
        f'{LINE} row 1, column C ("rated load max [N]"): says the same as column B. Keep one of them.',
    ),
    "two dampings": (
        GOOD.replace("price [EUR]", "damping [N s/m]"),
        f'{LINE} row 1, column E ("loss factor"): cannot stand beside column F ("damping [N s/m]"). Keep one.',
    ),
    "more cells": (
        GOOD.replace("12,5", "12,5;7"),
        f"{LINE} row 2: has 7 cells, but the heading names 6 columns.",
    ),
    "two mistakes": (
        GOOD.replace(";80;", ";eighty;").replace("M60", ""),
        f'{LINE} row 2, column D ("stiffness [N/mm]"): "eighty" is no number. Write one in the unit of the heading, '
        f'without it.\n{LINE} row 3, column A ("part"): is empty. Every part needs a name.',
    ),
}


@pytest.mark.parametrize(("csv", "message"), WRONG_FILES.values(), ids=WRONG_FILES)
def test_what_is_wrong_in_a_catalogue(tmp_path: Path, csv: str, message: str) -> None:
    assert said(tmp_path, csv) == message


WRONG_PARTS = {
    "missing file": (
        '{ catalogue = "other.csv" }',
        "pump.toml line 8: FOLDER/other.csv is not there. Name the CSV file, relative to the problem file.",
    ),
    "no catalogue": (
        '{ name = "M40" }',
        'pump.toml line 8: links.feet.part has no catalogue. Add it: catalogue = "mounts.csv".',
    ),
    "a name alone": (
        '"M40"',
        'pump.toml line 8: links.feet.part is a name without a catalogue. Write part = { catalogue = "mounts.csv", '
        'name = "M40" }.',
    ),
    "unknown part": (
        '{ catalogue = "parts.csv", name = "M45" }',
        'pump.toml line 8: links.feet.part names "M45", which is no part of parts.csv. Did you mean "M40"?',
    ),
    "unknown part of only": (
        '{ catalogue = "parts.csv", only = ["M40", "X"] }',
        'pump.toml line 8: links.feet.part names "X", which is no part of parts.csv. Known: M40, M60.',
    ),
    "name and only": (
        '{ catalogue = "parts.csv", name = "M40", only = ["M40"] }',
        "pump.toml line 8: links.feet.part has both name and only. Keep one: name fixes the part, only leaves a "
        "choice.",
    ),
    "unknown key": (
        '{ catalogue = "parts.csv", nane = "M40" }',
        'pump.toml line 8: unknown key "nane" in links.feet.part. Did you mean "name"?',
    ),
    "a column in the file": (
        '{ catalogue = "parts.csv", price = "20 EUR" }',
        "pump.toml line 8: links.feet.part has price, but every number comes from the catalogue. Remove it.",
    ),
}


@pytest.mark.parametrize(("part", "message"), WRONG_PARTS.values(), ids=WRONG_PARTS)
def test_what_is_wrong_with_a_part(tmp_path: Path, part: str, message: str) -> None:
    assert said(tmp_path, GOOD, part) == message


def test_a_part_stands_alone(tmp_path: Path) -> None:
    assert said(tmp_path, GOOD, more='stiffness = "80 N/mm"') == (
        "pump.toml line 5: links.feet gives part and stiffness. Keep one: a part brings its stiffness and its damping "
        "with it."
    )


def test_a_price_needs_a_column_and_one_currency(tmp_path: Path) -> None:
    without = "\n".join(line.rpartition(";")[0] for line in GOOD.splitlines())
    assert said(tmp_path, without) == (
        "pump.toml line 13: goal asks for a price, but parts.csv, from which links.feet is bought, has none. Add a "
        'column "price [EUR]".'
    )
    limit = '\n[limits.budget]\nresponse = "price"\nat_most = "90 USD"\n'
    assert said(tmp_path, GOOD, more=limit) == (
        "pump.toml line 10: limits.budget.at_most is in USD, but links.feet is in EUR. Nothing is exchanged: write all "
        "prices in one currency."
    )


def test_a_price_without_parts(tmp_path: Path) -> None:
    file = tmp_path / "bare.toml"
    file.write_text(
        FILE.replace("part = {part}", 'stiffness = "80 N/mm"')
        .replace("{more}", "")
        .replace('[goal]\nminimise = "{goal}"', '[limits.budget]\nresponse = "price"\nat_most = "90 EUR"'),
        encoding="utf-8",
    )
    assert str(refused(read, file)) == (
        "bare.toml line 13: limits.budget asks for a price, but nothing is bought. Give a link its part = { catalogue "
        '= "mounts.csv" }.'
    )


@pytest.mark.parametrize(
    ("parts", "path", "goal"),
    [
        (GOOD, "links.feet.part", 'minimise = "price"'),
        (re.sub(";[^;\n]*$", "", GOOD, flags=re.M), "links.feet.part", 'maximise = "stiffness" and of = "feet"'),
    ],
)
def test_a_part_is_to_be_chosen_but_nothing_says_by_what(tmp_path: Path, parts: str, path: str, goal: str) -> None:
    (tmp_path / "parts.csv").write_text(parts, encoding="utf-8")
    file = tmp_path / "pump.toml"
    text = FILE.replace("{part}", PART).replace("{more}", "").partition("[goal]")[0]
    file.write_text(text, encoding="utf-8")
    assert str(refused(read, file)) == (
        f"pump.toml: {path} is to be chosen, but there is no [goal]. Add [goal] with {goal}, for example."
    )


def test_no_part_can_carry_the_load(tmp_path: Path) -> None:
    (tmp_path / "parts.csv").write_text(GOOD, encoding="utf-8")
    file = tmp_path / "pump.toml"
    text = FILE.replace("{part}", PART).replace("{more}", "").replace("{goal}", "price").replace("240 kg", "800 kg")
    file.write_text(text, encoding="utf-8")
    design = solve(read(file))
    assert (design.status, design.claim) == ("infeasible", "proven: each of 2 combinations of parts breaks a limit")
    assert design.reason == (
        "links.feet.part: no part will do: all 2 cannot carry the load. The nearest is links.feet.part = M60: its load "
        "is 22.6 % above the most that it is rated for."
    )


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "cp1252"])
@pytest.mark.parametrize("sign", [";", "\t", ","])
def test_a_catalogue_as_spreadsheets_export_it(tmp_path: Path, encoding: str, sign: str) -> None:
    text = GOOD if sign != "," else GOOD.replace(",", ".")
    (tmp_path / "parts.csv").write_bytes(text.replace(";", sign).replace("\n", "\r\n").encode(encoding))
    file = tmp_path / "pump.toml"
    file.write_text(FILE.replace("{part}", PART).replace("{more}", "").replace("{goal}", "price"), encoding="utf-8")
    design = solve(read(file))
    assert design.places["links.feet.part"].value == "M40"
    assert design.goal is not None
    assert design.goal[1].shown == "50 EUR"


SPACE = """
[bodies.pump]
mass = "240 kg"
inertia = ["10 kg m2", "10 kg m2", "10 kg m2"]

[mounts.feet]
between = ["pump", "ground"]
at = [["0.3 m", "0.3 m", "0 m"], ["0.3 m", "-0.3 m", "0 m"], ["-0.3 m", "0.3 m", "0 m"], ["-0.3 m", "-0.3 m", "0 m"]]
part = { catalogue = "parts.csv" }
{more}
[goal]
minimise = "price"
"""
WRONG_MOUNTS = {
    "a part and a rating": (
        GOOD,
        'rating = "100..900 N"',
        "pump.toml line 6: mounts.feet gives part and rating. Keep one: a part brings its stiffness, damping and "
        "rating with it.",
    ),
    "a damping ratio": (
        GOOD.replace("loss factor", "damping ratio"),
        "shear_ratio = 0.4",
        "pump.toml line 6: mounts.feet is bought from parts.csv, which has damping ratios: relative to what? Give the "
        "catalogue a column of damping or of loss factors.",
    ),
    "nothing across": (
        GOOD,
        "",
        "pump.toml line 6: mounts.feet has one stiffness, that along its axis: how stiff is it across? Add shear_ratio "
        "= 0.5 (across over along), or write three values: stiffness = [x, y, z].",
    ),
    "no part": (
        "",
        "",
        "pump.toml line 9: parts.csv is empty. Its first row names the columns: part, rated load max [N], stiffness "
        "[N/mm], ...",
    ),
}


@pytest.mark.parametrize(("csv", "more", "message"), WRONG_MOUNTS.values(), ids=WRONG_MOUNTS)
def test_what_is_wrong_with_the_part_of_a_mount(tmp_path: Path, csv: str, more: str, message: str) -> None:
    (tmp_path / "parts.csv").write_text(csv, encoding="utf-8")
    file = tmp_path / "pump.toml"
    file.write_text(SPACE.replace("{more}", more), encoding="utf-8")
    assert str(refused(read, file)) == message
