"""Matrices of structures and shafts from files: Matrix Market, NumPy and CSV, with what can be wrong in them."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from pathlib import Path as FilePath
from typing import Any

import numpy as np

from vibopt.devices.matrix_contents import (
    NO_VALUES,
    Archive,
    from_archive,
    from_array,
    from_matrix_market,
    from_sheet,
)  # fmt: skip
from vibopt.errors import QuantityError, counted
from vibopt.files.reading import FileFault, Kind, Stamp, content_of, file_of, shown_name, stamp_of
from vibopt.units.parsing import LARGEST
from vibopt.values.fields import complaint

MATRIX = Kind("a matrix file", 500_000_000, "", "Name a Matrix Market file (.mtx) or a NumPy file (.npz).")
SYMMETRIC = 1e-10
"""Part of its greatest entry by which a matrix may differ from its transpose: rounding of an export."""
_TINY = 1e-12
WORDS = {"M": "mass", "C": "damping", "K": "stiffness"}


class Kept:
    """A matrix as a key: equal where it is the same object."""

    def __init__(self, matrix: Any) -> None:
        self.matrix = matrix

    def __hash__(self) -> int:
        return id(self.matrix)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Kept) and self.matrix is other.matrix


def named(given: object, read: Callable[[FilePath], object]) -> FilePath:
    """The file that a key names, looked into.

    Raises
    ------
    PydanticCustomError
        It is no name, or what it names cannot be used.
    """
    if isinstance(given, FilePath):
        return given
    if not isinstance(given, str):
        raise complaint('is no file name. Write it in quotation marks: "m.mtx".')
    try:
        read(file := file_of(given))
    except FileFault as fault:
        raise complaint(fault.text) from None
    except QuantityError as error:
        raise complaint(str(error)) from None
    return file


def matrix_of(file: FilePath, key: str = "", *, skew: bool = False) -> Any:
    """One real matrix of a file, symmetric or `skew`, sparse by columns.

    Parameters
    ----------
    file
        Where it lies: .mtx, .csv, .npy, or .npz as scipy.sparse.save_npz writes it.
    key
        "M", "C" or "K" of a .npz with several matrices.

    Raises
    ------
    QuantityError
        The file or the matrix cannot be used; the text continues `path = "file" `.
    """
    try:
        return _matrix_at(file, key, skew, stamp_of(file, MATRIX))
    except FileFault as fault:
        raise QuantityError(_fault(file, fault)) from None


def keys_of(file: FilePath) -> set[str]:
    """Which of M, C and K a .npz file has.

    Raises
    ------
    QuantityError
        It is not there, or no .npz.
    """
    if file.suffix.lower() != ".npz":
        raise QuantityError('is no .npz file. Write mass = "m.mtx" and stiffness = "k.mtx" for single files.')
    try:
        return set(_keys_at(file, stamp_of(file, MATRIX)))
    except FileFault as fault:
        raise QuantityError(_fault(file, fault)) from None


@lru_cache(maxsize=16)
def _keys_at(file: FilePath, stamp: Stamp) -> tuple[str, ...]:
    names = Archive(content_of(file, MATRIX)).names
    return tuple(key for key in WORDS if key in names or f"{key}_data" in names)


def _fault(file: FilePath, fault: FileFault) -> str:
    looked = f"vibopt looked for {shown_name(file)}; write it as seen from the problem file."
    return f"{fault.text}{looked if fault.missing else ''}"


@lru_cache(maxsize=16)
def _matrix_at(file: FilePath, key: str, skew: bool, stamp: Stamp) -> Any:
    """The matrix of a file as it is now: a file that has changed is read again."""
    raw = _read(file, key)
    which = f"Its matrix {key}" if key else "It"
    whole = _plain(raw, which)
    return _mirrored(whole, which, -1 if skew else 1)


def _read(file: FilePath, key: str) -> Any:
    ending = file.suffix.lower()
    if ending == ".npz":
        return from_archive(Archive(content_of(file, MATRIX)), key)
    if ending == ".npy":
        return from_array(content_of(file, MATRIX))
    if ending == ".csv":
        return from_sheet(file)
    if ending != ".mtx":
        raise QuantityError(
            "is in no format that vibopt reads. Give a Matrix Market file (.mtx), a NumPy file (.npy, .npz) or a table "
            "(.csv)."
        )
    return from_matrix_market(content_of(file, MATRIX))


def _plain(raw: Any, which: str) -> Any:
    """Real, square, finite, in doubles."""
    from scipy.sparse import csc_array

    if getattr(raw, "ndim", 0) != 2 or raw.dtype.kind not in "fiubc":
        raise QuantityError(f"cannot be used. {which} is no table of numbers with rows and columns.")
    if raw.dtype.kind == "b":
        raise QuantityError(f"cannot be used. {which} {NO_VALUES}")
    if raw.dtype.kind == "c":
        raise QuantityError(
            f"cannot be used. {which} has complex values; mass, damping and stiffness are real. Write structural "
            "damping as loss_factor = 0.02."
        )
    if raw.shape[0] != raw.shape[1]:
        raise QuantityError(
            f"cannot be used. {which} is not square: {counted(raw.shape[0], 'rows')}, "
            f"{counted(raw.shape[1], 'columns')}. "
            "Export the whole matrix."
        )
    whole = csc_array(raw, dtype=float)
    whole.sum_duplicates()
    if not np.isfinite(whole.data).all():
        bad = int(np.flatnonzero(~np.isfinite(whole.data))[0])
        column = int(np.searchsorted(whole.indptr, bad, side="right")) - 1
        raise QuantityError(
            f"cannot be used. {which} has {whole.data[bad]} at row {whole.indices[bad]}, column {column} (counted "
            "from 0), which is no number. Correct the export."
        )
    whole.eliminate_zeros()
    largest = float(np.abs(whole.data).max(initial=0.0))
    if largest and not 1.0 / LARGEST <= largest <= LARGEST:
        said = f"an entry of {largest:g}" if largest > 1.0 else f"no entry greater than {largest:g}"
        raise QuantityError(f"cannot be used. {which} has {said}, which no machine has. Check the units of the export.")
    return whole


_UNLIKE = {
    1: "{which} is not symmetric: row {i}, column {j} has {here:g}, but row {j}, column {i} has {there:g} (counted "
    'from 0). Write both triangles alike, or one triangle of a file that says "symmetric" in its first line.',
    -1: "{which} is not skew: row {i}, column {j} has {here:g}, and row {j}, column {i} has {there:g} (counted from "
    "0), where gyroscopic moments have the opposite. Give the matrix that the speed of rotation is multiplied by, "
    "without damping.",
}


def _mirrored(whole: Any, which: str, sign: int) -> Any:
    """A matrix that is its own transpose (1), or the opposite of it (-1), freed of rounding."""
    turned = sign * whole.T.tocsc()
    apart = abs(whole - turned).tocoo()
    largest = float(np.abs(whole.data).max(initial=0.0))
    if apart.nnz and float(apart.data.max()) > SYMMETRIC * largest:
        worst = int(apart.data.argmax())
        i, j = sorted((int(apart.row[worst]), int(apart.col[worst])))
        said = _UNLIKE[sign].format(which=which, i=i, j=j, here=whole[i, j], there=whole[j, i])
        raise QuantityError(f"cannot be used. {said}")
    return ((whole + turned) * 0.5).tocsc()


def mass_fault(mass: Any, which: str = "It") -> str:
    """Why a matrix is no mass matrix; "" when it is one, coordinates without any mass left out."""
    from vibopt.mechanics.host.condense import massless
    from vibopt.mechanics.host.matrices import negative_count

    diagonal = mass.diagonal()
    there = np.setdiff1d(np.arange(len(diagonal)), massless(mass))
    if not len(there):
        return f"cannot be used. {which} is empty: nothing has a mass. Check the export."
    least = int(there[diagonal[there].argmin()])
    if diagonal[least] <= 0.0:
        return (
            f"cannot be used. {which} has the mass {diagonal[least]:g} kg at coordinate {least} (counted from 0); a "
            "mass is positive. Leave a coordinate without mass out (static condensation)."
        )
    if negative_count(mass[there][:, there]) != 0:
        return (
            f"cannot be used. {which} is not positive definite: some motion would have a negative mass. Check signs "
            "and units of the export."
        )
    return ""


def sign_fault(matrix: Any, what: str, which: str = "It") -> str:
    """Why a stiffness or damping matrix cannot be one, by its diagonal; "" where nothing is seen."""
    diagonal = matrix.diagonal()
    least = int(diagonal.argmin())
    if not matrix.nnz or diagonal[least] >= 0.0:
        return ""
    return (
        f"cannot be used. {which} has {diagonal[least]:g} at coordinate {least} (counted from 0); a {what} is not "
        "negative. Check signs and units of the export."
    )


def holding_fault(matrix: Any, mass: Any, what: str, which: str = "It") -> str:
    """Why a stiffness matrix holds nothing, or it or a damping matrix gives energy away; "" when all is well."""
    from vibopt.mechanics.host.matrices import negative_count

    if not matrix.nnz:
        empty = f"cannot be used. {which} is empty: nothing that has a mass has a stiffness. Check the export."
        return empty if what == "stiffness" else ""
    diagonal = matrix.diagonal()
    size = float((np.abs(diagonal) / mass.diagonal()).max())
    if not size or negative_count(matrix + _TINY * size * mass) > 0:  # entries beside an empty diagonal pull both ways
        moved = "would be pushed on instead of held back" if what == "stiffness" else "would gain energy"
        return (
            f"cannot be used. {which} has a negative eigenvalue: some motion {moved}. Check signs and units of the "
            "export."
        )
    return ""
