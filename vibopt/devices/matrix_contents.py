"""What stands in a matrix file, checked before anything of its size is made: Matrix Market, NumPy and CSV."""

from __future__ import annotations

import re
import tokenize
import warnings
import zipfile
import zlib
from codecs import BOM_UTF8
from io import BytesIO
from pathlib import Path as FilePath
from typing import Any, NoReturn

import numpy as np

from vibopt.arrays import FloatArray
from vibopt.errors import InputError, QuantityError, counted
from vibopt.records import dataclass
from vibopt.values.csv_tables import sheet_of

MOST_ROWS = 100_000
"""Most degrees of freedom of a structure."""
MOST_ENTRIES = 20_000_000
"""Most entries of one matrix, dense or sparse."""
NO_VALUES = "says where its entries are, but not their values. Export the matrix with its values."
_BANNER = re.compile(
    rb"%%MatrixMarket\s+matrix\s+(coordinate|array)\s+(real|double|integer|pattern|complex)\s+"
    rb"(general|symmetric|skew-symmetric|hermitian)\s*\Z",
    re.IGNORECASE,
)
_COMMENTS = re.compile(rb"(?:[ \t\r]*(?:%[^\n]*)?\n)*")
_GLUED = re.compile(rb"[0-9.][+-]")
"""A number whose exponent has lost its letter, or two without a blank between them."""
_LEAST_BYTES = {"array": 2, "coordinate": 4}
"""Bytes that one entry takes at least, with the end of its line."""
_MATRIX_MARKET = "is no valid Matrix Market file: {}. Write it anew, for example with scipy.io.mmwrite."
_NPY = "is no valid .npy file. Write it anew with numpy.save."
_NPZ = "is no valid .npz file. Write it anew with numpy.savez or scipy.sparse.save_npz."
_DAMAGED = (ValueError, TypeError, OverflowError, OSError, EOFError, KeyError, RuntimeError, NotImplementedError,
            zipfile.BadZipFile, zlib.error, SyntaxError, tokenize.TokenError, MemoryError, AttributeError)  # fmt: skip


@dataclass(frozen=True, slots=True)
class _Market:
    """What a Matrix Market file says of itself: form, field, symmetry, sizes and number of entries, and its body."""

    form: str
    field: str
    symmetry: str
    rows: int
    columns: int
    count: int
    body: bytes


def from_matrix_market(content: bytes) -> Any:
    """The matrix of a Matrix Market file: dense, or sparse by places.

    Raises
    ------
    QuantityError
        It is no such file, or says sizes that it cannot hold.
    """
    said = _said(content.removeprefix(BOM_UTF8))
    parts = 2 if said.field == "complex" else 1
    wide = parts + (2 if said.form == "coordinate" else 0)
    table = _numbers(said.body)
    if len(table) != said.count * wide:
        raise QuantityError(_MATRIX_MARKET.format("it has not as many numbers as it says"))
    table = table.reshape(said.count, wide)
    last = table[:, wide - parts :]
    values = last[:, 0] if parts == 1 else last[:, 0] + 1j * last[:, 1]
    return _of_places(said, table[:, :2], values) if said.form == "coordinate" else _of_columns(said, values)


