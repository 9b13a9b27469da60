"""All methods by name, each made when it is asked for: nobody needs more than a few."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any, cast

from vibopt.errors import InputError, way_out
from vibopt.solve.method import Method


def _late(module: str, kind: str, **given: Any) -> Callable[[], Method]:
    def make() -> Method:
        made: Method = getattr(import_module(f"vibopt.solve.{module}"), kind)(**given)
        return made

    return make


METHODS: dict[str, Callable[[], Method]] = {
    "closed_form": _late("outer", "OneVariable"),
    "closed_form_kc": _late("closed_form", "StiffnessAndDamping"),
    "tangents": _late("tangents", "Tangents"),
    "each_listed": _late("choose", "each_listed"),
    "round_and_exchange": _late("round_and_exchange", "RoundAndExchange"),
    "one_range": _late("one_range", "OneRange"),
    "discs": _late("plane.discs", "DiscsOfOneLink"),
    "branch_and_bound": _late("global_search", "BranchAndBound"),
    "nlp": _late("nlp", "Nlp"),
    "catalogue": _late("catalogue.parts", "Catalogue"),
    "grid": _late("rivals.grid", "Grid"),
    "slsqp": _late("rivals.general", "Slsqp"),
    "slsqp_peaks": _late("rivals.general", "OnPeaks"),
    "slsqp_exchange": _late("rivals.general", "Exchange"),
    "equal_peaks": _late("rivals.equal_peaks", "EqualPeaks"),
    "trust_constr": _late("rivals.general", "TrustConstr"),
    "ipopt_sampled": _late("rivals.general", "IpoptSampled"),
    "cvxpy_sampled": _late("rivals.convex_sampled", "Convex"),
    "differential_evolution": _late("rivals.population", "DifferentialEvolution"),
    "cma_es": _late("rivals.population", "CmaEs"),
    "cvxpy_dpp": _late("rivals.convex_sampled", "Convex", keep=True, name="cvxpy_dpp"),
}
"""Name and how to make the method."""

OWN = (
    "closed_form", "closed_form_kc", "discs", "branch_and_bound", "one_range", "tangents", "each_listed",
    "round_and_exchange", "nlp", "catalogue",
)  # fmt: skip
"""Those from which vibopt chooses by itself; the others only answer to --method."""


def called(method: str | Method | None) -> Method | None:
    """The method of a name, or as it is given; InputError with near names where there is none."""
    if method is None or hasattr(method, "refuses"):
        return cast("Method | None", method)
    if not isinstance(method, str) or method not in METHODS:
        raise InputError(
            f"--method {method}: there is no such method.{way_out(str(method), ['cvxpy', 'ipopt', *METHODS])}"
        )
    return METHODS[method]()
