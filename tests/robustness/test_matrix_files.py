"""Matrix files that would kill or fill the process: each is refused with a sentence, before anything is made of it."""

from __future__ import annotations

import io
import struct
import zipfile
from collections.abc import Callable
from contextlib import suppress
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sparse
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from scipy.io import mmread, mmwrite

from vibopt.devices.matrix_contents import from_matrix_market
from vibopt.devices.matrix_files import holding_fault, keys_of, mass_fault, matrix_of
from vibopt.errors import QuantityError

MATRIX = np.array([[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 2.0]])
FORMS = ("csc", "csr", "coo", "dia", "bsr")
HUGE = 2**62


def parts_of(form: str) -> dict[str, np.ndarray]:
    """The arrays of a good archive."""
    stream = io.BytesIO()
    sparse.save_npz(stream, sparse.coo_array(MATRIX).asformat(form))
    stream.seek(0)
    with np.load(stream) as held:
        return {name: held[name] for name in held.files}


def refused(file: Path, key: str = "") -> str:
    with pytest.raises(QuantityError) as caught:
        matrix_of(file, key)
    assert len(caught.value.complaint) < 300
    return caught.value.complaint


@pytest.mark.parametrize("form", FORMS)
def test_every_form_that_scipy_saves_is_read(form: str, tmp_path: Path) -> None:
    np.savez(tmp_path / "m.npz", **parts_of(form))
    assert (matrix_of(tmp_path / "m.npz").toarray() == MATRIX).all()


@pytest.mark.parametrize("form", ["csc", "csr", "coo", "bsr"])
@pytest.mark.parametrize("place", [-1, 3, HUGE, -HUGE])
def test_a_place_outside_of_the_matrix_is_refused(form: str, place: int, tmp_path: Path) -> None:
    parts = parts_of(form)
    name = "row" if form == "coo" else "indices"
    parts[name] = parts[name].astype(np.int64)
    parts[name][0] = place
    np.savez(tmp_path / "m.npz", **parts)
    assert "a place is not between 0 and " in refused(tmp_path / "m.npz")


@pytest.mark.parametrize(
    "pointers", [[0, 2, 5, 9], [0, 5, 2, 7], [1, 2, 5, 7], [-4, 2, 5, 7], [0, 7], [0, 2, 5, HUGE], []]
)
@pytest.mark.parametrize("form", ["csc", "csr"])
def test_pointers_that_do_not_rise_from_zero_to_the_end_are_refused(
    form: str, pointers: list[int], tmp_path: Path
) -> None:
    parts = parts_of(form)
    np.savez(tmp_path / "m.npz", **{**parts, "indptr": np.array(pointers, dtype=np.int64)})
    assert "is damaged: indptr does not rise from 0 to the number of values" in refused(tmp_path / "m.npz")
    single = {f"K_{name}": parts[name] for name in ("data", "indices", "shape")}
    np.savez(tmp_path / "k.npz", K_indptr=np.array(pointers, dtype=np.int64), **single)
    assert "Its matrix K is damaged: K_indptr does not rise" in refused(tmp_path / "k.npz", "K")


SHAPES = {
    "negative": [-3, 3], "of one number": [3], "of parts": [3.0, 3.0], "empty": [0, 0], "huge": [HUGE, HUGE],
    "a list of texts": ["3", "3"],
}  # fmt: skip


@pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)
@pytest.mark.parametrize("form", FORMS)
def test_a_shape_that_no_matrix_has_is_refused(form: str, shape: list[Any], tmp_path: Path) -> None:
    np.savez(tmp_path / "m.npz", **{**parts_of(form), "shape": np.array(shape)})
    refused(tmp_path / "m.npz")


def with_header(folder: Path, shape: object, data: bytes = b"\0" * 72) -> Path:
    """An archive whose dense K claims a shape."""
    return headed(folder, f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}", data)


def headed(folder: Path, said: str, data: bytes = b"\0" * 72) -> Path:
    """An archive whose dense K has this header."""
    header = said.encode().ljust(117) + b"\n"
    with zipfile.ZipFile(folder / "m.npz", "w") as archive:
        archive.writestr("K.npy", b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header + data)
    return folder / "m.npz"


