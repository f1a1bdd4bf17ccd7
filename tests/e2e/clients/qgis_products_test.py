"""What a server hands over, drawn by QGIS where it lies: the GeoTIFF in UTM, the bands and the heights, each held against the map.
SKYQUILT_PICTURES=FOLDER keeps the pictures."""
import json
import math
import os
import pathlib
import shutil
import tempfile
import unittest

from flights import made_flights
from gis_support import MapFileTestCase, has_qgis
from server_support import Server, ServerTestCase, photos_in, wait_until

# Each source is "band,lowest,highest,address": drawn grey between the two; band 0: as QGIS draws it by itself.
QGIS_DRAW = r"""
import json
import sys
from qgis.core import (QgsApplication, QgsContrastEnhancement, QgsCoordinateReferenceSystem, QgsMapRendererParallelJob, QgsMapSettings,
                       QgsRasterLayer, QgsRectangle, QgsSingleBandGrayRenderer)
from qgis.PyQt.QtCore import QSize
from qgis.PyQt.QtGui import QColor
west, south, east, north, side, out, *sources = sys.argv[1:]
application = QgsApplication([], False)
application.initQgis()
systems = []
for number, source in enumerate(sources):
    band, lowest, highest, address = source.split(",", 3)
    layer = QgsRasterLayer(address, "served", "gdal")
    assert layer.isValid(), (address, layer.error().message())
    systems.append([layer.crs().authid(), layer.bandCount(), layer.dataProvider().generateBandName(1)])
    if int(band) > 0:
        renderer = QgsSingleBandGrayRenderer(layer.dataProvider(), int(band))
        stretch = QgsContrastEnhancement(layer.dataProvider().dataType(int(band)))
        stretch.setMinimumValue(float(lowest))
        stretch.setMaximumValue(float(highest))
        stretch.setContrastEnhancementAlgorithm(QgsContrastEnhancement.StretchToMinimumMaximum)
        renderer.setContrastEnhancement(stretch)
        layer.setRenderer(renderer)
    settings = QgsMapSettings()
    settings.setLayers([layer])
    settings.setBackgroundColor(QColor(0, 0, 0, 0))
    settings.setDestinationCrs(QgsCoordinateReferenceSystem("EPSG:3857"))
    settings.setExtent(QgsRectangle(float(west), float(south), float(east), float(north)))
    settings.setOutputSize(QSize(int(side), int(side)))
    settings.setOutputDpi(96)
    job = QgsMapRendererParallelJob(settings)
    job.start()
    job.waitForFinished()
    assert not job.errors(), [error.message for error in job.errors()]
    job.renderedImage().save(f"{out}/{number}.png")
print(json.dumps(systems))
"""
SIDE = 600


