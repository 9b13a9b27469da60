"""Machines as text: tables of a problem file, and what many tests ask about: one mass on one mount.

Values stand as in a file, texts without their quotes.  What begins as a table or a list of a file is one.
"""

from __future__ import annotations

import json
from collections.abc import Mapping


def table(name: str, /, **words: object) -> str:
    """A table of a file; words that are None are left out."""
    return "\n".join([f"[{name}]", *(f"{key} = {_said(one)}" for key, one in words.items() if one is not None), ""])


def _said(value: object) -> str:
    if isinstance(value, list):
        return f"[{', '.join(map(_said, value))}]"
    return value if isinstance(value, str) and value[:1] in ("{", "[") else json.dumps(value)


def choice(low: str, high: str, more: str = "") -> str:
    """A range to choose from, `more` behind its ends."""
    return f'{{ from = "{low}", to = "{high}"{more} }}'


def one_mass(
    body: str, mass: str, mount: Mapping[str, object], shaken: Mapping[str, object], *more: str, link: str = "mount"
) -> str:
    """A body on a mount on the ground; `shaken` by a force, if nothing else is said, of the body's name or its own."""
    force = {"name": body, "kind": "force", "on": body, **shaken}
    return "".join([
        table(f"bodies.{body}", mass=mass), table(f"links.{link}", between=[body, "ground"], **mount),
        *([table(f"excitations.{force.pop('name')}", **force)] if shaken else ()), *more,
    ])  # fmt: skip


SKID = """
[bodies]
motor.mass = "{motor!r} kg"
skid.mass = "420 kg"

[links.pads]
between = ["motor", "skid"]
stiffness = "{pads!r} MN/m"
damping = "900 N s/m"

[links.mount]
between = ["skid", "ground"]
stiffness = {{ from = "10 kN/m", to = "100 MN/m" }}
{damper}

[excitations.motor]
kind = "unbalance"
on = "motor"
unbalance = "2 kg mm"
speed = "600..1500 rpm"

[limits]
floor = {{ response = "transmitted_force", into = "ground", at_most = "150 N" }}
motor_move = {{ response = "displacement", of = "motor", at_most = "0.05 mm" }}

[goal]
{goal}
"""


def skid(
    motor: float, pads: float, goal: str, damper: str = 'damping = { from = "10 N s/m", to = "200 kN s/m" }'
) -> str:
    """A motor [kg] on pads [MN/m] on a skid, whose mount is to be chosen."""
    return SKID.format(motor=motor, pads=pads, goal=goal, damper=damper)


def press(
    stiffness: str,
    damping: str | None,
    *more: str,
    mass: str = "300 kg",
    name: str = "punch",
    varies: str = "constant",
) -> str:
    """A press at 3000 rpm; if nothing else is said, its force is the same at all speeds."""
    shaken = {"name": name, "amplitude": "30 kN", "speed": "3000 rpm", "varies": varies}
    return one_mass("press", mass, {"stiffness": stiffness, "damping": damping}, shaken, *more)


def shaken_fan(mount: Mapping[str, object], *more: str, mass: str = "100 kg", **shaken: str) -> str:
    """A fan; if nothing else is said, 100 N shake it at 3000 rpm."""
    push = {} if "kind" in shaken else {"amplitude": "100 N", "speed": "3000 rpm"}
    return one_mass("fan", mass, mount, {**push, **shaken}, *more)


def permitted(*limits: str, **mount: str) -> str:
    """A fan whose permitted speeds are asked for."""
    asked = moves("fan", "0.1 mm"), best(find_all="fan.speed")
    turning = {"kind": "unbalance", "unbalance": "10 kg mm", "speed": choice("0 rpm", "6000 rpm")}
    return shaken_fan({"stiffness": "600 kN/m", **mount}, *limits, *asked, mass="120 kg", **turning)


def swayed(body: str, speed: str, *more: str, title: str, **mount: object) -> str:
    """A machine of 100 kg on 1 MN/m under 100 N, of which its absorbers are in question."""
    shaken = {"name": "push", "amplitude": "100 N", "speed": speed}
    text = one_mass(body, "100 kg", {"stiffness": "1 MN/m", **mount}, shaken, *more)
    return f'title = "{title}"\n{text}'


def absorber(name: str, on: str, mass: str | None, **words: object) -> str:
    """A small mass on a body."""
    return table(f"absorbers.{name}", on=on, mass=mass, **words)


def hanging(sigma: float, width: float, bound: float, wanted: float, name: str = "tank") -> str:
    """A mass of a normal distribution [%] on a spring of a uniform one [%]; its sag has a bound [m] for a share [%]."""
    mass, spring = f'{{ normal = "{sigma!r} %" }}', f'{{ uniform = "{width!r} %" }}'
    mount = {"stiffness": f'{{ value = "200 kN/m", tolerance = {spring} }}'}
    asked = sags("spring", f"{bound!r} m", with_probability=f"{wanted!r} %")
    return one_mass(name, f'{{ value = "300 kg", tolerance = {mass} }}', mount, {}, asked, link="spring")


def floor(most: str, name: str = "floor", **words: object) -> str:
    """A limit of the force into the ground."""
    return table(f"limits.{name}", response="transmitted_force", into="ground", at_most=most, **words)


def moves(of: str, most: str, name: str = "move", over: str | None = None, **words: object) -> str:
    """A limit of the displacement of a body."""
    return table(f"limits.{name}", response="displacement", of=of, over=over, at_most=most, **words)


def sags(of: str, most: str, **words: object) -> str:
    """A limit of what the weight does to a link or a body."""
    return table("limits.sag", response="static_deflection", of=of, at_most=most, **words)


def best(**words: object) -> str:
    """A goal."""
    return table("goal", **words)


def shaft(*more: str) -> str:
    """A shaft between bearings A and B that turns at 1500 rpm."""
    return table("shaft", bearings='{ A = "0 mm", B = "900 mm" }', speed="1500 rpm") + "".join(more)


def plane(name: str, at: str) -> str:
    """A correction plane for up to 500 g."""
    return table(f"planes.{name}", at=at, radius="50 mm", weight=choice("0 g", "500 g"))


def reaction(bearing: str, most: str, **words: object) -> str:
    """A limit of what a bearing takes."""
    return table(f"limits.{bearing}", response="bearing_reaction", of=bearing, at_most=most, **words)


STIFFEST = best(maximise="stiffness", of="mount")
ANY_STIFFNESS, ANY_DAMPING = choice("10 kN/m", "1 GN/m"), choice("10 N s/m", "1 MN s/m")
DAMPING_RATIO = "{ from = 0.01, to = 0.5 }"
LEFT = table("masses.left", mass="1 kg", radius="50 mm", angle="90 deg", at="200 mm")
MIDDLE = table("masses.middle", unbalance="30 kg mm", angle="210 deg", at="450 mm")
"""Known masses on a shaft."""
