"""A simulated rig of five bands over hills, each with lens, vignetting, exposure and light of its own: the map's bands are
the ground's reflectance, and those that look alike lie on each other."""
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "tests" / "bench" / "bands"))
try:
    import simulated_rig
except ImportError:
    simulated_rig = None


@unittest.skipIf(simulated_rig is None, "OpenCV, numpy or GDAL for Python is not installed")
class BandRig(unittest.TestCase):
    def test_reflectance_and_places_are_true(self):
        folder = pathlib.Path(tempfile.mkdtemp(prefix="skyquilt_rig_"))
        self.addCleanup(shutil.rmtree, folder)
        simulated_rig.fly(folder, 8, "800x600", 8)
        pairs = simulated_rig.bands_and_truths(folder)
        reflectance = simulated_rig.reflectance_errors(pairs)
        self.assertEqual(list(reflectance), ["blue", "green", "red", "rededge", "nir"])
        for name, (rms, ratio, cells) in reflectance.items():
            self.assertGreater(cells, 5_000, name)
            self.assertAlmostEqual(ratio, 1.0, delta=0.01, msg=name)
            self.assertLess(rms, 0.03, name)
        places = simulated_rig.registration_errors(pairs)
        self.assertEqual(set(places), {"blue", "red", "rededge", "nir"})
        for name, (rms_px, windows) in places.items():
            self.assertGreater(windows, 10, name)
            self.assertLess(rms_px, 0.3, name)
        self.held_against_the_ground(folder)

    def held_against_the_ground(self, folder):
        """A target in the middle says that green is twice as bright as the light sensor has it."""
        from osgeo import gdal, osr
        raster = gdal.Open(str(folder / "map" / "bands.tif"))
        west, step, _, north, _, down = raster.GetGeoTransform()
        column, row = raster.RasterXSize // 2, raster.RasterYSize // 2
        green = float(simulated_rig.numpy.median(raster.GetRasterBand(2).ReadAsArray(column - 8, row - 8, 17, 17)))
        mercator, degrees = osr.SpatialReference(), osr.SpatialReference()
        mercator.ImportFromEPSG(3857)
        degrees.ImportFromEPSG(4326)
        lat, lon, _ = osr.CoordinateTransformation(mercator, degrees).TransformPoint(west + step * column, north + down * row)
        known = folder / "reflectance.csv"
        known.write_text(f"lat,lon,radius_m,green\n{lat},{lon},{6 * step:.3f},{2 * green}\n")
        subprocess.run([simulated_rig.BINARY, "stitch", folder / "sim" / "photos", known, "-o", folder / "held"], check=True,
                       capture_output=True)
        held = gdal.Open(str(folder / "held" / "bands.tif"))
        for band, ratio in ((1, 1.0), (2, 2.0), (3, 1.0)):
            both = [simulated_rig.numpy.nanmedian(of.GetRasterBand(band).ReadAsArray()) for of in (held, raster)]
            self.assertAlmostEqual(both[0] / both[1], ratio, delta=0.05 * ratio - 0.049, msg=band)
        self.assertEqual(held.GetRasterBand(2).GetMetadataItem("CALIBRATION"), "reflectance")
        self.assertIn("by 1 target on the ground", held.GetRasterBand(2).GetMetadataItem("METHOD"))
        self.assertNotIn("target", held.GetRasterBand(1).GetMetadataItem("METHOD"))


if __name__ == "__main__":
    unittest.main()
