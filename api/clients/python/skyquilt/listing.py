"""Which files of a folder go to the server, and by which names."""
from __future__ import annotations

import dataclasses
import os
import pathlib
from typing import Iterable, List, Sequence, Set, Union

from .errors import InputError

Path = Union[str, "os.PathLike[str]"]


@dataclasses.dataclass(frozen=True)
class LocalFile:
    """A file here, and its name at the server."""

    name: str
    path: pathlib.Path
    bytes: int


def list_files(paths: Union[Path, Iterable[Path]]) -> List[LocalFile]:
    """The files named and those below the folders named, without hidden and empty ones, in the order of their paths. A name
    that comes twice gets as many folders in front as it takes. Raises `InputError` where there is nothing to send."""
    named = [pathlib.Path(paths)] if isinstance(paths, (str, os.PathLike)) else [pathlib.Path(path) for path in paths]
    files: List[LocalFile] = []
    taken: Set[str] = set()
    seen: Set[str] = set()
    for path in _walk(named):
        key = os.path.normpath(path)
        size = path.stat().st_size
        if key in seen or size == 0:  # an empty file says nothing
            continue
        seen.add(key)
        name = _unique_name(path, taken)
        taken.add(name)
        files.append(LocalFile(name, path, size))
    if not files:
        raise InputError(f"There are no files to send in {', '.join(str(path) for path in named) or 'an empty list'}.")
    return files


def name_of(paths: Union[Path, Iterable[Path]]) -> str:
    """What a flight of these is called: as the folder, or the first file without its ending."""
    first = pathlib.Path(paths) if isinstance(paths, (str, os.PathLike)) else next((pathlib.Path(path) for path in paths), pathlib.Path())
    whole = pathlib.Path(os.path.abspath(first))
    return (whole.name if whole.is_dir() else whole.stem)[:200] or "flight"


def _walk(named: Sequence[pathlib.Path]) -> Iterable[pathlib.Path]:
    for path in named:
        if not path.exists():
            raise InputError(f"There is no file or folder {path}.")
        if not path.is_dir():
            yield path
            continue
        found = []
        for folder, below, names in os.walk(path):
            below[:] = sorted(name for name in below if not name.startswith("."))
            found += [pathlib.Path(folder, name) for name in names if not name.startswith(".")]
        yield from (one for one in sorted(found) if one.is_file())


def _unique_name(path: pathlib.Path, taken: Set[str]) -> str:
    name, folder = path.name, pathlib.Path(os.path.abspath(path)).parent
    while name in taken and folder.name:
        name, folder = f"{folder.name}/{name}", folder.parent
    copy = 2
    while name in taken:
        name, copy = f"{path.name} ({copy})", copy + 1
    return name
