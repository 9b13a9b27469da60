"""The sheet: loads, modes in words, limits, and never a place to sign for what is not met."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from datetime import date
from functools import cache
from html.parser import HTMLParser
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from refusals import refused
from vibopt.answer.answer import EXIT_CODES
from vibopt.answer.clashes import Conflict
from vibopt.answer.entry import Entry
from vibopt.errors import InputError
from vibopt.mechanics.rigid import SpaceMachine
from vibopt.report.mode_shapes import Shape, shapes_of
from vibopt.report.sheet import browser, digests_of, html, printed
from vibopt.report.sheet.fit import SIZES
from vibopt.report.sheet.judgement import HELD, assumptions_of, limit_rows, verdict_of
from vibopt.report.sheet.mount_plan import plan_figure
from vibopt.report.sheet.printing import pages_of, pdf
from vibopt.report.sheet.sheet_page import machine_in
from vibopt.report.space_views import machine_figure
from vibopt.report.what_to_build import verified
from vibopt.scene.read import from_dict, from_text, read
from vibopt.scene.scene import Design
from vibopt.solve import solve
from vibopt.units import show
from vibopt.verify.as_built import machine_of

Solved = Callable[[str], Design]
DAY = date(2026, 1, 31)
ROOT = Path(__file__).parents[2] / "problems"
SPACE = ("generator_set", "genset_front_and_rear", "focalised_engine", "pump_with_absorber", "inertia_base")
WAYS = ("x", "y", "z", "rx", "ry", "rz")
MOUNTS = (ROOT / "mounts/mounts.csv").read_text(encoding="utf-8-sig").splitlines()
HEADS = MOUNTS[0].split(";")
VOID = {"meta", "br", "col"}


@cache
def answered(path: str) -> Design:
    return solve(read(ROOT / f"{path}.toml"))


class Page(HTMLParser):
    """Every tag is closed in order; texts of tables and paragraphs are kept, one blank between words."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.words: list[str] = []
        self.feed(page)
        assert self.open == []
        self.text = " ".join(" ".join(self.words).split())

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        pass

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if "style" not in self.open and "svg" not in self.open:
            self.words.append(data)


def text(design: Design, **words: Any) -> str:
    return Page(html(design, on=DAY, **words)).text


def metres(three: Sequence[float]) -> list[str]:
    return [f"{one!r} m" for one in three]


def number(given: str) -> float:
    return float(given.split()[0])


def document(**changes: Any) -> dict[str, Any]:
    """A machine on four mounts, as a file says it."""
    mass, centre, at = (changes.pop(key, None) for key in ("mass", "centre", "at"))
    corners = [[0.8, 0.4, 0.0], [0.8, -0.4, 0.0], [-0.8, 0.4, 0.0], [-0.8, -0.4, 0.0]]
    return {
        "title": "Set on four mounts",
        "bodies": {
            "genset": {
                "mass": f"{mass or 1850.0!r} kg",
                "centre": metres(centre or (0.1, 0.05, 0.45)),
                "inertia": ["310 kg m2", "620 kg m2", "590 kg m2"],
            }
        },
        "mounts": {
            "foot": {
                "between": ["genset", "ground"],
                "at": [metres(one) for one in at or corners],
                "stiffness": "2 MN/m",
                "shear_ratio": 0.55,
                "loss_factor": 0.12,
            }
        },
        "excitations": {
            "engine": {"kind": "force", "on": "genset", "direction": "z", "amplitude": "100 N", "speed": "1500 rpm"}
        },
        "limits": {"force": {"response": "transmitted_force", "into": "ground", "direction": "z", "at_most": "1 kN"}},
        **changes,
    }


def built(given: dict[str, Any]) -> SpaceMachine:
    machine = machine_of(from_dict(given, name="set.toml"), {})
    assert isinstance(machine, SpaceMachine)
    return machine


numbers = st.floats(-0.35, 0.35).map(lambda one: round(one, 3))


