"""The accuracy of real flights, the same to the digit wherever it is said: in report.json, at the command line, in the report and
its PDF, in the API's list and flight, in STAC, in the page's list, head and report. A test a flight; each prints a table of all of
it, and says which surface it could not look at for want of a program."""
import json
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

from accuracy_test import digits
from program import DATA, report_of, run
from server_support import Server

HERE = pathlib.Path(__file__).resolve().parent
PAGE_READER = HERE.parents[1] / "web" / "support" / "flight_texts.js"
STATUSES = {"ready": "Ready to use", "limited": "Usable, with limits", "doubtful": "Place in doubt", "unplaced": "Not georeferenced"}
COPR = DATA / "copr_41"
PDF_TOOLS = ("weasyprint", "chromium", "google-chrome", "wkhtmltopdf")


def of_quality(quality):
    """What JSON says, as (status, absolute, relative in metres, in pixels)."""
    sigma_m, error_m, error_px = quality["absolute"]["sigma_m"], quality["relative"]["error_m"], quality["relative"]["error_px"]
    return (STATUSES[quality["status"]], "unknown" if sigma_m is None else digits(sigma_m), "unknown" if error_m is None else digits(error_m),
            "unknown" if error_px is None else f"{error_px:.2g}" if error_px < 100 else f"{error_px:.0f}")


def of_words(status, absolute, relative):
    """The same of sentences."""
    radius, metres, pixels = (re.search(pattern, text.replace("\u00a0", " ")) for pattern, text in (
        (r"(?:\+-|\u00b1)([\d.]+ c?m)\b", absolute), (r"([\d.]+ c?m) \(", relative), (r"([\d.]+) px", relative)))
    return (status, *("unknown" if found is None else found[1] for found in (radius, metres, pixels)))


def of_report(text):
    """Of the report's text, however its lines are broken."""
    text = " ".join(text.split())
    status = next((words for words in STATUSES.values() if f"{words}." in text), "none")
    return of_words(status, *(re.search(pattern, text)[1] for pattern in (r"Absolute (.*?) Relative ", r"Absolute .*? Relative (.*?)(?: Ground | Each of| To be known|$)")))


def with_checks(folder):
    """The flight's own list, every third of its points one that only checks the map."""
    rows = (COPR / "gcp_list.txt").read_text().splitlines()
    names = sorted({row.split()[6] for row in rows if len(row.split()) > 6})
    checks = set(names[1::3])
    path = pathlib.Path(folder, "gcp_list.txt")
    path.write_text("\n".join(f"{row}_check" if (row.split() + [""] * 7)[6] in checks else row for row in rows) + "\n")
    return path


