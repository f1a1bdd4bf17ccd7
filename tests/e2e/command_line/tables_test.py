"""Photos without GPS and the tables people write beside them, through the real program: a GNSS log with units in its
column names and a table of exposures by photo name; photos named by their time beside a telemetry log; and that no
file given is passed over without a word."""
import csv
import datetime
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

from logged_flight_test import Result, rms, run
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from server_support import BINARY, Server  # noqa: E402

PHOTOS = 45


def without_metadata(jpeg):
    """The same picture without EXIF and XMP."""
    out, at = jpeg[:2], 2
    while jpeg[at:at + 2] != b"\xff\xda":
        end = at + 2 + int.from_bytes(jpeg[at + 2:at + 4], "big")
        if jpeg[at + 1] != 0xE1:
            out += jpeg[at:end]
        at = end
    return out + jpeg[at:]


class TablesTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp())
        cls.flight = cls.folder / "flight"
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
        cls.tables = cls.folder / "tables"
        cls.tables.mkdir()
        height = "alt_ell" if "alt_ell" in rows[0] else "alt_msl"
        (cls.tables / "gnss.csv").write_text("time_s,lat_deg,lon_deg,alt_m,hacc_m\n" + "".join(
            f"{float(row['t']) + 4000:.3f},{row['lat']},{row['lon']},{row[height]},1.5\n" for row in cls.fixes))
        (cls.tables / "triggers.csv").write_text("time_s,photo\n" + "".join(
            f"{t + 4000:.3f},{name}\n" for t, name in zip(cls.exposed_s, cls.names)))

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder)

    def test_photos_without_gps_become_a_map_by_two_tables(self):
        out = self.folder / "map"
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
        tables = self.folder / "unfit"
        tables.mkdir()
        shutil.copy(self.tables / "gnss.csv", tables)
        (tables / "triggers.csv").write_text("time_s,photo\n" + "".join(
            f"{t:.3f},{name}\n" for t, name in zip(self.exposed_s, self.names)))
        (tables / "track.csv").write_text("stamp,lat_deg,lon_deg\n1,46.8,7.1\n2,46.8,7.1\n")
        (tables / "notes.txt").write_text("windy\n")
        verdict = json.loads(run("inspect", self.flight / "photos", tables, "--json"))
        text = "\n".join(verdict["warnings"])
        self.assertIn("triggers.csv is not used: its times", text)
        self.assertIn("track.csv is a table, but not used: no column of it is recognised as a time", text)
        self.assertRegex(text, "Not used.*notes.txt")
        self.assertIn("track.csv", verdict["warnings"][0] if verdict["photos_placeable"] == 0 else text)

    def test_says_so_of_an_upload_too(self):
        files = [(name, (self.flight / "photos" / name).read_bytes()) for name in self.names[:6]]
        files += [(name, (self.tables / name).read_bytes()) for name in ("gnss.csv", "triggers.csv")]
        files.append(("track.csv", b"stamp,lat_deg,lon_deg\n1,46.8,7.1\n2,46.8,7.1\n"))
        server = Server(tempfile.mkdtemp(dir=self.folder))
        try:
            status, made = server.upload(files, options='{"method": "imu"}')
            self.assertEqual(status, 202)
            job = server.wait_for_job(made["job"]["id"])
            self.assertEqual(job["state"], "successful", job)
            flight = made["flight"]["id"]
            status, verdict = server.json("GET", f"/api/v1/flights/{flight}/verdict")
            self.assertEqual((status, verdict["photos_placeable"]), (200, 6))
            status, report = server.json("GET", f"/api/v1/flights/{flight}/report")
            self.assertEqual(status, 200)
            for warnings in (verdict["warnings"], report["warnings"]):
                self.assertTrue(any("track.csv is a table, but not used" in text for text in warnings), warnings)
        finally:
            server.stop()

    def test_photos_named_by_their_time_are_tied_to_the_telemetry_log(self):
        start = datetime.datetime(2018, 8, 5, 1, 0, 0, tzinfo=datetime.timezone.utc)
        flight = self.folder / "named"
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
        out = self.folder / "named_map"
        run("stitch", flight / "photos", flight / "telemetry.csv", "-o", out, "--method", "imu")
        result = Result(flight, out)
        result.print("names and telemetry.csv")
        self.assertEqual(result.count, PHOTOS)
        self.assertEqual(result.poses["photos_by_log"], PHOTOS)
        self.assertLess(rms(result.across), 3.0)
        self.assertTrue(any("the one in their names is taken" in text for text in result.report["warnings"]))


if __name__ == "__main__":
    unittest.main()
