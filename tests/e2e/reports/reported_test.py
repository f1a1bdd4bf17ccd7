"""Lists of positions, tracks, surveyed points and other pictures beside the photos as users were reported to have them, and what they sent to
servers: the map where it belongs, or words that name what cannot be read. Never a map elsewhere without a word."""
import pathlib
import re
import shutil
import sqlite3
import subprocess
import tempfile
import unittest

from reported_flight import A_DEGREE_EAST_M, MOVED_EAST_DEG, NAMES, OF_A_LIST, OF_A_TRACK, REPORTS, ReportedFlight
from program import run
from server_support import Server


class Positions(ReportedFlight):
    def test_degrees_below_a_system_of_metres(self):
        answer = self.stitch("photos", "degrees-under-utm/geo.txt")
        self.assert_map_or_told(answer, [r"geo\.txt", "degrees", "EPSG:32615"], east_m=4.0)
        self.assertIn("geo.txt", answer.said)  # how it was read, or why it is not used

    def test_longitude_first_as_the_header_says(self):
        answer = self.stitch("image-longitude-latitude/photos", "image-longitude-latitude/positions.csv")
        moved = {name: (lat, lon + MOVED_EAST_DEG) for name, (lat, lon) in self.places.items()}
        self.assert_cameras(answer, names=NAMES[:6], places=moved, within_m=OF_A_LIST)
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
        for east, north in answer.offsets_m(self.places).values():  # one block, where the list has it
            self.assertTrue(2.0 < east < 5.0 and abs(north) < 1.5, (east, north, answer.said))


class Inspect(ReportedFlight):
    """`inspect` says of each file what it was read as, how many rows count, and how they agree with the photos."""

    def lines_about(self, name, *words):
        done = run("inspect", *words, cwd=self.folder)
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


class Tracks(ReportedFlight):
    def assert_placed(self, track):
        answer = self.stitch("photos-nogps", track)
        self.assert_map(answer, within_m=OF_A_TRACK)
        self.assertEqual(answer.report["poses"]["photos_by_log"], 18, answer.said)

    def test_tables_and_the_ways_to_write_dates(self):
        for case in ("DJIFlightRecord_2016-06-23_[16-31-29].csv", "us-dates.csv", "date-and-time-apart.csv", "epoch-ms.csv",
                     "2016-06-23_16-31-19_v2.csv"):
            with self.subTest(case):
                self.assert_placed(f"tracks/{case}")

    def test_tracks_of_other_programs(self):
        for case in ("gpx-prefix.gpx", "gpx-single-quotes.gpx", "nmea-without-checksums.nmea"):
            with self.subTest(case):
                self.assert_placed(f"tracks/{case}")

    def test_events_of_which_one_is_missing(self):
        answer = self.stitch("photos-nogps", "one-event-missing/raw_201606231916_UBX_events.pos")
        if not answer.is_placed():
            self.assert_told(answer, r"events\.pos", r"\b17\b", r"\b18\b")
            return
        self.assertEqual(answer.report["photos"]["aligned"], 18, answer.said)
        self.assert_cameras(answer, within_m=(0.7, 5.0))  # between its neighbours: half a step at most
        misses = sorted(max(abs(east), abs(north)) for east, north in answer.offsets_m(self.places).values())
        self.assertLess(misses[-2], 1.5, answer.said)

    def test_subtitles_of_another_maker(self):
        for case, cause in (("MAX_0001.ASS", r"MAX_0001\.ASS.*(Autel|subtitle)"), ("MAX_0001.SRT", r"MAX_0001\.SRT.*(this form|Autel|not read)")):
            with self.subTest(case):
                # Six decimals of a degree, and a caption holds until the next begins.
                self.assert_map_or_told(self.stitch("photos-nogps", f"autel-subtitles/{case}"), [cause], within_m=OF_A_TRACK)


