"""Parts of a catalogue by HiGHS: a mixed-integer program of amplitudes at few speeds, exchanged until its choice holds.

Of a machine on a line.  Stiffness times motion is linear in motions of which each part has its own, nothing where it is
not chosen; amplitudes lie inside a polygon round their circle, so that no choice is lost.  A choice that breaks a limit
at its exact peak is forbidden, and the speed of that peak joins the program: the first that holds is the cheapest.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, cast

import numpy as np

from vibopt.arrays import FloatArray, IntArray
from vibopt.charts.mount_machine import GRAVITY, LINE, Machine, Shelf
from vibopt.charts.mount_truth import broken, size
from vibopt.solve.rivals.milp import quiet

SPEEDS, SIDES = 3, 16
"""Speeds to begin with, and sides of a polygon."""
_AIR = 1e-5
"""Part by which every limit is looser in the program, whose solver is exact to 1e-6."""
_LOOKS, _ROUNDS, _NODES = 2000, 200, 20_000


class _Rows(NamedTuple):
    """low <= on_parts @ x + on_motions @ v <= high; x is 1 for each chosen part, shape (n_groups * n_parts,)."""

    on_parts: FloatArray
    on_motions: FloatArray
    low: FloatArray
    high: FloatArray


def refusal(machine: Machine) -> str:
    """Why a machine is not taken; "" where it is."""
    if machine.motion != LINE:
        return "takes machines on a line: in space nothing bounds the motions that parts are multiplied by"
    return "" if machine.sway is not None else "takes a limit on the sway"


def cheapest(machine: Machine, shelf: Shelf) -> tuple[str, IntArray | None]:
    """Status, and the part of each group; "optimal" and "infeasible" are proven."""
    speeds = np.linspace(0.0, machine.omega, SPEEDS + 1)[1:].tolist()
    looks = np.linspace(0.0, machine.omega, _LOOKS + 1)[1:]
    blocks = [_standing(machine, shelf), *(_moving(machine, shelf, speed) for speed in speeds)]
    known: list[IntArray] = []
    for _ in range(_ROUNDS):
        status, chosen = _solved(machine, shelf, blocks, known)
        if chosen is None or broken(machine, shelf, chosen[None, :])[0] <= 0.0:
            return status, chosen
        known.append(chosen)
        mass, dynamic, _ = machine.matrices(shelf, chosen[None, :])
        moved = size(machine, mass, dynamic, looks[None, :])[0]
        if moved.max() > (machine.sway or np.inf):
            blocks.append(_moving(machine, shelf, float(looks[moved.argmax()])))
    return "unproven", None


def _each(machine: Machine, shelf: Shelf) -> tuple[FloatArray, FloatArray]:
    """How many mounts stand for each x, (n,), and which group it belongs to, (n_groups, n)."""
    counts = np.array([len(places) for places in machine.groups], dtype=float)
    return np.repeat(counts, len(shelf)), np.repeat(np.eye(len(counts)), len(shelf), axis=1)


def _standing(machine: Machine, shelf: Shelf) -> _Rows:
    """One part a group, the highest natural frequency, the sag under the weight, and what it loads within its rating.

    A motion is the sag of a group where the part is chosen, over that on parts of mean stiffness.
    """
    each, group = _each(machine, shelf)
    many, n = group.shape
    k, static, most, least = (np.tile(one, many) for one in (shelf.k, shelf.static, shelf.most, shelf.least))
    weight = machine.mass * GRAVITY
    unit = weight / float((each * static).sum() / len(shelf))
    none = np.zeros
    tables = [
        _Rows(group, none((many, n)), np.ones(many), np.ones(many)),
        _Rows(none((many - 1, n)), group[0] - group[1:], none(many - 1), none(many - 1)),
        _Rows(none((1, n)), (each * static * unit / weight)[None], np.ones(1), np.ones(1)),
        _Rows(-np.eye(n) * (1.0 + _AIR), np.diag(static * unit / most), np.full(n, -np.inf), none(n)),
        _Rows(-np.diag(least / most) * (1.0 - _AIR), np.diag(static * unit / most), none(n), np.full(n, np.inf)),
    ]
    if machine.highest is not None:
        top = machine.mass * (2.0 * np.pi * machine.highest) ** 2 * (1.0 + _AIR)
        tables.append(_Rows((each * k / top)[None], none((1, n)), np.full(1, -np.inf), np.ones(1)))
    return _joined(tables)


def _moving(machine: Machine, shelf: Shelf, speed: float) -> _Rows:
    """The motion at a speed within the limit on the sway, and at full speed the force into the floor.

    Motions are real parts, then imaginary ones, over the limit on the sway.
    """
    each, group = _each(machine, shelf)
    many, n = group.shape
    sway = float(machine.sway or np.inf)
    pull = each * np.tile(shelf.k, many) * (1.0 + 1j * np.tile(shelf.loss, many)) * sway
    inertia = machine.mass * speed**2 * sway * group[0]
    scale = machine.mass * machine.omega**2 * sway
    driven = machine.force * (speed / machine.omega) ** 2 / scale
    balance = (pull - inertia) / scale
    none = np.zeros
    apart = group[0] - group[1:]
    tables = [
        _Rows(none((many - 1, n)), np.hstack([apart, none(apart.shape)]), none(many - 1), none(many - 1)),
        _Rows(none((many - 1, n)), np.hstack([none(apart.shape), apart]), none(many - 1), none(many - 1)),
        _Rows(none((1, n)), np.hstack([balance.real, -balance.imag])[None], np.full(1, driven), np.full(1, driven)),
        _Rows(none((1, n)), np.hstack([balance.imag, balance.real])[None], none(1), none(1)),
        _within(group[0] + 0j),
    ]
    for side in (1.0, -1.0):
        still = np.tile(np.eye(n), (2, 1)) * -(1.0 + _AIR)
        tables.append(_Rows(still, side * np.eye(2 * n), np.full(2 * n, -np.inf), none(2 * n)))
    if machine.floor is not None and speed == machine.omega:
        tables.append(_within(pull / machine.floor))
    return _joined(tables)


def _within(row: Any) -> _Rows:
    """The size of a complex sum of motions is at most 1: inside each side of a polygon."""
    turned = np.exp(2j * np.pi * np.arange(SIDES) / SIDES)[:, None] * row
    n = len(row)
    return _Rows(np.zeros((SIDES, n)), np.hstack([turned.real, -turned.imag]), np.full(SIDES, -np.inf),
                 np.full(SIDES, 1.0 + _AIR))  # fmt: skip


def _joined(tables: Sequence[_Rows]) -> _Rows:
    return _Rows(*(np.concatenate(parts) for parts in zip(*tables, strict=True)))


def _solved(
    machine: Machine, shelf: Shelf, blocks: Sequence[_Rows], known: Sequence[IntArray]
) -> tuple[str, IntArray | None]:
    """The cheapest choice of the program that is none of those known."""
    from scipy.optimize import Bounds, LinearConstraint, milp
    from scipy.sparse import block_diag, csr_array, hstack, vstack

    each, group = _each(machine, shelf)
    many, n = group.shape
    motions: Any = block_diag([block.on_motions for block in blocks])
    whole: Any = hstack([csr_array(np.vstack([block.on_parts for block in blocks])), motions])
    low, high = (np.concatenate([block[end] for block in blocks]) for end in (2, 3))
    if known:
        rows = np.zeros((len(known), whole.shape[1]))
        for row, chosen in zip(rows, known, strict=True):
            row[np.arange(many) * len(shelf) + chosen] = 1.0
        whole = vstack([whole, csr_array(rows)])
        low, high = np.append(low, np.full(len(known), -np.inf)), np.append(high, np.full(len(known), many - 1.0))
    free = whole.shape[1] - n
    price = np.append(each * np.tile(shelf.price, many), np.zeros(free))
    ends = Bounds(np.append(np.zeros(n), np.full(free, -np.inf)), np.append(np.ones(n), np.full(free, np.inf)))
    kept, how = LinearConstraint(whole, low, high), cast("Any", {"mip_rel_gap": 0.0, "node_limit": _NODES})
    with quiet():
        found: Any = milp(
            price, integrality=np.append(np.ones(n), np.zeros(free)), bounds=ends, constraints=kept, options=how
        )
    if found.status == 2:
        return "infeasible", None
    if found.status:
        return "unproven", None
    return "optimal", np.asarray(found.x[:n]).reshape(many, -1).argmax(axis=1)
