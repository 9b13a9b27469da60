"""Isolation problems solved a second time, without vibopt.

Every answer recorded in ``problems/isolation/rao_*.toml`` is computed here from the closed form of
one mass on one mount, with 40 digits. All results are in SI units: m, N, N/m, N s/m, rad/s
(m/s for the speed of a vehicle); ratios are plain numbers; amplitudes are peak.

Symbols: r2 = (speed / natural frequency)^2, zeta = damping ratio, T = transmissibility.
"""

from collections.abc import Callable
from typing import Any

from mpmath import diff, findroot, mp, mpf, pi, sqrt

mp.dps = 40

Real = Any  # mpmath's real number, which has no static type
Answer = Any  # a real number, a word, or a list of intervals
Answers = dict[str, Answer]

GRAVITY = mpf("9.80665")
INFINITE = "infinite"
MOUNT_STIFFNESS = "variables.links.mount.stiffness"
MOUNT_DAMPING = "variables.links.mount.damping"


# --- one mass on one mount -------------------------------------------------------------------


def rpm(speed: float | str) -> Real:
    """Angular speed in rad/s."""
    return mpf(speed) * 2 * pi / 60


def hertz(frequency: float | str) -> Real:
    """Angular speed in rad/s."""
    return mpf(frequency) * 2 * pi


def kilometres_per_hour(speed: float | str) -> Real:
    """Speed in m/s."""
    return mpf(speed) / mpf("3.6")


def transmissibility(r2: Real, zeta: Real) -> Real:
    """Force ratio, and as well the ratio of motions over a moving base."""
    return sqrt((1 + 4 * zeta**2 * r2) / ((1 - r2) ** 2 + 4 * zeta**2 * r2))


def isolating_ratio(ratio: Real, zeta: Real) -> Real:
    """The r2 above resonance at which the transmissibility comes down to `ratio`."""
    half = 1 - 2 * zeta**2 + 2 * zeta**2 / ratio**2
    return half + sqrt(half**2 - 1 + 1 / ratio**2)


def stiffest(mass: Real, speed: Real, ratio: Real, zeta: Real) -> Real:
    """Largest stiffness whose transmissibility at `speed` is not above `ratio` (< 1)."""
    return mass * speed**2 / isolating_ratio(ratio, zeta)


def peak_ratio(zeta: Real) -> tuple[Real, Real]:
    """Highest transmissibility over all speeds, and the r2 at which it stands."""
    r2 = (sqrt(1 + 8 * zeta**2) - 1) / (4 * zeta**2)
    return transmissibility(r2, zeta), r2


def impedance(stiffness: Real, damping: Real, mass: Real, speed: Real) -> Real:
    """Force over displacement of the mass on its mount."""
    return sqrt((stiffness - mass * speed**2) ** 2 + (damping * speed) ** 2)


def mount_impedance(stiffness: Real, damping: Real, speed: Real) -> Real:
    """Force in the mount over its deformation."""
    return sqrt(stiffness**2 + (damping * speed) ** 2)


def peak_under_constant_force(force: Real, mass: Real, stiffness: Real, damping: Real) -> tuple[Real, Real]:
    """Resonant amplitude and its speed under a force of the same amplitude at every speed."""
    zeta = damping / (2 * sqrt(stiffness * mass))
    amplitude = force / (stiffness * 2 * zeta * sqrt(1 - zeta**2))
    return amplitude, sqrt(stiffness / mass * (1 - 2 * zeta**2))


def peak_under_unbalance(unbalance: Real, mass: Real, stiffness: Real, damping: Real) -> tuple[Real, Real]:
    """Resonant amplitude and its speed under a force that grows with the speed squared."""
    zeta = damping / (2 * sqrt(stiffness * mass))
    amplitude = unbalance / mass / (2 * zeta * sqrt(1 - zeta**2))
    return amplitude, sqrt(stiffness / mass / (1 - 2 * zeta**2))


def verdict(holds: bool) -> str:
    """Status of an analysis."""
    return "met" if holds else "violated"


# --- problems --------------------------------------------------------------------------------


