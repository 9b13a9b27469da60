"""Properties of links, as limits or goals."""

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from vibopt.forms import Form, Monomials
from vibopt.mechanics.machine import Machine
from vibopt.mechanics.model import DAMPING, STIFFNESS, Model, Term
from vibopt.responses.response import Response
from vibopt.signals import Combine, Drive


def owned_by(model: Model, owner: str, kind: int, *, weighs: bool = False) -> Monomials:
    """The terms of one kind that belong to one body or link; with `weighs` those on which gravity acts."""
    chosen = [term for term in model.terms if term.owner == owner and term.kind == kind]
    return sum_of(model, [term for term in chosen if term.static_scale or not weighs])


def sum_of(model: Model, chosen: Sequence[Term]) -> Monomials:
    """The sum of some terms; of none it is zero."""
    exponents = np.array([term.exponents for term in chosen]).reshape(len(chosen), model.n_vars)
    return Monomials(np.array([term.scale for term in chosen]), exponents)


class OfLink(Response):
    """A property of one single mount of a link.

    Keys
    ----
    of: The link, absorber or group of mounts: `of = "mount"`.
    """

    of: str
    names: ClassVar[dict[str, str]] = {"of": "link"}
    against_friction: ClassVar[str] = ""
    of_link: ClassVar[bool] = True


class OfMount(OfLink):
    """Stiffness or damping, by the kind of its terms."""

    moves: ClassVar[str] = "line"
    of_mount: ClassVar[str] = "alike"
    kind: ClassVar[int]

    def form(self, model: Model, drives: tuple[Drive, ...], combine: Combine) -> Form:
        return _single(model, self.of, owned_by(model, self.of, self.kind))

    def measure_static(self, machine: Machine) -> float:
        joint = machine.joint(self.of)
        return (joint.stiffness if self.kind == STIFFNESS else joint.damping) / joint.count


class Stiffness(OfMount):
    """`response = "stiffness"`: of one single mount [N/m]."""

    dimension: ClassVar[str] = "stiffness"
    twin: ClassVar[str] = "torsional_stiffness"
    kind: ClassVar[int] = STIFFNESS


class Damping(OfMount):
    """`response = "damping"`: viscous, of one single mount [N s/m]."""

    dimension: ClassVar[str] = "damping"
    twin: ClassVar[str] = "torsional_damping"
    kind: ClassVar[int] = DAMPING


class FrictionForce(OfLink):
    """`response = "friction_force"`: dry friction of one single mount [N]."""

    dimension: ClassVar[str] = "force"
    moves: ClassVar[str] = "line"

    def form(self, model: Model, drives: tuple[Drive, ...], combine: Combine) -> Form:
        return _single(model, self.of, Monomials.of(model, model.properties[self.of, "friction_force"]))

    def measure_static(self, machine: Machine) -> float:
        joint = machine.joint(self.of)
        return joint.friction / joint.count


class Count(OfLink):
    """`response = "count"`: number of mounts in a link."""

    dimension: ClassVar[str] = "count"
    of_mount: ClassVar[str] = "group"

    def form(self, model: Model, drives: tuple[Drive, ...], combine: Combine) -> Form:
        return Monomials.of(model, model.counts[self.of])

    def measure_static(self, machine: Machine) -> float:
        return machine.joint(self.of).count


def _single(model: Model, link: str, whole: Monomials) -> Monomials:
    """Divide by the number of mounts in the link."""
    count = model.counts[link]
    return Monomials(whole.scale / count.scale, whole.exponents - count.row(model.n_vars))
