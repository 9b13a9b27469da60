"""A base: a support that moves in a prescribed way."""

from __future__ import annotations

from vibopt.values import Table


class BaseTable(Table):
    """`[bases.NAME]`: nothing to say here; its motion is an excitation."""
