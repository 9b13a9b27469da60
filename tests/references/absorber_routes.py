"""Absorber problems and absorber theory solved without vibopt.

Every problem is worked out from the masses and springs themselves, with 40 digits, and where there is
a second way (eigenvalues against a closed form, one choice of coordinates against another) both are
taken and have to agree. All results are in SI units: m, kg, N, N/m, rad/s, kg m^2, N m/rad.

Symbols: mu = absorber mass / main mass, f = absorber frequency / main frequency,
zeta = c / (2 m2 omega2) of the absorber, zeta1 = c1 / (2 m1 omega1) of the main system,
d = c / (m2 omega1) = 2 zeta f, x = (frequency / main frequency)^2.
Responses are of the main mass over its static deflection, under a force of constant amplitude,
unless a function says otherwise.
"""

from collections.abc import Callable
from functools import cache
from typing import Any

from mpmath import cos, diff, eig, expm, findroot, lu_solve, matrix, mp, mpc, mpf, pi, sin, sqrt

mp.dps = 40

Real = Any  # mpmath's real number, which has no static type
Answers = dict[str, Any]  # numbers, lists of numbers, lists of intervals

GRAVITY = mpf("9.80665")
SAME = mpf(10) ** -30
"""Relative difference at which two routes count as one."""


# --- small tools -----------------------------------------------------------------------------


def rpm(speed: float | str) -> Real:
    """Angular speed in rad/s."""
    return mpf(speed) * 2 * pi / 60


def agreed(first: Real, second: Real) -> Real:
    """The first of two numbers found by two routes; the routes have to agree."""
    if abs(first - second) > SAME * max(abs(first), abs(second), SAME):
        raise ArithmeticError(f"two routes differ: {first} and {second}")
    return first


def eigenfrequencies(masses: Any, stiffnesses: Any) -> list[Real]:
    """Natural frequencies of M x'' + K x = 0, rising, by eigenvalues."""
    values, _ = eig(lu_solve_matrix(masses, stiffnesses))
    return sorted(sqrt(abs(value.real if isinstance(value, mpc) else value)) for value in values)


def lu_solve_matrix(left: Any, right: Any) -> Any:
    """left^-1 right, column by column."""
    solution = matrix(left.rows, right.cols)
    for column in range(right.cols):
        solution[:, column] = lu_solve(left, right[:, column])
    return solution


def with_absorber(m1: Real, k1: Real, m2: Real, k2: Real) -> list[Real]:
    """Both natural frequencies of a sprung mass with an absorber: eigenvalues and the quadratic."""
    half = ((k1 + k2) / m1 + k2 / m2) / 2
    spread = sqrt(half**2 - k1 * k2 / (m1 * m2))
    low, high = eigenfrequencies(matrix([[m1, 0], [0, m2]]), matrix([[k1 + k2, -k2], [-k2, k2]]))
    return [agreed(sqrt(half - spread), low), agreed(sqrt(half + spread), high)]


def amplitudes(m1: Real, k1: Real, m2: Real, k2: Real, speed: Real, force: Real = 1) -> tuple[Real, Real]:
    """Signed amplitudes of main mass and absorber under a harmonic force on the main mass."""
    dynamic = matrix([[k1 + k2 - m1 * speed**2, -k2], [-k2, k2 - m2 * speed**2]])
    motion = lu_solve(dynamic, matrix([force, 0]))
    return motion[0], motion[1]


# --- natural frequencies out of a band -------------------------------------------------------


def tuned_ratio(r: Real) -> Real:
    """Mass ratio of the absorber tuned to the main system that puts a frequency at r times it."""
    return r**2 + 1 / r**2 - 2


def band_tuned(m1: Real, main: Real, low: Real, high: Real) -> Answers:
    """Least absorber tuned to the main system with no natural frequency between low and high."""
    m2 = m1 * max(tuned_ratio(low / main), tuned_ratio(high / main))
    k2 = m2 * main**2
    return {"mass": m2, "stiffness": k2, "frequencies": with_absorber(m1, m1 * main**2, m2, k2)}


def band_free(m1: Real, main: Real, low: Real, high: Real) -> Answers:
    """Least absorber of any tuning with no natural frequency between low and high.

    Each end of the band asks for a least mass ratio, the lower end one that rises with the absorber's
    frequency and the upper end one that falls, so the least mass has a natural frequency on both ends.
    """
    a, b, w1 = low**2, high**2, main**2
    w2 = a * b / w1
    mu = w1 * (a + b - w1) / (a * b) - 1
    root = findroot(lambda w: asked_by_end(w1, w, a) - asked_by_end(w1, w, b), (w2 * mpf("0.9"), w2 * mpf("1.1")))
    agreed(w2, root)
    agreed(mu, asked_by_end(w1, w2, b))
    m2 = mu * m1
    frequencies = with_absorber(m1, m1 * w1, m2, m2 * w2)
    agreed(frequencies[0], low)
    agreed(frequencies[1], high)
    return {"mass": m2, "stiffness": m2 * w2, "tuning": sqrt(w2), "frequencies": frequencies}


