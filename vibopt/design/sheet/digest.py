"""Digests of the files that an answer was made from, so that a signed page says which they were."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from hashlib import sha256
from pathlib import Path
from typing import Any

from vibopt.document.reading import FileText
from vibopt.files.reading import FileFault, Kind, content_of
from vibopt.scene.scene import Scene

_ANY = Kind("a file", 1_000_000_000, "", "")


def digests_of(path: str | Path, scene: Scene) -> dict[str, str]:
    """SHA-256 [hex] of a problem file and of the catalogues and matrix files that it names, by name."""
    files = {Path(path).name: Path(path)}
    files |= {str(one): Path(one.folder) / one for one in _named(scene.document)}
    found = {}
    for name, file in files.items():
        try:
            found[name] = sha256(content_of(file, _ANY)).hexdigest()
        except FileFault:  # gone since it was read: nothing can be said of it
            continue
    return found


def _named(given: Any) -> Iterator[FileText]:
    """Every file that a document names."""
    if isinstance(given, FileText):
        yield given
    elif isinstance(given, Mapping):
        for one in given.values():
            yield from _named(one)
    elif isinstance(given, (list, tuple)):
        for one in given:
            yield from _named(one)


__all__ = ["digests_of"]
