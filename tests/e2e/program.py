"""One run of the program, and what it leaves in a map's folder: what all end-to-end tests share."""
import contextlib
import importlib
import json
import os
import pathlib
import shutil
import sqlite3
import subprocess
import tempfile
import unittest

BINARY = os.path.abspath(os.environ.get("SKYQUILT_BINARY", "build/release/bin/skyquilt"))
# Real flights and logs, not part of the repository: tests that want them skip where they are not.
DATA = pathlib.Path(os.environ.get("SKYQUILT_DATA", pathlib.Path(__file__).parents[2] / ".." / "shared" / "data"))
REPORT_SCHEMA = pathlib.Path(__file__).resolve().parents[2] / "core" / "pipeline" / "report.schema.json"


def run(*words, code=0, **how):
    """One run, which ends with this code; with any where it is None. What it said is text."""
    done = subprocess.run([BINARY, *map(str, words)], capture_output=True, text=True, **how)
    assert code in (None, done.returncode), (words, done.returncode, done.stdout, done.stderr)
    return done


def tool(*words):
    """What another program, of GDAL's for one, prints."""
    return subprocess.run([str(word) for word in words], check=True, stdout=subprocess.PIPE, text=True).stdout


def report_of(folder):
    return json.loads(pathlib.Path(folder, "report.json").read_text())


def checked_report(folder):
    """The same, held against its schema."""
    import jsonschema
    report = report_of(folder)
    jsonschema.validate(report, json.loads(REPORT_SCHEMA.read_text()))
    return report


def tiles_of(folder):
    """{(zoom, column, row): bytes} of a map's folder."""
    with contextlib.closing(sqlite3.connect(f"file:{folder}/mosaic.mbtiles?mode=ro", uri=True)) as mbtiles:
        return {row[:3]: row[3] for row in mbtiles.execute("SELECT zoom_level, tile_column, tile_row, tile_data FROM tiles")}


def cameras_of(folder):
    """{name: camera} of the photos of a map, as `skyquilt locate` has them."""
    return {camera["name"]: camera for camera in json.loads(pathlib.Path(folder, "locate.json").read_text())["cameras"]}


def without_metadata(jpeg):
    """The picture alone: no EXIF, no XMP, nothing that a camera wrote beside it."""
    kept, at = [jpeg[:2]], 2
    while jpeg[at + 1] != 0xDA:
        size = 2 + int.from_bytes(jpeg[at + 2:at + 4], "big")
        if not 0xE1 <= jpeg[at + 1] <= 0xEF:
            kept.append(jpeg[at:at + size])
        at += size
    return b"".join(kept) + jpeg[at:]


class ScratchCase(unittest.TestCase):
    """With a folder for as long as the class."""

    @classmethod
    def setUpClass(cls):
        cls.scratch = pathlib.Path(tempfile.mkdtemp(prefix="skyquilt_e2e_"))
        cls.addClassCleanup(shutil.rmtree, cls.scratch)

    def imported(self, wanting, *names):
        """These modules; where one is not there the test is skipped, and says what is wanting."""
        try:
            return [importlib.import_module(name) for name in names]
        except ImportError:
            self.skipTest(wanting)
