"""Campbell diagram and unbalance response of rotors on shafts beside 2-node elements in two planes, solved as usual.

Run by hand: python tests/bench/rotors_on_shafts.py.  CPU seconds; the elements are Timoshenko's with consistent mass,
four coordinates a node (two deflections, two tilts), a dense state matrix at each spin and a solution at each speed.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from timing import timed

from vibopt.forms.drive_response import DriveResponse, modes_for
from vibopt.program.pose import on_needed
from vibopt.scene.assemble import model_of
from vibopt.scene.read import from_dict
from vibopt.verify.as_built import machine_of

SPINS, SPEEDS = np.linspace(0.0, 500.0, 81), np.linspace(5.0, 500.0, 400)
MODULUS, SHEAR, DENSITY, WIDE, LONG = 211e9, 81.2e9, 7810.0, 0.05, 1.5
BEARING, DAMPER = 1e6, 1e3
DISCS = {0.5: 0.28, 1.0: 0.35}


def document() -> dict[str, Any]:
    disc = {"inner_diameter": "50 mm", "width": "70 mm", "density": f"{DENSITY} kg/m3"}
    links = {name: {"between": [name[:-2], "ground"], "stiffness": f"{BEARING} N/m", "damping": f"{DAMPER} N s/m"}
             for name in ("left_b", "right_b")}  # fmt: skip
    return {
        "title": "two discs",
        "rotors": {
            "rotor": {
                "sections": [{"length": f"{LONG} m", "diameter": f"{WIDE} m"}],
                "discs": [{"name": f"d{i}", "at": f"{at} m", "outer_diameter": f"{outer} m", **disc}
                          for i, (at, outer) in enumerate(DISCS.items())],
                "stations": {"left": "0 m", "right": f"{LONG} m"},
                "modulus": f"{MODULUS} Pa",
                "shear_modulus": f"{SHEAR} Pa",
                "density": f"{DENSITY} kg/m3",
            }
        },
        "links": links,
        "excitations": {"u": {"kind": "unbalance", "on": "d0", "unbalance": "1 g m", "speed": "5..500 rad/s"}},
        "measures": {"m": {"response": "displacement", "of": "d1"}},
    }  # fmt: skip


def elements(count: int) -> tuple[Any, Any, Any, Any]:
    """M, C, K and G, (4 n, 4 n), of a shaft in `count` elements; coordinates x, y, tilts about y and about x."""
    area, second = math.pi * WIDE**2 / 4.0, math.pi * WIDE**4 / 64.0
    kappa, e = 6.0 * 1.3 / (7.0 + 6.0 * 0.3), LONG / count
    phi = 12.0 * MODULUS * second / (kappa * SHEAR * area * e**2)
    a, b = (4.0 + phi) * e**2, (2.0 - phi) * e**2
    stiff = np.array([[12, 6 * e, -12, 6 * e], [6 * e, a, -6 * e, b], [-12, -6 * e, 12, -6 * e], [6 * e, b, -6 * e, a]])
    stiff = stiff * MODULUS * second / (e**3 * (1.0 + phi))
    t, weights = np.polynomial.legendre.leggauss(6)
    mass, turn = np.zeros((4, 4)), np.zeros((4, 4))
    for x, w in zip(0.5 + 0.5 * t, 0.5 * weights, strict=True):
        one = 1.0 / (1.0 + phi)
        u = one * np.array([1 + phi * (1 - x) - 3 * x**2 + 2 * x**3, e * (x + phi * (x - x * x) / 2 - 2 * x**2 + x**3),
                            phi * x + 3 * x**2 - 2 * x**3, e * (-x * x + x**3 - 0.5 * phi * (x - x * x))])  # fmt: skip
        v = one * np.array([6 * (x * x - x) / e, 1 + phi - phi * x - 4 * x + 3 * x * x, 6 * (x - x * x) / e,
                            phi * x - 2 * x + 3 * x * x])  # fmt: skip
        mass += w * e * (DENSITY * area * np.outer(u, u) + DENSITY * second * np.outer(v, v))
        turn += w * e * 2.0 * DENSITY * second * np.outer(v, v)
    n = 2 * (count + 1)
    k, m, p, c = (np.zeros((n, n)) for _ in range(4))
    for i in range(count):
        here = slice(2 * i, 2 * i + 4)
        k[here, here] += stiff
        m[here, here] += mass
        p[here, here] += turn
    for at, outer in DISCS.items():
        node, weight = round(at / e), DENSITY * math.pi * (outer**2 - 0.05**2) / 4.0 * 0.07
        m[2 * node, 2 * node] += weight
        m[2 * node + 1, 2 * node + 1] += weight * (3.0 * (outer**2 + 0.05**2) / 4.0 + 0.07**2) / 12.0
        p[2 * node + 1, 2 * node + 1] += weight * (outer**2 + 0.05**2) / 8.0
    for i in (0, n - 2):
        k[i, i] += BEARING
        c[i, i] += DAMPER
    both, cross = np.eye(2), np.array([[0.0, 1.0], [-1.0, 0.0]])
    return np.kron(both, m), np.kron(both, c), np.kron(both, k), np.kron(cross, p)


def campbell_of_elements(parts: tuple[Any, Any, Any, Any]) -> Any:
    m, _, k, g = parts
    n = len(m)
    found = []
    for spin in SPINS:
        state = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(m, k), -np.linalg.solve(m, spin * g)]])
        found.append(np.sort(np.abs(np.linalg.eigvals(state).imag))[:12])
    return np.array(found)


def response_of_elements(parts: tuple[Any, Any, Any, Any], driven: int, seen: int) -> Any:
    m, c, k, g = parts
    n = len(m) // 2
    load = np.zeros(2 * n, dtype=complex)
    load[driven], load[n + driven] = 1.0, -1j
    found = [np.linalg.solve(k + 1j * w * (c + w * g) - w * w * m, load)[seen] * 1e-3 * w * w for w in SPEEDS]
    return np.abs(np.array(found))


def whirls(scene: Any) -> Any:
    machine = machine_of(scene, {})
    return [machine.free_whirls(float(spin)) for spin in SPINS]


def responses(scene: Any, model: Any) -> Any:
    harmonic = on_needed(scene, model, scene.measures["m"])[1].harmonic
    assert harmonic is not None
    vars(model).pop("kept", None)  # what is dear is measured anew
    modal = modes_for(model, harmonic, harmonic.drives[0], np.zeros(0))[0]
    return DriveResponse(model, harmonic, harmonic.drives[0], np.zeros(0), modal)(SPEEDS)


def main() -> None:
    scene = from_dict(document())
    model = model_of(scene)
    whirls(scene), responses(scene, model)
    for count in (6, 12, 24, 48):
        parts = elements(count)
        node = [2 * round(at / LONG * count) for at in DISCS]
        theirs, ours = timed(lambda parts=parts: campbell_of_elements(parts)), timed(lambda: whirls(scene))
        apart = max(
            abs(np.sort(np.abs(one))[:6] / np.sort(other)[:12:2][:6] - 1.0).max()
            for one, other in zip(ours[1][10:], theirs[1][10:], strict=True)
        )
        print(f"{count} elements: Campbell {theirs[0]:.2f} s, here {ours[0]:.3f} s, {theirs[0] / ours[0]:.0f} times; "
              f"apart {apart:.0e}")  # fmt: skip
        theirs = timed(lambda parts=parts, node=node: response_of_elements(parts, *node))
        ours = timed(lambda: responses(scene, model))
        apart = float(np.abs(ours[1] / theirs[1] - 1.0).max())
        print(f"             response {theirs[0]:.3f} s, here {ours[0]:.3f} s, {theirs[0] / ours[0]:.1f} times; "
              f"apart {apart:.0e}")  # fmt: skip


if __name__ == "__main__":
    main()
