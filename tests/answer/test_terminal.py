"""Texts and tables for a terminal are laid out as rich lays them out, line by line, but that fewer words are broken."""

from __future__ import annotations

import re
from collections import Counter
from io import StringIO
from itertools import pairwise
from typing import Any

from hypothesis import example, given
from hypothesis import strategies as st
from rich.console import Console as Rich
from rich.padding import Padding
from rich.table import Table

from vibopt.answer.console import Console, Grid, columns, wrapped

WORDS = st.text("abcdef-/.µ²é", min_size=1, max_size=24)
TEXTS = st.lists(WORDS, max_size=16).map(" ".join) | st.lists(WORDS, max_size=5).map("  ".join)
LINES = TEXTS | st.lists(TEXTS, min_size=2, max_size=3).map("\n".join)
SHORT = st.text("abcdef-/.µ²é", max_size=6)


def by_rich(grid: Grid, text: str, width: int, indent: int) -> str:
    stream = StringIO()
    console = Rich(file=stream, width=width, color_system=None, highlight=False, markup=False, emoji=False)
    table = Table(box=None, show_header=bool(grid.heads), padding=(0, grid.gap, 0, 0), pad_edge=False)
    for k in range(len(grid.rows[0])):
        own: dict[str, Any] = {"width": grid.widths[k]} if grid.widths else {"no_wrap": k in grid.whole}
        table.add_column(grid.heads[k] if grid.heads else "", overflow="fold", **own)
    for row in grid.rows:
        table.add_row(*row)
    for one in (table, text):
        console.print(Padding(one, (0, 0, 0, indent)))
    return "".join(f"{line.rstrip()}\n" for line in stream.getvalue().splitlines())


def ours(grid: Grid, text: str, width: int, indent: int, *, colour: bool = False) -> str:
    console = Console(width, colour=colour)
    console.print(grid, indent=indent)
    console.print(text, indent=indent)
    return console.text


@st.composite
def grids(draw: Any) -> Grid:
    count = draw(st.integers(1, 5))
    whole = draw(st.sets(st.integers(0, count - 1), max_size=2))
    cells = [SHORT if k in whole else LINES for k in range(count)]
    rows = draw(st.lists(st.tuples(*cells), min_size=1, max_size=4))
    heads = draw(st.just(()) | st.tuples(*[SHORT if k in whole else TEXTS for k in range(count)]))
    return Grid(rows, heads, tuple(whole))


@given(grid=grids(), text=LINES, width=st.integers(40, 120), indent=st.sampled_from([0, 2]))
def test_texts_and_tables_stand_as_rich_sets_them(grid: Grid, text: str, width: int, indent: int) -> None:
    """Tables of which rich breaks words need not."""
    nothing = Grid([("",)])
    assert ours(nothing, text, width, indent) == by_rich(nothing, text, width, indent)
    words = Counter(" ".join(map(" ".join, [grid.heads, *grid.rows])).split())
    if Counter(by_rich(grid, "", width, indent).split()) == words:
        assert ours(grid, "", width, indent) == by_rich(grid, "", width, indent)


@given(
    rows=st.integers(1, 6).flatmap(lambda count: st.lists(st.tuples(*[TEXTS] * count), min_size=1, max_size=3)),
    spare=st.integers(0, 30),
)
@example(rows=[("mass of the middle plane", "excitations.press.amplitude", "one two six")], spare=0)
def test_no_word_is_broken_where_each_column_has_room_for_its_own(rows: list[tuple[str, ...]], spare: int) -> None:
    longest = [max(map(len, " ".join(cells).split()), default=0) for cells in zip(*rows, strict=True)]
    lines = ours(Grid(rows), "", sum(max(one + 2, 10) for one in longest) + spare, 0)
    assert Counter(lines.split()) == Counter(" ".join(map(" ".join, rows)).split())


STEP = st.text("abcdef", min_size=1, max_size=9)
PATHS = st.lists(STEP, min_size=1, max_size=4).map(".".join)


@given(
    rows=st.integers(2, 7).flatmap(lambda count: st.lists(st.tuples(*[PATHS] * count), min_size=2, max_size=4)),
    spare=st.integers(0, 12),
)
def test_a_path_is_broken_behind_its_points_alone_where_each_column_has_room_for_its_steps(
    rows: list[tuple[str, ...]], spare: int
) -> None:
    steps = {path: re.split(r"(?<=\.)", path) for row in rows for path in row}
    whole = {"".join(own[i:j]) for own in steps.values() for i in range(len(own)) for j in range(i + 1, len(own) + 1)}
    least = [max(len(step) for path in cells for step in steps[path]) for cells in zip(*rows, strict=True)]
    lines = ours(Grid(rows[1:], rows[0]), "", sum(least) + 2 * len(least) + spare, 0)
    assert set(lines.split()) <= whole


