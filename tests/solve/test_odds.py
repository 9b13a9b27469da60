"""Limits with a probability: shares against integrals of formulas, intervals against sums, and three verdicts."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from math import comb, erf, pi, sqrt
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapes import faults

from refusals import refused
from texts import floor, hanging, press
from vibopt.cli.main import main
from vibopt.errors import NotProven
from vibopt.jobs import answer, from_text
from vibopt.manual.schema import schema_of_answers
from vibopt.program.drawn import MET, NOT_MET, OPEN, Sampled, clopper_pearson, drawn
from vibopt.scene.uncertain import Uncertain, uncertain
from vibopt.study.sweep import sweep
from vibopt.study.whatif import whatif
from vibopt.values.tolerance import Scatter

PRESS = '\ntitle = "Press"\n' + press(
    '{ value = "4 MN/m", tolerance = { uniform = "20 %" } }', "9 kN s/m", floor("6.6 kN", with_probability="90 %")
)


def share_of(bound: float, sigma: float, width: float) -> float:
    """Share of machines that sag no more: the normal mass in closed form, the uniform spring by Simpson's rule."""
    k = np.linspace(2e5 * (1.0 - width), 2e5 * (1.0 + width), 2001)
    lightest = bound * k / 9.80665
    below = np.array([0.5 * (1.0 + erf((one / 300.0 - 1.0) / (sigma * sqrt(2.0)))) for one in lightest])
    weights = np.ones(2001)
    weights[1:-1:2], weights[2:-1:2] = 4.0, 2.0
    return float((weights * below).sum() / weights.sum())


@settings(max_examples=40)
@given(
    st.sampled_from(["a", "b", "press", "pump", "x1", "x2", "x3"]),
    st.floats(1.0, 12.0), st.floats(1.0, 25.0), st.floats(0.95, 1.35), st.sampled_from([60.0, 90.0, 95.0, 99.0]),
)  # fmt: skip
def test_the_interval_holds_the_share_and_a_verdict_is_right(
    name: str, sigma: float, width: float, part: float, wanted: float
) -> None:
    bound = part * 300.0 * 9.80665 / 2e5
    text = hanging(name=name, sigma=sigma, width=width, bound=bound, wanted=wanted)
    design = answer(from_text(text, "hanging.toml"))
    assert design.tolerances is not None
    odds = design.tolerances.odds["sag"]
    truth = share_of(bound, sigma / 100.0, width / 100.0)
    assert odds.low <= truth <= odds.high
    right = {MET: truth >= wanted / 100.0, NOT_MET: truth < wanted / 100.0, OPEN: odds.drawn > 1000}
    assert right[odds.verdict]
    assert design.status == {MET: "met", NOT_MET: "violated", OPEN: "unproven"}[odds.verdict]
    row = design.limits["sag"]
    assert row.met == (odds.verdict == MET)
    worst = 300.0 * 9.80665 / 2e5 * (1.0 + 3.0 * sigma / 100.0) / (1.0 - width / 100.0)
    assert odds.worst.value == pytest.approx(worst, rel=1e-9)
    assert not design.proven


def test_a_limit_that_falls_with_one_number_is_told_by_its_quantile() -> None:
    """The force grows with the spring: of a uniform one 90 % stay below that of 90 % of its width."""
    top, design = 3000.0 * 2.0 * pi / 60.0, answer(from_text(PRESS, "press.toml"))

    def force(k: float) -> float:
        spring = k + 1j * top * 9e3
        return float(30e3 * abs(spring / (spring - 300.0 * top**2)))

    assert design.tolerances is not None
    odds = design.tolerances.odds["floor"]
    exact = next(k for k in np.linspace(3.2e6, 4.8e6, 160001) if force(k) > 6.6e3)
    truth = (exact - 3.2e6) / 1.6e6
    assert odds.low <= truth <= odds.high
    assert odds.worst.value == pytest.approx(force(4.8e6), rel=1e-9)
    assert force(4.8e6) > design.limits["floor"].value.value > force(3.2e6 + 0.9 * 1.6e6)


@settings(max_examples=60)
@given(st.integers(1, 60), st.data(), st.floats(0.8, 0.999))
def test_the_interval_is_that_of_the_sums_of_binomial_chances(n: int, data: Any, confidence: float) -> None:
    k = data.draw(st.integers(0, n))
    low, high = clopper_pearson(k, n, confidence)
    tail = 0.5 * (1.0 - confidence)

    def chance(some: range, p: float) -> float:
        return sum(comb(n, j) * p**j * (1.0 - p) ** (n - j) for j in some)

    assert (low == 0.0) if k == 0 else chance(range(k, n + 1), low) == pytest.approx(tail, rel=1e-7)
    assert (high == 1.0) if k == n else chance(range(k + 1), high) == pytest.approx(tail, rel=1e-7)


