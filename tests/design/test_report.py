"""The page: complete, self-contained, well-formed."""

import re
from collections.abc import Callable
from dataclasses import replace
from datetime import date
from html.parser import HTMLParser

import pytest

from vibopt.answer.answer_page import given, html, inline
from vibopt.answer.clashes import Conflict
from vibopt.answer.entry import Entry
from vibopt.scene.scene import Design

Solved = Callable[[str], Design]
DAY = date(2026, 1, 31)
VOID = {"meta", "br", "link", "img", "hr", "input"}


class Nesting(HTMLParser):
    """Every tag is closed in order; texts and ids are kept."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.text = ""
        self.ids: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.ids += [str(value) for key, value in attrs if key == "id"]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.ids += [str(value) for key, value in attrs if key == "id"]

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data


def read(page: str) -> Nesting:
    reader = Nesting()
    reader.feed(page)
    assert reader.open == []
    return reader


@pytest.mark.sampled(2)
@pytest.mark.parametrize("name", ["rao_9_34", "rao_9_1", "rao_9_35", "rao_9_65", "rao_9_38", "rao_9_34_printed_design"])
def test_the_page_is_well_formed_and_needs_nothing_from_outside(solved: Solved, name: str) -> None:
    page = html(solved(name), on=DAY)
    reader = read(page)
    assert len(reader.ids) == len(set(reader.ids))
    assert not re.search(r'(src|href)="(?!#)(?!http://www\.w3\.org)', page)
    assert "2026-01-31" in reader.text
    assert solved(name).scene.title in reader.text


def test_all_evidence_is_on_the_page(solved: Solved) -> None:
    text = read(html(solved("rao_9_34"), changes=["limits.start_up.at_most=20 mm"], on=DAY)).text
    for words in (
        "greatest stiffness of mount is 6957 kN/m",
        "6957 kN/m",
        "10 kN/m to 1 GN/m",
        "at most 20 mm pk",
        "1437 rpm",
        "ACTIVE",
        "0.4229 mm",
        "24.24 Hz",
        "66.67 % at 3000 rpm",
        "An amplitude is peak",
        "Changed against the file: limits.start_up.at_most=20 mm",
        "Checked by, date",
    ):
        assert words in " ".join(text.split())


def test_places_orders_and_pieces_stand_one_a_line() -> None:
    at = [["0.85 m", "0.4 m", "0 m"], ["0.85 m", "-0.4 m", "0 m"]]
    harmonics = [{"order": 1, "amplitude": "3 N"}, {"order": 2, "amplitude": "1 N"}]
    document = {
        "mounts": {"foot": {"between": ["set", "ground"], "at": at}},
        "excitations": {"engine": {"harmonics": harmonics}},
    }
    assert given(document) == [
        ("mounts.foot", [("between", "set; ground"), ("at", "0.85 m, 0.4 m, 0 m\n0.85 m, -0.4 m, 0 m")]),
        ("excitations.engine", [("harmonics", "order 1, amplitude 3 N\norder 2, amplitude 1 N")]),
    ]


def test_a_conflict_is_told(solved: Solved) -> None:
    step = ("start_up", Entry(0.02, "length", "mm"), Entry(0.024, "length", "mm"))
    design = replace(
        solved("rao_9_34"), status="infeasible", goal=None, variables={}, x=(), limits={}, measures={},
        conflict=Conflict(("a", "b"), (step,), "proof"), reason="Too light.",
    )  # fmt: skip
    text = " ".join(read(html(design, on=DAY)).text.split())
    assert 'These cannot hold together: "a", "b".' in text
    assert "start_up 20 mm -> 24 mm" in text
    assert "Too light." in text
    assert "Every limit was measured again" not in text


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    "status",
    ["optimal", "feasible", "met", "violated", "infeasible", "unbounded", "unproven", "check_failed"],
)
def test_only_a_machine_that_keeps_its_limits_has_lines_to_sign(solved: Solved, status: str) -> None:
    page = " ".join(read(html(replace(solved("rao_9_34"), status=status), on=DAY)).text.split())
    signed = status in ("optimal", "feasible", "met")
    why = "the limits are not met" if status in ("violated", "infeasible") else "it is no design"
    assert ("Checked by" in page) is signed
    assert (f"Not for signature: {why}." in page) is not signed


def test_what_the_user_wrote_cannot_break_the_page(solved: Solved) -> None:
    design = solved("rao_9_34")
    nasty = replace(design, job=replace(design.scene, title='<script>alert(1)</script> & "co"'))
    page = html(nasty, on=DAY)
    read(page)
    assert "<script" not in page


def test_ids_of_an_inline_figure_are_its_own() -> None:
    svg = '<?xml version="1.0"?>\n<svg width="9pt" height="9pt"><g id="a" clip-path="url(#b)"/><use href="#a"/></svg>'
    assert inline(svg, "f1", 'x "y" <z>') == (
        '<svg role="img" aria-label="x &quot;y&quot; &lt;z>">'
        '<g id="f1-a" clip-path="url(#f1-b)"/><use href="#f1-a"/></svg>'
    )