NO_ARCHIVE = "is no valid .npz file. Write it anew with numpy.savez or scipy.sparse.save_npz."
PIECES = ("(", "{", "[", "'", "'''", "\\", "\n  ", "\0", "#", "0777", "3L", "1e999", "**", "O", "<M8", "None", ",", "é")


@settings(max_examples=200, suppress_health_check=list(HealthCheck))
@given(
    changes=st.lists(st.tuples(st.integers(0, 60), st.sampled_from(PIECES)), min_size=1, max_size=4),
    over=st.booleans(),
)
@example(changes=[(0, "(")], over=False)
@example(changes=[(10, "'''")], over=False)
@example(changes=[(0, "(" * 5000)], over=False)
def test_a_damaged_header_is_a_matrix_or_a_sentence(
    changes: list[tuple[int, str]], over: bool, tmp_path_factory: Any
) -> None:
    header = "{'descr': '<f8', 'fortran_order': False, 'shape': (3, 3), }"
    for place, piece in changes:
        header = header[:place] + piece + header[place + over :]
    with suppress(QuantityError):
        matrix_of(headed(tmp_path_factory.mktemp("m"), header), "K")


def test_a_header_that_breaks_off_in_the_middle_is_said(tmp_path: Path) -> None:
    assert refused(headed(tmp_path, "{'descr': ('<f8', "), "K") == NO_ARCHIVE


@pytest.mark.parametrize("shape", [(10**6, 10**6), (HUGE, HUGE), (4, 3), (-1, -1)])
def test_an_array_that_claims_more_than_its_file_holds_is_refused(shape: tuple[int, ...], tmp_path: Path) -> None:
    assert refused(with_header(tmp_path, shape), "K").startswith("is no valid .npz file.")


def test_a_dense_matrix_without_rows_is_refused(tmp_path: Path) -> None:
    np.savez(tmp_path / "m.npz", K=np.zeros((0, 0)))
    assert refused(tmp_path / "m.npz", "K") == (
        "cannot be used. It is empty: 0 rows and 0 columns. Export the whole matrix."
    )


NO_VALUES = "It says where its entries are, but not their values. Export the matrix with its values."


@pytest.mark.parametrize("form", ["dense", *FORMS])
def test_entries_without_values_are_no_matrix(form: str, tmp_path: Path) -> None:
    there = MATRIX != 0.0
    matrix = there if form == "dense" else sparse.coo_array(there).asformat(form)
    if form == "dense":
        np.savez(tmp_path / "m.npz", K=matrix)
    else:
        sparse.save_npz(tmp_path / "m.npz", matrix)
    said = refused(tmp_path / "m.npz", "K" if form == "dense" else "")
    assert said == f"cannot be used. {NO_VALUES if form != 'dense' else NO_VALUES.replace('It', 'Its matrix K')}"


def test_a_pattern_is_no_matrix(tmp_path: Path) -> None:
    (tmp_path / "m.mtx").write_text("%%MatrixMarket matrix coordinate pattern symmetric\n3 3 1\n1 1\n")
    assert refused(tmp_path / "m.mtx") == f"cannot be used. {NO_VALUES}"


@pytest.mark.parametrize(
    "data", [["a", "b"], np.zeros(2, "S0"), np.zeros(2, "M8[s]")], ids=["texts", "nothing", "dates"]
)
@pytest.mark.parametrize("form", FORMS)
def test_values_that_are_no_numbers_are_said(form: str, data: Any, tmp_path: Path) -> None:
    np.savez(tmp_path / "m.npz", **{**parts_of(form), "data": np.array(data)})
    assert refused(tmp_path / "m.npz") == (
        "cannot be used. It is damaged: its values are no numbers. Write the file anew."
    )