def asked_by_end(w1: Real, w2: Real, end: Real) -> Real:
    """Mass ratio that puts a natural frequency at an end of the band; squares of frequencies."""
    return (end - w1) * (end - w2) / (w2 * end)


def both_bands(m1: Real, main: Real, low: Real, high: Real) -> Answers:
    """Least absorber, tuned and of any tuning, with dotted names."""
    answers = {f"tuned.{name}": value for name, value in band_tuned(m1, main, low, high).items()}
    return answers | {f"free.{name}": value for name, value in band_free(m1, main, low, high).items()}


# --- problems of the chapter -----------------------------------------------------------------


def compressor_band() -> Answers:
    """9.51: 200 kg at 1200 rpm, natural frequencies 20 % away."""
    speed = rpm(1200)
    bands = both_bands(mpf(200), speed, speed * mpf("0.8"), speed * mpf("1.2"))
    return bands | {
        "main.stiffness": 200 * speed**2,
        "ratio_of_lower_end": tuned_ratio(mpf("0.8")),
        "ratio_of_upper_end": tuned_ratio(mpf("1.2")),
    }


def motor_on_cantilever() -> Answers:
    """9.52: 300 kg at 1500 rpm, the lower natural frequency at three quarters of the speed."""
    speed, unbalance = rpm(1500), mpf("0.02")
    absorber = band_tuned(mpf(300), speed, speed * mpf("0.75"), speed / mpf("0.75"))
    agreed(absorber["mass"], band_free(mpf(300), speed, speed * mpf("0.75"), speed / mpf("0.75"))["mass"])
    moved = amplitudes(mpf(300), 300 * speed**2, absorber["mass"], absorber["stiffness"], speed, unbalance * speed**2)
    return absorber | {
        "ratio": absorber["mass"] / 300,
        "main.stiffness": 300 * speed**2,
        "main.amplitude": abs(moved[0]),
        "absorber.amplitude": agreed(-moved[1], unbalance / absorber["mass"]),
    }


def pipe_as_tuned_trial() -> Answers:
    """9.53 as the print reads it: the trial kilogram tuned at 800 rpm, its upper frequency left unused."""
    return pipe(1 / tuned_ratio(mpf(750) / 800))


def pipe_with_both_frequencies() -> Answers:
    """9.53 with both frequencies of the trial, the pipe natural at 800 rpm: the trial is at 937.5 rpm."""
    main, low, high = mpf(800) ** 2, mpf(750) ** 2, mpf(1000) ** 2
    trial = low * high / main
    ratio = (low + high - main) / trial - 1
    frequencies = with_absorber(1 / ratio, main / ratio, mpf(1), trial)
    agreed(frequencies[0], mpf(750))
    agreed(frequencies[1], mpf(1000))
    return pipe(1 / ratio) | {"trial.tuning": rpm("937.5"), "trial.stiffness": trial * rpm(1) ** 2}


def pipe(mass: Real) -> Answers:
    """9.53: natural frequencies out of 700 to 1040 rpm."""
    low_end_only = mass * tuned_ratio(mpf(700) / 800)
    upper = with_absorber(mass, mass * rpm(800) ** 2, low_end_only, low_end_only * rpm(800) ** 2)[1]
    return both_bands(mass, rpm(800), rpm(700), rpm(1040)) | {
        "main.mass": mass,
        "main.stiffness": mass * rpm(800) ** 2,
        "printed_rule.mass": low_end_only,
        "printed_rule.upper_frequency": upper,
    }


def floor() -> Answers:
    """9.54: 900 kg at 600 rpm, an absorber on 900 kN/m."""
    speed = rpm(600)
    mass = mpf(900_000) / speed**2
    frequencies = with_absorber(mpf(900), 900 * speed**2, mass, mpf(900_000))
    return {
        "main.stiffness": 900 * speed**2,
        "mass": mass,
        "weight": mass * GRAVITY,
        "ratio": mass / 900,
        "frequencies": frequencies,
    }


def floor_band() -> Answers:
    """9.55: the same floor, natural frequencies 30 % away."""
    speed = rpm(600)
    bands = both_bands(mpf(900), speed, speed * mpf("0.7"), speed * mpf("1.3"))
    return bands | {"weight": bands["tuned.mass"] * GRAVITY}


