"""Records of a problem file, `[[expected]]`: what may stand in one, and what is wrong with it as it stands."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from vibopt.errors import way_out

KEYS = ("what", "path", "value", "rel_tol", "rel_tol_why", "printed", "verdict", "why")
VERDICTS = ("right", "rounded", "wrong", "misprint", "incomplete")
REL_TOL = 1e-6
"""Without a `rel_tol`; a coarser one says why."""


def complaint_of(record: Mapping[str, Any]) -> str:
    """What is wrong with the record itself; "" where nothing is."""
    for key in record:
        if key not in KEYS:
            return f'unknown key "{key}" in the record.{way_out(key, KEYS)}'
    for key in ("what", "path", "value"):
        if key not in record:
            return f"the record has no {key}."
    tolerance = record.get("rel_tol", REL_TOL)
    if isinstance(tolerance, bool) or not isinstance(tolerance, (int, float)) or not 0.0 < tolerance < 1.0:
        return f"rel_tol = {tolerance} is no number between 0 and 1."
    if (tolerance > REL_TOL) != bool(record.get("rel_tol_why")):
        return f"rel_tol = {tolerance:g}: a rel_tol_why says why it is more than {REL_TOL:g}, and stands nowhere else."
    verdict = record.get("verdict")
    if verdict is not None and verdict not in VERDICTS:
        return f'verdict = "{verdict}" is none of {", ".join(VERDICTS)}.'
    if verdict is not None and "printed" not in record:
        return "there is a verdict, but nothing printed that it judges."
    if verdict not in (None, "right") and not record.get("why"):
        return f'verdict = "{verdict}" needs a why.'
    return ""
