"""The sheet as HTML: facts in words, a figure, and the template that puts them on one A4 page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from datetime import date
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vibopt.answer.answer_page import filled, inline, shown_digests, version
from vibopt.answer.blocks import Block
from vibopt.errors import InputError
from vibopt.mechanics.machine import Machine
from vibopt.mechanics.rigid import SpaceMachine
from vibopt.report import isolators
from vibopt.report.figures import saved
from vibopt.report.figures.paper import short
from vibopt.report.figures.rotor_drawing import rotor_figure
from vibopt.report.machine_parts import sketch_of
from vibopt.report.mode_shapes import shapes_of
from vibopt.report.mount_spots import spots_of, sums_of
from vibopt.report.rotor_parts import rotors_of
from vibopt.report.sheet.fit import SIZES, density_of
from vibopt.report.sheet.judgement import assumptions_of, limit_rows, measure_rows, proof_of, verdict_of
from vibopt.report.sheet.machine_tables import body_rows, excitation_rows
from vibopt.report.sheet.mount_plan import plan_figure
from vibopt.report.sheet.printing import pages_of, pdf
from vibopt.report.sketch import sketch_figure
from vibopt.report.what_to_build import build_rows, machine_in
from vibopt.scene.places import turning
from vibopt.scene.scene import Design, Scene
from vibopt.units import best_unit, plain, show

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TEMPLATE = Path(__file__).with_name("sheet.html.j2")
MOST_MODES, MOST_MOUNTS, MOST_ROWS = 8, 12, 10
LONG, NAME = 120, 22
"""Letters of a title and of the name of a mount; the rest is cut."""


def html(
    design: Design,
    *,
    digests: Mapping[str, str] | None = None,
    changes: Sequence[str] = (),
    on: date | None = None,
    density: int | None = None,
    paper: str = "A4",
) -> str:
    """The page.

    Parameters
    ----------
    design
        Any answer but that of `find_all`; one that is not met is printed without a place to sign.
    digests
        SHA-256 of the problem file and of the files it reads, by their names.
    changes
        What was set on the command line beside the file.
    on
        Date of the page; today if None.
    density
        How closely the page is set, a number of `fit.SIZES`; None estimates it from how much there is to say.
    paper
        "A4" or "letter": what it is printed on.

    Raises
    ------
    InputError
        The file asks at which speeds its limits hold: there is no one design to sign.
    """
    asks_for_one_design(design.scene)
    said = _said(design, digests, changes, on) | {"paper": paper}
    return filled(TEMPLATE, **said, size=SIZES[density if density is not None else density_of(said)])


def _said(design: Design, digests: Mapping[str, str] | None, changes: Sequence[str], on: date | None) -> dict[str, Any]:
    return _words(design) | {
        "digests": shown_digests(digests),
        "changes": list(changes),
        "date": (on or date.today()).isoformat(),
    }


def asks_for_one_design(scene: Scene) -> None:
    """InputError where a file asks at which speeds its limits hold: there is no one design to sign."""
    if scene.find_all is not None:
        raise InputError(
            f"{scene.name}: --sheet is for one design, and find_all asks at which {scene.finds} the limits hold. Use "
            "vibopt report without --sheet."
        )


def printed(
    design: Design,
    program: str,
    target: str,
    *,
    digests: Mapping[str, str] | None = None,
    changes: Sequence[str] = (),
    paper: str = "A4",
) -> bytes:
    """The page as PDF, in the largest letters with which it is one page.

    Parameters
    ----------
    design, digests, changes, paper
        As of `html`.
    program
        A browser, from `browser`.
    target
        The file that was asked for, for messages.

    Raises
    ------
    InputError
        The browser did not print.
    """
    found: dict[int, bytes] = {}

    def fits(density: int) -> bool:
        page = html(design, digests=digests, changes=changes, density=density, paper=paper)
        found[density] = pdf(page, program, target)
        return pages_of(found[density]) <= 1

    density = density_of(_said(design, digests, changes, None) | {"paper": paper})
    if fits(density):
        while density > 0 and fits(density - 1):
            density -= 1
        return found[density]
    while density < len(SIZES) - 1 and not fits(density + 1):
        density += 1
    return found[min(density + 1, len(SIZES) - 1)]


def _words(design: Design) -> dict[str, Any]:
    """Everything the template says, as text."""
    verdict, near, design = verdict_of(design), design.nearest, design.tried
    scene, machine = design.scene, machine_in(design)
    limits, more_limits = limit_rows(design) if machine is not None else ([], 0)
    shapes = _mode_rows(scene, machine) if machine is not None else []
    mounts, sums = _mount_rows(design, machine)
    return {
        "title": scene.title if len(scene.title) <= LONG else f"{scene.title[: LONG - 4]} ...",
        "file": scene.name,
        "verdict": verdict,
        "nearest": near is not None,
        "alone": [f"{name} {least.value.shown} ({least.known})" for name, least in near.least.items()] if near else [],
        "bodies": _cut(body_rows(scene, machine)),
        "build": _cut(build_rows(design, machine)) if machine is not None else [],
        "excitations": _cut(excitation_rows(scene)),
        "figure": _figure(design, machine, _load_unit(design, machine)),
        "two_figures": isinstance(machine, SpaceMachine) and len({spot.carried for spot in spots_of(machine)}) > 1,
        "mounts": mounts[:MOST_MOUNTS],
        "more_mounts": len(mounts[MOST_MOUNTS:]),
        "sums": sums,
        "scatter": design.tolerances is not None,
        "isolators": _isolators(design, machine) if machine is not None else None,
        "modes": shapes[:MOST_MODES],
        "more_modes": len(shapes[MOST_MODES:]),
        "limits": limits,
        "more_limits": more_limits,
        "measures": measure_rows(design, 6) if machine is not None else [],
        "assumptions": assumptions_of(design),
        "proof": proof_of(design),
        "version": version(),
    }


def _cut(rows: list[tuple[str, str]]) -> list[tuple[str, str]]:
    """No more rows than the page has room for; how many are left out is said."""
    if len(rows) <= MOST_ROWS:
        return rows
    return [*rows[: MOST_ROWS - 1], ("...", f"and {len(rows) - MOST_ROWS + 1} more in the report")]


def _mode_rows(scene: Scene, machine: Machine) -> list[dict[str, str]]:
    """Number, frequency, damping ratio and words of each mode."""
    rows, known = [], not machine.on_structures and not machine.rubs
    for i, shape in enumerate(shapes_of(machine, sorted(turning(scene)))):
        words = shape.words or "of machine and structure together"
        undamped = "none" if known and shape.frequency > 0.0 else "not told"
        rows.append(
            {
                "number": str(i + 1),
                "frequency": show(shape.frequency, "Hz", "angular_rate"),
                "damping": show(shape.damping, "%", "ratio", digits=3) if shape.damping is not None else undamped,
                "words": words if shape.frequency > 0.0 else f"{words}: free, nothing holds it",
            }
        )
    return rows


def _isolators(design: Design, machine: Machine) -> Block:
    """As in the answer, with names as short as those of the mounts, and without their modes, which stand beside it."""
    block = isolators.isolator_block(design, machine)
    kept = [k for k, head in enumerate(block.heads) if k and not head.startswith("Strained")]
    rows = tuple((short(row[0], NAME), *(row[k] for k in kept)) for row in block.rows)
    return replace(block, heads=("", *(block.heads[k] for k in kept)), rows=rows)


def _mount_rows(design: Design, machine: Machine | None) -> tuple[list[dict[str, str]], list[str]]:
    """Place and load of each mount, and what the loads under each body come to."""
    if not isinstance(machine, SpaceMachine):
        return [], []
    spots, unit = spots_of(machine), _load_unit(design, machine)
    rows = [
        {
            "name": short(spot.name, NAME),
            "x": plain(spot.at[0]),
            "y": plain(spot.at[1]),
            "z": plain(spot.at[2]),
            "load": show(spot.load, unit, "force") if isfinite(spot.load) else "not held",
            "lifted": "lifted" if spot.load < 0.0 else "",
        }
        for spot in spots
    ]
    return rows, [f"under {name} {show(total, unit, 'force')}" for name, total in sums_of(spots).items()]


def _load_unit(design: Design, machine: Machine | None) -> str:
    """The unit in which the file speaks of static loads, else one for the greatest."""
    for checked in (*design.limits.values(), *design.measures.values()):
        if checked.response == "static_load":
            return checked.value.shown.partition(" ")[2]
    if not isinstance(machine, SpaceMachine):
        return "N"
    loads = [abs(spot.load) for spot in spots_of(machine) if isfinite(spot.load)]
    return best_unit(max(loads, default=1.0), "force")


SKETCH = 4.2
"""Inches across a schematic: it is printed half as wide as the page."""


def _figure(design: Design, machine: Machine | None, unit: str) -> Any:
    """Inline SVG of the plan view, or of the schematic; "" where there is nothing to draw."""
    from markupsafe import Markup

    drawn: Figure | None = None
    title = "Plan view"
    if isinstance(machine, SpaceMachine):
        drawn = plan_figure(machine, unit, tuple(design.scene.points))
    if design.scene.rotors:
        drawn, title = rotor_figure(rotors_of(design), ""), "Rotor"
    if drawn is None and machine is not None:
        drawn, title = sketch_figure(sketch_of(design), SKETCH, looked_at=False), "Schematic"
    return "" if drawn is None else Markup(inline(saved(drawn, "svg").decode(), "sheet", title))
