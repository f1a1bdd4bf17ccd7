"""The map through GIS programs: GDAL and QGIS read the server's tiles and get the pixels of the MBTiles."""
import contextlib
import json
import math
import pathlib
import sqlite3
import subprocess
import urllib.parse
import urllib.request
import xml.etree.ElementTree as xml_parser

import older_ogcapi
from gis_support import GDAL_XYZ, WORLD_M, GdalTestCase, MapFileTestCase
from npm_clients import installed_clients, script

class Gis(MapFileTestCase):
    def url(self):
        return f"http://127.0.0.1:{self.server.port}/tiles/{self.flight_id}/${{z}}/${{x}}/${{y}}.png"

    def test_gdal_reads_files_and_tiles_alike(self):
        _, _, west, north, pixel_m, side = self.inner_window()
        mbtiles = self.gdal.Open(str(self.path("mbtiles")))
        want = self.pixels(mbtiles, west, north, pixel_m, side)
        self.assertGreater(want.std(), 3.0)  # a picture, not a blank
        xml = GDAL_XYZ.format(url=self.url(), w=WORLD_M, zoom=self.tilejson["maxzoom"],
                              size=self.tilejson.get("tileSize", 256))
        self.assertEqual(int(abs(self.pixels(self.gdal.Open(xml), west, north, pixel_m, side).astype(int) - want).max()), 0)
        cog = self.pixels(self.gdal.Open(str(self.path("tif"))), west, north, pixel_m, side)
        self.assertLess(abs(cog.astype(int) - want).mean(), 2.0)

    def test_gdals_wmts_driver_reads_both_bindings(self):
        capabilities = self.address(f"/wmts/{self.flight_id}/1.0.0/WMTSCapabilities.xml")
        self.check_against_mbtiles(self.gdal.Open(f"WMTS:{capabilities},layer=map"))
        # Without ResourceURL the driver goes by parameters.
        _, _, xml = self.server.request("GET", f"/wmts/{self.flight_id}?SERVICE=WMTS&REQUEST=GetCapabilities")
        without = pathlib.Path(self.data, "kvp.xml")
        without.write_bytes(b"\n".join(line for line in xml.splitlines() if b"<ResourceURL" not in line))
        self.check_against_mbtiles(self.gdal.Open(f"WMTS:{without},layer=map"))

    def test_addresses_without_parameters_are_capabilities(self):
        wmts, wms = f"/wmts/{self.flight_id}", f"/wms/{self.flight_id}"
        text = self.server.request("GET", wmts)[2]
        self.assertLess(text.index(b"<Format>image/png"), text.index(b"<Format>image/jpeg"))  # the fringe is see-through
        for path, root in ((wmts, b"<Capabilities"), (wms, b"<WMS_Capabilities")):
            for query in ("", "?", "?request=", "?REQUEST=nonsense", "?SERVICE=WMS&REQUEST=GetCapabilities",
                          "?service=WMTS&request=getcapabilities"):
                self.assertIn(root, self.server.request("GET", path + query, code=200)[2], path + query)
        self.check_against_mbtiles(self.gdal.Open(f"WMTS:{self.address(wmts)}"))
        self.check_against_mbtiles(self.gdal.Open(self.address(wmts)))
        for source in (f"WMS:{self.address(wms)}", self.address(wms)):
            layers = self.gdal.Open(source).GetSubDatasets()
            self.assertIn("LAYERS=map", layers[0][0], source)
            west, _, _, north = self.tilejson["bounds"]
            left, _, _, top, _, _ = self.gdal.Open(layers[0][0]).GetGeoTransform()
            want = west / 180 * WORLD_M, math.asinh(math.tan(math.radians(north))) / math.pi * WORLD_M
            self.assertLess(abs(left - want[0]) + abs(top - want[1]), 0.01, source)

    def test_gdals_wms_driver_reads_both_versions(self):
        for version, crs in (("1.1.1", "SRS"), ("1.3.0", "CRS")):
            west, south, east, north, size_x, size_y = self.whole_window()
            xml = (f'<GDAL_WMS><Service name="WMS"><Version>{version}</Version><ServerUrl>{self.address("/wms/" + self.flight_id)}?'
                   f"</ServerUrl><{crs}>EPSG:3857</{crs}><ImageFormat>image/png</ImageFormat><Transparent>TRUE</Transparent>"
                   f"<Layers>map</Layers></Service><DataWindow><UpperLeftX>{west!r}</UpperLeftX><UpperLeftY>{north!r}</UpperLeftY>"
                   f"<LowerRightX>{east!r}</LowerRightX><LowerRightY>{south!r}</LowerRightY><SizeX>{size_x}</SizeX>"
                   f"<SizeY>{size_y}</SizeY></DataWindow><Projection>EPSG:3857</Projection><BandsCount>4</BandsCount></GDAL_WMS>")
            self.check_against_mbtiles(self.gdal.Open(xml))

    def test_gdals_tms_driver_reads_the_tile_map(self):
        xml = self.server.request("GET", f"/tms/1.0.0/{self.flight_id}")[2]
        self.assertIn(b"units-per-pixel", xml)
        xml = GDAL_XYZ.format(url=self.address(f"/tms/1.0.0/{self.flight_id}/${{z}}/${{x}}/${{y}}.png"), w=WORLD_M,
                              zoom=self.tilejson["maxzoom"], size=self.tilejson.get("tileSize", 256))
        xml = xml.replace("<YOrigin>top</YOrigin>", "<YOrigin>bottom</YOrigin>")
        self.check_against_mbtiles(self.gdal.Open(xml))
        # By the address alone: every zoom from 0 on, of the world.
        self.check_against_mbtiles(self.gdal.Open(self.address(f"/tms/1.0.0/{self.flight_id}")))
        tile_map = xml_parser.fromstring(self.server.request("GET", f"/tms/1.0.0/{self.flight_id}")[2])
        sets = tile_map.findall("TileSets/TileSet")
        self.assertEqual([int(one.get("order")) for one in sets], list(range(self.tilejson["maxzoom"] + 1)))
        maps = self.gdal.Open(self.address("/tms/1.0.0")).GetSubDatasets()
        self.assertEqual(maps[0][0], self.address(f"/tms/1.0.0/{self.flight_id}"))
        for tile in ("0/0/0", "5/0/0", f"{self.tilejson['maxzoom']}/0/0"):
            self.assertEqual(self.server.request("GET", f"/tms/1.0.0/{self.flight_id}/{tile}.png")[0], 200, tile)

    def test_a_token_is_in_every_address_of_the_tile_map(self):
        tile_map = xml_parser.fromstring(self.server.request("GET", f"/tms/1.0.0/{self.flight_id}?token=abc")[2])
        self.assertEqual(tile_map.find("TileFormat").get("extension"), "png?token=abc")
        self.assertIn(b"?token=abc", self.server.request("GET", "/tms/1.0.0?token=abc")[2])

    def test_gdal_opens_the_arcgis_map_service(self):
        _, info = self.server.json("GET", "/arcgis/rest/info?f=json")
        self.assertEqual(info["authInfo"], {"isTokenBasedSecurity": False})
        _, services = self.server.json("GET", "/arcgis/rest/services?f=json")
        self.assertEqual(services["currentVersion"], info["currentVersion"])
        self.assertEqual(services["services"], [{"name": self.flight_id, "type": "MapServer"}])
        path = f"/arcgis/rest/services/{self.flight_id}/MapServer"
        self.check_against_mbtiles(self.gdal.Open(self.address(path + "?f=json")))
        status, layer = self.server.json("GET", path + "/0?f=pjson")
        _, described = self.server.json("GET", path)
        self.assertEqual((status, layer["id"], layer["extent"]), (200, described["layers"][0]["id"], described["fullExtent"]))
        self.assertEqual(layer["extent"]["spatialReference"], {"wkid": 102100, "latestWkid": 3857})
        self.assertEqual(self.server.json("GET", path + "/layers?f=json"), (200, {"layers": [layer], "tables": []}))
        status, legend = self.server.json("GET", path + "/legend?f=pjson")
        self.assertEqual((status, [(each["layerId"], each["legend"]) for each in legend["layers"]]), (200, [(0, [])]))
        self.assertEqual(self.server.request("GET", path + "?f=kmz")[0], 400)
        self.assertEqual(self.server.request("GET", path + "/identify?f=json")[0], 404)

    def test_gdals_ogcapi_driver_reads_the_collection(self):
        collection, options = f"/ogc/collections/{self.flight_id}", ["API=TILES", "TILEMATRIXSET=WebMercatorQuad"]
        if int(self.gdal.VersionInfo()) >= older_ogcapi.DRIVER_MENDED_IN:
            self.check_against_mbtiles(self.gdal.OpenEx(f"OGCAPI:{self.address(collection)}", open_options=options))
            return
        west, south, east, north, *_ = self.whole_window()
        options += [f"TILEMATRIX={self.tilejson['maxzoom']}", f"MINX={west!r}", f"MINY={south!r}", f"MAXX={east!r}", f"MAXY={north!r}"]
        with older_ogcapi.widened_limits(self.server.port) as port:
            self.check_against_mbtiles(self.gdal.OpenEx(f"OGCAPI:http://127.0.0.1:{port}{collection}", open_options=options))

    def test_the_files_to_connect_open(self):
        _, _, xml = self.server.request("GET", f"/connect/{self.flight_id}/gdal.xml")
        self.check_against_mbtiles(self.gdal.Open(xml.decode()))
        service = self.server.json("GET", f"/connect/{self.flight_id}/arcgis.json")[1]["operationalLayers"][0]["url"]
        self.assertEqual(self.server.json("GET", service.removeprefix(self.address("")), code=200)[1]["tileInfo"]["lods"][-1]["level"], self.tilejson["maxzoom"])
        for file in ("josm.xml", "qgis.qlr"):
            xml = self.server.request("GET", f"/connect/{self.flight_id}/{file}")[2]
            xml_parser.fromstring(xml)

    def test_the_stac_item_leads_to_all_there_is(self):
        _, headers, body = self.server.request("GET", f"/stac/{self.flight_id}")
        item = json.loads(body)
        self.assertEqual((headers["Content-Type"], item["type"], item["stac_version"]), ("application/geo+json", "Feature", "1.0.0"))
        west, south, east, north = item["bbox"]
        ring = item["geometry"]["coordinates"][0]
        self.assertEqual((ring[0], {tuple(corner) for corner in ring}),
                         (ring[-1], {(west, south), (east, south), (east, north), (west, north)}))
        told = item["properties"]
        _, photos = self.server.json("GET", f"/api/v1/flights/{self.flight_id}/photos.geojson")
        times = sorted(photo["properties"]["captured_at"][:19] + "Z" for photo in photos["features"])
        self.assertEqual((told["datetime"], told["start_datetime"], told["end_datetime"]), (times[0], times[0], times[-1]))
        for asset in item["assets"].values():
            status, headers, _ = self.server.request("HEAD", asset["href"].removeprefix(self.address("")))
            self.assertEqual((status, headers["Content-Type"]), (200, asset["type"]), asset)
            self.assertTrue(asset["roles"])
        links = {link["rel"]: link["href"].removeprefix(self.address("")) for link in item["links"]}
        self.assertLessEqual({"self", "xyz", "tilejson", "wmts", "wms", "pmtiles"}, set(links))
        for rel in links.keys() - {"xyz", "wms"}:  # which are templates
            self.assertEqual(self.server.request("HEAD", links[rel])[0], 200, rel)

    def test_owslib_reads_the_capabilities(self):
        of_wms, of_wmts = self.imported("python3-owslib is not here", "owslib.wms", "owslib.wmts")
        wmts = of_wmts.WebMapTileService(self.address(f"/wmts/{self.flight_id}/1.0.0/WMTSCapabilities.xml"))
        set_name = list(wmts.tilematrixsets)[0]
        column, row, *_ = self.inner_window()
        tile = wmts.gettile(layer="map", tilematrixset=set_name, tilematrix=str(self.tilejson["maxzoom"]), row=row,
                            column=column, format="image/png")
        self.assertTrue(tile.read().startswith(b"\x89PNG"))
        for version in ("1.1.1", "1.3.0"):
            wms = of_wms.WebMapService(self.address(f"/wms/{self.flight_id}"), version=version)
            self.assertEqual(list(wms.contents), ["map"])
            box = wms["map"].boundingBoxWGS84
            for ours, theirs in zip(self.tilejson["bounds"], box):
                self.assertAlmostEqual(ours, theirs, places=6)
            picture = wms.getmap(layers=["map"], srs="EPSG:4326", bbox=box, size=(300, 200), format="image/png")
            self.assertTrue(picture.read().startswith(b"\x89PNG"))

    def test_owslib_reads_all_maps_at_one_address(self):
        of_wms, of_wmts = self.imported("python3-owslib is not here", "owslib.wms", "owslib.wmts")
        wmts = of_wmts.WebMapTileService(self.address("/wmts"))
        self.assertIn(self.flight_id, wmts.contents)
        column, row, *_ = self.inner_window()
        tile = wmts.gettile(layer=self.flight_id, tilematrixset="WebMercatorQuad", tilematrix=str(self.tilejson["maxzoom"]), row=row,
                            column=column, format="image/png")
        self.assertTrue(tile.read().startswith(b"\x89PNG"))
        for version in ("1.1.1", "1.3.0"):
            wms = of_wms.WebMapService(self.address("/wms"), version=version)
            self.assertIn(self.flight_id, wms.contents)
            box = wms[self.flight_id].boundingBoxWGS84
            asked = {"layers": [self.flight_id], "srs": "EPSG:4326", "bbox": box, "size": (300, 200), "format": "image/png"}
            self.assertTrue(wms.getmap(**asked).read().startswith(b"\x89PNG"))
            told = wms.getfeatureinfo(**asked, query_layers=[self.flight_id], info_format="application/json", xy=(150, 100))
            seen = json.loads(told.read())["features"][0]["properties"]
            self.assertLessEqual({"red", "green", "blue", "height_m", "photo"}, set(seen))

    def test_gdal_and_qgis_read_all_maps_at_one_address(self):
        self.check_against_mbtiles(self.gdal.Open(f"WMTS:{self.address('/wmts')},layer={self.flight_id}"))
        layers = self.gdal.Open(f"WMS:{self.address('/wms')}").GetSubDatasets()
        self.assertIn(f"LAYERS={self.flight_id}", "".join(layer[0] for layer in layers))
        capabilities = urllib.parse.quote(self.address("/wmts") + "?SERVICE=WMTS&REQUEST=GetCapabilities", safe="")
        self.check_qgis([f"crs=EPSG:3857&format=image/png&layers={self.flight_id}&styles=default&tileMatrixSet=WebMercatorQuad&url={capabilities}"])

    def test_gdal_and_owslib_read_photos_as_features(self):
        from osgeo import ogr
        for kind, geometry in (("photos", ogr.wkbPoint), ("footprints", ogr.wkbPolygon)):
            collection = f"{self.flight_id}.{kind}"
            dataset = self.gdal.OpenEx(f"OAPIF:{self.address('/ogc')}", self.gdal.OF_VECTOR)
            layer = dataset.GetLayerByName(collection)
            self.assertEqual(layer.GetFeatureCount(), self.photo_count)
            feature = layer.GetNextFeature()
            self.assertEqual(feature.GetGeometryRef().GetGeometryType(), geometry)
            layer.SetSpatialFilterRect(0, 0, 1, 1)
            self.assertEqual(layer.GetFeatureCount(), 0)
        try:
            from owslib.ogcapi.features import Features
        except ImportError:
            return
        features = Features(self.address("/ogc"))
        self.assertIn(f"{self.flight_id}.photos", features.feature_collections())
        page = features.collection_items(f"{self.flight_id}.photos", limit=2)
        self.assertEqual((page["numberReturned"], page["numberMatched"]), (2, self.photo_count))

    def test_a_place_tells_its_photo_and_an_area_its_figures(self):
        west, south, east, north = self.tilejson["bounds"]
        lon, lat = (west + east) / 2, (south + north) / 2
        _, point = self.server.json("GET", f"/api/v1/flights/{self.flight_id}/point?lon={lon}&lat={lat}", code=200)
        _, seen = self.server.json("GET", f"/api/v1/flights/{self.flight_id}/at?lon={lon}&lat={lat}")
        self.assertEqual(point["photo"]["name"], seen["photos"][0]["name"])
        mbtiles = self.gdal.Open(str(self.path("mbtiles")))
        left, pixel_m, _, top, _, _ = mbtiles.GetGeoTransform()
        x, y = lon / 180 * WORLD_M, math.asinh(math.tan(math.radians(lat))) / math.pi * WORLD_M
        want = mbtiles.ReadAsArray(int((x - left) / pixel_m), int((top - y) / pixel_m), 1, 1)[:3, 0, 0]
        self.assertEqual([point["colour"][name] for name in ("red", "green", "blue")], [int(value) for value in want])
        ring = [[west, south], [east, south], [east, north], [west, north], [west, south]]
        _, told = self.server.json("POST", f"/api/v1/flights/{self.flight_id}/statistics", {"type": "Polygon", "coordinates": [ring]}, code=200)
        pixels = mbtiles.ReadAsArray()
        shown = pixels[3] >= 128
        self.assertEqual((told["zoom"], told["pixels"]), (self.tilejson["maxzoom"], int(shown.sum())))
        for band, values in zip(told["bands"], pixels):
            self.assertAlmostEqual(band["mean"], float(values[shown].mean()), places=6)
            self.assertEqual((band["min"], band["max"]), (int(values[shown].min()), int(values[shown].max())))

    def test_stac_finds_the_map(self):
        west, south, east, north = self.tilejson["bounds"]
        status, found = self.server.json("POST", "/stac/search", {"bbox": [west, south, east, north], "limit": 1})
        self.assertEqual((status, len(found["features"])), (200, 1))
        _, item = self.server.json("GET", f"/stac/{self.flight_id}")
        self.assertEqual(found["features"][0], item)
        at = urllib.parse.quote(item["properties"]["datetime"])
        self.assertEqual(self.server.json("GET", f"/stac/search?datetime={at}")[1]["numberReturned"], 1)
        self.assertEqual(self.server.json("GET", "/stac/search?bbox=0,0,1,1")[1]["numberReturned"], 0)

    def test_openlayers_reads_the_capabilities(self):
        clients = installed_clients()
        if clients is None:
            self.skipTest("npm's OpenLayers cannot be had")
        column, row, west, north, pixel_m, side = self.inner_window(1)
        zoom = self.tilejson["maxzoom"]
        lon = math.degrees((west + pixel_m * side / 2) / WORLD_M * math.pi)
        lat = math.degrees(math.atan(math.sinh((north - pixel_m * side / 2) / WORLD_M * math.pi)))
        capabilities = {"KVP": f"/wmts/{self.flight_id}?SERVICE=WMTS&REQUEST=GetCapabilities",
                        "REST": f"/wmts/{self.flight_id}/1.0.0/WMTSCapabilities.xml"}
        for encoding, path in capabilities.items():
            done = subprocess.run(["node", script(clients, "openlayers_wmts.mjs"), self.address(path), "map", encoding, str(lon), str(lat),
                                   str(zoom)], capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stderr)
            found = json.loads(done.stdout)
            self.assertEqual((found["column"], found["row"]), (column, row))
            self.assertAlmostEqual(found["resolution_m"], pixel_m, delta=pixel_m * 1e-6)
            with urllib.request.urlopen(found["url"]) as answer:
                kind = answer.headers["Content-Type"].removeprefix("image/")
                want = self.server.request("GET", f"/tiles/{self.flight_id}/{zoom}/{column}/{row}.{kind}")[2]
                self.assertEqual(answer.read(), want, encoding)

    def test_the_versions_of_wms_agree_on_where_north_is(self):
        west, south, east, north = self.tilejson["bounds"]
        base = f"/wms/{self.flight_id}?SERVICE=WMS&REQUEST=GetMap&LAYERS=map&STYLES=&FORMAT=image/png&WIDTH=200&HEIGHT=150&TRANSPARENT=TRUE"
        old = self.server.request("GET", f"{base}&VERSION=1.1.1&SRS=EPSG:4326&BBOX={west},{south},{east},{north}")[2]
        new = self.server.request("GET", f"{base}&VERSION=1.3.0&CRS=EPSG:4326&BBOX={south},{west},{north},{east}")[2]
        same = self.server.request("GET", f"{base}&VERSION=1.3.0&CRS=CRS:84&BBOX={west},{south},{east},{north}")[2]
        self.assertEqual(old, new)
        self.assertEqual(old, same)

    def test_double_tiles_are_made_of_the_four_below(self):
        column, row, west, north, pixel_m, _ = self.inner_window()
        zoom, size = self.tilejson["maxzoom"], self.tilejson.get("tileSize", 256)
        column, row = column // 2, row // 2
        _, headers, png = self.server.request("GET", f"/tiles/{self.flight_id}/{zoom - 1}/{column}/{row}@2x.png")
        self.assertEqual(headers["Content-Type"], "image/png")
        path = pathlib.Path(self.data, "double.png")
        path.write_bytes(png)
        got = self.gdal.Open(str(path)).ReadAsArray()[:3]
        self.assertEqual(got.shape, (3, 2 * size, 2 * size))
        tile_m = 2 * WORLD_M / 2 ** (zoom - 1)
        want = self.pixels(self.gdal.Open(str(self.path("mbtiles"))), column * tile_m - WORLD_M, WORLD_M - row * tile_m,
                           pixel_m, 2 * size)
        self.assertEqual(int(abs(got.astype(int) - want).max()), 0)

    def test_every_refusal_of_the_standards_is_said_their_way(self):
        wmts, wms = f"/wmts/{self.flight_id}", f"/wms/{self.flight_id}"
        for path, status, word in ((wmts + "?request=GetMap", 501, b"OperationNotSupported"),
                                   (wmts + "?request=GetTile&version=2", 400, b"InvalidParameterValue"),
                                   (wmts + "?request=GetFeatureInfo", 400, b"MissingParameterValue"),
                                   (wmts + "?request=GetTile&layer=map", 400, b"MissingParameterValue"),
                                   (wmts + "/map/default/WebMercatorQuad/1/9/9.png", 400, b"TileOutOfRange"),
                                   (wmts + "/other/default/WebMercatorQuad/1/0/0.png", 404, b"NotFound"),
                                   ("/wmts/nobody?request=GetCapabilities", 404, b"NotFound"),
                                   (wms + "?request=GetTile", 400, b"OperationNotSupported"), (wms + "?request=GetMap", 400, b"LayerNotDefined"),
                                   (wms + "?request=GetMap&layers=map&crs=EPSG:4326&bbox=1,2,3,4&width=100000&height=100000&format=image/png",
                                    400, b"WIDTH"),
                                   (wms + "?request=GetMap&layers=map&crs=EPSG:1&bbox=1,2,3,4&width=1&height=1", 400, b"InvalidCRS"),
                                   (wms + "?request=GetMap&layers=map&crs=CRS:84&bbox=1,2,nan,4&width=1&height=1", 400, b"BBOX")):
            got, _, body = self.server.request("GET", path)
            self.assertEqual(got, status, path)
            self.assertIn(word, body, path)

    def test_a_photos_pixel_and_its_place_find_each_other(self):
        west, south, east, north = self.tilejson["bounds"]
        lon, lat = (west + east) / 2, (south + north) / 2
        _, seen = self.server.json("GET", f"/api/v1/flights/{self.flight_id}/at?lon={lon}&lat={lat}", code=200)
        self.assertTrue(seen["photos"])
        for photo in seen["photos"]:
            path = f"/api/v1/flights/{self.flight_id}/photos/{photo['name']}/ground?x={photo['x']}&y={photo['y']}"
            _, ground = self.server.json("GET", path, code=200)
            self.assertAlmostEqual(ground["lon"], lon, places=8)
            self.assertAlmostEqual(ground["lat"], lat, places=8)
        self.assertEqual(self.server.json("GET", f"/api/v1/flights/{self.flight_id}/at?lon=x&lat=1")[0], 400)
        self.assertEqual(self.server.json("GET", f"/api/v1/flights/{self.flight_id}/photos/no/ground?x=1&y=1")[0], 404)

    def test_gdal_translate_cuts_a_piece_of_the_mbtiles(self):
        out = pathlib.Path(self.data, "piece.png")
        subprocess.run(["gdal_translate", "-q", "-srcwin", "100", "100", "200", "150", self.path("mbtiles"), out], check=True)
        self.assertEqual((self.gdal.Open(str(out)).RasterXSize, self.gdal.Open(str(out)).RasterYSize), (200, 150))
        described = json.loads(subprocess.run(["gdalinfo", "-json", self.path("mbtiles")], check=True,
                                              capture_output=True).stdout)
        self.assertIn('"EPSG",3857', described["coordinateSystem"]["wkt"].replace(" ", ""))

    def test_gdal_reads_the_webp_at_the_edge_of_the_mbtiles(self):
        """Tiles of JPEG and of WebP in one file: each is what it is by itself, alpha and all."""
        zoom, size = self.tilejson["maxzoom"], self.tilejson.get("tileSize", 256)
        dataset = self.gdal.Open(str(self.path("mbtiles")))
        west, pixel_m, _, north, _, _ = dataset.GetGeoTransform()
        tile_m, compared = 2 * WORLD_M / 2**zoom, 0
        with contextlib.closing(sqlite3.connect(self.path("mbtiles"))) as mbtiles:
            self.assertEqual(dict(mbtiles.execute("SELECT name, value FROM metadata WHERE name IN ('format', 'fringe')")),
                             {"format": "webp", "fringe": "webp"})
            # Strict servers take these for the format of all.
            self.assertEqual({bytes(mbtiles.execute(f"SELECT tile_data FROM tiles {where} LIMIT 1").fetchone()[0])[8:12]
                              for where in ("", *(f"WHERE zoom_level={z}" for z in range(self.tilejson["minzoom"], zoom + 1)))}, {b"WEBP"})
            rows = mbtiles.execute("SELECT tile_column, tile_row, tile_data FROM tiles WHERE zoom_level=?", (zoom,)).fetchall()
        self.assertEqual({content[:4] for *_, content in rows}, {b"\xff\xd8\xff\xe0", b"RIFF"})
        for column, row, content in rows:
            if not content.startswith(b"RIFF"):
                continue
            left = round((column * tile_m - WORLD_M - west) / pixel_m)
            top = round((north - WORLD_M + (2**zoom - 1 - row) * tile_m) / pixel_m)
            x, y = max(0, left), max(0, top)
            width, height = min(left + size, dataset.RasterXSize) - x, min(top + size, dataset.RasterYSize) - y
            if width <= 0 or height <= 0:
                continue
            self.gdal.FileFromMemBuffer("/vsimem/tile.webp", content)
            want = self.gdal.Open("/vsimem/tile.webp").ReadAsArray()[:, y - top:y - top + height, x - left:x - left + width]
            got = dataset.ReadAsArray(x, y, width, height)
            self.assertTrue((got[3] == want[3]).all(), (column, row))
            self.assertTrue((got[:3] == want[:3])[:, want[3] > 0].all(), (column, row))
            compared += 1
        self.assertGreater(compared, 5)

    def test_the_edge_is_webp_for_those_who_name_it_and_png_for_others(self):
        zoom = self.tilejson["maxzoom"]
        with contextlib.closing(sqlite3.connect(self.path("mbtiles"))) as mbtiles:
            column, row, stored = mbtiles.execute(
                "SELECT tile_column, tile_row, tile_data FROM tiles WHERE zoom_level=? AND substr(tile_data, 1, 4)=x'52494646'", (zoom,)).fetchone()
        address = f"/tiles/{self.flight_id}/{zoom}/{column}/{2**zoom - 1 - row}"
        for accept in ("image/webp,*/*", "image/avif,image/webp,image/apng,image/svg+xml,image/*,*/*;q=0.8"):
            status, headers, content = self.server.request("GET", address, headers={"Accept": accept})
            self.assertEqual((status, headers["Content-Type"], content), (200, "image/webp", stored))
        for headers in ({}, {"Accept": "*/*"}, {"Accept": "text/html, image/png, image/jpeg, image/gif, */*"}):
            status, headers, content = self.server.request("GET", address, headers=headers)
            self.assertEqual((status, headers["Content-Type"], content[:4], headers["Vary"]), (200, "image/png", b"\x89PNG", "Accept"))

    def test_qgis_shows_the_map_pixel_for_pixel(self):
        zoom, layer = self.tilejson["maxzoom"], "layers=map&format=image/png&crs=EPSG:3857"
        quoted = lambda url: urllib.parse.quote(url, safe="")
        wmts, wms = (self.address(f"/{service}/{self.flight_id}") for service in ("wmts", "wms"))
        sources = [f"type=xyz&zmin={zoom}&zmax={zoom}&url={quoted(self.url().replace('$', ''))}",
                   f"{layer}&styles=default&tileMatrixSet=WebMercatorQuad&url={quoted(wmts + '?SERVICE=WMTS&REQUEST=GetCapabilities')}",
                   f"{layer}&styles=default&tileMatrixSet=WebMercatorQuad&url={quoted(wmts + '/1.0.0/WMTSCapabilities.xml')}",
                   f"{layer}&styles=&url={quoted(wms)}", f"{layer}&styles=&IgnoreGetMapUrl=1&url={quoted(wms + '?VERSION=1.1.1')}"]
        self.check_qgis(sources)

    def test_qgis_zooms_to_the_layer_of_the_file(self):
        self.check_qgis_zooms_to(self.server.request("GET", f"/connect/{self.flight_id}/qgis.qlr")[2])