class SurveyedPoints(ReportedFlight):
    """They lie 5 m east of where the photos alone put them."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.plain = cls.stitch(cls("test_the_plain_list_moves_the_map"), "photos", "gcp-plain/gcp_list.txt")

    def test_the_plain_list_moves_the_map(self):
        self.assert_cameras(self.plain, east_m=5.0, within_m=(1.5, 2.0))
        self.assertEqual([point["is_used"] for point in self.plain.report["alignment"]["ground_control"]], [True] * 5)

    def test_other_ways_to_write_the_same_list(self):
        for case, cause in (("gcp-compound-system", r"EPSG:32615\+5773"), ("gcp-crlf-tabs-header", r"gcp_list\.txt.*(line|row)")):
            with self.subTest(case):
                answer = self.stitch("photos", f"{case}/gcp_list.txt")
                if answer.report["alignment"]["ground_control"]:
                    self.assert_cameras(answer, within_m=(0.05, 0.1), places=self.plain.cameras)
                else:
                    self.assert_told(answer, cause)


class Pictures(ReportedFlight):
    def left_out(self, answer):
        return {photo["name"]: photo["reason"] for photo in answer.report["left_out_photos"]}

    def test_raw_files_beside_the_photos(self):
        photos = [f"photos/{name}" for name in NAMES[:4]]
        alone, answer = self.stitch(*photos), self.stitch(*photos, "nef-beside-jpeg")
        self.assertEqual(answer.report["photos"], {"total": 8, "aligned": 4, "pose_only": 0, "left_out": 4}, answer.said)
        self.assertAlmostEqual(answer.report["gsd_m"], alone.report["gsd_m"], delta=0.0005)
        self.assertAlmostEqual(answer.report["gsd_m"], 0.063, delta=0.003)
        self.assert_cameras(answer, within_m=(0.05, 0.1), names=NAMES[:4], places=alone.cameras)
        for name, reason in self.left_out(answer).items():
            self.assertRegex(reason, r"(?i)\braw\b", name)
        told = self.inspect(*photos, "nef-beside-jpeg")
        self.assertEqual(len(told["cameras"]), 1, told["cameras"])
        self.assertEqual([photo["name"].rsplit(".")[1] for photo in told["left_out"]], ["NEF"] * 4)

    def test_a_panorama_of_the_place_of_take_off(self):
        answer = self.stitch("photos", "panorama-apart")
        self.assert_map(answer)
        self.assertRegex(self.left_out(answer)["DJI_0036_PANO.JPG"], r"(?i)panorama")
        self.assertAlmostEqual(answer.report["area_m2"], 12_854, delta=130)

    def test_a_panorama_amid_the_others(self):
        folder = self.scratch / "amid"
        folder.mkdir()
        for photo in (self.folder / "photos").iterdir():
            (folder / photo.name).write_bytes(photo.read_bytes())
        panorama = self.folder / "panorama-apart" / "DJI_0036_PANO.JPG"
        (folder / "DJI_0026_PANO.JPG").write_bytes(panorama.read_bytes())
        answer = self.stitch(folder)
        self.assert_map(answer)
        self.assertIn("DJI_0026_PANO.JPG", self.left_out(answer))

    def test_exports_beside_their_originals(self):
        answer = self.stitch("photos", "edited-copies")
        self.assert_map(answer)
        for name in ("DJI_0021-2.jpg", "DJI_0022-2.jpg", "DJI_0023-2.jpg", "DJI_0024-2.jpg"):
            self.assertNotIn(name, answer.cameras, answer.said)  # drawn, they would make the map brighter
            self.assertIn("DJI_00" + name[6:8], self.left_out(answer)[name])

    def test_temperatures_as_floating_point(self):
        answer = self.stitch("float32-tiff")
        told = self.inspect("float32-tiff")
        if answer.report is None:
            self.assertRegex(answer.said, r"(?i)32.?bit|floating|float32")
            self.assertEqual(told["photos_readable"], 0, told)
            for photo in told["left_out"]:
                self.assertRegex(photo["reason"], r"(?i)32.?bit|floating|float32")
            return
        self.assertEqual((answer.report["photos"]["total"], answer.report["photos"]["left_out"], told["photos_readable"]), (3, 0, 3), answer.said)
        self.assert_cameras(answer, names=[name for name in answer.cameras], places=self.of_the_same_moment(answer))

    def of_the_same_moment(self, answer):
        """Temperatures were taken where the photo of the same number was."""
        return {name: self.places[name.split("_T")[0] + ".JPG"] for name in answer.cameras}


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
        made = self.server.stitched(photos)
        service = f"/arcgis/rest/services/{made['flight']['id']}/MapServer"
        for part, key in (("layers", "id"), ("legend", "layerId")):
            _, answer = self.server.json("GET", f"{service}/{part}?f=json", code=200)
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