@settings(max_examples=60)
@given(
    st.integers(0, 10**6), st.integers(20, 900), st.sampled_from([0.5, 0.9, 0.97]), st.floats(0.05, 3.0), st.booleans()
)
def test_what_so_many_stay_within_is_within_a_bound_where_the_verdict_is_met(
    seed: int, n: int, wanted: float, bound: float, least: bool
) -> None:
    values = np.random.default_rng(seed).exponential(size=n)
    seen = Sampled(values, values >= bound if least else values <= bound, 0.99)
    reached = seen.stays_within(wanted, least=least)
    within = reached >= bound if least else reached <= bound
    assert within == (seen.verdict(wanted) == MET)


@settings(max_examples=20)
@given(st.sampled_from(["normal", "uniform"]), st.floats(0.01, 0.2), st.text("abc.", min_size=1, max_size=8))
def test_what_is_drawn_has_its_distribution_and_is_the_same_each_time(kind: str, size: float, path: str) -> None:
    one = [Uncertain(path, Scatter(kind, size))]
    factors = drawn(one, 4096)[:, 0]
    assert np.array_equal(factors[:256], drawn(one, 256)[:, 0])
    assert not np.array_equal(factors, drawn(one, 4096, "again")[:, 0])
    spread = size if kind == "normal" else size / sqrt(3.0)
    assert abs(factors.mean() - 1.0) <= 5.0 * spread / 64.0
    assert factors.std() == pytest.approx(spread, rel=0.08)
    assert kind == "normal" or abs(factors - 1.0).max() <= size


def test_deviations_that_were_measured_are_drawn_alike() -> None:
    text = PRESS.replace('{ uniform = "20 %" }', '{ data = ["-10 %", "0 %", "5 %", "30 %"] }')
    text = text.replace('"90 %"', '"60 %"')
    design = answer(from_text(text, "press.toml"))
    assert design.tolerances is not None
    odds = design.tolerances.odds["floor"]
    assert odds.low <= 0.75 <= odds.high  # only the stiffest breaks 6.6 kN
    assert odds.verdict == MET
    assert uncertain(design.job)[0].tolerance == pytest.approx(0.3)


@pytest.mark.parametrize("wanted", ["50 %", "99.9999 %", "0.999999", "0.5"])
def test_the_ends_that_the_refusal_offers_are_taken(wanted: str) -> None:
    scene = from_text(PRESS.replace('"90 %"', wanted if wanted[-1] != "%" else f'"{wanted}"'), "press.toml")
    assert scene.limits["floor"].with_probability in (0.5, 0.999999)


def test_a_bound_at_the_share_itself_cannot_be_told() -> None:
    bound = 300.0 * 9.80665 / 2e5
    text = hanging(name="a", sigma=5.0, width=0.001, bound=bound, wanted=50.0)
    design = answer(from_text(text, "hanging.toml"))
    assert design.status == "unproven"
    assert design.claim.startswith("cannot be told with so many machines: sag; sag: ")
    assert design.tolerances is not None
    assert design.tolerances.odds["sag"].drawn == 16384
    with pytest.raises(NotProven):
        answer(from_text(text.replace('"50.0 %"', '"40 %"').replace("40", "55"), "hanging.toml")).require_proof()


def test_studies_draw_the_same_machines() -> None:
    job = from_text(PRESS, "press.toml")
    both = [sweep(job, {"limits.floor.at_most": one}).table() for one in ("6.2, 6.6 kN", "6.6, 6.2 kN")]
    assert sorted(map(str, both[0])) == sorted(map(str, both[1]))
    assert len({str(row) for row in both[0]}) == 2
    kept = whatif(job, {"links.mount.stiffness.tolerance.uniform": "1 %"}, keep_design=True)
    assert kept.after.status in ("met", "violated")
    assert not kept.thresholds


def test_a_tighter_bound_has_no_more_room() -> None:
    """Enough machines are drawn for the value, however soon a verdict is reached."""
    margins = []
    for bound in (5.0, 6.0, 6.6, 7.0):
        text = PRESS.replace("6.6 kN", f"{bound} kN").replace('"90 %"', '"99 %"')
        margins.append(answer(from_text(text, "press.toml")).limits["floor"].margin)
    assert all(np.isfinite(margins))
    assert margins == sorted(margins)


