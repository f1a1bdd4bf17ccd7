"""A finished map that lies nowhere on Earth, placed later through the real program: by surveyed points, and by a place
with scale and north; no photo compared again; and what is refused leaves the map as it is."""
import hashlib
import json
import math
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

from control_test import gcp_list, metres_a_degree
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from server_support import BINARY  # noqa: E402


class Place(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = pathlib.Path(tempfile.mkdtemp(prefix="skyquilt_place_"))
        subprocess.run([BINARY, "simulate", "-o", cls.scratch / "sim", "--photos", "20", "--size", "800x600", "--relief-m", "2",
                        "--noise", "no-pose", "--no-world"], check=True, capture_output=True)
        cls.truth = json.loads((cls.scratch / "sim/truth/poses.json").read_text())
        cls.finished = cls.scratch / "finished"
        subprocess.run([BINARY, "stitch", cls.scratch / "sim/photos", "-o", cls.finished, "--layers", "error", "--formats", "geotiff,pmtiles"], check=True,
                       capture_output=True)
        report = json.loads((cls.finished / "report.json").read_text())
        assert not report["is_placed"]
        (cls.scratch / "gcp_list.txt").write_text(gcp_list(cls.truth, [(-25, -30), (25, 30), (-20, 25), (22, -28), (0, 0)]))

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.scratch)

    def map(self, name):
        shutil.copytree(self.finished, self.scratch / name)
        return self.scratch / name

    def place(self, folder, *arguments):
        return subprocess.run([BINARY, "place", folder, *map(str, arguments)], capture_output=True, text=True)

    def placed(self, folder, *arguments):
        done = self.place(folder, *arguments)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return json.loads((folder / "report.json").read_text())

    def cameras(self, folder):
        """East and north on Earth of each camera, by the map and in truth, in metres from the flight's origin; by a map
        that lies nowhere, from 0, 0."""
        is_placed = json.loads((folder / "report.json").read_text())["is_placed"]
        east, north = metres_a_degree(self.truth) if is_placed else (111319.5, 110574.3)
        origin = self.truth["origin"] if is_placed else {"lon_deg": 0.0, "lat_deg": 0.0}
        said = {f["properties"]["name"]: f["properties"] for f in json.loads((folder / "photos.geojson").read_text())["features"]}
        return [(complex((said[p["name"]]["camera_lon"] - origin["lon_deg"]) * east,
                         (said[p["name"]]["camera_lat"] - origin["lat_deg"]) * north),
                 complex(*p["camera_center_in_enu"][:2])) for p in self.truth["photos"]]

    def assert_drawn_again_alone(self, report):
        stages = [timing["stage"] for timing in report["timings"]]
        self.assertNotIn("check", stages)  # which looks at every photo and finds its features
        self.assertNotIn("pose", stages)
        align = next(timing for timing in report["timings"] if timing["stage"] == "align")
        self.assertLess(align["cpu_s"], 0.5)

    def test_surveyed_points_place_the_map(self):
        folder = self.map("by_points")
        report = self.placed(folder, "--gcp", self.scratch / "gcp_list.txt")
        self.assertTrue(report["is_placed"])
        self.assertTrue(report["poses"]["is_placed"])
        self.assertFalse(any("NOT GEOREFERENCED" in text for text in report["warnings"]), report["warnings"])
        self.assertTrue(any("placed by 5 surveyed points" in text for text in report["warnings"]), report["warnings"])
        self.assertTrue(all(point["is_used"] for point in report["alignment"]["ground_control"]))
        self.assert_drawn_again_alone(report)
        misses = sorted(abs(said - true) for said, true in self.cameras(folder))
        print(f"by points: cameras {misses[len(misses) // 2]:.2f} m off in the median, {misses[-1]:.2f} m at most")
        self.assertLess(misses[len(misses) // 2], 0.5)
        true_gsd = self.truth["photos"][0]["camera_center_in_enu"][2] / self.truth["intrinsics"]["focal_x_px"]
        self.assertAlmostEqual(report["gsd_m"] / true_gsd, 1.0, delta=0.05)
        west, south, east, north = report["bounds"]
        self.assertTrue(west < self.truth["origin"]["lon_deg"] < east and south < self.truth["origin"]["lat_deg"] < north)
        for name in ("mosaic.tif", "mosaic.pmtiles", "layer_error.mbtiles", "layers.json"):
            self.assertGreaterEqual((folder / name).stat().st_mtime, (folder / "mosaic.mbtiles").stat().st_mtime - 60)
        info = json.loads(subprocess.run(["gdalinfo", "-json", folder / "mosaic.tif"], check=True, capture_output=True).stdout)
        lon, lat = info["wgs84Extent"]["coordinates"][0][0]
        self.assertAlmostEqual(lat, self.truth["origin"]["lat_deg"], delta=0.01)
        # The place stays: the same photos stitched again are not aligned anew.
        subprocess.run([BINARY, "stitch", self.scratch / "sim/photos", "-o", folder], check=True, capture_output=True)
        again = json.loads((folder / "report.json").read_text())
        self.assertTrue(again["is_placed"])
        self.assertEqual(again["bounds"], report["bounds"])

    def test_a_place_with_scale_and_north_will_do(self):
        folder = self.map("by_place")
        pairs = self.cameras(folder)
        (first_said, first_true), (last_said, last_true) = pairs[0], max(pairs, key=lambda pair: abs(pair[1] - pairs[0][1]))
        turn = (last_true - first_true) / (last_said - first_said)
        photo = self.truth["photos"][0]
        report = self.placed(folder, "--origin", f"{photo['lat_deg']},{photo['lon_deg']}", "--at", photo["name"], "--scale",
                             f"{abs(turn)}x", "--north", math.degrees(math.atan2(turn.imag, turn.real)))
        self.assertTrue(report["is_placed"])
        self.assert_drawn_again_alone(report)
        misses = sorted(abs(said - true) for said, true in self.cameras(folder))
        print(f"by a place: cameras {misses[len(misses) // 2]:.2f} m off in the median, {misses[-1]:.2f} m at most")
        self.assertLess(misses[0], 0.05)
        self.assertLess(misses[-1], 1.5)

    def test_refusals_say_what_to_do_and_leave_the_map(self):
        folder = self.map("refused")
        digest = lambda: hashlib.sha256((folder / "mosaic.mbtiles").read_bytes()).hexdigest()
        before = digest()
        few, wrong, mirrored = (self.scratch / name for name in ("few.txt", "wrong.txt", "mirrored.txt"))
        few.write_text(gcp_list(self.truth, [(-25, -30), (25, 30)]))
        rows = (self.scratch / "gcp_list.txt").read_text().splitlines()
        wrong.write_text("\n".join(rows[:1] + [row.replace(row.split()[5], "OTHER.JPG") for row in rows[1:]]) + "\n")
        mirrored.write_text("\n".join(rows[:1] + [f"{2 * self.truth['origin']['lon_deg'] - float(row.split()[0]):.10f} "
                                                  + row.split(" ", 1)[1] for row in rows[1:]]) + "\n")
        for arguments, words in (((), "--origin LAT,LON, --gcp gcp_list.txt or --point"),
                                 (("--point", "46.8,7.1"), "where the map shows a thing and where it is"),
                                 (("--point", "0,0=here"), "write it as LAT,LON"),
                                 (("--point", "0,0=95,7"), "latitude up to 85"),
                                 (("--point", "0,0=1,1", "--point", "0,0=1,1"), "too near together"),
                                 (("--origin", "here"), "write it as LAT,LON"),
                                 (("--origin", "95,7"), "latitude up to 85"),
                                 (("--origin", "46.8,7.1", "--scale", "big"), "--scale is 'big'"),
                                 (("--origin", "46.8,7.1", "--scale", "1000000x"), "m of ground"),
                                 (("--origin", "46.8,7.1", "--at", "NO.JPG"), "no photo called NO.JPG"),
                                 (("--gcp", few), "Of 2 surveyed points 2 can be used, and 3 are needed"),
                                 (("--gcp", wrong), "marked in fewer than two photos"),
                                 (("--gcp", mirrored), "contradict each other"),
                                 (("--gcp", folder / "report.json"), "report.json cannot be read as surveyed points")):
            done = self.place(folder, *arguments)
            self.assertEqual(done.returncode, 1, (arguments, done.stdout, done.stderr))
            self.assertIn(words, done.stderr)
            self.assertEqual(digest(), before, arguments)
        self.placed(folder, "--origin", "46.8,7.1")
        done = self.place(folder, "--origin", "46.9,7.1")
        self.assertEqual(done.returncode, 1)
        self.assertIn("--again", done.stderr)
        report = self.placed(folder, "--origin", "46.9,7.1", "--again")
        self.assertTrue(report["bounds"][1] < 46.9 < report["bounds"][3])
        empty = self.scratch / "empty"
        empty.mkdir()
        self.assertEqual(self.place(empty, "--origin", "46.8,7.1").returncode, 1)


if __name__ == "__main__":
    unittest.main()