def car_on_wavy_road() -> Answers:
    """9.1: the undamped car meets its resonance at one speed."""
    natural = sqrt(mpf(400_000) / 1500)
    wavelength = mpf(5)
    return {
        "measures.ride.value": INFINITE,
        "measures.ride.worst_at": natural * wavelength / (2 * pi),
        "measures.bounce.value": natural,
    }


CAR_MASS, CAR_STIFFNESS, WAVE, ROAD, FELT = mpf(1500), mpf(400_000), mpf(5), mpf("0.001"), mpf("0.002")
"""9.1: the car, its springs, length and height of the waves, and the motion that is felt."""


def quiet_car_speeds() -> Answers:
    """9.1: |1 / (1 - r2)| = 2 at r2 = 1/2 and 3/2."""
    assert FELT / ROAD == 2
    resonance = sqrt(CAR_STIFFNESS / CAR_MASS) * WAVE / (2 * pi)
    ends = (mpf(0), resonance * sqrt(mpf("0.5"))), (resonance * sqrt(mpf("1.5")), kilometres_per_hour(120))
    return {"set": list(ends)}


def stiffer_car() -> Answers:
    """9.1: springs whose resonance lies so far above 120 km/h that r2 = 1/2 there; softer ones pass it."""
    omega = 2 * pi * kilometres_per_hour(120) / WAVE
    return {"status": "optimal", "variables.links.springs.stiffness": 2 * CAR_MASS * omega**2}


def heavier_car() -> Answers:
    """9.1: r2 = 3/2 at the speed at which the light car resonates."""
    omega = 2 * pi * kilometres_per_hour("46.781808") / WAVE
    mass = mpf("1.5") * CAR_STIFFNESS / omega**2
    bounce = sqrt(CAR_STIFFNESS / mass)
    return {"status": "optimal", "variables.bodies.car.mass": mass, "measures.bounce.value": bounce}


def ever_heavier_car() -> Answers:
    """9.1: every mass from 1500 kg up puts the resonance of the undamped car between 0 and 120 km/h."""
    highest = sqrt(CAR_STIFFNESS / CAR_MASS) * WAVE / (2 * pi)
    return {"status": "infeasible" if highest < kilometres_per_hour(120) else "optimal"}


def damped_car() -> Answers:
    """9.1: the damping ratio whose highest transmissibility is 2."""
    zeta = findroot(lambda z: peak_ratio(z)[0] - FELT / ROAD, mpf("0.3"))
    natural = sqrt(CAR_STIFFNESS / CAR_MASS)
    return {
        "status": "optimal",
        "variables.links.springs.damping": 2 * zeta * sqrt(CAR_STIFFNESS * CAR_MASS),
        "measures.ratio.value": zeta,
        "limits.ride.worst_at": sqrt(peak_ratio(zeta)[1]) * natural * WAVE / (2 * pi),
    }


def rms_of_a_harmonic() -> Answers:
    """9.2: the peak amplitude; what is recorded as rms is read as peak over root two."""
    peak = mpf(300) / abs(mpf(10_000) - 1 * mpf(200) ** 2)
    return {"measures.peak.value": peak, "measures.rms.value": peak}


def free_machine(mass: Real, stiffness: Real) -> Answers:
    """9.26 a: a mount that is nothing against the inertia above it."""
    force = mpf("2.5") * mpf("0.075") * rpm(600) ** 2
    amplitude = force / abs(stiffness - mass * rpm(600) ** 2)
    return {"measures.motion.value": amplitude, "measures.floor_force.value": amplitude * stiffness}


def fixed_machine() -> Answers:
    """9.26 b: a mount that is all but rigid."""
    force = mpf("2.5") * mpf("0.075") * rpm(600) ** 2
    stiffness = mpf(10) ** 12
    amplitude = force / abs(stiffness - 100 * rpm(600) ** 2)
    return {"measures.floor_force.value": amplitude * stiffness}


def instrument_on_panel() -> Answers:
    """9.27: the lowest frequency of the band is the hardest to isolate."""
    mass = 85 / GRAVITY
    stiffness = stiffest(mass, hertz(25), mpf("0.2"), mpf(0))
    at_35 = transmissibility(mass * hertz(35) ** 2 / stiffness, mpf(0))
    return {
        MOUNT_STIFFNESS: stiffness,
        "goal": 85 / stiffness,
        "limits.isolated.worst_at": hertz(25),
        "measures.ratio_at_35_hz.value": at_35,
        "measures.isolation_at_35_hz.value": 1 - at_35,
    }


