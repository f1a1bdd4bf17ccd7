"""A finished map on one page: its picture to scale, its figures, what was left out; no other file needed."""
import base64
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from flights import made_flights  # noqa: E402
from server_support import BINARY  # noqa: E402


class ReportPage(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.made = pathlib.Path(tempfile.mkdtemp(prefix="skyquilt_made_"))
        shutil.copytree(made_flights.small_flight(), cls.made / "sim")
        (cls.made / "sim/photos/broken.jpg").write_bytes(b"\xff\xd8\xff\xe0 no photo")
        subprocess.run([BINARY, "stitch", cls.made / "sim/photos", "-o", cls.made / "map"], check=True, capture_output=True)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.made)

    def setUp(self):
        self.scratch = pathlib.Path(tempfile.mkdtemp(prefix="skyquilt_page_"))
        for name in ("sim", "map"):
            shutil.copytree(self.made / name, self.scratch / name)

    def tearDown(self):
        shutil.rmtree(self.scratch)

    def report(self, *words):
        return subprocess.run([BINARY, "report", self.scratch / "map", "-o", self.scratch / "report.html", *words], capture_output=True, text=True)

    def test_it_is_whole(self):
        done = self.report()
        self.assertEqual(done.returncode, 0, done.stderr)
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
        self.assertIn("--overwrite", self.report().stderr)
        self.assertEqual(self.report("--overwrite", "--picture-px", "300").returncode, 0)
        self.assertLess((self.scratch / "report.html").stat().st_size, len(page))

    def pdf(self, path=None):
        return subprocess.run([BINARY, "report", self.scratch / "map", "-o", self.scratch / "report.pdf"], capture_output=True, text=True,
                              env={**os.environ, **({} if path is None else {"PATH": path})})

    @unittest.skipUnless(any(shutil.which(name) for name in ("weasyprint", "chromium", "google-chrome", "wkhtmltopdf")), "nothing here prints PDF")
    def test_as_pdf(self):
        done = self.pdf()
        self.assertEqual(done.returncode, 0, done.stderr)
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
        done = self.pdf(str(empty))
        self.assertEqual(done.returncode, 1)
        self.assertIn("apt install weasyprint", done.stderr)
        (empty / "weasyprint").write_text("#!/bin/sh\necho out of paper >&2\nexit 3\n")
        (empty / "weasyprint").chmod(0o755)
        done = self.pdf(str(empty))
        self.assertEqual(done.returncode, 1)
        self.assertIn("weasyprint could not print the report", done.stderr)
        self.assertIn("out of paper", done.stderr)
        self.assertFalse((self.scratch / "report.pdf").exists())

    def test_a_folder_without_a_map(self):
        done = subprocess.run([BINARY, "report", self.scratch / "sim", "-o", self.scratch / "a.html"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 1)
        self.assertIn("stitch", done.stderr)
        self.assertFalse((self.scratch / "a.html").exists())


if __name__ == "__main__":
    unittest.main()
