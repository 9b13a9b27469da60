"""A design as a problem file of its own: every choice is a value, so it can be solved and varied as it stands."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path as FilePath
from typing import Any

from vibopt.design.design import Design
from vibopt.design.words import verdict
from vibopt.errors import InputError
from vibopt.files.marks import with_check
from vibopt.scene.document import FileText
from vibopt.scene.positions import asked_positions
from vibopt.scene.scene import Scene
from vibopt.scene.settle import open_places
from vibopt.scene.write import document_toml
from vibopt.study.freeze import frozen

_NO_DESIGN = ("infeasible", "unbounded", "unproven", "check_failed")


def design_file(design: Design, target: FilePath, *, kept: Scene | None = None, changes: Sequence[str] = ()) -> str:
    """The text of a problem file that says a design, as it must read at `target`.

    Parameters
    ----------
    design
        An answer with a design, or an analysis, which is saved as it stands.
    target
        Where the file will lie; matrix files and catalogues are named as seen from there.
    kept
        The scene with the values to write, where they are not exactly those of the design (rounded values).
    changes
        What was changed before solving, as "path=value"; said in the comments.

    Raises
    ------
    InputError
        There is no design to save.
    """
    scene = design.scene
    if scene.find_all is not None:
        raise InputError(f"{scene.name}: find_all answers with speeds, so there is no design to save.")
    open_one = bool(scene.variables or open_places(scene) or asked_positions(scene))
    if design.status in _NO_DESIGN or (open_one and not design.variables and not design.places):
        raise InputError(f"{scene.name}: there is no design to save: {design.status}. {target.name} is not written.")
    if open_one and design.status == "violated":
        broken = ", ".join(name for name, one in design.limits.items() if not one.met)
        raise InputError(
            f"{scene.name}: the rounded design breaks {broken}. {target.name} is not written; round finer."
        )
    if kept is None:
        kept = frozen(scene, design.x) if scene.variables or design.places or asked_positions(scene) else scene
    document = moved({key: one for key, one in kept.document.items() if key != "expected"}, target)
    return with_check(f"{_comments(design, changes)}\n\n{document_toml(document)}")


def moved(document: Mapping[str, Any], target: FilePath) -> dict[str, Any]:
    """The document with the files it names as seen from the folder of `target`."""
    return {key: _moved(one, target.resolve().parent) for key, one in document.items()}


def _moved(value: Any, folder: FilePath) -> Any:
    if isinstance(value, FileText):
        return _seen_from(folder, value)
    if isinstance(value, Mapping):
        return {key: _moved(one, folder) for key, one in value.items()}
    if isinstance(value, list):
        return [_moved(one, folder) for one in value]
    return value


def _seen_from(folder: FilePath, file: FileText) -> str:
    """The name of a file as seen from another folder; an absolute name stays as it is."""
    if FilePath(file).is_absolute():
        return str(file)
    there = (file.folder / file).resolve()
    try:
        return FilePath(os.path.relpath(there, folder)).as_posix()
    except ValueError:  # another drive
        return there.as_posix()


def _comments(design: Design, changes: Sequence[str]) -> str:
    """From which file and which answer a design comes."""
    scene = design.scene
    words = f"Design of {scene.name}" + (f" with {', '.join(changes)}" if changes else "")
    lines = [f"{words}, saved by vibopt: nothing is left to choose.", f"Answer: {verdict(design)}."]
    lines += [f"Claim: {design.claim}."] if design.claim else []
    chosen = [*design.places, *(path for path in design.variables if ".part." not in path)]
    lines += [f"Chosen: {', '.join(chosen)}."] if chosen else []
    return "\n".join(f"# {' '.join(line.split())}" for line in lines)


__all__ = ["design_file", "moved"]