@settings(max_examples=25, deadline=None)
@given(mass=st.floats(20.0, 9000.0).map(lambda one: round(one, 1)), x=numbers, y=numbers, z=numbers, shift=numbers)
def test_the_loads_that_are_drawn_add_up_to_the_weight(mass: float, x: float, y: float, z: float, shift: float) -> None:
    at = [[0.8, 0.4, 0.0], [0.8 + shift, -0.4, 0.1], [-0.8, 0.4, shift], [-0.8, -0.4, 0.0]]
    figure = plan_figure(built(document(mass=mass, centre=(x, y, z), at=at)), "N")
    assert figure is not None
    labels = [one.get_text() for one in figure.axes[0].texts if "\n" in one.get_text()]
    assert len(labels) == 4
    loads = [float(one.split("\n")[1].removesuffix(" N")) for one in labels]
    assert sum(loads) == pytest.approx(mass * 9.80665, abs=5e-3 * max(map(abs, loads)))


def test_mounts_are_drawn_where_they_stand_to_scale_and_groups_by_other_markers() -> None:
    design = answered("mounts/genset_front_and_rear")
    machine = machine_in(design)
    assert isinstance(machine, SpaceMachine)
    figure = plan_figure(machine, "N")
    assert figure is not None
    axes = figure.axes[0]
    assert axes.get_aspect() == 1.0
    drawn = {one.get_gid(): one for one in axes.lines if one.get_gid()}
    assert np.array(drawn["group-front"].get_xydata()).tolist() == [[0.9, 0.4], [0.9, -0.4]]
    assert np.array(drawn["group-rear"].get_xydata()).tolist() == [[-0.8, 0.4], [-0.8, -0.4]]
    assert drawn["group-front"].get_marker() != drawn["group-rear"].get_marker()
    assert "centre of mass" in {one.get_text() for one in axes.texts}
    assert drawn.keys() == {"group-front", "group-rear"}


def by_hand(given: dict[str, Any]) -> list[tuple[float, dict[str, float]]]:
    """Frequency [rad/s] and shares of energy of each mode, from a stiffness put together mount by mount."""
    body, mount = given["bodies"]["genset"], given["mounts"]["foot"]
    centre = np.array([number(one) for one in body["centre"]])
    mass = np.diag(np.array([number(body["mass"])] * 3 + [number(one) for one in body["inertia"]]))
    stiff = np.zeros((6, 6))
    for place in mount["at"]:
        x, y, z = np.array([number(one) for one in place]) - centre
        moved = np.array([[1, 0, 0, 0, z, -y], [0, 1, 0, -z, 0, x], [0, 0, 1, y, -x, 0]], dtype=float)
        stiff += moved.T @ np.diag([0.55 * 2e6, 0.55 * 2e6, 2e6]) @ moved
    squares, modes = np.linalg.eig(np.linalg.inv(mass) @ stiff)
    found = []
    for square, mode in sorted(zip(squares.real, modes.T.real, strict=True), key=lambda one: float(one[0])):
        energy = np.diag(mass) * mode**2
        found.append((float(np.sqrt(square)), dict(zip(WAYS, energy / energy.sum(), strict=True))))
    return found


@settings(max_examples=25, deadline=None)
@given(x=numbers, y=numbers, z=numbers)
def test_shapes_are_those_of_eigenvectors_put_together_by_hand(x: float, y: float, z: float) -> None:
    given_ = document(centre=(x, y, z + 0.01))
    mine = by_hand(given_)
    if min(b[0] / a[0] for a, b in pairwise(mine)) < 1.001:
        return  # nearly equal frequencies: the shares depend on rounding
    for shape, (omega, shares) in zip(shapes_of(built(given_)), mine, strict=True):
        assert shape.frequency == pytest.approx(omega, rel=1e-9)
        assert {one.way: one.share for one in shape.parts} == pytest.approx(shares, abs=1e-6)
        assert shape.damping == pytest.approx(0.06, rel=1e-9)


def test_words_name_the_motions_with_most_energy() -> None:
    words = {"x": "along x", "y": "along y", "z": "vertical", "rx": "rocking about x", "ry": "rocking about y"}
    given_ = document()
    for shape, (_, shares) in zip(shapes_of(built(given_)), by_hand(given_), strict=True):
        first, second, *_ = sorted(shares, key=lambda way: -shares[way])
        assert shape.words.startswith(words.get(first, "turning about z"))
        assert (" with " in shape.words) == (shares[second] >= 0.1)
        assert f"({round(100 * shares[first])} %)" in shape.words


