"""Recorded answers of the rotors: two-node elements of the textbook, both planes together, extrapolated."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.io import mmread
from scipy.linalg import eigh
from scipy.optimize import brentq, minimize_scalar

import vibopt as vo
from vibopt.document.toml_reading import placed
from vibopt.units import read_quantity

PROBLEMS = Path(__file__).parents[2] / "problems/shafts"
RPM = np.pi / 30.0
DIMENSIONS = {
    "length": "length", "diameter": "length", "inner_diameter": "length", "at": "length", "width": "length",
    "outer_diameter": "length", "mass": "mass", "diametral": "inertia", "polar": "inertia", "density": "density",
    "modulus": "modulus", "stiffness": "stiffness", "damping": "damping",
}  # fmt: skip


def said(table: Any, key: str) -> float:
    return float(read_quantity(table[key], DIMENSIONS[key]).value) if key in table else 0.0


def element(long: float, outer: float, inner: float, table: Any) -> tuple[Any, Any, Any]:
    """Stiffness, inertia and polar inertia (4, 4) of Timoshenko's beam, by its static shapes and quadrature."""
    modulus, density = said(table, "modulus"), said(table, "density")
    area, second = np.pi * (outer**2 - inner**2) / 4.0, np.pi * (outer**4 - inner**4) / 64.0
    hole = (inner / outer) ** 2
    kappa = 7.8 * (1.0 + hole) ** 2 / (8.8 * (1.0 + hole) ** 2 + 23.6 * hole)  # Cowper, Poisson's ratio 0.3
    phi = 12.0 * modulus * second / (kappa * modulus / 2.6 * area * long**2)
    near, far = (4.0 + phi) * long**2, (2.0 - phi) * long**2
    k = np.array([[12.0, 6 * long, -12.0, 6 * long], [6 * long, near, -6 * long, far],
                  [-12.0, -6 * long, 12.0, -6 * long], [6 * long, far, -6 * long, near]])  # fmt: skip
    points, weights = np.polynomial.legendre.leggauss(6)
    s, weight = 0.5 + 0.5 * points, 0.5 * long * weights
    w = np.array([1 - 3 * s**2 + 2 * s**3 + phi * (1 - s), long * (s - 2 * s**2 + s**3 + phi * (s - s**2) / 2),
                  3 * s**2 - 2 * s**3 + phi * s, long * (s**3 - s**2 + phi * (s**2 - s) / 2)])  # fmt: skip
    t = np.array([6 * (s**2 - s) / long, 1 - 4 * s + 3 * s**2 + phi * (1 - s), 6 * (s - s**2) / long,
                  3 * s**2 - 2 * s + phi * s])  # fmt: skip
    moves, tilts = ((one * weight) @ one.T / (1.0 + phi) ** 2 for one in (w, t))
    stiff = k * modulus * second / (long**3 * (1.0 + phi))
    return stiff, density * (area * moves + second * tilts), 2.0 * density * second * tilts


