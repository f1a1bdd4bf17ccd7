"""Clients in browsers, on pages of another origin than the server's: what they draw has the map's own pixels, with and
without tokens, and of a map with larger tiles too. Wants npm, Chromium and web/node_modules (playwright-core)."""
import json
import math
import os
import pathlib
import subprocess
import tempfile
import unittest

from gis_support import WORLD_M, has_gdal
from nginx import free_port
from npm_clients import installed_clients, script
from server_support import AS_JSON, Server, ServerTestCase, add_token, bearer, make_map, put_map

WEB = pathlib.Path(__file__).resolve().parents[3] / "web"
CHROMIUM = os.environ.get("SKYQUILT_CHROMIUM", "/usr/bin/chromium")
DRAWING = ["leaflet", "openlayers_xyz", "openlayers_tilejson", "openlayers_wmts", "openlayers_geotiff", "maplibre_tilejson",
           "maplibre_pmtiles", "geotiff"]
# Mean absolute difference to the tile, in levels of 255: the GeoTIFF was encoded anew, and JPEG is decoded by other hands.
# The same tile one pixel aside differs by more (see look()).
MOST_OFF = 0.3


class BrowserTestCase(ServerTestCase):
    """One map in cls.data_folder, made anew where it has options, and how it looks where its tile of 256 pixels lies."""
    photo_count, options = 6, {}

    @classmethod
    def setUpClass(cls):
        cls.npm = installed_clients()
        if cls.npm is None:
            raise unittest.SkipTest("npm's clients cannot be had")
        if not pathlib.Path(CHROMIUM).exists() or not (WEB / "node_modules/playwright-core").is_dir():
            raise unittest.SkipTest("Chromium or web/node_modules is not here (apt install chromium; npm ci in web/)")
        if not has_gdal():
            raise unittest.SkipTest("python3-gdal is not here")
        super().setUpClass()
        script(cls.npm, "browser_pages.js")
        cls.program = script(cls.npm, "browser_clients.mjs")
        cls.data_folder = tempfile.mkdtemp(dir=cls.scratch)
        cls.flight = make_map(cls.data_folder, cls.photos[:cls.photo_count], options=json.dumps(cls.options)) if cls.options else put_map(cls.data_folder)
        server = Server(cls.data_folder, "--workers", "0")
        cls.look(server)
        server.stop()

    @classmethod
    def look(cls, server):
        """The middle of an inner tile of 256 pixels, in degrees, and its picture as the server has it."""
        below = "" if server.json("GET", f"/tiles/{cls.flight}.json")[1]["tileSize"] == 256 else "256/"
        _, told = server.json("GET", f"/tiles/{cls.flight}/256.json")
        west, south, east, north = told["bounds"]
        zoom = told["maxzoom"]
        tile_m = 2 * WORLD_M / 2**zoom
        latitude = lambda y: math.degrees(math.atan(math.sinh(y / WORLD_M * math.pi)))  # noqa: E731
        x = int(((west + east) / 360 * WORLD_M + WORLD_M) / tile_m)
        middle = math.asinh(math.tan(math.radians((south + north) / 2))) / math.pi * WORLD_M
        y = int((WORLD_M - middle) / tile_m)
        cls.map = {"flight": cls.flight, "below": below, "zoom": zoom, "min_zoom": told["minzoom"],
                   "lon": ((x + 0.5) * tile_m - WORLD_M) / WORLD_M * 180, "lat": latitude(WORLD_M - (y + 0.5) * tile_m)}
        cls.want = cls.picture(server.request("GET", f"/tiles/{cls.flight}/256/{zoom}/{x}/{y}.png")[2])
        aside = abs(cls.want[:, :, 1:] - cls.want[:, :, :-1]).mean()
        assert aside > 1.5 * MOST_OFF, f"the tile has too little to see: {aside}"

    @classmethod
    def picture(cls, content):
        from osgeo import gdal
        gdal.UseExceptions()
        with tempfile.NamedTemporaryFile(dir=cls.scratch, suffix=".png") as file:
            file.write(content)
            file.flush()
            return gdal.Open(file.name).ReadAsArray()[:3].astype(int)

    def run_clients(self, names, port, server, token="", **more):
        """What each client answered, and where the pictures are."""
        out = tempfile.mkdtemp(dir=self.scratch)
        given = {**self.map, "server": f"http://127.0.0.1:{server.port}", "token": token, **more}
        photo = pathlib.Path(out, "photo.jpg")
        photo.write_bytes(self.photos[0][1])
        config = {"port": port, "web": str(WEB), "chromium": CHROMIUM, "file": str(photo), "out": out,
                  "runs": [{"name": name, "client": name, "map": given} for name in names]}
        pathlib.Path(out, "config.json").write_text(json.dumps(config))
        done = subprocess.run(["node", self.program, f"{out}/config.json"], capture_output=True, text=True, timeout=1200)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout), pathlib.Path(out)

    def check_drawn(self, names, port, server, token=""):
        told, out = self.run_clients(names, port, server, token)
        for name in names:
            with self.subTest(client=name):
                self.assertNotIn("error", told[name], told[name])
                got = self.picture((out / f"{name}.png").read_bytes())
                self.assertLess(abs(got - self.want).mean(), MOST_OFF, name)
                self.assertGreater(got.std(), self.want.std() / 2, name)

    def token(self):
        return add_token(self.data_folder, "browser", "--scope", "upload")

    def serve_for(self, port, *arguments):
        """The map, to pages of this port."""
        return self.serve("--workers", "0", *arguments, *(("--cors-origin", f"http://127.0.0.1:{port}") if port else ()), data=self.data_folder)