def test_equal_modes_are_told_apart() -> None:
    """As stiff along x as along y, the centre in the plane of the mounts: two modes of one frequency."""
    given_ = document(centre=(0.0, 0.0, 0.0))
    foot = given_["mounts"]["foot"]
    del foot["shear_ratio"]
    # own axes between x and y, and stiffnesses that differ by less than anybody can tell
    foot |= {"stiffness": ["1.1 MN/m", "1.10000001 MN/m", "2 MN/m"], "across": [0.8, 0.6, 0.0]}
    shapes = shapes_of(built(given_))
    pair = [one for one in shapes if one.frequency == pytest.approx(np.sqrt(4 * 0.55 * 2e6 / 1850.0))]
    assert sorted(one.words for one in pair) == ["along x", "along y"]


def chain() -> dict[str, Any]:
    return {
        "title": "Two masses",
        "bodies": {"upper": {"mass": "3 kg"}, "lower": {"mass": "5 kg"}},
        "links": {
            "spring": {"between": ["upper", "lower"], "stiffness": "2000 N/m", "damping": "4 N s/m"},
            "mount": {"between": ["lower", "ground"], "stiffness": "7000 N/m", "damping": "14 N s/m"},
        },
        "excitations": {"hand": {"kind": "force", "on": "upper", "amplitude": "1 N", "speed": "10 Hz"}},
        "limits": {"top": {"response": "displacement", "of": "upper", "at_most": "1 m"}},
    }


def test_bodies_on_a_line_move_in_step_and_against_each_other() -> None:
    mass, stiff = np.diag([3.0, 5.0]), np.array([[2000.0, -2000.0], [-2000.0, 9000.0]])
    squares, modes = np.linalg.eig(np.linalg.inv(mass) @ stiff)
    order = np.argsort(squares)
    low, high = shapes_of(machine_of(from_dict(chain(), name="chain.toml"), {}))
    for shape, square, mode in zip((low, high), squares[order], modes.T[order], strict=True):
        energy = np.diag(mass) * mode**2 / (np.diag(mass) @ mode**2)
        assert shape.frequency == pytest.approx(np.sqrt(square))
        assert {one.body: one.share for one in shape.parts} == pytest.approx(
            {"upper": energy[0], "lower": energy[1]}, rel=1e-9
        )
        assert shape.damping == pytest.approx(0.002 * np.sqrt(square) / 2.0)  # the damping goes with the stiffness
        assert (mode[0] * mode[1] > 0) == shape.words.endswith("in step")
    assert low.words == "upper (87 %) with lower (13 %), in step"
    assert high.words == "lower (87 %) with upper (13 %), against each other"


def test_a_single_body_and_what_turns_have_words_of_their_own() -> None:
    one = chain()
    del one["bodies"]["upper"], one["links"]["spring"]
    one["excitations"]["hand"]["on"] = one["limits"]["top"]["of"] = "lower"
    machine = machine_of(from_dict(one, name="one.toml"), {})
    (shape,) = shapes_of(machine)
    assert shape.words == "lower moves"
    assert shape.damping == pytest.approx(14.0 / (2.0 * np.sqrt(5.0 * 7000.0)))
    assert shapes_of(machine, ["lower"])[0].words == "lower turns"
    assert Shape(1.0, None, ()).words == ""


def test_everything_stands_on_the_sheet() -> None:
    said = text(
        answered("mounts/generator_set"),
        changes=["limits.sag.at_most=8 mm"],
        digests={"a.toml": "0123456789abcdef" * 4},
    )
    for words in (
        "Diesel generator set on four mounts generator_set.toml, 2026-01-31; SHA-256 a.toml 0123 4567 89ab cdef",
        "Changed against the file: limits.sag.at_most=8 mm",
        "All limits met Least transmitted force into ground along z is 156.8 N pk",
        "1850 kg; centre of mass x, y, z = 0.1, 0, 0.45 m; inertia about x, y, z = 310, 620, 590 kg m²",
        "foot 4 mounts, each of stiffness 2.154335 MN/m along its axis, 1.184884 MN/m across, loss factor 0.12",
        "moment harmonics on genset about x; order 2 amplitude 400 N m; at 1500 rpm; amplitude the same at every speed",
        "unbalance on genset at (-0.5 m, 0 m, 0.5 m) about x; unbalance 20 g m; at 1500 rpm",
        "foot.1 0.85 0.4 0 5.069 kN",
        "Sum under genset 18.14 kN.",
        "6 17.6 Hz 6 % rocking about y (95 %)",
        "flange displacement of flange along y, over start-up, due to engine at most 2 mm pk 2 mm pk 171.1 rpm 0 %",
        "Gravity 9.80665 m/s². Coordinates: 6 degrees of freedom declared, 6 needed: every mode is excited and",
        "No tolerances: every number is taken as it is given.",
        "Designed Name Date Signature Checked Name Date Signature",
    ):
        assert words in said, words