class Rotor:
    """Stiffness, inertia, damping and polar inertia of one plane; `first`: a diameter [m] of the first section."""

    def __init__(self, stem: str, many: int, first: float, span: float = 0.0) -> None:
        document = tomllib.loads((PROBLEMS / f"{stem}.toml").read_text(encoding="utf-8"))
        (table,) = document["rotors"].values()
        longs = [span if isinstance(one["length"], dict) else said(one, "length") for one in table["sections"]]
        ends = np.concatenate([[0.0], np.cumsum(longs)])
        spots = {**table["stations"], **{one["name"]: one["at"] for one in table["discs"]}}
        places = {
            name: ends[int(at.split()[-1])] if at.startswith("end of section") else said({"at": at}, "at")
            for name, at in spots.items()
        }
        cuts = np.unique(np.round([*ends, *places.values()], 9))
        pieces = [np.linspace(a, b, many + 1)[:-1] for a, b in pairwise(cuts)]
        nodes = np.concatenate([*pieces, cuts[-1:]])
        self.at = {name: 2 * int(np.abs(nodes - place).argmin()) for name, place in places.items()}
        self.k, self.m, self.c, self.p = (np.zeros((2 * len(nodes), 2 * len(nodes))) for _ in range(4))
        for i, (a, b) in enumerate(pairwise(nodes)):
            which = int(np.searchsorted(ends, 0.5 * (a + b))) - 1
            section = table["sections"][which]
            outer = first if first and not which else said(section, "diameter")
            here = slice(2 * i, 2 * i + 4)
            parts = element(b - a, outer, said(section, "inner_diameter"), table)
            for target, part in zip((self.k, self.m, self.p), parts, strict=True):
                target[here, here] += part
        self.shaft = self.k.copy()
        for one in table["discs"]:
            self._disc(one)
        self.links, self.bearings = document.get("links", {}), document.get("bearings", {})
        for link in self.links.values():
            i = self.at[link["between"][0]]
            self.k[i, i] += said(link, "stiffness")
            self.c[i, i] += said(link, "damping")

    def _disc(self, one: Any) -> None:
        i, mass, diametral, polar = self.at[one["name"]], said(one, "mass"), said(one, "diametral"), said(one, "polar")
        if not mass:
            outer, inner, wide = (said(one, key) for key in ("outer_diameter", "inner_diameter", "width"))
            mass = said(one, "density") * np.pi / 4.0 * (outer**2 - inner**2) * wide
            polar = mass * (outer**2 + inner**2) / 8.0
            diametral = polar / 2.0 + mass * wide**2 / 12.0
        self.m[i, i] += mass
        self.m[i + 1, i + 1] += diametral
        self.p[i + 1, i + 1] += polar

    def orbit(self, on: str, unbalance: float, of: str, spin: float) -> float:
        """Major half axis of the orbit at a place [m], of an unbalance [kg m] that turns; x and y solved together."""
        one = self.k - spin**2 * self.m + 1j * spin * self.c
        across = 1j * spin**2 * self.p  # spin times polar inertia times the rate of the other plane
        force = np.zeros(len(one))
        force[self.at[on]] = unbalance * spin**2
        both = np.linalg.solve(np.block([[one, across], [-across, one]]), np.concatenate([force, -1j * force]))
        x, y = both[self.at[of]], both[len(one) + self.at[of]]
        return float(np.sqrt(0.5 * (abs(x) ** 2 + abs(y) ** 2 + abs(x**2 + y**2))))

    def force(self, on: str, unbalance: float, link: str, spin: float) -> float:
        """That a link passes on [N]."""
        dynamic = said(self.links[link], "stiffness") + 1j * spin * said(self.links[link], "damping")
        return abs(dynamic) * self.orbit(on, unbalance, self.links[link]["between"][0], spin)

    def threshold(self, lags: float, low: float, high: float) -> float:
        """Spin between two at which the first whirl of both planes begins to grow, as its material lags [rad/s]."""
        inverse, drag = np.linalg.inv(self.m), lags * self.shaft
        zero, n = np.zeros_like(self.m), len(self.m)

        def grows(spin: float) -> float:
            brake = np.block([[self.c + drag, spin * self.p], [-spin * self.p, self.c + drag]])
            stiff = np.block([[self.k, spin * drag], [-spin * drag, self.k]])
            both = np.block([[inverse, zero], [zero, inverse]])
            state = np.block([[np.zeros((2 * n, 2 * n)), np.eye(2 * n)], [-both @ stiff, -both @ brake]])
            return float(np.linalg.eigvals(state).real.max())

        return float(brentq(grows, low, high, xtol=1e-9, rtol=1e-13))

    def films(self, spin: float) -> tuple[Any, Any]:
        """Stiffness and damping of both planes with what bearings add at a spin, straight between rows."""
        stiff, damp = (np.kron(np.eye(2), one) for one in (self.k, self.c))
        for bearing in self.bearings.values():
            i, n = self.at[bearing["between"][0]], len(self.k)
            for key, value in _coefficients(bearing, spin).items():
                a, b = (i + n * (letter == "z") for letter in key[2:])
                (stiff if key[0] == "k" else damp)[a, b] += value
        return stiff, damp

    def whirls(self, spin: float, sense: float) -> Any:
        """Complex frequencies [rad/s], Im above zero of those that fade, forward (1), backward (-1) or all (0)."""
        (stiff, damp), n, zero = self.films(spin), len(self.m), np.zeros_like(self.m)
        damp = damp + spin * np.block([[zero, self.p], [-self.p, zero]])
        inverse = np.kron(np.eye(2), np.linalg.inv(self.m))
        state = np.block([[np.zeros((2 * n, 2 * n)), np.eye(2 * n)], [-inverse @ stiff, -inverse @ damp]])
        rates, ways = np.linalg.eig(state)
        y, z = ways[:n], ways[n : 2 * n]
        turns = np.real(np.sum(np.conj(1j * z) * (self.m @ y), axis=0))  # the area of all orbits, by their masses
        swings = (rates.imag > 1.0) & (rates.imag > 0.5 * np.abs(rates)) & (sense * turns >= 0.0)
        found = -1j * rates[swings]
        return found[np.argsort(found.real)]

    def whirl(self, on: str, of: str, spin: float) -> float:
        """Major half axis at a place over that of a unit unbalance [m], in films of that spin."""
        (stiff, damp), n, zero = self.films(spin), len(self.m), np.zeros_like(self.m)
        damp = damp + spin * np.block([[zero, self.p], [-self.p, zero]])
        force = np.zeros(2 * n, dtype=complex)
        force[self.at[on]], force[n + self.at[on]] = spin**2, -1j * spin**2
        both = np.linalg.solve(stiff + 1j * spin * damp - spin**2 * np.kron(np.eye(2), self.m), force)
        y, z = both[self.at[of]], both[n + self.at[of]]
        return float(np.sqrt(0.5 * (abs(y) ** 2 + abs(z) ** 2 + abs(y**2 + z**2))))

    def critical(self, sense: float) -> Any:
        """Speeds of free whirl as fast as the spin, forward (1) or backward (-1), ascending [rad/s]."""
        inverse = eigh(self.m - sense * self.p, self.k, eigvals_only=True)
        return 1.0 / np.sqrt(inverse[inverse > 0.0][::-1])


