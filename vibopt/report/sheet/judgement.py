"""What the sheet says of the answer: verdict, limits, assumptions, proof, and whether anybody may sign it."""

from __future__ import annotations

from collections.abc import Iterator

from vibopt.answer.answer import odds_said
from vibopt.answer.blocks import SIDES, at_words, spoken
from vibopt.answer.entry import Checked
from vibopt.errors import counted
from vibopt.mechanics.constants import GRAVITY
from vibopt.records import dataclass
from vibopt.report.figures.paper import short
from vibopt.report.limiting_views import limiting
from vibopt.report.machine_words import (
    HELD,
    goal_words,
    listed,
    model_words,
    notes_of,
    off_words,
    status_words,
)
from vibopt.report.sheet.mount_plan import said
from vibopt.scene.scene import MINIMISE, Design
from vibopt.scene.uncertain import Uncertain, uncertain, uncertain_at
from vibopt.units import plain, show
from vibopt.values.tolerance import DATA, NORMAL, Scatter, span

MOST_LIMITS = 12
NAME = 24
"""Letters of the name of a limit; the rest is cut."""
MOST_NOTES = 9
MOST_OFF = 3
LONGEST = 200
"""Letters of a note; the report has the rest."""
_SO = {"infeasible": " (proven)", "unbounded": ", so there is no design"}


@dataclass(frozen=True, slots=True)
class Verdict:
    """The banner: whether it may be signed, a word in large letters, and the lines below it."""

    signable: bool
    head: str
    lines: tuple[str, ...]


def verdict_of(design: Design) -> Verdict:
    """What stands on top.  Only a design of which every limit holds may be signed."""
    if design.status not in HELD or not all(limit.met for limit in design.limits.values()):
        said = status_words(design) + _SO.get(design.status, "")
        lines = [f"{said[:1].upper()}{said[1:]}.", *_conflict(design)]
        if "rounded" in design.details:
            lines.append(f"{design.claim[:1].upper()}{design.claim[1:]}.")
        return Verdict(False, "NOT MET", tuple(lines))
    goal = goal_words(design)
    lines = [f"{goal[:1].upper()}{goal[1:]}; {_best(design)}."] if goal else []
    if not design.limits:
        return Verdict(True, "No limit was set", ("Nothing is judged: the sheet says what was asked.", *lines))
    return Verdict(True, f"All limits met{_within(design)}", tuple(lines))


def _within(design: Design) -> str:
    """For which machines the limits are met; where the worst was only searched for, no more is said."""
    if design.tolerances is None:
        return ""
    odds = odds_said(design)
    if odds and design.tolerances is not None and len(design.tolerances.odds) == len(design.limits):
        return f": {odds}"
    every, found = " for every machine within the tolerances", " on the worst machines found within the tolerances"
    within = every if all(one.startswith("measures.") for one in design.tolerances.open) else found
    return f"{within}, but {odds}" if odds else within


def _best(design: Design) -> str:
    """How good the choice is among all."""
    if design.scene.goal is None:
        return ""
    if "rounded" in design.details and design.status != "optimal":
        return "every limit is measured with them"
    cheaper = design.scene.goal.name == "price" and design.scene.goal.sense == MINIMISE
    if design.status == "optimal":
        return f"{'no cheaper choice' if cheaper else 'no better choice'} exists (proven)"
    return f"that no {'cheaper' if cheaper else 'better'} choice exists is not proven"


def _conflict(design: Design) -> list[str]:
    """Why there is no design, and what would help."""
    lines = [design.reason] if design.reason else []
    if design.conflict is not None:
        names = listed([f'"{name}"' for name in design.conflict.limits])
        lines.append(f"{names} cannot hold{' together' if len(design.conflict.limits) > 1 else ''}.")
    if design.nearest is not None:
        missed = max((limit for limit in design.nearest.limits.values()), key=lambda checked: -checked.margin)
        lines.append(f"Shown is the nearest design: it misses no limit by more than {missed.margin_shown[1:]}.")
    steps = design.conflict.steps if design.conflict is not None else []
    return lines + ([f"Smallest loosening of one that helps: {', or '.join(steps)}."] if steps else [])


@dataclass(frozen=True, slots=True)
class LimitRow:
    """One limit in words."""

    name: str
    what: str
    allowed: str
    value: str
    at: str
    margin: str
    state: str


def limit_rows(design: Design, most: int = MOST_LIMITS) -> tuple[list[LimitRow], int]:
    """Rows in the order of the file, and how many were left out.

    Those with most margin are left out first; never one that is broken or active.
    """
    rows = design.limits
    kept = set(sorted(rows, key=lambda key: (rows[key].met, not rows[key].active, rows[key].margin))[:most])
    kept |= {key for key, row in rows.items() if not row.met or row.active}
    return [_limit(design, row) for key, row in rows.items() if key in kept], len(rows) - len(kept)


def _limit(design: Design, checked: Checked) -> LimitRow:
    what = ", ".join(filter(None, (spoken(checked.response, checked.place), *_asked(design, checked))))
    return LimitRow(
        short(checked.name, NAME),
        short(what, 4 * NAME),
        f"{SIDES.get(checked.side, '')} {checked.limit.shown if checked.limit is not None else ''}".strip(),
        checked.value.shown,
        "; ".join(filter(None, (at_words(checked.worst_at), _off(checked)))),
        checked.margin_shown,
        {"BROKEN": "NOT MET", "OPEN": "cannot be told", "ACTIVE": "met, at its limit"}.get(checked.state, "met"),
    )


