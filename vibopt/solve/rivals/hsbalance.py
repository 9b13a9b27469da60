"""hsbalance 0.5.5 as its authors published it: a rival for the charts, where it is installed."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext
from functools import partialmethod
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import numpy as np

from vibopt.arrays import ComplexArray, FloatArray

HOW = "pip install hsbalance==0.5.5"


def installed() -> bool:
    """Whether Python finds it; it is not loaded for that."""
    return find_spec("hsbalance") is not None


class Model:
    """One question in its terms.

    Parameters
    ----------
    y0, H
        Readings (n_readings,) and response per unbalance (n_readings, n_planes).
    caps
        Greatest correction (n_planes,), inf where there is none.
    clarabel
        Whether it is given Clarabel; else the solver is what cvxpy takes by itself.
    """

    def __init__(self, y0: ComplexArray, H: ComplexArray, caps: FloatArray, *, clarabel: bool = False) -> None:
        self._library: Any = import_module("hsbalance")
        self._y0 = y0[:, None]
        self._alpha = self._library.Alpha()
        self._alpha.add(H)
        self._caps = {plane: float(cap) for plane, cap in enumerate(caps) if np.isfinite(cap)}
        self._clarabel = clarabel

    def least_squares(self) -> ComplexArray:
        return self._solved(self._library.LeastSquares(A=self._y0, alpha=self._alpha))

    def huber(self) -> ComplexArray:
        """Its Huber smoother has no threshold to set."""
        return self._solved(self._library.LeastSquares(A=self._y0, alpha=self._alpha), solver="Huber")

    def worst(self) -> ComplexArray:
        return self._solved(self._worst())

    def critical(self, sensors: Sequence[int], limit: float) -> ComplexArray:
        """Smallest worst of these sensors while every other keeps the limit."""
        model = self._library.LMI(
            A=self._y0, alpha=self._alpha, weight_const=self._caps, critical_planes=set(sensors), V_max=limit
        )
        with _quiet():  # it names its solver itself
            return _column(model.solve())

    def split(self, holes: Sequence[float], weights: Sequence[float]) -> ComplexArray:
        """Smallest worst residual, then each plane by itself split over holes [deg] and weights, at most one a hole."""
        model = self._worst()
        self._solved(model)
        with _quiet():
            for plane in range(model.N):
                part = model.create_split()
                part.split_setup(plane, list(holes), list(weights), 1, float(max(weights)))
                part.split_solve()
                part.update(confirm=True)
        return _column(model.W)

    def _worst(self) -> Any:
        return self._library.Min_max(A=self._y0, alpha=self._alpha, weight_const=self._caps)

    def _solved(self, model: Any, **given: Any) -> ComplexArray:
        with _quiet(), _clarabel() if self._clarabel else nullcontext():
            return _column(model.solve(**given))


def _column(found: Any) -> ComplexArray:
    if found is None:
        raise ValueError("no correction came back")
    u: ComplexArray = np.asarray(found, dtype=complex)[:, 0]
    return u


@contextmanager
def _quiet() -> Iterator[None]:
    """Its solvers warn of licences and of how its programs are written; neither belongs into a chart."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


@contextmanager
def _clarabel() -> Iterator[None]:
    """It leaves the choice of the solver to cvxpy, which may take one whose free licence ends at 200 rows."""
    import cvxpy as cp

    own = cp.Problem.solve
    cp.Problem.solve = partialmethod(own, solver="CLARABEL")
    try:
        yield
    finally:
        cp.Problem.solve = own
