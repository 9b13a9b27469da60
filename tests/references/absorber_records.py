"""What each file of problems/absorbers has to answer, from routes that know nothing of vibopt.

For every file the paths of its records and their values: numbers in SI, words, or lists of intervals.
The problems come from `absorber_routes` (40 digits), the worked cases from `absorber_cases` (brute force).
"""

from collections.abc import Callable
from functools import cache, partial
from itertools import pairwise
from typing import Any

from mpmath import cos, findroot, lu_solve, matrix, mpc, mpf, pi, sqrt

from absorber_cases import CASES
from absorber_routes import (
    GRAVITY,
    PROBLEMS,
    System,
    agreed,
    amplitudes,
    damped_curves,
    fastest_decay,
    least_mean_square,
    nishihara_asami,
    pulley_absorber,
    response_table,
    rpm,
    stiff_absorbers,
    with_absorber,
)

Real = Any  # mpmath's real number, which has no static type
Answers = dict[str, Any]

GOAL, STATUS = "goal", "status"
LOW, HIGH = "limits.low.value", "limits.high.value"


@cache
def solved(name: str) -> Answers:
    """The answers of one problem, worked out once."""
    answers: Answers = PROBLEMS[name]()
    return answers


def absorber(key: str) -> str:
    """Path of a variable of the absorber."""
    return f"variables.absorbers.absorber.{key}"


def both(frequencies: list[Real], low: str = LOW, high: str = HIGH) -> Answers:
    """Both natural frequencies under their paths."""
    return {low: frequencies[0], high: frequencies[1]}


def proven(answers: Answers) -> Answers:
    """With the word that the optimum is proven."""
    return {STATUS: "optimal", **answers}


# --- natural frequencies out of a band -------------------------------------------------------


def tuned(problem: str) -> Answers:
    """Least absorber tuned to the speed."""
    found = solved(problem)
    mass, stiffness = found["tuned.mass"], found["tuned.stiffness"]
    return proven({GOAL: mass, "measures.spring.value": stiffness, **both(found["tuned.frequencies"])})


def free(problem: str) -> Answers:
    """Least absorber of any tuning."""
    found = solved(problem)
    answers = {GOAL: found["free.mass"], "measures.spring.value": found["free.stiffness"]}
    return proven(answers | {absorber("tuning"): found["free.tuning"] / main_frequency(problem)})


def main_frequency(problem: str) -> Real:
    """Frequency to which the tuning of a problem refers."""
    speeds = {"9.51": 1200, "9.53 both frequencies": 800, "9.55": 600}
    return rpm(speeds[problem]) if problem in speeds else solved(problem)["main.frequency"]


def cantilever() -> Answers:
    found = solved("9.52")
    answers = {GOAL: found["ratio"], "measures.mass.value": found["mass"], "measures.spring.value": found["stiffness"]}
    swing = {"measures.swing.value": found["absorber.amplitude"], "measures.beam.value": found["main.stiffness"]}
    return proven(answers | swing | {"limits.low.value": found["frequencies"][0]})


def printed_pipe() -> Answers:
    """9.53 with the numbers that were printed."""
    pipe, added, spring = mpf("59.8861"), mpf("4.301"), mpf("30186.2166")
    frequencies = with_absorber(pipe, pipe * rpm(800) ** 2, added, spring)
    return {STATUS: "violated", **both(frequencies)}


def trial_pipe() -> Answers:
    """9.53: the pipe that answers to the trial kilogram with 750 and 1000 rpm."""
    found = solved("9.53 both frequencies")
    frequencies = with_absorber(found["main.mass"], found["main.stiffness"], mpf(1), found["trial.stiffness"])
    spring = {"measures.spring.value": found["trial.stiffness"]}
    return spring | both(frequencies, "measures.low.value", "measures.high.value")


TRIAL_RATIO, TRIAL_TUNING = "goal", "variables.absorbers.trial.tuning"


