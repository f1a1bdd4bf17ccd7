"""A map of others sent to a running server becomes a flight's map; what cannot be one, costs too much or comes from somebody
who may not is refused in words, and the server goes on."""
import json
import pathlib
import shutil
import sqlite3
import unittest

from flights import made_flights
from program import report_of, run, tool
from server_support import ServerTestCase, add_token, bearer, middle_of, tile_of

HAS_GDAL = all(shutil.which(name) for name in ("gdal_translate", "gdalwarp"))


@unittest.skipUnless(HAS_GDAL, "gdal-bin is not installed: it makes the maps of others for this test")
class ServerImport(ServerTestCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.folder = pathlib.Path(cls.scratch)
        made = made_flights.small_map()
        cls.mbtiles = made / "mosaic.mbtiles"
        cls.utm = cls.folder / "north field.tif"
        tool("gdalwarp", "-q", "-t_srs", "EPSG:32632", "-dstalpha", "-r", "cubic", made / "mosaic.tif", cls.utm)
        cls.report = report_of(made)
        cls.bounds = cls.report["bounds"]

    def import_(self, server, file, *words, env=None):
        return run("import", file, "--server", f"http://127.0.0.1:{server.port}/", *map(str, words), code=None, env=env, timeout=240)

    def imported(self, server, file, *words):
        done = self.import_(server, file, *words)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return next(line.split()[1] for line in done.stdout.splitlines() if line.startswith("flight "))

    def token(self, name, *words):
        return add_token(self.data, name, *words)

    def middle_of(self, server, flight):
        about = server.json("GET", f"/api/v1/flights/{flight}")[1]
        zoom = server.json("GET", f"/tiles/{flight}.json")[1]["maxzoom"]
        x, y = middle_of(about["bounds"], zoom)
        return server.request("GET", f"/tiles/{flight}/{zoom}/{x}/{y}")

    def test_a_geotiff_and_an_mbtiles_become_maps(self):
        server = self.serve("--workers", "1")
        flight = self.imported(server, self.utm, "--name", "North field, 2019", "--tag", "archive", "--quality", "70")
        about = server.json("GET", f"/api/v1/flights/{flight}")[1]
        self.assertEqual((about["name"], about["state"], about["tags"], about["photos"]["total"]), ("North field, 2019", "ready", ["archive"], 0))
        self.assertEqual(about["options"], {"import_file": "north field.tif", "quality": 70})
        for got, wanted in zip(about["bounds"], self.bounds):
            self.assertAlmostEqual(got, wanted, delta=5e-5)
        status, headers, _ = self.middle_of(server, flight)
        self.assertEqual((status, headers["Content-Type"]), (200, "image/jpeg"))
        for address in (f"/api/v1/flights/{flight}/download.tif", f"/api/v1/flights/{flight}/download.zip", f"/api/v1/flights/{flight}/thumbnail.png",
                        f"/stac/{flight}", f"/wmts/{flight}", f"/connect/{flight}/qgis.qlr"):
            self.assertEqual(server.request("GET", address)[0], 200, address)
        said = " ".join(server.json("GET", f"/api/v1/flights/{flight}/report")[1]["warnings"])
        self.assertIn("imported from north field.tif", said)
        self.assertEqual(about["quality"]["status"], "unknown")
        self.assertNotIn(str(self.data), said)
        # Another file takes its place, as another revision; its tiles are its own bytes.
        self.assertEqual(self.imported(server, self.mbtiles, "--flight", flight), flight)
        about = server.json("GET", f"/api/v1/flights/{flight}")[1]
        # The report that lay beside it came along, and says how true the map is.
        self.assertEqual((about["revision"], about["quality"]), (2, self.report["quality"]))
        said = server.json("GET", f"/api/v1/flights/{flight}/report")[1]
        self.assertEqual((about["gsd_m"], said["area_m2"]), (self.report["gsd_m"], self.report["area_m2"]))
        zoom = server.json("GET", f"/tiles/{flight}.json")[1]["maxzoom"]
        x, y = tile_of(sum(self.bounds[::2]) / 2, sum(self.bounds[1::2]) / 2, zoom)
        row = sqlite3.connect(self.mbtiles).execute("SELECT tile_data FROM tiles WHERE zoom_level=? AND tile_column=? AND tile_row=?",
                                                    (zoom, x, 2 ** zoom - 1 - y)).fetchone()[0]
        self.assertEqual(server.request("GET", f"/tiles/{flight}/{zoom}/{x}/{y}")[2], row)
        # The files stay until somebody deletes them; the map needs none of them.
        files = server.json("GET", f"/api/v1/flights/{flight}/files")[1]["files"]
        self.assertEqual(sorted(file["name"] for file in files), ["mosaic.mbtiles", "north field.tif", "report.json"])
        for file in ("mosaic.mbtiles", "north%20field.tif", "report.json"):
            self.assertEqual(server.request("DELETE", f"/api/v1/flights/{flight}/files/{file}")[0], 204)
        self.assertEqual(self.middle_of(server, flight)[0], 200)
        self.assertEqual(server.garbage(), [])

    def test_another_file_of_the_same_name_and_size_becomes_the_map(self):
        server = self.serve("--workers", "1")
        flight = self.imported(server, self.utm)
        before = server.json("GET", f"/api/v1/flights/{flight}")[1]
        coarser = self.folder / "coarser" / self.utm.name
        coarser.parent.mkdir()
        tool("gdal_translate", "-q", "-outsize", "50%", "50%", self.utm, coarser)
        coarser.write_bytes(coarser.read_bytes().ljust(self.utm.stat().st_size, b"\0"))
        for file in (coarser, coarser, self.utm):  # each sent once
            self.assertEqual(self.imported(server, file, "--flight", flight), flight)
            about = server.json("GET", f"/api/v1/flights/{flight}")[1]
            self.assertEqual(about["gsd_m"] > 1.5 * before["gsd_m"], file is coarser)
        files = server.json("GET", f"/api/v1/flights/{flight}/files")[1]["files"]
        self.assertEqual((about["revision"], len(files), "north field.tif" in [file["name"] for file in files]), (4, 2, True))

    def test_a_newer_report_beside_the_file_takes_the_place_of_the_one_there(self):
        server = self.serve("--workers", "1")
        folder, again = self.folder / "reported", ()
        folder.mkdir()
        file = pathlib.Path(shutil.copy(self.mbtiles, folder))
        for sigma_m in (0.25, 0.75, 0.125):  # the second as long as the first
            quality = {**self.report["quality"], "absolute": {**self.report["quality"]["absolute"], "sigma_m": sigma_m}}
            (folder / "report.json").write_text(json.dumps({**self.report, "quality": quality}))
            flight = self.imported(server, file, *again)
            again = ("--flight", flight)
            self.assertEqual(server.json("GET", f"/api/v1/flights/{flight}")[1]["quality"], quality)
        files = server.json("GET", f"/api/v1/flights/{flight}/files")[1]["files"]
        self.assertEqual(sorted(file["name"] for file in files), ["mosaic.mbtiles", "report.json"])

    def test_a_file_whose_name_is_longer_than_a_flights_may_be_is_taken(self):
        server = self.serve("--workers", "0")
        flight = self.imported(server, shutil.copy(self.mbtiles, self.folder / ("Ж" * 120 + ".mbtiles")), "--no-wait")
        self.assertEqual(server.json("GET", f"/api/v1/flights/{flight}")[1]["name"], "Ж" * 100)

    def test_one_form_is_enough(self):
        server = self.serve("--workers", "1")
        made = server.stitched([("old.mbtiles", self.mbtiles.read_bytes())], name="By a form", options='{"import_file": "old.mbtiles"}')
        self.assertEqual(made["job"]["options"], {"import_file": "old.mbtiles"})
        self.assertEqual(self.middle_of(server, made["flight"]["id"])[0], 200)

    def test_what_is_asked_wrongly_is_refused_at_once(self):
        server = self.serve("--workers", "0")
        for options, words in (({"import_file": 7}, "name of one"), ({"import_file": "a/b.tif"}, "name of one"), ({"import_file": ""}, "name of one"),
                               ({"import_file": "a.tif", "gsd_m": 0.1}, "gsd_m"), ({"import_file": "a.tif", "place": "control"}, "place")):
            self.assertIn(words, server.json("POST", "/api/v1/flights", {"name": "f", "options": options}, code=422)[1]["detail"], options)
        flight = server.json("POST", "/api/v1/flights", {"name": "f", "options": {"import_file": "there.tif"}})[1]["id"]
        self.assertEqual(server.request("PUT", f"/api/v1/flights/{flight}/files/other.tif", b"II*\0")[0], 201)
        self.assertIn("there.tif", server.json("POST", f"/api/v1/flights/{flight}/jobs", {}, code=409)[1]["detail"])
        self.assertIn("--server", run("import", self.utm, code=1).stderr)
        both = run("import", self.utm, "--data", self.data, "--server", "http://127.0.0.1:1", code=None)
        self.assertNotEqual(both.returncode, 0)
        self.assertIn("excludes", both.stderr)
        for words in (("--data", self.data, "--patience", "5"), ("--server", "http://127.0.0.1:1", "--threads", "1")):
            self.assertIn("requires", run("import", self.utm, *words, code=None).stderr, words)

    def test_what_cannot_be_a_map_fails_its_job_and_nothing_else(self):
        server = self.serve("--workers", "1", "--job-timeout", "40")
        good = self.imported(server, self.mbtiles)
        whole = self.utm.read_bytes()
        bad = {"cut.tif": (whole[:len(whole) // 3], "damaged"), "noise.tif": (b"II*\0" + bytes(range(256)) * 4, "damaged")}
        # A picture that names other files of the machine is no GeoTIFF, whatever it calls itself.
        catalogue = pathlib.Path(self.data, "catalogue.db")
        bad["links.tif"] = (f'<VRTDataset rasterXSize="8" rasterYSize="8"><VRTRasterBand dataType="Byte" band="1"><SourceFilename>{catalogue}'
                            f'</SourceFilename></VRTRasterBand></VRTDataset>'.encode(), "GeoTIFF")
        endless = self.folder / "endless.mbtiles"
        shutil.copy(self.mbtiles, endless)
        with sqlite3.connect(endless) as db:
            db.executescript("DROP VIEW IF EXISTS tiles; DROP TABLE IF EXISTS tiles; CREATE VIEW tiles AS WITH RECURSIVE n(i) AS (SELECT 0 UNION ALL "
                             "SELECT i + 1 FROM n) SELECT 3 AS zoom_level, i % 8 AS tile_column, 0 AS tile_row, x'00' AS tile_data FROM n")
        db.close()
        bad["endless.mbtiles"] = (endless.read_bytes(), "more than 40 seconds")
        for name, (content, words) in bad.items():
            (self.folder / name).write_bytes(content)
            done = self.import_(server, self.folder / name)
            self.assertEqual(done.returncode, 1, (name, done.stdout))
            self.assertIn(words, done.stderr, name)
            self.assertNotIn(str(self.data), done.stderr, name)
            self.assertEqual(self.middle_of(server, good)[0], 200)
        failed = [flight for flight in server.json("GET", "/api/v1/flights")[1]["flights"] if flight["id"] != good]
        self.assertEqual([flight["state"] for flight in failed], ["failed"] * len(bad))
        self.assertEqual(server.garbage(), [])
        # The same flight, with a file that is sound.
        self.assertEqual(self.imported(server, self.utm, "--flight", failed[0]["id"]), failed[0]["id"])

    def test_who_may_not_and_who_has_no_room(self):
        reader, small, owner = self.token("reader", "--scope", "read"), self.token("small", "--scope", "upload", "--most-gb", "0.00002"), self.token("owner", "--scope", "upload")
        server = self.serve("--workers", "1")
        by = lambda token, *words: self.import_(server, self.utm, *words, "--token", token)
        self.assertIn("--token", self.import_(server, self.utm).stderr)
        self.assertIn("token", by("sq_" + "x" * 40).stderr)
        refused = by(reader)
        self.assertEqual(refused.returncode, 1)
        self.assertIn("scope", refused.stderr)
        self.assertIn("may hold 20.0 kB", by(small).stderr)
        done = by(owner)
        self.assertEqual(done.returncode, 0, done.stderr)
        flight = next(line.split()[1] for line in done.stdout.splitlines() if line.startswith("flight "))
        self.assertEqual(by(self.token("other", "--scope", "upload"), "--flight", flight).returncode, 1)
        _, listed = server.json("GET", f"/api/v1/flights/{flight}/files", headers=bearer(owner), code=200)
        self.assertEqual([file["name"] for file in listed["files"]], ["north field.tif"])
