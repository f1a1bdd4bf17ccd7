"""Photos added to a finished flight: what was there stays, byte for byte, but for the tiles below the new photos."""
import json
import math
import pathlib
import shutil
import sqlite3
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from server_support import BINARY  # noqa: E402

HALO_TILES = 4  # of 256 pixels: as far as a seam evens out the light


def tiles_of(out):
    with sqlite3.connect(out / "mosaic.mbtiles") as mbtiles:
        return {row[:3]: row[3] for row in
                mbtiles.execute("SELECT zoom_level, tile_column, tile_row, tile_data FROM tiles")}


def cameras_of(out):
    return {camera["name"]: camera for camera in json.loads((out / "locate.json").read_text())["cameras"]}


def column_row(zoom, lon, lat):
    side = 2 ** zoom
    y = (1 - math.asinh(math.tan(math.radians(lat))) / math.pi) / 2
    return (lon + 180) / 360 * side, side - 1 - y * side


class Append(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = pathlib.Path(tempfile.mkdtemp(prefix="skyquilt_append_"))
        subprocess.run([BINARY, "simulate", "-o", cls.scratch / "sim", "--photos", "20", "--size", "800x600", "--noise", "xmp",
                        "--exposure-jitter", "0.05", "--vignetting", "0.1", "--no-world"], check=True, capture_output=True)
        photos = sorted((cls.scratch / "sim" / "photos").iterdir())
        cls.first, cls.more = cls.scratch / "first", cls.scratch / "more"
        cls.first.mkdir()
        cls.more.mkdir()
        cls.new = photos[-1].name
        for photo in photos[:-1]:
            shutil.copy(photo, cls.first)
        shutil.copy(photos[-1], cls.more)
        cls.finished = cls.scratch / "finished"
        cls.stitch(cls.first, cls.finished)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.scratch)

    @classmethod
    def stitch(cls, photos, out, *arguments):
        subprocess.run([BINARY, "stitch", photos, "-o", out, *arguments], check=True,
                       capture_output=True)
        return json.loads((out / "report.json").read_text())

    def check_figures(self, figures, before):
        """The new photo's stand behind those of the finished flight, which stay."""
        self.assertEqual((figures["photos"], figures["aligned"]), (20, before["aligned"] + 1))
        self.assertEqual(figures["photo_reports"][:-1], before["photo_reports"])
        self.assertEqual(figures["photo_reports"][-1]["name"], self.new)
        pairs = len(before["pairs"])
        self.assertEqual(figures["pairs"][:pairs], before["pairs"])
        self.assertGreater(len(figures["pairs"]), pairs)
        for pair in figures["pairs"][pairs:]:
            self.assertIn(self.new, (pair["first"], pair["second"]))
        merged = ("photos", "aligned", "photo_reports", "pairs")
        self.assertEqual({key: value for key, value in figures.items() if key not in merged},
                         {key: value for key, value in before.items() if key not in merged})

    def test_only_the_tiles_below_the_new_photo_change(self):
        out = self.scratch / "grown"
        shutil.copytree(self.finished, out)
        before = tiles_of(out)
        report = self.stitch(self.more, out, "--append")
        self.assertEqual(report["photos"]["total"], 20)
        self.assertEqual(report["photos"]["aligned"], 20)
        self.assertGreater(report["blocks"]["kept"], 0)
        self.check_figures(report["alignment"], json.loads((self.finished / "report.json").read_text())["alignment"])
        # What was placed stays exactly where it was.
        cameras, old_cameras = cameras_of(out), cameras_of(self.finished)
        self.assertEqual({name: cameras[name] for name in old_cameras}, old_cameras)
        after = tiles_of(out)
        self.assertEqual(set(before) - set(after), set())
        zoom = report["max_zoom"]
        changed = [key for key in after if key[0] == zoom and after[key] != before.get(key)]
        self.assertGreater(len(changed), 0)
        ring = next(photo["geometry"]["coordinates"][0]
                    for photo in json.loads((out / "photos.geojson").read_text())["features"]
                    if photo["properties"]["name"] == self.new)
        corners = [column_row(zoom, lon, lat) for lon, lat in ring]
        for _, column, row in changed:
            self.assertGreaterEqual(column, min(x for x, _ in corners) - 1 - HALO_TILES)
            self.assertLessEqual(column, max(x for x, _ in corners) + HALO_TILES)
            self.assertGreaterEqual(row, min(y for _, y in corners) - 1 - HALO_TILES)
            self.assertLessEqual(row, max(y for _, y in corners) + HALO_TILES)
        # Nothing is left of the finished map's tiles that a run from the new state would not make.
        again = self.stitch(self.more, out, "--append")
        self.assertEqual(again["blocks"]["kept"], again["blocks"]["total"])
        self.assertEqual(tiles_of(out), after)

    def test_a_map_with_png_at_its_edge_becomes_the_same_as_one_made_anew(self):
        out = self.scratch / "png"
        self.stitch(self.first, out, "--format", "jpeg-png")
        before = tiles_of(out)
        self.assertEqual({tile[:4] for tile in before.values()}, {b"\xff\xd8\xff\xe0", b"\x89PNG"})
        report = self.stitch(self.first, out, "--overwrite")
        self.assertEqual(report["blocks"]["kept"], report["blocks"]["total"])
        self.assertEqual(tiles_of(out), tiles_of(self.finished))
        again = self.stitch(self.first, out)
        self.assertEqual(again["blocks"]["kept"], again["blocks"]["total"])
        # Who wants PNG again has it rendered: what WebP lost is gone.
        report = self.stitch(self.first, out, "--format", "jpeg-png", "--overwrite")
        self.assertEqual(report["blocks"]["kept"], 0)
        self.assertEqual(tiles_of(out), before)

    def test_the_new_photo_lies_where_a_whole_alignment_puts_it(self):
        out, whole = self.scratch / "placed", self.scratch / "whole"
        shutil.copytree(self.finished, out)
        self.stitch(self.more, out, "--append")
        self.stitch(self.scratch / "sim" / "photos", whole)
        places = []
        for folder in (out, whole):
            text = subprocess.run([BINARY, "locate", folder, "--photo", self.new, "--pixel", "400,300"], check=True,
                                  capture_output=True, text=True).stdout
            places.append([float(word) for word in text.split()[0].split(",")])
        lon, lat = (abs(a - b) * 111_000 for a, b in zip(*places))
        self.assertLess(math.hypot(lon, lat), 1.0)

    def test_a_folder_without_a_map_cannot_be_added_to(self):
        told = subprocess.run([BINARY, "stitch", self.more, "-o", self.scratch / "nothing", "--append"], capture_output=True,
                              text=True)
        self.assertEqual(told.returncode, 1)
        self.assertIn("no map that can be added to", told.stderr)


if __name__ == "__main__":
    unittest.main()