def identified_pipe() -> Answers:
    """9.53: the trial of one kilogram as a part of the pipe, and its tuning."""
    found = solved("9.53 both frequencies")
    return proven({TRIAL_RATIO: 1 / found["main.mass"], TRIAL_TUNING: found["trial.tuning"] / rpm(800)})


def pipe_of_one_frequency() -> Answers:
    """9.53: the same with the trial at 800 rpm; both natural frequencies then multiply to the square of that."""
    ratio = 1 / solved("9.53 as printed")["main.mass"]
    upper = with_absorber(mpf(1), rpm(800) ** 2, ratio, ratio * rpm(800) ** 2)[1]
    return proven({TRIAL_RATIO: ratio, "measures.high.value": agreed(upper, rpm(800) ** 2 / rpm(750))})


def floor() -> Answers:
    found = solved("9.54")
    answers = {"measures.mass.value": found["mass"], "measures.ratio.value": found["ratio"]}
    return answers | both(found["frequencies"], "measures.low.value", "measures.high.value")


def printed_floor() -> Answers:
    """9.55 with the printed mass and spring, on the floor that resonates at 600 rpm."""
    frequencies = with_absorber(mpf(900), 900 * rpm(600) ** 2, mpf("477.72"), mpf("1885972"))
    return {STATUS: "violated", **both(frequencies)}


# --- torsion ---------------------------------------------------------------------------------


def hollow_shaft(problem: str) -> Answers:
    found = solved(problem)
    return {
        STATUS: "optimal",
        absorber("shaft.diameter"): found["outer"],
        "measures.own.value": found["main.frequency"],
        "measures.first_shaft.value": found["main.stiffness"],
        "measures.first_disc.value": found["main.inertia"],
        "measures.second_disc.value": found["inertia"],
        "measures.second_shaft.value": found["stiffness"],
        **both(found["frequencies"], "measures.low.value", "measures.high.value"),
    }


def quarter_below() -> Answers:
    """9.57 with the lower natural frequency a quarter below, as the print chooses."""
    found = solved("9.57")
    low, high = found["printed_rule.frequencies"]
    springs = {GOAL: found["printed_rule.inertia"], "measures.spring.value": found["printed_rule.stiffness"]}
    return proven(springs | both([low, high]))


def disc_at_rest() -> Answers:
    """9.56 at the natural frequency of the first disc: all of the torque is in the second shaft."""
    found = solved("9.56")
    twist = {"measures.twist.value": 300 / found["stiffness"]}
    return {absorber("shaft.diameter"): found["outer"], GOAL: mpf(0), **twist}


def printed_rotor() -> Answers:
    """9.57 with the printed inertia and stiffness."""
    frequencies = with_absorber(mpf(15), mpf(600_000), mpf("5.1045"), mpf(204_200))
    return {STATUS: "met", **both(frequencies)}


# --- tables ----------------------------------------------------------------------------------


def ratios_table() -> Answers:
    """9.58: ten machines of 1 rad/s side by side, their frequencies in order."""
    found = solved("9.58")
    answers = {}
    for index in range(10):
        answers[f"measures.low_{index + 1}.value"] = found["low"][index]
        answers[f"measures.high_{index + 1}.value"] = found["high"][index]
    return answers


def stiff_table(ratio: str) -> Answers:
    """9.67: four machines side by side, absorbers of 1 rad/s."""
    found = stiff_absorbers()
    return {
        f"measures.{side}_{mu.replace('.', '')}.value": found[f"{side}({ratio}, {mu})"]
        for side in ("low", "high")
        for mu in ("0.25", "0.5", "0.75", "1")
    }


CURVES = (
    ("0.2", "0.2"),
    ("0.2", "0.5"),
    ("0.3", "0.2"),
    ("0.3", "0.5"),
    ("0.5", "0.1"),
    ("0.4", "0.2"),
    ("0.4", "0.5"),
)


def curves() -> Answers:
    """9.66: peaks over a static deflection of 1 mm, main frequency 100 rad/s."""
    found = damped_curves()
    answers = {}
    for zeta, mu in CURVES:
        name = f"{zeta[2:]}_{mu[2:]}"
        for part in ("main", "absorber"):
            answers[f"measures.{part}_{name}.value"] = found[f"{part}.peak({zeta}, {mu})"] / 1000
            answers[f"measures.{part}_{name}.worst_at"] = found[f"{part}.at({zeta}, {mu})"] * 100
    return answers


