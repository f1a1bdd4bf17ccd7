"""A killed job goes on where it stopped, a map made again renders nothing anew, and its tiles are the same bytes."""
import contextlib
import json
import pathlib
import shutil
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from server_support import BINARY, PATIENCE_S  # noqa: E402


def tiles_of(out):
    with sqlite3.connect(out / "mosaic.mbtiles") as mbtiles:
        return {row[:3]: row[3] for row in
                mbtiles.execute("SELECT zoom_level, tile_column, tile_row, tile_data FROM tiles")}


class Resume(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = pathlib.Path(tempfile.mkdtemp(prefix="skyquilt_resume_"))
        subprocess.run([BINARY, "simulate", "-o", cls.scratch / "sim", "--photos", "9", "--size", "1600x1200",
                        "--no-world"], check=True, capture_output=True)
        cls.reference = cls.scratch / "reference"
        cls.first = cls.stitch(cls.reference)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.scratch)

    @classmethod
    def command(cls, out, *arguments):
        return [BINARY, "stitch", cls.scratch / "sim" / "photos", "-o", out, "--method", "imu",
                "--threads", "1", *arguments]

    @classmethod
    def stitch(cls, out, *arguments):
        subprocess.run(cls.command(out, *arguments), check=True, capture_output=True)
        return json.loads((out / "report.json").read_text())

    @staticmethod
    def blocks_in(state):
        if not state.exists():
            return 0
        try:
            with contextlib.closing(sqlite3.connect(f"file:{state}?mode=ro", uri=True)) as database:
                return database.execute("SELECT count(*) FROM blocks").fetchone()[0]
        except sqlite3.Error:  # just being made or written
            return 0

    def kill_in_mid_render(self, out):
        """Kills the job once some blocks are remembered, and before it is done."""
        job = subprocess.Popen(self.command(out), stderr=subprocess.DEVNULL)
        state = out / "mosaic.state.tmp"
        deadline = time.monotonic() + PATIENCE_S
        while time.monotonic() < deadline and job.poll() is None:
            if self.blocks_in(state) > 0:
                break
            time.sleep(0.005)
        job.send_signal(signal.SIGKILL)
        job.wait()
        self.assertFalse((out / "mosaic.mbtiles").exists(), "the job was done before it could be killed")

    def test_a_killed_job_renders_only_the_rest(self):
        out = self.scratch / "killed"
        self.kill_in_mid_render(out)
        report = self.stitch(out)
        self.assertGreater(report["blocks"]["kept"], 0)
        self.assertLess(report["blocks"]["kept"], report["blocks"]["total"])
        self.assertEqual(tiles_of(out), tiles_of(self.reference))
        for field in ("bounds", "area_m2", "tile_count", "min_zoom", "max_zoom"):
            self.assertEqual(report[field], self.first[field])
        self.assertEqual([path.name for path in out.iterdir() if ".tmp" in path.name or ".part" in path.name], [])

    def test_a_job_killed_twice_loses_nothing(self):
        out = self.scratch / "killed_twice"
        self.kill_in_mid_render(out)
        self.kill_in_mid_render(out)
        report = self.stitch(out)
        self.assertGreater(report["blocks"]["kept"], 0)
        self.assertEqual(tiles_of(out), tiles_of(self.reference))

    def test_a_left_over_that_is_damaged_is_not_believed(self):
        out = self.scratch / "damaged"
        self.kill_in_mid_render(out)
        (out / "mosaic.mbtiles.tmp").write_bytes(b"no database")
        self.assertEqual(self.stitch(out)["blocks"]["kept"], 0)
        self.assertEqual(tiles_of(out), tiles_of(self.reference))

    def test_made_again_nothing_is_rendered_unless_something_changed(self):
        out = self.scratch / "again"
        shutil.copytree(self.reference, out)
        report = self.stitch(out)
        self.assertEqual(report["blocks"]["kept"], report["blocks"]["total"])
        self.assertEqual(tiles_of(out), tiles_of(self.reference))
        self.assertEqual(self.stitch(out, "--quality", "70", "--overwrite")["blocks"]["kept"], 0)
        # The state of another map is not believed.
        shutil.copy(self.reference / "mosaic.state", out / "mosaic.state")
        with sqlite3.connect(out / "mosaic.mbtiles") as mbtiles:
            mbtiles.execute("DELETE FROM tiles_shallow WHERE zoom_level = "
                            "(SELECT max(zoom_level) FROM tiles_shallow)")
        self.assertEqual(self.stitch(out)["blocks"]["kept"], 0)
        self.assertEqual(tiles_of(out), tiles_of(self.reference))


if __name__ == "__main__":
    unittest.main()