class QgisProducts(MapFileTestCase):
    @classmethod
    def setUpClass(cls):
        if not has_qgis():
            raise unittest.SkipTest("python3-qgis is not here")
        from osgeo import gdal
        gdal.UseExceptions()
        cls.gdal = gdal
        ServerTestCase.setUpClass.__func__(cls)
        cls.data = tempfile.mkdtemp(dir=cls.scratch)
        cls.server = Server(cls.data, "--workers", "1")
        flight = made_flights.simulated(8, "640x480", "--bands", "--relief-m", "4")
        files = photos_in(flight / "photos")
        cls.flight_id = cls.server.stitched(files, options=json.dumps({"heights": "dsm"}))["flight"]["id"]
        cls.flight = f"/api/v1/flights/{cls.flight_id}"
        _, cls.tilejson = cls.server.json("GET", f"/tiles/{cls.flight_id}.json")
        cls.mbtiles = pathlib.Path(cls.scratch, "map.mbtiles")
        cls.mbtiles.write_bytes(cls.server.request("GET", f"{cls.flight}/download.mbtiles")[2])

    def utm(self):
        status, made = self.server.json("POST", f"{self.flight}/exports", {"format": "geotiff", "crs": "utm"})
        self.assertIn(status, (200, 202), made)
        path = f"{self.flight}/exports/{made['id']}"
        wait_until(lambda: self.server.json("GET", path)[1]["state"] not in ("accepted", "running"), "the export did not end")
        self.assertEqual(self.server.json("GET", path)[1]["state"], "successful")
        return f"{path}/file"

    def drawn(self, *sources):
        """QGIS' pictures of a square over the whole map, as levels and what is drawn at all; what it says of the layers; and the map's."""
        west, south, east, north = self.bounds_m()
        side_m = max(east - west, north - south)
        box = [west, north - side_m, west + side_m, north]
        out = tempfile.mkdtemp(dir=self.scratch)
        told = self.in_qgis(QGIS_DRAW, *(repr(edge) for edge in box), str(SIDE), out, *sources)
        pictures = [self.gdal.Open(f"{out}/{number}.png").ReadAsArray() for number in range(len(sources))]
        if os.environ.get("SKYQUILT_PICTURES"):
            shutil.copytree(out, pathlib.Path(os.environ["SKYQUILT_PICTURES"], self._testMethodName), dirs_exist_ok=True)
        want = self.gdal.Warp("", str(self.mbtiles), format="MEM", outputBounds=box, width=SIDE, height=SIDE, dstSRS="EPSG:3857",
                              resampleAlg="bilinear").ReadAsArray().astype(int)
        return pictures, json.loads(next(line for line in told.splitlines() if line.startswith("["))), want, box

    def assert_at_its_place(self, got, want, seen, least):
        """The same things at the same places: shifted by two pixels of six hundred they are less alike."""
        inner = seen[2:-2, 2:-2]
        alike = {shift: abs(self.correlation(got[2 + shift[1]:SIDE - 2 + shift[1], 2 + shift[0]:SIDE - 2 + shift[0]][inner], want[2:-2, 2:-2][inner]))
                 for shift in ((0, 0), (2, 0), (-2, 0), (0, 2), (0, -2))}
        self.assertGreater(alike[0, 0], least, alike)
        self.assertEqual(max(alike, key=alike.get), (0, 0), alike)

    def served(self, path):
        return f"/vsicurl/{self.address(path)}"

    def test_the_geotiff_in_utm_is_the_map(self):
        (picture,), (system,), want, _ = self.drawn("0,0,0," + self.served(self.utm()))
        self.assertRegex(system[0], r"^EPSG:326\d\d$")
        seen = (want[3] == 255) & (picture[3] == 255)
        self.assertGreater(seen.sum(), 0.98 * (want[3] == 255).sum())
        self.assertLess(abs(picture[:3].astype(int) - want[:3])[:, seen].mean(), 4.0)
        self.assert_at_its_place(picture[1].astype(int), want[1], seen, 0.95)

    def test_bands_lie_on_the_map(self):
        source = self.served(f"{self.flight}/bands.tif")
        raster = self.gdal.Open(source)
        names = [raster.GetRasterBand(band + 1).GetDescription() for band in range(raster.RasterCount)]
        report = self.server.json("GET", f"{self.flight}/report")[1]["bands"]
        self.assertEqual(names, [band["name"] for band in report["bands"]])
        self.assertEqual({band["held_against"] for band in report["bands"]}, {None})
        reference = names.index(report["reference_band"]) + 1
        lowest, highest = raster.GetRasterBand(reference).ComputeRasterMinMax(False)
        (picture,), (system,), want, _ = self.drawn(f"{reference},{lowest},{highest},{source}")
        self.assertEqual(system[:2], ["EPSG:3857", len(names)])
        self.assertIn(names[0], system[2])
        seen = (want[3] == 255) & (picture[3] == 255)
        self.assertGreater(seen.sum(), 0.9 * (want[3] == 255).sum())
        self.assert_at_its_place(picture[1].astype(int), want[1], seen, 0.75)  # QGIS takes the nearest value: its picture is rougher

    def test_heights_are_drawn_where_and_as_high_as_they_are(self):
        source = self.served(f"{self.flight}/dsm.tif")
        raster = self.gdal.Open(source)
        lowest, highest = raster.GetRasterBand(1).ComputeRasterMinMax(False)
        (picture,), (system,), want, box = self.drawn(f"1,{lowest},{highest},{source}")
        self.assertRegex(system[0], r"^EPSG:326\d\d$")
        step, checked = (highest - lowest) / 255.0, 0
        for column in range(50, SIDE, 100):
            for row in range(50, SIDE, 100):
                if picture[3][row, column] != 255 or want[3][row, column] != 255:
                    continue
                east, north = (box[0] + (column + 0.5) / SIDE * (box[2] - box[0]), box[3] - (row + 0.5) / SIDE * (box[3] - box[1]))
                lon, lat = math.degrees(east / 6378137.0), math.degrees(math.atan(math.sinh(north / 6378137.0)))
                told = self.server.json("GET", f"{self.flight}/point?lon={lon}&lat={lat}")[1]
                self.assertAlmostEqual(lowest + picture[0][row, column] * step, told["dsm_m"], delta=2.0 * step + 0.1, msg=(lon, lat, told))
                checked += 1
        self.assertGreater(checked, 8)
