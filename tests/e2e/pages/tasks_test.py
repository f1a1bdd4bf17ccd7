"""The lines of docs/tasks are run as they stand, in a folder with a simulated flight, and leave what the page promises."""
import json
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import zipfile

from flights import made_flights
from program import BINARY, report_of, run
from server_support import ServerTestCase

HERE = pathlib.Path(__file__).resolve().parent
TASKS = HERE.parents[2] / "docs" / "tasks"
ADDRESS = "127.0.0.1:8080"
PRINTERS = ("weasyprint", "chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "wkhtmltopdf")


def blocks(page):
    """The shell lines of a page, a text for each block."""
    return re.findall(r"^```sh\n(.*?)^```$", (TASKS / page).read_text(), re.M | re.S)


class TaskPages:
    """The pages, for a test case that has a `folder` to run their lines in, serve() and run_block(text, server)."""
    prints = any(shutil.which(name) for name in PRINTERS)
    has_gdalinfo = shutil.which("gdalinfo") is not None

    def card(self, name="DCIM", flight=None):
        shutil.copytree((flight or made_flights.small_flight()) / "photos", self.folder / name / "100MEDIA")

    def assert_begins(self, **files):
        for name, bytes_ in files.items():
            path = self.folder / name.replace("__", ".")
            self.assertTrue(path.is_file(), f"{path.name} is not there")
            self.assertTrue(path.read_bytes().startswith(bytes_), path.name)

    def test_every_page_is_run(self):
        run = set(re.findall(r'blocks\("([\w-]+\.md)"\)', pathlib.Path(__file__).read_text()))
        self.assertEqual(run, {path.name for path in TASKS.glob("*.md")})
        for page in TASKS.glob("*.md"):
            for target in re.findall(r"\]\(([^)#]+)", page.read_text()):
                if not target.startswith("http"):
                    self.assertTrue((TASKS / target).resolve().exists(), f"{page.name}: {target}")

    def test_from_the_card_to_a_pdf(self):
        if not self.prints:
            self.skipTest("no program that prints a PDF (apt install weasyprint)")
        by_command, by_curl = blocks("card-to-pdf.md")
        self.card()
        self.run_block(by_command)
        self.assert_begins(map__pdf=b"%PDF-", map_utm__tif=b"II", map__kmz=b"PK")
        self.run_block(by_curl, self.serve())
        self.assert_begins(report__pdf=b"%PDF-")

    def test_ndvi_of_a_field(self):
        by_command, zones = blocks("ndvi-of-a-field.md")
        self.card("FIELD", made_flights.simulated(6, "640x480", "--bands"))
        self.run_block(by_command)
        self.assert_begins(ndvi__tif=b"II", coarse__tif=b"II")
        self.run_block(zones, self.serve())
        self.assertEqual(len(json.loads((self.folder / "zones.geojson").read_text())["features"]), 5)
        self.assertTrue(any(name.endswith(".shp") for name in zipfile.ZipFile(self.folder / "zones.zip").namelist()))

    def test_with_control_points(self):
        (lines,) = blocks("control-points.md")
        flight = made_flights.simulated(12, "800x600", "--noise", "xmp")
        self.card(flight=flight)
        rows = made_flights.gcp_list(json.loads((flight / "truth" / "poses.json").read_text()), [(-20, -20), (20, 20), (-18, 18), (19, -19), (0, 5)])
        (self.folder / "DCIM" / "100MEDIA" / "gcp_list.txt").write_text(rows.replace(" p4\n", " p4_check\n"))
        if self.prints:
            self.run_block(lines)
            self.assert_begins(map__pdf=b"%PDF-")
        else:
            self.run_block("\n".join(line for line in lines.splitlines() if ".pdf" not in line))
        report = report_of(self.folder / "map")
        self.assertEqual([point["is_check"] for point in report["alignment"]["ground_control"]].count(True), 1)
        self.assertEqual(report["quality"]["absolute"]["by"], "check_points")

    def test_into_qgis(self):
        if not self.has_gdalinfo:
            self.skipTest("no gdalinfo (apt install gdal-bin)")
        from_server, from_folder = blocks("into-qgis.md")
        self.card()
        server = self.serve()
        self.run_block("skyquilt upload DCIM --name beach", server)
        self.assertIn("EPSG", self.run_block(from_server, server))
        self.assertIn("<qlr", (self.folder / "map.qlr").read_text())
        self.assertEqual(len(json.loads((self.folder / "photos.geojson").read_text())["features"]), 6)
        self.run_block("skyquilt stitch DCIM -o map")
        self.assertIn("UTM zone", self.run_block(from_folder))

    def test_a_server_for_the_team(self):
        tokens, programs, share = blocks("server-for-the-team.md")
        self.card()
        server = self.serve()
        said = self.run_block(tokens, server)
        self.assertRegex(said, r"(?m)^sq_[\w-]+$")
        self.assertRegex(said, r"(?m)^field-team .*upload")
        self.run_block(programs + share, server)
        self.assertEqual(json.loads((self.folder / "flights.json").read_text())["flights"][0]["name"], "beach")
        self.assertIn("sq_share_", (self.folder / "share.json").read_text())


class Tasks(TaskPages, ServerTestCase):
    def setUp(self):
        super().setUp()
        self.folder = pathlib.Path(tempfile.mkdtemp(dir=self.scratch))
        self.programs = pathlib.Path(tempfile.mkdtemp(dir=self.scratch))
        (self.programs / "skyquilt").symlink_to(pathlib.Path(BINARY).resolve())

    def run_block(self, text, server=None):
        """One block in a shell of its own; the page's address is that of the server of this test, its data folder too."""
        if server is not None:
            text = text.replace(ADDRESS, f"127.0.0.1:{server.port}").replace("--data data", f"--data {server.data}")
            text = re.sub(r"\bskyquilt upload ", f"skyquilt upload --server http://127.0.0.1:{server.port} ", text)
        done = subprocess.run(["bash", "-euo", "pipefail", "-c", text], cwd=self.folder, capture_output=True, text=True, timeout=900,
                              env={**os.environ, "PATH": f"{self.programs}:{os.environ['PATH']}"})
        self.assertEqual(done.returncode, 0, f"{text}\n{done.stdout}\n{done.stderr}")
        return done.stdout
