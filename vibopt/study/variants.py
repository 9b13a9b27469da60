"""Variants A, B, C in one table: what each chooses, what it costs, and how much room each limit has."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from vibopt.design.design import Design
from vibopt.errors import InputError
from vibopt.scene.scene import Scene
from vibopt.solve import solve
from vibopt.solve.method import Progress
from vibopt.study.variant_rows import Cell, Row, rows_of


@dataclass(frozen=True, slots=True)
class Variants:
    """Several answers beside each other, by the names of the variants."""

    names: tuple[str, ...]
    designs: tuple[Design, ...]
    rows: tuple[Row, ...]

    @property
    def exit_code(self) -> int:
        """0 where any variant keeps its limits, else that of the first."""
        codes = [one.exit_code for one in self.designs]
        return 0 if 0 in codes else codes[0]


def compare(scenes: Mapping[str, Scene], progress: Progress | None = None) -> Variants:
    """Answer each scene and set the answers beside each other.

    Parameters
    ----------
    scenes
        By the name of the variant; a scene with choices is solved, one without is measured.
    progress
        Called with a stage and the part that is done.

    Raises
    ------
    InputError
        Fewer than two variants, or one that asks for speeds.

    Notes
    -----
    Every goal of any variant is measured on all variants that have its places, so saved designs, which have nothing
    left to choose, are compared by it too.
    """
    if len(scenes) < 2:
        raise InputError("compare needs at least two variants. Name two problem files or saved designs.")
    for name, scene in scenes.items():
        if scene.find_all is not None:
            raise InputError(f"{name}: find_all answers with speeds, which compare does not set beside each other.")
    designs = []
    for index, scene in enumerate(scenes.values()):
        if progress is not None:
            progress("variants", index / len(scenes))
        designs.append(solve(scene))
    return Variants(tuple(scenes), tuple(designs), tuple(rows_of(designs)))


__all__ = ["Cell", "Row", "Variants", "compare"]
