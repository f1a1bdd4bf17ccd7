"""What the tests of GIS programs share: a map, made anew, and the pixels that programs must find in it."""
import json
import math
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

from server_support import Server, ServerTestCase, make_map, put_map

WORLD_M = 20037508.342789244
GDAL_XYZ = """<GDAL_WMS><Service name="TMS"><ServerUrl>{url}</ServerUrl></Service>
<DataWindow><UpperLeftX>-{w}</UpperLeftX><UpperLeftY>{w}</UpperLeftY><LowerRightX>{w}</LowerRightX>
<LowerRightY>-{w}</LowerRightY><TileLevel>{zoom}</TileLevel><TileCountX>1</TileCountX><TileCountY>1</TileCountY>
<YOrigin>top</YOrigin></DataWindow><Projection>EPSG:3857</Projection><BlockSizeX>{size}</BlockSizeX>
<BlockSizeY>{size}</BlockSizeY><BandsCount>4</BandsCount></GDAL_WMS>"""
QGIS_SCRIPT = r"""
import sys
from qgis.core import (QgsApplication, QgsCoordinateReferenceSystem, QgsMapRendererCustomPainterJob, QgsMapSettings,
                       QgsRasterLayer, QgsRectangle)
from qgis.PyQt.QtCore import QSize
from qgis.PyQt.QtGui import QColor, QImage, QPainter
west, south, east, north, side, out, *sources = sys.argv[1:]
application = QgsApplication([], False)
application.initQgis()
for number, source in enumerate(sources):
    layer = QgsRasterLayer(source, "map", "wms")
    assert layer.isValid(), layer.error().message()
    settings = QgsMapSettings()
    settings.setLayers([layer])
    settings.setDestinationCrs(QgsCoordinateReferenceSystem("EPSG:3857"))
    settings.setExtent(QgsRectangle(float(west), float(south), float(east), float(north)))
    settings.setOutputSize(QSize(int(side), int(side)))
    settings.setOutputDpi(96)
    image = QImage(int(side), int(side), QImage.Format_RGB32)
    image.fill(QColor(255, 255, 255))
    painter = QPainter(image)
    job = QgsMapRendererCustomPainterJob(settings, painter)
    job.renderSynchronously()
    painter.end()
    assert not job.errors(), [error.message for error in job.errors()]
    image.save(f"{out}/{number}.png")
"""

# What "Open" and "Zoom to Layer" do: the layer's extent is printed, and drawn only where it lies within the box given.
QGIS_ZOOM_SCRIPT = r"""
import json
import sys
from qgis.core import QgsApplication, QgsCoordinateReferenceSystem, QgsLayerDefinition, QgsMapRendererParallelJob, QgsMapSettings, QgsProject, QgsRectangle
from qgis.PyQt.QtCore import QSize
definition, out, side, *box = sys.argv[1:]
application = QgsApplication([], False)
application.initQgis()
is_loaded, error = QgsLayerDefinition.loadLayerDefinition(definition, QgsProject.instance(), QgsProject.instance().layerTreeRoot())
assert is_loaded, error
[layer] = QgsProject.instance().mapLayers().values()
assert layer.isValid(), layer.error().message()
settings = QgsMapSettings()
settings.setLayers([layer])
settings.setDestinationCrs(QgsCoordinateReferenceSystem("EPSG:3857"))
settings.setOutputSize(QSize(int(side), int(side)))
settings.setOutputDpi(96)
extent = settings.layerExtentToOutputExtent(layer, layer.extent())
print(json.dumps([extent.xMinimum(), extent.yMinimum(), extent.xMaximum(), extent.yMaximum()]))
extent.scale(1.05)
if QgsRectangle(*map(float, box)).contains(extent):
    settings.setExtent(extent)
    job = QgsMapRendererParallelJob(settings)
    job.start()
    job.waitForFinished()
    assert not job.errors(), [error.message for error in job.errors()]
    job.renderedImage().save(out)
    extent = settings.visibleExtent()
    print(json.dumps([extent.xMinimum(), extent.yMinimum(), extent.xMaximum(), extent.yMaximum()]))
"""


def has_qgis():
    return subprocess.run([sys.executable, "-c", "import qgis.core"], capture_output=True).returncode == 0


