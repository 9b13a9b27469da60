"""What if: the old answer beside the new, with a new design or with the one that is bought."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from vibopt.design.design import Design
from vibopt.errors import InputError
from vibopt.scene.positions import is_open
from vibopt.scene.read import with_changes
from vibopt.scene.scene import Scene
from vibopt.solve import solve
from vibopt.solve.method import Progress
from vibopt.study.freeze import frozen
from vibopt.study.rounded import rounded
from vibopt.study.thresholds import Threshold, thresholds


@dataclass(frozen=True)
class WhatIf:
    """Two answers to compare.

    changes
        Values set, by path.
    before, after
        Answers before and after; with `keep_design` both measure the machine of `before`.
    breaks
        Limits that held before and break after (`keep_design` only).
    thresholds
        Where the frozen design fails, fact by fact (`keep_design` only): from the changed facts on when
        they leave every limit met, else from the facts as they were; none where neither meets every limit.
    """

    changes: Mapping[str, Any]
    before: Design
    after: Design
    keep_design: bool
    breaks: tuple[str, ...] = ()
    thresholds: tuple[Threshold, ...] = ()


def whatif(
    scene: Scene,
    changes: Mapping[str, Any],
    *,
    keep_design: bool = False,
    rounding: Sequence[str] = (),
    progress: Progress | None = None,
) -> WhatIf:
    """Answer a scene before and after some changes.

    Parameters
    ----------
    scene
        The scene as it is.
    changes
        Values by path, as in the file: {"limits.start_up.at_most": "8 mm"}.
    keep_design
        The design is bought: measure it under the changed facts instead of choosing anew.
    rounding
        What is bought are rounded values, as in `rounded`; `before` is then the design with them.
    progress
        Called with a stage and the part that is done.

    Raises
    ------
    InputError
        A path or value that does not fit, or no design to keep.
    """
    changed = with_changes(scene, changes)
    if keep_design and (scene.find_all is not None or changed.find_all is not None):
        raise InputError(
            f"{scene.name}: find_all answers with speeds, so there is no design to keep: "
            "use whatif without --keep-design instead."
        )
    if rounding and not keep_design:
        raise InputError("--round goes with --keep-design: what is chosen anew has no rounded values to keep. Add it.")
    before = solve(scene, progress=progress)
    if not keep_design:
        return WhatIf(changes, before, solve(changed, progress=progress), keep_design)
    if is_open(scene) and not (before.variables or before.places):
        raise InputError(f"{scene.name}: there is no design to keep: {before.status}. Solve the scene first.")
    kept = frozen(before.scene, before.x) if is_open(scene) else scene
    if rounding:
        drawn = rounded(before, rounding)
        before, kept = drawn.design, drawn.kept
    after = solve(with_changes(kept, changes))
    held = {name for name, one in before.limits.items() if one.met}
    breaks = tuple(name for name, one in after.limits.items() if not one.met and name in held)
    base = with_changes(kept, changes) if after.status == "met" else kept
    sound = after.status == "met" or len(held) == len(before.limits)
    return WhatIf(changes, before, after, keep_design, breaks, tuple(thresholds(base, progress)) if sound else ())