def fan_through_resonance() -> Answers:
    """9.28: damping from the true peak on the way up, then stiffness from the running speed."""
    mass = 800 / GRAVITY
    zeta = findroot(lambda z: peak_ratio(z)[0] - mpf("2.5"), mpf("0.22"))
    stiffness = stiffest(mass, rpm(600), mpf("0.1"), zeta)
    return {
        MOUNT_STIFFNESS: stiffness,
        MOUNT_DAMPING: 2 * zeta * sqrt(stiffness * mass),
        "measures.damping_ratio.value": zeta,
    }


def fan_at_resonance() -> Answers:
    """9.28 with 2.5 at r = 1: the damping ratio is one over the root of 21."""
    mass, zeta = 800 / GRAVITY, 1 / sqrt(mpf(21))
    assert abs(transmissibility(mpf(1), zeta) - mpf("2.5")) < mpf(10) ** -30
    stiffness = stiffest(mass, rpm(600), mpf("0.1"), zeta)
    return {
        "status": "optimal",
        MOUNT_STIFFNESS: stiffness,
        MOUNT_DAMPING: 2 * zeta * sqrt(stiffness * mass),
        "limits.at_resonance.value": zeta,
    }


def fan_as_printed() -> Answers:
    """9.28 with the mount of the print."""
    mass = 800 / GRAVITY
    stiffness, damping = mpf("12958.5054"), mpf("448.6139")
    zeta = damping / (2 * sqrt(stiffness * mass))
    peak, r2 = peak_ratio(zeta)
    running = transmissibility(mass * rpm(600) ** 2 / stiffness, zeta)
    return {
        "limits.start_up.value": peak,
        "limits.start_up.worst_at": sqrt(r2 * stiffness / mass),
        "limits.running.value": 1 - running,
        "status": verdict(peak <= mpf("2.5") and running <= mpf("0.1")),
    }


def compressor(zeta: Real) -> Answers:
    """9.29: stiffest mount, then the amplitude at speed."""
    mass, unbalance, speed = mpf(500), mpf("0.5"), rpm(300)
    stiffness = stiffest(mass, speed, mpf("0.1"), zeta)
    damping = 2 * zeta * sqrt(stiffness * mass)
    return {
        MOUNT_STIFFNESS: stiffness,
        "measures.amplitude.value": unbalance * speed**2 / impedance(stiffness, damping, mass, speed),
        "measures.sag.value": mass * GRAVITY / stiffness,
    }


def compressor_held(zeta: Real) -> Answers:
    """9.29: the same mount, deflected by the rotating force at a speed of zero."""
    stiffness = stiffest(mpf(500), rpm(300), mpf("0.1"), zeta)
    return {MOUNT_STIFFNESS: stiffness, "measures.deflection.value": mpf("493.48022") / stiffness}


def preferred_mount(of_mount: Callable[[Real], tuple[Real, Real, Real]]) -> Answers:
    """9.29: the better damping ratio of 0 and 0.1; `of_mount` gives its goal, stiffness and amplitude."""
    best = min((of_mount(zeta), zeta) for zeta in (mpf(0), mpf("0.1")))
    (goal, stiffness, _), zeta = best
    return {
        "status": "optimal",
        "variables.links.mount.damping_ratio": zeta,
        MOUNT_STIFFNESS: stiffness,
        "goal": goal,
    }


def amplitude_of_compressor(stiffness: Real, zeta: Real) -> Real:
    """9.29: motion at 300 rpm."""
    damping = 2 * zeta * sqrt(stiffness * 500)
    return mpf("0.5") * rpm(300) ** 2 / impedance(stiffness, damping, mpf(500), rpm(300))


def preferred_by_amplitude() -> Answers:
    """9.29: least motion; above resonance the softest permitted mount moves least, and that sags 140 mm."""
    softest = 500 * GRAVITY / mpf("0.14")
    answers = preferred_mount(lambda zeta: (amplitude_of_compressor(softest, zeta), softest, mpf(0)))
    zeta = answers["variables.links.mount.damping_ratio"]
    ratio = transmissibility(500 * rpm(300) ** 2 / softest, zeta)
    assert ratio <= mpf("0.1")
    assert amplitude_of_compressor(softest * mpf("1.01"), zeta) > answers["goal"]
    return {**answers, "measures.passed.value": ratio}


