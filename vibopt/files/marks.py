"""What tells a file that vibopt wrote, and that nobody has changed since, from every other one."""

from __future__ import annotations

import csv
import io
import re
from hashlib import sha256
from typing import Any

PDF_MARK = b"%vibopt\n"
"""Stands behind the end of a page that a browser printed."""
GENERATOR = '<meta name="generator" content="vibopt">'
FIGURES: dict[str, dict[str, Any]] = {
    "svg": {"Creator": "vibopt", "Date": None},
    "png": {"Software": "vibopt"},
    "pdf": {"Creator": "vibopt", "CreationDate": None},
}
"""What matplotlib writes into a figure of each format."""
_INSIDE = (GENERATOR.encode(), b"<dc:title>vibopt</dc:title>", b"tEXtSoftware\0vibopt", b"/Creator (vibopt)")
_CHECK = r"# vibopt ([0-9a-f]{16}): [^\n]*\n\Z"
_MARKDOWN_CHECK = r"<!-- vibopt ([0-9a-f]{16}): [^\n]* -->\n\Z"
_JSON_CHECK = r',\n "vibopt": "([0-9a-f]{16})"\n}\n\Z'
_ENDS = 20_000
"""Bytes at either end of a file in which a mark stands."""
_CHARTS = {"speed-accuracy", "stability", "fidelity", "profiles", "cost"}
_STATUSES = {
    "optimal", "feasible", "met", "violated", "infeasible", "unbounded", "unproven", "check_failed",
}  # fmt: skip


def with_check(text: str) -> str:
    """A problem file with a last line that tells whether anything above it has been changed."""
    return f"{text}# vibopt {_digest(text)}: vibopt writes over this file as long as nothing above is changed.\n"


def with_markdown_check(text: str) -> str:
    """A page in Markdown with a last line, not shown, that does the same."""
    kept = "vibopt writes over this file as long as nothing above is changed."
    return f"{text}\n<!-- vibopt {_digest(text + chr(10))}: {kept} -->\n"


def with_json_check(text: str) -> str:
    """A JSON object, one entry a line at its first level, with a last entry that does the same."""
    body = text.rstrip().removesuffix("}").rstrip()
    return f'{body},\n "vibopt": "{_digest(body)}"\n}}\n'


def is_ours(content: bytes) -> bool:
    """Whether vibopt wrote this file, a text as it stands; a file without any content is nobody's."""
    if not content:
        return True
    ends = content[:_ENDS] + content[-_ENDS:]
    if content.endswith(PDF_MARK) or any(mark in ends for mark in _INSIDE):
        return True
    try:
        text = content.decode()
    except UnicodeDecodeError:
        return False
    match = next(filter(None, (re.search(one, text) for one in (_CHECK, _MARKDOWN_CHECK, _JSON_CHECK))), None)
    return _digest(text[: match.start()]) == match[1] if match else _is_table(text)


def _digest(text: str) -> str:
    return sha256(text.encode()).hexdigest()[:16]


def _is_table(text: str) -> bool:
    """Whether a text is a table of a sweep, of variants or of a chart: its headings, and only its words below."""
    try:
        head, *rows = csv.reader(io.StringIO(text), strict=True)
    except (csv.Error, ValueError):
        return False
    if any(len(row) != len(head) for row in rows):
        return False
    if head[:3] == ["kind", "row", "unit"]:
        return all(re.fullmatch("[a-z]+", row[0]) for row in rows)
    if head[:2] in (["chart", "case"], ["chart", "ladder"]):
        return all(row[0] in _CHARTS for row in rows)
    return head[1:2] == ["status"] and all(row[1] in _STATUSES for row in rows)
