"""The layers beside a map: asked for by a job's options, served as tilesets of their own, explained by layers.json."""
import json
import pathlib
import sqlite3
import tempfile

from server_support import ServerTestCase, middle_of, path_of

LAYERS = ["photo", "error", "height"]


class Layers(ServerTestCase):
    def map_of(self, server, options):
        return server.stitched(self.photos, options=json.dumps(options))["flight"]["id"]

    def test_each_is_a_tileset_of_its_own(self):
        server = self.serve()
        flight_id = self.map_of(server, {"layers": LAYERS})
        _, tilejson = server.json("GET", f"/tiles/{flight_id}.json")
        self.assertEqual([layer["id"] for layer in tilejson["layers"]], LAYERS)
        for layer in tilejson["layers"]:
            _, document = server.json("GET", path_of(layer["tilejson"]), code=200)
            self.assertEqual(document["bounds"], tilejson["bounds"])
            self.assertLess(document["maxzoom"], tilejson["maxzoom"])
            self.assertEqual(document.get("encoding"), "terrarium" if layer["id"] == "height" else None)
            zoom = document["maxzoom"]
            x, y = middle_of(tilejson["bounds"], zoom)
            url = path_of(document["tiles"][0].format(z=zoom, x=x, y=y))
            status, headers, tile = server.request("GET", url)
            self.assertEqual((status, headers["Content-Type"]), (200, "image/png"))
            self.assertIn("immutable", headers["Cache-Control"])
            self.assertEqual(server.request("GET", url, headers={"If-None-Match": headers["ETag"]})[0], 304)

            _, headers, file = server.request("GET", f"/api/v1/flights/{flight_id}/layer_{layer['id']}.mbtiles", code=200)
            with tempfile.TemporaryDirectory() as folder:
                path = pathlib.Path(folder, "layer.mbtiles")
                path.write_bytes(file)
                with sqlite3.connect(path) as layer_file:
                    found = layer_file.execute(
                        "SELECT tile_data FROM tiles WHERE zoom_level = ? AND tile_column = ? AND tile_row = ?",
                        (zoom, x, 2 ** zoom - 1 - y)).fetchone()
            self.assertEqual(bytes(found[0]), tile)
        _, legends = server.json("GET", f"/api/v1/flights/{flight_id}/layers.json")
        self.assertEqual(sorted(legends), sorted(LAYERS))
        self.assertEqual(sorted(entry["photo"] for entry in legends["photo"]["colours"]),
                         sorted(name for name, _ in self.photos))
        least_m, most_m = legends["height"]["range_m"]
        self.assertLessEqual(least_m, most_m)
        self.assertEqual(server.request("GET", f"/api/v1/flights/{flight_id}/thumbnail.png")[2][:4], b"\x89PNG")
        self.assertEqual(server.request("GET", f"/api/v1/flights/{flight_id}/thumbnail.webp?size=160")[2][8:12], b"WEBP")

    def test_a_map_without_them_says_how_to_get_them(self):
        server = self.serve()
        flight_id = self.map_of(server, {"layers": ["error"]})
        _, tilejson = server.json("GET", f"/tiles/{flight_id}.json")
        self.assertEqual([layer["id"] for layer in tilejson["layers"]], ["error"])
        self.assertIn('"layers": ["height"]', server.json("GET", f"/tiles/{flight_id}/height.json", code=404)[1]["detail"])
        for path in (f"/tiles/{flight_id}/depth.json", f"/tiles/{flight_id}/depth/1/0/0", f"/tiles/{flight_id}/error",
                     f"/tiles/{flight_id}/height/1/0/0"):
            self.assertEqual(server.request("GET", path)[0], 404, path)
        for path in (f"/tiles/{flight_id}/error/1/0/0.jpg", f"/tiles/{flight_id}/error/1/0/0@2x.png",
                     f"/tiles/{flight_id}/error/1/0/x"):
            self.assertEqual(server.request("GET", path)[0], 400, path)

    def test_what_is_no_list_of_layers_is_refused(self):
        server = self.serve()
        for layers in ("photo", ["photo", "photo"], ["depth"], [1], {"photo": True}):
            self.assertIn("layers", server.upload(self.photos[:1], options=json.dumps({"layers": layers}), code=422)[1]["detail"])
