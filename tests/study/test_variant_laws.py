"""What holds of every table of variants, whatever they buy and however their numbers are rounded."""

from __future__ import annotations

from itertools import combinations, pairwise
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vibopt.scene.read import read, with_changes
from vibopt.scene.scene import Scene
from vibopt.solve import solve
from vibopt.study.freeze import frozen
from vibopt.study.variant_cells import Cell, Row, marked
from vibopt.study.variants import Variants, compare

PRESS = Path(__file__).parents[2] / "problems" / "isolation" / "rao_9_34.toml"
PARTS = {"feet": ("hard", 4, 20.0, 300e3), "top": ("soft", 1, 12.5, 150e3)}
"""Per link the part that is bought, how many, the price of one and its stiffness."""
CATALOGUE = """part;rated load max [N];stiffness [N/mm];damping [N s/m];price [{currency}]
soft;9000;150;90;12,5
hard;9000;300;90;20
"""
SCENE = """
[bodies.base]
mass = "80 kg"
[bodies.pump]
mass = "120 kg"
[links.feet]
between = ["base", "ground"]
count = 4
{feet}
[links.top]
between = ["pump", "base"]
{top}
[excitations.shaft]
kind = "unbalance"
on = "pump"
unbalance = "0.01 kg m"
speed = "1500 rpm"
[limits.floor]
response = "transmitted_force"
into = "ground"
at_most = "20 kN"
"""
OWN = {"feet": 'stiffness = "310 kN/m"\ndamping = "90 N s/m"', "top": 'stiffness = "140 kN/m"\ndamping = "90 N s/m"'}
ALL = tuple(owners for count in range(3) for owners in combinations(PARTS, count))


def _scene(folder: Path, owners: tuple[str, ...], currency: str = "EUR", goal: str = "") -> Scene:
    """A machine on two stages, those links of `owners` bought."""
    (folder / f"{currency}.csv").write_text(CATALOGUE.format(currency=currency))
    parts = {name: f'part = {{ catalogue = "{currency}.csv", name = "{PARTS[name][0]}" }}' for name in owners}
    file = folder / f"{'_'.join((*owners, currency))}.toml"
    file.write_text(SCENE.format(**{**OWN, **parts}) + goal)
    return read(file)


def _row(result: Variants, name: str) -> Row:
    (found,) = (one for one in result.rows if one.name == name)
    return found


def _total(owners: tuple[str, ...]) -> float:
    return sum(PARTS[name][1] * PARTS[name][2] for name in owners)


@pytest.mark.parametrize("wanted", [False, True])
@pytest.mark.parametrize("set_", [one for n in (2, 3) for one in combinations(ALL, n)], ids=str)
def test_a_price_is_that_of_what_is_bought_and_best_only_where_as_much_is_bought(
    tmp_path: Path, set_: tuple[tuple[str, ...], ...], wanted: bool
) -> None:
    goal = '[measures.minimised]\nresponse = "price"\n'
    scenes = {str(one): _scene(tmp_path, one, goal=goal if wanted and one else "") for one in set_}
    result = compare(scenes)
    rows = [one for one in result.rows if one.name in ("least price", "price of all parts")]
    assert len(rows) == 1
    everything = {name for one in set_ for name in one}
    for owners, cell in zip(set_, rows[0].cells, strict=True):
        assert (cell is None) == (not owners)
        if cell is not None:
            assert cell.value == pytest.approx(_total(owners))
            missing = [name for name in ("feet", "top") if name in everything and name not in owners]
            assert ("without" in cell.text) == bool(missing)
            assert all(name in cell.text for name in missing)
            cheapest = min((_total(one) for one in set_ if set(one) == everything), default=None)
            dearer = any(_total(one) != cheapest for one in set_ if one)
            assert cell.best == (set(owners) == everything and dearer and _total(owners) == cheapest)


def test_prices_in_two_currencies_have_no_best(tmp_path: Path) -> None:
    result = compare({"A": _scene(tmp_path, ("feet",)), "B": _scene(tmp_path, ("feet", "top"), "USD")})
    price = _row(result, "price of all parts")
    assert [one and (one.text, one.best) for one in price.cells] == [("80 EUR without top", False), ("92.5 USD", False)]