def test_bought_parts_are_said_as_one_would_order_them() -> None:
    design = answered("mounts/genset_front_and_rear")
    said = text(design)
    front = design.places["mounts.front.part"].value
    price = design.variables["mounts.front.part.price"].value.value
    assert (
        f"front 2 x {front} ({show(price, 'EUR', 'price', digits=8)} each, {show(2 * price, 'EUR', 'price', digits=8)})"
        in said
    )
    assert "All limits met for every machine within the tolerances" in said
    for group in ("front", "rear"):
        row = next(one for one in MOUNTS if one.split(";")[1] == design.places[f"mounts.{group}.part"].value)
        assert f"mounts.{group}.stiffness ±{dict(zip(HEADS, row.split(';'), strict=True))['tolerance [%]']} %" in said
    assert "Natural frequencies, without tolerances" in said


@pytest.mark.parametrize("status", [one for one in EXIT_CODES if one not in HELD])
def test_a_failed_design_never_looks_signable(status: str) -> None:
    said = text(replace(answered("mounts/generator_set"), status=status))
    assert "NOT MET" in said
    assert "NOT FOR SIGNATURE: the limits are not met." in said
    assert "Signature" not in said
    assert "All limits met" not in said


def test_a_broken_limit_forbids_the_signature_whatever_the_status() -> None:
    design = answered("mounts/generator_set")
    broken = replace(design.limits["sag"], margin=-0.5)
    verdict = verdict_of(replace(design, status="optimal", limits={**design.limits, "sag": broken}))
    assert not verdict.signable
    assert (verdict.head, verdict.lines) == ("NOT MET", ('The machine breaks "sag".',))


def test_an_analysis_that_breaks_a_limit_says_which(solved: Solved) -> None:
    said = text(solved("rao_9_34_printed_design"))
    assert 'NOT MET The machine breaks "start_up".' in said
    assert "What was tried" in said
    assert "-113 % NOT MET" in said


def test_a_conflict_stands_on_top(solved: Solved) -> None:
    step = ("start_up", Entry(0.02, "length", "mm"), Entry(0.024, "length", "mm"))
    conflict = Conflict(("floor_force", "start_up"), (step,), "proven")
    design = replace(solved("rao_9_34"), status="infeasible", x=(), variables={}, limits={}, conflict=conflict)
    assert verdict_of(design).lines == (
        "No design meets all limits (proven).",
        '"floor_force" and "start_up" cannot hold together.',
        "Smallest loosening of one that helps: start_up 20 mm -> 24 mm.",
    )
    said = text(design)
    assert "Natural frequencies" not in said
    assert "Limit Bound" not in said


def test_a_rounding_that_breaks_a_limit_is_told_as_such() -> None:
    design = answered("mounts/generator_set")
    limits = {**design.limits, "flange": replace(design.limits["flange"], margin=-0.1)}
    design = replace(design, status="violated", limits=limits, claim="no rounding keeps it", details={"rounded": {}})
    assert verdict_of(design).lines == ('The machine breaks "flange".', "No rounding keeps it.")


def test_products_of_inertia_are_signed_as_in_the_file() -> None:
    assert "inertia about x, y, z = 9, 19, 17 kg m², products zx = 2.2 kg m²" in text(
        answered("mounts/focalised_engine")
    )


def test_proven_prices_are_told_in_the_words_of_a_buyer() -> None:
    design = replace(answered("mounts/genset_front_and_rear"), status="optimal")
    assert verdict_of(design).lines[0].endswith("EUR; no cheaper choice exists (proven).")
    assert (
        verdict_of(replace(design, status="feasible")).lines[0].endswith("that no cheaper choice exists is not proven.")
    )


