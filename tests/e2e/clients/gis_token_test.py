"""GIS programs and readers of map files where tokens are asked for: each gets by with the one in the address, whatever
further addresses it takes from documents, and nothing without. And maps of WebP, and of 1024-pixel tiles in QGIS."""
import hashlib
import json
import pathlib
import re
import subprocess
import urllib.parse
import xml.etree.ElementTree as xml_parser

from gis_support import GDAL_XYZ, WORLD_M, GdalTestCase, MapFileTestCase
from npm_clients import installed_clients, script
from server_support import Server, add_token, middle_of


def quoted(url):
    return urllib.parse.quote(url, safe="")


class Guarded(MapFileTestCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.server.stop()
        cls.token = add_token(cls.server.data, "gis", "--scope", "read")
        cls.server = Server(cls.server.data, "--workers", "0")

    def guarded(self, path):
        return self.address(f"{path}{'&' if '?' in path else '?'}token={self.token}")

    def gdal_sources(self, address):
        """By kind of service; `address` makes an address of a path."""
        id, zoom = self.flight_id, self.tilejson["maxzoom"]
        xyz = address(f"/tiles/{id}/${{z}}/${{x}}/${{y}}")
        return {"WMTS": f"WMTS:{address(f'/wmts/{id}')}", "WMTS bare": address(f"/wmts/{id}"), "TMS": address(f"/tms/1.0.0/{id}"),
                "XYZ": GDAL_XYZ.format(url=xyz, w=WORLD_M, zoom=zoom, size=256)}

    def test_gdal_reads_with_the_token_alone(self):
        for kind, source in self.gdal_sources(self.guarded).items():
            with self.subTest(kind=kind):
                self.check_against_mbtiles(self.gdal.Open(source))
        for kind, source in self.gdal_sources(self.address).items():
            with self.subTest(kind=kind, token=None), self.assertRaises(RuntimeError):
                self.check_against_mbtiles(self.gdal.Open(source))

    def test_gdals_mapserver_takes_the_token_as_a_header(self):
        """The driver drops what follows the service's address, so that a token there is lost to the tiles."""
        service = self.address(f"/arcgis/rest/services/{self.flight_id}/MapServer?f=json")
        with self.assertRaises(RuntimeError):
            self.gdal.Open(service)
        self.gdal.SetConfigOption("GDAL_HTTP_HEADERS", f"Authorization: Bearer {self.token}")
        try:
            self.check_against_mbtiles(self.gdal.Open(service))
        finally:
            self.gdal.SetConfigOption("GDAL_HTTP_HEADERS", None)

    def test_gdals_wms_keeps_the_token(self):
        for source in (f"WMS:{self.guarded(f'/wms/{self.flight_id}')}", self.guarded(f"/wms/{self.flight_id}")):
            layer = self.gdal.Open(self.gdal.Open(source).GetSubDatasets()[0][0])
            self.assertGreater(layer.ReadAsArray(buf_xsize=64, buf_ysize=64)[:3].std(), 3.0)

    def test_gdal_reads_the_geotiff_where_it_lies(self):
        path = f"/api/v1/flights/{self.flight_id}/download.tif"
        there = self.gdal.Open(f"/vsicurl/{self.guarded(path)}")
        here = self.gdal.Open(str(self.path("tif")))
        _, _, west, north, pixel_m, side = self.inner_window()
        self.assertEqual(int(abs(self.pixels(there, west, north, pixel_m, side).astype(int)
                                 - self.pixels(here, west, north, pixel_m, side)).max()), 0)

    def test_the_files_to_connect_carry_the_token(self):
        xml = self.server.request("GET", f"/connect/{self.flight_id}/gdal.xml?token={self.token}")[2].decode()
        self.check_against_mbtiles(self.gdal.Open(xml))
        self.check_qgis([qlr_source(self.server, self.flight_id, self.token)])
        self.check_qgis_zooms_to(self.server.request("GET", f"/connect/{self.flight_id}/qgis.qlr?token={self.token}")[2])

    def test_qgis_reads_with_the_token_alone(self):
        zoom, layer = self.tilejson["maxzoom"], "layers=map&format=image/png&crs=EPSG:3857"
        wmts, wms = (self.guarded(f"/{service}/{self.flight_id}") for service in ("wmts", "wms"))
        xyz = self.guarded(f"/tiles/{self.flight_id}/{{z}}/{{x}}/{{y}}")
        self.check_qgis([f"type=xyz&zmin={zoom}&zmax={zoom}&url={quoted(xyz)}",
                         f"{layer}&styles=default&tileMatrixSet=WebMercatorQuad&url={quoted(wmts)}",
                         f"{layer}&styles=&url={quoted(wms)}"])

    def test_owslib_keeps_the_token(self):
        of_wms, of_wmts = self.imported("python3-owslib is not here", "owslib.wms", "owslib.wmts")
        column, row, *_ = self.inner_window()
        for path, layer in ((f"/{self.flight_id}", "map"), ("", self.flight_id)):  # one map's address, and that of all
            wmts = of_wmts.WebMapTileService(self.guarded(f"/wmts{path}"))
            tile = wmts.gettile(layer=layer, tilematrixset="WebMercatorQuad", tilematrix=str(self.tilejson["maxzoom"]), row=row,
                                column=column, format="image/png")
            self.assertTrue(tile.read().startswith(b"\x89PNG"))
            wms = of_wms.WebMapService(self.guarded(f"/wms{path}"), version="1.3.0")
            picture = wms.getmap(layers=[layer], srs="EPSG:4326", bbox=wms[layer].boundingBoxWGS84, size=(300, 200), format="image/png")
            self.assertTrue(picture.read().startswith(b"\x89PNG"))

    def test_readers_of_map_files_find_the_stored_tiles(self):
        clients = installed_clients()
        if clients is None:
            self.skipTest("npm's clients cannot be had")
        column, row, *_ = self.inner_window()
        zoom = self.tilejson["maxzoom"]
        stored = self.server.request("GET", f"/tiles/{self.flight_id}/{zoom}/{column}/{row}?token={self.token}")[2]
        told = {}
        for reader, source in (("pmtiles", self.guarded(f"/api/v1/flights/{self.flight_id}/download.pmtiles")),
                               ("mbtiles", str(self.path("mbtiles")))):
            said = subprocess.run(["node", script(clients, "tile_files.mjs"), reader, source, str(zoom), str(column), str(row)],
                                  capture_output=True, text=True)
            if "Could not locate the bindings file" in said.stderr:
                continue  # of @mapbox/mbtiles' sqlite3, which npm_clients.py --native compiles
            self.assertEqual(said.returncode, 0, said.stderr)
            told[reader] = json.loads(said.stdout)
        for reader, tile in told.items():
            self.assertEqual(tile["sha256"], hashlib.sha256(stored).hexdigest(), reader)
            self.assertEqual((tile["min_zoom"], tile["max_zoom"]), (self.tilejson["minzoom"], zoom), reader)
        if "mbtiles" not in told:
            self.skipTest("pmtiles holds; sqlite3 for @mapbox/mbtiles is not compiled: tests/e2e/npm_clients.py --native")


def qlr_source(server, flight_id, token=""):
    """What QGIS opens of the layer definition."""
    query = f"?token={token}" if token else ""
    xml = server.request("GET", f"/connect/{flight_id}/qgis.qlr{query}")[2]
    return xml_parser.fromstring(xml).find("maplayers/maplayer/datasource").text


class WebpMap(GdalTestCase):
    photo_count, options = 2, {"format": "webp"}

    def test_wmts_lists_what_is_stored_first(self):
        """And GDAL, which takes the first format that it knows, reads the map."""
        text = self.server.request("GET", f"/wmts/{self.flight_id}")[2].decode()
        listed = re.findall(r"<Format>image/(\w+)</Format>", text)
        self.assertEqual((listed[0], sorted(listed)), ("webp", ["jpeg", "png", "webp"]))
        self.assertEqual(re.search(r'<ResourceURL format="image/(\w+)"', text).group(1), "webp")
        overview = self.gdal.Open(self.address(f"/wmts/{self.flight_id}")).ReadAsArray(buf_xsize=64, buf_ysize=64)
        self.assertGreater(overview[:3].std(), 3.0)


class VeryLargeTiles(MapFileTestCase):
    """A map of 1024-pixel tiles, which QGIS has no setting for as XYZ: its layer definition names the WMTS set of just these."""
    photo_count, options = 2, {"gsd_m": 0.007}

    def test_qgis_shows_the_map_pixel_for_pixel(self):
        self.assertEqual(self.tilejson["tileSize"], 1024)
        _, told = self.server.json("GET", f"/tiles/{self.flight_id}/256.json")
        self.assertEqual((told["tileSize"], told["maxzoom"]), (256, self.tilejson["maxzoom"] + 2))
        self.assertIn(f"/tiles/{self.flight_id}/256/", told["tiles"][0])
        source = qlr_source(self.server, self.flight_id)
        self.assertIn("tileMatrixSet=WebMercatorQuad1024&", source)
        zoom = self.tilejson["maxzoom"]
        column, row = middle_of(self.tilejson["bounds"], zoom)
        tile = pathlib.Path(self.data, "tile.png")
        tile.write_bytes(self.server.request("GET", f"/tiles/{self.flight_id}/{zoom}/{column}/{row}.png")[2])
        want = self.gdal.Open(str(tile)).ReadAsArray()
        self.assertTrue((want[3:] == 255).all(), "the map ends within the tile")
        tile_m = 2 * WORLD_M / 2**zoom
        self.check_qgis([source], 0.1, (column * tile_m - WORLD_M, WORLD_M - row * tile_m, tile_m / 1024, 1024), want[:3])
