"""The QGIS plugin (api/clients/qgis), packed as users get it and loaded by QGIS without a screen, against the real server:
the list, layers pixel for pixel, uploads, photos of a place, tokens that never lie about."""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest
import zipfile

from gis_support import WORLD_M, MapFileTestCase, has_qgis
from program import run
from server_support import add_token, bearer, photos_in

HERE = pathlib.Path(__file__).resolve().parent
QGIS = HERE.parents[2] / "api" / "clients" / "qgis"


class Plugin(MapFileTestCase):
    @classmethod
    def setUpClass(cls):
        if not has_qgis():
            raise unittest.SkipTest("python3-qgis is not here")
        super().setUpClass()
        cls.plugins = pathlib.Path(cls.scratch, "plugins")
        packed = pathlib.Path(cls.scratch, "skyquilt_qgis.zip")
        subprocess.run([sys.executable, QGIS / "pack.py", packed], check=True, stdout=subprocess.DEVNULL)
        with zipfile.ZipFile(packed) as archive:
            archive.extractall(cls.plugins)
        cls.folder = pathlib.Path(cls.scratch, "more")
        cls.folder.mkdir()
        for name, content in cls.photos:
            (cls.folder / name).write_bytes(content)

    def session(self, url, *steps):
        """What each step gave."""
        self.out = pathlib.Path(tempfile.mkdtemp(dir=self.scratch))
        done = subprocess.run([sys.executable, HERE / "qgis_session.py", self.plugins, url, self.out], input=json.dumps(steps),
                              capture_output=True, text=True, timeout=600)
        self.assertEqual(done.returncode, 0, done.stderr[-4000:])
        return json.loads(done.stdout.strip().splitlines()[-1])

    def test_what_is_packed_is_whole(self):
        names = {path.relative_to(self.plugins).as_posix() for path in self.plugins.rglob("*") if path.is_file()}
        self.assertLessEqual({"skyquilt_qgis/metadata.txt", "skyquilt_qgis/LICENSE", "skyquilt_qgis/icon.png",
                              "skyquilt_qgis/skyquilt/client.py", "skyquilt_qgis/skyquilt/contract/models.py"}, names)
        told = (self.plugins / "skyquilt_qgis/metadata.txt").read_text()
        self.assertNotIn("@", told)
        for key in ("name", "qgisMinimumVersion", "description", "about", "version", "author", "license"):
            self.assertRegex(told, rf"(?m)^{key}=\S")
        self.assertEqual((self.plugins / "skyquilt_qgis/LICENSE").read_bytes(), (QGIS.parents[2] / "LICENSE").read_bytes())

    def test_a_map_becomes_layers(self):
        _, _, west, north, pixel_m, side = self.inner_window()
        window = (west, north - side * pixel_m, west + side * pixel_m, north, side)
        rows, may_add, tiles, extent, zoomed, _, geotiff, _, outlines, _, _, again = self.session(
            self.address(""), ["rows"], ["choose", self.flight_id], ["add", "tiles"], ["extent"], ["zoom"], ["render", "tiles.png", *window],
            ["add", "geotiff"], ["render", "geotiff.png", *window], ["add", "footprints"], ["render", "outlines.png", *window],
            ["grab", "window.png"], ["go"])
        _, flight = self.server.json("GET", f"/api/v1/flights/{self.flight_id}")
        self.assertEqual(rows, [[flight["name"], flight["captured"]["first"][:10], str(len(self.photos)), f"{100 * flight['gsd_m']:.1f} cm"]])
        self.assertTrue(may_add)
        self.assertEqual((tiles[0], tiles[2], geotiff[0], geotiff[2]), ("wms", True, "gdal", True))
        self.assertEqual(outlines[0::2] + outlines[3:], ["ogr", True, len(self.photos)])
        self.assertNotIn("token", tiles[1] + geotiff[1] + outlines[1])
        for shown in (extent, zoomed, again):
            for got, want, less in zip(shown, flight["bounds"], (1, 1, -1, -1)):
                self.assertLessEqual(less * got, less * want)  # all of it is to be seen
            self.assertLess(shown[2] - shown[0], 4 * (flight["bounds"][2] - flight["bounds"][0]))
        want = self.pixels(self.gdal.Open(str(self.path("mbtiles"))), west, north, pixel_m, side).astype(int)
        self.assertGreater(want.std(), 5)
        shifted = abs(want[:, 1:, 1:] - want[:, :-1, :-1]).mean()
        for name in ("tiles.png", "geotiff.png"):
            got = self.gdal.Open(str(self.out / name)).ReadAsArray()[:3].astype(int)
            # QGIS opens the JPEGs with another decoder; a pixel beside its place would be much further off.
            self.assertLess(abs(got - want).mean(), min(2.0, 0.3 * shifted), name)
        drawn = self.gdal.Open(str(self.out / "outlines.png")).ReadAsArray()[:3].astype(int)
        self.assertGreater((abs(drawn - [[[0xD9]], [[0xA4]], [[0x41]]]).max(axis=0) < 40).sum(), side)  # lines cross it

    def test_heights_become_layers_where_the_map_has_them(self):
        server = self.serve("--workers", "1", data=tempfile.mkdtemp(dir=self.scratch))
        made = server.stitched(self.photos, name="Village", options=json.dumps({"heights": "dtm"}))
        flight, url = made["flight"]["id"], f"http://127.0.0.1:{server.port}"
        kinds = ("surface", "hillshade", "ground", "contours")
        _, _, *added = self.session(url, ["rows"], ["choose", flight], *(["add", kind] for kind in kinds))
        self.assertEqual([layer[0::2] for layer in added[:3]], [["gdal", True]] * 3)
        self.assertEqual(added[3][0::2], ["ogr", True])
        for layer, file in zip(added, ("dsm.tif", "dsm_hillshade.tif", "dtm.tif", "contours.geojson")):
            self.assertTrue(layer[1].endswith(f"/flights/{flight}/{file}"), layer)
        _, _, _, said = self.session(self.address(""), ["rows"], ["choose", self.flight_id], ["ask", "surface"], ["said"])
        self.assertIn("was made without these heights. Make it again with heights: dsm.", said[-1])

    def test_photos_of_a_place(self):
        west, south, east, north = self.tilejson["bounds"]
        lon, lat = (west + east) / 2, (south + north) / 2
        _, seen = self.server.json("GET", f"/api/v1/flights/{self.flight_id}/at?lon={lon}&lat={lat}")
        _, _, (title, photos, (width, height, x, y)), _, nothing, left = self.session(
            self.address(""), ["choose", self.flight_id], ["add", "tiles"], ["click", lon, lat], ["grab", "window.png"],
            ["click", lon + 1, lat], ["unload"])
        self.assertEqual([photo["name"] for photo in photos], [photo["name"] for photo in seen["photos"]])
        self.assertIn(f"{len(photos)} photos see {lat:.6f}, {lon:.6f}", title)
        self.assertEqual((width, height), (800, 600))
        # The project's coordinates are rounded on the way.
        self.assertAlmostEqual(x, seen["photos"][0]["x"], delta=0.01)
        self.assertAlmostEqual(y, seen["photos"][0]["y"], delta=0.01)
        self.assertEqual((nothing[0].split(" sees")[0], nothing[1]), ("No photo of a listed map", []))
        self.assertEqual(left, [True, 0, 0])

    def test_a_map_across_the_antimeridian(self):
        photos = pathlib.Path(self.scratch, "fiji/photos")
        run("simulate", "-o", photos.parent, "--photos", "4", "--size", "640x480", "--no-world", "--lat", "-17", "--lon", "180")
        server = self.serve("--workers", "1", data=tempfile.mkdtemp(dir=self.scratch))
        flight = server.stitched(photos_in(photos))["flight"]["id"]
        west, south, east, north = server.json("GET", f"/api/v1/flights/{flight}")[1]["bounds"]
        self.assertTrue(179.9 < west < 180 < east < 180.1, (west, east))
        west_m, east_m = (WORLD_M / 180 * lon for lon in (west, east))
        width_m = east_m - west_m
        _, _, tiles, (_, in_the_west, _), (_, in_the_east, _), _, geotiff = self.session(
            f"http://127.0.0.1:{server.port}", ["choose", flight], ["go"], ["view"], ["click", 180 - 1e-5, (south + north) / 2],
            ["click", -180 + 1e-5, (south + north) / 2], ["add", "geotiff"], ["view"])
        # In Web Mercator tiles lie at both its ends: one of them is shown, not the whole world.
        self.assertLess(tiles[2] - tiles[0], 10 * width_m)
        self.assertLess(min(abs(abs(side) - WORLD_M) for side in tiles[0::2]), 10 * width_m)
        # The file is in one piece.
        self.assertLess(geotiff[2] - geotiff[0], 10 * width_m)
        self.assertTrue(geotiff[0] < west_m + 0.1 * width_m and geotiff[2] > east_m - 0.1 * width_m, geotiff)
        self.assertTrue(in_the_west and in_the_east)

    def test_a_folder_becomes_a_map(self):
        server = self.serve("--workers", "1", data=tempfile.mkdtemp(dir=self.scratch))
        before, is_bar_left, stopped, stages, rows, said, _, _ = self.session(
            f"http://127.0.0.1:{server.port}", ["said"], ["upload_and_cancel", str(self.folder), "Stopped"], ["said"],
            ["upload", str(self.folder), "Field 7"], ["rows"], ["said"], ["add", "tiles"], ["grab", "window.png"])
        self.assertIn("There are no flights yet", before[0])
        self.assertFalse(is_bar_left)
        self.assertEqual(len(stopped), 1)  # nothing went wrong
        self.assertIn("upload", stages)
        self.assertEqual(said[1:], ["The map of Field 7 is there."])
        window = self.gdal.Open(str(self.out / "window.png")).ReadAsArray()[:3].astype(int)
        self.assertGreater((window[1] - window[2] > 20).mean(), 0.2)  # green fields on the canvas
        self.assertEqual([(row[0], row[2]) for row in rows if row[0] == "Field 7"], [("Field 7", str(len(self.photos)))])
        _, flights = server.json("GET", "/api/v1/flights")
        self.assertEqual({flight["name"]: flight["state"] for flight in flights["flights"]}["Field 7"], "ready")

    def test_tokens_stay_where_they_belong(self):
        data = tempfile.mkdtemp(dir=self.scratch)
        token = add_token(data, "team", "--scope", "upload")
        server = self.serve("--workers", "1", data=data)
        url = f"http://127.0.0.1:{server.port}"
        refused, (is_closed, kept, is_readable), stages, layer, said, _, again, said_again, _, renewed = self.session(
            url, ["said"], ["token", token, True], ["upload", str(self.folder), "Field 8"], ["add", "geotiff"], ["said"],
            ["forget", None], ["add", "footprints"], ["said"], ["forget", "sq_share_gone"], ["add", "geotiff"])
        self.assertIn("token", refused[0])
        self.assertEqual((is_closed, kept, is_readable), (True, token, False))
        self.assertIn("upload", stages)
        # A layer's address, which a project keeps, reads this flight alone.
        self.assertTrue(layer[2])
        self.assertNotIn(token, layer[1])
        shared = layer[1].split("token=")[1]
        _, access = server.json("GET", "/api/v1/access", headers=bearer(shared))
        flight_id = layer[1].split("/flights/")[1].split("/")[0]
        self.assertEqual({"scope": "read", "flight": flight_id}.items() & access.items(), {"scope": "read", "flight": flight_id}.items())
        # It is said once, and taken by the project's other layers until it is revoked.
        self.assertIn("does not end by itself", said[-1])
        self.assertEqual((again[1].split("token=")[1], said_again[1:]), (shared, said[1:]))
        self.assertTrue(renewed[2])
        self.assertNotIn(renewed[1].split("token=")[1], (shared, "sq_share_gone"))
        # Where no more such can be made, none of the user's own takes its place.
        json_of = {**bearer(token), "Content-Type": "application/json"}
        made = [server.request("POST", f"/api/v1/flights/{flight_id}/shares", body=b"{}", headers=json_of)[0] for _ in range(100)]
        self.assertEqual(made[-1], 409)
        *_, said = self.session(url, ["token", token, False], ["choose", flight_id], ["ask", "geotiff"], ["said"])
        self.assertIn("shares already", said[-1])

    def test_a_server_that_is_away_is_said(self):
        rows, said = self.session("http://127.0.0.1:9", ["rows"], ["said"])
        self.assertEqual(rows, [])
        self.assertIn("Nothing answers at http://127.0.0.1:9", said[0])