def torsional_absorber(length: float | str = "0.75") -> Answers:
    """9.56: a disc on a hollow shaft, outer over inner diameter 4/3, tuned to another such disc."""
    modulus = mpf(80) * 10**9
    first = pi * modulus / (32 * mpf("0.75")) * (mpf("0.05") ** 4 - mpf("0.038") ** 4)
    inertia, added = 45 * mpf("0.38") ** 2 / 8, 9 * mpf("0.15") ** 2 / 8
    stiffness = added * first / inertia
    per_fourth_power = pi * modulus / (32 * mpf(length)) * ((mpf(4) / 3) ** 4 - 1)
    inner = (stiffness / per_fourth_power) ** (mpf(1) / 4)
    polar = pi * ((inner * 4 / 3) ** 4 - inner**4) / 32
    agreed(stiffness, modulus * polar / mpf(length))
    return {
        "main.stiffness": first,
        "main.inertia": inertia,
        "main.frequency": sqrt(first / inertia),
        "inertia": added,
        "stiffness": stiffness,
        "inner": inner,
        "outer": inner * 4 / 3,
        "frequencies": with_absorber(inertia, first, added, stiffness),
    }


def rotor_band() -> Answers:
    """9.57: 15 kg m^2 on 0.6 MN m/rad; what the print chose, and the least 20 % away."""
    main = sqrt(mpf(600_000) / 15)
    chosen = band_tuned(mpf(15), main, main * mpf("0.75"), main / mpf("0.75"))
    return both_bands(mpf(15), main, main * mpf("0.8"), main * mpf("1.2")) | {
        "main.frequency": main,
        "printed_rule.inertia": chosen["mass"],
        "printed_rule.stiffness": chosen["stiffness"],
        "printed_rule.frequencies": chosen["frequencies"],
    }


def table_of_ratios() -> Answers:
    """9.58: both frequency ratios of a tuned absorber at mass ratios 0.1 to 1."""
    ratios = [mpf(step) / 10 for step in range(1, 11)]
    pairs = [with_absorber(mpf(1), mpf(1), mu, mu) for mu in ratios]
    for low, high in pairs:
        agreed(low * high, mpf(1))
    return {"ratios": ratios, "low": [pair[0] for pair in pairs], "high": [pair[1] for pair in pairs]}


def operating_range() -> Answers:
    """9.59: frequencies at which a tuned tenth holds the main mass to half its static deflection."""
    upper = sqrt((mpf("0.1") + sqrt(mpf("4.01"))) / 2)
    lower, above = (sqrt((mpf("4.1") + sign * sqrt(mpf("4.81"))) / 2) for sign in (-1, 1))
    for end, sign in ((lower, -1), (upper, 1), (above, -1)):
        agreed(amplitudes(mpf(1), mpf(1), mpf("0.1"), mpf("0.1"), end)[0], sign * mpf("0.5"))
    return {
        "set": [(lower, upper), (above, mp.inf)],
        "resonances": with_absorber(mpf(1), mpf(1), mpf("0.1"), mpf("0.1")),
    }


def stroke() -> Answers:
    """9.60: 30 kg tuned to 40 kg on 0.1 MN/m, 300 N at the resonance."""
    speed = sqrt(mpf(100_000) / 40)
    stiffness = 30 * speed**2
    main, absorber = amplitudes(mpf(40), mpf(100_000), mpf(30), stiffness, speed, mpf(300))
    return {
        "main.frequency": speed,
        "stiffness": stiffness,
        "main.amplitude": main,
        "absorber.amplitude": agreed(absorber, -300 / stiffness),
        "frequencies": with_absorber(mpf(40), mpf(100_000), mpf(30), stiffness),
    }


def clamped_beam_stiffness(modulus: Real, inertia: Real, a: Real, b: Real) -> Real:
    """Stiffness of a beam built in at both ends at a distance a from one and b from the other."""
    length = a + b
    closed = 3 * modulus * inertia * length**3 / (a**3 * b**3)
    halves = [[12 / s**3, turn * 6 / s**2, 4 / s] for s, turn in ((a, -1), (b, 1))]
    own, cross, turning = (modulus * inertia * (left + right) for left, right in zip(*halves, strict=True))
    return agreed(closed, own - cross**2 / turning)