@settings(max_examples=3)
@given(st.floats(0.5, 4.0), st.floats(0.5, 4.0), st.floats(8.5, 11.0))
def test_answers_that_are_compared_are_told_by_the_same_machine(one: float, other: float, bound: float) -> None:
    """The value is that of one machine drawn: by formula its spring is as many deviations off before as after."""
    text = PRESS.replace('"4 MN/m"', '"7 MN/m"').replace('"9 kN s/m"', '"0 N s/m"').replace("6.6 kN", "10 kN")
    text = text.replace('{ uniform = "20 %" }', f'{{ normal = "{one!r} %" }}')
    wider = {"links.mount.stiffness.tolerance.normal": f"{other!r} %", "limits.floor.at_most": f"{bound!r} kN"}
    top = (3000.0 * 2.0 * pi / 60.0) ** 2
    for keep in (False, True):
        found = whatif(from_text(text, "press.toml"), wider, keep_design=keep)
        forces = [each.limits["floor"].value.value for each in (found.before, found.after)]
        springs = [300.0 * top * force / (30e3 + force) for force in forces]
        off = [(k / 7e6 - 1.0) / size for k, size in zip(springs, (one, other), strict=True)]
        assert off[0] == pytest.approx(off[1], rel=1e-6)
        assert off[0] > 0.0


def without_values(out: str) -> str:
    """What is said in a line, without the worst values behind each verdict."""
    return re.sub(r"(met|violated|unproven)( [\d.]+( \S+ pk)?)+", r"\1", " ".join(out.split()))