def _said(content: bytes) -> _Market:
    """Its first lines, looked at before anything of their sizes is made."""
    banner, _, rest = content.partition(b"\n")
    match = _BANNER.match(banner)
    if not match:
        raise QuantityError(_MATRIX_MARKET.format("its first line does not say so"))
    form, field, symmetry = (group.decode().lower() for group in match.groups())
    if field == "pattern":
        raise QuantityError(f"cannot be used. It {NO_VALUES}")
    start = _COMMENTS.match(rest)
    line, _, body = rest[start.end() if start else 0 :].partition(b"\n")
    sizes = line.split()
    if len(sizes) != (3 if form == "coordinate" else 2) or not all(size.isdigit() and len(size) < 20 for size in sizes):
        raise QuantityError(_MATRIX_MARKET.format("the line behind its comments has no sizes"))
    rows, columns, *entries = map(int, sizes)
    _check_sizes(rows, columns)
    if symmetry != "general" and rows != columns:
        raise QuantityError(_MATRIX_MARKET.format("it says a symmetry, but its sides are not alike"))
    half = rows * (rows - 1) // 2 + (0 if symmetry == "skew-symmetric" else rows)
    count = entries[0] if entries else rows * columns if symmetry == "general" else half
    if count > MOST_ENTRIES:
        _too_many(count)
    if count * _LEAST_BYTES[form] > len(body) + 1:
        raise QuantityError(_MATRIX_MARKET.format(f"it says {count} entries, more than the file can hold"))
    return _Market(form, field, symmetry, rows, columns, count, body)


