"""What a machine adds to the views of its answer."""

from __future__ import annotations

from typing import Any

from vibopt.answer import answer_schema as shape
from vibopt.answer.blocks import (
    FOOT,
    LEAD,
    TEXT,
    Block,
    limits_block,
    measures_block,
    nearest_block,
    pairs,
    prices_block,
    table,
)  # fmt: skip
from vibopt.answer.entry import Value
from vibopt.report import isolators
from vibopt.report.absorber_parts import BUILD, parts_of
from vibopt.report.catalogue_choices import choice_rows, choices_of, dropped_rows, free_words, tied
from vibopt.report.limiting_views import limiting, limiting_block
from vibopt.report.machine_words import (
    ENDS,
    conflict_words,
    interval,
    model_words,
    quiet_notes,
    ranges_of,
    tolerance_rows,
    worst_rows,
)  # fmt: skip
from vibopt.report.machine_words import next_step as next_step
from vibopt.report.machine_words import notes_of as readings_of
from vibopt.report.machine_words import verdict as verdict
from vibopt.report.what_to_build import build_rows, machine_in
from vibopt.report.whirl_views import asks_whirls, campbell_drawn, whirls_block, whirls_json
from vibopt.scene.scene import Design

_CHOSEN = shape.table(
    {
        "value": {"anyOf": [shape.NUMBER, shape.TEXT]},
        **dict.fromkeys(("unit", "shown"), shape.TEXT),
        "at_bound": {"enum": ["from", "to", ""]},
    },
    {"one_of": shape.TEXTS},
)
_USED = shape.table({"declared_dof": {"type": "integer"}, "used_dof": {"type": "integer"}, "why": shape.TEXT})
_INTERVALS = {"type": "array", "items": {"type": "array", "items": shape.ref("number")}}
STANDS = "As it stands"
KEYS = {
    "scene": (
        {"variables": shape.named(_CHOSEN), "set": shape.maybe(_INTERVALS), "model": shape.maybe(_USED)},
        {
            **dict.fromkeys(("build", "tolerances"), shape.OPEN),
            **{key: {"type": "array"} for key in ("choices", "limiting_performance", "whirls")},
        },
    )
}
"""By kind of job: what its answers have in JSON beside what all have, always and sometimes."""


def sense_of(design: Design) -> str:
    """ "minimise" or "maximise"; "" without a goal."""
    return design.scene.goal.sense if design.scene.goal is not None else ""


def notes_of(design: Design) -> list[str]:
    """How the file was read, and what must be known to use the answer."""
    return list(dict.fromkeys((*readings_of(design.scene), *design.notes)))


def own_json(design: Design) -> dict[str, Any]:
    """Variables and places, parts to build, the set of good speeds, the model, tolerances, choices."""
    return {
        "variables": {
            **{
                path: {
                    "value": word.value,
                    "unit": "",
                    "shown": word.value,
                    "at_bound": "",
                    "one_of": list(word.options),
                }
                for path, word in design.places.items()
            },
            **{
                path: {**chosen.value.to_json(), "at_bound": chosen.at_bound}
                for path, chosen in design.variables.items()
            },
        },
        **({} if not design.scene.absorbers else {"build": {part.name: part for part in parts_of(design)}}),
        "set": None if design.found is None else design.found,
        "model": design.model,
        **({} if design.tolerances is None else {"tolerances": design.tolerances}),
        **({"choices": choices_of(design)} if "picks" in design.details else {}),
        **({"limiting_performance": beside} if (beside := limiting(design)) else {}),
        **(whirls_json(design, machine_in(design)) if asks_whirls(design.scene) else {}),
    }


def blocks(design: Design) -> list[Block]:
    """What a machine's answer says, in the order in which it is needed."""
    lead = [Block("", LEAD, tuple(conflict_words(design))), _intervals(design), _at_ends(design)]
    if design.status == "unbounded":  # its values are as far as a search went, and mean nothing
        return [*lead, *_foot(design)]
    title = "Limits" if design.found is None else f"Limits over the whole range of {design.scene.find_all}"
    places = [(one["place"], one["status"], one["goal"]) for one in design.details.get("places", ())]
    lead += nearest_blocks(design)
    machine = machine_in(design)
    built = [] if machine is None else build_rows(design, machine, whole=False)
    return [
        *lead,
        pairs(BUILD if design.variables or design.places else STANDS, built, whole=(0,)),
        *isolators.blocks_of(design, machine),
        limits_block(design, title, states=design.found is None),
        Block("What the tolerances cost", heads=("", "without", "with"), rows=tuple(tolerance_rows(design))),
        pairs("Worst machine within the tolerances", worst_rows(design)),
        prices_block(design),
        *_shelf(design),
        measures_block(design),
        whirls_block(design, machine),
        limiting_block(design),
        pairs("Layouts" if any(path.endswith(".between") for path in design.places) else "Places", places),
        pairs("What was chosen", _values(design)),
        *_foot(design),
    ]


