"""`stitch --surface dense`: roofs of simulated houses lie where their walls stand, ground behind them is that of other photos,
and the map is the same for any number of threads, resumed, beside dsm.tif and placed anew."""
import json
import shutil
import sqlite3

from program import ScratchCase, report_of, run
from server_support import Server, photos_in


class Upright(ScratchCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.flight = cls.scratch / "flight"
        run("simulate", "-o", cls.flight, "--photos", "12", "--size", "800x600", "--height", "50", "--houses", "6", "--relief-m", "3",
            "--noise", "rtk", "--seed", "5", "--surface", "--sidelap", "0.75")
        cls.map = cls.scratch / "map"
        cls.stitch(cls.map, "--surface", "dense", "--threads", "1")

    @classmethod
    def stitch(cls, out, *options):
        return run("stitch", cls.flight / "photos", "-o", out, *options).stdout

    @staticmethod
    def tiles(folder):
        return (folder / "mosaic.mbtiles").read_bytes()

    def test_roofs_lie_where_their_walls_stand(self):
        numpy, surface_accuracy = self.imported("GDAL's Python package with numpy is not installed", "numpy", "surface_accuracy")
        self.stitch(self.scratch / "leaning")
        truth = json.loads((self.flight / "truth" / "poses.json").read_text())
        away = {}
        for name in ("leaning", "map"):
            shifts, corners = surface_accuracy.corner_shifts(self.scratch / name / "mosaic.mbtiles", self.flight, truth, truth["gsd_m"])
            self.assertGreater(len(shifts), 0.5 * corners)
            away[name] = numpy.median(numpy.linalg.norm(shifts, axis=1)) / truth["gsd_m"]
        self.assertLess(away["map"], 2.0)
        self.assertGreater(away["leaning"], 2 * away["map"])

    def test_two_threads_make_the_same_also_beside_heights(self):
        out = self.scratch / "two"
        self.stitch(out, "--surface", "dense", "--threads", "2", "--formats", "dsm")
        self.assertEqual(self.tiles(out), self.tiles(self.map))
        report = report_of(out)
        self.assertGreater(report["surface"]["measured_share"], 0.6)
        self.assertEqual([timing["stage"] for timing in report["timings"]].count("surface"), 2, "matched, and written")

    def test_auto_stands_a_village_upright_and_leaves_a_meadow_smooth(self):
        out = self.scratch / "auto"
        self.assertIn("--surface auto: upright; as first placed, ", self.stitch(out, "--surface", "auto"))
        self.assertEqual(self.tiles(out), self.tiles(self.map))
        self.assertEqual(report_of(out)["ground_choice"]["surface"], "dense")
        meadow = self.scratch / "meadow"
        run("simulate", "-o", meadow, "--photos", "8", "--size", "640x480", "--height", "50", "--relief-m", "3", "--noise", "rtk",
            "--seed", "5", "--no-world", "--sidelap", "0.75")
        maps = []
        for surface in ("auto", "smooth"):
            maps.append(self.scratch / f"meadow_{surface}")
            done = run("stitch", meadow / "photos", "-o", maps[-1], "--surface", surface)
            self.assertEqual("--surface auto: the smooth ground" in done.stdout, surface == "auto", done.stdout)
        self.assertEqual(self.tiles(maps[0]), self.tiles(maps[1]))

    def test_the_smooth_map_of_the_folder_is_not_taken_for_it(self):
        out = self.scratch / "changed"
        self.stitch(out)
        smooth = self.tiles(out)
        refused = run("stitch", self.flight / "photos", "-o", out, "--surface", "dense", code=None)
        self.assertNotEqual(refused.returncode, 0)
        self.assertIn("--surface smooth (now dense)", refused.stderr)
        self.assertEqual(self.tiles(out), smooth)
        self.stitch(out, "--surface", "dense", "--overwrite")
        self.assertEqual(self.tiles(out), self.tiles(self.map))
        self.stitch(out, "--overwrite")
        self.assertEqual(self.tiles(out), smooth)

    def test_a_server_makes_the_same(self):
        server = Server(self.scratch / "data")
        self.addCleanup(server.stop)
        photos = photos_in(self.flight / "photos")
        made = server.stitched(photos, name="Village", options=json.dumps({"surface": "dense", "layers": ["height"]}))
        self.assertEqual(made["job"]["options"]["surface"], "dense")
        flight = made["flight"]["id"]
        self.assertGreater(server.json("GET", f"/api/v1/flights/{flight}/report")[1]["surface"]["measured_share"], 0.6)
        copy = self.scratch / "downloaded.mbtiles"
        copy.write_bytes(server.request("GET", f"/api/v1/flights/{flight}/download.mbtiles")[2])
        tiles = lambda path: sqlite3.connect(path).execute("SELECT * FROM tiles ORDER BY 1, 2, 3").fetchall()
        self.assertEqual(tiles(copy), tiles(self.map / "mosaic.mbtiles"))

    def test_photos_that_are_added_leave_it_upright(self):
        photos = sorted((self.flight / "photos").glob("*.JPG"))
        first, rest, out = self.scratch / "first", self.scratch / "rest", self.scratch / "grown"
        for folder, part in ((first, photos[:-1]), (rest, photos[-1:])):
            folder.mkdir()
            for photo in part:
                shutil.copy(photo, folder)
        for folder, words in ((first, ["--surface", "dense"]), (rest, ["--append"])):
            done = run("stitch", folder, "-o", out, *words)
        self.assertIn("12 photos", done.stdout)
        self.assertIn("upright by heights", done.stdout)

    def test_a_map_that_is_placed_stays_upright(self):
        folder = self.scratch / "moved"
        shutil.copytree(self.map, folder)
        west, south, _, _ = report_of(folder)["bounds"]
        run("place", folder, "--again", "--point", f"{south},{west}={south + 0.001},{west}")
        self.assertIn("surface", [timing["stage"] for timing in report_of(folder)["timings"]])
