"""The sheet as PDF, printed by a browser of this machine, and the digests of the files that it was made from."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import tempfile
from hashlib import sha256
from pathlib import Path

from vibopt.answer.answer import Asked
from vibopt.document.toml_reading import FileText, texts_of
from vibopt.errors import InputError
from vibopt.files.marks import PDF_MARK
from vibopt.files.reading import FileFault, Kind, content_of

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")
PATIENCE = 60.0
"""Seconds that a browser may take."""
_PAGE = re.compile(rb"/Type\s*/Page\b")


def browser(target: str) -> str:
    """Path of a browser that can print.

    Raises
    ------
    InputError
        There is none: how to get one, and what to do without; `target` is the file that was asked for.
    """
    for name in BROWSERS:
        found = shutil.which(name)
        if found is not None:
            return found
    instead = str(Path(target).with_suffix(".html"))
    raise InputError(
        f"{target} cannot be written: a PDF is printed by a browser, and none of {', '.join(BROWSERS)} is on the PATH. "
        f"Install Chromium or Chrome, or write {instead} and print it from any browser: it is made for one page of A4."
    )


def pdf(page: str, program: str, target: str) -> bytes:
    """A page of HTML as PDF.

    Parameters
    ----------
    page
        The whole page, nothing outside it.
    program
        From `browser`.
    target
        The file that was asked for, for messages.

    Raises
    ------
    InputError
        The browser did not print.
    """
    with tempfile.TemporaryDirectory(prefix="vibopt-") as folder:
        source, printed = Path(folder, "sheet.html"), Path(folder, "sheet.pdf")
        source.write_text(page, encoding="utf-8")
        words = [
            program,
            "--headless",
            "--disable-gpu",
            "--no-first-run",
            "--no-pdf-header-footer",
            f"--user-data-dir={folder}/profile",
            f"--print-to-pdf={printed}",
            source.as_uri(),
        ]
        if hasattr(os, "geteuid") and os.geteuid() == 0:  # a browser of root has no sandbox; the page has no scripts
            words.insert(1, "--no-sandbox")
        try:
            done = subprocess.run(words, capture_output=True, timeout=PATIENCE, check=False)
            said = done.stderr.decode("utf-8", "replace").strip().splitlines()[-1:]
        except subprocess.TimeoutExpired:
            said = [f"nothing within {PATIENCE:g} s"]
        except OSError as error:
            said = [str(error.strerror)]
        if printed.is_file():
            return printed.read_bytes() + PDF_MARK
    instead = str(Path(target).with_suffix(".html"))
    raise InputError(
        f"{target} cannot be written: {program} did not print it ({said[0] if said else 'it said nothing'}). Write "
        f"{instead} and print it from any browser."
    )


def pages_of(content: bytes) -> int:
    """Number of pages of a PDF that a browser printed."""
    return len(_PAGE.findall(content))


_ANY = Kind("a file", 1_000_000_000, "", "")


def digests_of(path: str | Path, job: Asked) -> dict[str, str]:
    """SHA-256 [hex] of a problem file and of the catalogues and matrix files that it names, by name."""
    files = {Path(path).name: Path(path)}
    files |= {str(one): one.folder / one for one in texts_of(job.document) if isinstance(one, FileText)}
    found = {}
    for name, file in files.items():
        try:
            found[name] = sha256(content_of(file, _ANY)).hexdigest()
        except FileFault:  # gone since it was read: nothing can be said of it
            continue
    return found