def best_curve(mu: str) -> Answers:
    """9.66 as a design: the least peak at one mass ratio."""
    best = nishihara_asami(mu)
    answers = {absorber("tuning"): best["tuning"], absorber("damping_ratio"): best["zeta"]}
    return proven({GOAL: best["peak"] / 1000, **answers})


def points_of_curves() -> Answers:
    """9.66 at every hundredth of the printed points: motions over a static deflection of 1 mm."""
    answers = {}
    for zeta, mu in CURVES:
        system = System(mpf(mu), mpf(1), 2 * mpf(zeta))
        for tenths in range(6, 14):
            x = (mpf(tenths) / 10) ** 2
            name = f"{zeta[2:]}_{mu[2:]}_g_{tenths:02d}"
            answers[f"measures.main_{name}.value"] = system.height(x) / 1000
            answers[f"measures.absorber_{name}.value"] = system.height(x, motion="absorber") / 1000
    return answers


RESPONSES = tuple((zeta, f"{tenths / 10:.1f}") for zeta in ("0", "0.1", "10") for tenths in range(5, 20))


def responses() -> Answers:
    """9.71: motions at single speeds over a static deflection of 1 mm."""
    found = response_table()
    return {
        f"measures.{part}_{zeta.replace('.', '')}_{g.replace('.', '')}.value": found[f"{part}({zeta}, {g})"] / 1000
        for zeta, g in RESPONSES
        for part in ("main", "absorber")
    }


# --- amplitudes ------------------------------------------------------------------------------


def quiet_range() -> Answers:
    """9.59 with a main frequency of 100 rad/s, up to 300 rad/s."""
    (low, high), (above, _) = solved("9.59")["set"]
    return {"set": [(100 * low, 100 * high), (100 * above, mpf(300))]}


def swinging() -> Answers:
    found = solved("9.60")
    answers = {"measures.spring.value": found["stiffness"], "measures.swing.value": abs(found["absorber.amplitude"])}
    own = {"measures.own.value": found["main.frequency"], "measures.machine.value": mpf(0)}
    return answers | own | both(found["frequencies"], "measures.low.value", "measures.high.value")


def motor_on_beam(problem: str) -> Answers:
    found = solved(problem)
    spring = "measures.spring.value"
    answers = {spring: found["stiffness"], "measures.beam.value": found["main.stiffness"]}
    return answers | both(found["frequencies"], "measures.low.value", "measures.high.value")


def least_on_beam() -> Answers:
    found = solved("9.61")
    stroke = {"limits.stroke.value": found["absorber.amplitude"]}
    return proven({GOAL: found["mass"], **stroke, **motor_on_beam("9.61")})


def printed_on_beam() -> Answers:
    found = solved("9.61 as printed")
    stroke = {"limits.stroke.value": found["absorber.amplitude"]}
    return {STATUS: "met", **stroke, **motor_on_beam("9.61 as printed")}


def damped_bridge() -> Answers:
    found = solved("9.62")
    springs = {
        absorber("stiffness"): found["damped.stiffness"],
        absorber("damping"): found["damped.damping"],
    }
    return proven({GOAL: found["damped.peak"], **springs})


def undamped_bridge() -> Answers:
    found = solved("9.62")
    speeds = both(found["undamped.frequencies"], "measures.low.value", "measures.high.value")
    return {
        absorber("stiffness"): found["undamped.stiffness"],
        "measures.bridge.value": found["undamped.main.amplitude"],
        "measures.swing.value": found["undamped.absorber.amplitude"],
        "measures.own.value": found["main.frequency"],
    } | speeds


def bridge_of_least_swing() -> Answers:
    """9.62: a tuned absorber that carries all of the force swings by the force over its spring."""
    stiffness = mpf(600) / mpf("0.1")
    return proven({GOAL: stiffness / solved("9.62")["main.frequency"] ** 2, "measures.spring.value": stiffness})