def preferred_by_sag() -> Answers:
    """9.29: least sag, each mount as stiff as a tenth of the force permits."""

    def of_mount(zeta: Real) -> tuple[Real, Real, Real]:
        stiffness = stiffest(mpf(500), rpm(300), mpf("0.1"), zeta)
        return 500 * GRAVITY / stiffness, stiffness, amplitude_of_compressor(stiffness, zeta)

    answers = preferred_mount(of_mount)
    amplitude = of_mount(answers["variables.links.mount.damping_ratio"])[2]
    return {**answers, "measures.amplitude.value": amplitude}


def speeds_that_amplify() -> Answers:
    """9.30 a: every mount amplifies up to root two times its natural frequency."""
    return {"set": [(mpf(0), sqrt(2 * mpf(10_000) / 200))]}


def speeds_that_isolate() -> Answers:
    """9.30 b: from the tenth down to the highest speed asked about."""
    r2 = isolating_ratio(mpf("0.1"), mpf("0.15"))
    return {"set": [(sqrt(r2 * mpf(10_000) / 200), rpm(1000))]}


def sixty_percent() -> Answers:
    """9.31"""
    stiffness = stiffest(mpf(68), rpm(300), mpf("0.4"), mpf(0))
    return {MOUNT_STIFFNESS: stiffness, "goal": 68 * GRAVITY / stiffness}


def seventy_five_percent() -> Answers:
    """9.32"""
    return {MOUNT_STIFFNESS: stiffest(mpf(50), rpm(1200), mpf("0.25"), mpf("0.07"))}


def undamped_fan() -> Answers:
    """9.33"""
    mass, speed = mpf(80), rpm(1000)
    stiffness = stiffest(mass, speed, mpf("0.2"), mpf(0))
    return {
        MOUNT_STIFFNESS: stiffness,
        "measures.amplitude.value": 10_000 / abs(stiffness - mass * speed**2),
        "measures.start_up.value": INFINITE,
        "measures.start_up.worst_at": sqrt(stiffness / mass),
    }


def press_answers(stiffness: Real, damping: Real, start_up: tuple[Real, Real]) -> Answers:
    """What is recorded of a mount of the printing press (9.34)."""
    mass, force, speed = mpf(300), mpf(30_000), rpm(3000)
    amplitude = force / impedance(stiffness, damping, mass, speed)
    return {
        "limits.floor_force.value": amplitude * mount_impedance(stiffness, damping, speed),
        "limits.amplitude.value": amplitude,
        "limits.start_up.value": start_up[0],
        "limits.start_up.worst_at": start_up[1],
        "measures.sag.value": mass * GRAVITY / stiffness,
    }


def softness_for_floor_force(damping: Real) -> Real:
    """Stiffness of the press's mount at which the floor gets one third of the force."""
    mass, speed = mpf(300), rpm(3000)
    inertia, viscous = mass * speed**2, (damping * speed) ** 2
    # 9 (k^2 + v) = (k - i)^2 + v  with i the inertia and v the viscous part
    return (-inertia + sqrt(inertia**2 + 8 * (inertia**2 - 8 * viscous))) / 8


def press_constant_force() -> Answers:
    """9.34: floor force and resonance are both at their limits."""
    mass, force = mpf(300), mpf(30_000)

    def excess(damping: Real) -> Real:
        stiffness = softness_for_floor_force(damping)
        return peak_under_constant_force(force, mass, stiffness, damping)[0] - mpf("0.02")

    damping = findroot(excess, mpf(10_000))
    stiffness = softness_for_floor_force(damping)
    peak = peak_under_constant_force(force, mass, stiffness, damping)
    return {
        MOUNT_STIFFNESS: stiffness,
        MOUNT_DAMPING: damping,
        **press_answers(stiffness, damping, peak),
    }