def motor_on_beam(mass: float | str = "5") -> Answers:
    """9.61: 20 kg at 1350 rpm on a clamped beam; a mass of 5 kg is the least with a stroke of 2 cm."""
    speed, m2, unbalance = rpm(1350), mpf(mass), mpf("0.1")
    inertia = mpf("0.15") * mpf("0.012") ** 3 / 12
    k1 = clamped_beam_stiffness(mpf(207) * 10**9, inertia, mpf(1), mpf("0.5"))
    k2 = m2 * speed**2
    main, absorber = amplitudes(mpf(20), k1, m2, k2, speed, unbalance * speed**2)
    return {
        "main.stiffness": k1,
        "main.frequency": sqrt(k1 / 20),
        "mass": m2,
        "stiffness": k2,
        "main.amplitude": abs(main),
        "absorber.amplitude": agreed(-absorber, unbalance / m2),
        "frequencies": with_absorber(mpf(20), k1, m2, k2),
    }


def bridge() -> Answers:
    """9.62: 10 kg on a bridge of 15 t, without damping as printed, and with the best damper."""
    m1, k1, m2, force = mpf(15_000), mpf(2_000_000), mpf(10), mpf(600)
    main = sqrt(k1 / m1)
    best = nishihara_asami(m2 / m1)
    undamped = amplitudes(m1, k1, m2, m2 * main**2, main, force)
    return {
        "main.frequency": main,
        "undamped.stiffness": m2 * main**2,
        "undamped.main.amplitude": undamped[0],
        "undamped.absorber.amplitude": -undamped[1],
        "undamped.frequencies": with_absorber(m1, k1, m2, m2 * main**2),
        "damped.stiffness": m2 * (best["tuning"] * main) ** 2,
        "damped.damping": 2 * best["zeta"] * m2 * best["tuning"] * main,
        "damped.peak": best["peak"] * force / k1,
        "static": force / k1,
    }


def motor_off_resonance() -> Answers:
    """9.63: 5 kg against 80 rad/s; the frequencies are those on a main mass of 50 kg at 100 rad/s."""
    stiffness = 5 * mpf(80) ** 2
    agreed(1 + amplitudes(mpf(50), mpf(500_000), mpf(5), stiffness, mpf(80))[0], mpf(1))
    return {"stiffness": stiffness, "frequencies": with_absorber(mpf(50), mpf(500_000), mpf(5), stiffness)}


def pulley_absorber(speed: Real | None = None) -> Answers:
    """9.64 with data of our own: a pulley with a hung mass on two springs holds a damped mass at rest."""
    m, c, k, K1, K2, R, inertia, force = (mpf(v) for v in ("10", "20", "4000", "3000", "1000", "0.1", "0.04", "50"))
    quiet = sqrt(R**2 * (K1 + K2) / inertia)
    omega = quiet if speed is None else speed
    main = k + K2 - m * omega**2 + mpc(0, 1) * omega * c
    turning = R**2 * (K1 + K2) - inertia * omega**2
    motion = lu_solve(matrix([[main, -K2 * R], [-K2 * R, turning]]), matrix([force, 0]))
    closed = turning * force / (main * turning - (K2 * R) ** 2)
    agreed(1 + abs(motion[0]), 1 + abs(closed))
    printed_turn = K2 * R * force / ((m * omega**2 + k + K2 + mpc(0, 1) * omega * c) * turning - (K2 * R) ** 2)
    return {
        "quiet_at": quiet,
        "main.amplitude": abs(motion[0]),
        "pulley.angle": abs(motion[1]),
        "pulley.angle_as_printed": abs(printed_turn),
    }


def damped_curves() -> Answers:
    """9.66: greatest main and absorber motion at f = 1, zeta in c / (2 m2 omega1), over static deflection."""
    cases = [(zeta, mu) for zeta in ("0.2", "0.3", "0.4") for mu in ("0.2", "0.5")]
    keyed_instead = ("0.5", "0.1")
    answers: Answers = {}
    for zeta, mu in [*cases, keyed_instead]:
        system = System(mpf(mu), mpf(1), 2 * mpf(zeta))
        peaks = {"main": system.peak(), "absorber": system.peak(motion="absorber")}
        for name, (height, x) in peaks.items():
            answers |= {f"{name}.peak({zeta}, {mu})": height, f"{name}.at({zeta}, {mu})": sqrt(x)}
    return answers


def stiff_absorbers() -> Answers:
    """9.67: natural frequencies over the absorber's, absorber at 1.5, 3 and 4.5 times the main system."""
    answers: Answers = {}
    for ratio in ("1.5", "3", "4.5"):
        q2 = mpf(ratio) ** 2
        for mu in ("0", "0.25", "0.5", "0.75", "1"):
            half = 1 + (1 + mpf(mu)) * q2
            pair = [sqrt((half + sign * sqrt(half**2 - 4 * q2)) / (2 * q2)) for sign in (-1, 1)]
            if mpf(mu) > 0:
                built = with_absorber(mpf(1), mpf(1), mpf(mu), mpf(mu) * q2)
                pair = [agreed(one, other / mpf(ratio)) for one, other in zip(pair, built, strict=True)]
            answers |= {f"low({ratio}, {mu})": pair[0], f"high({ratio}, {mu})": pair[1]}
    return answers


