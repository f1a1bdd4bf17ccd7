"""A simulated rig of five bands over hills, each with lens, vignetting, exposure and light of its own: the map's bands are
the ground's reflectance, and those that look alike lie on each other."""
import pathlib
import shutil
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


if __name__ == "__main__":
    unittest.main()