@pytest.mark.parametrize(
    ("size", "words"), [(1e-310, "no entry greater than 1e-310"), (1e-31, "no entry greater than 1e-31"),
                        (1e31, "an entry of 1e+31"), (1e300, "an entry of 1e+300")]
)  # fmt: skip
def test_entries_that_no_machine_has_are_refused(size: float, words: str, tmp_path: Path) -> None:
    np.savez(tmp_path / "m.npz", K=np.eye(3) * size)
    assert refused(tmp_path / "m.npz", "K") == (
        f"cannot be used. Its matrix K has {words}, which no machine has. Check the units of the export."
    )


def test_a_mark_of_utf_8_may_stand_before_a_matrix_market_file(tmp_path: Path) -> None:
    (tmp_path / "m.mtx").write_text(
        "%%MatrixMarket matrix coordinate real symmetric\n2 2 2\n1 1 3\n2 2 4\n", encoding="utf-8-sig"
    )
    assert (matrix_of(tmp_path / "m.mtx").toarray() == np.diag([3.0, 4.0])).all()


MARKET: dict[str, tuple[str, str]] = {
    "dense and huge": ("array real general\n1000000 1000000\n1.0\n", "1000000 rows and 1000000 columns"),
    "dense and larger than the file": ("array real general\n4000 4000\n1.0\n", "16000000 entries, more than the file"),
    "sparse and larger than the file": ("coordinate real general\n3 3 900000\n1 1 1\n", "900000 entries, more than"),
    "sparse and huge": ("coordinate real general\n3 3 99999999999\n1 1 1\n", "20000000 are the most"),
    "sparse and beyond": (
        "coordinate real symmetric\n3 3 999999999999\n1 1 1\n", "It has 999999999999 entries; 20000000 are the most"
    ),
    "beyond all numbers": (f"array real general\n{10**40} {10**40}\n1.0\n", "has no sizes"),
    "negative": ("coordinate real general\n-3 3 1\n1 1 1\n", "has no sizes"),
    "empty": ("coordinate real general\n0 0 0\n", "It is empty: 0 rows and 0 columns."),
    "a place of zero": ("coordinate real general\n3 3 1\n0 1 1.0\n", "a place is not a whole number from 1 to 3"),
    "a place beyond": ("coordinate real general\n3 3 1\n4 1 1.0\n", "a place is not a whole number from 1 to 3"),
    "a negative place": ("coordinate real general\n3 3 1\n-1 1 1.0\n", "a place is not a whole number from 1 to 3"),
    "half a place": ("coordinate real general\n3 3 1\n1.5 1 1.0\n", "a place is not a whole number from 1 to 3"),
    "no place": ("coordinate real general\n3 3 1\nnan 1 1.0\n", "a place is not a whole number from 1 to 3"),
    "cut off": ("coordinate real general\n3 3 2\n1 1 1.0     \n", "it has not as many numbers as it says"),
    "an exponent without its letter": ("coordinate real general\n3 3 1\n1 1 1.0-5\n", "not all of its entries are"),
    "a word": ("coordinate real general\n3 3 1\n1 1 secret\n", "not all of its entries are numbers"),
    "a decimal comma": ("coordinate real general\n3 3 1\n1 1 1,5\n", "not all of its entries are numbers"),
    "a symmetry of unlike sides": ("coordinate real symmetric\n3 2 1\n1 1 1\n", "its sides are not alike"),
    "no banner": ("root:x:0:0\n3 3\n", "its first line does not say so"),
    "only a banner": ("array real general", "has no sizes"),
}  # fmt: skip


@pytest.mark.parametrize(("text", "message"), MARKET.values(), ids=MARKET)
def test_a_matrix_market_file_that_claims_too_much_is_refused(text: str, message: str, tmp_path: Path) -> None:
    head = "" if text.startswith("root") else "%%MatrixMarket matrix "
    (tmp_path / "m.mtx").write_text(head + text)
    said = refused(tmp_path / "m.mtx")
    assert message in said
    assert not {"root", "secret"} & set(said.split())


KINDS_OF_FILE = [
    (dense, field, symmetry)
    for dense, field, symmetry in product(
        [True, False], ["real", "integer", "complex"], ["general", "symmetric", "skew-symmetric", "hermitian"]
    )
    if field == "complex" or symmetry != "hermitian"
]
"""All that scipy writes."""