def response_table() -> Answers:
    """9.71: a twentieth tuned to the main system, zeta in c / (2 m2 omega1): 0, 0.1 and 10 (for infinity)."""
    answers: Answers = {}
    for zeta in ("0", "0.1", "10"):
        system = System(mpf("0.05"), mpf(1), 2 * mpf(zeta))
        for g in [f"{tenths / 10:.1f}" for tenths in range(5, 20)]:
            answers[f"main({zeta}, {g})"] = system.height(mpf(g) ** 2)
            answers[f"absorber({zeta}, {g})"] = system.height(mpf(g) ** 2, motion="absorber")
    return answers


# --- the assignment --------------------------------------------------------------------------


def two_masses() -> Answers:
    """Assignment 4 a with data of our own: frequencies, mode ratios, phases of a free motion."""
    m1, m2, k1, k2 = mpf(4), mpf(1), mpf(1200), mpf(300)
    frequencies = with_absorber(m1, k1, m2, k2)
    r1, r2 = ((k1 + k2 - m1 * w**2) / k2 for w in frequencies)
    agreed(r1, k2 / (k2 - m2 * frequencies[0] ** 2))
    agreed(r1 * r2, -m1 / m2)
    start, speed = (mpf("0.01"), mpf("-0.02")), (mpf("0.3"), mpf("0.1"))
    phases, sizes = free_motion(frequencies, (r1, r2), start, speed)
    answers = {"frequencies": frequencies, "mode_ratios": [r1, r2], "phases": phases, "sizes": sizes}
    check_free_motion(matrix([[m1, 0], [0, m2]]), matrix([[k1 + k2, -k2], [-k2, k2]]), answers, start, speed)
    return answers | {"printed.discriminant": ((k1 + k2) / m1) ** 2 - 4 * k1 * k2 / (m1 * m2)}


def free_motion(w: list[Real], r: tuple[Real, Real], x: tuple[Real, Real], v: tuple[Real, Real]) -> tuple[Any, Any]:
    """Phases and sizes of both modes in x1 = sum A cos(w t + phase)."""
    phases, sizes = [], []
    for own, other, frequency in ((r[0], r[1], w[0]), (r[1], r[0], w[1])):
        along = (other * x[0] - x[1]) / (other - own)
        across = (-other * v[0] + v[1]) / (frequency * (other - own))
        phases.append(mp.atan2(across, along))
        sizes.append(sqrt(along**2 + across**2))
    return phases, sizes


def check_free_motion(masses: Any, springs: Any, found: Answers, x: tuple[Real, Real], v: tuple[Real, Real]) -> None:
    """The sum of both modes against the matrix exponential, 0.4 s after the start."""
    time = mpf("0.4")
    system = matrix(4, 4)
    system[0, 2] = system[1, 3] = 1
    system[2:4, 0:2] = -lu_solve_matrix(masses, springs)
    state = expm(system * time) * matrix([*x, *v])
    modes = list(zip(found["frequencies"], found["sizes"], found["phases"], found["mode_ratios"], strict=True))
    agreed(state[0], sum(size * cos(w * time + phase) for w, size, phase, _ in modes))
    agreed(state[1], sum(ratio * size * cos(w * time + phase) for w, size, phase, ratio in modes))
    agreed(state[2], sum(-w * size * sin(w * time + phase) for w, size, phase, _ in modes))


def hanging_pendulum() -> Answers:
    """Assignment 4 b with data of our own: a mass between two springs with a pendulum hung from it.

    The second equation, lost in the print, is l theta'' + x1'' + g theta = 0. In the bob's own motion
    x2 = x1 + l theta the pendulum is an absorber of mass m2 on a spring of m2 g / l.
    """
    m1, m2, k, length = mpf(8), mpf(2), mpf(200) + 200, mpf("0.3")
    masses = matrix([[m1 + m2, m2 * length], [m2 * length, m2 * length**2]])
    frequencies = eigenfrequencies(masses, matrix([[k, 0], [0, m2 * GRAVITY * length]]))
    absorber = with_absorber(m1, k, m2, m2 * GRAVITY / length)
    for one, other in zip(frequencies, absorber, strict=True):
        agreed(one, other)
        w = one**2
        agreed(m1 * length * w**2 + k * GRAVITY, ((m1 + m2) * GRAVITY + k * length) * w)
    return {"frequencies": frequencies, "quiet_at": sqrt(GRAVITY / length)}


