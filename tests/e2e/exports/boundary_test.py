"""A map that is cut to a boundary, by the command: what is left, what is said, and what is refused before work begins."""

import json
import math
import re
import shutil

from flights import made_flights
from program import ScratchCase, report_of, run, tiles_of

kMetresPerDegree = 111_320.0


class BoundaryTest(ScratchCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.flight = made_flights.simulated(12, "800x600", "--noise", "xmp")
        cls.origin = json.loads((cls.flight / "truth" / "poses.json").read_text())["origin"]
        cls.whole = cls.scratch / "whole"
        cls.stitch(cls.whole)

    @classmethod
    def run_stitch(cls, out, *more):
        return run("stitch", cls.flight / "photos", *more, "-o", out, code=None)

    @classmethod
    def stitch(cls, out, *more):
        done = cls.run_stitch(out, *more)
        assert done.returncode == 0, done.stderr
        return report_of(out)

    def corners(self, places_m):
        east = kMetresPerDegree * math.cos(math.radians(self.origin["lat_deg"]))
        return [[self.origin["lon_deg"] + x / east, self.origin["lat_deg"] + y / kMetresPerDegree] for x, y in places_m]

    def geojson(self, name, places_m):
        path = self.scratch / name
        path.write_text(json.dumps({"type": "Polygon", "coordinates": [self.corners([*places_m, places_m[0]])]}))
        return path

    def test_what_is_left_is_what_is_told(self):
        places = [(-42, -36), (45, -30), (6, 48)]
        area = self.geojson("triangle.geojson", places)
        report = self.stitch(self.scratch / "cut", "--boundary", area)
        self.assertEqual(report["photos"], report_of(self.whole)["photos"])
        self.assertAlmostEqual(report["area_m2"], 0.5 * (87 * 84 - 6 * 48), delta=30)
        lons, lats = zip(*self.corners(places))
        for found, expected in zip(report["bounds"], [min(lons), min(lats), max(lons), max(lats)]):
            self.assertAlmostEqual(found, expected, delta=3e-6)
        tiles, all_tiles = tiles_of(self.scratch / "cut"), tiles_of(self.whole)
        self.assertLess(len(tiles), len(all_tiles))
        self.assertTrue(any(all_tiles.get(tile) == data for tile, data in tiles.items()), "tiles wholly within are the same")
        for name in ("locate.json", "photos.geojson"):
            self.assertEqual((self.scratch / "cut" / name).read_text(), (self.whole / name).read_text(), "photos lie as without")

    def test_a_kml_is_as_good_and_another_number_of_threads_changes_nothing(self):
        places = [(-14, -12), (15, -10), (2, 16), (-14, -12)]
        kml = self.scratch / "area.kml"
        text = " ".join(f"{lon!r},{lat!r},0" for lon, lat in self.corners(places))
        kml.write_text('<?xml version="1.0"?><kml xmlns="http://www.opengis.net/kml/2.2"><Placemark><Polygon><outerBoundaryIs>'
                       f"<LinearRing><coordinates>{text}</coordinates></LinearRing></outerBoundaryIs></Polygon></Placemark></kml>")
        self.stitch(self.scratch / "by_kml", "--boundary", kml, "--threads", "1")
        self.stitch(self.scratch / "by_json", "--boundary", self.geojson("same.geojson", places[:-1]), "--threads", "2")
        self.assertEqual(tiles_of(self.scratch / "by_kml"), tiles_of(self.scratch / "by_json"))

    def test_a_finished_map_is_cut_without_placing_it_anew(self):
        out = self.scratch / "later"
        shutil.copytree(self.whole, out)
        report = self.stitch(out, "--overwrite", "--boundary", self.geojson("later.geojson", [(-14, -12), (15, -10), (2, 16)]))
        self.assertNotIn("check", [stage["stage"] for stage in report["timings"]])
        self.stitch(self.scratch / "at_once", "--boundary", self.scratch / "later.geojson")
        self.assertEqual(tiles_of(out), tiles_of(self.scratch / "at_once"))

    def test_a_map_that_is_brought_elsewhere_stays_cut(self):
        out = self.scratch / "moved"
        before = self.stitch(out, "--boundary", self.geojson("moved.geojson", [(-14, -12), (15, -10), (2, 16)]))
        pairs = []
        for x, y in ((-9, -8), (8, -7)):
            (lon, lat), (lon_is, lat_is) = self.corners([(x, y), (x + 1, y)])
            pairs += ["--point", f"{lat:.9f},{lon:.9f}={lat_is:.9f},{lon_is:.9f}"]
        run("place", out, *pairs, "--again")
        after = report_of(out)
        for found, expected in zip(after["bounds"], before["bounds"]):
            self.assertAlmostEqual(found, expected, delta=2e-6)

    def test_what_cannot_be_used_is_refused_before_work_begins(self):
        bad = self.scratch / "bad.geojson"
        bad.write_text('{"type":"LineString","coordinates":[[7,46],[8,47]]}')
        done = self.run_stitch(self.scratch / "none", "--boundary", bad)
        self.assertEqual(done.returncode, 1)
        self.assertIn("bad.geojson: The boundary cannot be used: it has a LineString. Give a GeoJSON Polygon", done.stderr)
        self.assertFalse((self.scratch / "none").exists())

    def test_a_boundary_elsewhere_is_refused_with_the_flights_place_before_photos_are_compared(self):
        done = self.run_stitch(self.scratch / "far", "--boundary", self.geojson("far.geojson", [(30000, 0), (30100, 0), (30000, 100)]))
        self.assertEqual(done.returncode, 1)
        place = re.search(r"the flight is around ([-0-9.]+), ([-0-9.]+)", done.stderr)
        self.assertIsNotNone(place, done.stderr)
        self.assertAlmostEqual(float(place[1]), self.origin["lat_deg"], delta=1e-3)
        self.assertAlmostEqual(float(place[2]), self.origin["lon_deg"], delta=1e-3)
        self.assertNotIn("Aligning", done.stderr)
        self.assertFalse((self.scratch / "far" / "report.json").exists())
        near = self.run_stitch(self.scratch / "near", "--boundary", self.geojson("near.geojson", [(600, 0), (700, 0), (600, 100)]))
        self.assertEqual(near.returncode, 1)
        self.assertIn("Draw the boundary over the flight", near.stderr)

    def test_a_trace_that_cannot_be_written_is_told_at_once(self):
        for place, words in (("missing/trace.json", "cannot be written"), ("whole", "is a folder")):
            done = self.run_stitch(self.scratch / "untraced", "--trace", self.scratch / place)
            self.assertEqual(done.returncode, 1)
            self.assertIn(words, done.stderr)
            self.assertFalse((self.scratch / "untraced").exists(), "no work was done")
        self.stitch(self.scratch / "traced", "--trace", self.scratch / "trace.json")
        self.assertIn("traceEvents", (self.scratch / "trace.json").read_text())
        self.assertEqual([path.name for path in self.scratch.glob("trace.json*")], ["trace.json"])

    def test_a_given_takeoff_height_is_where_the_map_hangs(self):
        report = self.stitch(self.scratch / "raised", "--takeoff-height-m", "1234.5")
        self.assertIn("take-off 1234.5 m above sea level, as given", report["poses"]["height_rule"])
        height_m = json.loads((self.scratch / "raised" / "locate.json").read_text())["origin"][2]
        self.assertLess(abs(height_m - 1234.5), 110, "the geoid lies so far from the ellipsoid at most")
        done = self.run_stitch(self.scratch / "none", "--takeoff-height-m", "99999")
        self.assertEqual(done.returncode, 1)
        self.assertIn("between -500 and 9000 metres above sea level", done.stderr)
