"""`skyquilt reckon` on simulated and real logs: table, plot and figures."""
import csv
import io
import pathlib
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from server_support import BINARY, DATA  # noqa: E402


def reckon(*arguments):
    return subprocess.run([BINARY, "reckon", *map(str, arguments)], capture_output=True, text=True, timeout=300)


class Reckon(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.flight = pathlib.Path(cls.folder.name, "sim")
        subprocess.run([BINARY, "simulate", "-o", cls.flight, "--photos", "8", "--size", "400x300", "--no-world", "--log", "dataflash"],
                       check=True, capture_output=True)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_the_steps_between_photos_are_those_of_the_flight(self):
        table, plot = self.flight / "steps.csv", self.flight / "steps.svg"
        ran = reckon(self.flight, "--table", table, "--plot", plot)
        self.assertEqual(ran.returncode, 0, ran.stderr)
        rows = list(csv.DictReader(io.StringIO(table.read_text())))
        self.assertGreaterEqual(len(rows), 5)
        for row in rows:
            for rule in ("trapezoid", "simpson"):
                moved = sum(float(row[f"{rule}_{axis}_m"]) ** 2 for axis in "enu") ** 0.5
                recorded = sum(float(row[f"gnss_{axis}_m"]) ** 2 for axis in "enu") ** 0.5
                seconds = float(row["to_s"]) - float(row["from_s"])
                # An accelerometer's bias of 0.1 m/s2 and the tilt that the gyroscope's adds, both twice integrated.
                self.assertLess(abs(moved - recorded), 0.5 + 0.1 * seconds**2, row)
        drawn = xml.etree.ElementTree.parse(plot).getroot()
        circles = drawn.findall(".//{http://www.w3.org/2000/svg}circle")
        self.assertEqual(len(circles), 6 * len(rows))

    def test_photos_without_a_log_are_told_so(self):
        photos = self.flight / "photos"
        ran = reckon(*sorted(photos.iterdir()))
        self.assertEqual(ran.returncode, 1)
        self.assertIn("flight log", ran.stderr)

    @unittest.skipUnless((DATA / "logs" / "dataflash").is_dir(), "the real logs are not here (SKYQUILT_DATA)")
    def test_real_multirotor_logs_drift_as_measured(self):
        for name, drift_10_s_m in (("px4tools_16-07-13_17-52-16.bin", 7.0), ("px4tools_16-07-13_18-04-04.bin", 8.6)):
            ran = reckon(DATA / "logs" / "dataflash" / name)
            self.assertEqual(ran.returncode, 0, ran.stderr)
            line = next(line for line in ran.stdout.splitlines() if line.startswith("Drift after 10 s"))
            self.assertAlmostEqual(float(line.split(":")[1].split()[0]), drift_10_s_m, delta=0.1)


if __name__ == "__main__":
    unittest.main(verbosity=2)
