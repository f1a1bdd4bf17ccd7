"""Surveyed points and places given to a finished map: it is moved to them as a whole, no photo compared again; and what is refused leaves it as
it is."""
import hashlib
import json
import math
import shutil
import subprocess

from flights.made_flights import gcp_list, metres_a_degree, turned
from program import ScratchCase, cameras_of, report_of, run, tiles_of


class Control(ScratchCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        run("simulate", "-o", cls.scratch / "sim", "--photos", "16", "--size", "800x600", "--noise", "xmp", "--no-world")
        cls.truth = json.loads((cls.scratch / "sim" / "truth" / "poses.json").read_text())
        cls.finished = cls.scratch / "finished"
        cls.before = cls.stitch(cls.finished)

    @classmethod
    def stitch(cls, out, *more):
        run("stitch", cls.scratch / "sim" / "photos", *more, "-o", out)
        return report_of(out)

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
            text = run("locate", out, "--photo", photo["name"], "--pixel", "399.5,299.5").stdout
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
        self.assertIn("No photo", run("locate", out, "--lonlat", "0,0").stderr)
        stages = {stage["stage"]: stage for stage in report["timings"]}
        self.assertNotIn("check", stages)
        self.assertLess(stages["align"]["cpu_s"], 0.1 * next(stage for stage in self.before["timings"] if stage["stage"] == "align")["cpu_s"])
        self.assertTrue(any("was moved as a whole to 3 ground control points" in line for line in report["warnings"]))
        self.assertEqual([point["is_used"] for point in report["alignment"]["ground_control"]], [True] * 3)
        # The next run of the same finds nothing to do.
        tiles = tiles_of(out)
        again = self.stitch(out, points)
        self.assertEqual(again["blocks"]["kept"], again["blocks"]["total"])
        self.assertEqual(tiles_of(out), tiles)

    def test_marks_in_photos_that_are_not_here_are_said_where_the_map_is_only_moved(self):
        out = self.scratch / "strayed"
        shutil.copytree(self.finished, out)
        points = self.surveyed("strays", [(-20, -20), (18, -15), (5, 20)])
        words = points.read_text().splitlines()[1].split()
        words[5] = "NOT_HERE.JPG"
        points.write_text(points.read_text().rstrip("\n") + "\n" + " ".join(words) + "\n")
        report = self.stitch(out, points)
        self.assertTrue(any("was moved as a whole to 3 ground control points" in line for line in report["warnings"]), report["warnings"])
        self.assertTrue(any("1 mark is in a photo that is not here (NOT_HERE.JPG)" in line for line in report["warnings"]), report["warnings"])

    def test_each_point_is_predicted_by_the_others(self):
        places = [(-20, -20), (18, -15), (5, 20), (-15, 14), (20, 12)]
        points = self.surveyed("five", places)
        report = self.stitch(self.scratch / "predicted", points)
        control = report["alignment"]["ground_control"]
        self.assertEqual([point["is_used"] for point in control], [True] * 5)
        misses = {point["name"]: math.hypot(point["left_out"]["miss_east_m"], point["left_out"]["miss_north_m"]) for point in control}
        self.assertLess(max(misses.values()), 6 * report["gsd_m"], "a sound survey is met where it was not told")
        run("report", self.scratch / "predicted", "-o", self.scratch / "predicted.html")
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


class Place(ScratchCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        run("simulate", "-o", cls.scratch / "sim", "--photos", "20", "--size", "800x600", "--relief-m", "2", "--noise", "no-pose",
            "--no-world")
        cls.truth = json.loads((cls.scratch / "sim/truth/poses.json").read_text())
        cls.finished = cls.scratch / "finished"
        run("stitch", cls.scratch / "sim/photos", "-o", cls.finished, "--layers", "error", "--formats", "geotiff,pmtiles")
        report = report_of(cls.finished)
        assert not report["is_placed"]
        (cls.scratch / "gcp_list.txt").write_text(gcp_list(cls.truth, [(-25, -30), (25, 30), (-20, 25), (22, -28), (0, 0)]))

    def map(self, name):
        shutil.copytree(self.finished, self.scratch / name)
        return self.scratch / name

    def place(self, folder, *arguments, code=1):
        return run("place", folder, *map(str, arguments), code=code)

    def placed(self, folder, *arguments):
        self.place(folder, *arguments, code=0)
        return report_of(folder)

    def cameras(self, folder):
        """East and north on Earth of each camera, by the map and in truth, in metres from the flight's origin; by a map
        that lies nowhere, from 0, 0."""
        is_placed = report_of(folder)["is_placed"]
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
        self.assertLess(next(timing for timing in report["timings"] if timing["stage"] == "align")["cpu_s"], 0.5)

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
        run("stitch", self.scratch / "sim/photos", "-o", folder)
        again = report_of(folder)
        self.assertTrue(again["is_placed"])
        self.assertEqual(again["bounds"], report["bounds"])

    def test_check_points_among_surveyed_points_are_compared_with_the_map(self):
        folder = self.map("by_points_with_check")
        listed = self.scratch / "with_check.txt"
        rows = (self.scratch / "gcp_list.txt").read_text().splitlines()
        listed.write_text("".join(row + ("_check\n" if row.endswith(" p4") else "\n") for row in rows))
        self.placed(folder, "--gcp", listed)
        run("stitch", self.scratch / "sim/photos", "-o", folder)  # which does not have the list
        points = {point["name"]: point for point in report_of(folder)["alignment"]["ground_control"]}
        self.assertEqual([name for name, point in points.items() if point["is_check"]], ["p4_check"])
        self.assertTrue(all(point["is_used"] and point["marks"] for point in points.values()), points)

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
        # Nothing tells how far off it lies: no surface states a number.
        self.assertIsNone(report["quality"]["absolute"]["sigma_m"])
        located = run("locate", folder, "--photo", photo["name"], "--pixel", "399.5,299.5").stdout
        self.assertIn("with an unknown error", located)

    def test_the_map_is_drawn_again_as_it_was_asked_for(self):
        usual, small = self.map("usual_tiles"), self.scratch / "small_tiles"
        run("stitch", self.scratch / "sim/photos", "-o", small, "--quality", "20", "--title", "Field 7")
        self.assertEqual(self.placed(small, "--origin", "46.8,7.1")["title"], "Field 7")
        self.placed(usual, "--origin", "46.8,7.1")
        size = lambda folder: (folder / "mosaic.mbtiles").stat().st_size
        self.assertLess(size(small), 0.7 * size(usual))

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
                                 (("--gcp", wrong), f"rows name {len(rows) - 1} photos (the first is OTHER.JPG), and none of the photos given is called so"),
                                 (("--gcp", mirrored), "contradict each other"),
                                 (("--gcp", folder / "report.json"), "report.json cannot be read as surveyed points")):
            self.assertIn(words, self.place(folder, *arguments).stderr)
            self.assertEqual(digest(), before, arguments)
        said = self.place(folder, "--origin", "46.8,7.1", code=0).stdout
        # All that is said of it, as when it was made: its limits too, and no size that nothing tells.
        self.assertIn("  note: The map was placed by hand", said)
        for limit in ("The scale is a guess", "Which way is north is a guess", "The map was placed by hand"):
            self.assertIn(f"  limit: {limit}", said)
        self.assertIn("size unknown", said)
        self.assertIn("Place in doubt. Absolute accuracy: unknown", said)
        self.assertNotRegex(said, r"\d ha at|cm a pixel")
        self.assertIn("--again", self.place(folder, "--origin", "46.9,7.1").stderr)
        report = self.placed(folder, "--origin", "46.9,7.1", "--again")
        self.assertTrue(report["bounds"][1] < 46.9 < report["bounds"][3])
        empty = self.scratch / "empty"
        empty.mkdir()
        self.place(empty, "--origin", "46.8,7.1")