def _numbers(text: bytes) -> FloatArray:
    """Numbers between blanks, and nothing else."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # what cannot be read is only warned of
        try:
            if _GLUED.search(text):
                raise ValueError
            return np.fromstring(text, sep=" ") if text.strip() else np.zeros(0)
        except (ValueError, Warning):
            raise QuantityError(_MATRIX_MARKET.format("not all of its entries are numbers")) from None


def _of_places(said: _Market, places: FloatArray, values: Any) -> Any:
    """A sparse matrix from places (n, 2), counted from 1, with the triangle that is not written."""
    from scipy.sparse import coo_array

    rows, columns, kind = said.rows, said.columns, said.symmetry
    whole = (places == np.floor(places)).all() and (places >= 1).all() and (places <= (rows, columns)).all()
    if not whole:
        raise QuantityError(_MATRIX_MARKET.format(f"a place is not a whole number from 1 to {rows}"))
    i, j = (places.T - 1).astype(np.int64)
    apart = (i != j) & (kind != "general")
    other = _mirrored(values[apart], kind)
    data, row, column = np.concatenate([values, other]), np.concatenate([i, j[apart]]), np.concatenate([j, i[apart]])
    return coo_array((data, (row, column)), shape=(rows, columns))


def _of_columns(said: _Market, values: Any) -> Any:
    """A dense matrix from its columns, or from those of its lower triangle."""
    rows, columns, kind = said.rows, said.columns, said.symmetry
    if kind == "general":
        return values.reshape(columns, rows).T
    j, i = np.triu_indices(rows, 1 if kind == "skew-symmetric" else 0)
    made = np.zeros((rows, rows), values.dtype)
    made[j, i] = _mirrored(values, kind)
    made[i, j] = values
    return made


def _mirrored(values: Any, kind: str) -> Any:
    """Entries above the diagonal from those below it."""
    return -values if kind == "skew-symmetric" else values.conj() if kind == "hermitian" else values


def _check_sizes(rows: int, columns: int) -> None:
    shape = f"{counted(rows, 'rows')} and {counted(columns, 'columns')}"
    if not rows or not columns:
        raise QuantityError(f"cannot be used. It is empty: {shape}. Export the whole matrix.")
    if max(rows, columns) > MOST_ROWS:
        raise QuantityError(f"cannot be used. It has {shape}; {MOST_ROWS} degrees of freedom are the most.")


def _too_many(count: int) -> NoReturn:
    raise QuantityError(f"cannot be used. It has {count} entries; {MOST_ENTRIES} are the most.")


class Archive:
    """The arrays of a .npz file, each read when it is asked for, after its size is known.

    Parameters
    ----------
    content
        The whole file.

    Raises
    ------
    QuantityError
        It is no archive of arrays.
    """

    def __init__(self, content: bytes) -> None:
        try:
            self._held = zipfile.ZipFile(BytesIO(content))
        except _DAMAGED:
            raise QuantityError(_NPZ) from None
        self.names = {one.removesuffix(".npy") for one in self._held.namelist()}

    def array(self, name: str) -> Any:
        """One array; QuantityError where it is damaged, too large, or no array of numbers."""
        try:
            info = self._held.getinfo(f"{name}.npy")
            with self._held.open(info) as raw:
                shape, dtype = _header(raw)
                if not dtype.hasobject and int(np.prod(shape, dtype=object)) * dtype.itemsize > info.file_size:
                    raise QuantityError(_NPZ)
            if dtype.hasobject:
                raise QuantityError(
                    "holds Python objects, which vibopt does not open. Save each matrix with scipy.sparse.save_npz, or "
                    "as a dense array."
                )
            if info.file_size > 16 * MOST_ENTRIES:
                _too_many(int(np.prod(shape, dtype=object)))
            with self._held.open(info) as raw:
                return np.lib.format.read_array(raw, allow_pickle=False)
        except _DAMAGED as error:
            if isinstance(error, QuantityError):
                raise
            raise QuantityError(_NPZ) from None


def _header(raw: Any) -> tuple[tuple[int, ...], np.dtype[Any]]:
    """Shape and kind of numbers of a .npy file, before its numbers are read."""
    version = np.lib.format.read_magic(raw)
    read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    shape, _, dtype = read(raw)
    return shape, dtype


def from_array(content: bytes) -> Any:
    """The array of a .npy file; QuantityError where it is damaged, too large, or no array of numbers."""
    raw = BytesIO(content)
    try:
        shape, dtype = _header(raw)
        count = int(np.prod(shape, dtype=object))
        if count * dtype.itemsize > len(content):
            raise QuantityError(_NPY)
        if dtype.hasobject:
            raise QuantityError("holds Python objects, which vibopt does not open. Save a plain array of numbers.")
        if count > MOST_ENTRIES:
            _too_many(count)
        if len(shape) == 2:
            _check_sizes(*shape)
        raw.seek(0)
        return np.lib.format.read_array(raw, allow_pickle=False)
    except _DAMAGED as error:
        if isinstance(error, QuantityError):
            raise
        raise QuantityError(_NPY) from None


def from_sheet(file: FilePath) -> FloatArray:
    """The matrix of a CSV file of numbers, without headings."""
    try:
        sheet = sheet_of(file)
    except InputError as error:
        raise QuantityError(f"cannot be used: {error.messages[0]}") from None
    wide = max((len(row) for _, row in sheet.rows), default=0)
    _check_sizes(len(sheet.rows), wide)
    found = np.empty((len(sheet.rows), wide))
    for i, (number, row) in enumerate(sheet.rows):
        if len(row) != wide:
            raise QuantityError(
                f"cannot be used. Its row {number} has {counted(len(row), 'numbers')}, others have {wide}. Write the "
                "whole matrix, a row a line."
            )
        for j, cell in enumerate(row):
            try:
                found[i, j] = float(sheet.number(cell))
            except ValueError:
                raise QuantityError(
                    f'cannot be used. Its row {number} has "{cell}", which is no number. Write the numbers alone, '
                    "without headings."
                ) from None
    return found


def from_archive(held: Archive, key: str) -> Any:
    """Matrix `key` ("M", "C", "K") of an archive, or the single sparse one that it holds ("").

    Raises
    ------
    QuantityError
        It is not there whole, or its parts do not fit each other.
    """
    if not key:
        if "format" not in held.names:
            raise QuantityError(
                'holds no single sparse matrix. Save it with scipy.sparse.save_npz, or write file = "..." for a file '
                "with the matrices M, K and C."
            )
        form = held.array("format")
        word = form.item() if form.ndim == 0 else b""
        return _sparse(held, "", word.decode("ascii", "replace") if isinstance(word, bytes) else str(word))
    if key in held.names:
        whole = held.array(key)
        if whole.ndim == 2:
            _check_sizes(*whole.shape)
        return whole
    names = [f"{key}_{part}" for part in ("data", "indices", "indptr", "shape")]
    if any(name not in held.names for name in names):
        raise QuantityError(f"has {key}_data, but not {key}_indices, {key}_indptr and {key}_shape with it.")
    return _sparse(held, f"{key}_", "csc")


def _sparse(held: Archive, before: str, form: str) -> Any:
    """A sparse matrix from its parts in one of scipy's forms, with every index looked at."""
    from scipy.sparse import bsr_array, coo_array, csc_array, csr_array, dia_array

    rows, columns = _shape(held.array(f"{before}shape"), before)
    parts = {"coo": ("data", "row", "col"), "dia": ("data", "offsets")}.get(form, ("data", "indices", "indptr"))
    if any(f"{before}{part}" not in held.names for part in parts):
        raise QuantityError(_NPZ)
    data, *places = (held.array(f"{before}{part}") for part in parts)
    if data.dtype.kind not in "fiubc":
        _unfit(before, "its values are no numbers")
    if any(place.ndim != 1 or place.dtype.kind not in "iu" for place in places):
        _unfit(before, "its places are no lists of whole numbers")
    if form == "coo":
        _check_places(before, places[0], rows, len(data) if data.ndim == 1 else -1)
        _check_places(before, places[1], columns, len(data))
        return coo_array((data, (places[0], places[1])), shape=(rows, columns))
    if form == "dia":
        _check_diagonals(before, data, places[0], rows, columns)
        return dia_array((data, places[0]), shape=(rows, columns))
    high, wide = (int(one) for one in data.shape[1:]) if form == "bsr" and data.ndim == 3 else (1, 1)
    if form not in ("csc", "csr", "bsr") or data.ndim != (3 if form == "bsr" else 1):
        raise QuantityError(_NPZ)
    if not high or not wide or rows % high or columns % wide:
        _unfit(before, "its blocks do not fill it")
    along, across = (columns, rows) if form == "csc" else (rows // high, columns // wide)
    _check_pointers(before, places[1], along, len(data))
    _check_places(before, places[0], across, len(data))
    made = {"csc": csc_array, "csr": csr_array, "bsr": bsr_array}[form]
    return made((data, places[0], places[1]), shape=(rows, columns))


def _shape(given: Any, before: str) -> tuple[int, int]:
    if given.shape != (2,) or given.dtype.kind not in "iu" or (given < 0).any():
        _unfit(before, "its shape is not two whole numbers")
    rows, columns = int(given[0]), int(given[1])
    _check_sizes(rows, columns)
    return rows, columns


def _check_places(before: str, places: FloatArray, size: int, count: int) -> None:
    """As many places as values, each from 0 to size - 1."""
    if len(places) != count:
        _unfit(before, "it has not as many places as values")
    if count and not (int(places.min()) >= 0 and int(places.max()) < size):
        _unfit(before, f"a place is not between 0 and {size - 1}")


def _check_pointers(before: str, pointers: FloatArray, along: int, count: int) -> None:
    """Where each row or column begins: from 0 to the number of values, never back."""
    fits = len(pointers) == along + 1 and int(pointers[0]) == 0 and int(pointers[-1]) == count
    if not fits or (pointers[1:] < pointers[:-1]).any():
        _unfit(before, f"{before}indptr does not rise from 0 to the number of values")


def _check_diagonals(before: str, data: FloatArray, offsets: FloatArray, rows: int, columns: int) -> None:
    if data.ndim != 2 or len(data) != len(offsets) or data.shape[1] > columns or len(set(offsets.tolist())) < len(data):
        _unfit(before, "its diagonals do not fit it")
    if len(offsets) and not (-rows < int(offsets.min()) and int(offsets.max()) < columns):
        _unfit(before, "a diagonal lies outside of it")


def _unfit(before: str, why: str) -> NoReturn:
    which = f"Its matrix {before[0]}" if before else "It"
    raise QuantityError(f"cannot be used. {which} is damaged: {why}. Write the file anew.")