def press_with_most_room() -> Answers:
    """9.34 with the same part left over of both limits, as much as any damping lets them have."""
    mass, force, speed = mpf(300), mpf(30_000), rpm(3000)

    def parts(stiffness: Real, damping: Real) -> tuple[Real, Real]:
        through = mount_impedance(stiffness, damping, speed) / impedance(stiffness, damping, mass, speed)
        return force * through / 10_000, peak_under_constant_force(force, mass, stiffness, damping)[0] / mpf("0.02")

    def balanced(damping: Real) -> Real:
        return findroot(lambda k: parts(k, damping)[0] - parts(k, damping)[1], (mpf(3_000_000), mpf(4_000_000)))

    damping = findroot(lambda c: diff(lambda one: parts(balanced(one), one)[0], c), (mpf(18_000), mpf(19_000)))
    stiffness = balanced(damping)
    peak = peak_under_constant_force(force, mass, stiffness, damping)
    return {
        MOUNT_STIFFNESS: stiffness,
        MOUNT_DAMPING: damping,
        "goal": 1 - parts(stiffness, damping)[0],
        **press_answers(stiffness, damping, peak),
    }


def press_speed_squared() -> Answers:
    """9.34 with a force that grows with the speed squared."""
    mass, unbalance = mpf(300), mpf(30_000) / rpm(3000) ** 2

    def excess(damping: Real) -> Real:
        stiffness = softness_for_floor_force(damping)
        return peak_under_unbalance(unbalance, mass, stiffness, damping)[0] - mpf("0.02")

    damping = findroot(excess, mpf(2_400))
    stiffness = softness_for_floor_force(damping)
    peak = peak_under_unbalance(unbalance, mass, stiffness, damping)
    return {
        MOUNT_STIFFNESS: stiffness,
        MOUNT_DAMPING: damping,
        **press_answers(stiffness, damping, peak),
    }


def press_as_printed() -> Answers:
    """9.34 with the mount of the print."""
    stiffness, damping = mpf(6_000_000), mpf(5_000)
    peak = peak_under_constant_force(mpf(30_000), mpf(300), stiffness, damping)
    answers = press_answers(stiffness, damping, peak)
    holds = (
        answers["limits.floor_force.value"] <= 10_000
        and answers["limits.amplitude.value"] <= mpf("0.0025")
        and peak[0] <= mpf("0.02")
    )
    return {**answers, "status": verdict(holds)}


def speeds_below(force: Real, highest: Real) -> Answers:
    """9.35: both pieces of the speeds at which the floor gets no more than `force`."""
    natural2, zeta2 = mpf(500_000) / 120, 4 * mpf("0.06") ** 2
    level2 = (force / (mpf("0.2") * natural2)) ** 2

    def excess(r2: Real) -> Real:
        """Square of the force over the limit, less one."""
        return r2**2 * (1 + zeta2 * r2) / (level2 * ((1 - r2) ** 2 + zeta2 * r2)) - 1

    brackets = ((0, 1), (1, 10), (10, 10_000))
    low, high, last = (sqrt(findroot(excess, ends, solver="anderson") * natural2) for ends in brackets)
    assert last < highest
    return {"set": [(mpf(0), low), (high, last)]}


def machine_over_speed_range() -> Answers:
    """9.36: the lowest speed decides, being the nearest to resonance."""
    mass, unbalance, zeta = mpf(200), mpf(1), mpf("0.08")
    stiffness = stiffest(mass, rpm(800), 6000 / (unbalance * rpm(800) ** 2), zeta)
    at_2000 = transmissibility(mass * rpm(2000) ** 2 / stiffness, zeta)
    return {
        MOUNT_STIFFNESS: stiffness,
        "limits.floor_force.worst_at": rpm(800),
        "measures.natural_frequency.value": sqrt(stiffness / mass),
        "measures.ratio_at_2000_rpm.value": at_2000,
    }


def ninety_percent() -> Answers:
    """9.37"""
    stiffness = stiffest(mpf(100), rpm(600), mpf("0.1"), mpf(0))
    return {MOUNT_STIFFNESS: stiffness, "measures.sag.value": 100 * GRAVITY / stiffness}


