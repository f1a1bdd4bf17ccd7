"""Thermal cameras: radiometric JPEGs and TIFFs of kelvins become a map with a band of temperatures, true to those that
the photos were made of."""
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from bands_test import stitch  # noqa: E402
from server_support import BINARY  # noqa: E402

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
class Thermal(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = pathlib.Path(tempfile.mkdtemp(prefix="skyquilt_thermal_"))
        cls.addClassCleanup(shutil.rmtree, cls.scratch)
        subprocess.run([BINARY, "simulate", "-o", cls.scratch / "sim", "--photos", "12", "--size", "640x480"], check=True,
                       capture_output=True)
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


if __name__ == "__main__":
    unittest.main()
