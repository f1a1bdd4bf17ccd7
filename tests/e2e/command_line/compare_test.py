"""`skyquilt compare`: every method on one simulated flight, figures that agree with the maps, a picture of them."""
import json
import pathlib
import re
import shutil
import sqlite3
import struct
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from server_support import BINARY  # noqa: E402


class Compare(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = pathlib.Path(tempfile.mkdtemp(prefix="skyquilt_compare_"))
        subprocess.run([BINARY, "simulate", "-o", cls.scratch / "sim", "--photos", "6", "--size", "640x480", "--noise",
                        "xmp", "--height", "40", "--no-world"], check=True, capture_output=True)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.scratch)

    def compare(self, photos, name):
        out = self.scratch / name
        printed = subprocess.run([BINARY, "compare", photos, "-o", out], check=True, capture_output=True, text=True).stdout
        table = (out / "compare.md").read_text()
        self.assertIn(table, printed)
        methods = {method["method"]: method for method in json.loads((out / "compare.json").read_text())["methods"]}
        self.assertEqual([name for name in methods if name != "reckon"], ["imu", "features", "direct", "auto"])
        for method in methods:
            self.assertIn(f"| {method} |", table)
        header = (out / "compare.png").read_bytes()[:24]
        self.assertEqual(header[:8], b"\x89PNG\r\n\x1a\n")
        self.assertGreater(struct.unpack(">II", header[16:])[0], 900)
        return out, methods

    def test_a_simulated_flight_is_measured_against_its_truth(self):
        out, methods = self.compare(self.scratch / "sim" / "photos", "compared")
        for name, method in methods.items():
            self.assertIsNone(method["failure"])
            self.assertGreater(method["peak_memory_bytes"], 10 << 20)
            report = json.loads((out / name / "report.json").read_text())
            self.assertEqual(method["placed"], report["photos"]["aligned"] + report["photos"]["pose_only"])
            self.assertEqual(method["truth"]["photos"], method["placed"])
            with sqlite3.connect(out / name / "mosaic.mbtiles") as mbtiles:
                self.assertGreater(mbtiles.execute("SELECT count(*) FROM tiles").fetchone()[0], 0)
        relative = {name: method["truth"]["relative_ce90_m"] for name, method in methods.items()}
        self.assertLess(relative["auto"], 0.2 * relative["imu"])
        self.assertEqual(methods["imu"]["aligned"], 0)
        self.assertNotIn("reckon", methods)

    def test_a_log_with_raw_inertial_samples_adds_dead_reckoning(self):
        flight = self.scratch / "logged"
        subprocess.run([BINARY, "simulate", "-o", flight, "--photos", "6", "--size", "640x480", "--height", "40",
                        "--no-world", "--log", "dataflash"], check=True, capture_output=True)
        out, methods = self.compare(flight, "reckoned")
        reckon = methods["reckon"]
        drift_m = [float(drift) for drift in re.findall(r"([0-9.]+) m by", reckon["note"])]
        self.assertEqual(len(drift_m), 2)
        # An accelerometer's bias and the tilt that the gyroscope's adds, twice integrated over a few seconds.
        self.assertLess(max(drift_m), 5.0)
        self.assertGreater(min(drift_m), 0.0)
        self.assertFalse((out / "reckon").exists())
        self.assertIsNone(methods["auto"]["note"])

    def test_without_truth_and_with_a_method_that_fails(self):
        alone = self.scratch / "alone"
        alone.mkdir()
        first = sorted((self.scratch / "sim" / "photos").iterdir())[0]
        shutil.copy(first, alone)
        _, methods = self.compare(alone, "one")
        self.assertIsNone(methods["auto"]["truth"])
        self.assertEqual(methods["auto"]["placed"], 1)
        self.assertIn("No two photos match", methods["features"]["failure"])


if __name__ == "__main__":
    unittest.main()