def _coefficients(bearing: Any, spin: float) -> dict[str, float]:
    """Of a bearing at a spin [N/m] and [N s/m]."""
    if "table" not in bearing:
        kinds = {"k": "stiffness", "c": "damping"}
        return {key: read_quantity(one, kinds[key[0]]).value for key, one in bearing.items() if key != "between"}
    head, *rows = [line.split(";") for line in (PROBLEMS / bearing["table"]).read_text(encoding="utf-8").splitlines()]
    table, sizes = np.array(rows, dtype=float).T, {"MN/m": 1e6, "kN s/m": 1e3}
    said = [one.rstrip("]").split(" [") for one in head]
    return {key: sizes[unit] * float(np.interp(spin / RPM, table[0], column))
            for (key, unit), column in zip(said[1:], table[1:], strict=True)}  # fmt: skip


def limit(ask: Callable[[Rotor], float], stem: str, first: float = 0.0, many: int = 2) -> float:
    """Of ever finer elements, whose error falls by four and then by sixteen at each halving."""
    coarse, fine, finest = (ask(rotor(stem, one, first)) for one in (many, 2 * many, 4 * many))
    return (64.0 * finest - 20.0 * fine + coarse) / 45.0


@cache
def rotor(stem: str, many: int, first: float) -> Rotor:
    return Rotor(stem, many, first)


def expected(stem: str) -> dict[str, Any]:
    document = tomllib.loads((PROBLEMS / f"{stem}.toml").read_text(encoding="utf-8"))
    return {one["path"]: one["value"] for one in document["expected"]}


def lengths(pairs: Any) -> Any:
    return [read_quantity(one, "length").value for pair in pairs for one in pair]


def greatest(ask: Callable[[Rotor, float], float], stem: str, low: float, high: float) -> tuple[float, float]:
    """Where a range of spins answers most [rad/s], by a net and then a search in it, and how much."""
    spins = np.linspace(low, high, 601)
    near = int(np.argmax([ask(rotor(stem, 2, 0.0), float(one)) for one in spins]))
    ends = tuple(spins[np.clip([near - 1, near + 1], 0, len(spins) - 1)])
    found: Any = minimize_scalar(
        lambda spin: -limit(lambda one: ask(one, spin), stem), bounds=ends, options={"xatol": 1e-7 * high}
    )
    return float(found.x), -float(found.fun)