def has_gdal():
    return subprocess.run([sys.executable, "-c", "from osgeo import gdal"], capture_output=True).returncode == 0


class GdalTestCase(ServerTestCase):
    """One map that GDAL reads; one of its own where it has options."""
    photo_count, options = 6, {}

    @classmethod
    def setUpClass(cls):
        if not has_gdal():
            raise unittest.SkipTest("python3-gdal is not here")
        from osgeo import gdal
        gdal.UseExceptions()
        cls.gdal = gdal
        super().setUpClass()
        gdal.SetConfigOption("GDAL_DEFAULT_WMS_CACHE_PATH", cls.scratch)
        data = tempfile.mkdtemp(dir=cls.scratch)
        cls.flight_id = make_map(data, cls.photos[:cls.photo_count], options=json.dumps(cls.options)) if cls.options else put_map(data)
        cls.server = Server(data)
        _, cls.tilejson = cls.server.json("GET", f"/tiles/{cls.flight_id}.json")

    @classmethod
    def tearDownClass(cls):
        cls.server.stop()
        super().tearDownClass()

    def address(self, path):
        return f"http://127.0.0.1:{self.server.port}{path}"


class MapFileTestCase(GdalTestCase):
    """The same with the map's files beside it, which other programs' pixels are compared with."""
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        for kind in ("mbtiles", "tif"):
            cls.path(kind).write_bytes(cls.server.request("GET", f"/api/v1/flights/{cls.flight_id}/download.{kind}")[2])

    @classmethod
    def path(cls, kind):
        return pathlib.Path(cls.scratch, f"download.{kind}")

    def inner_window(self, side_tiles=2):
        """Tiles in the middle of the map, all photo: (x, y, west, north, metres a pixel, side in pixels)."""
        zoom, size = self.tilejson["maxzoom"], self.tilejson.get("tileSize", 256)
        mbtiles = self.gdal.Open(str(self.path("mbtiles")))
        transform = mbtiles.GetGeoTransform()
        middle_x = transform[0] + transform[1] * mbtiles.RasterXSize / 2
        middle_y = transform[3] + transform[5] * mbtiles.RasterYSize / 2
        tile_m = 2 * WORLD_M / 2**zoom
        column, row = int((middle_x + WORLD_M) / tile_m) - 1, int((WORLD_M - middle_y) / tile_m) - 1
        return column, row, column * tile_m - WORLD_M, WORLD_M - row * tile_m, tile_m / size, side_tiles * size

    def pixels(self, dataset, west, north, pixel_m, side):
        transform = dataset.GetGeoTransform()
        left = round((west - transform[0]) / pixel_m)
        top = round((transform[3] - north) / pixel_m)
        return dataset.ReadAsArray(left, top, side, side)[:3]

    def check_against_mbtiles(self, dataset, bands=3):
        """Some program's dataset of the finest zoom has the MBTiles' own pixels."""
        _, _, west, north, pixel_m, side = self.inner_window()
        want = self.pixels(self.gdal.Open(str(self.path("mbtiles"))), west, north, pixel_m, side)
        self.assertAlmostEqual(dataset.GetGeoTransform()[1], pixel_m, delta=pixel_m * 1e-6)
        got = self.pixels(dataset, west, north, pixel_m, side)
        self.assertEqual(int(abs(got.astype(int) - want).max()), 0)

    def whole_window(self):
        mbtiles = self.gdal.Open(str(self.path("mbtiles")))
        west, pixel_m, _, north, _, _ = mbtiles.GetGeoTransform()
        return (west, north - mbtiles.RasterYSize * pixel_m, west + mbtiles.RasterXSize * pixel_m, north,
                mbtiles.RasterXSize, mbtiles.RasterYSize)

    def in_qgis(self, script, *words):
        """What a script printed in a QGIS without a window, whose settings and cache are this test's alone. QGIS' own end, where it
        crashes now and then, is not what is looked at."""
        ended = "\nimport os, sys\nsys.stdout.flush()\nos._exit(0)\n"
        done = subprocess.run([sys.executable, "-c", script + ended, *words], capture_output=True, text=True, timeout=300,
                              env={**os.environ, "QT_QPA_PLATFORM": "offscreen", "QGIS_CUSTOM_CONFIG_PATH": self.scratch, "XDG_CACHE_HOME": self.scratch})
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def check_qgis(self, sources, most_off=0.0, window=None, want=None):
        """QGIS draws each source with the MBTiles' own pixels, or in the mean so near to them (levels of 255). The window is
        (west, north, metres a pixel, side in pixels) with the pixels wanted there; without it, it is the inner one."""
        if not has_qgis():
            self.skipTest("python3-qgis is not here")
        west, north, pixel_m, side = window or self.inner_window()[2:]
        if want is None:
            want = self.pixels(self.gdal.Open(str(self.path("mbtiles"))), west, north, pixel_m, side)
        self.in_qgis(QGIS_SCRIPT, repr(west), repr(north - side * pixel_m), repr(west + side * pixel_m), repr(north), str(side), self.data, *sources)
        for number, source in enumerate(sources):
            got = self.gdal.Open(f"{self.data}/{number}.png").ReadAsArray()[:3]
            off = abs(got.astype(int) - want)
            self.assertLessEqual(off.max() if most_off == 0.0 else off.mean(), most_off, source)

    def check_qgis_zooms_to(self, definition):
        """QGIS opens a layer definition (bytes), zooms to it and shows the map: whole, in its colours, where it lies. Its picture is
        kept in the folder SKYQUILT_PICTURES names."""
        if not has_qgis():
            self.skipTest("python3-qgis is not here")
        file, picture, side = pathlib.Path(self.data, "zoom.qlr"), pathlib.Path(self.data, "zoom.png"), 600
        file.write_bytes(definition)
        west, south, east, north = self.bounds_m()
        width_m, height_m = east - west, north - south
        said = self.in_qgis(QGIS_ZOOM_SCRIPT, file, picture, str(side), repr(west - width_m), repr(south - height_m), repr(east + width_m),
                            repr(north + height_m))
        extent, *drawn = [json.loads(line) for line in said.splitlines() if line.startswith("[")]
        for got, want in zip(extent, (west, south, east, north)):
            self.assertAlmostEqual(got, want, delta=0.01 * max(width_m, height_m))
        west, south, east, north = drawn[0]
        want = self.gdal.Translate("", self.gdal.Open(str(self.path("mbtiles"))), format="MEM", projWin=[west, north, east, south],
                                   width=side, height=side, resampleAlg="average").ReadAsArray().astype(int)
        got = self.gdal.Open(str(picture)).ReadAsArray()[:3].astype(int)
        if os.environ.get("SKYQUILT_PICTURES"):
            kept = pathlib.Path(os.environ["SKYQUILT_PICTURES"])
            kept.mkdir(parents=True, exist_ok=True)
            shutil.copy(picture, kept / "qgis-zoomed-to-layer.png")
        seen = want[3] == 255
        self.assertGreater(seen.mean(), 0.3)
        self.assertGreater(got[:, seen].std(), 3.0)  # a picture, not a blank
        self.assertLess(abs(got[:, seen].mean(axis=1) - want[:3, seen].mean(axis=1)).max(), 3.0)
        self.assertLess(abs(got - want[:3])[:, seen].mean(), 10.0)
        self.assertLess((got[:, want[3] == 0] < 255).mean(), 0.02)  # nothing is drawn beside the map
        # The same things at the same places: shifted by three pixels of six hundred, they are less alike.
        inner = seen[3:-3, 3:-3]
        alike = {shift: self.correlation(got[1, 3 + shift[1]:side - 3 + shift[1], 3 + shift[0]:side - 3 + shift[0]][inner], want[1, 3:-3, 3:-3][inner])
                 for shift in ((0, 0), (3, 0), (-3, 0), (0, 3), (0, -3))}
        self.assertGreater(alike[0, 0], 0.9, alike)
        self.assertEqual(max(alike, key=alike.get), (0, 0), alike)

    @staticmethod
    def correlation(a, b):
        a, b = a - a.mean(), b - b.mean()
        return float((a * b).sum() / math.sqrt((a * a).sum() * (b * b).sum()))

    def bounds_m(self):
        """The map's, in Web Mercator: west, south, east, north."""
        x = lambda lon: lon / 180 * WORLD_M  # noqa: E731
        y = lambda lat: math.asinh(math.tan(math.radians(lat))) / math.pi * WORLD_M  # noqa: E731
        west, south, east, north = self.tilejson["bounds"]
        return x(west), y(south), x(east), y(north)