# --- one absorber on one mass, in ratios -----------------------------------------------------


class System:
    """A main mass with one absorber; d = c / (m2 omega1) = 2 zeta f."""

    def __init__(self, mu: Real, f: Real, d: Real, zeta1: Real = 0) -> None:
        self.mu, self.f, self.d, self.zeta1 = mpf(mu), mpf(f), mpf(d), mpf(zeta1)

    def polynomials(self, motion: str = "main") -> tuple[list[Real], list[Real]]:
        """Numerator and denominator of the squared height in x, highest power first."""
        F, d, mu, own = self.f**2, self.d, self.mu, 2 * self.zeta1
        above = [1, d**2 - 2 * F, F**2] if motion == "main" else [0, d**2, F**2]
        middle = 1 + F * (1 + mu) + own * d
        odd, first = d * (1 + mu) + own, d + own * F
        below = [1, odd**2 - 2 * middle, middle**2 + 2 * F - 2 * odd * first, first**2 - 2 * middle * F, F**2]
        return [mpf(c) for c in above], [mpf(c) for c in below]

    def height(self, x: Real, motion: str = "main") -> Real:
        """Amplitude over static deflection, from the dynamic stiffness matrix."""
        omega, i = sqrt(mpf(x)), mpc(0, 1)
        link = self.mu * (self.f**2 + i * omega * self.d)
        main = 1 - x + 2 * i * omega * self.zeta1 + link
        determinant = main * (link - self.mu * x) - link**2
        return abs((link - self.mu * x if motion == "main" else link) / determinant)

    def peak(self, motion: str = "main") -> tuple[Real, Real]:
        """Greatest height over all frequencies and the x at which it stands."""
        above, below = self.polynomials(motion)
        rise, fall = product(derivative(above), below), product(above, derivative(below))
        slope = [p - q for p, q in zip(rise, fall, strict=True)]
        places = [r.real for r in roots(slope) if abs(r.imag) < mpf(10) ** -15 and r.real > mpf(10) ** -9]
        heights = [(mpf(1), mpf(0)), *((self.height(x, motion), x) for x in places)]
        return max(heights)

    def white_noise(self) -> Real:
        """Integral of the squared height over all frequency ratios, both signs."""
        F, d, own = self.f**2, self.d, 2 * self.zeta1
        a1, a2, a3 = d + own * F, 1 + F * (1 + self.mu) + own * d, d * (1 + self.mu) + own
        numerator = a1 + (d**2 - 2 * F) * a3 + F * (a2 * a3 - a1)
        return pi * numerator / (a1 * a2 * a3 - a1**2 - F * a3**2)

    def decay(self) -> Real:
        """Slowest decay rate over the main frequency."""
        F, d, own = self.f**2, self.d, 2 * self.zeta1
        characteristic = [mpf(1), d * (1 + self.mu) + own, 1 + F * (1 + self.mu) + own * d, d + own * F, F]
        return min(-root.real for root in roots(characteristic))


def roots(p: list[Real]) -> list[Real]:
    """Complex roots of a polynomial, highest power first, as eigenvalues of its companion matrix."""
    while p[0] == 0:
        p = p[1:]
    size = len(p) - 1
    companion = matrix(size, size)
    for column in range(size):
        companion[0, column] = -p[column + 1] / p[0]
        if column:
            companion[column, column - 1] = 1
    values, _ = eig(companion)
    return [mpc(value) for value in values]


def value(p: list[Real], x: Real) -> Real:
    """A polynomial, highest power first, at one place."""
    total = mpf(0)
    for coefficient in p:
        total = total * x + coefficient
    return total


def product(p: list[Real], q: list[Real]) -> list[Real]:
    """Product of two polynomials, highest power first."""
    result = [mpf(0)] * (len(p) + len(q) - 1)
    for i, one in enumerate(p):
        for j, other in enumerate(q):
            result[i + j] += one * other
    return result


def derivative(p: list[Real]) -> list[Real]:
    """Derivative of a polynomial, highest power first."""
    return [c * (len(p) - 1 - i) for i, c in enumerate(p[:-1])]


def damped(mu: Real, tuning: Real, zeta: Real, zeta1: Real = 0) -> System:
    """The system with the absorber's damping given as zeta = c / (2 m2 omega2)."""
    return System(mu, tuning, 2 * mpf(zeta) * tuning, zeta1)


# --- least greatest height -------------------------------------------------------------------


