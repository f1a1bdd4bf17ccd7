"""Lists of positions as users were reported to have them: the map where the list says, or words that name what in the list
cannot be read. Never a map elsewhere without a word."""
import re
import subprocess
import unittest

from reported_flight import A_DEGREE_EAST_M, MOVED_EAST_DEG, NAMES, OF_A_LIST, PROGRAM, ReportedFlight

FIRST_SIX = NAMES[:6]


class Positions(ReportedFlight):
    def test_degrees_below_a_system_of_metres(self):
        answer = self.stitch("photos", "degrees-under-utm/geo.txt")
        self.assert_map_or_told(answer, [r"geo\.txt", "degrees", "EPSG:32615"], east_m=4.0)
        self.assertIn("geo.txt", answer.said)  # how it was read, or why it is not used

    def test_longitude_first_as_the_header_says(self):
        answer = self.stitch("image-longitude-latitude/photos", "image-longitude-latitude/positions.csv")
        moved = {name: (lat, lon + MOVED_EAST_DEG) for name, (lat, lon) in self.places.items()}
        self.assert_cameras(answer, names=FIRST_SIX, places=moved, within_m=OF_A_LIST)
        self.assertEqual(answer.report["photos"]["aligned"], 6)
        self.assert_size(answer, gsd_m=0.063, area_m2=6_800.0)

    def test_metres_without_a_system(self):
        answer = self.stitch("photos", "pix4d-projected/geolocation.csv")
        self.assert_map_or_told(answer, [r"geolocation\.csv", "metres|projected", "EPSG"], east_m=4.0)

    def test_cells_of_all_ways_to_write_degrees(self):
        for case, cause in (("decimal-comma/images.csv", r"latitude.*46,84260708"),
                            ("degrees-minutes-seconds/positions.csv", r"latitude.*N?46°50'33\.39"),
                            ("degree-signs/positions.csv", r"latitude.*46\.84260708°")):
            with self.subTest(case):
                self.assert_map_or_told(self.stitch("photos-nogps", case), [cause], within_m=OF_A_LIST)

    def test_heights_in_feet(self):
        answer = self.stitch("photos-nogps", "altitude-in-feet/positions.csv", "--takeoff-height-m", 158.5, "--method", "imu")
        self.assert_cameras(answer)
        for height_m in answer.heights_m:
            # Above the sea; 29 m more where the column is taken as above the ellipsoid.
            self.assertTrue(abs(height_m - 40.0) < 2.0 or abs(height_m - 69.0) < 2.0, (height_m, answer.said))

    def test_a_list_that_a_spreadsheet_wrote_with_its_mark(self):
        self.assert_map(self.stitch("photos-nogps", "semicolon-bom/positions.csv"), within_m=OF_A_LIST)

    def test_a_list_of_half_of_the_photos(self):
        self.assert_map(self.stitch("photos-nogps", "half-a-list/geo.txt"), within_m=OF_A_LIST)
        self.assert_map(self.stitch("photos", "half-a-list/geo.txt"))

    def test_half_of_the_photos_a_little_elsewhere(self):
        rows = (self.folder / "half-a-list" / "geo.txt").read_text().splitlines()
        moved = [rows[0]]
        for row in rows[1:]:
            name, lon, lat, height = row.split()
            moved.append(f"{name} {float(lon) + 4.0 / A_DEGREE_EAST_M:.8f} {lat} {height}")
        (self.scratch / "moved").mkdir()
        (self.scratch / "moved" / "geo.txt").write_text("\n".join(moved) + "\n")
        answer = self.stitch("photos", self.scratch / "moved" / "geo.txt")
        self.assertEqual(answer.report["photos"]["aligned"], 18, answer.said)
        for east, north in answer.offsets_m(self.places).values():  # one block, between the two
            self.assertTrue(-1.0 < east < 5.0 and abs(north) < 1.5, (east, north, answer.said))


class Inspect(ReportedFlight):
    """`inspect` says of each file what it was read as, how many rows count, and how they agree with the photos."""

    def lines_about(self, name, *words):
        done = subprocess.run([PROGRAM, "inspect", *words], capture_output=True, text=True, cwd=self.folder)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertLess(len(done.stdout.splitlines()), 60, "one screen")
        return " ".join(line for line in done.stdout.splitlines() if line.startswith(" ") or name in line)

    def test_it_tells_of_each_list(self):
        for case, rows in (("semicolon-bom/positions.csv", 18), ("half-a-list/geo.txt", 9), ("degrees-under-utm/geo.txt", 18),
                           ("pix4d-projected/geolocation.csv", 18)):
            with self.subTest(case):
                said = self.lines_about(case.split("/")[1], "photos", case)
                self.assertRegex(said, rf"\b{rows} (of {rows} )?rows")
                self.assertRegex(said, r"\d(\.\d+)? (m|cm|metres|km)\b")

    def test_it_tells_of_each_track(self):
        for case in ("tracks/us-dates.csv", "tracks/gpx-prefix.gpx", "tracks/nmea-without-checksums.nmea",
                     "autel-subtitles/MAX_0001.SRT"):
            name = case.split("/")[1]
            with self.subTest(case):
                said = self.lines_about(name, "photos-nogps", case)
                self.assertRegex(said, rf"Used +{re.escape(name)} \(\w+\): 18 of 18 photos placed")
                if name != "MAX_0001.SRT":  # seven seconds between its positions: too few to fit the photos' own to
                    self.assertRegex(self.lines_about(name, "photos", case), r"\d\.\d m from the photos' own positions")
        events = "raw_201606231916_UBX_events.pos"
        self.assertRegex(self.lines_about(events, "photos-nogps", f"one-event-missing/{events}"), r"18 of 18 photos stand where")

    def test_positions_are_those_that_the_map_stands_on(self):
        for photos, case, sources in (("photos", "pix4d-projected/geolocation.csv", {"geolocation.csv": 18}),
                                      ("photos", "half-a-list/geo.txt", {"geo.txt": 9, "exif": 9}),
                                      ("photos-nogps", "tracks/us-dates.csv", {"us-dates.csv": 18}),
                                      ("photos-nogps", "half-a-list/geo.txt", {"geo.txt": 9, "none": 9})):
            with self.subTest(case):
                self.assertEqual(self.inspect(photos, case)["position_sources"], sources)

    def test_what_it_says_is_what_stitch_does(self):
        verdict = self.inspect("photos-nogps", "decimal-comma/images.csv")
        self.assertEqual(verdict["photos_placeable"], 18, verdict["warnings"])
        verdict = self.inspect("photos", "panorama-apart")
        self.assertEqual(verdict["photos_readable"], 18, verdict["left_out"])
        verdict = self.inspect("float32-tiff")
        self.assertTrue(verdict["photos_readable"] == 3 or all("float" in photo["reason"] for photo in verdict["left_out"]), verdict)


if __name__ == "__main__":
    unittest.main()