def force_of_stock_isolators(number: int) -> Real:
    """9.38: floor force on that many isolators of 1 MN/m."""
    speed = rpm(1800)
    r2 = 300 * speed**2 / (number * mpf(1_000_000))
    return 1 * speed**2 * transmissibility(r2, mpf("0.05"))


def stock_isolators() -> Answers:
    """9.38: the most isolators of the stock that still meet the limit."""
    number = max(n for n in range(1, 9) if force_of_stock_isolators(n) <= 8000)
    return {
        "variables.links.mount.count": mpf(number),
        "limits.floor_force.value": force_of_stock_isolators(number),
        "measures.natural_frequency.value": sqrt(number * mpf(1_000_000) / 300),
    }


def necessary_stiffness() -> Answers:
    """9.38: the stiffest mount, were any stiffness to be had."""
    mass, speed = mpf(300), rpm(1800)
    stiffness = stiffest(mass, speed, 8000 / speed**2, mpf("0.05"))
    return {
        MOUNT_STIFFNESS: stiffness,
        "measures.natural_frequency.value": sqrt(stiffness / mass),
    }


def two_isolators() -> Answers:
    """9.38: two isolators, which the print finds near enough."""
    force = force_of_stock_isolators(2)
    return {
        "limits.floor_force.value": force,
        "measures.natural_frequency.value": sqrt(mpf(2_000_000) / 300),
        "status": verdict(force <= 8000),
    }


def piece_of_spring() -> Answers:
    """9.38: a piece may be as stiff as any mount may be; it is a piece, for it is stiffer than the whole spring."""
    answers = necessary_stiffness()
    assert answers[MOUNT_STIFFNESS] > mpf(1_000_000)
    return {"status": "optimal", **answers}


def engine_forces(stiffness: Real) -> tuple[Real, Real]:
    """9.39: amplitudes of the two harmonics of the transmitted force, in phase above resonance."""
    first = 18_000 * stiffness / (stiffness - 500 * mpf(300) ** 2)
    second = 3_600 * stiffness / (stiffness - 500 * mpf(600) ** 2)
    return first, second


def engine_measures(stiffness: Real) -> Answers:
    """Sum, true peak over time and root sum of squares of the two harmonics."""
    first, second = engine_forces(stiffness)
    # a cos t + b cos 2t is extreme at t = 0, t = pi and, if |a| < 4 |b|, at cos t = -a / 4b
    cosines = [mpf(1), mpf(-1)]
    if abs(first) < 4 * abs(second):
        cosines.append(-first / (4 * second))
    peak = max(abs(first * c + second * (2 * c**2 - 1)) for c in cosines)
    return {
        "limits.floor_force.value": abs(first) + abs(second),
        "measures.peak_over_time.value": peak,
        "measures.root_sum_square.value": sqrt(first**2 + second**2),
    }


def engine() -> Answers:
    """9.39: 18 / (x - 1) + 3.6 / (4 x - 1) = 12 with x = r2 of the first harmonic."""
    # 48 x^2 - 135.6 x + 33.6 = 0, and isolation needs x > 1
    x = (mpf("135.6") + sqrt(mpf("135.6") ** 2 - 4 * 48 * mpf("33.6"))) / 96
    stiffness = 500 * mpf(300) ** 2 / x
    return {MOUNT_STIFFNESS: stiffness, **engine_measures(stiffness)}


def engine_as_printed() -> Answers:
    """9.39 with the mount of the print."""
    answers = engine_measures(mpf("16.0714e6"))
    return {**answers, "status": verdict(answers["limits.floor_force.value"] <= 12_000)}


def driver(wavenumber: Real, deciding: Real, other: Real) -> Answers:
    """9.40: stiffest suspension; `deciding` is the vehicle speed that governs."""
    mass, zeta, waviness = mpf(680), mpf("0.05"), mpf("0.15")
    speed = wavenumber * deciding
    stiffness = stiffest(mass, speed, 2 * GRAVITY / (waviness * speed**2), zeta)
    second = wavenumber * other
    return {
        "variables.links.suspension.stiffness": stiffness,
        "limits.comfort.worst_at": deciding,
        "measures.natural_frequency.value": sqrt(stiffness / mass),
        "measures.other_end.value": waviness * second**2 * transmissibility(mass * second**2 / stiffness, zeta),
    }