def test_a_worst_machine_that_was_only_searched_for_is_not_called_every_machine() -> None:
    design = answered("isolation/press_on_rubber")
    assert design.tolerances is not None
    searched = replace(design, status="feasible", tolerances=replace(design.tolerances, open=("start_up",)))
    assert verdict_of(design).head == "All limits met for every machine within the tolerances"
    assert verdict_of(searched).head == "All limits met on the worst machines found within the tolerances"
    assert 'Not proven over the tolerances: "start_up"; the worst machine was searched for.' in text(searched)


def test_without_limits_nothing_is_judged() -> None:
    assert text(answered("absorbers/frame_three_storeys")).count("No limit was set Nothing is judged") == 1


def many_limits(count: int) -> Design:
    design = answered("mounts/generator_set")
    one = design.limits["sag"]
    limits = {f"limit_{i}": replace(one, name=f"limit_{i}", margin=0.01 * i + 0.1) for i in range(count)}
    limits["limit_3"] = replace(limits["limit_3"], margin=0.0)
    limits["limit_17"] = replace(limits["limit_17"], margin=-0.2)
    return replace(design, limits=limits)


def test_limits_with_most_margin_are_left_out_first_never_a_broken_or_an_active_one() -> None:
    kept, left = limit_rows(many_limits(20))
    assert [one.name for one in kept] == [f"limit_{i}" for i in (*range(11), 17)]
    assert left == 8
    assert "And 8 more in the report, all met, with more margin than these." in text(many_limits(20))
    design = many_limits(20)
    broken = {key: replace(one, margin=-1.0) for key, one in design.limits.items()}
    assert limit_rows(replace(design, limits=broken))[1] == 0


def test_a_long_list_of_notes_is_cut_and_says_so() -> None:
    design = replace(answered("mounts/generator_set"), notes=tuple(f"Note {i} {'word ' * 60}" for i in range(30)))
    notes = assumptions_of(design)
    assert len(notes) == 9
    assert notes[-1] == "And 27 more notes in the report."
    assert max(map(len, notes)) <= 200


CRATE = """
[bases.crate]
[bodies.camera]
mass = "6 kg"
[links.foam]
between = ["camera", "crate"]
stiffness = "20 kN/m"
damping_ratio = {ratio}
[excitations.fall]
kind = "drop"
on = "crate"
height = "0.5 m"
[measures.peak]
response = "peak_acceleration"
of = "camera"
"""
STEADY = """
[excitations.shaker]
kind = "base_motion"
on = "crate"
displacement = "1 mm"
speed = "5 Hz"
[measures.shaken]
response = "displacement"
of = "camera"
"""


@pytest.mark.parametrize(
    ("more", "small"), [("", "motions are small."), (STEADY, "motions are small and steady.")], ids=["drop", "both"]
)
def test_of_what_comes_once_the_sheet_says_what_it_starts_from(more: str, small: str) -> None:
    said = assumptions_of(solve(from_text(CRATE.replace("{ratio}", "0.1") + more)))
    assert said[:2] == [
        f"Bodies are rigid, springs and dampers are linear, {small}",
        "In time: the machine is at rest before the load, and all of the load comes as given.",
    ]
    assert not any(one.startswith("In time") for one in assumptions_of(answered("mounts/generator_set")))


@pytest.mark.parametrize(("ratio", "said"), [("0.0", "none"), ("0.1", "10 %")])
def test_a_machine_without_damping_has_none_on_the_sheet(ratio: str, said: str) -> None:
    assert f"9.189 Hz {said} camera moves" in text(solve(from_text(CRATE.replace("{ratio}", ratio))))


def test_dry_friction_is_not_called_no_damping() -> None:
    assert "5.033 Hz not told machine moves" in text(answered("friction/rao_9_41"))


def test_texts_of_the_file_cannot_reach_into_the_page(solved: Solved) -> None:
    design = solved("rao_9_34")
    title = '<script>alert("1")</script> & $x^2$ {{ 7 * 7 }}'
    page = html(replace(design, job=replace(design.scene, title=title)), on=DAY, changes=["<b>"], digests={"<i>": "0"})
    assert "<script" not in page
    assert "<b>" not in page.replace("<b>All", "").replace("<b>Des", "").replace("<b>Che", "")
    assert title in Page(page).text