def test_the_diameters_of_the_fan_end_where_it_whirls_as_fast_as_the_edge_of_a_band() -> None:
    stem, running = "fan_on_a_stepped_shaft", 1480.0 * RPM
    bands = [(0.85 * order * running, 1.15 * order * running) for order in (1, 2)]

    def root(edge: float) -> float:
        found = brentq(lambda wide: limit(lambda one: one.critical(1.0)[0], stem, wide) - edge, 0.05, 0.14, xtol=1e-11)
        return float(found)

    found = lengths(expected(stem)["set"])
    assert found == pytest.approx([0.05, root(bands[1][0]), root(bands[1][1]), 0.14], rel=2e-7)
    for wide in np.linspace(0.05, 0.14, 91):
        one = rotor(stem, 2, float(wide))
        apart = not any(low < speed < high for speed in one.critical(1.0) for low, high in bands)
        far = one.orbit("fan", 6e-4, "fan", running)
        force = one.force("fan", 6e-4, "fan_bearing", running)
        assert (apart and far <= 5e-5 and force <= 2e3) == (not found[1] < wide < found[2])


def test_the_spans_of_the_fan_end_where_it_whirls_as_fast_as_the_edge_of_a_band() -> None:
    stem, running = "where_a_fan_is_borne", 1750.0 * RPM

    def fast(span: float) -> float:
        coarse, fine, finest = (Rotor(stem, many, 0.0, span).critical(1.0)[0] for many in (2, 4, 8))
        return float((64.0 * finest - 20.0 * fine + coarse) / 45.0)

    ends = [brentq(lambda span: fast(span) - 2.3 * running, *two, xtol=1e-11) for two in ((0.3, 0.5), (0.6, 0.9))]
    assert lengths(expected(stem)["set"]) == pytest.approx(ends, rel=2e-7)
    for span in np.linspace(0.3, 1.2, 61):
        one = Rotor(stem, 2, 0.0, float(span))
        speeds = one.critical(1.0) / running
        apart = not ((speeds > 0.85) & (speeds < 1.15) | (speeds > 1.7) & (speeds < 2.3)).any()
        assert (apart and one.orbit("fan", 6e-4, "fan", running) <= 3e-6) == (ends[0] < span < ends[1])


def test_the_speeds_of_the_pump_end_where_the_impeller_takes_a_quarter_of_the_clearance() -> None:
    stem = "pump_rotor"

    def far(one: Rotor, spin: float) -> float:
        return one.orbit("impeller", 4.5e-4, "impeller", spin)

    peak, most = greatest(far, stem, 300.0 * RPM, 6000.0 * RPM)
    sides = [(300.0 * RPM, peak), (peak, 6000.0 * RPM)]
    ends = [brentq(lambda spin: limit(lambda one: far(one, spin), stem) - 5e-5, *side, xtol=1e-9) for side in sides]
    right, pairs = expected(stem), expected(stem)["set"]
    rates = [read_quantity(one, "angular_rate").value for pair in pairs for one in pair]
    assert rates == pytest.approx([300.0 * RPM, ends[0], ends[1], 6000.0 * RPM], rel=2e-7)
    assert read_quantity(right["limits.wear_ring.value"], "length").value == pytest.approx(most, rel=2e-7)


@pytest.mark.parametrize("name", ["first", "second", "third", "front", "rear"])
def test_the_turbine_whirls_most_on_its_way_up(name: str) -> None:
    stem, bearing = "three_disc_turbine", name in ("front", "rear")

    def ask(one: Rotor, spin: float) -> float:
        return (one.force if bearing else one.orbit)("second", 1.6e-3, f"{name}_bearing" if bearing else name, spin)

    _, most = greatest(ask, stem, 1.0, 6000.0 * RPM)
    right = expected(stem)[f"measures.{name}.value"]
    assert read_quantity(right, "force" if bearing else "length").value == pytest.approx(most, rel=2e-7)


