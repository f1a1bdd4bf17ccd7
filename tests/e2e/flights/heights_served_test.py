"""Heights that a job is asked for: the files of `stitch --formats dtm`, offered for download, kept when the map is moved, and in
the archive of a processing node's task."""
import io
import json
import math
import os
import subprocess
import sys
import zipfile

from clients.gis_support import has_qgis
from program import ScratchCase, run
from server_support import FORM, Server, form, photos_in

OF_GROUND = ["dtm.tif", "dtm_ground.tif", "contours.gpkg", "contours.geojson", "contours.dxf"]
OF_SURFACE = ["dsm.tif", "dsm_photos.tif", "dsm_hillshade.tif"]

QGIS_HEIGHTS_SCRIPT = r"""
import json
import sys
from qgis.core import QgsApplication, QgsRaster, QgsRasterLayer, QgsVectorLayer
dsm, dtm, *contours = sys.argv[1:]
application = QgsApplication([], False)
application.initQgis()
surface, ground = (QgsRasterLayer(source, "heights") for source in (dsm, dtm))
assert surface.isValid() and ground.isValid(), (surface.error().message(), ground.error().message())
extent = surface.extent()
values = []
for row in range(1, 10):
    for column in range(1, 10):
        place = extent.center()
        place.setX(extent.xMinimum() + extent.width() * column / 10)
        place.setY(extent.yMinimum() + extent.height() * row / 10)
        values.append([place.x(), place.y(), *(layer.dataProvider().identify(place, QgsRaster.IdentifyFormatValue).results().get(1)
                                               for layer in (surface, ground))])
lines = [QgsVectorLayer(source, "contours", "ogr") for source in contours]
assert all(layer.isValid() for layer in lines)
invalid = sum(not feature.geometry().isGeosValid() for layer in lines for feature in layer.getFeatures())
print(json.dumps({"system": surface.crs().authid(), "values": values, "lines": [layer.featureCount() for layer in lines],
                  "systems": [layer.crs().authid() for layer in lines], "invalid": invalid}))
"""


# The path of the finest tile of a place (longitude, latitude), and where in it that lies: column and row.
def tile_at(tilejson, place):
    lon, lat = place
    n = 2 ** tilejson["maxzoom"]
    x, y = (lon + 180) / 360 * n, (1 - math.asinh(math.tan(math.radians(lat))) / math.pi) / 2 * n
    address = tilejson["tiles"][0].replace("{z}", str(tilejson["maxzoom"])).replace("{x}", str(int(x))).replace("{y}", str(int(y)))
    return address[address.index("/tiles/"):], (int(x % 1 * 256), int(y % 1 * 256))


def pixel(tile, at):
    from osgeo import gdal
    gdal.FileFromMemBuffer("/vsimem/tile.png", tile)
    return [int(band[at[1], at[0]]) for band in gdal.Open("/vsimem/tile.png").ReadAsArray()]


