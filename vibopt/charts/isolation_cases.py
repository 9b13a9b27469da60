"""Isolators in the charts: scenes whose answer is a closed form or equations solved in forty digits.

No reference comes from a method that is charted; `tests/charts/test_isolation_cases.py` works them out with mpmath.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from vibopt.charts.fidelity import Fidelity, on_both_models
from vibopt.charts.machines import block, chain, fan, hall, one_mass, press, star
from vibopt.charts.scene_rivals import EVERY, HARD, QUICK_HARD, chosen
from vibopt.charts.scene_rivals import QUICK as QUICK_LINES
from vibopt.charts.trial import DEFAULT, Case, Table, left_out, scene_table
from vibopt.charts.verdicts import FEASIBLE, INFEASIBLE
from vibopt.scene.read import from_text

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

METHODS = (DEFAULT, "branch_and_bound", "nlp", *chosen(EVERY))
QUICK_METHODS = (DEFAULT, "branch_and_bound", "nlp", *chosen(QUICK_LINES))
HARD_METHODS = (DEFAULT, "branch_and_bound", "nlp", *chosen(HARD))
QUICK_HARD_METHODS = (DEFAULT, "branch_and_bound", "nlp", *chosen(QUICK_HARD))
RUNS, QUICK_RUNS = 3, 2


def speed(*, quick: bool) -> Table:
    """Mounts under one mass and under chains, timed in one run."""
    stock, methods = (QUICK, QUICK_METHODS) if quick else (STOCK, METHODS)
    left = left_out(STOCK, stock, METHODS, methods)
    return scene_table([(case, case.scene()) for case in stock], methods, QUICK_RUNS if quick else RUNS, WARM, left)


def hard(*, quick: bool) -> Table:
    """Every family of hard ground; with `quick` two cases of each."""
    every = families()
    cases, methods = (ends_of(every), QUICK_HARD_METHODS) if quick else (every, HARD_METHODS)
    left = left_out(every, cases, HARD_METHODS, methods)
    return scene_table([(case, case.scene()) for case in cases], methods, 1, WARM, left)


def fidelity(*, quick: bool) -> list[tuple[str, Callable[[], Sequence[Fidelity]]]]:
    """Symmetric machines, chains and halls of unrelated machines, posed with and without reduction."""
    made = [(f"symmetric machine, {n + 1} bodies", star(n)) for n in (2, 4, 8, 16)]
    made += [(f"chain of {n} bodies", chain(n, floor="300 N", start_up="4 mm")) for n in (2, 5, 10)]
    made += [(f"hall of {n} unrelated machines", hall(n)) for n in (2, 5, 10, 20)]
    scenes = [from_text(text, name=name) for name, text in (made[::2] if quick else made)]
    return on_both_models(scenes, quick=quick)


_PRESS, _TWO, _FIVE = 6956917.160715138961, 1102942.8400772246188, 1727991.4374941021286
_FORCE, _MASS, _FLOOR = 30e3, 300.0, 10e3
_TOP, _LOW = 3000 * math.pi / 30, 2000 * math.pi / 30
_GRAVITY = 9.80665
_WIDE = '{ from = "1 kN/m", to = "1 GN/m" }'


def families() -> list[Case]:
    """Hard ground: all cases, those of a family next to each other."""
    return [
        *light_damping(), *hidden_peak(), *undamped_passage(), *thin(), *disjoint(), *on_the_edge(),
        *slivers(), *decades(), *sizes(), *two_clocks(), *many(),
    ]  # fmt: skip


def ends_of(cases: Sequence[Case]) -> list[Case]:
    """The first and the last case of every family."""
    found: dict[str, list[Case]] = {}
    for case in cases:
        found.setdefault(case.family, []).append(case)
    return [case for some in found.values() for case in {some[0].name: some[0], some[-1].name: some[-1]}.values()]


def _shaken(limits: str, damping: float, goal: str = "maximise") -> str:
    return one_mass(
        mass='"300 kg"',
        stiffness=_WIDE,
        damping=f'damping = "{damping!r} N s/m"' if damping else "",
        force='kind = "force"\namplitude = "30 kN"\nspeed = "3000 rpm"\nvaries = "constant"',
        limits=limits,
        goal=f'{goal} = "stiffness"\nof = "mount"',
    )


def _floor(over: str) -> str:
    return f'[limits.floor]\nresponse = "transmitted_force"\ninto = "ground"\nover = "{over}"\nat_most = "10 kN"'


def _motion(over: str, at_most: str) -> str:
    return f'[limits.motion]\nresponse = "displacement"\nof = "machine"\nover = "{over}"\nat_most = "{at_most}"'


def _ratios() -> list[tuple[str, float]]:
    """Damping ratios of a 300 kg machine at 2000 rpm, as words and as damping [N s/m]."""
    critical = 2.0 * _MASS * _LOW
    return [(f"{ratio:g}", ratio * critical) for ratio in (1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 0.0)]


def light_damping() -> list[Case]:
    """Running above resonance with next to no damping: (F^2 - T^2)(k^2 + w^2 c^2) + 2 T^2 m w^2 k = T^2 m^2 w^4."""
    cases = []
    for words, c in _ratios():
        a = _FORCE**2 - _FLOOR**2
        b = 2.0 * _FLOOR**2 * _MASS * _LOW**2
        d = a * (_LOW * c) ** 2 - (_FLOOR * _MASS * _LOW**2) ** 2
        best = (-b + math.sqrt(b * b - 4.0 * a * d)) / (2.0 * a)
        text = _shaken(_floor("2000..3000 rpm"), c)
        cases.append(Case(f"light damping, ratio {words}", text, FEASIBLE, best, "closed form", "light damping"))
    return cases


def hidden_peak() -> list[Case]:
    """Softest mount whose resonance does not lie in the band: sampled speeds step over a sharp peak."""
    cases = []
    for words, c in _ratios():
        pull = 100.0 / 2e-3
        if c * _TOP > 0.2 * pull:
            continue
        best = _MASS * _TOP**2 + math.sqrt(pull**2 - (_TOP * c) ** 2)
        text = _shaken(_motion("1000..3000 rpm", "2 mm"), c, "minimise").replace("30 kN", "100 N")
        text = text.replace('from = "1 kN/m"', 'from = "4 MN/m"')
        cases.append(Case(f"hidden peak, ratio {words}", text, FEASIBLE, best, "closed form", "peak between speeds"))
    return cases


def undamped_passage() -> list[Case]:
    """A mount must isolate at speed and pass its resonance: without damping it cannot."""
    cases = []
    for words, c in _ratios()[1:]:
        text = _shaken(f"{_floor('3000 rpm').replace('over', 'at')}\n\n{_motion('0..3000 rpm', '20 mm')}", c)
        cases.append(
            Case(
                f"passage, ratio {words}",
                text,
                INFEASIBLE,
                math.nan,
                "peak of at least F / (c w0)",
                "no damping to pass with",
            )
        )
    return cases


def thin() -> list[Case]:
    """A window on the natural frequency that gets thinner and thinner."""
    cases = []
    for width in (1e-2, 1e-4, 1e-6, 1e-8):
        high = 10.0 * (1.0 + width)
        limits = f'[limits.window]\nresponse = "natural_frequency"\nat_least = "10 Hz"\nat_most = "{high!r} Hz"'
        best = _MASS * (2.0 * math.pi * high) ** 2
        cases.append(Case(f"window of {width:g}", _shaken(limits, 100.0), FEASIBLE, best, "closed form", "thin set"))
    return cases


def disjoint() -> list[Case]:
    """Two islands: no mode between `low` and 60 Hz, and only the stiff island holds the motion at 20 to 25 Hz."""
    cases = []
    for low in (2, 5, 15):
        modes = f'[limits.modes]\nresponse = "natural_frequency"\noutside = "{low}..60 Hz"'
        limits = f"{modes}\n\n{_motion('20..25 Hz', '1 mm')}"
        pull, w = _FORCE / 1e-3, 2.0 * math.pi * 25.0
        best = max(_MASS * w**2 + math.sqrt(pull**2 - (w * 1e3) ** 2), _MASS * (2.0 * math.pi * 60.0) ** 2)
        text = _shaken(limits, 1e3, "minimise")
        cases.append(Case(f"islands, {low} to 60 Hz", text, FEASIBLE, best, "closed form", "disjoint sets"))
    return cases


def on_the_edge() -> list[Case]:
    """Force and sag that just can, or just cannot, hold together."""
    stiffest = _MASS * _TOP**2 * (_FLOOR / _FORCE) / (1.0 + _FLOOR / _FORCE)
    cases = []
    for part in (1e-4, 1e-6, 1e-9, -1e-9, -1e-6, -1e-4):
        sag = _MASS * _GRAVITY / stiffest * (1.0 + part)
        most = f'[limits.sag]\nresponse = "static_deflection"\nof = "mount"\nat_most = "{sag!r} m"'
        limits = f"{_floor('3000 rpm').replace('over', 'at')}\n\n{most}"
        truth = FEASIBLE if part > 0 else INFEASIBLE
        words = f"{'feasible' if part > 0 else 'infeasible'} by {abs(part):g}"
        cases.append(
            Case(words, _shaken(limits, 0.0), truth, stiffest if part > 0 else math.nan, "closed form", "on the edge")
        )
    return cases


def slivers() -> list[Case]:
    """The best stiffness is known: ask for almost that much, or for a little more."""
    cases = []
    for words, text, best in (
        ("press", press(), _PRESS),
        ("2 bodies", chain(2, floor="400 N", start_up="10 mm"), _TWO),
        ("5 bodies", chain(5, floor="300 N", start_up="4 mm"), _FIVE),
    ):
        for part in (-1e-3, -1e-6, -1e-8, 1e-8, 1e-6, 1e-3):
            least = f"{best * (1.0 + part)!r} N/m"
            floor = f'[limits.firm]\nresponse = "stiffness"\nof = "mount"\nat_least = "{least}"\n\n[goal]'
            truth = FEASIBLE if part < 0 else INFEASIBLE
            name = f"{words}, {'' if part < 0 else 'in'}feasible by {abs(part):g}"
            goal = best if part < 0 else math.nan
            cases.append(Case(name, text.replace("[goal]", floor), truth, goal, "40 digits", "sliver of a set"))
    return cases


def many() -> list[Case]:
    """Several presses in one file, all to be chosen together; the best for one is that of a press alone."""
    return [
        Case(f"{count} presses, {2 * count} unknowns", presses(count), FEASIBLE, _PRESS, "40 digits", "many unknowns")
        for count in (1, 2, 3, 5)
    ]


def presses(count: int) -> str:
    """So many presses in one file, two unknowns each."""
    parts = ['title = "Presses in one hall"']
    for i in range(1, count + 1):
        parts.append(f"""
