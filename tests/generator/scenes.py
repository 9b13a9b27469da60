"""Small scenes drawn over the whole schema: a machine, what shakes it, and a question; the same for the same seed."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

from asking import Table, beside, candidates, closed, mistakes, question
from draw import Draw, aside
from machines import (
    Drawn,
    about_an_axis,
    on_a_line,
    on_a_structure,
    that_is_geared,
    that_rubs,
    that_spins,
    that_whirls,
    with_absorber,
    with_inerter,
)
from shaking import shaken
from spatial import in_a_plane, in_space
from vibopt.responses import KINDS
from vibopt.scene.read import from_dict
from vibopt.solve import solve

ATTEMPTS = 60
MACHINES: tuple[tuple[Callable[[Draw], Drawn], bool, bool], ...] = (
    (on_a_line, False, False),
    (about_an_axis, False, False),
    (in_space, False, False),
    (on_a_line, True, False),
    (on_a_structure, False, False),
    (in_a_plane, False, False),
    (on_a_line, False, True),
    (about_an_axis, True, False),
    (in_space, False, True),
    (on_a_line, False, False),
    (on_a_structure, True, False),
)
"""What may be built: the machine, whether an absorber sits on it, and whether its parts are bought."""
_BENT = ("bearing_force", *(f"{one}bending_stress" for one in ("", "static_", "combined_", "rms_", "peak_")))
OF_ITS_OWN = {
    "friction_force": that_rubs,
    "gear_torque": that_is_geared,
    "shear_stress": about_an_axis,
    "stability_threshold": that_spins,
    "critical_speed": that_whirls,
    "amplification_factor": that_whirls,
    **dict.fromkeys(_BENT, on_a_line),
}
"""What must be built for a response that few machines have."""
_VARIABLES = (0, 1, 1, 1, 2, 2, 3)


def scene(seed: int, folder: Path, *, small: bool = False) -> Drawn:
    """A scene that asks about response number `seed` of the registry, round and round; its files lie in `folder`.

    A small one has two variables at most, and in space those of a list.
    """
    kind = list(KINDS)[seed % len(KINDS)]
    for attempt in range(ATTEMPTS):
        build, absorber, bought = MACHINES[(seed // len(KINDS) + seed + attempt) % len(MACHINES)]
        if kind in OF_ITS_OWN:
            build, absorber, bought = OF_ITS_OWN[kind], False, False
        spatial = build in (in_space, in_a_plane)
        most = (1 if spatial or absorber or build is about_an_axis else 2) if small else 3
        rolls = Draw(f"{seed}/{attempt}", listed=bought or (small and spatial), bought=bought, small=small)
        rolls.left = min(max(rolls.pick(_VARIABLES), int(bought)), most)
        rolls.sure = small and (bought or build not in (on_a_line, about_an_axis))
        rolls.bent = kind.endswith(("bending_stress", "bearing_force"))
        made = build(rolls)
        made.folder = folder
        made = with_absorber(rolls, made) if absorber else made
        if spatial and (more := aside(made.document)).chance(0.25):
            made = with_absorber(more, made)
        made = with_inerter(rolls, made) if rolls.chance(0.15) and build is not that_spins else made
        made.lay()
        many = 0 if build is that_spins else rolls.pick([1, 1, 2])  # beyond its threshold nothing steady is known
        shaken(rolls, made, sort=KINDS[kind].sort, many=many)
        made.lay()
        first = candidates(rolls, made, kind, 8)
        if first and (asked(rolls, made, first) or rolls.chance(0.1)):
            return made
    raise LookupError(
        f'the generator draws no scene that can ask for the response "{kind}". Let machines.py or spatial.py build '
        "what it needs, or asking.py say its words."
    )


def asked(draw: Draw, made: Drawn, first: list[Table]) -> bool:
    """Adds limits, measures and a goal; whether the file has no mistake (now and then one is put in)."""
    others = [one for _ in range(2) for one in candidates(draw, made, draw.pick(list(KINDS)), 3)[:1]]
    others += first[1:2] if draw.chance(0.5) else []
    asks = [first[0], *others]
    values = sizes(made, asks)
    open_ones = is_open(made.document)
    bounded = [index for index, one in enumerate(asks) if not KINDS[one["response"]].signed]
    goal = draw.pick(bounded) if open_ones and bounded else -1
    made.document["title"] = f"Drawn about {first[0]['response']}"
    for index, (one, value) in enumerate(zip(asks, values, strict=True)):
        signed = KINDS[one["response"]].signed
        if index == goal:
            made.document["goal"] = aim(draw, one)
        elif draw.chance(0.85) and not signed:
            made.put("limits", f"limit{index + 1}", limited(draw, made, one, value))
        else:
            unit = draw.unit(value, KINDS[one["response"]].dimension) if 0.0 < value < math.inf else ""
            made.put(
                "measures", f"measure{index + 1}", {**one, **({"unit": unit} if unit and draw.chance(0.3) else {})}
            )
    if not open_ones and "limits" in made.document and draw.chance(0.4):
        _all_speeds(draw, made)
    sound = not mistakes(made, made.document)
    if draw.chance(0.06):
        made.put("limits", "unlikely", {**question(draw, made, draw.pick(list(KINDS))), "at_most": 1})
    return sound


def is_open(value: Any) -> bool:
    """Whether something is to be chosen."""
    return bool(closed(value) != value)


def sizes(made: Drawn, asks: list[Table]) -> list[float]:
    """What is asked, measured on the machine in the middle of its ranges and without its tolerances [SI]."""
    named = {f"q{index}": one for index, one in enumerate(asks)}
    found = solve(from_dict(beside(made, {**sure(closed(made.document)), "measures": named})))
    return [found.measures[name].value.value for name in named]


def sure(value: Any) -> Any:
    """The same without any tolerance."""
    if isinstance(value, list):
        return [sure(one) for one in value]
    if not isinstance(value, dict):
        return value
    if "value" in value:
        return value["value"]
    printed = {"tolerance": "0 %"} if "part" in value else {}
    return {key: sure(one) for key, one in value.items() if "tolerance" not in key} | printed


def aim(draw: Draw, one: Table) -> Table:
    words = {key: value for key, value in one.items() if key != "response"}
    if one["response"] in _LESS_IS_BETTER or draw.chance(0.5):
        return {"minimise": one["response"], **words}
    return {"maximise": one["response"], **words}


_LESS_IS_BETTER = (
    "displacement",
    "transmitted_force",
    "price",
    "absorber_mass",
    "total_mass",
    "rms_displacement",
    "peak_displacement",
)


def limited(draw: Draw, made: Drawn, one: Table, value: float) -> Table:
    """A response with a bound about its value: now loose, now tight."""
    kind = KINDS[one["response"]]
    if kind.complement:
        return {**one, "at_least": round(value - draw.size(0.05, 0.8), 3)}
    if "outside" in kind.model_fields and draw.chance(0.6):
        low = value * draw.size(0.3, 1.2) / (2.0 * math.pi)
        outside: Any = f"{low:.3g}..{1.2 * low:.3g} Hz"
        steady = [
            name for name, table in made.document.get("excitations", {}).items() if table["kind"] != "white_noise"
        ]
        if steady and draw.chance(0.4):
            outside = {"orders": [1, 2], "of": steady[0], "margin": "10 %"}
        return {**{key: word for key, word in one.items() if key != "mode"}, "outside": outside}
    if _own_bound(made, one) and draw.chance(0.6):
        return one
    typical = abs(value) if 1e-10 < abs(value) < math.inf else 1.0
    most, least = (typical * draw.size(0.7, 2.5), typical * draw.size(0.3, 1.3))
    side = draw.pick(["at_most", "at_most", "at_least", "both"])
    bounds = {"at_most": _bound(draw, kind, max(most, least)), "at_least": _bound(draw, kind, least)}
    return {**one, **{key: bound for key, bound in bounds.items() if side in (key, "both")}}


def _own_bound(made: Drawn, one: Table) -> bool:
    """Whether a mount says itself what a response of it must not exceed."""
    key = {"travel": "gap", "static_load": "rating"}.get(one["response"], "")
    return key in made.document.get("mounts", {}).get(str(one.get("of", "")).partition(".")[0], {})


def _bound(draw: Draw, kind: Any, value: float) -> Any:
    if kind.dimension == "price":
        return f"{value:.4g} EUR"
    if kind.dimension == "count":
        return max(round(value), 1)
    if kind.dimension == "ratio" and draw.chance(0.3):
        return f"{20.0 * math.log10(value):.3g} dB" if draw.chance(0.5) else f"{100.0 * value:.4g} %"
    return draw.said(value, kind.dimension, amplitude=kind.amplitude)


def _all_speeds(draw: Draw, made: Drawn) -> None:
    """Asks for every speed of one excitation at which the limits hold."""
    name = draw.pick(made.names("excitations") or [""])
    table = made.document.get("excitations", {}).get(name, {})
    if table.get("kind") in (None, "white_noise", "road") or "amplitude_at" in table:
        return
    table["speed"] = {"from": "0 rpm", "to": f"{300.0 * made.frequency:.4g} rpm"}
    if table.get("varies") in ("speed", "speed^2"):
        table["amplitude_at"] = f"{60.0 * made.frequency:.4g} rpm"
    made.document["goal"] = {"find_all": f"{name}.speed"}
