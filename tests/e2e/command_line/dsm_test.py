"""`stitch --formats dsm,dtm`: heights of a flight over houses against the simulated world, honest where nothing is known, the same
bytes for any number of threads."""
import json
import shutil

from program import ScratchCase, checked_report, report_of, run


class Dsm(ScratchCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.flight = cls.scratch / "flight"
        run("simulate", "-o", cls.flight, "--photos", "9", "--size", "800x600", "--height", "50", "--houses", "3", "--trees", "3",
            "--relief-m", "3", "--noise", "rtk", "--seed", "5", "--surface", "--sidelap", "0.75")
        cls.map = cls.scratch / "map"
        cls.said = cls.stitch(cls.map, "--formats", "dsm")

    @classmethod
    def stitch(cls, out, *options):
        return run("stitch", cls.flight / "photos", "-o", out, *options).stdout

    def test_heights_are_those_of_the_world(self):
        gdal, truth_of = self.imported("GDAL's Python package with numpy is not installed", "osgeo.gdal", "heights_against_truth")
        truth = json.loads((self.flight / "truth" / "poses.json").read_text())
        numbers = truth_of.measure_heights(self.map / "dsm.tif", self.flight, truth, truth["gsd_m"])
        self.assertGreater(numbers["answered"], 0.85)
        self.assertLess(abs(numbers["ground"]), 3.0)  # the lens' calibration is 0.12 % off
        self.assertLess(numbers["NMAD"], 1.0)
        self.assertLess(abs(numbers["roofs"] - abs(numbers["ground"])), 1.5)
        info = gdal.Info(str(self.map / "dsm.tif"), format="json")
        self.assertEqual((info["bands"][0]["type"], info["bands"][0]["unit"]), ("Float32", "m"))
        self.assertIn("UTM zone", info["coordinateSystem"]["wkt"])

    def test_validate_looks_at_heights_too(self):
        self.assertIn("dsm.tif: cloud-optimised GeoTIFF\n", run("validate", self.map).stdout)
        damaged = self.scratch / "damaged"
        shutil.copytree(self.map, damaged)
        heights = (damaged / "dsm.tif").read_bytes()
        (damaged / "dsm.tif").write_bytes(heights[:len(heights) // 2])
        self.assertIn("Not sound", run("validate", damaged, code=1).stdout)

    def test_the_ground_below_is_that_of_the_world_and_has_contours(self):
        gdal, ogr, truth_of = self.imported("GDAL's Python package with numpy is not installed", "osgeo.gdal", "osgeo.ogr",
                                            "heights_against_truth")
        out = self.scratch / "with_ground"
        said = self.stitch(out, "--formats", "dtm")
        self.assertEqual((out / "dsm.tif").read_bytes(), (self.map / "dsm.tif").read_bytes())
        truth = json.loads((self.flight / "truth" / "poses.json").read_text())
        numbers = truth_of.measure_heights(out / "dsm.tif", self.flight, truth, truth["gsd_m"])
        self.assertLess(numbers["beside"], 2.0)
        self.assertLess(numbers["below things"] * truth["gsd_m"], 0.25)
        interval_m = report_of(out)["surface"]["contour_interval_m"]
        self.assertIn(f"every {interval_m:g} m", said)
        ground = gdal.Open(str(out / "dtm.tif"))
        left, step, _, top, _, down = ground.GetGeoTransform()
        heights = ground.ReadAsArray()
        lines = ogr.Open(str(out / "contours.gpkg"))
        count = 0
        for line in lines.GetLayer(0):
            height_m = line.GetField("height_m")
            self.assertAlmostEqual(height_m / interval_m, round(height_m / interval_m), 6)
            for x, y, _ in line.GetGeometryRef().GetPoints()[5:-5:9]:
                row, column = int((y - top) / down), int((x - left) / step)
                near = heights[max(0, row - 8):row + 9, max(0, column - 8):column + 9]
                self.assertTrue((near >= height_m - 0.1).any() and (near <= height_m + 0.1).any(), (height_m, x, y))
            count += 1
        self.assertGreater(count, 5)
        self.stitch(out)
        self.assertTrue((out / "dtm_ground.tif").exists(), "what the folder has is written again")

    def test_the_report_says_how_much_was_measured(self):
        report = checked_report(self.map)
        self.assertGreater(report["surface"]["measured_share"], 0.6)
        self.assertAlmostEqual(report["surface"]["cell_m"], 2 * report["gsd_m"], 5)
        self.assertIn("surface", [timing["stage"] for timing in report["timings"]])
        self.assertIn(f"{100 * report['surface']['measured_share']:.0f} % measured", self.said)

    def test_one_thread_and_two_write_the_same(self):
        for threads in ("1", "2"):
            self.stitch(self.scratch / threads, "--formats", "dsm", "--threads", threads)
        for name in ("dsm.tif", "dsm_photos.tif", "dsm_hillshade.tif"):
            self.assertEqual((self.scratch / "1" / name).read_bytes(), (self.scratch / "2" / name).read_bytes())

    def test_without_being_asked_there_is_none_and_the_map_is_the_same(self):
        self.stitch(self.scratch / "plain")
        self.assertFalse((self.scratch / "plain" / "dsm.tif").exists())
        self.assertEqual((self.scratch / "plain" / "mosaic.mbtiles").read_bytes(), (self.map / "mosaic.mbtiles").read_bytes())

    def test_two_photos_alone_say_that_little_was_measured(self):
        two = self.scratch / "two"
        two.mkdir()
        for photo in sorted((self.flight / "photos").glob("*.JPG"))[:2]:
            shutil.copy(photo, two)
        out = self.scratch / "two_map"
        run("stitch", two, "-o", out, "--formats", "dsm")
        report = report_of(out)
        self.assertTrue((out / "dsm.tif").exists())
        self.assertLess(report["surface"]["measured_share"], 0.5)
        self.assertIn("heights_mostly_filled", [remark["code"] for remark in report["remarks"]])

    def test_heights_move_with_the_map(self):
        gdal, = self.imported("GDAL's Python package is not installed", "osgeo.gdal")
        folder = self.scratch / "moved"
        shutil.copytree(self.map, folder)
        corner = lambda: [gdal.Open(str(folder / "dsm.tif")).GetGeoTransform()[i] for i in (0, 3)]
        east, north = corner()
        west, south, _, _ = report_of(folder)["bounds"]
        run("place", folder, "--again", "--point", f"{south},{west}={south + 0.001},{west}")
        moved_east, moved_north = corner()
        self.assertAlmostEqual(moved_north - north, 111.2, delta=1.5)
        self.assertAlmostEqual(moved_east - east, 0.0, delta=3.5)

    def test_a_file_that_cannot_be_written_leaves_map_and_report(self):
        out = self.scratch / "blocked"
        (out / "dsm.tif").mkdir(parents=True)
        self.assertIn("dsm.tif", run("stitch", self.flight / "photos", "-o", out, "--formats", "dsm", "--overwrite", code=1).stderr)
        self.assertEqual((out / "mosaic.mbtiles").read_bytes(), (self.map / "mosaic.mbtiles").read_bytes())
        report = report_of(out)
        self.assertEqual((report["photos"]["total"], "surface" in report), (9, False))

    def test_an_elevation_model_of_that_name_stays(self):
        own = b"somebody's heights"
        empty = self.scratch / "own_alone"
        empty.mkdir()
        (empty / "dsm.tif").write_bytes(own)
        self.assertIn("dsm.tif", run("stitch", self.flight / "photos", "-o", empty, "--formats", "dsm", code=1).stderr)
        self.assertEqual((empty / "dsm.tif").read_bytes(), own)
        beside = self.scratch / "own_beside"
        self.stitch(beside)
        (beside / "dsm.tif").write_bytes(own)
        self.stitch(beside)
        self.assertEqual((beside / "dsm.tif").read_bytes(), own)