def nearest_blocks(design: Design) -> list[Block]:
    """The design that misses its limits least, and how far each is missed."""
    tried = design.tried
    machine = machine_in(tried) if design.nearest is not None else None
    if machine is None:
        return []
    off = "" if design.tolerances is None else " (alone: without tolerances)"
    return [
        pairs("The nearest design", build_rows(tried, machine, whole=False), whole=(0,)),
        nearest_block(design, off),
    ]


def _intervals(design: Design) -> Block:
    """What `find_all` found; of values with what ends each interval."""
    title, ends = f"All limits hold for {design.scene.find_all}", design.details.get("ends", ())
    if not ends:
        return pairs(title, [(interval(*one),) for one in design.found or ()])
    limits = {name: f"limits.{name}" for name in design.scene.limits}
    held = [[limits.get(one.ended_by, one.ended_by or "end of the range") for one in two] for two in ends]
    rows = [(interval(*one), *two) for one, two in zip(design.found or (), held, strict=True)]
    return table(title, ("", "below it", "above it"), rows)


def _at_ends(design: Design) -> Block:
    """What is measured at the ends of the intervals of a value."""
    ends = list({one.value.value: one for two in design.details.get("ends", ()) for one in two}.values())
    names = list(ends[0].rows) if ends else []
    return table(
        "Measured at the ends",
        ("", *(end.value.shown for end in ends)),
        [(name, *(end.rows[name].value for end in ends)) for name in names],
    )


def _values(design: Design) -> list[tuple[str | Value, ...]]:
    """Places, parts and variables with what they were chosen from."""
    ranges = ranges_of(design.scene)
    brought = {
        path: f"as {design.places[part].value} has it"
        for path, part in tied(design.scene).items()
        if part in design.places
    }
    placed: list[tuple[str | Value, ...]] = [
        (path, place.value, f"chosen from {place.among or ', '.join(place.options)}")
        for path, place in design.places.items()
    ]
    return placed + [
        (
            path,
            variable.value,
            ENDS.get(variable.at_bound, "") or brought.get(path, f"chosen from {ranges.get(path, '')}"),
        )
        for path, variable in design.variables.items()
        if ".part." not in path
    ]


def _shelf(design: Design) -> list[Block]:
    """The best choices from a catalogue, what was dropped, and what free values would do."""
    choices, free = choice_rows(design), free_words(design)
    costs = "" if not any(choice[2] for choice in choices) else "Price"
    heads = ("Order", "Goal", costs, "Tightest limit")
    best = [Block(f"The best {len(choices)} choices", heads=heads, rows=tuple(choices))] if len(choices) > 1 else []
    order = Block("Stiffness and damping made to order", TEXT, (free,) if free else ())
    return [*best, pairs("What was dropped", dropped_rows(design)), order]


def _foot(design: Design) -> list[Block]:
    """What the answer stands on: model, method, notes."""
    reduced = design.model is not None and design.model.declared_dof != design.model.used_dof
    seconds = sum(design.timings.values())
    time = f"{seconds:.1f} s" if seconds >= 1.0 else f"{1e3 * seconds:.0f} ms"
    return [
        Block("Model", FOOT, (model_words(design),) if reduced else ()),
        Block("Method", FOOT, (f"{design.method}, {time}",) if design.method else ()),
        Block("Notes", FOOT, tuple(quiet_notes(design, notes_of(design)))),
    ]


def figures(design: Design, *, compact: bool = False) -> list[tuple[str, str]]:
    """Title and SVG of the machine, of every panel and map; only the first where values mean nothing."""
    from vibopt.report.curves import panels
    from vibopt.report.design_plane import absorbers_with_map, plane
    from vibopt.report.figures import below, plane_figure, response_figure, saved
    from vibopt.report.space_views import machine_figure
    from vibopt.report.spectrum_views import spectrum_panels

    machine = machine_figure(design, "The machine")
    drawn = [("The machine", machine)] if machine is not None else []
    if design.status == "unbounded":
        return [(title, saved(figure, "svg").decode()) for title, figure in drawn]
    drawn += [(panel.title, response_figure([panel])) for panel in (*panels(design), *spectrum_panels(design))]
    drawn += [(one.title, response_figure([], "", [one])) for one in below(design)]
    drawn += campbell_drawn(design)
    for mapped in filter(None, (plane(design, name) for name in absorbers_with_map(design) or ("",))):
        drawn.append((mapped.title, plane_figure(mapped)))
    return [(title, saved(figure, "svg").decode()) for title, figure in drawn]


def signs(design: Design) -> tuple[str, ...]:
    """Who signs the page."""
    return ("Designed by, date", "Checked by, date")