def motor_off_resonance() -> Answers:
    found = solved("9.63")
    spring = {absorber("stiffness"): found["stiffness"]}
    return spring | both(found["frequencies"], "measures.low.value", "measures.high.value")


def pulley() -> Answers:
    """9.64: turning is asked as motion of the rim, at a radius of 0.1 m."""
    answers = {}
    for name, speed in (("quiet", None), ("slow", mpf(20))):
        found = pulley_absorber(speed)
        answers[f"measures.mass_{name}.value"] = found["main.amplitude"]
        answers[f"measures.rim_{name}.value"] = found["pulley.angle"] / 10
    return answers


def pulley_quiet_speeds() -> Answers:
    """9.64: frequencies up to 100 rad/s at which the mass moves by no more than 1 mm."""

    def excess(speed: Real) -> Real:
        return pulley_absorber(speed)["main.amplitude"] - mpf("0.001")

    quiet = pulley_absorber()["quiet_at"]
    grid = [mpf(step) / 10 for step in range(1, 1000)]
    brackets = sorted([quiet, *grid])
    values = [excess(speed) for speed in brackets]
    pairs = zip(pairwise(brackets), pairwise(values), strict=True)
    ends = [findroot(excess, ends, solver="anderson") for ends, (one, other) in pairs if one * other < 0]
    low, high, last = ends
    return {"set": [(low, high), (last, mpf(100))]}


def pulley_spring() -> Answers:
    """9.64: I0 w^2 = R^2 (K1 + K2) at 300 rpm; all of the force then stretches the rope of 1 kN/m."""
    inertia, radius, rope = mpf("0.04"), mpf("0.1"), mpf(1000)
    stiffness = inertia * rpm(300) ** 2 / radius**2 - rope
    return {"variables.links.spring.stiffness": stiffness, GOAL: mpf(0), "measures.rim.value": 50 / rope}


# --- the assignment --------------------------------------------------------------------------


def chain() -> Answers:
    """Assignment 4 a: natural frequencies, and the motion over the moving base at 15 rad/s."""
    first, second = solved("assignment 4 a")["frequencies"]
    m1, m2, k1, k2, c1, c2, w = mpf(4), mpf(1), mpf(1200), mpf(300), mpf(12), mpf(3), mpf(15)
    lower, upper = mpc(k1, w * c1), mpc(k2, w * c2)
    moved = lu_solve(matrix([[lower + upper - m1 * w**2, -upper], [-upper, upper - m2 * w**2]]), matrix([lower, 0]))
    motions = {f"measures.motion_{i + 1}.value": abs(moved[i]) for i in range(2)}
    ratios = {f"measures.ratio_{i + 1}.value": solved("assignment 4 a")["mode_ratios"][i] for i in range(2)}
    return {"measures.first.value": first, "measures.second.value": second, **ratios, **motions}


def let_go() -> Answers:
    """Assignment 4 a: the sum of both modes without damping."""
    found = solved("assignment 4 a")
    modes = list(zip(found["frequencies"], found["sizes"], found["phases"], found["mode_ratios"], strict=True))
    answers = {}
    for millis in (100, 400):
        moved = [size * cos(w * mpf(millis) / 1000 + phase) for w, size, phase, _ in modes]
        answers[f"measures.first_{millis}.value"] = sum(moved)
        answers[f"measures.second_{millis}.value"] = sum(one * mode[3] for one, mode in zip(moved, modes, strict=True))
    return answers


def pendulum() -> Answers:
    found = solved("assignment 4 b")
    mass, bob = amplitudes(mpf(8), mpf(400), mpf(2), 2 * GRAVITY / mpf("0.3"), mpf(5), mpf(10))
    swings = {"measures.mass.value": abs(mass), "measures.bob.value": abs(bob)}
    answers = {"measures.own.value": found["quiet_at"], **swings}
    return answers | both(found["frequencies"], "measures.low.value", "measures.high.value")


