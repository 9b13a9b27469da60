"""The problem file and answers as JSON schema, put together from the tables that read them, with words for each key."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from vibopt.errors import InputError, way_out
from vibopt.manual.keys import said_of, tables_in, told

DIALECT = "https://json-schema.org/draft/2020-12/schema"
BOUNDS = ("at_most", "at_least", "outside")
_TEXT = {"type": "string"}


_SCENARIOS = {
    "type": "object",
    "description": "Named sets of changes: values by path.",
    "additionalProperties": {"type": "object", "minProperties": 1},
}


def schema_of(kind: str) -> dict[str, Any]:
    """JSON schema (draft 2020-12): "scene", "rotor", "known", "engine", or "answer".

    Raises
    ------
    InputError
        There is none of that name.
    """
    if kind in ("scene", "answer"):
        return problem_schema() if kind == "scene" else schema_of_answers()
    if kind not in SCHEMAS:
        raise InputError(f'there is no schema "{kind}".{way_out(kind, ["scene", *SCHEMAS, "answer"])}')
    parts: dict[str, Any] = {}
    made = SCHEMAS[kind](lambda table: _table(table, parts), _named)
    made["properties"]["expected"] = {"type": "array", "items": _record()}
    made["properties"]["scenarios"] = _SCENARIOS
    return {"$schema": DIALECT, "title": f"vibopt balancing job ({kind})", **made, "$defs": parts}


def schema_of_answers() -> dict[str, Any]:
    """JSON schema of the answers to every kind of job."""
    from vibopt.answer.answer_schema import answer_schema
    from vibopt.balancing.plan_views import KEYS as BALANCING
    from vibopt.report.machine_views import KEYS as MACHINES

    return answer_schema({**MACHINES, **BALANCING})


def problem_schema() -> dict[str, Any]:
    """JSON schema (draft 2020-12) of a whole problem file."""
    from vibopt.devices import FAMILIES
    from vibopt.excitations import KINDS as EXCITATIONS
    from vibopt.responses import GOALS
    from vibopt.responses import KINDS as RESPONSES
    from vibopt.scene.check_devices import CARRIED

    parts: dict[str, Any] = {}
    families = {name: _named(_table(kind, parts)) for name, kind in FAMILIES.items()}
    excitations = [_fixed(_table(kind, parts), "kind", name) for name, kind in EXCITATIONS.items()]
    responses = {name: _table(kind, parts) for name, kind in RESPONSES.items()}
    goals = {name: responses.get(name) or _table(kind, parts) for name, kind in GOALS.items()}
    return {
        "$schema": DIALECT,
        "title": "vibopt problem file",
        "type": "object",
        "properties": {
            "title": _TEXT,
            "statement": _TEXT,
            "source": _TEXT,
            **families,
            "excitations": _named({"oneOf": excitations}),
            "limits": _named(
                {"oneOf": [_limit(responses[name], name, RESPONSES[name].other_bound) for name in responses]}
            ),
            "measures": _named({"oneOf": [_measure(response, name) for name, response in responses.items()]}),
            "goal": {"oneOf": [_find_all(), *_goals(goals)]},
            "scenarios": _SCENARIOS,
            "expected": {"type": "array", "items": _record()},
        },
        "anyOf": [{"required": [family]} for family in CARRIED],
        "additionalProperties": False,
        "$defs": parts,
    }


def _table(kind: Any, parts: dict[str, Any]) -> dict[str, Any]:
    """Schema of one kind of table; its own definitions move into `parts`."""
    made: dict[str, Any] = kind.model_json_schema()
    inner = {name: _tidy(one) for name, one in made.pop("$defs", {}).items()}
    tidy: dict[str, Any] = _with_words(_tidy(made), kind)
    for one in tables_in(kind):
        inner[one.__name__] = _with_words(inner[one.__name__], one) if one.__name__ in inner else {}
    parts.update({name: one for name, one in inner.items() if one})
    return tidy


def _with_words(made: dict[str, Any], kind: type) -> dict[str, Any]:
    """A schema whose tables and keys say what they are."""
    words = said_of(kind)
    for name, one in made.get("properties", {}).items():
        if name in words:
            made["properties"][name] = {**one, "description": words[name]}
    return {**made, "description": told(kind)} if told(kind) else {k: v for k, v in made.items() if k != "description"}


def _tidy(node: Any) -> Any:
    """Without what TOML cannot say (null) and the titles made up from key names."""
    if isinstance(node, list):
        return [_tidy(one) for one in node]
    if not isinstance(node, Mapping):
        return node
    kept = {key: one for key, one in node.items() if not (key == "title" and isinstance(one, str))}
    if kept.get("default", 0) is None:
        kept.pop("default")
    options = [one for one in kept.get("anyOf", []) if one != {"type": "null"}]
    if len(options) == 1:
        kept.pop("anyOf")
        kept = _tidy({**options[0], **kept})
    elif options:
        kept["anyOf"] = options
    return {key: _tidy(one) for key, one in kept.items()}


def _named(one: dict[str, Any]) -> dict[str, Any]:
    """A family: tables by the name that the user gives them."""
    return {"type": "object", "additionalProperties": one}


def _fixed(one: dict[str, Any], key: str, word: str) -> dict[str, Any]:
    """The schema where `key` can only be `word`."""
    return {**one, "properties": {**one["properties"], key: {"const": word}}}


def _without(one: dict[str, Any], keys: tuple[str, ...]) -> dict[str, Any]:
    properties = {key: value for key, value in one["properties"].items() if key not in keys}
    return {**one, "properties": properties, "required": [key for key in one.get("required", []) if key not in keys]}


def _limit(one: dict[str, Any], name: str, elsewhere: str) -> dict[str, Any]:
    """The schema of a limit, whose bound may stand `elsewhere` than in BOUNDS, at the mount itself."""
    fixed, bounds = _fixed(one, "response", name), [{"required": [key]} for key in BOUNDS if key in one["properties"]]
    return fixed if elsewhere and len(bounds) < len(BOUNDS) else {**fixed, "anyOf": bounds}


def _measure(one: dict[str, Any], name: str) -> dict[str, Any]:
    return _without(_fixed(one, "response", name), BOUNDS)


def _goals(responses: Mapping[str, dict[str, Any]]) -> list[dict[str, Any]]:
    from vibopt.scene.scene import MAXIMISE, MINIMISE

    return [_goal(response, name, sense) for sense in (MAXIMISE, MINIMISE) for name, response in responses.items()]


def _goal(one: dict[str, Any], name: str, sense: str) -> dict[str, Any]:
    bare = _without(one, (*BOUNDS, "response"))
    return {
        **bare,
        "properties": {sense: {"const": name}, **bare["properties"]},
        "required": [sense, *bare["required"]],
    }


def _find_all() -> dict[str, Any]:
    asked = {"type": "string", "description": 'all good speeds, "fan.speed", or all good values of the one variable'}
    return _closed({"find_all": asked}, ["find_all"])


def _record() -> dict[str, Any]:
    from vibopt.document.expected import KEYS, VERDICTS

    words: dict[str, Any] = dict.fromkeys(KEYS, _TEXT)
    words["value"] = {"type": ["string", "number", "array"]}
    words["rel_tol"] = {"type": "number", "exclusiveMinimum": 0, "exclusiveMaximum": 1}
    words["verdict"] = {"enum": list(VERDICTS)}
    return _closed(words, ["what", "path", "value"])


Made = Callable[[Any], dict[str, Any]]
Named = Callable[[dict[str, Any]], dict[str, Any]]
_FILE = {"type": "string", "description": "a file beside this one that solve --save-coefficients wrote"}
_WORDS = {"title": _TEXT, "statement": _TEXT, "source": _TEXT}


def _rotor_file(made: Made, named: Named) -> dict[str, Any]:
    from vibopt.balancing import rotor_tables as tables
    from vibopt.balancing.conventions import CHOICES

    words: dict[str, Any] = {key: {"enum": list(known), "description": text} for key, (known, text) in CHOICES.items()}
    words["zero"] = {"type": "string", "description": "where angle zero is, in words"}
    limits = {"anyOf": [_fixed(made(tables.ResidualLimit), "response", "residual"),
                        _fixed(made(tables.CorrectionLimit), "response", "correction")]}  # fmt: skip
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


def _known_file(made: Made, named: Named) -> dict[str, Any]:
    from vibopt.balancing.known import known_job as tables

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


def _engine_file(made: Made, named: Named) -> dict[str, Any]:
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


SCHEMAS: Mapping[str, Callable[[Made, Named], dict[str, Any]]] = {
    "rotor": _rotor_file,
    "known": _known_file,
    "engine": _engine_file,
}