def den_hartog(mu: float | str | Real) -> Answers:
    """Fixed points at one height, and the damping that all but puts the peaks there.

    The tuning is exact for equal fixed points. The damping is the mean of the squares of the two that
    put one peak on a fixed point, so the true peak stands a little above `fixed_height`.
    """
    mu = mpf(mu)
    tuning, zeta = 1 / (1 + mu), sqrt(3 * mu / (8 * (1 + mu)))
    spread = sqrt(mu / (2 + mu))
    return {
        "tuning": tuning,
        "zeta": zeta,
        "fixed_points": [(1 - spread) / (1 + mu), (1 + spread) / (1 + mu)],
        "fixed_height": sqrt(1 + 2 / mu),
        "peak": damped(mu, tuning, zeta).peak()[0],
    }


def nishihara_asami(mu: float | str | Real) -> Answers:
    """The exact optimum on an undamped main mass, in closed form."""
    mu = mpf(mu)
    root = sqrt(4 + 3 * mu)
    squared = 2 * (16 + 23 * mu + 9 * mu**2 + 2 * (2 + mu) * root) / (3 * (64 + 80 * mu + 27 * mu**2))
    squared_peak = ((8 + 9 * mu) ** 2 * (16 + 9 * mu) - 128 * root**3) / (3 * (32 + 27 * mu))
    return {
        "tuning": 2 / (1 + mu) * sqrt(squared),
        "zeta": sqrt((8 + 9 * mu - 4 * root) / (1 + mu)) / 4,
        "peak": sqrt(squared_peak) / (3 * mu),
    }


FIRST_ORDERS = ((1, 0, 0), (0, 1, 0), (0, 0, 1))


def log_height(x: Real, F: Real, d: Real, mu: Real, zeta1: Real) -> Real:
    """Logarithm of the squared height."""
    above, below = System(mu, sqrt(F), d, zeta1).polynomials()
    return mp.log(value(above, x) / value(below, x))


def conditions(mu: Real, zeta1: Real) -> Callable[..., list[Real]]:
    """What holds at the optimum: two peaks, equal, no step in (F, d) lowers both."""

    def height(x: Real, F: Real, d: Real) -> Real:
        return log_height(x, F, d, mu, zeta1)

    def residuals(F: Real, d: Real, x1: Real, x2: Real) -> list[Real]:
        first, second = ([diff(height, (x, F, d), order) for order in FIRST_ORDERS] for x in (x1, x2))
        turn = first[1] * second[2] - first[2] * second[1]
        return [height(x1, F, d) - height(x2, F, d), first[0], second[0], turn]

    return residuals


def h_infinity(mu: float | str | Real, zeta1: float | str | Real = 0) -> Answers:
    """The exact optimum, the main mass damped or not, by Newton's method on its conditions."""
    return dict(solved(mpf(mu), mpf(zeta1)))


@cache
def solved(mu: Real, zeta1: Real) -> Answers:
    """`h_infinity`, kept; from an undamped main mass to the asked damping in steps."""
    first = den_hartog(mu)
    guess = [first["tuning"] ** 2, 2 * first["zeta"] * first["tuning"], *first["fixed_points"]]
    steps = max(1, int(zeta1 * 40))
    with mp.workdps(20):
        for step in range(steps + 1):
            guess = list(findroot(conditions(mu, zeta1 * step / steps), guess, tol=mpf(10) ** -24))
    with mp.workdps(60):
        F, d, x1, x2 = findroot(conditions(mu, zeta1), guess, tol=mpf(10) ** -70)
    system = System(mu, sqrt(F), d, zeta1)
    return {
        "tuning": +sqrt(F),
        "zeta": d / (2 * sqrt(F)),
        "peak": agreed(system.height(x1), system.peak()[0]),
        "peaks_at": [+x1, +x2],
    }


def certificate(mu: float | str | Real, zeta1: float | str | Real = 0) -> Answers:
    """Proof that no absorber at all has a lower peak than `h_infinity`.

    At one frequency, g = |denominator|^2 - |numerator|^2 / peak^2 is a quadratic in (F, d) and is
    positive exactly where the height is below the peak. A sum of g at the two peaks with positive
    weights is stationary at the optimum, where it is zero; its second derivatives (there is no mixed
    one) are returned. Not above zero, they leave the sum nowhere positive: every absorber is at least
    as high as the peak at one of the two frequencies.
    """
    mu, zeta1 = mpf(mu), mpf(zeta1)
    best = h_infinity(mu, zeta1)
    F, d = best["tuning"] ** 2, 2 * best["zeta"] * best["tuning"]
    forms = [quadratic(x, mu, zeta1, best["peak"]) for x in best["peaks_at"]]
    slopes = [(curve * 2 * F + along, curve * x * 2 * d + across) for curve, along, across, x in forms]
    weights = [abs(slopes[1][0]), abs(slopes[0][0])]
    return {
        "weights": weights,
        "slope_in_F": sum(w * s[0] for w, s in zip(weights, slopes, strict=True)),
        "slope_in_d": sum(w * s[1] for w, s in zip(weights, slopes, strict=True)),
        "curvature_in_F": sum(w * form[0] for w, form in zip(weights, forms, strict=True)),
        "curvature_in_d": sum(w * form[0] * form[3] for w, form in zip(weights, forms, strict=True)),
    }


