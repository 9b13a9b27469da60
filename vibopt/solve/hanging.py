"""What hangs by a spring that is to be chosen: absorbers, and bodies on links that nothing loads and nobody asks of."""

from __future__ import annotations

from collections.abc import Mapping

from vibopt.mechanics.model import INERTIA
from vibopt.program.program import Program
from vibopt.records import dataclass

SPRINGS = {"frequency", "tuning", "stiffness", "torsional_stiffness"}


@dataclass(frozen=True, slots=True)
class MassOnSpring:
    """A mass on a spring: its variables by their words, its mass where that is known, and how it is carried."""

    axes: dict[str, int]
    mass: float
    depth: int
    last: bool
    host: str

    @property
    def weight(self) -> int:
        """Which variable its mass is, -1 where it is known or others ride on it."""
        return next(
            (self.axes[word] for word in ("mass", "mass_ratio", "inertia") if self.last and word in self.axes), -1
        )


def masses_on_springs(program: Program) -> list[MassOnSpring]:
    """What has a spring to be chosen between a host and a mass of its own."""
    model, owners = program.model, dict[str, dict[str, int]]()
    for index, axis in enumerate(program.axes):
        path, _, word = axis.path.rpartition(".")
        owners.setdefault(path.partition(".")[2], {})[word] = index
    hung = _hung(program)
    springs = {name: hung[name] for name, axes in owners.items() if SPRINGS & set(axes) and name in hung}
    hosts, found = dict(springs.values()), list[MassOnSpring]()
    for name, (end, first) in springs.items():
        depth, host = 0, first
        while host in hosts and depth < len(hosts):
            depth, host = depth + 1, hosts[host]
        axes = dict(owners[name])
        for other in (end, *(one for one, there in hung.items() if there == (end, first))):
            axes = {**owners.get(other, {}), **axes}
        own = [term for term in model.terms if term.owner == end and term.kind == INERTIA]
        mass = sum(term.scale for term in own if not term.exponents.any())
        found.append(MassOnSpring(axes, mass, depth, end not in hosts.values(), first))
    return found


def _hung(program: Program) -> dict[str, tuple[str, str]]:
    """By each absorber and each link that something hangs by: what that is, and from what; from the outside in."""
    model = program.model
    found = {
        name: (name, next((one for one in ends if one != name), ""))
        for name, ends in model.ends.items() if name in model.points
    }  # fmt: skip
    left = {name: ends for name, ends in model.ends.items() if name not in found}
    while outermost := _outermost(program, left):
        found |= outermost
        left = {name: ends for name, ends in left.items() if name not in outermost}
    return found


def _outermost(program: Program, left: Mapping[str, tuple[str, str]]) -> dict[str, tuple[str, str]]:
    """The links, of those left, by which one body hangs at which no other ends; none where there is no such body."""
    for ends in left.values():
        for end, host in (ends, ends[::-1]):
            names = [name for name, its in left.items() if end in its]
            if all({*left[name]} == {*ends} for name in names) and _hangs(program, end, host):
                return dict.fromkeys(names, (end, host))
    return {}


def _hangs(program: Program, end: str, host: str) -> bool:
    """Whether a body with one mass and its host move freely, and nothing loads it or asks of it alone."""
    if sum(term.owner == end and term.kind == INERTIA for term in program.model.terms) != 1:
        return False
    for model, parts in [(program.model, ()), *((part.model, (part,)) for part in program.parts)]:
        rows = [model.points[name] for name in (end, host) if name in model.points]
        if len(rows) < 2 and model is not program.model:  # it is none of what this part needs
            continue
        if len(rows) < 2 or not all(row[: model.n_free].any() for row in rows):
            return False
        for part in parts:
            read = None if part.form.harmonic is None else part.form.harmonic.output.row
            if any(line.vector @ rows[0] for drive in part.form.drives for line in drive.lines):
                return False
            if read is not None and read @ rows[0] and not read @ rows[1]:
                return False
    return True
