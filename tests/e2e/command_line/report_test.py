"""report.json keeps to its schema, whatever was stitched, and its counts agree with the map and the footprints."""
import json
import pathlib
import shutil
import sqlite3
import subprocess
import sys
import tempfile
import unittest

import jsonschema

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from server_support import BINARY  # noqa: E402

SCHEMA = json.loads(pathlib.Path(__file__).resolve().parents[3].joinpath("core", "pipeline", "report.schema.json").read_text())


class Report(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = pathlib.Path(tempfile.mkdtemp(prefix="skyquilt_report_"))
        subprocess.run([BINARY, "simulate", "-o", cls.scratch / "sim", "--photos", "5", "--size", "640x480",
                        "--no-world"], check=True, capture_output=True)
        (cls.scratch / "sim" / "photos" / "notes.jpg").write_text("no picture")

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.scratch)

    def stitch(self, *arguments):
        out = self.scratch / ("out" + "".join(arguments))
        subprocess.run([BINARY, "stitch", self.scratch / "sim" / "photos", "-o", out, *arguments],
                       check=True, capture_output=True)
        report = json.loads((out / "report.json").read_text())
        jsonschema.validate(report, SCHEMA)
        photos = report["photos"]
        self.assertEqual(photos["total"], photos["aligned"] + photos["pose_only"] + photos["left_out"])
        self.assertEqual(photos["total"], 6)
        self.assertEqual([photo["name"] for photo in report["left_out_photos"]], ["notes.jpg"])
        footprints = json.loads((out / "photos.geojson").read_text())["features"]
        self.assertEqual(len(footprints), photos["aligned"] + photos["pose_only"])
        with sqlite3.connect(out / "mosaic.mbtiles") as mbtiles:
            self.assertEqual(mbtiles.execute("SELECT count(*) FROM tiles").fetchone()[0], report["tile_count"])
        return report

    def test_the_default_way(self):
        self.assertEqual(self.stitch()["photos"]["aligned"], 5)

    def test_a_size_of_pixels_that_none_can_have_is_refused(self):
        for size, said in (("nan", "no length"), ("5furlong", "no length"), ("0", "gsd_m is"), ("-1", "gsd_m is")):
            refused = subprocess.run([BINARY, "stitch", self.scratch / "sim" / "photos", "-o", self.scratch / "none", f"--gsd={size}"],
                                     capture_output=True, text=True)
            self.assertNotEqual(refused.returncode, 0)
            self.assertIn(said, refused.stderr)
            self.assertFalse((self.scratch / "none" / "mosaic.mbtiles").exists())

    def test_centimetres_said_as_metres_are_asked_about(self):
        self.assertAlmostEqual(self.stitch("--gsd=50cm")["gsd_m"], 0.5)
        refused = subprocess.run([BINARY, "stitch", self.scratch / "sim" / "photos", "-o", self.scratch / "none", "--gsd", "5"],
                                 capture_output=True, text=True)
        self.assertEqual(refused.returncode, 1)
        self.assertRegex(refused.stderr, r"pixels of 5 m, but those of the photos show [0-9.]+ cm of the ground, \d+ times less.*5cm.*--any-gsd")
        self.assertFalse((self.scratch / "none" / "mosaic.mbtiles").exists())
        self.assertAlmostEqual(self.stitch("--gsd=5m", "--any-gsd")["gsd_m"], 5.0)

    def test_it_ends_with_what_to_do_next_as_one_can_type_it(self):
        out = self.scratch / "a map's folder"
        done = subprocess.run([BINARY, "stitch", self.scratch / "sim" / "photos", "-o", out, "--method", "imu"], check=True, capture_output=True,
                              text=True)
        steps = done.stdout.split("What next:\n")[1].splitlines()
        self.assertEqual([step.split()[1] for step in steps], ["report", "export", "import"])
        for step in steps:
            step = step.split(" && ")[0].replace("skyquilt", str(BINARY), 1).replace("--data maps", f"--data '{self.scratch / 'maps'}'")
            subprocess.run(step, shell=True, check=True, capture_output=True)
        self.assertLessEqual({"report.html", "utm.tif"}, {path.name for path in out.iterdir()})
        self.assertTrue((self.scratch / "maps" / "skyquilt-data.json").exists())

    def test_by_poses_alone(self):
        report = self.stitch("--method=imu")
        self.assertEqual((report["photos"]["pose_only"], report["alignment"]), (5, None))


if __name__ == "__main__":
    unittest.main()