class LargeTiles(GdalTestCase):
    """A map of 512-pixel tiles through programs that take 256 for granted: the same pixels at the same places."""
    photo_count, options = 2, {"gsd_m": 0.014}

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        assert (cls.tilejson["tileSize"], cls.tilejson["maxzoom"]) == (512, 22), cls.tilejson
        west, south, east, north = cls.tilejson["bounds"]
        tile_m = 2 * WORLD_M / 2**22
        cls.column = int(((west + east) / 360 * WORLD_M + WORLD_M) / tile_m)
        lat = math.radians((south + north) / 2)
        cls.row = int((WORLD_M - math.asinh(math.tan(lat)) / math.pi * WORLD_M) / tile_m)

    def picture(self, path):
        _, _, content = self.server.request("GET", path, code=200)
        file = pathlib.Path(self.data, "tile")
        file.write_bytes(content)
        return self.gdal.Open(str(file)).ReadAsArray()[:3].astype(int)

    def stored(self):
        return self.picture(f"/tiles/{self.flight_id}/22/{self.column}/{self.row}.png")

    def check_alike(self, got, want, what, edge=1):
        """JPEG's coarser colours look across a tile's edge, which a piece of it cannot: there alone it may differ."""
        self.assertEqual(got.shape, want.shape, what)
        self.assertEqual((int(abs(got - want)[:, edge:-edge, edge:-edge].max()), float(want.std()) > 1.0), (0, True), what)

    def test_every_endpoint_has_the_quarters(self):
        whole, column, row = self.stored(), 2 * self.column, 2 * self.row
        for right in (0, 1):
            for below in (0, 1):
                x, y = column + right, row + below
                want = whole[:, 256 * below:256 * below + 256, 256 * right:256 * right + 256]
                for path in (f"/tiles/{self.flight_id}/256/23/{x}/{y}", f"/tms/1.0.0/{self.flight_id}/23/{x}/{2**23 - 1 - y}.png",
                             f"/wmts/{self.flight_id}/map/default/WebMercatorQuad/23/{y}/{x}.png",
                             f"/arcgis/rest/services/{self.flight_id}/MapServer/tile/23/{y}/{x}",
                             f"/ogc/collections/{self.flight_id}/map/tiles/WebMercatorQuad/23/{y}/{x}"):
                    self.check_alike(self.picture(path), want, path)

    def test_the_stored_size_stays_to_be_had(self):
        whole, x, y = self.stored(), self.column, self.row
        for path in (f"/tms/1.0.0/{self.flight_id}/512/22/{x}/{2**22 - 1 - y}.png",
                     f"/wmts/{self.flight_id}/map/default/WebMercatorQuad512/22/{y}/{x}.png",
                     f"/ogc/collections/{self.flight_id}/map/tiles/WebMercatorQuad512/22/{y}/{x}",
                     f"/tiles/{self.flight_id}/256/22/{x}/{y}@2x.png"):
            self.check_alike(self.picture(path), whole, path)

    def read(self, source, side):
        """The stored tile's square as a dataset has it, of `side` pixels."""
        dataset = self.gdal.Open(source)
        left, pixel_m, _, top, _, _ = dataset.GetGeoTransform()
        tile_m = 2 * WORLD_M / 2**22
        self.assertAlmostEqual(pixel_m * side / tile_m, 1.0, places=6, msg=source)
        x = round((self.column * tile_m - WORLD_M - left) / pixel_m)
        y = round((top - (WORLD_M - self.row * tile_m)) / pixel_m)
        return dataset.ReadAsArray(x, y, side, side)[:3].astype(int)

    def test_gdal_finds_the_pixels_at_their_places(self):
        whole, wmts = self.stored(), f"WMTS:{self.address(f'/wmts/{self.flight_id}')}"
        for source in (wmts, wmts + ",layer=map,tilematrixset=WebMercatorQuad512"):
            got = self.read(source, 512)
            self.assertLess(abs(got - whole).mean(), 0.05, source)
        # A world of 23 zooms has more pixels than GDAL counts: it leaves the last one out.
        for source in (self.address(f"/tms/1.0.0/{self.flight_id}"),
                       self.address(f"/arcgis/rest/services/{self.flight_id}/MapServer?f=json")):
            got = self.read(source, 256)
            self.assertLess(abs(got - whole.reshape(3, 256, 2, 256, 2).mean(axis=(2, 4))).mean(), 4.0, source)

    def test_documents_name_256_first(self):
        xml = self.server.request("GET", f"/wmts/{self.flight_id}")[2].decode()
        first, second = (xml.index(f"<TileMatrixSet>{name}</TileMatrixSet>") for name in ("WebMercatorQuad", "WebMercatorQuad512"))
        self.assertLess(first, second)
        _, tilesets = self.server.json("GET", f"/ogc/collections/{self.flight_id}/map/tiles")
        self.assertEqual([one["links"][0]["href"].rsplit("/", 1)[1] for one in tilesets["tilesets"]][:3],
                         ["WebMercatorQuad", "WebMercatorQuad512", "WorldCRS84Quad"])
        _, quad = self.server.json("GET", f"/ogc/collections/{self.flight_id}/map/tiles/WebMercatorQuad")
        self.assertEqual(quad["tileMatrixSetLimits"][-1]["tileMatrix"], "23")
        maps = self.server.request("GET", "/tms/1.0.0")[2].decode()
        self.assertLess(maps.index(f'{self.flight_id}"'), maps.index(f'{self.flight_id}/512"'))