class BrowserClients(BrowserTestCase):
    def test_1_a_page_of_a_named_origin_draws_and_uploads(self):
        port = free_port()
        server = self.serve_for(port)
        self.check_drawn(DRAWING, port, server)
        self.check_upload(port, server, "")
        told, _ = self.run_clients(["leaflet"], free_port(), server)  # whom nobody named gets nothing
        self.assertIn("could not load a tile", told["leaflet"]["error"])

    def test_2_any_page_that_has_a_token_draws_and_uploads(self):
        port, token = free_port(), self.token()
        server = self.serve_for(None)
        self.check_drawn(DRAWING, port, server, token)
        self.check_upload(port, server, token)
        told, _ = self.run_clients(["maplibre_tilejson", "openlayers_xyz"], port, server, "wrong")
        self.assertIn("401", told["maplibre_tilejson"]["error"])  # the cause, which the browser shows because CORS lets it
        self.assertIn("error", told["openlayers_xyz"])

    def check_upload(self, port, server, token):
        name, content = self.photos[0]
        headers = bearer(token) if token else {}
        as_json = {**headers, **AS_JSON}
        flight = json.loads(server.request("POST", "/api/v1/flights", json.dumps({"name": "From elsewhere"}), as_json)[2])["id"]
        told, _ = self.run_clients(["uppy"], port, server, token, flight=flight, file=name)
        self.assertEqual(told["uppy"].get("answer"), {"sent": [name], "bytes": len(content)}, told)
        status, _, files = server.request("GET", f"/api/v1/flights/{flight}/files", headers=headers)
        self.assertEqual((status, [(file["name"], file["bytes"]) for file in json.loads(files)["files"]]), (200, [(name, len(content))]))


class LargeTilesInBrowsers(BrowserTestCase):
    """A map of 512-pixel tiles: clients that are told of 256 get them, the others follow the documents."""
    photo_count, options = 2, {"gsd_m": 0.014}

    def test_every_client_shows_the_pixels_at_their_places(self):
        self.assertEqual(self.map["below"], "256/")
        port = free_port()
        self.check_drawn(["leaflet", "openlayers_xyz", "openlayers_tilejson", "openlayers_wmts", "maplibre_tilejson"], port,
                         self.serve_for(port))
