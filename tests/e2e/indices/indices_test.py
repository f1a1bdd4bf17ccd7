"""Indices of maps as the server gives them, against numpy on the same tiles and the same bands: colours to one level of
the ramp, values and statistics to rounding; zones as GDAL reads them; hostile expressions refused."""
import json
import unittest
import urllib.parse
from xml.etree import ElementTree

from program import ScratchCase, run
from server_support import Server

try:
    import numpy as np
    from osgeo import gdal, ogr
    gdal.UseExceptions()
    MISSING = ""
except ImportError:
    MISSING = "python3-gdal and python3-numpy are not installed: they make the maps and the figures to compare with"

HALF_WORLD_M = 20037508.342789244
ZOOM, SIDE = 21, 256
PIXEL_M = 2 * HALF_WORLD_M / (SIDE << ZOOM)
FIRST = (1090000, 730000)  # column and row of the map's first tile
WIDTH, HEIGHT = 3 * SIDE + 72, 2 * SIDE + 32  # of which overviews take every eighth
RDYLGN = ["a50026", "d73027", "f46d43", "fdae61", "fee08b", "ffffbf", "d9ef8b", "a6d96a", "66bd63", "1a9850", "006837"]


def rdylgn():
    """256 colours between the points that ColorBrewer published."""
    points = np.array([[int(colour[i:i + 2], 16) for i in (0, 2, 4)] for colour in RDYLGN], float)
    place = np.linspace(0, len(points) - 1, 256)
    return np.stack([np.interp(place, np.arange(len(points)), points[:, channel]) for channel in range(3)], axis=1)


def write(path, bands, kind, **options):
    """A GeoTIFF on the grid of the web map, with `bands` as (name, array) and what is said of each of them."""
    file = gdal.GetDriverByName("GTiff").Create(str(path), WIDTH, HEIGHT, len(bands), kind, ["TILED=YES", "COMPRESS=DEFLATE"])
    file.SetGeoTransform((FIRST[0] * SIDE * PIXEL_M - HALF_WORLD_M, PIXEL_M, 0, HALF_WORLD_M - FIRST[1] * SIDE * PIXEL_M, 0, -PIXEL_M))
    file.SetProjection("EPSG:3857")
    for number, (name, values) in enumerate(bands, 1):
        band = file.GetRasterBand(number)
        band.SetDescription(name)
        if options:
            band.SetScale(options["scale"])
            band.SetOffset(options["offset"])
            band.SetNoDataValue(0)
        elif kind == gdal.GDT_Float32:
            band.SetNoDataValue(float("nan"))
        band.WriteArray(values)
    file.BuildOverviews("AVERAGE", [2, 4, 8])
    file.FlushCache()


def pixels(picture):
    """An encoded picture as rows of RGBA."""
    gdal.FileFromMemBuffer("/vsimem/picture", picture)
    try:
        read = gdal.Open("/vsimem/picture").ReadAsArray()
    finally:
        gdal.Unlink("/vsimem/picture")
    read = np.stack([read] * 3) if read.ndim == 2 else read
    return np.moveaxis(read if len(read) == 4 else np.concatenate([read, np.full((1, *read.shape[1:]), 255, read.dtype)]), 0, 2)


