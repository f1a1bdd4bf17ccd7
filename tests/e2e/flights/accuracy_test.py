"""One map's accuracy, the same to the digit wherever it is said: command line, report.json, report, list, flight, STAC."""
import html
import json
import pathlib
import re
import shutil
import subprocess
import tempfile

from flights import made_flights
from program import report_of, run
from server_support import ServerTestCase


def said_in(text):
    """What a program says of the absolute accuracy: (number with its unit, what it is by), or None."""
    found = re.search(r"\+-([\d.]+ c?m) \(1 sigma\), by (\d+ [A-Za-z ]+?)(?:[.,<\n]|$)", html.unescape(text))
    return found and found.groups()


def digits(metres):
    """As core/pipeline/report/map_quality.cc and web/src/shared/format.js write it (tests/web/support/accuracy_texts.json)."""
    return f"{metres * 100:.2g} cm" if metres < 1 else f"{metres:.2g} m" if metres < 100 else f"{metres:.0f} m"


class Accuracy(ServerTestCase):
    def scratch_of_test(self):
        folder = tempfile.mkdtemp(prefix="skyquilt_one_truth_")
        self.addCleanup(shutil.rmtree, folder, ignore_errors=True)
        return folder

    def stitched(self, *inputs):
        out = pathlib.Path(self.scratch_of_test(), "map")
        return run("stitch", *inputs, "-o", out).stdout, report_of(out), out

    def reported(self, folder, ending):
        """The report of a map, with a small picture: its words are looked at."""
        report = folder / f"report.{ending}"
        run("report", folder, "-o", report, "--picture-px", "300")
        return report

    def test_every_surface_says_the_same(self):
        flight = made_flights.simulated(12, "800x600", "--noise", "rtk")
        photos = sorted((flight / "photos").iterdir())
        inspected = json.loads(run("inspect", "--json", flight / "photos").stdout)
        said, report, folder = self.stitched(flight / "photos")
        absolute = report["quality"]["absolute"]
        self.assertEqual(absolute["by"], "rtk")
        self.assertEqual(absolute["count"], 12)
        self.assertLess(absolute["sigma_m"], 0.06)
        wanted = (digits(absolute["sigma_m"]), "12 positions of RTK or PPK")
        self.assertEqual(said_in(said), wanted)
        # What the records claim is not the map's accuracy, and has another name; where they agree, the noise of twelve
        # positions adds less than a tenth to it.
        self.assertNotIn("quality", inspected)
        claimed = inspected["by_records"]["absolute"]
        self.assertEqual(claimed["by"], "rtk")
        self.assertAlmostEqual(claimed["sigma_m"], absolute["sigma_m"], delta=0.1 * absolute["sigma_m"])
        self.assertIsNone(inspected["by_records"]["status"])
        # Photos, cameras and report.
        radii = {photo["properties"]["error_radius_m"] for photo in json.loads((folder / "photos.geojson").read_text())["features"]}
        self.assertEqual(radii, {absolute["sigma_m"]})
        page = self.reported(folder, "html").read_text()
        self.assertEqual(said_in(page), wanted)
        self.assertEqual(page.count("1 sigma"), 1)
        self.assertIn("Ready to use.", page)
        if shutil.which("pdftotext") and any(shutil.which(name) for name in ("weasyprint", "chromium", "google-chrome", "wkhtmltopdf")):
            text = subprocess.run(["pdftotext", "-layout", self.reported(folder, "pdf"), "-"], check=True, capture_output=True, text=True).stdout
            number, by = wanted
            self.assertIn(f"+-{number} (1 sigma), by {by}", " ".join(text.split()))  # lines end where the paper does
        # The server, which stitches the same photos itself.
        server = self.serve()
        name = server.stitched([(photo.name, photo.read_bytes()) for photo in photos])["flight"]["id"]
        self.assertEqual(server.json("GET", f"/api/v1/flights/{name}")[1]["quality"], report["quality"])
        listed = server.json("GET", "/api/v1/flights")[1]["flights"]
        self.assertEqual([one["quality"] for one in listed if one["id"] == name], [report["quality"]])
        self.assertEqual(server.json("GET", f"/api/v1/flights/{name}/report")[1]["quality"], report["quality"])
        properties = server.json("GET", f"/stac/{name}")[1]["properties"]
        self.assertEqual((properties["skyquilt:accuracy_m"], properties["skyquilt:accuracy_by"], properties["skyquilt:status"]),
                         (absolute["sigma_m"], "rtk", report["quality"]["status"]))
        relative = report["quality"]["relative"]
        self.assertEqual([properties[f"skyquilt:relative_error_{part}"] for part in ("m", "px", "by")],
                         [relative["error_m"], relative["error_px"], relative["by"]])
        self.assertIn(properties["description"], said, "the command line's words")

    def test_without_positions_there_is_no_number(self):
        flight = made_flights.simulated(12, "800x600", "--relief-m", "2", "--noise", "no-pose")
        said, report, folder = self.stitched(flight / "photos")
        self.assertEqual(report["quality"]["absolute"], {"sigma_m": None, "by": "none", "count": 0})
        self.assertEqual(report["quality"]["status"], "unplaced")
        self.assertIsNone(report["quality"]["relative"]["error_m"])
        self.assertIn("unknown: no positions", said)
        self.assertNotRegex(said, r"\d ha|cm a pixel|1 sigma")
        page = self.reported(folder, "html").read_text()
        self.assertIn("unknown: no positions", page)
        self.assertIn("unknown: the scale is a guess", page)
        self.assertNotRegex(page, r"1 sigma|Estimated error|adjusted ones| ha<")
        radii = [photo["properties"]["error_radius_m"] for photo in json.loads((folder / "photos.geojson").read_text())["features"]]
        self.assertEqual(set(radii), {None})
        self.assertFalse((folder / "geo.txt").exists(), "other engines would believe positions near 0, 0")

    def test_check_points_say_the_number_and_place_nothing(self):
        flight = made_flights.simulated(12, "800x600", "--noise", "xmp")
        truth = json.loads((flight / "truth" / "poses.json").read_text())
        rows = made_flights.gcp_list(truth, [(-20, -20), (20, 20), (-18, 18), (19, -19), (0, 5)])
        checked = pathlib.Path(self.scratch_of_test(), "gcp_list.txt")
        checked.write_text(rows.replace(" p4\n", " p4_check\n"))
        said, report, _ = self.stitched(flight / "photos", checked)
        absolute = report["quality"]["absolute"]
        self.assertEqual((absolute["by"], absolute["count"]), ("check_points", 1))
        self.assertLess(absolute["sigma_m"], 0.3)
        self.assertEqual(said_in(said), (digits(absolute["sigma_m"]), "1 check point"))
        points = {point["name"]: point for point in report["alignment"]["ground_control"]}
        self.assertEqual([points[name]["is_check"] for name in ("p0", "p4_check")], [False, True])
        self.assertGreaterEqual(len(points["p4_check"]["marks"]), 2)
        # Surveyed wrongly it changes the number, and not the map.
        wrong = pathlib.Path(self.scratch_of_test(), "gcp_list.txt")
        lines = [" ".join([row.split()[0], f"{float(row.split()[1]) + 1e-5:.10f}", *row.split()[2:]]) if "check" in row else row
                 for row in checked.read_text().splitlines()]
        wrong.write_text("\n".join(lines) + "\n")
        _, off, _ = self.stitched(flight / "photos", wrong)
        self.assertGreater(off["quality"]["absolute"]["sigma_m"], 0.8)
        self.assertEqual(off["bounds"], report["bounds"])
