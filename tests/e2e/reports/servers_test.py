"""What users sent to servers and what their programs read of a map, as was reported."""
import pathlib
import shutil
import sqlite3
import subprocess
import tempfile
import unittest

from reported_flight import REPORTS, ReportedFlight
from server_support import Server

FORMATS = {b"\xff\xd8\xff\xe0": "jpg", b"\xff\xd8\xff\xdb": "jpg", b"\x89PNG": "png", b"RIFF": "webp"}


class Servers(ReportedFlight):
    def setUp(self):
        self.server = Server(tempfile.mkdtemp(dir=self.scratch))
        self.addCleanup(self.server.stop)

    @unittest.skipIf(shutil.which("curl") is None, "needs curl")
    def test_two_cards_with_the_same_names(self):
        _, flight = self.server.json("POST", "/api/v1/flights", {"name": "two cards"})
        address = f"http://127.0.0.1:{self.server.port}/api/v1/flights/{flight['id']}/files/"
        first, second = sorted((REPORTS / "photos").iterdir())[:2]
        statuses, answers = [], []
        for card, photo in (("100MEDIA", first), ("101MEDIA", second), ("100MEDIA", first)):
            path = pathlib.Path(self.scratch, "cards", card, "DJI_0001.JPG")
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(photo.read_bytes())
            done = subprocess.run(["curl", "-sS", "-w", "\n%{http_code}", "-T", path, address], check=True, capture_output=True, text=True)
            answer, _, status = done.stdout.rpartition("\n")
            statuses.append(int(status))
            answers.append(answer)
        _, listed = self.server.json("GET", f"/api/v1/flights/{flight['id']}/files")
        kept = {file["bytes"] for file in listed["files"]}
        self.assertIn(first.stat().st_size, kept, "the first card's photo was lost")
        if second.stat().st_size not in kept:
            self.assertEqual(statuses[1] // 100, 4, answers)
            self.assertIn("DJI_0001.JPG", answers[1])
        self.assertIn(statuses[2], (200, 201), answers)  # the same bytes again: a loop that was started twice

    def test_the_map_service_has_layers_and_a_legend(self):
        photos = [(path.name, path.read_bytes()) for path in sorted((REPORTS / "photos").iterdir())[:4]]
        _, made = self.server.upload(photos)
        self.assertEqual(self.server.wait_for_job(made["job"]["id"])["state"], "successful")
        service = f"/arcgis/rest/services/{made['flight']['id']}/MapServer"
        for part, key in (("layers", "id"), ("legend", "layerId")):
            status, answer = self.server.json("GET", f"{service}/{part}?f=json")
            self.assertEqual(status, 200, answer)
            self.assertLessEqual({layer[key] for layer in answer["layers"]}, {0})  # an empty legend will do


class Tilesets(ReportedFlight):
    """A strict server takes the first tile of the table, and the first of each zoom, as the file's format."""

    def assert_one_format(self, *options, every_tile=False):
        answer = self.stitch("photos", *options)
        with sqlite3.connect(answer.out / "mosaic.mbtiles") as tiles:
            named = tiles.execute("SELECT value FROM metadata WHERE name = 'format'").fetchone()[0]
            rows = tiles.execute("SELECT zoom_level, substr(tile_data, 1, 4) FROM tiles").fetchall()
        tiles.close()
        seen = set()
        for zoom, head in rows:
            if every_tile or zoom not in seen:
                self.assertEqual(FORMATS[bytes(head)], named, f"zoom {zoom}, {options}")
            seen.add(zoom)

    def test_the_first_tiles_are_of_the_format_that_is_named(self):
        self.assert_one_format()

    def test_one_kind_for_programs_that_insist(self):
        self.assert_one_format("--format", "webp", every_tile=True)


if __name__ == "__main__":
    unittest.main()
