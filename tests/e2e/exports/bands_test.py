"""A flight of a camera with several bands becomes a map for looking and bands.tif; photos in colour alone have none."""
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import jsonschema

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from server_support import BINARY, DATA  # noqa: E402

SCHEMA = json.loads(pathlib.Path(__file__).resolve().parents[3].joinpath("core", "pipeline", "report.schema.json").read_text())
BANDS, COLOUR = DATA / "garfield_msp_5", DATA / "garfield_rgb_8"


def stitch(out, *inputs):
    subprocess.run([BINARY, "stitch", *inputs, "-o", out], check=True, capture_output=True)
    report = json.loads((out / "report.json").read_text())
    jsonschema.validate(report, SCHEMA)
    return report


class Bands(unittest.TestCase):
    def setUp(self):
        self.scratch = pathlib.Path(tempfile.mkdtemp(prefix="skyquilt_bands_"))
        self.addCleanup(shutil.rmtree, self.scratch)

    def look_at(self, report):
        bands = report["bands"]
        self.assertEqual(bands["captures"], {"total": 5, "placed": 5})
        self.assertEqual([band["name"] for band in bands["bands"]], ["green", "red", "rededge", "nir"])
        self.assertEqual([band["wavelength_nm"] for band in bands["bands"]], [550, 660, 735, 790])
        for band in bands["bands"]:
            self.assertEqual((band["calibration"], band["pictures"], band["registered"]), ("relative reflectance", 5, 5))
            self.assertLess(band["residual_px"], 0.5)

    def look_into(self, path):
        try:
            from osgeo import gdal
            import numpy
        except ImportError:
            self.skipTest("GDAL's Python package is not installed")
        raster = gdal.Open(str(path))
        self.assertEqual(raster.GetMetadataItem("LAYOUT", "IMAGE_STRUCTURE"), "COG")
        self.assertEqual([raster.GetRasterBand(i).GetDescription() for i in (1, 2, 3, 4)],
                         ["green", "red", "rededge", "nir"])
        red, nir = raster.GetRasterBand(2).ReadAsArray(), raster.GetRasterBand(4).ReadAsArray()
        self.assertTrue(numpy.isnan(raster.GetRasterBand(1).GetNoDataValue()))
        shown = ~numpy.isnan(red)
        self.assertGreater(shown.sum(), 500_000)
        self.assertGreater((red[shown] > 0).mean(), 0.99)
        ndvi = (nir - red) / (nir + red)
        self.assertGreater(numpy.nanpercentile(ndvi, 95), 0.6)  # lawn
        self.assertLess(numpy.nanpercentile(ndvi, 2), 0.25)  # roads and roofs

    @unittest.skipUnless(BANDS.is_dir(), "the real flight with bands is not here (SKYQUILT_DATA)")
    def test_bands_alone(self):
        report = stitch(self.scratch / "map", BANDS)
        self.look_at(report)
        self.assertEqual(report["photos"]["aligned"], 5)
        self.look_into(self.scratch / "map" / "bands.tif")

    @unittest.skipUnless(BANDS.is_dir() and COLOUR.is_dir(), "the real flight with bands is not here (SKYQUILT_DATA)")
    def test_bands_beside_photos_in_colour(self):
        report = stitch(self.scratch / "map", BANDS, COLOUR)
        self.look_at(report)
        self.assertEqual(report["photos"]["aligned"], 13)
        self.assertLess(report["gsd_m"], 0.6 * report["bands"]["gsd_m"])  # the map is of the colour photos
        self.look_into(self.scratch / "map" / "bands.tif")

    def test_colour_alone_has_no_bands(self):
        subprocess.run([BINARY, "simulate", "-o", self.scratch / "sim", "--photos", "4", "--size", "640x480", "--no-world"],
                       check=True, capture_output=True)
        (self.scratch / "map").mkdir()
        report = stitch(self.scratch / "map", self.scratch / "sim" / "photos")
        self.assertNotIn("bands", report)
        self.assertFalse((self.scratch / "map" / "bands.tif").exists())


if __name__ == "__main__":
    unittest.main()
