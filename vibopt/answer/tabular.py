"""Answers and studies as rows: for a notebook, for pandas, for whatever reads tables."""

from __future__ import annotations

from math import isfinite
from typing import Any

from vibopt.errors import VibOptError
from vibopt.units import plain

_RAW = ("value", "unit", "limit", "before", "after")
"""Columns in SI that a notebook does not show: beside them stands the text in the user's unit."""
_SHOWN = " shown"
_DIGITS, _ROUNDING = 4, 1e-9
_WIDTH, _WIDEST = 100, 1000
"""Columns that the lines above the rows take as text, and at most the rows, of which none is broken."""
_LEFT = ' style="text-align:left"'


def installed(package: str, method: str, instead: str) -> Any:
    """A package that a method needs; VibOptError where it is not installed, with what to do instead."""
    from importlib import import_module

    try:
        return import_module(package)
    except ImportError:
        words = f"{method} needs {package}, which is not installed. Install it, pip install {package}, {instead}"
        raise VibOptError(words) from None


class Tabular:
    """What has rows; those who are one say them in `table` and their first lines in `heading`."""

    __slots__ = ()

    def table(self) -> list[dict[str, Any]]:
        """Rows with the same keys in the same order; numbers in SI, amplitudes peak, None where there is nothing."""
        raise NotImplementedError

    def heading(self) -> tuple[str, ...]:
        """What stands above the rows in a notebook."""
        return ()

    def as_said(self) -> dict[str, Any]:
        """What `to_json` says in plain data."""
        return {"heading": self.heading(), "rows": self.table()}

    def to_json(self) -> dict[str, Any]:
        """As plain data, with which `json.dumps` has no trouble: what a command prints under `--json`.

        Values are in SI (amplitudes peak), `shown` in the user's units.
        """
        from vibopt.answer.jsonable import plain

        return dict(plain(self.as_said()))

    def __str__(self) -> str:
        """The first lines, and the rows below them."""
        from vibopt.answer.console import Console, Grid

        above, below = Console(_WIDTH), Console(_WIDEST)
        for line in filter(None, self.heading()):
            above.print(line)
        heads, rows = self._cells()
        below.print(Grid(rows, heads))
        return above.text + below.text

    def to_pandas(self) -> Any:
        """The rows as a `pandas.DataFrame`.

        Raises
        ------
        VibOptError
            pandas is not installed.
        """
        pandas = installed("pandas", "to_pandas", "or take .table(): the same rows as a list.")
        return pandas.DataFrame(self.table())

    def _repr_html_(self) -> str:
        """For a notebook, by its own convention."""
        from html import escape

        heads, rows = self._cells()
        head = "".join(f"<th{_LEFT}>{escape(one)}</th>" for one in heads)
        cells = ((f"<td{_LEFT}>{escape(one)}</td>" for one in row) for row in rows)
        body = "".join(f"<tr>{''.join(row)}</tr>" for row in cells)
        lines = [f"<p>{escape(one)}</p>" for one in self.heading() if one]
        return "\n".join([*lines, f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"])

    def _cells(self) -> tuple[list[str], list[list[str]]]:
        """Heads and rows as shown, without the columns in SI beside which a text stands."""
        rows = self.table()
        every = list(rows[0]) if rows else []
        texts = [one for one in every if one.endswith("shown")]
        raw = {*_RAW, *(text.removesuffix(_SHOWN) for text in texts if text.endswith(_SHOWN))} if texts else set()
        keys = [one for one in every if one not in raw]
        return [_head(key) for key in keys], [[_shown(row[key], key) for key in keys] for row in rows]


def _head(key: str) -> str:
    return key.removesuffix(_SHOWN).removesuffix("_shown") if "." not in key else key


def _shown(value: object, key: str) -> str:
    if value is None:
        return ""
    if key.startswith("margin") and isinstance(value, float) and isfinite(value):
        return f"{plain(0.0 if abs(value) < _ROUNDING else 100.0 * value, _DIGITS)} %"
    return plain(value, _DIGITS) if isinstance(value, float) and isfinite(value) else str(value)