def test_the_turbine_of_a_grade_whirls_most_with_all_of_it_on_one_wheel() -> None:
    """On another below and above the first critical speed."""
    stem, top = "turbine_by_its_grade", 6000.0 * RPM
    one = rotor(stem, 1, 0.0)
    along = np.tile([1.0, 0.0], len(one.m) // 2)
    size = 2.5e-3 * float(along @ one.m @ along) / top
    right = expected(stem)

    def most(name: str, on: str, low: float) -> float:
        def ask(one: Rotor, spin: float) -> float:
            bearing = name == "rear"
            return (one.force if bearing else one.orbit)(on, size, f"{name}_bearing" if bearing else name, spin)

        at_top = limit(lambda one: ask(one, top), stem)
        return max(at_top, greatest(ask, stem, low, top)[1])

    for path, low in (
        ("limits.first", 1.0),
        ("limits.second", 1.0),
        ("measures.third", 3e3 * RPM),
        ("measures.rear", 3e3 * RPM),
    ):
        name = path.partition(".")[2]
        kind = "force" if name == "rear" else "length"
        found = [most(name, on, low) for on in ("first", "second", "third")]
        assert read_quantity(right[f"{path}.value"], kind).value == pytest.approx(max(found), rel=2e-7)


@pytest.mark.parametrize(("name", "sense"), [("forward", 1.0), ("backward", -1.0)])
def test_critical_speeds_of_the_turbine(name: str, sense: float) -> None:
    right = read_quantity(expected("three_disc_turbine")[f"measures.{name}.value"], "angular_rate").value
    assert right == pytest.approx(limit(lambda one: one.critical(sense)[1], "three_disc_turbine"), rel=2e-7)


def test_the_pump_by_its_matrices_is_that_of_both_planes_as_they_stand_in_the_files() -> None:
    """Tonnes, millimetres and seconds; y, z and the turns about them of each node; loads and discs in the same "
    "units."""
    stem = "pump_by_its_matrices"
    m, k, g = (mmread(PROBLEMS / f"pump_shaft_{one}.mtx").toarray() for one in ("mass", "stiffness", "gyroscopic"))
    for node, mass, across, about in ((0, 6e-3, 15.0, 20.0), (8, 22e-3, 190.0, 330.0)):
        at = 4 * node
        m[range(at, at + 4), range(at, at + 4)] += [mass, mass, across, across]
        g[at + 2, at + 3] += about
        g[at + 3, at + 2] -= about
    c = np.zeros_like(m)
    for node, brakes in ((1, 2.0), (6, 2.0), (8, 0.8)):  # N s/mm
        c[range(4 * node, 4 * node + 2), range(4 * node, 4 * node + 2)] = brakes
    force = np.zeros(len(m), dtype=complex)
    force[32:34] = 0.45e-3 * np.array([1.0, -1j])

    def held(bearing: float) -> Any:
        stiff = k.copy()
        for node, springs in ((1, 6e4), (6, bearing)):
            stiff[range(4 * node, 4 * node + 2), range(4 * node, 4 * node + 2)] += springs
        return stiff

    def far(bearing: float, spin: float) -> float:
        dynamic = held(bearing) + 1j * spin * (c + spin * g) - spin**2 * m
        y, z = np.linalg.solve(dynamic, spin**2 * force)[32:34]
        return float(np.sqrt(0.5 * (abs(y) ** 2 + abs(z) ** 2 + abs(y**2 + z**2))))

    def most(bearing: float) -> float:
        """Up to 3300 rpm it rises with the spin or has one top."""
        found: Any = minimize_scalar(
            lambda spin: -far(bearing, spin), bounds=(1.0, 3300.0 * RPM), method="bounded", options={"xatol": 1e-7}
        )
        return max(-float(found.fun), far(bearing, 3300.0 * RPM))

    def critical(bearing: float, sense: float) -> float:
        """Of free whirl in both planes, with z a quarter turn behind: the matrices of (u, -i u)."""
        ways = np.zeros((36, 18), dtype=complex)
        for node in range(9):
            ways[4 * node, 2 * node], ways[4 * node + 3, 2 * node + 1] = 1.0, 1.0
            ways[4 * node + 1, 2 * node], ways[4 * node + 2, 2 * node + 1] = -1j, 1j
        inertia = ways.conj().T @ (m - sense * 1j * g) @ ways
        return float(1.0 / np.sqrt(eigh(inertia, ways.conj().T @ held(bearing) @ ways, eigvals_only=True)[-1]))

    right = expected(stem)
    low, high = (read_quantity(one, "stiffness").value for one in right["set"][0])
    assert low == pytest.approx(1e3 * brentq(lambda one: most(one) - 0.05, 3e4, 1e5, xtol=1e-4), rel=1e-7)
    assert high == 2e8
    for bearing in np.geomspace(5e3, 2e5, 60):
        apart = not 0.85 * 2950.0 * RPM < critical(bearing, 1.0) < 1.15 * 2950.0 * RPM
        assert (apart and most(bearing) <= 0.05) == (bearing >= 1e-3 * low)
    text = (PROBLEMS / f"{stem}.toml").read_text(encoding="utf-8").partition("[goal]")[0]
    document = placed(tomllib.loads(text.replace('{ from = "5 MN/m", to = "200 MN/m" }', '"100 MN/m"')), PROBLEMS)
    back = vo.solve(vo.from_dict(document)).measures["backward"].value.value
    assert critical(1e5, -1.0) == pytest.approx(back, rel=1e-7)


@pytest.mark.parametrize(("path", "sense"), [("limits.apart.value", 1.0), ("measures.backward.value", -1.0)])
def test_the_compressor_whirls_as_fast_as_it_spins(path: str, sense: float) -> None:
    def ask(one: Rotor) -> float:
        return float(brentq(lambda spin: one.whirls(spin, sense)[0].real - spin, 420.0, 700.0, xtol=1e-9))

    right = read_quantity(expected("compressor_on_tilting_pads")[path], "angular_rate").value
    assert right == pytest.approx(limit(ask, "compressor_on_tilting_pads", many=1), rel=2e-7)


def test_the_peak_of_the_compressor_is_as_sharp_as_it_should_be() -> None:
    def ask(one: Rotor) -> float:
        def far(spin: float) -> float:
            return one.whirl("wheel_3", "drive_end", spin)

        ends = 4000.0 * RPM, 8000.0 * RPM
        found: Any = minimize_scalar(lambda spin: -far(spin), bounds=ends, method="bounded", options={"xatol": 1e-9})
        peak, level = float(found.x), -float(found.fun) / np.sqrt(2.0)
        flanks = [brentq(lambda spin: far(spin) - level, *side, xtol=1e-10) for side in ((300.0, peak), (peak, 1100.0))]
        return peak / (flanks[1] - flanks[0])

    right = expected("compressor_on_tilting_pads")["measures.sharpest.value"]
    assert right == pytest.approx(limit(ask, "compressor_on_tilting_pads", many=1), rel=1e-6)


def test_the_whirls_of_the_compressor_fade_as_fast_as_they_should() -> None:
    def ask(one: Rotor) -> float:
        every = one.whirls(7000.0 * RPM, 0.0)
        each = every[every.real <= 7000.0 * RPM]
        return float((2.0 * np.pi * each.imag / each.real).min())

    right = expected("compressor_on_tilting_pads")["limits.fades.value"]
    assert right == pytest.approx(limit(ask, "compressor_on_tilting_pads", many=1), rel=2e-7)


@pytest.mark.parametrize("lags", [2e-5, 4e-4])
def test_a_shaft_whose_own_material_damps_is_stable_to_the_same_spin(lags: float) -> None:
    document = tomllib.loads((PROBLEMS / "pump_rotor.toml").read_text(encoding="utf-8"))
    document["rotors"]["pump_shaft"]["material_damping"] = f"{1e3 * lags!r} ms"
    asked = {"measures": {"grows": {"response": "stability_threshold"}}}
    facts = {key: document[key] for key in ("title", "rotors", "links")}
    found = vo.solve(vo.from_dict({**facts, **asked})).measures["grows"].value.value
    ends = 0.9 * found, 1.1 * found
    assert found == pytest.approx(limit(lambda one: one.threshold(lags, *ends), "pump_rotor"), rel=1e-6)