def quadratic(x: Real, mu: Real, zeta1: Real, peak: Real) -> tuple[Real, Real, Real, Real]:
    """g = curve (F^2 + x d^2) + along F + across d + constant; returns curve, along, across, x."""
    omega, q = sqrt(x), 1 / peak**2
    main = 1 - x + 2 * mpc(0, 1) * omega * zeta1
    locked = main - mu * x
    cross = locked * main.conjugate()
    return abs(locked) ** 2 - q, -2 * x * (cross.real - q), 2 * x * omega * cross.imag, x


def lanchester(mu: float | str | Real) -> Answers:
    """The best absorber without a spring: damping c / (2 m2 omega1), its peak and where it stands."""
    mu = mpf(mu)
    zeta = 1 / sqrt(2 * (2 + mu) * (1 + mu))
    height = System(mu, mpf(0), 2 * zeta).height(2 / (2 + mu))
    return {"zeta": zeta, "peak": agreed(height, 1 + 2 / mu), "peak_at": 2 / (2 + mu)}


# --- least mean square and fastest decay -----------------------------------------------------


def least_mean_square(mu: float | str | Real) -> Answers:
    """White noise on an undamped main mass: `integral` of the squared height over both signs.

    The mean square of the motion is `integral` S0 omega1 / k1^2 for a two-sided density S0 of the
    force per rad/s.
    """
    mu = mpf(mu)
    tuning = sqrt((2 + mu) / 2) / (1 + mu)
    zeta = sqrt(mu * (4 + 3 * mu) / (8 * (1 + mu) * (2 + mu)))
    integral = pi * sqrt((4 + 3 * mu) / (mu * (1 + mu)))
    return {"tuning": tuning, "zeta": zeta, "integral": agreed(integral, damped(mu, tuning, zeta).white_noise())}


def least_mean_square_damped(mu: float | str | Real, zeta1: float | str | Real) -> Answers:
    """The same on a damped main mass, by Newton's method on both slopes."""
    mu, zeta1 = mpf(mu), mpf(zeta1)

    def slopes(f: Real, zeta: Real) -> list[Real]:
        return [diff(lambda *p: damped(mu, p[0], p[1], zeta1).white_noise(), (f, zeta), n) for n in ((1, 0), (0, 1))]

    first = least_mean_square(mu)
    tuning, zeta = findroot(slopes, (first["tuning"], first["zeta"]), tol=mpf(10) ** -50)
    return {"tuning": tuning, "zeta": zeta, "integral": damped(mu, tuning, zeta, zeta1).white_noise()}


def fastest_decay(mu: float | str | Real) -> Answers:
    """Undamped main mass, mu < 4: all modes decay alike, at `decay` times the main frequency."""
    mu = mpf(mu)
    tuning, zeta, decay = 1 / (1 + mu), sqrt(mu / (1 + mu)), sqrt(mu / (1 + mu)) / 2
    square = product([mpf(1), 2 * decay, tuning], [mpf(1), 2 * decay, tuning])
    d = 2 * zeta * tuning
    for one, other in zip(square, [1, d * (1 + mu), 1 + tuning**2 * (1 + mu), d, tuning**2], strict=True):
        agreed(one, other)
    return {"tuning": tuning, "zeta": zeta, "decay": decay}


PROBLEMS: dict[str, Callable[[], Answers]] = {
    "9.51": compressor_band,
    "9.52": motor_on_cantilever,
    "9.53 as printed": pipe_as_tuned_trial,
    "9.53 both frequencies": pipe_with_both_frequencies,
    "9.54": floor,
    "9.55": floor_band,
    "9.56": torsional_absorber,
    "9.56 half a metre": lambda: torsional_absorber("0.5"),
    "9.57": rotor_band,
    "9.58": table_of_ratios,
    "9.59": operating_range,
    "9.60": stroke,
    "9.61": motor_on_beam,
    "9.61 as printed": lambda: motor_on_beam("10"),
    "9.62": bridge,
    "9.63": motor_off_resonance,
    "9.64": pulley_absorber,
    "9.66": damped_curves,
    "9.67": stiff_absorbers,
    "9.71": response_table,
    "assignment 4 a": two_masses,
    "assignment 4 b": hanging_pendulum,
}
