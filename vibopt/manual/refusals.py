"""Sentences that refuse what only shows when the tables of a file are seen together, read off the checks themselves."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

from vibopt.manual.keys import text_of

AREAS = {"vibopt.scene": "Machines", "vibopt.balancing": "Balancing jobs"}
_SAYS = {"add": 1, "value": 2}
"""Methods that note a mistake, and which of their words is the sentence."""

_FEWEST = 4
"""Words of a sentence that says something even without what was given."""


def whole_file_refusals() -> str:
    """Lists in Markdown, by what the checks look at; "…" where a sentence says what was given."""
    return "\n\n".join(part for area, title in AREAS.items() for part in (f"## {title}", *_said_in(area)))


def _said_in(area: str) -> Iterator[str]:
    """Per file that refuses something, its first sentence as heading and what it says."""
    spec = find_spec(area)
    assert spec is not None
    for folder in spec.submodule_search_locations or ():
        for file in sorted(Path(folder).rglob("*.py")):
            source = file.read_text(encoding="utf-8")
            tree = ast.parse(source) if "mistakes." in source else None
            said = dict.fromkeys(_sentences(tree)) if tree is not None else {}
            if tree is not None and said:
                heading = (ast.get_docstring(tree) or file.stem).splitlines()[0].rstrip(".")
                yield f"### {heading}\n\n" + "\n".join(f"- {one}" for one in said)


def _sentences(tree: ast.AST) -> Iterator[str]:
    """Texts of every `mistakes.add(path, text)` and `mistakes.value(path, given, text)`."""
    for node in ast.walk(tree):
        if not isinstance(node, ast.Call) or not isinstance(node.func, ast.Attribute):
            continue
        place = _SAYS.get(node.func.attr)
        if place is not None and "mistakes" in ast.unparse(node.func.value) and len(node.args) > place:
            said = text_of(node.args[place])
            if len(re.findall(r"[a-z]{2,}", said)) > _FEWEST:
                yield f"… {said}" if node.func.attr == "value" else said