@pytest.mark.parametrize(("dense", "field", "symmetry"), KINDS_OF_FILE)
def test_a_file_says_the_same_to_vibopt_and_to_scipy(symmetry: str, field: str, dense: bool) -> None:
    draw = np.random.default_rng(7)
    whole = draw.integers(-9, 9, (5, 5)) * (1.0 if field == "integer" else 0.37)
    whole = whole + 1j * draw.integers(-9, 9, (5, 5)) if field == "complex" else whole
    turned = {"symmetric": whole.T, "skew-symmetric": -whole.T, "hermitian": whole.conj().T}.get(symmetry, whole)
    matrix = (whole + turned).astype(int if field == "integer" else whole.dtype)
    stream = io.BytesIO()
    mmwrite(stream, matrix if dense else sparse.coo_array(matrix), comment="from a test", symmetry=symmetry)
    read = from_matrix_market(stream.getvalue())
    assert (np.asarray(read if dense else read.toarray()) == matrix).all()
    stream.seek(0)
    theirs = mmread(stream)
    assert (np.asarray(theirs if dense else theirs.toarray()) == matrix).all()


def test_empty_lines_and_remarks_may_stand_before_the_sizes(tmp_path: Path) -> None:
    (tmp_path / "m.mtx").write_text("%%MatrixMarket matrix coordinate real symmetric\n% a\n\n%b\n2 2 2\n1 1 3\n2 2 4\n")
    assert (matrix_of(tmp_path / "m.mtx").toarray() == np.diag([3.0, 4.0])).all()


EMPTY = "cannot be used. It is empty: nothing that has a mass has a stiffness. Check the export."
SINGULAR = {
    "of one direction": [[1.0, 1.0], [1.0, 1.0]],
    "of nothing": [[0.0, 0.0], [0.0, 0.0]],
}


@pytest.mark.parametrize("given_matrix", SINGULAR.values(), ids=SINGULAR)
def test_a_singular_mass_is_refused_where_no_coordinate_is_massless_and_a_singular_stiffness_is_not(
    given_matrix: list[list[float]],
) -> None:
    matrix = sparse.csc_array(np.array(given_matrix))
    assert mass_fault(matrix).startswith("cannot be used.")
    fault = holding_fault(matrix, sparse.csc_array(np.eye(2)), "stiffness")
    assert fault == ("" if matrix.nnz else EMPTY)
    assert holding_fault(matrix, sparse.csc_array(np.eye(2)), "damping") == ""


def mutated(content: bytes, changes: list[tuple[int, int]]) -> bytes:
    """Bytes with some of them changed."""
    changed = bytearray(content)
    for place, value in changes:
        changed[place % len(changed)] = value
    return bytes(changed)


def npz(form: str) -> Callable[[], bytes]:
    def made() -> bytes:
        stream = io.BytesIO()
        np.savez(stream, **parts_of(form))
        return stream.getvalue()

    return made


def market() -> bytes:
    return b"%%MatrixMarket matrix coordinate real symmetric\n3 3 3\n1 1 2.0\n2 2 3e1\n3 1 -4\n"


@settings(max_examples=150, suppress_health_check=list(HealthCheck))
@given(
    which=st.sampled_from([(".npz", npz(form)) for form in FORMS] + [(".mtx", market)] * 3),
    changes=st.lists(st.tuples(st.integers(0, 5000), st.integers(0, 255)), min_size=1, max_size=4),
    cut=st.integers(0, 400),
)
def test_a_damaged_file_is_a_matrix_or_a_sentence(
    which: tuple[str, Callable[[], bytes]], changes: list[tuple[int, int]], cut: int, tmp_path_factory: Any
) -> None:
    ending, make = which
    file = tmp_path_factory.mktemp("m") / f"m{ending}"
    content = mutated(make(), changes)
    file.write_bytes(content[: len(content) - (cut if cut < 60 else 0)])
    for ask in (matrix_of, keys_of) if ending == ".npz" else (matrix_of,):
        with suppress(QuantityError):
            ask(file)
