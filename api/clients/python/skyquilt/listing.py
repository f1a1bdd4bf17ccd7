"""Which files of a folder go to the server, and by which names."""
from __future__ import annotations

import collections
import dataclasses
import os
import pathlib
import re
import warnings
from typing import Dict, Iterable, List, Sequence, Set, Union

from .errors import InputError

Path = Union[str, "os.PathLike[str]"]

PICTURES = {".jpg", ".jpeg", ".tif", ".tiff", ".png", ".dng"}
_MAX_FOLDERS = 8  # in front of a name
_MOST_BYTES_OF_NAME = 200  # of a flight
# What systems and network drives keep for themselves: a Mac's attributes, previews of each photo, deleted files.
_OF_PROGRAMS = {"@eadir", "@recycle", "#recycle", "$recycle.bin", "system volume information", "__macosx"}
# What `skyquilt stitch` writes beside its mosaic.state, as server/jobs/out_folder.cc names it.
_OF_MAPS = {"mosaic.mbtiles", "mosaic.pmtiles", "mosaic.tif", "mosaic_utm.tif", "mosaic.kmz", "thumbnail.png", "report.json",
            "photos.geojson", "locate.json", "cameras.json", "geo.txt", "layers.json", "bands.tif", "dsm.tif", "dsm_photos.tif",
            "dtm.tif", "dtm_ground.tif", "contours.gpkg", "contours.geojson", "contours.dxf", "dsm_hillshade.tif",
            "layer_photo.mbtiles", "layer_error.mbtiles", "layer_height.mbtiles"}
# A row and a comment of the geo.txt that it writes (core/pipeline/report/odm_exports.cc).
_ROW_OF_MAP = re.compile(rb"[^ ]*(?: -?\d+\.\d{10}){2} -?\d+\.\d{4}(?: -?\d+\.\d{6}){3}(?:(?: -?\d+\.\d{4}){2})?")
_PHOTOS_UNNAMED = b"# Not here, for this file "


@dataclasses.dataclass(frozen=True)
class LocalFile:
    """A file here, and its name at the server."""

    name: str
    path: pathlib.Path
    bytes: int


def list_files(paths: Union[Path, Iterable[Path]]) -> List[LocalFile]:
    """The files named and those below the folders named, without hidden and empty ones and what a map made there consists of,
    in the order of their paths. Names that come twice have as many folders in front as it takes. Warns of folders that may not be
    read. Raises `InputError` where there is nothing to send, or a disk fails."""
    named = [pathlib.Path(paths)] if isinstance(paths, (str, os.PathLike)) else [pathlib.Path(path) for path in paths]
    files: List[LocalFile] = []
    seen: Set[str] = set()
    for path in _walk(named):
        key = os.path.normpath(path)
        size = path.stat().st_size
        if key in seen or size == 0:  # an empty file says nothing
            continue
        seen.add(key)
        files.append(LocalFile(path.name, path, size))
    if not files:
        raise InputError(f"There are no files to send in {', '.join(str(path) for path in named) or 'an empty list'}.")
    return [dataclasses.replace(file, name=name) for file, name in zip(files, _names_apart([file.path for file in files]))]


def name_of(paths: Union[Path, Iterable[Path]]) -> str:
    """What a flight of these is called: as the folder, or the first file without its ending, in at most 200 bytes of UTF-8."""
    first = pathlib.Path(paths) if isinstance(paths, (str, os.PathLike)) else next((pathlib.Path(path) for path in paths), pathlib.Path())
    whole = pathlib.Path(os.path.abspath(first))
    name = whole.name if whole.is_dir() else whole.stem
    return name.encode(errors="replace")[:_MOST_BYTES_OF_NAME].decode(errors="ignore") or "flight"


def _is_of_programs(name: str) -> bool:
    return name.startswith(".") or name.lower() in _OF_PROGRAMS