[bodies.press{i}]
mass = "300 kg"

[links.mount{i}]
between = ["press{i}", "ground"]
stiffness = {{ from = "10 kN/m", to = "1 GN/m" }}
damping = {{ from = "10 N s/m", to = "1 MN s/m" }}

[excitations.shaft{i}]
kind = "force"
on = "press{i}"
amplitude = "30 kN"
speed = "3000 rpm"
varies = "constant"

[limits.floor{i}]
response = "transmitted_force"
through = "mount{i}"
due_to = ["shaft{i}"]
at_most = "10 kN"

[limits.start_up{i}]
response = "displacement"
of = "press{i}"
due_to = ["shaft{i}"]
over = "0..3000 rpm"
at_most = "20 mm"
""")
    return "\n".join([*parts, '[goal]\nmaximise = "stiffness"\nof = "mount1"\n'])


def decades() -> list[Case]:
    """The press with ranges far wider than anybody would write."""
    damping = 'damping = {{ from = "{} N s/m", to = "{} N s/m" }}'
    cases = []
    for low, high, c_low, c_high in (
        ("10 kN/m", "1 GN/m", "10", "1e6"),
        ("1 kN/m", "1e12 N/m", "1e-2", "1e8"),
        ("1 N/m", "1e12 N/m", "1e-6", "1e8"),
    ):
        text = press(damping=damping.format(c_low, c_high)).replace(
            'from = "10 kN/m", to = "1 GN/m"', f'from = "{low}", to = "{high}"'
        )
        span = f"stiffness {low} to {high}"
        cases.append(Case(span, text, FEASIBLE, _PRESS, "40 digits", "decades of stiffness"))
    return cases


def sizes() -> list[Case]:
    """The press in mm, t and s, as small as a watch and as big as a ship."""
    same = press().replace('"300 kg"', '"0.3 t"').replace('"10 kN/m", to = "1 GN/m"', '"10 N/mm", to = "1e6 N/mm"')
    same = same.replace('"10 N s/m", to = "1 MN s/m"', '"0.01 N s/mm", to = "1000 N s/mm"').replace(
        '"20 mm"', '"0.02 m"'
    )
    cases = [Case("press in mm, t, s", same, FEASIBLE, _PRESS, "40 digits", "units and sizes")]
    for name, factor in (("watch of 0.3 g", 1e-6), ("hull of 300 000 t", 1e6)):
        text = press()
        for old, value, unit in (
            ('"300 kg"', 300.0, "kg"), ('"10 kN/m"', 1e4, "N/m"), ('"1 GN/m"', 1e9, "N/m"),
            ('"10 N s/m"', 10.0, "N s/m"),
            ('"1 MN s/m"', 1e6, "N s/m"), ('"30 kN"', 3e4, "N"), ('"10 kN"', 1e4, "N"),
        ):  # fmt: skip
            text = text.replace(old, f'"{value * factor!r} {unit}"')
        cases.append(Case(name, text, FEASIBLE, _PRESS * factor, "40 digits", "units and sizes"))
    return cases


def two_clocks() -> list[Case]:
    """A slow heavy machine and a fast light one in one file: 1 Hz beside 1 kHz and more."""
    cases = []
    for fast in (10.0, 1e3, 1e5):
        text = f"""title = "Two clocks"

