"""Photos without GPS and what was recorded beside them, through the real program: a flight log, an exposure log, tables that people write, and a
short hop without any GNSS as the source paper flies it; poses held against the simulated truth."""
import csv
import datetime
import json
import math
import pathlib
import shutil
import tempfile
import unittest

from program import ScratchCase, report_of, run, without_metadata
from server_support import Server, photos_in

CLOCK_AHEAD_S = 3607.3
RADIUS_M = 6371000.0


def rms(values):
    return math.sqrt(sum(v * v for v in values) / len(values))


class Result:
    """One map beside the truth of its flight."""

    def __init__(self, flight, out):
        self.report = report_of(out)
        self.poses = self.report["poses"]
        truth = {p["name"]: p for p in json.loads((flight / "truth/poses.json").read_text())["photos"]}
        photos = [f["properties"] for f in json.loads((out / "photos.geojson").read_text())["features"]]
        self.across, self.height, self.turn, self.radius = [], [], [], []
        for photo in photos:
            true = truth[photo["name"]]
            north = math.radians(photo["camera_lat"] - true["lat_deg"]) * RADIUS_M
            east = math.radians(photo["camera_lon"] - true["lon_deg"]) * RADIUS_M * math.cos(math.radians(true["lat_deg"]))
            self.across.append(math.hypot(north, east))
            self.height.append(photo["camera_height_above_ground_m"] - true["camera_center_in_enu"][2])
            self.radius.append(photo["error_radius_m"])
            # The image's top: the camera's -y axis in enu, from the truth's cam_from_enu.
            w, x, y, z = true["cam_from_enu_wxyz"]
            top_e, top_n = -2 * (x * y + w * z), -(1 - 2 * (x * x + z * z))
            heading = math.degrees(math.atan2(top_e, top_n))
            self.turn.append((photo["yaw_deg"] - heading + 180) % 360 - 180)
        self.count = len(photos)

    def print(self, name):
        ahead = self.poses["camera_ahead_of_utc_s"]
        radii = sorted(radius for radius in self.radius if radius is not None)
        print(f"{name}: {self.count} photos, {rms(self.across):.2f} m across, {rms(self.height):.2f} m in height, "
              f"yaw {rms(self.turn):.2f} deg, clock {'not found' if ahead is None else f'{ahead:.3f} s ahead'}, "
              f"stated radius {f'{radii[len(radii) // 2]:.2f} m' if radii else 'none'}")


