"""A finished map that gets its first ground control points: moved to them as a whole, without any photo compared again."""
import json
import math
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

from append_test import cameras_of, tiles_of
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from server_support import BINARY  # noqa: E402

def turned(quaternion, vector):
    """The vector turned by (w, x, y, z)."""
    w, *axis = quaternion
    cross = lambda a, b: [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    twice = [2 * x for x in cross(axis, vector)]
    return [v + w * t + c for v, t, c in zip(vector, twice, cross(axis, twice))]


def metres_a_degree(truth):
    """East and north at the flight, by its own photos."""
    def along(axis, key):
        photos = sorted(truth["photos"], key=lambda photo: photo[key])
        first, last = photos[0], photos[-1]
        return (last["camera_center_in_enu"][axis] - first["camera_center_in_enu"][axis]) / (last[key] - first[key])
    return along(0, "lon_deg"), along(1, "lat_deg")


def gcp_list(truth, places):
    """ODM's format, of places east and north of the flight's middle, marked in every photo that shows them."""
    lens, origin = truth["intrinsics"], truth["origin"]
    a_degree_east, a_degree_north = metres_a_degree(truth)
    rows = ["EPSG:4326"]
    for number, (east, north) in enumerate(places):
        lon, lat = origin["lon_deg"] + east / a_degree_east, origin["lat_deg"] + north / a_degree_north
        for photo in truth["photos"]:
            ray = [a - b for a, b in zip((east, north, 0.0), photo["camera_center_in_enu"])]
            x, y, z = turned(photo["cam_from_enu_wxyz"], ray)
            column = lens["focal_x_px"] * x / z + lens["center_x_px"] + 0.5
            row = lens["focal_y_px"] * y / z + lens["center_y_px"] + 0.5
            if 0 < column < lens["width_px"] and 0 < row < lens["height_px"]:
                rows.append(f"{lon:.10f} {lat:.10f} {origin['height_ellipsoid_m']:.3f} {column:.3f} {row:.3f} {photo['name']} p{number}")
    return "\n".join(rows) + "\n"


class Control(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = pathlib.Path(tempfile.mkdtemp(prefix="skyquilt_control_"))
        subprocess.run([BINARY, "simulate", "-o", cls.scratch / "sim", "--photos", "16", "--size", "800x600", "--noise", "xmp",
                        "--no-world"], check=True, capture_output=True)
        cls.truth = json.loads((cls.scratch / "sim" / "truth" / "poses.json").read_text())
        cls.finished = cls.scratch / "finished"
        cls.before = cls.stitch(cls.finished)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.scratch)

    @classmethod
    def stitch(cls, out, *more):
        subprocess.run([BINARY, "stitch", cls.scratch / "sim" / "photos", *more, "-o", out], check=True,
                       capture_output=True)
        return json.loads((out / "report.json").read_text())

    def surveyed(self, name, places):
        path = self.scratch / name / "gcp_list.txt"
        path.parent.mkdir()
        path.write_text(gcp_list(self.truth, places))
        return path

    def middle_error_m(self, out):
        """Horizontal, of where the map says the middle of a photo's ground is, the median over every third photo."""
        a_degree_east, a_degree_north = metres_a_degree(self.truth)
        misses = []
        for photo in self.truth["photos"][::3]:
            down = turned([photo["cam_from_enu_wxyz"][0], *(-x for x in photo["cam_from_enu_wxyz"][1:])], [0.0, 0.0, 1.0])
            center = photo["camera_center_in_enu"]
            east, north = (center[k] - down[k] / down[2] * center[2] for k in (0, 1))
            text = subprocess.run([BINARY, "locate", out, "--photo", photo["name"], "--pixel", "399.5,299.5"], check=True,
                                  capture_output=True, text=True).stdout
            lon, lat = (float(word) for word in text.split()[0].split(","))
            misses.append(math.hypot((lon - self.truth["origin"]["lon_deg"]) * a_degree_east - east,
                                     (lat - self.truth["origin"]["lat_deg"]) * a_degree_north - north))
        return sorted(misses)[len(misses) // 2]

    def test_three_points_given_later_move_the_map_and_compare_nothing_again(self):
        out = self.scratch / "moved"
        shutil.copytree(self.finished, out)
        gsd_m = self.before["gsd_m"]
        self.assertGreater(self.middle_error_m(out), 4 * gsd_m)
        points = self.surveyed("three", [(-20, -20), (18, -15), (5, 20)])
        report = self.stitch(out, points)
        self.assertLess(self.middle_error_m(out), 3 * gsd_m)
        stages = {stage["stage"]: stage for stage in report["timings"]}
        self.assertNotIn("check", stages)
        self.assertLess(stages["align"]["cpu_s"], 0.1 * self.stage(self.before, "align")["cpu_s"])
        self.assertTrue(any("was moved as a whole to 3 ground control points" in line for line in report["warnings"]))
        self.assertEqual([point["is_used"] for point in report["alignment"]["ground_control"]], [True] * 3)
        # The next run of the same finds nothing to do.
        tiles = tiles_of(out)
        again = self.stitch(out, points)
        self.assertEqual(again["blocks"]["kept"], again["blocks"]["total"])
        self.assertEqual(tiles_of(out), tiles)

    @staticmethod
    def stage(report, name):
        return next(stage for stage in report["timings"] if stage["stage"] == name)

    def test_each_point_is_predicted_by_the_others(self):
        places = [(-20, -20), (18, -15), (5, 20), (-15, 14), (20, 12)]
        points = self.surveyed("five", places)
        report = self.stitch(self.scratch / "predicted", points)
        control = report["alignment"]["ground_control"]
        self.assertEqual([point["is_used"] for point in control], [True] * 5)
        misses = {point["name"]: math.hypot(point["left_out"]["miss_east_m"], point["left_out"]["miss_north_m"]) for point in control}
        self.assertLess(max(misses.values()), 6 * report["gsd_m"], "a sound survey is met where it was not told")
        subprocess.run([BINARY, "report", self.scratch / "predicted", "-o", self.scratch / "predicted.html"], check=True, capture_output=True)
        worst = max(misses, key=misses.get)
        self.assertRegex((self.scratch / "predicted.html").read_text(), rf"Each of them placed by the others</th><td>missed by .* in the median of 5, at worst .* \({worst}\)")
        # One that is surveyed a little wrong: the others tell by how much, where the map itself was bent towards it.
        lines = points.read_text().splitlines()
        wrong_m = 1.5
        a_degree_east = metres_a_degree(self.truth)[0]
        for number, line in enumerate(lines):
            if line.endswith(" p0"):
                lon, rest = line.split(" ", 1)
                lines[number] = f"{float(lon) + wrong_m / a_degree_east:.10f} {rest}"
        (self.scratch / "wrong").mkdir()
        wrong = self.scratch / "wrong" / "gcp_list.txt"
        wrong.write_text("\n".join(lines) + "\n")
        control = self.stitch(self.scratch / "bent", wrong)["alignment"]["ground_control"]
        found = {point["name"]: point for point in control}
        self.assertAlmostEqual(found["p0"]["left_out"]["miss_east_m"], -wrong_m, delta=0.35)
        misses = {name: math.hypot(point["left_out"]["miss_east_m"], point["left_out"]["miss_north_m"]) for name, point in found.items()}
        self.assertEqual(max(misses, key=misses.get), "p0")
        # Too few to leave one out.
        three = self.stitch(self.scratch / "only_three", self.surveyed("just_three", places[:3]))
        self.assertFalse(any("left_out" in point for point in three["alignment"]["ground_control"]))

    def test_points_that_nobody_can_use_leave_every_tile_as_it_was(self):
        out = self.scratch / "unmoved"
        shutil.copytree(self.finished, out)
        points = self.surveyed("one", [(0, 0)])
        lines = points.read_text().splitlines()
        points.write_text("\n".join(lines[:2]) + "\n")  # a single mark
        report = self.stitch(out, points)
        self.assertTrue(any("is not used" in line for line in report["warnings"]))
        self.assertEqual(report["blocks"]["kept"], report["blocks"]["total"])
        self.assertEqual(tiles_of(out), tiles_of(self.finished))
        self.assertEqual(cameras_of(out), cameras_of(self.finished))


if __name__ == "__main__":
    unittest.main()
