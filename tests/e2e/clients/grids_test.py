"""OGC API Maps, and tiles in degrees and in UTM: GDAL and OWSLib get the pixels that GDAL itself warps from the MBTiles."""
import pathlib
import subprocess

import older_ogcapi
from gis_support import MapFileTestCase

DEGREES = "WorldCRS84Quad"


class Grids(MapFileTestCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        west, _, east, _ = cls.tilejson["bounds"]
        cls.zone = int(((west + east) / 2 + 180) // 6) + 1
        cls.utm = f"UTM{cls.zone:02}WGS84Quad"

    def document(self, path):
        return self.server.json("GET", path, code=200)[1]

    def warped(self, dataset):
        """The MBTiles by GDAL, on the pixels of a dataset."""
        left, width, _, top, _, height = dataset.GetGeoTransform()
        bounds = (left, top + height * dataset.RasterYSize, left + width * dataset.RasterXSize, top)
        return self.gdal.Warp("", str(self.path("mbtiles")), format="MEM", dstSRS=dataset.GetProjection(), outputBounds=bounds,
                              width=dataset.RasterXSize, height=dataset.RasterYSize, resampleAlg="bilinear", errorThreshold=0)

    def check_placed(self, dataset, least_pixels=20_000, most_off=1.0):
        """A dataset in any system shows what the MBTiles shows there, and a pixel further nothing fits as well."""
        got, want = (raster.ReadAsArray().astype(int) for raster in (dataset, self.warped(dataset)))
        # Within the map; at its edge the two differ in what they make of what is half known.
        inside = want[3] == 255
        for _ in range(3):
            inside[1:-1, 1:-1] = (inside[1:-1, 1:-1] & inside[:-2, 1:-1] & inside[2:, 1:-1] & inside[1:-1, :-2] & inside[1:-1, 2:])
            inside[0] = inside[-1] = inside[:, 0] = inside[:, -1] = False
        self.assertGreater(int(inside.sum()), least_pixels)
        self.assertGreater(float(want[:3, inside].std()), 3.0)  # a picture, not a blank

        def off(down, right):
            moved = got[:3][:, 2 + down:got.shape[1] - 2 + down, 2 + right:got.shape[2] - 2 + right]
            return float(abs(moved - want[:3, 2:-2, 2:-2])[:, inside[2:-2, 2:-2]].mean())

        here = off(0, 0)
        self.assertLess(here, most_off)
        for down, right in ((1, 0), (-1, 0), (0, 1), (0, -1)):
            self.assertGreater(off(down, right), 1.5 * here, (down, right))

    def window(self, dataset, side=600):
        """The middle of a dataset, which may be of the whole grid."""
        west, south, east, north = self.tilejson["bounds"]
        reference = self.gdal.osr.SpatialReference(dataset.GetProjection())
        reference.SetAxisMappingStrategy(self.gdal.osr.OAMS_TRADITIONAL_GIS_ORDER)
        degrees = self.gdal.osr.SpatialReference()
        degrees.ImportFromEPSG(4326)
        degrees.SetAxisMappingStrategy(self.gdal.osr.OAMS_TRADITIONAL_GIS_ORDER)
        x, y, _ = self.gdal.osr.CoordinateTransformation(degrees, reference).TransformPoint((west + east) / 2, (south + north) / 2)
        left, width, _, top, _, height = dataset.GetGeoTransform()
        column, row = round((x - left) / width) - side // 2, round((y - top) / height) - side // 2
        return self.gdal.Translate("", dataset, format="MEM", srcWin=[max(column, 0), max(row, 0), side, side])

    def test_gdals_wmts_driver_reads_every_grid(self):
        source = f"WMTS:{self.address('/wmts/' + self.flight_id)},layer=map,tilematrixset="
        for grid, code in ((DEGREES, "4326"), (self.utm, str(32600 + self.zone))):
            with self.subTest(grid=grid):
                dataset = self.gdal.Open(source + grid)
                reference = self.gdal.osr.SpatialReference(dataset.GetProjection())
                self.assertIn(code, (reference.GetAuthorityCode(None), "4326" if reference.IsGeographic() else None))
                self.check_placed(self.window(dataset))
        # Who does not ask gets what was there before.
        self.check_against_mbtiles(self.gdal.Open(f"WMTS:{self.address('/wmts/' + self.flight_id)}"))

    def test_gdal_translate_writes_a_piece_of_the_utm_grid(self):
        out = pathlib.Path(self.data, "utm.tif")
        west, south, east, north = self.tilejson["bounds"]
        middle = [(west + east) / 2, (south + north) / 2]
        box = [middle[0] - (east - west) / 8, middle[1] + (north - south) / 8, middle[0] + (east - west) / 8, middle[1] - (north - south) / 8]
        subprocess.run(["gdal_translate", "-q", "-projwin_srs", "OGC:CRS84", "-projwin", *(repr(value) for value in box),
                        f"WMTS:{self.address('/wmts/' + self.flight_id)},layer=map,tilematrixset={self.utm}", str(out)], check=True)
        self.check_placed(self.gdal.Open(str(out)), least_pixels=3_000)

    def test_gdals_ogcapi_driver_reads_the_map(self):
        dataset = self.gdal.OpenEx(f"OGCAPI:{self.address('/ogc/collections/' + self.flight_id)}", open_options=["API=MAP"])
        self.assertTrue(self.gdal.osr.SpatialReference(dataset.GetProjection()).IsGeographic())
        # The driver counts pixels of a hundredth of a millionth degree. Those of an overview are a little finer than the map's.
        overview = 4
        shrunk = [dataset.GetRasterBand(band).GetOverview(overview) for band in range(1, 5)]
        side, factor = 600, 2 ** (overview + 1)
        column, row = (shrunk[0].XSize - side) // 2, (shrunk[0].YSize - side) // 2
        piece = self.gdal.GetDriverByName("MEM").Create("", side, side, 4)
        left, width, _, top, _, height = dataset.GetGeoTransform()
        piece.SetProjection(dataset.GetProjection())
        piece.SetGeoTransform([left + column * factor * width, factor * width, 0, top + row * factor * height, 0, factor * height])
        for band, source in enumerate(shrunk, 1):
            piece.GetRasterBand(band).WriteArray(source.ReadAsArray(column, row, side, side))
        self.check_placed(piece)

    def test_gdals_ogcapi_driver_reads_tiles_of_degrees(self):
        """Before GDAL 3.8 it reads those of a grid in degrees, with limits as wide as the matrix."""
        level = self.document(f"/ogc/collections/{self.flight_id}/map/tiles/{DEGREES}")["tileMatrixSetLimits"][-1]["tileMatrix"]
        options = ["API=TILES", f"TILEMATRIXSET={DEGREES}", f"TILEMATRIX={level}"]
        with older_ogcapi.widened_limits(self.server.port) as port:
            dataset = self.gdal.OpenEx(f"OGCAPI:http://127.0.0.1:{port}/ogc/collections/{self.flight_id}", open_options=options)
            self.check_placed(self.window(dataset, 400))

    def picture(self, query, crs):
        """A map as a dataset that lies where its headers say."""
        _, headers, content = self.server.request("GET", f"/ogc/collections/{self.flight_id}/map?{query}", code=200)
        file = f"/vsimem/{abs(hash(query))}"
        self.gdal.FileFromMemBuffer(file, content)
        dataset = self.gdal.GetDriverByName("MEM").CreateCopy("", self.gdal.Open(file))
        reference = self.gdal.osr.SpatialReference()
        reference.SetFromUserInput(headers.get("Content-Crs", "OGC:CRS84"))
        self.assertTrue(reference.IsSame(self.reference(crs)) or reference.IsGeographic(), crs)
        box = [float(number) for number in headers["Content-Bbox"].split(",")]
        if reference.EPSGTreatsAsLatLong() or reference.EPSGTreatsAsNorthingEasting():
            box = [box[1], box[0], box[3], box[2]]
        dataset.SetProjection(self.reference(crs).ExportToWkt())
        dataset.SetGeoTransform([box[0], (box[2] - box[0]) / dataset.RasterXSize, 0, box[3], 0, (box[1] - box[3]) / dataset.RasterYSize])
        return dataset

    def reference(self, crs):
        reference = self.gdal.osr.SpatialReference()
        reference.SetFromUserInput(crs)
        return reference

    def test_maps_lie_where_their_headers_say(self):
        west, south, east, north = self.tilejson["bounds"]
        for crs in ("EPSG:3857", "OGC:CRS84", "EPSG:4326", f"EPSG:{32600 + self.zone}", "EPSG:3035", "EPSG:2056"):
            with self.subTest(crs=crs):
                # A little finer than the map's pixels, so that nothing is averaged by either.
                dataset = self.picture(f"crs=[{crs}]&center={(west + east) / 2},{(south + north) / 2}&width=700&height=500&scale-denominator=100",
                                       crs)
                self.assertEqual((dataset.RasterXSize, dataset.RasterYSize), (700, 500))
                self.check_placed(dataset)
        self.assertEqual(self.picture("", "EPSG:3857").RasterCount, 4)

    def test_owslib_reads_tiles_of_every_grid(self):
        of_wmts, = self.imported("python3-owslib is not here", "owslib.wmts")
        wmts = of_wmts.WebMapTileService(self.address(f"/wmts/{self.flight_id}/1.0.0/WMTSCapabilities.xml"))
        self.assertLessEqual({"WebMercatorQuad", DEGREES, self.utm}, set(wmts.tilematrixsets))
        for grid, code in ((DEGREES, "CRS84"), (self.utm, str(32600 + self.zone))):
            known = wmts.tilematrixsets[grid]
            self.assertIn(code, known.crs)
            limits = wmts["map"].tilematrixsetlinks[grid].tilematrixlimits
            level = sorted(limits, key=int)[-1]
            matrix, limit = known.tilematrix[level], limits[level]
            row, column = (limit.mintilerow + limit.maxtilerow) // 2, (limit.mintilecol + limit.maxtilecol) // 2
            content = wmts.gettile(layer="map", tilematrixset=grid, tilematrix=level, row=row, column=column, format="image/png").read()
            self.gdal.FileFromMemBuffer("/vsimem/owslib.png", content)
            dataset = self.gdal.GetDriverByName("MEM").CreateCopy("", self.gdal.Open("/vsimem/owslib.png"))
            metres = 111319.49079327358 if grid == DEGREES else 1.0
            cell = matrix.scaledenominator * 0.00028 / metres
            left, top = matrix.topleftcorner
            dataset.SetProjection(self.reference("OGC:CRS84" if grid == DEGREES else f"EPSG:{code}").ExportToWkt())
            dataset.SetGeoTransform([left + column * 256 * cell, cell, 0, top - row * 256 * cell, 0, -cell])
            self.check_placed(dataset, least_pixels=5_000)

    def test_every_link_of_the_tilesets_leads_somewhere(self):
        listed = self.document(f"/ogc/collections/{self.flight_id}/map/tiles")["tilesets"]
        self.assertEqual([one["tileMatrixSetURI"].rsplit("/", 1)[1] for one in listed if "tileMatrixSetURI" in one],
                         ["WebMercatorQuad", DEGREES, self.utm])
        for one in listed:
            links = {link["rel"]: link["href"].removeprefix(self.address("")) for link in one["links"]}
            tileset = self.document(links["self"])
            scheme = self.document(links["http://www.opengis.net/def/rel/ogc/1.0/tiling-scheme"])
            self.assertEqual(scheme["crs"], tileset["crs"])
            last = tileset["tileMatrixSetLimits"][-1]
            self.assertIn(last["tileMatrix"], [matrix["id"] for matrix in scheme["tileMatrices"]])
            tile = links["item"].format(tileMatrix=last["tileMatrix"], tileRow=(last["minTileRow"] + last["maxTileRow"]) // 2,
                                        tileCol=(last["minTileCol"] + last["maxTileCol"]) // 2)
            self.assertEqual(self.server.request("GET", tile)[0], 200, tile)

    def test_the_contract_says_the_limits(self):
        limits = self.document("/openapi.json")["info"]["x-OGC-limits"]["maps"]
        path = f"/ogc/collections/{self.flight_id}/map"
        self.assertEqual(self.server.request("GET", f"{path}?width={limits['maxWidth'] + 1}")[0], 413)
        self.assertEqual(self.server.request("GET", f"{path}?width={limits['maxWidth']}&height={limits['maxHeight']}")[0], 413)
        height = limits["maxPixels"] // limits["maxWidth"]
        status, headers, content = self.server.request("GET", f"{path}?width={limits['maxWidth']}&height={height}&f=jpeg")
        self.assertEqual((status, headers["Content-Type"]), (200, "image/jpeg"))