@pytest.mark.parametrize("set_", [one for n in (2, 3, 4) for one in combinations(ALL, n)], ids=str)
def test_a_number_that_differs_has_its_row_with_every_variant_that_has_it_bought_or_not(
    tmp_path: Path, set_: tuple[tuple[str, ...], ...]
) -> None:
    result = compare({str(one): _scene(tmp_path, one) for one in set_})
    for name, own in (("feet", 310e3), ("top", 140e3)):
        values = [PARTS[name][3] if name in owners else own for owners in set_]
        found = [row for row in result.rows if row.name == f"links.{name}.stiffness"]
        assert len(found) == (len(set(values)) > 1)
        for row in found:
            assert [one and one.value for one in row.cells] == values


def _asked(folder: Path, feet: str) -> Scene:
    file = folder / "asked.toml"
    file.write_text(SCENE.format(**OWN | {"feet": feet}) + '[goal]\nminimise = "transmitted_force"\ninto = "ground"\n')
    return read(file)


def test_a_choice_keeps_its_row_beside_a_variant_that_has_a_part(tmp_path: Path) -> None:
    bought = _scene(tmp_path, ("feet",))
    chosen = _asked(tmp_path, 'part = { catalogue = "EUR.csv" }')
    own = _asked(tmp_path, 'stiffness = { from = "200 kN/m", to = "400 kN/m" }\ndamping = "90 N s/m"')
    for scenes in ({"own": own, "B": bought}, {"B": bought, "own": own}, {"own": own, "B": chosen}):
        result = compare(scenes)
        values = dict(
            zip(scenes, (one and one.value for one in _row(result, "links.feet.stiffness").cells), strict=True)
        )
        picked = _row(result, "links.feet.part").cells[list(scenes).index("B")]
        assert picked is not None
        assert values["B"] == {"hard": 300e3, "soft": 150e3}[picked.text]
        assert values["own"] == pytest.approx(result.designs[list(scenes).index("own")].x[0])


@given(
    values=st.lists(st.floats(1e-3, 1e6), min_size=2, max_size=5),
    noise=st.lists(st.floats(-1e-8, 1e-8), min_size=5, max_size=5),
    sense=st.sampled_from([1.0, -1.0]),
)
def test_rounding_never_moves_a_star(values: list[float], noise: list[float], sense: float) -> None:
    apart = sorted(values)
    if any(abs(a - b) <= 1e-5 * b and a != b for a, b in pairwise(apart)):
        return
    rivals = [True] * len(values)

    def stars(given: list[float]) -> list[bool]:
        cells = marked([Cell(f"{one:.17g}", one) for one in given], sense, rivals)
        return [one is not None and one.best for one in cells]

    exact = stars(values)
    assert exact == stars([one * (1.0 + off) for one, off in zip(values, noise, strict=False)])
    best = max(values) if sense > 0 else min(values)
    assert exact == ([one == best for one in values] if len(set(values)) > 1 else [False] * len(values))


@given(rooms=st.lists(st.floats(-1e-9, 1e-9), min_size=2, max_size=4))
def test_limits_that_are_all_reached_have_no_most_room(rooms: list[float]) -> None:
    cells = marked([Cell("0 %", one) for one in rooms], 1.0, [True] * len(rooms), ["0 %"] * len(rooms), least=1e-6)
    assert not any(one and one.best for one in cells)


@given(value=st.floats(1.0, 9.0), parts=st.lists(st.floats(0.0, 4e-4), min_size=2, max_size=4))
def test_entries_that_read_alike_are_marked_alike(value: float, parts: list[float]) -> None:
    values = [value * (1.0 + one) for one in parts]
    cells = marked([Cell(f"{one:.3g} N", one) for one in values], -1.0, [True] * len(values))
    starred = {one.text for one in cells if one is not None and one.best}
    assert not starred & {one.text for one in cells if one is not None and not one.best}


def test_a_design_and_the_same_saved_with_seven_digits_share_every_star() -> None:
    design = solve(read(PRESS), explain=False)
    saved = frozen(design.scene, design.x)
    text = {
        "links.mount.stiffness": f"{1e-3 * design.x[0]:.7g} kN/m",
        "links.mount.damping": f"{design.x[1]:.7g} N s/m",
    }
    drawn = with_changes(saved, text)
    result = compare({"solved": design.scene, "saved": saved, "drawn": drawn})
    assert not [row.name for row in result.rows for one in row.cells if one is not None and one.best]