def _asked(design: Design, checked: Checked) -> Iterator[str]:
    """At which speeds a limit looks, which excitations count, and how they add up; in the words of the file."""
    given = design.scene.document.get("limits", {}).get(checked.name, {})
    for key, words in (("over", "over"), ("at", "at"), ("due_to", "due to"), ("combine", "added up as")):
        if key in given:
            yield f"{words} {said(given[key])}"


def _off(checked: Checked) -> str:
    """The worst machine within the tolerances, shortly."""
    first = off_words(dict(list(checked.off.items())[:MOST_OFF]))
    return f"{first}, ..." if len(checked.off) > MOST_OFF else first


def measure_rows(design: Design, most: int) -> list[tuple[str, str, str]]:
    """What was measured beside the limits: name, response, value with its place."""
    rows = list(design.measures.items())[:most]
    return [
        (
            short(name, NAME),
            short(spoken(checked.response, checked.place), 2 * NAME),
            " at ".join(filter(None, (checked.value.shown, at_words(checked.worst_at)))),
        )
        for name, checked in rows
    ]


def assumptions_of(design: Design, most: int = MOST_NOTES) -> list[str]:
    """What the answer takes for granted; the longest list is cut, and says so."""
    scene = design.scene
    notes = [*_motion(design), f"Gravity {plain(GRAVITY, 6)} m/s². Coordinates: {model_words(design)}."]
    doubts = [f"{doubt.path} {_width(doubt.tolerance)}" for doubt in _doubts(design) if doubt.tolerance > 0.0]
    if doubts:
        notes.append(f"Tolerances: {', '.join(doubts)}. Frequencies and loads of single mounts are without them.")
    else:
        notes.append("No tolerances: every number is taken as it is given.")
    notes += dict.fromkeys((*notes_of(scene), *design.notes))
    cut = [note if len(note) <= LONGEST else f"{note[: LONGEST - 4].rstrip()} ..." for note in notes]
    return (
        cut
        if len(cut) <= most
        else [*cut[: most - 1], f"And {counted(len(cut) - most + 1, 'more notes')} in the report."]
    )


def _motion(design: Design) -> Iterator[str]:
    """What is taken for granted of bodies, springs and motions, steady ones and those in time."""
    scene = design.scene
    asked = scene.responses.values()
    in_time = any(response.sort == "transient" for response in asked)
    steady = not in_time or any(response.harmonic or response.sort == "random" for response in asked)
    swept = any(getattr(limit, "over", None) is not None for limit in scene.limits.values())
    run_up = ": running up through a resonance quickly gives less" if swept else ""
    how = f" and steady{run_up}" if steady else ""
    yield f"Bodies are rigid, springs and dampers are linear, motions are small{how}."
    beams = [link.beam for link in scene.links.values() if link.beam is not None]
    if beams:
        some = "those without density or mass " * any(beam.heavy for beam in beams)
        light = "" if all(beam.heavy for beam in beams) else f", and {some}weigh nothing themselves"
        yield f"Beams and shafts are bent as under a static load{light}."
    if in_time:
        let_go = any(
            excitation.once is not None and any(excitation.once.start) for excitation in scene.excitations.values()
        )
        rest = "what is not let go" if let_go else "the machine"
        yield f"In time: {rest} is at rest before the load, and all of the load comes as given."


def _width(tolerance: float) -> str:
    """How far a number may be off, and how it scatters: "±5 %", "±4.5 % (normal, 1.5 %)", "-8 % to +1 % (data)"."""
    if isinstance(tolerance, Scatter) and tolerance.kind == DATA:
        ends = [f"{'+' * (end > 1.0)}{show(end - 1.0, '%', 'ratio', digits=3)}" for end in span(tolerance)]
        return f"{' to '.join(ends)} (data)"
    wide = f"±{show(float(tolerance), '%', 'ratio', digits=3)}"
    if not isinstance(tolerance, Scatter):
        return wide
    size = f", {show(tolerance.size, '%', 'ratio', digits=3)}" if tolerance.kind == NORMAL else ""
    return f"{wide} ({tolerance.kind}{size})"


def _doubts(design: Design) -> tuple[Uncertain, ...]:
    """How far numbers may be off; of what is bought as the catalogue says of the part."""
    if len(design.x) != len(design.scene.variables):
        return uncertain(design.scene)
    return uncertain_at(design.scene, design.scene.named(design.x))


def proof_of(design: Design) -> list[str]:
    """How the answer is known, and what was not proven."""
    said = [f"{design.claim[:1].upper()}{design.claim[1:]}."] if design.claim else []
    if design.status not in HELD:
        return said
    said.append("Every limit was measured again on the finished machine, by another road than the one that chose it.")
    said += [f"{one.words[:1].upper()}{one.words[1:]}." for one in limiting(design)]
    if design.tolerances is not None and design.tolerances.open:
        names = listed([f'"{one}"' for one in design.tolerances.open])
        said.append(f"Not proven over the tolerances: {names}; the worst machine was searched for.")
    if design.status == "feasible" and "rounded" not in design.details:
        said.append("Not proven: that no better choice exists.")
    said.append("Not part of any proof: the numbers given, and what is assumed beside.")
    return said
