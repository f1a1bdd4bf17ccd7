"""`skyquilt compare`: every method on one simulated flight, figures that agree with the maps, a picture of them."""
import json
import pathlib
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
        self.assertEqual(list(methods), ["imu", "features", "direct", "auto"])
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

    def test_without_truth_and_with_a_method_that_fails(self):
        alone = self.scratch / "alone"
        alone.mkdir()
        first = sorted((self.scratch / "sim" / "photos").iterdir())[0]
        shutil.copy(first, alone)
        _, methods = self.compare(alone, "one")
        self.assertIsNone(methods["auto"]["truth"])
        self.assertEqual(methods["auto"]["placed"], 1)
        self.assertIn("no two photos match", methods["features"]["failure"])


if __name__ == "__main__":
    unittest.main()
