"""A map of others becomes a flight that is served like any other; what cannot be one is refused with what to do."""
import json
import pathlib
import shutil
import sqlite3
import tempfile
import unittest

from flights import made_flights
from program import ScratchCase, run, tool
from server_support import Server, middle_of, tile_of

HAS_GDAL = all(shutil.which(name) for name in ("gdal_translate", "gdalwarp", "gdalinfo"))


@unittest.skipUnless(HAS_GDAL, "gdal-bin is not installed: it makes the maps of others for this test")
class Import(ScratchCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        shutil.copytree(made_flights.small_map(), cls.scratch / "map")
        cls.report = json.loads((cls.scratch / "map/report.json").read_text())
        cls.cog = cls.scratch / "map/mosaic.tif"
        cls.swiss = cls.scratch / "swiss.tif"
        tool("gdalwarp", "-q", "-t_srs", "EPSG:32632", "-dstalpha", "-r", "cubic", cls.cog, cls.swiss)

    def setUp(self):
        self.data = pathlib.Path(tempfile.mkdtemp(prefix="data_", dir=self.scratch)) / "data"

    def import_(self, file, *words, code=0):
        return run("import", file, "--data", self.data, *map(str, words), code=code)

    def imported(self, file, *words):
        done = self.import_(file, *words)
        self.assertEqual(list((self.data / "incoming").iterdir()), [])
        return next(line.split()[1] for line in done.stdout.splitlines() if line.startswith("flight "))

    def middle_of(self, server, flight):
        """The tile in the middle of a map, as the server gives it."""
        zoom = server.json("GET", f"/tiles/{flight}.json")[1]["maxzoom"]
        x, y = middle_of(server.json("GET", f"/api/v1/flights/{flight}")[1]["bounds"], zoom)
        return server.request("GET", f"/tiles/{flight}/{zoom}/{x}/{y}")

    def test_geotiffs_and_mbtiles_are_served_like_any_map(self):
        flights = {"cog": self.imported(self.cog, "--name", "Old <field>"), "utm": self.imported(self.swiss),
                   "mbtiles": self.imported(self.scratch / "map/mosaic.mbtiles")}
        self.assertTrue((self.data / "flights" / flights["utm"] / "r1" / "thumbnail.png").exists())
        with Server(self.data, "--workers", "1") as server:
            self.assertEqual({flight["id"] for flight in server.json("GET", "/api/v1/flights")[1]["flights"]}, set(flights.values()))
            self.assertEqual(server.json("GET", f"/api/v1/flights/{flights['cog']}")[1]["name"], "Old <field>")
            for kind, flight in flights.items():
                about = server.json("GET", f"/api/v1/flights/{flight}")[1]
                for got, wanted in zip(about["bounds"], self.report["bounds"]):
                    self.assertAlmostEqual(got, wanted, delta=5e-5 if kind != "mbtiles" else 1e-9)
                status, headers, tile = self.middle_of(server, flight)
                self.assertEqual((status, headers["Content-Type"]), (200, "image/jpeg"), kind)
                for address in (f"/api/v1/flights/{flight}/report", f"/api/v1/flights/{flight}/photos.geojson", f"/stac/{flight}", f"/wmts/{flight}",
                                f"/api/v1/flights/{flight}/download.tif", f"/api/v1/flights/{flight}/download.pmtiles", f"/api/v1/flights/{flight}/thumbnail.png",
                                f"/api/v1/flights/{flight}/download.zip", f"/ogc/collections/{flight}", f"/connect/{flight}/qgis.qlr", f"/tms/1.0.0/{flight}"):
                    self.assertEqual(server.request("GET", address)[0], 200, (kind, address))
                # A stitched map's own report, which lies beside two of them, says how true it is; of the third nobody knows.
                stated = self.report["quality"] if kind != "utm" else {"status": "unknown"}
                self.assertEqual(about["quality"]["status"], stated["status"], kind)
                self.assertEqual(about["quality"]["absolute"]["sigma_m"], stated.get("absolute", {}).get("sigma_m"), kind)
                self.assertIn("imported", " ".join(server.json("GET", f"/api/v1/flights/{flight}/report")[1]["warnings"]))
                west, south, east, north = about["bounds"]
                self.assertIn(server.request("GET", f"/api/v1/flights/{flight}/at?lon={(west + east) / 2}&lat={(south + north) / 2}")[0], (200, 404))
            # The tiles of an MBTiles are its own bytes.
            zoom, x, y = self.report["max_zoom"], *tile_of(sum(self.report["bounds"][::2]) / 2, sum(self.report["bounds"][1::2]) / 2, self.report["max_zoom"])
            row = sqlite3.connect(self.scratch / "map/mosaic.mbtiles").execute(
                "SELECT tile_data FROM tiles WHERE zoom_level=? AND tile_column=? AND tile_row=?", (zoom, x, 2 ** zoom - 1 - y)).fetchone()[0]
            self.assertEqual(server.request("GET", f"/tiles/{flights['mbtiles']}/{zoom}/{x}/{y}")[2], row)
            # Nothing to stitch, and said so; shared, deleted and restored like any other.
            server.json("POST", f"/api/v1/flights/{flights['utm']}/jobs", {}, code=409)
            self.assertEqual(server.request("DELETE", f"/api/v1/flights/{flights['utm']}")[0], 204)
            self.assertEqual(server.request("POST", f"/api/v1/flights/{flights['utm']}/restore")[0], 200)
            # While a server has the folder, nothing is imported.
            busy = self.import_(self.cog, code=None)
            self.assertNotEqual(busy.returncode, 0)
            self.assertIn("Stop it", busy.stderr)
        self.assertIn("3 maps", run("data", "check", "--data", self.data).stdout)

    def test_what_a_pixel_shows_lies_where_it_did(self):
        flight = self.imported(self.swiss)
        ours = self.scratch / "ours.tif"
        run("export", self.data / "flights" / flight / "r1", "-o", ours)
        west, south, east, north = self.report["bounds"]
        far = 0
        for step in range(1, 20):
            lon, lat = west + (east - west) * (0.2 + 0.03 * step), south + (north - south) * 0.5
            colours = [[int(value) for value in tool("gdallocationinfo", "-valonly", "-wgs84", path, lon, lat).split()][:3] for path in (self.swiss, ours)]
            far += max(abs(a - b) for a, b in zip(*colours)) > 40
        self.assertLessEqual(far, 3)

    def test_forms_of_colour(self):
        bands = lambda name, *words: tool("gdal_translate", "-q", *words, self.swiss, self.scratch / name)
        bands("grey.tif", "-b", "1")
        bands("rgb.tif", "-b", "1", "-b", "2", "-b", "3")
        bands("holes.tif", "-b", "1", "-b", "2", "-b", "3", "-a_nodata", "0")
        if shutil.which("rgb2pct.py"):
            tool("rgb2pct.py", self.scratch / "rgb.tif", self.scratch / "palette.tif")
        for name in ("grey", "rgb", "holes", "palette"):
            if not (self.scratch / f"{name}.tif").exists():
                continue
            flight = self.imported(self.scratch / f"{name}.tif")
            told = json.loads((self.data / "flights" / flight / "r1" / "report.json").read_text())
            self.assertGreater(told["tile_count"], 0)
            if name == "holes":
                holes_m2 = told["area_m2"]
            if name == "rgb":
                full_m2 = told["area_m2"]
        self.assertLess(holes_m2, 0.999 * full_m2)

    def test_what_cannot_be_a_map(self):
        make = lambda name, *words: tool("gdal_translate", "-q", *words, self.swiss, self.scratch / name)
        make("nowhere.tif", "-co", "PROFILE=BASELINE")
        for stray in self.scratch.glob("nowhere.t*w"):
            stray.unlink()
        tool("gdal_translate", "-q", "-of", "PNG", "-b", "1", "-b", "2", "-b", "3", self.swiss, self.scratch / "picture.png")
        make("sixteen.tif", "-ot", "UInt16")
        make("local.tif", "-a_srs", 'LOCAL_CS["yard",UNIT["metre",1]]')
        make("wrong.tif", "-a_srs", "EPSG:4326")
        make("empty.tif", "-b", "1", "-b", "2", "-b", "3", "-scale", "0", "1", "0", "0", "-a_nodata", "0")
        make("unsaid.tif", "-co", "PROFILE=BASELINE", "-co", "TFW=YES")
        whole = self.swiss.read_bytes()
        (self.scratch / "cut.tif").write_bytes(whole[:len(whole) // 3])
        (self.scratch / "noise.tif").write_bytes(b"II*\0" + bytes(range(256)) * 4)
        tiles = lambda name, sql: (shutil.copy(self.scratch / "map/mosaic.mbtiles", self.scratch / name), self.changed(self.scratch / name, sql))
        tiles("vector.mbtiles", "UPDATE metadata SET value='pbf' WHERE name='format'")
        tiles("degrees.mbtiles", "INSERT INTO metadata VALUES('crs', 'EPSG:4326')")
        tiles("text.mbtiles", "UPDATE tiles_data SET tile_data='hello'")
        tiles("torn.mbtiles", "UPDATE tiles_data SET tile_data=substr(tile_data, 1, length(tile_data)/2)")
        tiles("bare.mbtiles", "DELETE FROM tiles_shallow")
        tiles("none.mbtiles", "DROP TABLE metadata")
        content = (self.scratch / "map/mosaic.mbtiles").read_bytes()
        (self.scratch / "short.mbtiles").write_bytes(content[:len(content) // 2])
        for name, words in [("nowhere.tif", "not georeferenced"), ("picture.png", "GeoTIFF"), ("sixteen.tif", "8 bits"), ("local.tif", "-a_srs"),
                            ("wrong.tif", "system"), ("unsaid.tif", "coordinate system"), ("cut.tif", "damaged"), ("noise.tif", "damaged"), ("empty.tif", "no data"),
                            ("vector.mbtiles", "vector"), ("degrees.mbtiles", "Web Mercator"), ("text.mbtiles", "no PNG"), ("torn.mbtiles", "damaged"),
                            ("bare.mbtiles", "no tiles"), ("none.mbtiles", "is no MBTiles"), ("short.mbtiles", "damaged")]:
            self.assertIn(words, self.import_(self.scratch / name, code=1).stderr, name)
            self.assertEqual(list((self.data / "incoming").iterdir()), [], name)
        self.assertEqual(list((self.data / "flights").iterdir()), [])

    def changed(self, path, sql):
        with sqlite3.connect(path) as db:
            db.execute(sql)
        db.close()
