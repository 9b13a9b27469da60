"""Absorber scenes whose best worst amplitude is known from elsewhere: a closed form, and equal peaks in forty digits.

No reference comes from a method that is charted; `tests/references/absorber_optima.py` works them out again.
"""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal, localcontext

from vibopt.study.chart.cases import FEASIBLE, Case

_CLOSED = "closed form (Nishihara and Asami)"
_DIGITS = "equal peaks of the optimum in 40 digits"


def least_peak(mu: float) -> float:
    """Least greatest amplitude of an undamped mass, over its static deflection, at mass ratio mu.

    Over all speeds and all absorbers with one spring and one damper: Nishihara and Asami, 2002.
    """
    with localcontext() as context:
        context.prec = 40
        m = Decimal(mu)
        root = (4 + 3 * m).sqrt()
        square = ((8 + 9 * m) ** 2 * (16 + 9 * m) - 128 * root**3) / (3 * (32 + 27 * m))
        return float(square.sqrt() / (3 * m))


def absorbed(
    hosts: Sequence[int],
    ratios: Sequence[float],
    *,
    count: int = 1,
    spring: float = 1e5,
    damping: float = 0.0,
    speeds: tuple[float, float] = (5.0, 100.0),
    tuning: tuple[float, float] = (0.3, 3.0),
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
            f"tuning = {{ from = {tuning[0]!r}, to = {tuning[1]!r} }}\n"
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


STOCK = (
    Case("1 absorber, undamped mass", absorbed([0], [0.05]), FEASIBLE, least_peak(0.05) / 1e5, _CLOSED),
    Case("1 absorber, damped mass", absorbed([0], [0.05], damping=0.02), FEASIBLE, 5.2671574936586e-5, _DIGITS),
    Case("2 absorbers", absorbed([0, 0], [0.025, 0.025]), FEASIBLE, 5.69505539428107e-5, _DIGITS),
    Case("3 absorbers", absorbed([0] * 3, [0.02, 0.015, 0.015]), FEASIBLE, 5.40552619487582e-5, _DIGITS),
    Case("5 absorbers", absorbed([0] * 5, [0.01] * 5, damping=0.01), FEASIBLE, 4.7444443273958e-5, _DIGITS),
    Case(
        "3 masses, 1 absorber",
        absorbed([2], [0.05], count=3, spring=1e6, damping=0.01, speeds=(5.0, 250.0)),
        FEASIBLE,
        2.23276362921596e-5,
        _DIGITS,
    ),
    Case(
        "3 masses, 2 absorbers",
        absorbed([2, 1], [0.05, 0.05], count=3, spring=1e6, damping=0.01, speeds=(5.0, 250.0)),
        FEASIBLE,
        1.5733801123856977e-5,
        _DIGITS,
    ),
    Case(
        "10 masses, 1 absorber",
        absorbed([9], [0.1], count=10, spring=1e6, damping=0.01, speeds=(1.0, 250.0)),
        FEASIBLE,
        8.82694002423295e-5,
        _DIGITS,
    ),
    Case(
        "100 masses, 1 absorber",
        absorbed([99], [0.5], count=100, spring=1e6, damping=0.01, speeds=(0.2, 30.0)),
        FEASIBLE,
        3.42211459859741e-3,
        _DIGITS,
    ),
)

QUICK = (STOCK[0], STOCK[1], STOCK[2], STOCK[5])
