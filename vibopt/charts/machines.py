"""Problem files of the charts: one mass, chains, halls, symmetric machines, absorbers on chains of masses."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise


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


def free_chain(count: int, base: str, stiffness: float, damping: float) -> str:
    """Tables of `count` masses of 1 kg one above the other on a base, like springs [N/m] and dampers [N s/m]."""
    dash = f'\ndamping = "{damping!r} N s/m"' if damping else ""
    return "\n\n".join(
        f'[bodies.m{i}]\nmass = "1 kg"\n\n[links.s{i}]\nbetween = ["m{i}", "{f"m{i - 1}" if i else base}"]\n'
        f'stiffness = "{stiffness!r} N/m"{dash}'
        for i in range(count)
    )


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


def shaken(
    on: str, force: str, speed: str, floor: str, start_up: str, goal: str = 'maximise = "stiffness"\nof = "mount"',
    varies: str = "constant",
) -> str:  # fmt: skip
    """A force on a machine, what it may hand on at its speed, and how far the machine may move on its way there."""
    return f"""[excitations.shaft]
kind = "force"
on = "{on}"
amplitude = "{force}"
speed = "{speed}"
varies = "{varies}"

[limits.floor]
response = "transmitted_force"
into = "ground"
at_most = "{floor}"

[limits.start_up]
response = "displacement"
of = "{on}"
over = "0..{speed}"
at_most = "{start_up}"

[goal]
{goal}
"""


def stacked(masses: Sequence[str], links: Sequence[tuple[str, str]], rest: str) -> str:
    """A machine on blocks, the lowest on a mount: masses, and (stiffness, damping) below each, as TOML has them."""
    names = ["machine", *(f"block{i}" for i in range(1, len(masses))), "ground"]
    tables = [f"[bodies.{name}]\nmass = {mass}" for name, mass in zip(names, masses, strict=False)]
    for i, ((upper, lower), (stiffness, damping)) in enumerate(zip(pairwise(names), links, strict=True)):
        link = "mount" if lower == "ground" else f"pad{i}"
        tables.append(f'[links.{link}]\nbetween = ["{upper}", "{lower}"]\nstiffness = {stiffness}\ndamping = {damping}')
    return "\n\n".join([f'title = "Machine on a stack of {len(masses) - 1} blocks"', *tables, rest])


def _mounted(on: str, floor: str) -> str:
    """A machine on a mount that is to be chosen."""
    return f"""[links.mount]
between = ["{on}", "ground"]
stiffness = {{ from = "10 kN/m", to = "1 GN/m" }}
damping = {{ from = "10 N s/m", to = "1 MN s/m" }}

{shaken(on, "30 kN", "3000 rpm", floor, "20 mm")}"""


def chain(count: int, *, floor: str, start_up: str) -> str:
    """A machine on a stack of `count` - 1 blocks, the lowest on a mount that is to be chosen."""
    pads = [(f'"{10 * count} MN/m"', '"2 kN s/m"')] * (count - 1)
    mount = ('{ from = "1 kN/m", to = "1 GN/m" }', '{ from = "10 N s/m", to = "1 MN s/m" }')
    return stacked(
        ['"100 kg"', *['"60 kg"'] * (count - 1)], [*pads, mount],
        shaken("machine", "1 kN", "1500 rpm", floor, start_up),
    )  # fmt: skip


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
    sag = 'minimise = "static_deflection"\nof = "machine"'
    return f"""title = "Machine on an inertia block"

[bodies.machine]
mass = "100 kg"

[bodies.block]
mass = "400 kg"

[links.upper]
between = ["machine", "block"]
stiffness = {{ from = "10 kN/m", to = "10 MN/m" }}
damping = {{ from = "10 N s/m", to = "100 kN s/m" }}

[links.lower]
between = ["block", "ground"]
stiffness = {{ from = "10 kN/m", to = "10 MN/m" }}
damping = "500 N s/m"

{shaken("machine", "1 kN", "3000 rpm", "200 N", "10 mm", sag)}"""


def star(count: int) -> str:
    """A machine on its mount with `count` alike motors hung on it: they move as one."""
    motors = "\n".join(
        f'[bodies.motor{i}]\nmass = "20 kg"\n\n[links.arm{i}]\nbetween = ["motor{i}", "machine"]\n'
        f'stiffness = "8 MN/m"\ndamping = "500 N s/m"\n'
        for i in range(1, count + 1)
    )
    return f"""title = "Machine with {count} alike motors"

[bodies.machine]
mass = "300 kg"

{motors}
{_mounted("machine", "12 kN")}"""


def hall(count: int) -> str:
    """Machines that stand beside each other; one is to be mounted anew."""
    others = "\n".join(
        f'[bodies.other{i}]\nmass = "{100 + 10 * i} kg"\n\n[links.feet{i}]\nbetween = ["other{i}", "ground"]\n'
        f'stiffness = "{1 + i} MN/m"\ndamping = "1 kN s/m"\n'
        for i in range(1, count)
    )
    return f"""title = "Hall of {count} machines"

[bodies.press]
mass = "300 kg"

{others}
{_mounted("press", "10 kN")}"""


def absorbed(
    hosts: Sequence[int],
    ratios: Sequence[float],
    *,
    count: int = 1,
    spring: float = 1e5,
    damping: float = 0.0,
    speeds: tuple[float, float] = (5.0, 100.0),
    least_damping: float = 0.001,
    extra: str = "",
    goal: str = "",
) -> str:
    """Problem file: `count` masses of 100 kg on equal springs [N/m], a force of 1 N on the highest, which is read.

    hosts, ratios
        Mass number (from the ground, 0) and mass ratio of each absorber.
    damping
        Damping ratio of every spring against the mass above it.
    speeds
        Range of the force [rad/s].
    extra
        Further tables.
    """
    lines = [f'title = "{len(hosts)} absorbers on {count} masses"']
    for i in range(count):
        lines.append(f'[bodies.m{i}]\nmass = "100 kg"')
        lines.append(
            f'[links.s{i}]\nbetween = ["{f"m{i - 1}" if i else "ground"}", "m{i}"]\nstiffness = "{spring!r} N/m"'
        )
        if damping:
            lines.append(f'damping_ratio = {damping!r}\nrelative_to = "m{i}"')
    for i, (host, ratio) in enumerate(zip(hosts, ratios, strict=True)):
        lines.append(
            f'[absorbers.a{i}]\non = "m{host}"\nmass_ratio = {ratio!r}\n'
            "tuning = { from = 0.3, to = 3.0 }\n"
            f"damping_ratio = {{ from = {least_damping!r}, to = 1.0 }}"
        )
    top = f"m{count - 1}"
    lines.append(
        f'[excitations.force]\nkind = "force"\non = "{top}"\namplitude = "1 N"\n'
        f'speed = "{speeds[0]!r}..{speeds[1]!r} rad/s"\nvaries = "constant"'
    )
    lines.append(extra)
    lines.append(goal or f'[goal]\nminimise = "displacement"\nof = "{top}"')
    return "\n".join(lines) + "\n"
