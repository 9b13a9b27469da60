"""Free vibration: what is only measured, of bodies that move alike, on machines that it is worked out for."""

from __future__ import annotations

from vibopt.document.mistakes import Mistakes, Path, dotted
from vibopt.responses import Response
from vibopt.responses.free_displacement import FreeDisplacement
from vibopt.scene import places
from vibopt.scene.check_random import check_lossy
from vibopt.scene.scene import Scene
from vibopt.scene.space import is_spatial
from vibopt.scene.uncertain import uncertain


def check_free(scene: Scene, path: Path, response: Response, mistakes: Mistakes) -> bool:
    """Add what is wrong with a response that has a sign; whether the rest is worth checking."""
    where, key = dotted(path), response.response
    if path[0] != "measures":
        way = f"Move it to [measures.{path[1]}]" if len(path) > 1 else "Ask for it in [measures.NAME]"
        mistakes.add(path, f"{where} asks for the {key}, which has a sign and is only measured. {way}.")
        return False
    if is_spatial(scene) or scene.structures:
        mistakes.add(path, f"{where}: {key} is not supported for machines in space or on structures yet. Remove it.")
        return False
    doubts = uncertain(scene)
    if doubts:
        mistakes.add(
            path,
            f"{where}: {key} is worked out for one machine, but {doubts[0].path} has a tolerance. Remove the one or "
            "the other.",
        )
        return False
    if isinstance(response, FreeDisplacement):
        check_lossy(scene, path, "free vibration", mistakes)
    named = [name for name, _ in response.places().values() if name in places.moving(scene)]
    turns = [name for name in named if name in places.turning(scene)]
    slides = [name for name in named if name not in turns]
    if turns and slides:
        mistakes.add(
            path,
            f"{where} looks at {turns[0]}, which turns, and at {slides[0]}, which moves along a line. Name one kind.",
        )
        return False
    return True
