"""The map through GIS programs: GDAL and QGIS read the server's tiles and get the pixels of the MBTiles."""
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

from server_support import Server, ServerTestCase

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
url, zoom, west, south, east, north, side, out = sys.argv[1:]
application = QgsApplication([], False)
application.initQgis()
layer = QgsRasterLayer(f"type=xyz&zmin={zoom}&zmax={zoom}&url={url}", "map", "wms")
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
image.save(out)
"""


def has_qgis():
    return subprocess.run([sys.executable, "-c", "import qgis.core"], capture_output=True).returncode == 0


def has_gdal():
    return subprocess.run([sys.executable, "-c", "from osgeo import gdal"], capture_output=True).returncode == 0


class Gis(ServerTestCase):
    @classmethod
    def setUpClass(cls):
        if not has_gdal():
            raise unittest.SkipTest("python3-gdal is not here")
        from osgeo import gdal
        gdal.UseExceptions()
        cls.gdal = gdal
        super().setUpClass()
        cls.server = Server(tempfile.mkdtemp(dir=cls.scratch))
        _, made = cls.server.upload(cls.photos)
        job = cls.server.wait_for_job(made["job"]["id"])
        assert job["state"] == "successful", job
        cls.flight_id = made["flight"]["id"]
        _, cls.tilejson = cls.server.json("GET", f"/tiles/{cls.flight_id}.json")
        for kind in ("mbtiles", "tif"):
            _, _, content = cls.server.request("GET", f"/api/v1/flights/{cls.flight_id}/download.{kind}")
            cls.path(kind).write_bytes(content)

    @classmethod
    def tearDownClass(cls):
        cls.server.stop()
        super().tearDownClass()

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

    def url(self):
        return f"http://127.0.0.1:{self.server.port}/tiles/{self.flight_id}/${{z}}/${{x}}/${{y}}.png"

    def test_gdal_reads_files_and_tiles_alike(self):
        _, _, west, north, pixel_m, side = self.inner_window()
        mbtiles = self.gdal.Open(str(self.path("mbtiles")))
        want = self.pixels(mbtiles, west, north, pixel_m, side)
        self.assertGreater(want.std(), 3.0)  # a picture, not a blank
        xml = GDAL_XYZ.format(url=self.url(), w=WORLD_M, zoom=self.tilejson["maxzoom"],
                              size=self.tilejson.get("tileSize", 256))
        served = self.pixels(self.gdal.Open(xml), west, north, pixel_m, side)
        self.assertEqual(int(abs(served.astype(int) - want).max()), 0)
        cog = self.pixels(self.gdal.Open(str(self.path("tif"))), west, north, pixel_m, side)
        self.assertLess(abs(cog.astype(int) - want).mean(), 2.0)

    def test_gdal_translate_cuts_a_piece_of_the_mbtiles(self):
        out = pathlib.Path(self.data, "piece.png")
        subprocess.run(["gdal_translate", "-q", "-srcwin", "100", "100", "200", "150", self.path("mbtiles"), out], check=True)
        self.assertEqual((self.gdal.Open(str(out)).RasterXSize, self.gdal.Open(str(out)).RasterYSize), (200, 150))
        described = json.loads(subprocess.run(["gdalinfo", "-json", self.path("mbtiles")], check=True,
                                              capture_output=True).stdout)
        self.assertIn('"EPSG",3857', described["coordinateSystem"]["wkt"].replace(" ", ""))

    def test_qgis_shows_the_tiles_pixel_for_pixel(self):
        if not has_qgis():
            self.skipTest("python3-qgis is not here")
        _, _, west, north, pixel_m, side = self.inner_window()
        want = self.pixels(self.gdal.Open(str(self.path("mbtiles"))), west, north, pixel_m, side)
        out = pathlib.Path(self.data, "qgis.png")
        url = self.url().replace("$", "").replace("{", "%7B").replace("}", "%7D")
        subprocess.run([sys.executable, "-c", QGIS_SCRIPT, url, str(self.tilejson["maxzoom"]), repr(west),
                        repr(north - side * pixel_m), repr(west + side * pixel_m), repr(north), str(side), out],
                       check=True, env={**os.environ, "QT_QPA_PLATFORM": "offscreen"}, capture_output=True)
        got = self.gdal.Open(str(out)).ReadAsArray()[:3]
        self.assertEqual(int(abs(got.astype(int) - want).max()), 0)


if __name__ == "__main__":
    unittest.main()