class LoggedFlightTest(ScratchCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.flight = cls.scratch / "flight"
        run("simulate", "-o", cls.flight, "--photos", 60, "--size", "640x480", "--height", 60, "--noise", "no-pose",
            "--log", "dataflash", "ulog", "csv", "--clock-offset-s", CLOCK_AHEAD_S, "--clock-seconds", "--no-world",
            "--seed", 5)

    def test_options_of_what_is_not_asked_for_are_refused(self):
        for words in (["--mount", "gimbal"], ["--imu", "mpu"], ["--log-rtk"], ["--log-without-gnss"], ["--log-range"], ["--house-heights-m", 3, 4],
                      ["--exposure-recorded"], ["--hot-spot-deg", 5], ["--shaking-dps", 12], ["--readout-ms", 60, "--gyro"]):
            done = run("simulate", "-o", self.scratch / "none", "--photos", 1, *words, code=None)
            self.assertIn("requires", done.stderr, words)

    def stitch(self, log, *more):
        out = self.scratch / ("map_" + log)
        run("stitch", self.flight / "photos", self.flight / "logs" / log, "-o", out, *more)
        result = Result(self.flight, out)
        result.print(log)
        return result

    def check(self, result):
        self.assertEqual(result.count, 60)
        self.assertEqual(result.report["photos"]["left_out"], 0)
        self.assertTrue(result.report["is_placed"])
        self.assertAlmostEqual(result.poses["camera_ahead_of_utc_s"], CLOCK_AHEAD_S, delta=0.05)
        # GNSS wanders by 1 m east and north and 1.8 m up; a flight is a few draws of it.
        self.assertLess(rms(result.across), 3.0)
        self.assertLess(rms(result.height), 2.0)
        self.assertLess(rms(result.turn), 1.0)
        self.assertGreaterEqual(sum(a <= 3 * r for a, r in zip(result.across, result.radius)), 59)

    def test_places_photos_by_a_dataflash_log(self):
        self.check(self.stitch("flight.BIN", "--method", "imu"))

    def test_places_photos_by_a_ulog(self):
        self.check(self.stitch("flight.ulg", "--method", "imu"))

    def test_places_photos_by_csv(self):
        self.check(self.stitch("flight.csv", "--method", "imu"))

    def test_refines_them_by_their_pictures(self):
        result = self.stitch("flight.BIN", "--max-memory", "0.5", "--overwrite")  # of the map by records alone
        self.assertGreaterEqual(result.report["photos"]["aligned"], 55)
        self.assertLess(rms(result.across), 3.0)

    def test_says_what_is_missing_without_the_log(self):
        run("stitch", self.flight / "photos", "-o", self.scratch / "nothing")
        # A map, by what the photos show alone, that says what would place it.
        report = report_of(self.scratch / "nothing")
        self.assertFalse(report["is_placed"])
        self.assertTrue(any("flight log" in warning for warning in report["warnings"]), report["warnings"])

    def test_tells_in_inspection_what_the_log_holds(self):
        verdict = json.loads(run("inspect", self.flight / "photos", self.flight / "logs/flight.BIN", "--json").stdout)
        self.assertEqual(verdict["photos_placeable"], 60)
        (log,) = verdict["logs"]
        self.assertEqual(log["format"], "dataflash")
        self.assertGreater(log["series"]["imu"]["rate_hz"], 40)
        self.assertAlmostEqual(verdict["poses"]["camera_ahead_of_utc_s"], CLOCK_AHEAD_S, delta=0.05)


    def test_takes_the_log_with_an_upload(self):
        files = photos_in(self.flight / "photos")
        files.append(("flight.BIN", (self.flight / "logs/flight.BIN").read_bytes()))
        with Server(tempfile.mkdtemp(dir=self.scratch)) as server:
            flight, job = server.begun(files, options='{"method": "imu"}')
            status, verdict = server.json("GET", f"/api/v1/flights/{flight}/verdict")
            self.assertEqual((status, verdict["photos_placeable"]), (200, 60))
            self.assertEqual(verdict["logs"][0]["format"], "dataflash")
            server.ended(job)
            self.assertEqual(server.json("GET", f"/api/v1/flights/{flight}")[1]["photos"]["left_out"], 0)


class ExposureLogTest(unittest.TestCase):
    """A consumer drone's photos beside the exposure log (MRK) of an RTK receiver."""

    def test_surveyed_positions_overrule_those_of_the_photos(self):
        with tempfile.TemporaryDirectory() as folder:
            flight = pathlib.Path(folder)
            run("simulate", "-o", flight, "--photos", 24, "--size", "320x240", "--noise", "xmp", "--no-world", "--seed", 4)
            start = datetime.datetime(2024, 6, 1, 10, tzinfo=datetime.timezone.utc).timestamp()
            rows = []
            for row, photo in enumerate(json.loads((flight / "truth/poses.json").read_text())["photos"], 1):
                gps_s = start + photo["t_s"] - 315964800 + 18  # GPS time began in 1980 and knows no leap seconds
                rows.append(f"{row}\t{gps_s % 604800:.6f}\t[{int(gps_s // 604800)}]\t     0,N\t     0,E\t   190,V\t"
                            f"{photo['lat_deg']:.9f},Lat\t{photo['lon_deg']:.9f},Lon\t"
                            f"{photo['height_ellipsoid_m']:.3f},Ellh\t0.010000, 0.010000, 0.020000\t50,Q\n")
            (flight / "photos/flight_Timestamp.MRK").write_text("".join(rows))
            run("stitch", flight / "photos", "-o", flight / "map", "--method", "imu")
            result = Result(flight, flight / "map")
            result.print("MRK")
            self.assertEqual(result.count, 24)
            self.assertLess(max(result.across), 0.01)
            # The barometer sets the common zero; against each other the heights are the receiver's.
            self.assertLess(max(result.height) - min(result.height), 0.02)


class HopWithoutGnssTest(ScratchCase):
    """20 m high, no GNSS, a marker at take-off, a range finder; the source paper's case."""

    SEEDS = range(1, 6)

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        for seed in cls.SEEDS:
            run("simulate", "-o", cls.scratch / f"hop_{seed}", "--photos", 8, "--size", "640x480", "--height", 20,
                "--speed", 4, "--overlap", 0.7, "--sidelap", 0.6, "--noise", "no-pose", "--log", "dataflash",
                "--log-without-gnss", "--log-range", "--no-world", "--seed", seed)

    def stitch(self, name, seed, *more):
        flight = self.scratch / f"hop_{seed}"
        out = self.scratch / f"{name}_{seed}"
        run("stitch", flight / "photos", flight / "logs/flight.BIN", "-o", out, "--method", "imu", *more)
        result = Result(flight, out)
        result.print(out.name)
        return result

    def reckon_all(self, name, *more):
        results = []
        for seed in self.SEEDS:
            start = json.loads((self.scratch / f"hop_{seed}/truth/poses.json").read_text())["origin"]
            results.append(self.stitch(name, seed, "--origin", f"{start['lat_deg']},{start['lon_deg']}", *more))
        # The radius is one sigma of both directions together: 1.73 of it hold 95 %.
        photos = [photo for result in results for photo in zip(result.across, result.radius)]
        self.assertGreaterEqual(sum(error <= 1.73 * radius for error, radius in photos), 0.95 * len(photos))
        for result in results:
            self.assertEqual(result.count, 8)
            self.assertTrue(result.report["is_placed"])
            self.assertGreater(result.report["tile_count"], 0)
            self.assertLess(rms(result.height), 0.5)
        return sum(rms(result.across) for result in results) / len(results)

    def test_reckons_from_the_start_marker(self):
        self.assertLess(self.reckon_all("start"), 1.3 * 14.0)

    def test_does_better_when_it_landed_where_it_started(self):
        self.assertLess(self.reckon_all("loop", "--landed-at-start"), 1.3 * 2.1)

    def test_says_that_it_is_not_placed_without_an_origin(self):
        result = self.stitch("unplaced", 1)
        self.assertFalse(result.report["is_placed"])
        self.assertEqual(set(result.radius), {None})
        self.assertTrue(any("--origin" in warning for warning in result.report["warnings"]))
        self.assertGreater(result.report["tile_count"], 0)


PHOTOS = 45


class TablesTest(ScratchCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.flight = cls.scratch / "flight"
        run("simulate", "-o", cls.flight, "--photos", PHOTOS, "--size", "640x480", "--height", 60, "--noise", "no-pose",
            "--log", "csv", "--mount", "gimbal", "--clock-offset-s", 3607.3, "--clock-seconds", "--no-world", "--seed", 9)
        with open(cls.flight / "logs/flight.csv", newline="") as log:
            rows = list(csv.DictReader(line for line in log if not line.startswith("#")))
        cls.fixes = [row for row in rows if row["lat"]]
        cls.truth = json.loads((cls.flight / "truth/poses.json").read_text())["photos"]
        exposures = [row for row in rows if row["event"]]
        assert len(exposures) == PHOTOS, len(exposures)
        cls.exposed_s = [float(row["t"]) for row in exposures]
        cls.names = sorted(path.name for path in (cls.flight / "photos").iterdir())
        cls.tables = cls.scratch / "tables"
        cls.tables.mkdir()
        height = "alt_ell" if "alt_ell" in rows[0] else "alt_msl"
        (cls.tables / "gnss.csv").write_text("time_s,lat_deg,lon_deg,alt_m,hacc_m\n" + "".join(
            f"{float(row['t']) + 4000:.3f},{row['lat']},{row['lon']},{row[height]},1.5\n" for row in cls.fixes))
        (cls.tables / "triggers.csv").write_text("time_s,photo\n" + "".join(
            f"{t + 4000:.3f},{name}\n" for t, name in zip(cls.exposed_s, cls.names)))

    def test_photos_without_gps_become_a_map_by_two_tables(self):
        out = self.scratch / "map"
        run("stitch", self.flight / "photos", self.tables, "-o", out)
        result = Result(self.flight, out)
        result.print("gnss.csv and triggers.csv")
        self.assertEqual(result.count, PHOTOS)
        self.assertTrue(result.report["is_placed"])
        self.assertGreaterEqual(result.report["photos"]["aligned"], PHOTOS - 2)
        # GNSS wanders by 1 m east and north; the same bounds as with the recorder's own log.
        self.assertLess(rms(result.across), 3.0)
        self.assertLess(rms(result.turn), 2.0)
        for name in ("gnss.csv", "triggers.csv"):
            self.assertTrue(any(name in line for line in result.poses["logs"]), result.poses["logs"])
            self.assertFalse(any(name in text for text in result.report["warnings"]), result.report["warnings"])

    def test_says_what_is_wrong_with_tables_that_do_not_fit(self):
        tables = self.scratch / "unfit"
        tables.mkdir()
        shutil.copy(self.tables / "gnss.csv", tables)
        (tables / "triggers.csv").write_text("time_s,photo\n" + "".join(
            f"{t:.3f},{name}\n" for t, name in zip(self.exposed_s, self.names)))
        (tables / "track.csv").write_text("stamp,lat_deg,lon_deg\n1,46.8,7.1\n2,46.8,7.1\n")
        (tables / "notes.txt").write_text("windy\n")
        verdict = json.loads(run("inspect", self.flight / "photos", tables, "--json").stdout)
        text = "\n".join(verdict["warnings"])
        self.assertIn("triggers.csv is not used: its times", text)
        self.assertIn("track.csv is a table, but not used: no column of it is recognised as a time", text)
        self.assertRegex(text, "Not used.*notes.txt")
        self.assertIn("track.csv", verdict["warnings"][0] if verdict["photos_placeable"] == 0 else text)

    def test_says_so_of_an_upload_too(self):
        files = [(name, (self.flight / "photos" / name).read_bytes()) for name in self.names[:6]]
        files += [(name, (self.tables / name).read_bytes()) for name in ("gnss.csv", "triggers.csv")]
        files.append(("track.csv", b"stamp,lat_deg,lon_deg\n1,46.8,7.1\n2,46.8,7.1\n"))
        with Server(tempfile.mkdtemp(dir=self.scratch)) as server:
            flight = server.stitched(files, options='{"method": "imu"}')["flight"]["id"]
            status, verdict = server.json("GET", f"/api/v1/flights/{flight}/verdict")
            self.assertEqual((status, verdict["photos_placeable"]), (200, 6))
            _, report = server.json("GET", f"/api/v1/flights/{flight}/report", code=200)
            for warnings in (verdict["warnings"], report["warnings"]):
                self.assertTrue(any("track.csv is a table, but not used" in text for text in warnings), warnings)

    def test_photos_named_by_their_time_are_tied_to_the_telemetry_log(self):
        start = datetime.datetime(2018, 8, 5, 1, 0, 0, tzinfo=datetime.timezone.utc)
        flight = self.scratch / "named"
        (flight / "photos").mkdir(parents=True)
        shutil.copytree(self.flight / "truth", flight / "truth")
        truth = json.loads((flight / "truth/poses.json").read_text())
        for photo, t in zip(truth["photos"], self.exposed_s):
            at = start + datetime.timedelta(seconds=t)
            name = at.strftime("%Y%m%d%H%M%S") + f"{at.microsecond // 10000:02d}Z.jpg"
            (flight / "photos" / name).write_bytes(
                without_metadata((self.flight / "photos" / photo["name"]).read_bytes()))
            photo["name"] = name
        (flight / "truth/poses.json").write_text(json.dumps(truth))
        (flight / "telemetry.csv").write_text("utc,lat,lon,alt_m\n" + "".join(
            f"{(start + datetime.timedelta(seconds=float(row['t']))).isoformat(timespec='milliseconds')},{row['lat']},{row['lon']},"
            f"{row.get('alt_ell') or row.get('alt_msl')}\n" for row in self.fixes))
        out = self.scratch / "named_map"
        run("stitch", flight / "photos", flight / "telemetry.csv", "-o", out, "--method", "imu")
        result = Result(flight, out)
        result.print("names and telemetry.csv")
        self.assertEqual(result.count, PHOTOS)
        self.assertEqual(result.poses["photos_by_log"], PHOTOS)
        self.assertLess(rms(result.across), 3.0)
        self.assertTrue(any("the one in their names is taken" in text for text in result.report["warnings"]))
