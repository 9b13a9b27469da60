"""What a job is as a program that others solve: for cvxpy, for CasADi, or why not."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from vibopt.errors import InputError
from vibopt.records import dataclass

if TYPE_CHECKING:
    from vibopt.posed.nonlinear import NonlinearProgram
    from vibopt.scene.scene import Design

PROVEN = 1e-6
"""Gap by our own dual bound up to which what cvxpy returns is called optimal: Clarabel ends between 1e-10 and 1e-8 of
its own numbers, which limits that bind weakly multiply."""


@dataclass(frozen=True)
class Posed:
    """A job as a program that others solve.

    refuses_cvxpy, refuses_casadi
        Why there is no such program, in words; "" where there is one.
    """

    name: str
    refuses_cvxpy: str
    refuses_casadi: str
    _cvxpy: Callable[[], Any]
    _casadi: Callable[[], NonlinearProgram]
    _measured: Callable[[Mapping[str, float]], Design] | None = None

    def cvxpy(self) -> Any:
        """The `cvxpy.Problem` of a convex job.

        Returns
        -------
        cvxpy.Problem
            Variables in SI units, named by their paths (`problem.var_dict["links.mount.stiffness"]`); constraints
            labelled with the paths of their limits, each divided by its bound; the objective is the goal divided by its
            size, so that tolerances of a solver mean the same for microns and for meganewtons.

        Raises
        ------
        InputError
            The job is not convex; the text says where.
        """
        if self.refuses_cvxpy:
            raise InputError(f"{self.name}: there is no convex program: {self.refuses_cvxpy}.")
        return self._cvxpy()

    def casadi(self) -> NonlinearProgram:
        """The smooth program in CasADi, with `x`, `f`, `g`, bounds, names, and `nlpsol`.

        Raises
        ------
        InputError
            The job is not smooth; the text says where.
        """
        if self.refuses_casadi:
            raise InputError(f"{self.name}: there is no smooth program: {self.refuses_casadi}.")
        return self._casadi()

    def measured(self, values: Mapping[str, float]) -> Design:
        """The machine with a design of your own, measured at its exact peaks and by the second road.

        Parameters
        ----------
        values
            What was chosen, by path [SI], as `NonlinearProgram.values` gives it.

        Raises
        ------
        InputError
            Values are missing, or the job is a rotor, a shaft or an engine: write its weights into a copy of the file.
        """
        if self._measured is None:
            raise InputError(f"{self.name}: weights are measured from a file. Write them into a copy, and solve that.")
        return self._measured(values)


def refused(name: str, why: str) -> Posed:
    """Neither program; asking for one says why."""

    def none() -> Any:
        raise InputError(f"{name}: there is no program: {why}.")

    return Posed(name, why, why, none, none)