[bodies.slow]
mass = "1000 kg"

[bodies.fast]
mass = "0.1 kg"

[links.soft]
between = ["slow", "ground"]
stiffness = {{ from = "1 N/m", to = "1 MN/m" }}

[links.hard]
between = ["fast", "ground"]
stiffness = {{ from = "1 N/m", to = "1e10 N/m" }}

[excitations.beat]
kind = "force"
on = "slow"
amplitude = "100 N"
speed = "1 Hz"

[excitations.hum]
kind = "force"
on = "fast"
amplitude = "1 N"
speed = "{fast:g} Hz"

[limits.soft]
response = "transmitted_force"
through = "soft"
due_to = ["beat"]
at_most = "20 N"

[limits.hard]
response = "transmitted_force"
through = "hard"
due_to = ["hum"]
at_most = "0.1 N"

[limits.firm]
response = "stiffness"
of = "hard"
at_least = "{0.1 * (2 * math.pi * fast) ** 2 * 0.05!r} N/m"

[goal]
maximise = "stiffness"
of = "soft"
"""
        best = 1000.0 * (2.0 * math.pi) ** 2 * 0.2 / 1.2
        cases.append(Case(f"1 Hz beside {fast:g} Hz", text, FEASIBLE, best, "closed form", "1 Hz beside 1 kHz"))
    return cases