def test_names_that_a_figure_cannot_draw_do_not_stop_the_sheet() -> None:
    given_ = document()
    given_["mounts"] = {"脚$x^2$": given_["mounts"]["foot"]}
    figure = plan_figure(built(given_), "kN")
    assert figure is not None
    assert r"?\$x^2\$.1" in figure.axes[0].texts[0].get_text()
    assert "脚$x^2$.1 0.8 0.4 0" in text(solve(from_dict(given_, name="set.toml")))


def test_the_page_needs_nothing_from_outside_and_has_no_scripts(solved: Solved) -> None:
    for design in (solved("rao_9_34"), answered("mounts/inertia_base")):
        page = html(design, on=DAY)
        assert not re.search(r'(src|href)="(?!#)(?!http://www\.w3\.org)|@import|url\((?!#)', page)
        assert "<script" not in page
        assert page.count("<svg") == 1


def test_links_without_places_get_a_schematic_of_what_stands_on_what() -> None:
    figure = machine_figure(answered("absorbers/pump_skid_two_grids"))
    assert figure is not None
    at = {
        one.get_text().split(" ")[0]: one.get_position()[1]
        for one in figure.axes[0].texts
        if "\n" not in one.get_text()
    }
    assert at["ground"] < at["skid"] < at["first"] == at["second"]
    said = text(answered("absorbers/pump_skid_two_grids"))
    assert "Schematic" in said
    assert re.search(r"first on skid: mass [\d.]+ kg, stiffness [\d.]+ MN/m, damping [\d.]+ N s/m", said)


def test_a_structure_says_where_it_comes_from_and_its_modes_have_no_words() -> None:
    said = text(answered("absorbers/footbridge_marching"))
    assert "structure of 2 modes with points" in said
    assert "of machine and structure together" in said


@settings(max_examples=200, deadline=None)
@given(st.floats(1e-3, 1e9))
def test_what_is_shown_is_what_was_verified(value: float) -> None:
    """To 1e-6 of it, and a round number stays short."""
    shown = verified(value, "N/m", "stiffness")
    assert float(shown.removesuffix(" N/m")) == pytest.approx(value, rel=1e-6)
    assert verified(2.5e6, "MN/m", "stiffness") == "2.5 MN/m"


def test_the_sheet_of_find_all_is_refused(solved: Solved) -> None:
    assert str(refused(html, solved("rao_9_35"))) == (
        "rao_9_35.toml: --sheet is for one design, and find_all asks at which speeds the limits hold. Use vibopt "
        "report without --sheet."
    )


def test_a_digest_is_that_of_every_file_that_was_read() -> None:
    from hashlib import sha256

    file = ROOT / "mounts/genset_front_and_rear.toml"
    found = digests_of(file, read(file))
    assert found == {
        one: sha256((file.parent / one).read_bytes()).hexdigest()
        for one in ("genset_front_and_rear.toml", "mounts.csv")
    }


def test_without_a_browser_a_pdf_is_refused_with_a_way_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "")
    assert str(refused(browser, "out/sheet.pdf")) == (
        "out/sheet.pdf cannot be written: a PDF is printed by a browser, and none of chromium, chromium-browser, "
        "google-chrome, chrome is on the PATH. Install Chromium or Chrome, or write out/sheet.html and print it from "
        "any browser: it is made for one page of A4."
    )


def test_a_browser_that_fails_is_told(tmp_path: Path) -> None:
    program = tmp_path / "chromium"
    program.write_text("#!/bin/sh\necho first >&2\necho no display >&2\nexit 1\n")
    program.chmod(0o755)
    assert str(refused(pdf, "<p>", str(program), "sheet.pdf")) == (
        f"sheet.pdf cannot be written: {program} did not print it (no display). Write sheet.html and print it from any "
        "browser."
    )
    with pytest.raises(InputError, match="did not print it \\(No such file or directory\\)"):
        pdf("<p>", str(tmp_path / "none"), "sheet.pdf")


@pytest.fixture
def program() -> str:
    """A browser, or the test is skipped."""
    try:
        return browser("sheet.pdf")
    except InputError as error:
        pytest.skip(f"no page can be printed here: {error}")