class HeightsServed(ScratchCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        flight = cls.scratch / "flight"
        run("simulate", "-o", flight, "--photos", "6", "--size", "400x300", "--height", "40", "--houses", "2", "--relief-m", "3",
            "--noise", "rtk", "--seed", "3", "--no-world", "--sidelap", "0.75")
        cls.photos = flight / "photos"
        cls.files = photos_in(cls.photos)
        cls.server = Server(cls.scratch / "data")
        cls.addClassCleanup(cls.server.stop)
        made = cls.server.stitched(cls.files, name="Village", options=json.dumps({"heights": "dtm"}))
        cls.job = made["job"]
        cls.path = f"/api/v1/flights/{made['flight']['id']}"
        cls.served = {name: cls.server.request("GET", f"{cls.path}/{name}") for name in OF_SURFACE + OF_GROUND}

    def download(self, name, path=None):
        status, headers, body = self.server.request("GET", f"{path or self.path}/{name}")
        return status, headers, body

    def test_they_are_those_of_the_command_line(self):
        out = self.scratch / "map"
        run("stitch", self.photos, "-o", out, "--formats", "dtm")
        for name in OF_SURFACE + OF_GROUND:
            status, headers, body = self.served[name]
            self.assertEqual(status, 200, name)
            self.assertTrue(body == (out / name).read_bytes(), name)
            self.assertIn(name, headers["Content-Disposition"])
        self.assertLessEqual(set(OF_SURFACE + OF_GROUND), set(zipfile.ZipFile(io.BytesIO(self.download("download.zip")[2])).namelist()))

    def test_a_map_that_is_moved_keeps_them_where_it_is_now(self):
        made = self.server.stitched(self.files, name="Moved", options=json.dumps({"heights": "dtm"}))
        path = f"/api/v1/flights/{made['flight']['id']}"
        before = self.download("dsm.tif", path)[2]
        west, south, _, _ = self.server.json("GET", f"{path}/report")[1]["bounds"]
        status, job = self.server.json("POST", f"{path}/jobs", {"options": {"place": [
            {"shown": [south, west], "is": [south + 1e-4, west]}]}})
        self.assertEqual((status, job["options"].get("heights")), (202, "dtm"), job)
        self.server.ended(job["id"])
        for name in OF_SURFACE + OF_GROUND:
            self.assertEqual(self.download(name, path)[0], 200, name)
        self.assertFalse(self.download("dsm.tif", path)[2] == before)

    def test_qgis_reads_the_heights_of_a_running_server(self):
        if not has_qgis():
            self.skipTest("python3-qgis is not here")
        from osgeo import gdal
        files = {name: self.scratch / f"served_{name}" for name in self.served}
        for name, file in files.items():
            file.write_bytes(self.served[name][2])
        made = self.server.stitched(self.files, name="Seen in QGIS", options=json.dumps({"heights": "dtm"}))
        below = f"/vsicurl/http://127.0.0.1:{self.server.port}/api/v1/flights/{made['flight']['id']}"
        contours = [files[name] for name in ("contours.gpkg", "contours.geojson", "contours.dxf")]
        done = subprocess.run([sys.executable, "-c", QGIS_HEIGHTS_SCRIPT, f"{below}/dsm.tif", f"{below}/dtm.tif", *contours],
                              capture_output=True, text=True, timeout=300,
                              env={**os.environ, "QT_QPA_PLATFORM": "offscreen", "QGIS_CUSTOM_CONFIG_PATH": str(self.scratch), "XDG_CACHE_HOME": str(self.scratch)})
        self.assertEqual(done.returncode, 0, done.stderr)
        told = json.loads(next(line for line in done.stdout.splitlines() if line.startswith("{")))
        self.assertEqual((told["system"], told["systems"][:2]), ("EPSG:32632", ["EPSG:32632", "EPSG:4979"]))  # with heights
        self.assertEqual((len(set(told["lines"])), told["invalid"]), (1, 0), told["lines"])
        self.assertGreater(told["lines"][0], 3)
        seen = 0
        for number, name in ((2, "dsm.tif"), (3, "dtm.tif")):
            raster = gdal.Open(str(files[name]))
            left, step, _, top, _, down = raster.GetGeoTransform()
            heights = raster.ReadAsArray()
            for place in told["values"]:
                want = float(heights[int((place[1] - top) / down), int((place[0] - left) / step)])
                got = place[number]
                if want == want:
                    self.assertAlmostEqual(got, want, 3)
                    seen += 1
                else:
                    self.assertTrue(got is None or got != got, (got, want))
        self.assertGreater(seen, 60)

    def raster(self, name):
        from osgeo import gdal
        path = f"/vsimem/{name}"
        gdal.FileFromMemBuffer(path, self.served[name][2])
        return gdal.Open(path)

    # Of a polygon of the map by shares of the raster's width and height: longitudes and latitudes.
    def polygon(self, raster, corners):
        from osgeo import osr
        left, step, _, top, _, down = raster.GetGeoTransform()
        geographic = osr.SpatialReference()
        geographic.ImportFromEPSG(4326)
        geographic.SetAxisMappingStrategy(osr.OAMS_TRADITIONAL_GIS_ORDER)
        transform = osr.CoordinateTransformation(raster.GetSpatialRef(), geographic)
        ring = [transform.TransformPoint(left + x * step * raster.RasterXSize, top + y * down * raster.RasterYSize)[:2] for x, y in corners]
        return {"type": "Polygon", "coordinates": [[list(place) for place in ring + ring[:1]]]}

    def post_polygon(self, route, polygon):
        return self.server.json("POST", f"{self.path}/{route}", polygon)

    def test_a_volume_is_the_sum_over_the_file(self):
        from osgeo import gdal, ogr, osr
        dsm = self.raster("dsm.tif")
        polygon = self.polygon(dsm, [(0.3, 0.3), (0.7, 0.35), (0.65, 0.7), (0.35, 0.6)])
        outline = ogr.CreateGeometryFromJson(json.dumps(polygon))
        geographic = osr.SpatialReference()
        geographic.ImportFromEPSG(4326)
        geographic.SetAxisMappingStrategy(osr.OAMS_TRADITIONAL_GIS_ORDER)
        outline.Transform(osr.CoordinateTransformation(geographic, dsm.GetSpatialRef()))
        shapes = ogr.GetDriverByName("Memory").CreateDataSource("shapes")
        layer = shapes.CreateLayer("area", dsm.GetSpatialRef())
        feature = ogr.Feature(layer.GetLayerDefn())
        feature.SetGeometry(outline)
        layer.CreateFeature(feature)
        mask = gdal.GetDriverByName("MEM").Create("", dsm.RasterXSize, dsm.RasterYSize, 1)
        mask.SetGeoTransform(dsm.GetGeoTransform())
        gdal.RasterizeLayer(mask, [1], layer, burn_values=[1])
        inside = dsm.ReadAsArray()[mask.ReadAsArray() == 1]
        self.assertGreater(inside.size, 1000)
        cell_m2 = dsm.GetGeoTransform()[1] ** 2
        base = float(inside.mean()) + 0.2
        status, told = self.post_polygon(f"volume?base={base!r}", polygon)
        self.assertEqual((status, told["of"], told["base"]), (200, "dsm", "given"), told)
        self.assertAlmostEqual(told["cut_m3"], float((inside - base).clip(0).sum()) * cell_m2, delta=1e-3 * told["cut_m3"])
        self.assertAlmostEqual(told["fill_m3"], float((base - inside).clip(0).sum()) * cell_m2, delta=1e-3 * told["fill_m3"])
        self.assertAlmostEqual(told["covered_m2"], inside.size * cell_m2, delta=1e-3 * told["covered_m2"])
        self.assertAlmostEqual(told["highest_m"], float(inside.max()), 2)
        self.assertIsNone(told["net_sigma_m3"], "how far off the map's zero the given height counts from, nothing says")
        for of, base in (("dsm", "lowest"), ("dsm", "plane"), ("dtm", "plane")):
            status, told = self.post_polygon(f"volume?of={of}&base={base}", polygon)
            self.assertEqual((status, told["of"], told["base"]), (200, of, base), told)
            if of == "dsm" and told["measured_share"] >= 0.8:
                self.assertGreater(told["net_sigma_m3"], 0)

    def test_what_lies_beside_the_map_is_not_covered(self):
        polygon = self.polygon(self.raster("dsm.tif"), [(0.5, 0.3), (1.5, 0.3), (1.5, 0.7), (0.5, 0.7)])
        status, told = self.post_polygon("volume?base=100", polygon)
        self.assertEqual(status, 200, told)
        self.assertLess(told["covered_m2"], 0.51 * told["area_m2"])
        self.assertLess(told["measured_share"], 0.51)
        world = {"type": "Polygon", "coordinates": [[[-60, -60], [80, -60], [80, 70], [-60, 70], [-60, -60]]]}
        status, told = self.post_polygon("volume?base=100", world)
        self.assertEqual((status, told["measured_share"]), (200, 0), told)
        self.assertGreater(told["covered_m2"], 1000)
        self.assertEqual(self.post_polygon("volume?base=plane", world)[0], 422, "no edge of it is on the map")

    def test_no_volume_without_heights_or_polygon(self):
        polygon = self.polygon(self.raster("dsm.tif"), [(3, 3), (3, 4), (4, 4)])
        status, told = self.post_polygon("volume", polygon)
        self.assertEqual((status, told["reason"]["code"]), (422, "volume_without_heights"), told)
        self.assertEqual(self.post_polygon("volume?base=sea", polygon)[0], 400)
        self.assertEqual(self.post_polygon("volume?base=1e9", polygon)[0], 400)
        self.assertEqual(self.post_polygon("volume?of=dem", polygon)[0], 400)
        self.assertEqual(self.post_polygon("volume", {"type": "Point", "coordinates": [1, 2]})[0], 422)
        self.server.request("POST", f"{self.path}/volume", b"polygon", {"Content-Type": "text/plain"}, code=415)

    def test_no_cubic_metres_of_a_map_whose_scale_is_a_guess(self):
        flight = self.scratch / "adrift"
        run("simulate", "-o", flight, "--photos", "6", "--size", "400x300", "--height", "40", "--houses", "2", "--relief-m", "3",
            "--noise", "no-pose", "--seed", "3", "--no-world", "--sidelap", "0.75")
        made = self.server.stitched(photos_in(flight / "photos"), name="Adrift", options=json.dumps({"heights": "dsm"}))
        path = f"/api/v1/flights/{made['flight']['id']}"
        report = self.server.json("GET", f"{path}/report")[1]
        self.assertIn("scale_guessed", [limit["kind"] for limit in report["quality"]["limits"]])
        west, south, east, north = report["bounds"]
        middle = {"type": "Polygon", "coordinates": [[[west + x * (east - west), south + y * (north - south)] for x, y in
                                                      ((0.4, 0.4), (0.6, 0.4), (0.6, 0.6), (0.4, 0.4))]]}
        self.assertIn("how large", json.dumps(self.server.json("POST", f"{path}/volume?base=0", middle, code=422)[1]))

    def test_terrain_tiles_and_places_say_the_heights_of_the_file(self):
        dsm = self.raster("dsm.tif")
        flight = self.path.split("/")[-1]
        _, tilejson = self.server.json("GET", f"/tiles/{flight}.json")
        self.assertEqual(tilejson["heights"], ["dsm", "dtm"])
        self.assertTrue(tilejson["terrain"].endswith(f"/tiles/{flight}/terrain.json"))
        (lon, lat), *_ = self.polygon(dsm, [(0.5, 0.5)])["coordinates"][0]
        left, step, _, top, _, down = dsm.GetGeoTransform()
        want = float(dsm.ReadAsArray()[dsm.RasterYSize // 2, dsm.RasterXSize // 2])
        _, point = self.server.json("GET", f"{self.path}/point?lon={lon}&lat={lat}&ground=false")
        self.assertAlmostEqual(point["dsm_m"], want, delta=0.05)
        self.assertLess(abs(point["dtm_m"] - want), 12)
        line = {"type": "LineString", "coordinates": [[lon, lat], [lon + 1e-4, lat]]}
        _, profile = self.server.json("POST", f"{self.path}/heights", line)
        self.assertEqual(profile["surfaces"], ["dsm", "dtm"])
        self.assertAlmostEqual(profile["samples"][0]["dsm_m"], point["dsm_m"], 3)
        status, terrain = self.server.json("GET", f"/tiles/{flight}/terrain.json")
        self.assertEqual((status, terrain["encoding"], terrain["tileSize"]), (200, "terrarium", 256))
        _, collection = self.server.json("GET", f"/ogc/collections/{flight}")
        files = [link["href"] for link in collection["links"] if link["rel"] == "enclosure"]
        self.assertEqual([href[href.index("/api/"):] for href in files], [f"{self.path}/dsm.tif", f"{self.path}/dtm.tif"])
        _, collections = self.server.json("GET", "/ogc/collections")
        [listed] = [one for one in collections["collections"] if one["id"] == flight]
        self.assertEqual(listed["links"], collection["links"])
        address, at = tile_at(terrain, (lon, lat))
        status, headers, tile = self.server.request("GET", address)
        self.assertEqual((status, headers["Content-Type"]), (200, "image/png"))
        self.assertIn("immutable", headers["Cache-Control"])
        red, green, blue, *_ = pixel(tile, at)
        self.assertAlmostEqual(red * 256 + green + blue / 256 - 32768, want, delta=0.1)
        for path, wanted in (("0/0/0.png", 200), ("3/1/1.png", 200), ("3/9/1.png", 400), ("3/1/1.jpg", 400), ("3/1/1@2x.png", 400), ("29/1/1.png", 404)):
            self.assertEqual(self.server.request("GET", f"/tiles/{flight}/terrain/{path}")[0], wanted, path)

    def test_a_house_that_was_built_since_an_earlier_flight_is_the_volume_between_the_two(self):
        village = ["--photos", "12", "--size", "640x480", "--height", "40", "--relief-m", "3", "--seed", "3", "--no-world", "--sidelap", "0.75"]
        flights = []
        # The second one is placed by a consumer drone's records, metres from the first.
        for houses, noise in ((2, "rtk"), (3, "xmp")):
            folder = self.scratch / f"village_{houses}"
            run("simulate", "-o", folder, "--houses", str(houses), "--noise", noise, *village)
            made = self.server.stitched(photos_in(folder / "photos"), name=f"Village with {houses} houses", options=json.dumps({"heights": "dsm"}))
            flights.append(made["flight"]["id"])
        before, after = flights
        truth = json.loads((folder / "truth" / "poses.json").read_text())
        [house] = truth["objects"][2:]
        corners = [corner[:2] for corner in house["corners_in_enu"]]
        area_m2 = abs(sum(a[0] * b[1] - b[0] * a[1] for a, b in zip(corners, corners[1:] + corners[:1]))) / 2
        volume_m3 = area_m2 * (house["ridge_m"] - house["ground_m"])
        middle, origin = house["center_in_enu"], truth["origin"]

        def around(factor):  # the house's outline so many times as large
            m_per_deg = 111_194.9
            ring = [[origin["lon_deg"] + (middle[0] + factor * (x - middle[0])) / (m_per_deg * math.cos(math.radians(origin["lat_deg"]))),
                     origin["lat_deg"] + (middle[1] + factor * (y - middle[1])) / m_per_deg] for x, y in corners]
            return {"type": "Polygon", "coordinates": [ring + ring[:1]]}

        path = f"/api/v1/flights/{after}/volume"
        status, built = self.server.json("POST", f"{path}?since={before}", around(1.5))
        self.assertEqual((status, built["base"], built["since"]), (200, "flight", before), built)
        self.assertLess(built["net_sigma_m3"], 0.1 * volume_m3, built)
        self.assertAlmostEqual(built["net_m3"], volume_m3, delta=2 * built["net_sigma_m3"])
        self.assertLess(built["fill_m3"], 0.05 * volume_m3, built)
        self.assertEqual(set(built["shift"]), {"east_m", "north_m", "up_m", "sigma_m", "alike_share"})
        self.assertGreater(built["shift"]["alike_share"], 0.8)
        status, torn_down = self.server.json("POST", f"/api/v1/flights/{before}/volume?since={after}", around(1.5))
        self.assertAlmostEqual(torn_down["net_m3"], -volume_m3, delta=2 * torn_down["net_sigma_m3"])
        for query, wanted in ((f"since={before}&base=plane", 400), (f"since={'0' * 26}", 404), ("since=house", 404), (f"since={before}&of=dtm", 404), (f"since={after}", 400), (f"since={before}&align=yes", 400)):
            self.assertEqual(self.server.json("POST", f"{path}?{query}", around(1.5))[0], wanted, query)

        status, as_placed = self.server.json("POST", f"{path}?since={before}&align=none", around(1.5))
        self.assertEqual((status, as_placed["shift"]["up_m"], as_placed["net_sigma_m3"]), (200, 0, None), as_placed)
        self.assertAlmostEqual(as_placed["net_m3"] - built["net_m3"], built["shift"]["up_m"] * built["covered_m2"], delta=0.03 * volume_m3)
        plain = self.server.stitched(self.files, name="Plain village")["flight"]["id"]
        self.assertIn('"Plain village"', self.server.json("POST", f"{path}?since={plain}", around(1.5), code=404)[1]["detail"])

        status, change = self.server.json("GET", f"/tiles/{after}/change.json?since={before}")
        self.assertEqual((status, change["shift"]), (200, built["shift"]), change)
        address, at = tile_at(change, around(0)["coordinates"][0][0])
        status, headers, tile = self.server.request("GET", address)
        self.assertEqual((status, headers["Content-Type"]), (200, "image/png"))
        self.assertIn("immutable", headers["Cache-Control"])
        red, green, blue, alpha = pixel(tile, at)
        self.assertTrue(alpha == 255 and blue > green > red, (red, green, blue, alpha))
        self.assertEqual(self.server.request("GET", address.replace("&since_rev=1", ""))[1]["Cache-Control"], "no-cache")
        for query, wanted in (("", 400), (f"?since={after}", 400), ("?since=1", 404), (f"?since={before}&align=none", 200)):
            self.assertEqual(self.server.json("GET", f"/tiles/{after}/change.json{query}")[0], wanted, query)

    def test_without_being_asked_there_are_none(self):
        made = self.server.stitched(self.files, name="Plain")
        path = f"/api/v1/flights/{made['flight']['id']}"
        for name in OF_SURFACE + OF_GROUND:
            status, headers, body = self.download(name, path)
            self.assertEqual((status, headers["Content-Type"]), (404, "application/problem+json"), name)
        flight = path.split("/")[-1]
        self.assertEqual(self.server.json("GET", f"/tiles/{flight}.json")[1]["heights"], [])
        links = self.server.json("GET", f"/ogc/collections/{flight}")[1]["links"]
        self.assertNotIn("enclosure", [link["rel"] for link in links])
        for address in (f"/tiles/{flight}/terrain.json", f"/tiles/{flight}/terrain/0/0/0.png"):
            self.assertEqual(self.server.request("GET", address)[0], 404, address)
        _, told = self.server.json("POST", f"{path}/volume", {"type": "Polygon", "coordinates": [[[1, 1], [2, 1], [2, 2], [1, 1]]]}, code=404)
        self.assertIn('"heights"', told["detail"])
        self.assertIn('"dtm"', self.server.json("POST", f"{path}/jobs", {"options": {"heights": "all"}}, code=422)[1]["detail"])

    def test_the_archive_of_a_node_has_them_where_clients_look(self):
        body = form({"options": json.dumps([{"name": "dsm", "value": True}])}, self.files, "images")
        status, _, answer = self.server.request("POST", "/task/new", body, FORM)
        uuid = json.loads(answer)["uuid"]
        while self.server.json("GET", f"/task/{uuid}/info")[1]["status"]["code"] in (10, 20):
            pass
        names = zipfile.ZipFile(io.BytesIO(self.server.request("GET", f"/task/{uuid}/download/all.zip")[2])).namelist()
        self.assertIn("odm_dem/dsm.tif", names)
        self.assertNotIn("odm_dem/dtm.tif", names)
