"""Scenes whose answer is known from elsewhere: closed forms and equations solved in forty digits.

No reference comes from a method that is charted; `tests/study/test_chart.py` works them out again with mpmath.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from vibopt.scene.scene import Scene

FEASIBLE, INFEASIBLE = "feasible", "infeasible"


@dataclass(frozen=True)
class Case:
    """One scene with its true answer.

    family
        What makes it hard, for the chart of stability; "" in the chart of speed.
    text
        The problem file.
    truth
        "feasible" or "infeasible".
    goal
        Best value of the goal [SI]; nan where there is none.
    known_by
        How the answer is known, in words.
    """

    name: str
    text: str
    truth: str
    goal: float
    known_by: str
    family: str = ""

    def scene(self) -> Scene:
        """The scene as read from its text."""
        from vibopt.scene.read import from_text

        return from_text(self.text, name=self.name)


def one_mass(
    *,
    mass: str,
    stiffness: str,
    damping: str,
    force: str,
    limits: str,
    goal: str = 'maximise = "stiffness"\nof = "mount"',
    title: str = "One mass on one mount",
) -> str:
    """Problem file of one mass on one mount; values in TOML, `limits` as tables."""
    return f"""title = "{title}"

[bodies.machine]
mass = {mass}

[links.mount]
between = ["machine", "ground"]
stiffness = {stiffness}
{damping}

[excitations.shaft]
on = "machine"
{force}

{limits}

[goal]
{goal}
"""


def press(varies: str = "constant", *, start_up: str = "20 mm", floor: str = "10 kN", damping: str = "") -> str:
    """The printing press of the problem file rao_9_34, its force constant or growing with the speed."""
    return one_mass(
        mass='"300 kg"',
        stiffness='{ from = "10 kN/m", to = "1 GN/m" }',
        damping=damping or 'damping = { from = "10 N s/m", to = "1 MN s/m" }',
        force=f'kind = "force"\namplitude = "30 kN"\nspeed = "3000 rpm"\nvaries = "{varies}"',
        limits=f"""[limits.floor]
response = "transmitted_force"
into = "ground"
at_most = "{floor}"

[limits.start_up]
response = "displacement"
of = "machine"
over = "0..3000 rpm"
at_most = "{start_up}"
""",
        title="Printing press on its mount",
    )


def chain(count: int, *, floor: str = "100 N", start_up: str = "5 mm", free: int = 2) -> str:
    """A machine on a stack of `count` - 1 blocks, the lowest on a mount that is to be chosen.

    free
        1: stiffness of the lowest mount.  2: its damping too.  3: the stiffness of the highest mount too.
    """
    names = ["machine", *[f"block{i}" for i in range(1, count)]]
    bodies = "\n".join(f'[bodies.{name}]\nmass = "{100 if name == "machine" else 60} kg"\n' for name in names)
    links = []
    for i, (upper, lower) in enumerate(pairwise(names)):
        stiffness = '{ from = "100 kN/m", to = "100 MN/m" }' if i == 0 and free > 2 else f'"{10 * count} MN/m"'
        links.append(
            f'[links.pad{i}]\nbetween = ["{upper}", "{lower}"]\nstiffness = {stiffness}\ndamping = "2 kN s/m"\n'
        )
    damping = '{ from = "10 N s/m", to = "1 MN s/m" }' if free > 1 else '"1 kN s/m"'
    links.append(
        f'[links.mount]\nbetween = ["{names[-1]}", "ground"]\n'
        f'stiffness = {{ from = "1 kN/m", to = "1 GN/m" }}\ndamping = {damping}\n'
    )
    return f"""title = "Machine on a stack of {count - 1} blocks"

{bodies}
{chr(10).join(links)}
[excitations.shaft]
kind = "force"
on = "machine"
amplitude = "1 kN"
speed = "1500 rpm"
varies = "constant"

[limits.floor]
response = "transmitted_force"
into = "ground"
at_most = "{floor}"

[limits.start_up]
response = "displacement"
of = "machine"
over = "0..1500 rpm"
at_most = "{start_up}"

[goal]
maximise = "stiffness"
of = "mount"
"""


def fan() -> str:
    """An undamped fan on a mount: 80 % isolation at 1500 rpm, as stiff as possible."""
    return one_mass(
        mass='"90 kg"',
        stiffness='{ from = "1 kN/m", to = "100 MN/m" }',
        damping="",
        force='kind = "force"\namplitude = "1 kN"\nspeed = "1500 rpm"',
        limits='[limits.isolated]\nresponse = "isolation"\ninto = "ground"\nat_least = "80 %"',
        title="Undamped fan",
    )


def block() -> str:
    """A machine on an inertia block: three unknowns, least sag."""
    return """title = "Machine on an inertia block"

[bodies.machine]
mass = "100 kg"

[bodies.block]
mass = "400 kg"

[links.upper]
between = ["machine", "block"]
stiffness = { from = "10 kN/m", to = "10 MN/m" }
damping = { from = "10 N s/m", to = "100 kN s/m" }

[links.lower]
between = ["block", "ground"]
stiffness = { from = "10 kN/m", to = "10 MN/m" }
damping = "500 N s/m"

[excitations.shaft]
kind = "force"
on = "machine"
amplitude = "1 kN"
speed = "3000 rpm"
varies = "constant"

[limits.floor]
response = "transmitted_force"
into = "ground"
at_most = "200 N"

[limits.start_up]
response = "displacement"
of = "machine"
over = "0..3000 rpm"
at_most = "10 mm"

[goal]
minimise = "static_deflection"
of = "machine"
"""


_CLOSED = "closed form"
_DIGITS = "equations of the optimum in 40 digits"

STOCK = (
    Case("fan, k", fan(), FEASIBLE, 370110.16504085094821, _CLOSED),
    Case("press, k and c", press(), FEASIBLE, 6956917.160715138961, _DIGITS),
    Case("press with unbalance, k and c", press("speed^2"), FEASIBLE, 7376914.526398903795, _CLOSED),
    Case("2 bodies, k and c", chain(2, floor="400 N", start_up="10 mm"), FEASIBLE, 1102942.8400772246188, _DIGITS),
    Case("5 bodies, k and c", chain(5, floor="300 N", start_up="4 mm"), FEASIBLE, 1727991.4374941021286, _DIGITS),
    Case("20 bodies, k and c", chain(20, floor="300 N", start_up="2 mm"), FEASIBLE, 4883895.2956251579043, _DIGITS),
    Case("2 bodies, 3 unknowns", block(), FEASIBLE, 7.1713367824444330534e-4, _DIGITS),
)

QUICK = STOCK[:5]

WARM = STOCK[:2]
"""Run once, untimed, so that every method is loaded."""
