"""report.json keeps to its schema, whatever was stitched, and its counts agree with the map; and the report on one page, as HTML and as PDF."""
import base64
import datetime
import json
import os
import pathlib
import re
import shutil
import signal
import sqlite3
import subprocess
import tempfile
import time
import unittest

from flights import made_flights
from program import BINARY, ScratchCase, checked_report, run


class Report(ScratchCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        run("simulate", "-o", cls.scratch / "sim", "--photos", "5", "--size", "640x480", "--no-world")
        (cls.scratch / "sim" / "photos" / "notes.jpg").write_text("no picture")

    def stitch(self, *arguments):
        out = self.scratch / ("out" + "".join(arguments))
        run("stitch", self.scratch / "sim" / "photos", "-o", out, *arguments)
        report = checked_report(out)
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
            refused = run("stitch", self.scratch / "sim" / "photos", "-o", self.scratch / "none", f"--gsd={size}", code=None)
            self.assertNotEqual(refused.returncode, 0)
            self.assertIn(said, refused.stderr)
            self.assertFalse((self.scratch / "none" / "mosaic.mbtiles").exists())

    def test_centimetres_said_as_metres_are_asked_about(self):
        self.assertAlmostEqual(self.stitch("--gsd=50cm")["gsd_m"], 0.5)
        refused = run("stitch", self.scratch / "sim" / "photos", "-o", self.scratch / "none", "--gsd", "5", code=1)
        self.assertRegex(refused.stderr, r"pixels of 5 m, but those of the photos show [0-9.]+ cm of the ground, \d+ times less.*5cm.*--any-gsd")
        self.assertFalse((self.scratch / "none" / "mosaic.mbtiles").exists())
        self.assertAlmostEqual(self.stitch("--gsd=5m", "--any-gsd")["gsd_m"], 5.0)

    def test_it_ends_with_what_to_do_next_as_one_can_type_it(self):
        out = self.scratch / "a map's folder"
        done = run("stitch", self.scratch / "sim" / "photos", "-o", out, "--method", "imu")
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

    def test_inspect_says_alike_when_photos_were_taken(self):
        captured = self.stitch("--method=imu")["captured"]
        inspected = json.loads(run("inspect", self.scratch / "sim" / "photos", "--json").stdout)
        self.assertRegex(captured["first"], r"(Z|[+-]\d\d:\d\d)$")
        self.assertEqual((inspected["first_capture"], inspected["last_capture"]), (captured["first"], captured["last"]))


class ReportPage(ScratchCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.made = cls.scratch
        shutil.copytree(made_flights.small_flight(), cls.made / "sim")
        (cls.made / "sim/photos/broken.jpg").write_bytes(b"\xff\xd8\xff\xe0 no photo")
        run("stitch", cls.made / "sim/photos", "-o", cls.made / "map")

    def setUp(self):
        self.scratch = pathlib.Path(tempfile.mkdtemp(prefix="page_", dir=self.made))
        for name in ("sim", "map"):
            shutil.copytree(self.made / name, self.scratch / name)

    def report(self, *words, code=0):
        return run("report", self.scratch / "map", "-o", self.scratch / "report.html", *words, code=code)

    def test_it_is_whole(self):
        self.report()
        page = (self.scratch / "report.html").read_text()
        report = json.loads((self.scratch / "map/report.json").read_text())
        self.assertTrue(page.startswith("<!doctype html>"))
        self.assertNotRegex(page.replace("http://www.w3.org/2000/svg", ""), r"https?://|<script|<link")
        picture = base64.b64decode(re.search(r"data:image/webp;base64,([A-Za-z0-9+/=]+)", page).group(1))
        self.assertEqual((picture[:4], picture[8:12]), (b"RIFF", b"WEBP"))
        self.assertIn("broken.jpg", page)
        self.assertIn(f"{report['photos']['total']}: {report['photos']['aligned']} placed", page)
        self.assertRegex(page, r">\d+ (k?m|cm)</text>")
        self.assertEqual(sorted(path.name for path in self.scratch.iterdir()), ["map", "report.html", "sim"])
        # Once more only by the word.
        self.assertIn("--overwrite", self.report(code=None).stderr)
        self.report("--overwrite", "--picture-px", "300")
        self.assertLess((self.scratch / "report.html").stat().st_size, len(page))

    def test_it_is_dated_by_the_clock_on_the_wall(self):
        for zone, ahead_h in (("EAST-14", 14), ("WEST12", -12)):  # on no day of the other
            def today():
                return f"{datetime.datetime.now(datetime.timezone.utc) + datetime.timedelta(hours=ahead_h):%Y-%m-%d}"
            began = today()
            run("report", self.scratch / "map", "-o", self.scratch / "report.html", "--overwrite", env={**os.environ, "TZ": zone})
            dated = re.search(r"Report of (\S+),", (self.scratch / "report.html").read_text()).group(1)
            self.assertIn(dated, (began, today()))

    def pdf(self, path=None, code=0):
        return run("report", self.scratch / "map", "-o", self.scratch / "report.pdf", code=code, env={**os.environ, **({} if path is None else {"PATH": path})})

    @unittest.skipUnless(any(shutil.which(name) for name in ("weasyprint", "chromium", "google-chrome", "wkhtmltopdf")), "nothing here prints PDF")
    def test_as_pdf(self):
        self.pdf()
        printed = (self.scratch / "report.pdf").read_bytes()
        self.assertTrue(printed.startswith(b"%PDF-"))
        self.assertGreater(len(printed), 20_000, "the picture is in it")
        self.assertEqual(sorted(path.name for path in self.scratch.iterdir()), ["map", "report.pdf", "sim"])
        if shutil.which("pdftotext"):
            text = subprocess.run(["pdftotext", self.scratch / "report.pdf", "-"], check=True, capture_output=True, text=True).stdout
            self.assertIn("broken.jpg", text)

    def test_pdf_without_a_program_that_prints(self):
        empty = self.scratch / "bin"
        empty.mkdir()
        self.assertIn("apt install weasyprint", self.pdf(str(empty), code=1).stderr)
        (empty / "weasyprint").write_text("#!/bin/sh\necho out of paper >&2\nexit 3\n")
        (empty / "weasyprint").chmod(0o755)
        done = self.pdf(str(empty), code=1)
        self.assertIn("weasyprint could not print the report", done.stderr)
        self.assertIn("out of paper", done.stderr)
        self.assertFalse((self.scratch / "report.pdf").exists())

    def test_ctrl_c_ends_the_printing_and_leaves_nothing(self):
        programs, begun = self.scratch / "bin", self.scratch / "begun"
        programs.mkdir()
        (programs / "weasyprint").write_text(f"#!/bin/sh\n: > '{begun}'\nexec /bin/sleep 60\n")
        (programs / "weasyprint").chmod(0o755)
        job = subprocess.Popen([BINARY, "report", self.scratch / "map", "-o", self.scratch / "report.pdf"],
                               env={**os.environ, "PATH": str(programs)}, stderr=subprocess.DEVNULL)
        while not begun.exists():
            self.assertIsNone(job.poll())
            time.sleep(0.05)
        job.send_signal(signal.SIGINT)
        self.assertEqual(job.wait(), 130)
        self.assertEqual(sorted(path.name for path in self.scratch.iterdir()), ["begun", "bin", "map", "sim"])

    def test_a_folder_without_a_map(self):
        self.assertIn("stitch", run("report", self.scratch / "sim", "-o", self.scratch / "a.html", code=1).stderr)
        self.assertFalse((self.scratch / "a.html").exists())