def crowded(name: str = "foot") -> Design:
    """Eight mounts, twelve limits, six measures, tolerances and long notes."""
    at = [[f"{0.9 - 0.6 * i} m", f"{y} m", "0 m"] for i in range(4) for y in (0.4, -0.4)]
    given_ = document()
    mount = {**given_["mounts"]["foot"], "at": at, "rating": "0.5..6 kN"}
    excitation = {**given_["excitations"]["engine"], "varies": "constant"}
    limits = {
        f"{name}_limit_{i}": {
            "response": "displacement",
            "of": "genset",
            "direction": "xyz"[i % 3],
            "over": f"{300 + i}..1500 rpm",
            "at_most": "9 mm",
        }
        for i in range(12)
    }
    measures = {f"{name}_{i}": {"response": "natural_frequency", "mode": i + 1} for i in range(6)}
    given_ |= {"mounts": {name: mount}, "excitations": {name: excitation}, "limits": limits, "measures": measures}
    return solve(from_dict({**given_, "title": f"Set on {name} " * 4}, name=f"{name}.toml"))


@pytest.mark.parametrize("name", ["foot", "a_mount_with_a_name_of_sixty_letters_that_nobody_should_choose"])
def test_eight_mounts_and_twelve_limits_are_one_page(program: str, name: str) -> None:
    design = crowded(name)
    assert verdict_of(design).signable
    assert pages_of(pdf(html(design), program, "sheet.pdf")) == 1


@pytest.mark.parametrize(
    "path",
    [
        "isolation/press_on_rubber",
        *(f"mounts/{one}" for one in SPACE[:1]),
        *(pytest.param(f"mounts/{one}", marks=pytest.mark.slow) for one in SPACE[1:]),
    ],
)
def test_a_problem_is_one_page_as_html_and_as_pdf(program: str, path: str) -> None:
    content = printed(answered(path), program, "sheet.pdf")
    assert content.startswith(b"%PDF")
    assert pages_of(content) == 1
    assert pages_of(pdf(html(answered(path)), program, "sheet.pdf")) == 1


def test_pages_are_counted(program: str) -> None:
    two = "<p>one</p><p style='break-before: page'>two</p>"
    assert pages_of(pdf(two, program, "two.pdf")) == 2


@pytest.mark.parametrize(
    "largest", [one if n % 3 == 0 else pytest.param(one, marks=pytest.mark.slow) for n, one in enumerate(SIZES)]
)
def test_a_pdf_has_the_largest_letters_with_which_it_is_one_page(
    monkeypatch: pytest.MonkeyPatch, largest: float
) -> None:
    import vibopt.report.sheet.sheet_page as page

    def size(content: bytes) -> float:
        return float(re.findall(rb"html \{ font-size: ([\d.]+)pt", content)[0])

    monkeypatch.setattr(page, "pdf", lambda text, program, target: text.encode())
    monkeypatch.setattr(page, "pages_of", lambda content: 1 if size(content) <= largest else 2)
    assert size(printed(answered("mounts/generator_set"), "browser", "sheet.pdf")) == largest
    monkeypatch.setattr(page, "pages_of", lambda content: 2)
    assert size(printed(answered("mounts/generator_set"), "browser", "sheet.pdf")) == SIZES[-1]


@pytest.mark.parametrize("heavy", ["", 'density = "7850 kg/m3"'])
def test_a_body_at_a_beam_weighs_what_the_file_says_and_a_heavy_beam_is_not_called_light(heavy: str) -> None:
    design = solve(
        from_text(
            """
            [bodies.disc]
            mass = "28 kg"
            [links.shaft]
            between = ["disc", "ground"]
            damping_ratio = 0.02
            beam = { kind = "simply_supported", length = "500 mm", diameter = "30 mm", modulus = "206 GPa" }
            [excitations.rest]
            kind = "unbalance"
            on = "disc"
            unbalance = "3000 g mm"
            speed = "1800..2200 rpm"
            [limits.whirl]
            response = "displacement"
            of = "disc"
            at_most = "1 mm"
        """.replace('"206 GPa"', f'"206 GPa", {heavy}' if heavy else '"206 GPa"')
        )
    )
    page = text(design)
    mass = 7850.0 * np.pi / 4.0 * 0.03**2 * 0.5
    said = f", and {show(5.0 / 8.0 * mass, 'kg', 'mass')} of beams that move with it" if heavy else ""
    assert f"28 kg{said}; moves along one line" in page
    assert ("weigh nothing themselves" in page) == (not heavy)
    damping = 2.0 * np.sqrt(28.0 / (28.0 + 17.0 / 35.0 * mass)) if heavy else 2.0
    assert f"{damping:.3g} %" in page