@unittest.skipIf(MISSING, MISSING)
class Indices(ScratchCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        x, y = np.meshgrid(np.arange(WIDTH) / WIDTH, np.arange(HEIGHT) / HEIGHT)
        colours = [np.uint8(127 + 120 * np.sin(9 * x + 2 * y)), np.uint8(128 + 110 * np.cos(5 * x * y + 1)), np.uint8(40 + 60 * y)]
        write(cls.scratch / "colours.tif", list(zip(("", "", ""), colours)), gdal.GDT_Byte)
        data = cls.scratch / "data"
        cls.flights = [cls.import_(data) for _ in range(3)]
        generator = np.random.default_rng(5)
        unknown = (x - 0.5) ** 2 + (y - 0.5) ** 2 > 0.2
        cls.bands = {name: (0.05 + 0.9 * generator.random((HEIGHT, WIDTH)) * (0.3 + 0.7 * x)).astype(np.float32)
                     for name in ("green", "red", "rededge", "nir")}
        for values in cls.bands.values():
            values[unknown] = np.nan
        cls.bands["nir"][100:140, 200:260] = 0
        cls.bands["red"][100:140, 200:260] = 0  # where NDVI divides by zero
        folders = [data / "flights" / flight / "r1" for flight in cls.flights]
        write(folders[1] / "bands.tif", list(cls.bands.items()), gdal.GDT_Float32)
        # Ten thousandths from a tenth below zero on.
        whole = {name: np.where(np.isnan(v), 0, np.round((v + 0.1) * 10000)).astype(np.uint16) for name, v in cls.bands.items()}
        cls.of_whole = {name: np.where(v == 0, np.nan, v * 0.0001 - 0.1) for name, v in whole.items()}
        write(folders[2] / "bands.tif", list(whole.items()), gdal.GDT_UInt16, scale=0.0001, offset=-0.1)
        cls.server = Server(data, "--workers", "1")
        cls.addClassCleanup(cls.server.stop)

    @classmethod
    def import_(cls, data):
        said = run("import", cls.scratch / "colours.tif", "--data", data).stdout
        return next(line.split()[1] for line in said.splitlines() if line.startswith("flight "))

    def tile(self, flight, x, y, zoom=ZOOM, **query):
        text = "?" + urllib.parse.urlencode(query) if query else ""
        status, headers, body = self.server.request("GET", f"/tiles/{flight}/{zoom}/{x}/{y}.png{text}")
        self.assertEqual((status, headers["Content-Type"]), (200, "image/png"), body)
        return pixels(body)

    def assert_coloured(self, shown, values, least, most, alphas):
        """Within one level of the ramp; transparent where there is no value."""
        known = np.isfinite(values) & (alphas > 0)
        np.testing.assert_array_equal(shown[..., 3], np.where(known, alphas, 0))
        levels = np.rint(np.clip((values[known] - least) / (most - least), 0, 1) * 255).astype(int)
        ramp = rdylgn()
        near = [np.abs(shown[known][:, :3] - ramp[np.clip(levels + by, 0, 255)]).max(axis=1) for by in (-1, 0, 1)]
        self.assertLessEqual(np.min(near, axis=0).max(initial=0), 1.0)
        return int(known.sum())

    def test_tiles_of_colours_are_numpys_to_one_level(self):
        for zoom, formula in ((ZOOM, "(2*green-red-blue)/(2*green+red+blue)"), (ZOOM - 2, "max(red, green)**2 - sqrt(blue)/3"), (ZOOM, "log(green)-red")):
            for x in range(FIRST[0] >> (ZOOM - zoom), (FIRST[0] + 3 >> (ZOOM - zoom)) + 1):
                y = FIRST[1] >> (ZOOM - zoom)
                colours = self.tile(self.flights[0], x, y, zoom)
                red, green, blue = (colours[..., channel] / 255.0 for channel in range(3))
                with np.errstate(all="ignore"):
                    values = eval(formula, {"max": np.maximum, "sqrt": np.sqrt, "log": np.log, "red": red, "green": green, "blue": blue})
                shown = self.tile(self.flights[0], x, y, zoom, expression=formula, rescale="-0.4,0.5")
                self.assertGreater(self.assert_coloured(shown, values, -0.4, 0.5, colours[..., 3]), 100)

    def test_tiles_of_bands_are_numpys_to_one_level(self):
        for flight, bands in ((self.flights[1], self.bands), (self.flights[2], self.of_whole)):
            shown = 0
            for column in range(4):
                for row in range(3):
                    part = {name: np.full((SIDE, SIDE), np.nan) for name in bands}
                    for name, values in bands.items():
                        cut = values[row * SIDE:(row + 1) * SIDE, column * SIDE:(column + 1) * SIDE]
                        part[name][:cut.shape[0], :cut.shape[1]] = cut
                    nir, red = part["nir"], part["red"]
                    with np.errstate(all="ignore"):
                        values = np.where(nir + red == 0, np.nan, (nir - red) / (nir + red))
                    picture = self.tile(flight, FIRST[0] + column, FIRST[1] + row, index="ndvi", rescale="-1,1")
                    shown += self.assert_coloured(picture, values, -1, 1, np.full((SIDE, SIDE), 255))
            self.assertGreater(shown, 100_000)

    def test_coarser_tiles_of_bands_are_gdals_averages(self):
        file = gdal.Open(str(self.scratch / "data/flights" / self.flights[1] / "r1/bands.tif"))
        zoom = ZOOM - 2
        x, y = FIRST[0] >> 2, FIRST[1] >> 2  # both are multiples of four
        read = file.ReadAsArray(0, 0, WIDTH // 4 * 4, HEIGHT // 4 * 4, buf_xsize=WIDTH // 4, buf_ysize=HEIGHT // 4,
                                resample_alg=gdal.GRIORA_Average).astype(float)
        green, nir = read[0], read[3]
        values = (nir - green) / (nir + green)
        shown = self.tile(self.flights[1], x, y, zoom, index="gndvi", rescale="-1,1")[:HEIGHT // 4, :WIDTH // 4]
        known = np.isfinite(values) & (shown[..., 3] > 0)
        self.assertGreater(known.sum(), 0.95 * np.isfinite(values).sum())
        levels = np.rint((np.clip(values[known], -1, 1) + 1) / 2 * 255).astype(int)
        near = [np.abs(shown[known][:, :3] - rdylgn()[np.clip(levels + by, 0, 255)]).max(axis=1) for by in (-1, 0, 1)]
        self.assertLess(np.mean(np.min(near, axis=0) > 1.0), 0.01)

    def test_statistics_and_points_are_numpys(self):
        flight = self.flights[1]
        bounds = self.server.json("GET", f"/api/v1/flights/{flight}")[1]["bounds"]
        west, south, east, north = bounds[0] - 1e-4, bounds[1] - 1e-4, bounds[2] + 1e-4, bounds[3] + 1e-4
        box = {"type": "Polygon", "coordinates": [[[west, south], [east, south], [east, north], [west, north], [west, south]]]}
        _, told = self.server.json("POST", f"/api/v1/flights/{flight}/statistics?index=ndvi", box, code=200)
        nir, red = self.bands["nir"].astype(float), self.bands["red"].astype(float)
        with np.errstate(all="ignore"):
            values = (nir - red) / (nir + red)
        values = values[np.isfinite(values)]
        index = told["index"]
        self.assertEqual(index["pixels"], values.size)
        for name, figure in (("min", values.min()), ("max", values.max()), ("mean", values.mean()), ("std", values.std())):
            self.assertAlmostEqual(index[name], figure, delta=1e-6, msg=name)
        for name, value in index["percentiles"].items():
            self.assertAlmostEqual(value, np.percentile(values, int(name[1:])), delta=1e-6, msg=name)
        counted = np.histogram(values, bins=64)[0]
        self.assertLessEqual(np.abs(counted - np.array(index["histogram"])).sum(), 8)  # values on an edge
        column, row = 400, 250
        lon = (FIRST[0] * SIDE + column + 0.5) * PIXEL_M / HALF_WORLD_M * 180 - 180
        merc_y = HALF_WORLD_M - (FIRST[1] * SIDE + row + 0.5) * PIXEL_M
        lat = np.degrees(2 * np.arctan(np.exp(merc_y / HALF_WORLD_M * np.pi)) - np.pi / 2)
        status, point = self.server.json("GET", f"/api/v1/flights/{flight}/point?lon={lon:.12f}&lat={lat:.12f}&expression=nir&ground=false")
        self.assertAlmostEqual(point["index"]["value"], float(self.bands["nir"][row, column]), places=6)

    def test_zones_open_in_gdal(self):
        flight = self.flights[0]
        areas = []
        for kind, driver in (("geojson", "GeoJSON"), ("shp", "ESRI Shapefile")):
            _, headers, body = self.server.request("GET", f"/api/v1/flights/{flight}/zones?index=gli&classes=4&format={kind}", code=200)
            path = self.scratch / f"zones.{'geojson' if kind == 'geojson' else 'shz'}"
            path.write_bytes(body)
            file = ogr.Open(str(path))
            self.assertEqual(file.GetDriver().GetName(), driver)
            layer = file.GetLayer(0)
            zones = [(feature["zone"], feature["mean"], feature["area_m2"], feature.GetGeometryRef().IsValid()) for feature in layer]
            self.assertEqual([zone for zone, *_ in zones], [1, 2, 3, 4])
            means = [mean for _, mean, *_ in zones]
            self.assertEqual(means, sorted(means))
            self.assertTrue(all(valid for *_, valid in zones))
            areas.append([area for _, _, area, _ in zones])
        np.testing.assert_allclose(areas[0], areas[1], rtol=1e-4)
        np.testing.assert_allclose(areas[0], np.mean(areas[0]), rtol=0.1)

    def test_gdal_reads_an_index_by_wmts(self):
        base = f"http://127.0.0.1:{self.server.port}/wmts/{self.flights[1]}"
        wmts = gdal.Open(f"WMTS:{base},layer=map,style=ndvi,tilematrixset=WebMercatorQuad")
        read = wmts.ReadAsArray()
        tile = self.tile(self.flights[1], FIRST[0] + 1, FIRST[1] + 1, index="ndvi")
        colours = np.moveaxis(read, 0, 2).reshape(-1, len(read))
        solid = tile[tile[..., 3] == 255][:, :3]
        found = {tuple(colour) for colour in colours[:, :3]}
        self.assertGreater(np.mean([tuple(colour) in found for colour in solid[::97]]), 0.95)

    def test_legends_show_the_ramp_and_its_values(self):
        flight = self.flights[1]
        legend = f"/api/v1/flights/{flight}/legend.png?index=ndvi"
        status, headers, body = self.server.request("GET", legend)
        self.assertEqual((status, headers["Content-Type"]), (200, "image/png"), body)
        shown = pixels(body)
        self.assertEqual(shown.shape, (64, 320, 4))
        self.assertTrue((shown[..., 3] == 255).all())  # on a card of its own, for light and dark
        np.testing.assert_allclose(shown[32, 16:304, :3], rdylgn()[np.rint(np.linspace(0, 255, 288)).astype(int)], atol=3)
        self.assertLess(shown[4:18, 16:120, :3].min(), 60)   # title
        for left in (4, 78, 148, 222, 290):                  # values
            self.assertLess(shown[42:58, left:left + 26, :3].min(), 90, left)
        _, _, other = self.server.request("GET", legend + "&rescale=-1,3")
        np.testing.assert_array_equal(pixels(other)[:41], shown[:41])
        self.assertFalse((pixels(other)[41:] == shown[41:]).all())
        for text in ("red+" * 60 + "red", "(red" + "+(red" * 20 + ")" * 21):
            _, _, body = self.server.request("GET", f"/api/v1/flights/{flight}/legend.png?" + urllib.parse.urlencode({"expression": text}), code=200)
            self.assertTrue((pixels(body)[4:18, 306:316, :3] == 255).all())  # the title ends before the margin

    def test_wms_has_legends(self):
        flight = self.flights[1]
        for version, tag in (("1.3.0", "sld:GetLegendGraphic"), ("1.1.1", "GetLegendGraphic")):
            status, _, told = self.server.request("GET", f"/wms/{flight}?SERVICE=WMS&REQUEST=GetCapabilities&VERSION={version}")
            document = ElementTree.fromstring(told)
            self.assertIn(f"<{tag}>".encode(), told)
            address = next(element.get("{http://www.w3.org/1999/xlink}href") for element in document.iter()
                           if element.tag.endswith("OnlineResource") and "legend" in (element.get("{http://www.w3.org/1999/xlink}href") or ""))
            status, headers, by_address = self.server.request("GET", address.split(f":{self.server.port}", 1)[1])
            self.assertEqual((status, headers["Content-Type"]), (200, "image/png"))
            ask = f"/wms/{flight}?SERVICE=WMS&REQUEST=GetLegendGraphic&VERSION={version}&SLD_VERSION=1.1.0&LAYER=map&FORMAT="
            style = urllib.parse.parse_qs(urllib.parse.urlparse(address).query)["index"][0]
            status, headers, by_wms = self.server.request("GET", f"{ask}image/png&STYLE={style}&WIDTH=20&HEIGHT=20")
            self.assertEqual((status, by_wms), (200, by_address))
            status, headers, _ = self.server.request("GET", f"{ask}image/svg%2Bxml&STYLE={style}")
            self.assertEqual((status, headers["Content-Type"]), (200, "image/svg+xml"))
            for wrong, code in ((f"{ask}image/png&STYLE=nothing", b"StyleNotDefined"), (f"{ask}image/png", b"StyleNotDefined"),
                                (f"{ask}image/gif&STYLE=ndvi", b"InvalidFormat"),
                                (f"{ask}image/png&STYLE=ndvi".replace("LAYER=map", "LAYER="), b"LayerNotDefined"),
                                (f"{ask}image/png&STYLE=ndvi".replace("LAYER=map", "LAYER=%3Cother%3E"), b"LayerNotDefined")):
                _, _, said = self.server.request("GET", wrong, code=400)
                self.assertIn(code, said)
                ElementTree.fromstring(said)

    def test_hostile_expressions_are_refused(self):
        for text in ("(" * 300, "-" * 511 + "red", "red" + "**red" * 120, "red+" * 127 + "red", "a" * 513, "__import__('os')",
                     "red;DROP TABLE", "red\x00", "1e9999*red", "", "red/*green*/", "../../etc", "${red}", "log(" * 40 + "red" + ")" * 40,
                     "pow(red,pow(red,pow(red,pow(red,pow(red,pow(red,pow(red,pow(red,pow(red,2)))))))))"):
            _, answer = self.server.json("GET", f"/tiles/{self.flights[0]}/{ZOOM}/{FIRST[0]}/{FIRST[1]}.png?" + urllib.parse.urlencode({"expression": text}), code=400)
            self.assertGreater(len(answer["detail"]), 20)
        status, answer = self.server.json("GET", f"/tiles/{self.flights[0]}/{ZOOM}/{FIRST[0]}/{FIRST[1]}.png?index=ndvi")
        self.assertIn("red, green, blue", json.dumps(answer))