def pendulum_length() -> Answers:
    """The rod that holds the mass at rest at 60 rpm."""
    length = GRAVITY / rpm(60) ** 2
    return {absorber("length"): length}


# --- the cabinet on a roof -------------------------------------------------------------------


def after_a_knock() -> Answers:
    best, own, mass = fastest_decay("0.05"), mpf(100), mpf(5)
    link = "variables.links.absorber."
    stiffness, damping = mass * (best["tuning"] * own) ** 2, 2 * best["zeta"] * mass * best["tuning"] * own
    return {STATUS: "optimal", GOAL: best["decay"] * own, link + "stiffness": stiffness, link + "damping": damping}


def in_gusts() -> Answers:
    """A density of 100 N^2/Hz, one-sided, is 100 / (4 pi) two-sided per rad/s."""
    best, own, mass = least_mean_square("0.05"), mpf(100), mpf(5)
    link = "variables.links.absorber."
    stiffness, damping = mass * (best["tuning"] * own) ** 2, 2 * best["zeta"] * mass * best["tuning"] * own
    motion = sqrt(best["integral"] * 100 / (4 * pi) * own) / mpf(10) ** 6
    return {GOAL: motion, link + "stiffness": stiffness, link + "damping": damping}


ROUTES: dict[str, Callable[[], Answers]] = {
    "rao_9_51": partial(tuned, "9.51"),
    "rao_9_51_tuned_freely": partial(free, "9.51"),
    "rao_9_52": cantilever,
    "rao_9_53": partial(tuned, "9.53 both frequencies"),
    "rao_9_53_tuned_freely": partial(free, "9.53 both frequencies"),
    "rao_9_53_one_frequency": partial(tuned, "9.53 as printed"),
    "rao_9_53_printed_design": printed_pipe,
    "rao_9_53_trial": trial_pipe,
    "rao_9_53_trial_identified": identified_pipe,
    "rao_9_53_trial_read_as_printed": pipe_of_one_frequency,
    "rao_9_54": floor,
    "rao_9_55": partial(tuned, "9.55"),
    "rao_9_55_tuned_freely": partial(free, "9.55"),
    "rao_9_55_printed_design": printed_floor,
    "rao_9_56": partial(hollow_shaft, "9.56"),
    "rao_9_56_half_a_metre": partial(hollow_shaft, "9.56 half a metre"),
    "rao_9_56_held_at_rest": disc_at_rest,
    "rao_9_57": partial(tuned, "9.57"),
    "rao_9_57_tuned_freely": partial(free, "9.57"),
    "rao_9_57_quarter_below": quarter_below,
    "rao_9_57_printed_design": printed_rotor,
    "rao_9_58": ratios_table,
    "rao_9_59": quiet_range,
    "rao_9_60": swinging,
    "rao_9_61": least_on_beam,
    "rao_9_61_printed_design": printed_on_beam,
    "rao_9_62": damped_bridge,
    "rao_9_62_undamped": undamped_bridge,
    "rao_9_62_least_swing": bridge_of_least_swing,
    "rao_9_63": motor_off_resonance,
    "rao_9_64": pulley,
    "rao_9_64_quiet_speeds": pulley_quiet_speeds,
    "rao_9_64_spring": pulley_spring,
    "rao_9_66": curves,
    "rao_9_66_table": points_of_curves,
    "rao_9_66_best_fifth": partial(best_curve, "0.2"),
    "rao_9_66_best_half": partial(best_curve, "0.5"),
    "rao_9_67_half_above": partial(stiff_table, "1.5"),
    "rao_9_67_three_times": partial(stiff_table, "3"),
    "rao_9_67_four_and_a_half": partial(stiff_table, "4.5"),
    "rao_9_71": responses,
    "assignment_4a": chain,
    "assignment_4a_let_go": let_go,
    "assignment_4b": pendulum,
    "assignment_4b_length": pendulum_length,
    "cabinet_after_a_knock": after_a_knock,
    "cabinet_in_gusts": in_gusts,
    **CASES,
}