def driver_as_stated() -> Answers:
    """9.40 on the road that is stated, 0.6 rad/m."""
    return driver(mpf("0.6"), kilometres_per_hour(65), kilometres_per_hour(130))


def driver_as_printed() -> Answers:
    """9.40 on the road the print computes with, 6.7 rad/m."""
    return driver(mpf("6.7"), kilometres_per_hour(130), kilometres_per_hour(65))


def washing_machine() -> Answers:
    """9.43: the softest mount is the one that sags 5 mm."""
    mass, unbalance, speed = mpf(200), mpf("0.02"), rpm(1200)
    stiffness = mass * GRAVITY / mpf("0.005")
    amplitude = unbalance * speed**2 / abs(stiffness - mass * speed**2)
    return {
        MOUNT_STIFFNESS: stiffness,
        "measures.amplitude.value": amplitude,
        "measures.floor_force.value": amplitude * stiffness,
    }


def quarter() -> Answers:
    """9.44: the stiffest mount has r2 = 5."""
    mass, unbalance, speed = mpf(60), mpf("0.002"), rpm(3000)
    stiffness = mass * speed**2 / 5
    amplitude = unbalance * speed**2 / (mass * speed**2 - stiffness)
    return {
        MOUNT_STIFFNESS: stiffness,
        "measures.amplitude.value": amplitude,
        "measures.floor_force.value": amplitude * stiffness,
    }


def quarter_as_printed() -> Answers:
    """9.44 with the softer mount the print selects."""
    mass, unbalance, speed = mpf(60), mpf("0.002"), rpm(3000)
    stiffness = mpf("947482")
    amplitude = unbalance * speed**2 / (mass * speed**2 - stiffness)
    ratio = stiffness / (mass * speed**2 - stiffness)
    return {
        "limits.isolated.value": ratio,
        "measures.amplitude.value": amplitude,
        "measures.floor_force.value": amplitude * stiffness,
        "status": verdict(ratio <= mpf("0.25")),
    }


def reduction_from_sag() -> Answers:
    """9.45: isolation follows from the sag alone, whatever the mass."""
    r2 = rpm(3000) ** 2 * mpf("0.01") / GRAVITY
    return {"measures.reduction.value": 1 - 1 / (r2 - 1)}


def table_on_floor() -> Answers:
    """9.46: the lowest frequency decides."""
    mass, zeta = mpf(30), mpf("0.25")
    stiffness = stiffest(mass, hertz(10), mpf("0.15"), zeta)
    return {
        MOUNT_STIFFNESS: stiffness,
        "limits.isolated.worst_at": hertz(10),
        "measures.ratio_at_75_hz.value": transmissibility(mass * hertz(75) ** 2 / stiffness, zeta),
    }


def reciprocating_machine(stiffness: Real) -> Answers:
    """9.47"""
    mass, speed = mpf(1200), rpm(600)
    force = 30 * mpf("0.19") * speed**2
    return {"measures.floor_force.value": force * stiffness / abs(stiffness - mass * speed**2)}


def better_mount() -> Answers:
    """9.47: the mount of the two that passes less."""
    forces = {k: reciprocating_machine(mpf(k))["measures.floor_force.value"] for k in (1_800_000, 4_400_000)}
    best = min(forces, key=lambda k: forces[k])
    return {"status": "optimal", MOUNT_STIFFNESS: mpf(best), "goal": forces[best]}


def isolating_mount() -> Answers:
    """9.47: nothing is amplified from root two times the natural frequency on."""
    return {"status": "optimal", MOUNT_STIFFNESS: stiffest(mpf(1200), rpm(600), mpf(1), mpf(0))}


def twentieth() -> Answers:
    """9.48"""
    return {MOUNT_STIFFNESS: stiffest(mpf(1), hertz(2), mpf("0.05"), mpf(0))}


def transmissibility_curves() -> Answers:
    """9.65: peaks of the curves, and their values at three times the natural frequency."""
    natural = mpf(10)
    answers: Answers = {
        "measures.peak_0.value": INFINITE,
        "measures.peak_0.worst_at": natural,
        "measures.far_0.value": transmissibility(mpf(9), mpf(0)),
    }
    for name in ("25", "50", "75", "100"):
        zeta = mpf(name) / 100
        peak, r2 = peak_ratio(zeta)
        answers[f"measures.peak_{name}.value"] = peak
        answers[f"measures.peak_{name}.worst_at"] = natural * sqrt(r2)
        answers[f"measures.far_{name}.value"] = transmissibility(mpf(9), zeta)
    return answers


