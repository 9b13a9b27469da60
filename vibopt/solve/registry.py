"""All methods by name.  Each is loaded when it is asked for."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any

from vibopt.solve.method import Method


def _late(module: str, kind: str, **given: Any) -> Callable[[], Method]:
    def make() -> Method:
        made: Method = getattr(import_module(f"vibopt.solve.{module}"), kind)(**given)
        return made

    return make


METHODS: dict[str, Callable[[], Method]] = {
    "closed_form": _late("outer", "OneVariable"),
    "closed_form_kc": _late("closed_form", "StiffnessAndDamping"),
    "each_listed": _late("each_listed", "EachListed"),
    "one_range": _late("one_range", "OneRange"),
    "discs": _late("plane.method", "DiscsOfOneLink"),
    "branch_and_bound": _late("global_search", "BranchAndBound"),
    "nlp": _late("nlp", "Nlp"),
    "catalogue": _late("shelf.method", "Catalogue"),
    "grid": _late("rivals.grid", "Grid"),
    "slsqp": _late("rivals.general", "Slsqp"),
    "slsqp_50": _late("rivals.general", "Slsqp", speeds=50, name="slsqp_50"),
    "slsqp_1000": _late("rivals.general", "Slsqp", speeds=1000, name="slsqp_1000"),
    "slsqp_exchange": _late("rivals.general", "Exchange"),
    "equal_peaks": _late("rivals.equal_peaks", "EqualPeaks"),
    "trust_constr": _late("rivals.general", "TrustConstr"),
    "trust_constr_50": _late("rivals.general", "TrustConstr", speeds=50, name="trust_constr_50"),
    "trust_constr_1000": _late("rivals.general", "TrustConstr", speeds=1000, name="trust_constr_1000"),
    "ipopt_sampled": _late("rivals.general", "IpoptSampled"),
    "ipopt_sampled_1000": _late("rivals.general", "IpoptSampled", speeds=1000, name="ipopt_sampled_1000"),
    "cvxpy_sampled": _late("rivals.convex", "Convex"),
    "cvxpy_dpp": _late("rivals.convex", "Convex", keep=True, name="cvxpy_dpp"),
}
"""Name and how to make the method."""

OWN = ("closed_form", "closed_form_kc", "discs", "branch_and_bound", "one_range", "each_listed", "nlp", "catalogue")
"""Those from which vibopt chooses by itself; the others only answer to --method."""
