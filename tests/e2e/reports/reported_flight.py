"""The flight of ../shared/data/reports: eighteen photos whose right map is known to the metre, in the shapes in which users
were reported to have their files. What its tests share: a copy to work in, one run of the program, the right map."""
import csv
import json
import math
import pathlib
import re
import shutil
import statistics
import tempfile
import unittest

from program import DATA, ScratchCase, report_of, run

REPORTS = DATA / "reports"
NAMES = [f"DJI_{number:04}.JPG" for number in range(18, 36)]
# How near cameras come to their places, (median, most) in metres: photos that record angles and heights; photos that record
# nothing and a list that says where; photos tied to a track of one fix a second, whose corners are rounded.
OF_RECORDS, OF_A_LIST, OF_A_TRACK = (0.5, 1.0), (0.9, 1.5), (0.9, 1.7)
A_DEGREE_NORTH_M = 111_180.0
A_DEGREE_EAST_M = 111_319.5 * math.cos(math.radians(46.8426))
BOUNDS = (-91.9950, 46.8419, -91.9929, 46.8434)  # of the right map
MOVED_EAST_DEG = 100.00005257  # one input shows the same flight this much further east


def recorded_places():
    """Of every photo by its name, as EXIF has it: (latitude, longitude)."""
    with open(REPORTS / "semicolon-bom" / "positions.csv", encoding="utf-8-sig", newline="") as rows:
        return {row["image"]: (float(row["latitude"]), float(row["longitude"])) for row in csv.DictReader(rows, delimiter=";")}


class Answer:
    """What one run of `stitch` left: its report and cameras, where it made a map, and all that it said."""

    def __init__(self, out, done):
        self.out, self.code = out, done.returncode
        self.said = done.stdout + done.stderr
        self.report, self.cameras, self.heights_m = None, {}, []
        if done.returncode != 0:
            return
        self.report = report_of(out)
        photos = json.loads((out / "photos.geojson").read_text())["features"]
        for photo in (feature["properties"] for feature in photos):
            self.cameras[photo["name"]] = (photo["camera_lat"], photo["camera_lon"])
            self.heights_m.append(photo["camera_height_above_ground_m"])
        told = self.report["warnings"] + [f"{photo['name']}: {photo['reason']}" for photo in self.report["left_out_photos"]]
        self.said += "\n".join(told)

    def is_placed(self):
        return self.report is not None and self.report["is_placed"]

    def offsets_m(self, places, east_m=0.0):
        """(east, north) of every camera against where it belongs."""
        return {name: ((lon - places[name][1]) * A_DEGREE_EAST_M - east_m, (lat - places[name][0]) * A_DEGREE_NORTH_M)
                for name, (lat, lon) in self.cameras.items() if name in places}


@unittest.skipUnless(REPORTS.is_dir(), f"what users were reported to have is not here: {REPORTS} (SKYQUILT_DATA)")
class ReportedFlight(ScratchCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.folder = cls.scratch / "reports"
        shutil.copytree(REPORTS, cls.folder, copy_function=shutil.copyfile)
        cls.places = recorded_places()

    def stitch(self, *words):
        out = pathlib.Path(tempfile.mkdtemp(dir=self.scratch, prefix="map_"))
        done = run("stitch", *map(str, words), "-o", out, code=None, cwd=self.folder)
        self.assertGreaterEqual(done.returncode, 0, done.stderr)  # negative: ended by a signal
        return Answer(out, done)

    def inspect(self, *words):
        done = run("inspect", *map(str, words), "--json", code=None, cwd=self.folder)
        self.assertIn(done.returncode, (0, 2), done.stderr)
        return json.loads(done.stdout)

    def assert_cameras(self, answer, east_m=0.0, within_m=OF_RECORDS, names=NAMES, places=None):
        """These photos and where they belong; others are not asked for."""
        self.assertTrue(answer.is_placed(), answer.said)
        offsets = answer.offsets_m(places or self.places, east_m)
        self.assertEqual(set(names) - set(offsets), set(), answer.said)
        misses = {name: math.hypot(*offsets[name]) for name in names}
        self.assertLess(statistics.median(misses.values()), within_m[0], (misses, answer.said))
        self.assertLess(max(misses.values()), within_m[1], (misses, answer.said))

    def assert_size(self, answer, gsd_m=0.066, area_m2=12_900.0):
        """Of the map, from which also follows how high the cameras stand."""
        self.assertAlmostEqual(answer.report["gsd_m"], gsd_m, delta=0.07 * gsd_m)
        self.assertAlmostEqual(answer.report["area_m2"], area_m2, delta=0.12 * area_m2)

    def assert_map(self, answer, east_m=0.0, **cameras):
        """The map of all eighteen, moved where the case says so."""
        self.assert_cameras(answer, east_m, **cameras)
        self.assertEqual(answer.report["photos"]["aligned"], 18, answer.said)
        self.assert_size(answer)
        for edge, (found, right) in enumerate(zip(answer.report["bounds"], BOUNDS)):
            metres = (found - right) * (A_DEGREE_NORTH_M if edge % 2 else A_DEGREE_EAST_M) - (0.0 if edge % 2 else east_m)
            self.assertLess(abs(metres), 10.0, (answer.report["bounds"], answer.said))  # four digits of a degree are 11 m

    def assert_told(self, answer, *patterns):
        """No map by what could not be read, and words that name the cause. A map by the photos' own records is none."""
        for pattern in patterns:
            self.assertRegex(answer.said, re.compile(pattern, re.IGNORECASE))
        if answer.is_placed():
            self.assert_map(answer)

    def assert_map_or_told(self, answer, patterns, east_m=0.0, **cameras):
        """Either of both right answers of a case; the map where there is one in the right place."""
        try:
            self.assert_map(answer, east_m, **cameras)
        except AssertionError:
            if not all(re.search(pattern, answer.said, re.IGNORECASE) for pattern in patterns):
                raise
            self.assert_told(answer, *patterns)