def test_headings_of_a_sweep_over_two_facts_are_whole() -> None:
    heads = (
        "speed",
        "m1.mass",
        "Verdict",
        "reaction",
        "static",
        "couple",
        "bearings.A.reaction",
        "bearings.B.reaction",
    )
    grid = Grid([("900 rpm", "45 g", "met", "1.526 N", "169.8 g mm", "164319 g mm²", "2.059 N", "0.646 N")], heads)
    assert [line.split() for line in ours(grid, "", 76, 0).splitlines()[:3]] == [
        ["bearings.", "bearings."],
        ["A.", "B."],
        ["speed", "m1.mass", "Verdict", "reaction", "static", "couple", "reaction", "reaction"],
    ]


UNPOINTED = TEXTS.map(lambda text: text.replace(".", "-"))


def test_units_of_a_series_stand_in_headings_where_its_rows_are_too_long() -> None:
    """Of columns whose numbers have one unit; as they are where all fit in, and where a column is none of numbers."""
    heads = ("grip", "Verdict", "acceleration", "plate.angle", "Limits")
    rows = [
        ("11.38 mm pk", "optimal", "5.885 m/s² pk", "1 g @ 3 deg", "grip"),
        ("9.5 mm pk", "infeasible", "-", "2 g @ 30 deg", ""),
        ("1e-3 mm pk", "optimal", "-0.25 m/s² pk", "3 g @ 300 deg", "grip"),
    ]
    assert printed(Grid(rows, heads, series=True), 60) == [
        "grip                 acceleration",
        "[mm pk]  Verdict     [m/s² pk]     plate.angle    Limits",
        "11.38    optimal     5.885         1 g @ 3 deg    grip",
        "9.5      infeasible  -             2 g @ 30 deg",
        "1e-3     optimal     -0.25         3 g @ 300 deg  grip",
    ]
    assert printed(Grid(rows, heads, series=True), 80) == printed(Grid(rows, heads), 80)
    mixed = [("1 mm", "22 s"), ("1 m", "33 s")]
    assert printed(Grid(mixed, ("a", "b"), series=True), 9) == ["      b", "a     [s]", "1 mm  22", "1 m   33"]


def printed(grid: Grid, width: int) -> list[str]:
    """Its lines on a console without colour."""
    console = Console(width)
    console.print(grid)
    return [line.rstrip() for line in console.lines]


@given(rows=st.lists(st.tuples(UNPOINTED, SHORT, UNPOINTED), min_size=1, max_size=4), width=st.integers(60, 120))
def test_columns_of_given_widths_too(rows: list[tuple[str, str, str]], width: int) -> None:
    grid = Grid(rows, widths=(20, 8, 15), gap=1)
    assert ours(grid, "", width, 0) == by_rich(grid, "", width, 0)


def test_wide_letters_take_two_columns_and_accents_none() -> None:
    assert [columns(one) for one in ("kN", "漢字", "e\u0301", "µ²")] == [2, 4, 1, 2]
    grid = Grid([("漢字", "a"), ("kN", "b")])
    assert ours(grid, "", 60, 0) == by_rich(grid, "", 60, 0) == "漢字  a\nkN    b\n\n"


def test_colour_is_written_only_where_it_is_wanted() -> None:
    console = Console(60, colour=True)
    console.print("optimal", style="bold green")
    console.print(Grid([("a", "b")], ("x", "y")))
    assert console.text == "\x1b[1;32moptimal\x1b[0m\n\x1b[2mx  y\x1b[0m\na  b\n"


NAMES = st.text("abcdefgh_.", min_size=1, max_size=70)


@given(
    rows=st.integers(2, 4).flatmap(lambda count: st.lists(st.tuples(*[NAMES] * count), min_size=1, max_size=3)),
    whole=st.sets(st.integers(0, 3)),
    width=st.integers(40, 120),
)
def test_no_letter_of_a_long_name_is_lost(rows: list[tuple[str, ...]], whole: set[int], width: int) -> None:
    """Columns that are not to be broken are, before they cut a text or leave the others no room."""
    lines = ours(Grid(rows, (), tuple(sorted(whole))), "", width, 0)
    assert all(len(one) <= width for one in lines.splitlines())
    assert Counter("".join(lines.split())) == Counter("".join(map("".join, rows)))


@given(
    steps=st.lists(st.text("abc_7", min_size=1, max_size=14).map("a{}".format), min_size=1, max_size=6),
    width=st.integers(17, 40),
)
def test_a_path_is_broken_behind_its_points_alone(steps: list[str], width: int) -> None:
    lines = wrapped(".".join(steps), width)
    assert "".join(lines) == ".".join(steps)
    assert all(columns(line) <= width for line in lines)
    assert all(line.endswith(".") for line in lines[:-1])
    assert all(columns(line + after.split(".")[0]) >= width for line, after in pairwise(lines))


def test_a_number_is_no_path() -> None:
    assert wrapped("0.123456", 4) == ["0.12", "3456"]