class RealAccuracy(unittest.TestCase):
    def setUp(self):
        self.scratch = pathlib.Path(tempfile.mkdtemp(prefix="skyquilt_real_accuracy_"))
        self.addCleanup(shutil.rmtree, self.scratch)

    def claimed_by_records(self, inputs):
        """`inspect` has seen no photo beside another: it has no number of the map's, and calls its own what it is."""
        plain, listed = (run("inspect", *words, *inputs).stdout for words in ([], ["--json"]))
        self.assertNotRegex(plain, "[Aa]bsolute accuracy|Ready to use|Usable, with limits")
        listed = json.loads(listed)
        self.assertNotIn("quality", listed)
        sigma_m = listed["by_records"]["absolute"]["sigma_m"]
        said = re.search(r"^Records +(.*)$", plain, re.MULTILINE)
        self.assertEqual(of_words("", said[1] if said else "", "")[1], "unknown" if sigma_m is None else digits(sigma_m))
        if sigma_m is not None:
            self.assertIn("not the map's accuracy", said[1])
        return said[1] if said else "nothing"

    def said_of(self, name, inputs):
        """Every surface's word on it, by its name; '' where it has none. Then what could not be looked at."""
        scratch, missing = self.scratch, []
        out = scratch / "map"
        line = run("stitch", *inputs, "-o", out).stdout
        report = report_of(out)
        said = {"report.json": of_quality(report["quality"])}
        found = re.search(r"^(.*?)\. Absolute accuracy: (.*?)\. Relative: (.*)\.$", line, re.MULTILINE)
        said["command line"] = of_words(*found.groups())
        run("report", out, "-o", scratch / "report.html")
        said["report"] = of_report(re.sub(r"<svg.*?</svg>|<style>.*?</style>|<[^>]*>", " ", (scratch / "report.html").read_text(), flags=re.DOTALL))
        if not shutil.which("pdftotext") or not any(map(shutil.which, PDF_TOOLS)):
            missing.append(f"PDF: wants pdftotext and one of {', '.join(PDF_TOOLS)}")
        else:
            run("report", out, "-o", scratch / "report.pdf")
            text = subprocess.run(["pdftotext", "-layout", scratch / "report.pdf", "-"], check=True, capture_output=True, text=True).stdout
            said["PDF"] = of_report(text)
        # The server makes the map anew, of the same files.
        with Server(scratch / "data") as server:
            url = f"http://127.0.0.1:{server.port}/"
            run("upload", *inputs, "--server", url, "--name", name)
            [listed] = server.json("GET", "/api/v1/flights")[1]["flights"]
            flight = listed["id"]
            said["API, list"] = of_quality(listed["quality"])
            said["API, flight"] = of_quality(server.json("GET", f"/api/v1/flights/{flight}")[1]["quality"])
            said["API, report"] = of_quality(server.json("GET", f"/api/v1/flights/{flight}/report")[1]["quality"])
            properties = server.json("GET", f"/stac/{flight}")[1]["properties"]
            said["STAC"] = of_quality({"status": properties["skyquilt:status"], "absolute": {"sigma_m": properties.get("skyquilt:accuracy_m")},
                                       "relative": {f"error_{unit}": properties.get(f"skyquilt:relative_error_{unit}") for unit in ("m", "px")}})
            said["STAC, words"] = of_words(*re.fullmatch(r"(.*?)\. Absolute accuracy: (.*?)\. Relative: (.*)\.", properties["description"]).groups())
            page = subprocess.run(["node", PAGE_READER, url, flight], capture_output=True, text=True) if shutil.which("node") else None
            if not page or page.returncode == 77:
                missing.append(f"page: {page.stderr.strip() if page else 'wants node'}")
            else:
                self.assertEqual(page.returncode, 0, page.stderr)
                page = json.loads(page.stdout)
                said["page, list"], said["page, head"] = ((*of_words(page[part]["status"], page[part]["facts"], "")[:2], "", "") for part in ("list", "head"))
                said["page, report"] = of_words(*page["report"].values())
        return said, missing

    def check(self, name, *inputs):
        """Every surface says what report.json does, which is returned: (status, absolute, relative in metres, in pixels)."""
        for path in inputs:
            if not path.exists():
                self.skipTest(f"{path} is not here")
        claimed = self.claimed_by_records(inputs)
        said, missing = self.said_of(name, inputs)
        rows = "\n".join(f"  {surface:14}" + "".join(f"{value or '-':22}" for value in values) for surface, values in said.items())
        print(f"\n{name}\n{rows}\n  inspect says of the records: {claimed}", *(f"\n  not looked at: {one}" for one in missing), flush=True)
        wanted = said["report.json"]
        for surface, values in said.items():
            with self.subTest(surface):
                self.assertEqual([value or want for value, want in zip(values, wanted)], list(wanted))
        return wanted

    def test_cameras_lie_where_the_photos_gps_says(self):
        photos = DATA / "brighton_beach" / "images"
        if not photos.is_dir() or shutil.which("exiftool") is None:
            self.skipTest("the Brighton Beach photos or exiftool are not here")
        with tempfile.TemporaryDirectory() as out:
            run("stitch", photos, "-o", out, "--method", "imu")
            report = json.loads(pathlib.Path(out, "report.json").read_text())
            features = json.loads(pathlib.Path(out, "photos.geojson").read_text())["features"]
        self.assertEqual(report["photos"], {"total": 18, "aligned": 0, "pose_only": 18, "left_out": 0})
        exif = json.loads(subprocess.run(["exiftool", "-j", "-n", "-GPSLatitude", "-GPSLongitude", photos], check=True,
                                         capture_output=True).stdout)
        recorded = {pathlib.Path(row["SourceFile"]).name: row for row in exif}
        west, south, east, north = report["bounds"]
        for feature in features:
            row = recorded[feature["properties"]["name"]]
            lat, lon = row["GPSLatitude"], row["GPSLongitude"]
            self.assertTrue(west <= lon <= east and south <= lat <= north)
            self.assertLess(abs(feature["properties"]["camera_lat"] - lat) * 111_000, 0.5)
            self.assertLess(abs(feature["properties"]["camera_lon"] - lon) * 76_000, 0.5)
            # The photos look straight down: the middle of the footprint lies below the camera.
            ring = feature["geometry"]["coordinates"][0][:-1]
            corners = [ring[i * len(ring) // 4] for i in range(4)]
            self.assertLess(abs(sum(c[1] for c in corners) / 4 - lat) * 111_000, 0.5)
            self.assertLess(abs(sum(c[0] for c in corners) / 4 - lon) * 76_000, 0.5)

    def test_brighton(self):
        self.check("brighton", DATA / "brighton_beach" / "images")

    def test_caliterra(self):
        self.check("caliterra_75", DATA / "caliterra_75")

    def test_copr_with_its_list(self):
        self.check("copr_41 with its list", COPR / "images", COPR / "gcp_list.txt")

    def test_copr_without_its_list(self):
        self.assertEqual(self.check("copr_41 without its list", COPR / "images")[:3], ("Not georeferenced", "unknown", "unknown"))

    def test_copr_with_check_points(self):
        if not COPR.exists():
            self.skipTest(f"{COPR} is not here")
        self.check("copr_41 with check points", COPR / "images", with_checks(self.scratch))
        self.assertEqual(report_of(self.scratch / "map")["quality"]["absolute"]["by"], "check_points")

    def test_garfield_in_colours(self):
        self.check("garfield, colours", DATA / "garfield_rgb_8")

    def test_garfield_in_bands(self):
        self.check("garfield, bands", DATA / "garfield_msp_5")