def test_a_sweep_says_what_cannot_be_told_and_looks_for_no_edges(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The bound that by formula just 90 % of all machines keep is left open."""
    file, spring = tmp_path / "press.toml", 3.2e6 + 0.9 * 1.6e6
    file.write_text(PRESS.replace('"9 kN s/m"', '"0 N s/m"'), encoding="utf-8")
    bound = 30.0 * spring / (300.0 * (3000.0 * 2.0 * pi / 60.0) ** 2 - spring)
    main(["sweep", str(file), "--vary", f"limits.floor.at_most=4, {bound:.6f}, 8 kN"])
    shown = without_values(capsys.readouterr().out)
    assert "violated floor BROKEN" in shown
    assert "unproven floor cannot be told" in shown
    assert "8 kN pk met" in shown
    with file.open("a", encoding="utf-8") as more:
        more.write('[limits.way]\nresponse = "displacement"\nof = "press"\nat_most = "1 nm"\n')
    main(["sweep", str(file), "--vary", f"limits.floor.at_most={bound:.6f}, 8 kN"])
    both = without_values(capsys.readouterr().out)
    assert "violated floor BROKEN or cannot be told, way BROKEN" in both
    assert "8 violated way BROKEN" in both
    assert shown.endswith(
        "Where the answer changes between these values is not looked for: floor asks for a probability, which machines "
        "that are drawn tell."
    )


def test_a_sweep_of_two_bounds_has_no_edges() -> None:
    found = sweep(from_text(PRESS, "press.toml"), {"limits.floor.at_most": "6, 8 kN"})
    assert [point.status for point in found.points] == ["violated", "met"]
    assert found.boundaries == ()
    assert found.drawn == ("floor",)


def test_prices_of_a_draw_are_refused() -> None:
    from vibopt.study.explain import explain
    from vibopt.study.prices import prices

    job = from_text(PRESS, "press.toml")
    assert refused(prices, job).messages == (
        "press.toml: a limit asks for a probability, and what a step buys of it is the luck of the draw. Leave "
        "with_probability out for prices, or compare two answers: vibopt whatif FILE --set PATH=VALUE.",
    )
    said = explain(job)
    assert said.prices is None
    assert said.answer.notes[-1] == (
        "No price is told: a limit asks for a probability, and what a step buys of it is the luck of the draw."
    )


NONE = "is no share that machines which are drawn can tell."
WAY = 'Write a share from "50 %" to "99.9999 %", for example with_probability = "99 %".'
KINDS = 'Write { normal = "2 %" } for a standard deviation, { uniform = "5 %" } or { data = ["+1 %", "-0.5 %"] }.'
MINE = '{ value = "4 MN/m", tolerance = { uniform = "20 %" } }'


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('"90 %"', '"120 %"', f'line 19: limits.floor.with_probability = "120 %" is more than all machines. For every '
         f"machine within the tolerances leave it out. {WAY}"),
        ('"90 %"', '"100 %"', f'line 19: limits.floor.with_probability = "100 %" is all machines. For every machine '
         f"within the tolerances leave it out. {WAY}"),
        ('"90 %"', '"99.99999 %"', f'line 19: limits.floor.with_probability = "99.99999 %" {NONE} {WAY}'),
        ('"90 %"', '"often"', f'line 19: limits.floor.with_probability = "often" is no share of all machines. {WAY}'),
        (MINE, '"4 MN/m"', "line 19: limits.floor has with_probability, but no number scatters. Add one, for example "
         'tolerance = { normal = "2 %" } of a mass.'),
        ('{ uniform = "20 %" }', '"20 %"', "line 19: limits.floor has with_probability, but of links.mount.stiffness "
         'it is only known how far it may be off. Write its distribution, tolerance = { uniform = "5 %" } or '
         '{ normal = "2 %" }.'),
        ('at_most = "6.6 kN"', 'at_most = "6.6 kN"\nat_least = "1 kN"', "line 20: limits.floor has "
         "with_probability, but that goes with at_most or at_least, one of the two. Write two "
         "limits, or remove with_probability."),
        ("{ uniform =", "{ gauss =", f'line 7: links.mount.stiffness = {MINE.replace("uniform", "gauss")} has a '
         f"tolerance that is no distribution. {KINDS}"),
        ('{ uniform = "20 %" }', '{ normal = "25 %" }', "line 7: links.mount.stiffness = "
         f'{MINE.replace("uniform", "normal").replace("20", "25")} has a standard deviation above 20 %, with which '
         'some machines would have nothing of it. Write { uniform = "..." } or { data = [...] }.'),
        ('{ uniform = "20 %" }', '{ uniform = "0 %" }', "line 7: links.mount.stiffness = "
         f"{MINE.replace('20', '0')} has a uniform tolerance that is not greater than zero. {KINDS}"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused(old: str, new: str, words: str) -> None:
    error = refused(from_text, PRESS.replace(old, new), "press.toml")
    assert f"press.toml {words}" in error.messages
    assert len(error.messages) <= 2


def test_a_saved_design_keeps_its_distributions() -> None:
    from vibopt.study.freeze import frozen

    text = PRESS.replace('with_probability = "90 %"', "").replace(
        '"9 kN s/m"', '{ from = "1 kN s/m", to = "9 kN s/m" }'
    )
    text += '[goal]\nminimise = "damping"\nof = "mount"\n'
    text = text.replace('to = "9 kN s/m" }', 'to = "9 kN s/m", tolerance = { normal = "3 %" } }').replace(
        "7 kN", "9 kN"
    )
    design = answer(from_text(text, "press.toml"))
    kept = {one.path: one.tolerance for one in uncertain(frozen(design.scene, design.x))}
    assert kept == {"links.mount.stiffness": Scatter("uniform", 0.2), "links.mount.damping": Scatter("normal", 0.03)}


def test_no_page_says_more_than_the_share(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The worst machine breaks the bound: nothing that is signed may say that all machines keep it."""
    file, page = tmp_path / "press.toml", tmp_path / "sheet.html"
    heads = []
    for wanted in ("90 %", "95.5 %", "99 %"):
        file.write_text(PRESS.replace('"90 %"', f'"{wanted}"'), encoding="utf-8")
        main(["solve", str(file)])
        shown = capsys.readouterr().out
        main(["solve", str(file), "--json"])
        data = json.loads(capsys.readouterr().out)
        schema = schema_of_answers()
        assert list(faults(data, schema, schema)) == []
        assert data["tolerances"]["odds"]["floor"]["wanted"] == pytest.approx(float(wanted[:-2]) / 100.0)
        assert not data["proven"]
        main(["report", str(file), "--sheet", "-o", str(page)])
        capsys.readouterr()
        text = page.read_text(encoding="utf-8")
        heads.append((shown.splitlines()[1], "NOT MET" in text, "cannot be told" in text))
        assert "every machine within" not in text
        assert "worst machines found" not in text
        assert "(uniform)" in text
    assert heads[0] == ("met: all limits hold, floor in 90 % of all machines", False, False)
    assert heads[1] == ("unproven: it cannot be told whether enough of all machines keep every limit", True, True)
    assert heads[2] == ('violated: the machine breaks "floor"', True, False)


def test_the_way_out_of_a_choice_leads_to_the_greatest_spring_that_enough_machines_bear(tmp_path: Path) -> None:
    """By formula 99 % bear a spring 2.326 deviations below a quarter of m omega^2; the sweep stops just before it."""
    file, saved = tmp_path / "press.toml", tmp_path / "design.toml"
    text = PRESS.replace('with_probability = "90 %"', "").replace('"9 kN s/m"', '"0 N s/m"').replace("6.6 kN", "10 kN")
    text = text.replace('value = "4 MN/m", tolerance = { uniform = "20 %" }', 'from = "1 MN/m", to = "20 MN/m", '
                        'tolerance = { normal = "2 %" }')  # fmt: skip
    file.write_text(text + '[goal]\nmaximise = "stiffness"\nof = "mount"\n', encoding="utf-8")
    assert main(["solve", str(file), "--save", str(saved)]) == 0
    design = saved.read_text(encoding="utf-8").replace('"10 kN"\n', '"10 kN"\nwith_probability = "99 %"\n')
    found = sweep(from_text(design, "design.toml"), {"links.mount.stiffness.value": "0 %..+2 %"}, points=3)
    exact = 0.25 * 300.0 * (3000.0 * 2.0 * pi / 60.0) ** 2 / (1.0 + 2.3263 * 0.02)
    said = {point.value.value / exact - 1.0: point.status for point in found.points}
    assert [status for _, status in sorted(said.items())] == ["met", "met", "violated"]
    assert max(off for off, status in said.items() if status == "met") > -0.004
    assert min(off for off, status in said.items() if status == "violated") > 0.0


def of_data(masses: list[str], springs: list[str], bound: float, wanted: float) -> str:
    """The mass on its spring, both off by deviations that were measured."""
    text = hanging(name="a", sigma=1.0, width=1.0, bound=bound, wanted=wanted)
    return text.replace('normal = "1.0 %"', f"data = {masses}").replace('uniform = "1.0 %"', f"data = {springs}")


@settings(max_examples=12)
@given(
    st.lists(st.integers(-99, 99), min_size=2, max_size=40).filter(any),
    st.lists(st.integers(-99, 99), min_size=2, max_size=40).filter(any),
    st.floats(0.95, 1.1),
    st.sampled_from([60.0, 95.0, 99.95]),
)
def test_machines_of_measured_numbers_are_counted(
    masses: list[int], springs: list[int], part: float, wanted: float
) -> None:
    """Each deviation of one number with each of the other, and the value of the row is one of these machines."""
    sag = 300.0 * 9.80665 / 2e5
    said = [[f"{one / 10.0} %" for one in [*many, -1, 1]] for many in (masses, springs)]
    text = of_data(said[0], said[1], part * sag, wanted)
    design = answer(from_text(text, "hanging.toml"))
    every = sorted(sag * (1 + m / 1e3) / (1 + s / 1e3) for m in [*masses, -1, 1] for s in [*springs, -1, 1])
    kept = sum(one <= part * sag for one in every)
    assert design.tolerances is not None
    odds = design.tolerances.odds["sag"]
    assert (odds.counted, odds.kept, odds.drawn, odds.confidence) == (True, kept, len(every), 1.0)
    assert odds.low == odds.high == kept / len(every)
    assert odds.verdict == (MET if kept / len(every) >= wanted / 100.0 else NOT_MET)
    row = design.limits["sag"]
    assert row.place.endswith(f"{wanted:g} % of all machines")
    assert "at least" not in row.place
    assert row.value.value == pytest.approx(every[int(np.ceil(wanted / 100.0 * len(every) - 1e-9)) - 1], rel=1e-9)


def test_more_machines_than_can_be_counted_are_drawn() -> None:
    """317 deviations twice are 100 489 machines; and one number of another kind leaves nothing to count."""
    data = [f"{k / 50.0} %" for k in range(-150, 167)]
    text = of_data(data, data, 0.0150, 60.0)
    other = text.replace(f"data = {data}", 'normal = "2 %"', 1)
    for one in (text, other):
        design = answer(from_text(one, "hanging.toml"))
        assert design.tolerances is not None
        assert not design.tolerances.odds["sag"].counted
        assert design.limits["sag"].place.endswith("at least 60 % of all machines")


@pytest.mark.parametrize(
    ("low", "high", "said"),
    [
        (0.98416, 0.98417, "98.41 to 98.42 %"),
        (0.9999949, 0.9999999, "99.99949 to 99.99999 %"),
        (0.999999999, 1.0, "99.9999999 to 100 %"),
        (0.9999999999999, 1.0, "99.9999999 to 100 %"),
        (0.0, 0.07, "0 to 7 %"),
    ],
)
def test_a_share_is_never_told_greater_than_it_is(low: float, high: float, said: str) -> None:
    design = answer(from_text(PRESS, "press.toml"))
    assert design.tolerances is not None
    odds = replace(design.tolerances.odds["floor"], low=low, high=high)
    assert f" machines drawn keep it, of all {said} at a confidence of " in odds.words
    assert odds.least == said.split(" to ")[0] + " %"
