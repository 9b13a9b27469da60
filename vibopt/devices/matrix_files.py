"""Matrices of a structure from files: Matrix Market (.mtx) and NumPy (.npz), with what can be wrong in them."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path as FilePath
from typing import Any

import numpy as np

from vibopt.errors import QuantityError

SYMMETRIC = 1e-10
"""Part of its greatest entry by which a matrix may differ from its transpose: rounding of an export."""
_TINY = 1e-12
WORDS = {"M": "mass", "C": "damping", "K": "stiffness"}


def matrix_of(file: FilePath, key: str = "") -> Any:
    """One symmetric real matrix of a file, sparse by columns.

    Parameters
    ----------
    file
        Where it lies: .mtx, or .npz as scipy.sparse.save_npz writes it.
    key
        "M", "C" or "K" of a .npz with several matrices.

    Raises
    ------
    QuantityError
        The file or the matrix cannot be used; the text continues `path = "file" `.
    """
    try:
        stamp = file.stat()
    except OSError:
        raise QuantityError(
            f"is not there. vibopt looked for {file}; write it as seen from the problem file."
        ) from None
    return _matrix_at(file, key, stamp.st_mtime_ns, stamp.st_size)


def keys_of(file: FilePath) -> set[str]:
    """Which of M, C and K a .npz file has.

    Raises
    ------
    QuantityError
        It is not there, or no .npz.
    """
    if file.suffix.lower() != ".npz":
        raise QuantityError('is no .npz file. Write mass = "m.mtx" and stiffness = "k.mtx" for single files.')
    if not file.is_file():
        raise QuantityError(f"is not there. vibopt looked for {file}; write it as seen from the problem file.")
    names = _opened(file).keys()
    return {key for key in WORDS if key in names or f"{key}_data" in names}


@lru_cache(maxsize=16)
def _matrix_at(file: FilePath, key: str, changed: int, size: int) -> Any:
    """The matrix of a file as it is now: a file that has changed is read again."""
    raw = _read(file, key)
    which = f"Its matrix {key}" if key else "It"
    whole = _plain(raw, which)
    return _symmetric(whole, which)


def _read(file: FilePath, key: str) -> Any:
    ending = file.suffix.lower()
    if ending == ".npz":
        return _from_npz(file, key)
    if ending != ".mtx":
        raise QuantityError(
            "is in no format that vibopt reads. Give a Matrix Market file (.mtx) or a NumPy file (.npz)."
        )
    from scipy.io import mmread

    try:
        return mmread(file)
    except (ValueError, TypeError, OverflowError, StopIteration) as error:
        reason = str(error).rstrip(".") or "it is cut off"
        raise QuantityError(
            f"is no valid Matrix Market file: {reason}. Write it anew, for example with scipy.io.mmwrite."
        ) from None


def _opened(file: FilePath) -> dict[str, Any]:
    try:
        with file.open("rb") as raw, np.load(raw, allow_pickle=False) as held:
            return {name: held[name] for name in held.files}
    except (ValueError, OSError, EOFError, KeyError) as error:
        if "pickle" in str(error):
            raise QuantityError(
                "holds Python objects, which vibopt does not open. Save each matrix with scipy.sparse.save_npz, or "
                "as a dense array."
            ) from None
        raise QuantityError("is no valid .npz file. Write it anew with numpy.savez or scipy.sparse.save_npz.") from None
    except Exception as error:  # a damaged archive raises what the archive reader likes
        if type(error).__module__ in ("zipfile", "zlib"):
            raise QuantityError(
                "is no valid .npz file. Write it anew with numpy.savez or scipy.sparse.save_npz."
            ) from None
        raise


def _from_npz(file: FilePath, key: str) -> Any:
    from scipy.sparse import csc_array, load_npz

    held = _opened(file)
    if not key:
        if "format" not in held:
            raise QuantityError(
                'holds no single sparse matrix. Save it with scipy.sparse.save_npz, or write file = "..." for a file '
                "with the matrices M, K and C."
            )
        return load_npz(file)
    if key in held:
        return held[key]
    names = [f"{key}_{part}" for part in ("data", "indices", "indptr", "shape")]
    if any(name not in held for name in names):
        raise QuantityError(f"has {key}_data, but not {key}_indices, {key}_indptr and {key}_shape with it.")
    data, indices, indptr, shape = (held[name] for name in names)
    rows, columns = (int(one) for one in np.ravel(shape))
    return csc_array((data, indices, indptr), shape=(rows, columns))


def _plain(raw: Any, which: str) -> Any:
    """Real, square, finite, in doubles."""
    from scipy.sparse import csc_array

    if getattr(raw, "ndim", 0) != 2 or raw.dtype.kind not in "fiubc":
        raise QuantityError(f"cannot be used. {which} is no table of numbers with rows and columns.")
    if raw.dtype.kind == "c":
        raise QuantityError(
            f"cannot be used. {which} has complex values; mass, damping and stiffness are real. Write structural "
            "damping as loss_factor = 0.02."
        )
    if raw.shape[0] != raw.shape[1]:
        raise QuantityError(
            f"cannot be used. {which} is not square: {raw.shape[0]} rows, {raw.shape[1]} columns. "
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
    return whole


def _symmetric(whole: Any, which: str) -> Any:
    mirrored = whole.T.tocsc()
    apart = abs(whole - mirrored).tocoo()
    largest = float(np.abs(whole.data).max(initial=0.0))
    if apart.nnz and float(apart.data.max()) > SYMMETRIC * largest:
        worst = int(apart.data.argmax())
        i, j = sorted((int(apart.row[worst]), int(apart.col[worst])))
        raise QuantityError(
            f"cannot be used. {which} is not symmetric: row {i}, column {j} has {whole[i, j]:g}, but row {j}, column "
            f"{i} has {whole[j, i]:g} (counted from 0). Write both triangles alike, or one triangle of a file that "
            'says "symmetric" in its first line.'
        )
    return ((whole + mirrored) * 0.5).tocsc()


def mass_fault(mass: Any, which: str = "It") -> str:
    """Why a matrix is no mass matrix; "" when it is one."""
    from vibopt.mechanics.host.matrices import negative_count

    diagonal = mass.diagonal()
    least = int(diagonal.argmin())
    if diagonal[least] <= 0.0:
        return (
            f"cannot be used. {which} has the mass {diagonal[least]:g} kg at coordinate {least} (counted from 0); a "
            "mass is positive. Leave a coordinate without mass out (static condensation)."
        )
    if negative_count(mass) != 0:
        return (
            f"cannot be used. {which} is not positive definite: some motion would have a negative mass. Check signs "
            "and units of the export."
        )
    return ""


def holding_fault(matrix: Any, mass: Any, what: str, which: str = "It") -> str:
    """Why a stiffness or damping matrix gives energy away; "" when it does not."""
    from vibopt.mechanics.host.matrices import negative_count

    diagonal = matrix.diagonal()
    if not matrix.nnz:
        return ""
    least = int(diagonal.argmin())
    if diagonal[least] < 0.0:
        return (
            f"cannot be used. {which} has {diagonal[least]:g} at coordinate {least} (counted from 0); a {what} is not "
            "negative. Check signs and units of the export."
        )
    size = float((np.abs(diagonal) / mass.diagonal()).max())
    if negative_count(matrix + _TINY * size * mass) > 0:
        moved = "would be pushed on instead of held back" if what == "stiffness" else "would gain energy"
        return (
            f"cannot be used. {which} has a negative eigenvalue: some motion {moved}. Check signs and units of the "
            "export."
        )
    return ""
