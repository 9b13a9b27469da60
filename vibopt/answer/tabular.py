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
        rows = self.table()
        every = list(rows[0]) if rows else []
        texts = [one for one in every if one.endswith("shown")]
        raw = {*_RAW, *(text.removesuffix(_SHOWN) for text in texts if text.endswith(_SHOWN))} if texts else set()
        keys = [one for one in every if one not in raw]
        from html import escape

        head = "".join(f"<th{_LEFT}>{escape(_head(key))}</th>" for key in keys)
        cells = ((f"<td{_LEFT}>{escape(_shown(row[key], key))}</td>" for key in keys) for row in rows)
        body = "".join(f"<tr>{''.join(row)}</tr>" for row in cells)
        lines = [f"<p>{escape(one)}</p>" for one in self.heading() if one]
        return "\n".join([*lines, f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"])


def _head(key: str) -> str:
    return key.removesuffix(_SHOWN).removesuffix("_shown") if "." not in key else key


def _shown(value: object, key: str) -> str:
    if value is None:
        return ""
    if key.startswith("margin") and isinstance(value, float) and isfinite(value):
        return f"{plain(0.0 if abs(value) < _ROUNDING else 100.0 * value, _DIGITS)} %"
    return plain(value, _DIGITS) if isinstance(value, float) and isfinite(value) else str(value)
