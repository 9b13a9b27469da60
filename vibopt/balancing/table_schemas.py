"""JSON schemas of balancing files, put together from the tables that read them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

Made = Callable[[Any], dict[str, Any]]
Named = Callable[[dict[str, Any]], dict[str, Any]]
_TEXT = {"type": "string"}
_FILE = {"type": "string", "description": "a file beside this one that solve --save-coefficients wrote"}
_WORDS = {"title": _TEXT, "statement": _TEXT, "source": _TEXT}


def _rotor(made: Made, named: Named) -> dict[str, Any]:
    from vibopt.balancing import rotor_tables as tables
    from vibopt.balancing.conventions import CHOICES

    words: dict[str, Any] = {key: {"enum": list(known), "description": text} for key, (known, text) in CHOICES.items()}
    words["zero"] = {"type": "string", "description": "where angle zero is, in words"}
    limits = {"anyOf": [_only(made(tables.ResidualLimit), "response", "residual"),
                        _only(made(tables.CorrectionLimit), "response", "correction")]}  # fmt: skip
    return _closed(
        {
            **_WORDS,
            "conventions": _closed(words, ["angles", "detector", "zero"]),
            "planes": named(made(tables.PlaneTable)),
            "sensors": named(made(tables.SensorTable)),
            "runs": _list(made(tables.RunTable)),
            "readings": {"type": "string", "description": "a CSV file beside this one, instead of runs"},
            "influence": {"anyOf": [_list(made(tables.InfluenceTable)), _FILE]},
            "speed": {"type": "string", "description": "of all runs, instead of one in each"},
            "scatter": made(tables.ScatterTable),
            "pairs": named(made(tables.PairTable)),
            "limits": named(limits),
            "goal": made(tables.GoalTable),
            "rotor": made(tables.RotorTable),
            "quality": made(tables.QualityTable),
        }
    )


def _known(made: Made, named: Named) -> dict[str, Any]:
    from vibopt.balancing.known import known_tables as tables

    limit = made(tables.KnownLimitTable)
    return _closed(
        {
            **_WORDS,
            "conventions": _closed(
                {
                    "angles": {"type": "string", "description": "in which sense angles are counted, in your words"},
                    "zero": {"type": "string", "description": "where angle zero is, in your words"},
                }
            ),
            "shaft": made(tables.ShaftTable),
            "masses": named(made(tables.MassTable)),
            "planes": named(made(tables.KnownPlaneTable)),
            "limits": named(limit),
            "measures": named(limit),
            "goal": made(tables.KnownGoalTable),
        },
        ["masses"],
    )


def _engine(made: Made, named: Named) -> dict[str, Any]:
    from vibopt.balancing.engine import engine_tables as tables

    limit = made(tables.EngineLimitTable)
    return _closed(
        {
            **_WORDS,
            "engine": made(tables.EngineTable),
            "cylinders": _list(made(tables.CylinderTable)),
            "counterweights": named(made(tables.CounterweightTable)),
            "balance_shafts": named(made(tables.BalanceShaftTable)),
            "limits": named(limit),
            "measures": named(limit),
            "goal": made(tables.EngineGoalTable),
        },
        ["engine", "cylinders"],
    )


def _closed(properties: dict[str, Any], required: list[str] | None = None) -> dict[str, Any]:
    return {"type": "object", "properties": properties, "required": required or [], "additionalProperties": False}


def _list(one: dict[str, Any]) -> dict[str, Any]:
    return {"type": "array", "items": one}


def _only(one: dict[str, Any], key: str, word: str) -> dict[str, Any]:
    return {**one, "properties": {**one["properties"], key: {"const": word}}}


SCHEMAS: Mapping[str, Callable[[Made, Named], dict[str, Any]]] = {
    "rotor": _rotor,
    "known": _known,
    "engine": _engine,
}