def _is_list_of_map(path: pathlib.Path) -> bool:
    """Whether a map's own geo.txt, to the digit: one that somebody put there, or that cannot be read, is the flight's."""
    try:
        head, *lines = path.read_bytes().split(b"\n")
    except OSError:
        return False
    if head != b"EPSG:4326" or not lines or lines.pop():
        return False
    rows = [line for line in lines if not line.startswith(b"# ")]
    says_anything = bool(rows) or any(line.startswith(_PHOTOS_UNNAMED) for line in lines)
    return says_anything and all(_ROW_OF_MAP.fullmatch(row) for row in rows)


def _is_of_map(path: pathlib.Path) -> bool:
    """Whether a file beside a mosaic.state is part of that map: its positions and heights are none of a flight's."""
    name = path.name
    return name.startswith("mosaic.state") or name in _OF_MAPS and (name != "geo.txt" or _is_list_of_map(path))


def _walk(named: Sequence[pathlib.Path]) -> Iterable[pathlib.Path]:
    for path in named:
        if not path.exists():
            raise InputError(f"There is no file or folder {path}.")
        if not path.is_dir():
            yield path
            continue
        found = []
        denied: List[str] = []

        def is_not_read(error: OSError) -> None:
            if not isinstance(error, PermissionError):
                raise InputError(f"The folder {error.filename} cannot be read: {error.strerror}.") from error
            denied.append(str(error.filename))

        for folder, below, names in os.walk(path, onerror=is_not_read):
            here, has_map = pathlib.Path(folder), "mosaic.state" in names
            below[:] = sorted(name for name in below if not _is_of_programs(name))
            if here.name == "frames" and "frames.json" in names and here != path:
                continue  # what became of films; the folder that is given itself counts
            found += [here / name for name in names if not (_is_of_programs(name) or has_map and _is_of_map(here / name))]
        if denied:
            warnings.warn(f"Not read, for want of permission: {len(denied)} folder{'s' * (len(denied) > 1)} ({denied[0]} first).")
        yield from (one for one in sorted(found) if one.is_file())


def _names_apart(paths: Sequence[pathlib.Path]) -> List[str]:
    """A name for each, as core/base/text/file_names.cc gives them: its own, with as many folders in front as tell it from
    files of that name elsewhere. What is no picture keeps the folder beside such, for a list counts for the photos there; a
    sidecar is called as its picture."""
    whole = [pathlib.Path(os.path.abspath(path)) for path in paths]
    first_folder: Dict[str, pathlib.Path] = {}
    doubled = {path.name.lower() for path in whole if first_folder.setdefault(path.name.lower(), path.parent) != path.parent}
    labels = _labels({path.parent for path in whole if path.name.lower() in doubled})
    company = [(path.parent, path.name.lower().split(".")[0]) for path in whole]
    pictures = {own for path, own in zip(whole, company) if path.suffix.lower() in PICTURES}
    doubled_pictures = {own for path, own in zip(whole, company) if path.suffix.lower() in PICTURES and path.name.lower() in doubled}
    names: List[str] = []
    taken: Set[str] = set()
    for path, own_company in zip(whole, company):
        keeps_folder = path.name.lower() in doubled or own_company in doubled_pictures or own_company not in pictures
        label = labels.get(path.parent, "") if keeps_folder else ""
        name, copy = f"{label}_{path.name}" if label else path.name, 2
        own = pathlib.PurePath(name)
        while name in taken:
            name, copy = f"{own.stem}({copy}){own.suffix}", copy + 1
        taken.add(name)
        names.append(name)
    return names


def _labels(folders: Set[pathlib.Path]) -> Dict[pathlib.Path, str]:
    """Of each the last folders that tell it from the others."""
    labels: Dict[pathlib.Path, str] = {}
    remaining = sorted(folders)
    for parts in range(1, _MAX_FOLDERS + 1):
        for folder in remaining:
            labels[folder] = "_".join(folder.parts[1:][-parts:])
        times = collections.Counter(labels[folder].lower() for folder in remaining)
        remaining = [folder for folder in remaining if times[labels[folder].lower()] > 1]
    return labels
