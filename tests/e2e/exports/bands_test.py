"""Cameras of several bands and thermal ones: the map for looking and bands.tif beside it, true to what the photos were made of."""
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "bench" / "bands"))
from program import DATA, ScratchCase, checked_report, run  # noqa: E402

BANDS, COLOUR = DATA / "garfield_msp_5", DATA / "garfield_rgb_8"


def stitch(out, *inputs):
    run("stitch", *inputs, "-o", out)
    return checked_report(out)


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
        run("simulate", "-o", self.scratch / "sim", "--photos", "4", "--size", "640x480", "--no-world")
        (self.scratch / "map").mkdir()
        self.assertNotIn("bands", stitch(self.scratch / "map", self.scratch / "sim" / "photos"))
        self.assertFalse((self.scratch / "map" / "bands.tif").exists())


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
        run("stitch", folder / "sim" / "photos", known, "-o", folder / "held")
        held = gdal.Open(str(folder / "held" / "bands.tif"))
        for band, ratio in ((1, 1.0), (2, 2.0), (3, 1.0)):
            both = [simulated_rig.numpy.nanmedian(of.GetRasterBand(band).ReadAsArray()) for of in (held, raster)]
            self.assertAlmostEqual(both[0] / both[1], ratio, delta=0.05 * ratio - 0.049, msg=band)
        self.assertEqual(held.GetRasterBand(2).GetMetadataItem("CALIBRATION"), "reflectance")
        self.assertIn("by 1 target on the ground", held.GetRasterBand(2).GetMetadataItem("METHOD"))
        self.assertNotIn("target", held.GetRasterBand(1).GetMetadataItem("METHOD"))


try:
    import cv2
    import numpy
    from osgeo import gdal
except ImportError:
    cv2 = None

R1, R2, B, F, O = 17096.453, 0.046642166, 1428.0, 1.0, -342
EMISSIVITY, REFLECTED_K = 0.95, 268.15
GAIN = 0.04


def kelvin_of(picture_rgb):
    """The temperature of a place is known by its green: 10 to 50 degrees Celsius."""
    return 283.15 + 40.0 * picture_rgb[..., 1].astype(float) / 255.0


def levels_of(kelvin):
    light = lambda k: R1 / (R2 * (numpy.exp(B / k) - F))  # noqa: E731
    return numpy.rint(EMISSIVITY * light(kelvin) + (1 - EMISSIVITY) * light(REFLECTED_K) - O).astype("<u2")


def record_of(levels):
    """As FLIR's cameras write it: no air between, no window."""
    height, width = levels.shape
    picture = struct.pack("<HHH", 2, width, height).ljust(0x20, b"\0") + levels.tobytes()
    camera = bytearray(0x400)
    struct.pack_into(">H", camera, 0, 2)
    for at, value in {0x20: EMISSIVITY, 0x28: REFLECTED_K, 0x2C: 293.15, 0x30: 293.15, 0x34: 1.0, 0x3C: 0.5, 0x58: R1,
                      0x5C: B, 0x60: F, 0x30C: R2}.items():
        struct.pack_into(">f", camera, at, value)
    struct.pack_into(">i", camera, 0x308, O)
    begin = 0x80
    head = b"FFF\0" + bytes(16) + struct.pack(">III", 101, 0x40, 2)
    entries = b"".join(struct.pack(">HHIIII", kind, 1, 100, 1, at, size).ljust(0x20, b"\0") for kind, at, size in
                       [(1, begin, len(picture)), (0x20, begin + len(picture), len(camera))])
    return head.ljust(0x40, b"\0") + entries + picture + bytes(camera)


def with_record(jpeg, record):
    parts = [record[at:at + 65000] for at in range(0, len(record), 65000)]
    segments = b"".join(struct.pack(">BBH", 0xFF, 0xE1, len(part) + 10) + b"FLIR\0\1" + bytes([i, len(parts) - 1]) + part
                        for i, part in enumerate(parts))
    return jpeg[:2] + segments + jpeg[2:]


@unittest.skipIf(cv2 is None, "OpenCV, numpy or GDAL for Python is not installed")
class Thermal(ScratchCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        run("simulate", "-o", cls.scratch / "sim", "--photos", "12", "--size", "640x480")
        cls.photos = sorted((cls.scratch / "sim" / "photos").iterdir())

    def seen(self, photo):
        return cv2.cvtColor(cv2.imread(str(photo)), cv2.COLOR_BGR2RGB)

    def hold_against_truth(self, out):
        raster = gdal.Open(str(out / "bands.tif"))
        self.assertEqual(raster.RasterCount, 1)
        band = raster.GetRasterBand(1)
        self.assertEqual((band.GetDescription(), band.GetMetadataItem("CALIBRATION")), ("lwir", "kelvin"))
        west, step, _, north, _, down = raster.GetGeoTransform()
        box = (west, north + down * raster.RasterYSize, west + step * raster.RasterXSize, north)
        truth = gdal.Warp("", str(self.scratch / "sim" / "truth" / "world.tif"), format="MEM", dstSRS="EPSG:3857",
                          outputBounds=box, width=raster.RasterXSize, height=raster.RasterYSize, resampleAlg="average")
        miss = band.ReadAsArray() - kelvin_of(numpy.moveaxis(truth.ReadAsArray()[:3], 0, -1))
        known = miss[~numpy.isnan(miss)]
        self.assertGreater(known.size, 100_000)
        self.assertLess(abs(numpy.median(known)), 0.1)
        self.assertLess(numpy.percentile(abs(known), 90), 2.0)  # edges are a little beside those of the truth

    def test_radiometric_jpegs(self):
        folder = self.scratch / "jpegs"
        folder.mkdir()
        for photo in self.photos:
            levels = levels_of(kelvin_of(self.seen(photo)))
            folder.joinpath(photo.name).write_bytes(with_record(photo.read_bytes(), record_of(levels)))
        report = stitch(self.scratch / "map_of_jpegs", folder)
        self.assertEqual(report["bands"]["captures"], {"total": 12, "placed": 12})
        self.assertEqual([band["calibration"] for band in report["bands"]["bands"]], ["kelvin"])
        self.hold_against_truth(self.scratch / "map_of_jpegs")

    @unittest.skipUnless(shutil.which("exiftool"), "exiftool is not installed")
    def test_tiffs_of_kelvins(self):
        folder = self.scratch / "tiffs"
        folder.mkdir()
        for photo in self.photos:
            tiff = folder / (photo.stem + ".tif")
            cv2.imwrite(str(tiff), numpy.rint(kelvin_of(self.seen(photo)) / GAIN).astype(numpy.uint16))
            xmp = subprocess.run(["exiftool", "-b", "-xmp", photo], check=True, capture_output=True).stdout.decode()
            words = ('<rdf:Description xmlns:Camera="http://pix4d.com/camera/1.0/" Camera:BandName="LWIR" '
                     f'xmlns:FLIR="http://ns.flir.com/FLIR/1.0/" FLIR:TLinearGain="{GAIN}"')
            self.assertIn("<rdf:Description", xmp)
            (self.scratch / "words.xmp").write_text(xmp.replace("<rdf:Description", words, 1))
            subprocess.run(["exiftool", "-q", "-overwrite_original", "-tagsFromFile", photo, "-exif:all", "-gps:all",
                            f"-xmp<={self.scratch / 'words.xmp'}", tiff], check=True, capture_output=True)
        report = stitch(self.scratch / "map_of_tiffs", folder)
        self.assertEqual(report["photos"]["aligned"], 12)  # by a hundredth of the levels that 16 bits have
        self.hold_against_truth(self.scratch / "map_of_tiffs")