def transmissibility_table() -> Answers:
    """9.65: five curves at every hundredth of the printed points, r = 0, 0.3, ..., 3."""
    return {
        f"measures.zeta_{name}_r_{tenths}.value": transmissibility((mpf(tenths) / 10) ** 2, mpf(name) / 100)
        for name in ("0", "25", "50", "75", "100")
        for tenths in range(0, 31, 3)
    }


ROUTES: dict[str, Callable[[], Answers]] = {
    "rao_9_1": car_on_wavy_road,
    "rao_9_1_speeds": quiet_car_speeds,
    "rao_9_1_other_springs": stiffer_car,
    "rao_9_1_dead_weight": heavier_car,
    "rao_9_1_any_weight": ever_heavier_car,
    "rao_9_1_shock_absorbers": damped_car,
    "rao_9_2": rms_of_a_harmonic,
    "rao_9_26_a": lambda: free_machine(mpf(100), mpf(1)),
    "rao_9_26_b": fixed_machine,
    "rao_9_26_a_heavy": lambda: free_machine(mpf(10) ** 7, mpf(10) ** 6),
    "rao_9_26_a_rotor_alone": lambda: free_machine(mpf("2.5"), mpf(1)),
    "rao_9_27": instrument_on_panel,
    "rao_9_28": fan_through_resonance,
    "rao_9_28_at_resonance": fan_at_resonance,
    "rao_9_28_printed_design": fan_as_printed,
    "rao_9_29_undamped": lambda: compressor(mpf(0)),
    "rao_9_29_damped": lambda: compressor(mpf("0.1")),
    "rao_9_29_undamped_force_held": lambda: compressor_held(mpf(0)),
    "rao_9_29_damped_force_held": lambda: compressor_held(mpf("0.1")),
    "rao_9_29_preferred_by_amplitude": preferred_by_amplitude,
    "rao_9_29_preferred_by_sag": preferred_by_sag,
    "rao_9_30_a": speeds_that_amplify,
    "rao_9_30_b": speeds_that_isolate,
    "rao_9_31": sixty_percent,
    "rao_9_32": seventy_five_percent,
    "rao_9_33": undamped_fan,
    "rao_9_34": press_constant_force,
    "rao_9_34_most_room": press_with_most_room,
    "rao_9_34_speed_squared": press_speed_squared,
    "rao_9_34_printed_design": press_as_printed,
    "rao_9_35": lambda: speeds_below(mpf(2500), rpm(20_000)),
    "rao_9_35_printed_limit": lambda: speeds_below(2500 * sqrt(mpf(8)) / 3, rpm(20_000)),
    "rao_9_36": machine_over_speed_range,
    "rao_9_37": ninety_percent,
    "rao_9_38": stock_isolators,
    "rao_9_38_necessary_stiffness": necessary_stiffness,
    "rao_9_38_two_isolators": two_isolators,
    "rao_9_38_cut_spring": piece_of_spring,
    "rao_9_38_half_spring": two_isolators,
    "rao_9_39": engine,
    "rao_9_39_printed_design": engine_as_printed,
    "rao_9_40": driver_as_stated,
    "rao_9_40_printed_road": driver_as_printed,
    "rao_9_43": washing_machine,
    "rao_9_44": quarter,
    "rao_9_44_printed_design": quarter_as_printed,
    "rao_9_45": reduction_from_sag,
    "rao_9_46": table_on_floor,
    "rao_9_47_a": lambda: reciprocating_machine(mpf(1_800_000)),
    "rao_9_47_b": lambda: reciprocating_machine(mpf(4_400_000)),
    "rao_9_47_better_mount": better_mount,
    "rao_9_47_permitted_mounts": isolating_mount,
    "rao_9_48": twentieth,
    "rao_9_65": transmissibility_curves,
    "rao_9_65_table": transmissibility_table,
}
