"""Limits with a probability: what they need, and where they do not go yet."""

from __future__ import annotations

from collections.abc import Iterable

from vibopt.document.mistakes import Mistakes, Path, dotted
from vibopt.responses import Response
from vibopt.scene.open_places import asked_positions
from vibopt.scene.places import bound_parts
from vibopt.scene.scene import Scene
from vibopt.scene.uncertain import uncertain
from vibopt.values.tolerance import Scatter


def check_probabilities(scene: Scene, responses: Iterable[tuple[Path, Response]], mistakes: Mistakes) -> None:
    """A probability belongs to a limit with one bound, of a machine that is there and whose scatters are all known."""
    for path, response in responses:
        if response.with_probability is None:
            continue
        text = _fault(scene, path, response)
        if text:
            mistakes.add((*path, "with_probability"), f"{dotted(path)} has with_probability, but {text}")


def _fault(scene: Scene, path: Path, response: Response) -> str:
    """What is wrong, and the way out; "" where nothing is."""
    if path[0] != "limits":
        return "only a limit is kept or broken by a machine. Remove with_probability."
    if (response.at_most is None) == (response.at_least is None) or response.outside_bands:
        return "that goes with at_most or at_least, one of the two. Write two limits, or remove with_probability."
    what = _not_drawn(scene)
    if what:
        return (
            f"{what}, which machines that are drawn do not tell. Solve without it, keep the answer with --save "
            "design.toml, and add with_probability there."
        )
    doubts = uncertain(scene)
    if not doubts:
        return 'no number scatters. Add one, for example tolerance = { normal = "2 %" } of a mass.'
    bare = [doubt.path for doubt in doubts if not isinstance(doubt.tolerance, Scatter)]
    if bare:
        return (
            f"of {bare[0]} it is only known how far it may be off. Write its distribution, tolerance = {{ uniform = "
            '"5 %" } or { normal = "2 %" }.'
        )
    return ""


def _not_drawn(scene: Scene) -> str:
    """What is asked that has no answer by machines drawn; "" where nothing is."""
    parts = bound_parts(scene)
    if parts:
        return f"{parts[0].path} is chosen from a catalogue"
    where = list(asked_positions(scene))
    return f"the position {where[0]} is to be chosen" if where else ""
