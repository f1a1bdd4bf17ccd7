"""A map is asked for in another format, system, area and resolution; made beside the requests; kept for a day."""
import json
import os
import pathlib
import shutil
import signal
import subprocess
import tempfile
import unittest
import unittest.mock

from server_support import (AS_JSON, BLOBS, ServerTestCase, bearer, children_called, in_catalogue, is_running,
                            kept_of_flights, put_map, wait_until)


def confined_exports(server):
    return children_called(server.process.pid, "export-sandboxed")


def box(west, south, east, north):
    return {"type": "Polygon", "coordinates": [[[west, south], [east, south], [east, north], [west, north], [west, south]]]}


PRINTERS = ("weasyprint", "chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "wkhtmltopdf")


class Exports(ServerTestCase):
    def serve_map(self):
        """(a server, its flight with a map)"""
        flight = put_map(self.data)
        return self.serve(), flight

    def ask(self, server, flight, headers=None, **wish):
        status, head, body = server.request("POST", f"/api/v1/flights/{flight}/exports", json.dumps(wish),
                                            {**AS_JSON, **(headers or {})})
        answer = json.loads(body)
        if status == 202:
            self.assertEqual(head["Location"], answer["href"])
        return status, answer

    def finished(self, server, export):
        self.shown = export
        def has_ended():
            status, self.shown = server.json("GET", export["href"])
            self.assertEqual(status, 200, self.shown)
            return self.shown["state"] in ("successful", "failed")
        wait_until(has_ended, f"the export did not end: {self.shown} {server.errors()}")
        return self.shown

    def files_of(self, flight):
        """The files of a flight's exports, wherever they lie."""
        return [name for name in kept_of_flights(self.data) if name.startswith(f"{flight}/exports/")]

    def test_a_job_cuts_its_map_to_an_area_and_refuses_what_is_none(self):
        server, flight = self.serve_map()
        west, south, east, north = server.json("GET", f"/api/v1/flights/{flight}")[1]["bounds"]
        middle = [west + (east - west) / 3, south + (north - south) / 3, east - (east - west) / 3, north - (north - south) / 3]
        def begin(options):
            return server.json("POST", f"/api/v1/flights/{flight}/jobs", {"options": options})
        for bad, words in (({"boundary": {"type": "Point", "coordinates": [7, 46]}}, "has a Point"),
                           ({"boundary": "field"}, "not JSON"), ({"takeoff_height_m": 9001}, "above sea level")):
            status, refused = begin(bad)
            self.assertIn(status, (400, 422), refused)
            self.assertIn(words, refused["detail"])
        status, elsewhere = begin({"boundary": box(west + 1, south, east + 1, north)})
        self.assertEqual(status, 202, elsewhere)
        self.assertIn("Draw the boundary over the flight", json.dumps(server.ended(elsewhere["id"], "failed")))
        status, job = begin({"boundary": box(*middle), "takeoff_height_m": 321})
        self.assertEqual(status, 202, job)
        server.ended(job["id"])
        _, cut = server.json("GET", f"/api/v1/flights/{flight}")
        for found, expected in zip(cut["bounds"], middle):
            self.assertAlmostEqual(found, expected, delta=3e-6)
        self.assertEqual(cut["job"]["options"]["takeoff_height_m"], 321)
        lon, lat = (middle[0] + middle[2]) / 2, (middle[1] + middle[3]) / 2
        _, seen = server.json("GET", f"/api/v1/flights/{flight}/at?lon={lon}&lat={lat}", code=200)
        qualities = [photo["quality"] for photo in seen["photos"]]
        self.assertEqual(qualities, sorted(qualities, reverse=True))
        self.assertTrue(any(photo["sharpness"] is not None for photo in seen["photos"]), seen)

    def test_every_format_and_what_cannot_be(self):
        server, flight = self.serve_map()
        _, _, whole = server.request("GET", f"/api/v1/flights/{flight}/download.mbtiles")
        status, about = server.json("GET", f"/api/v1/flights/{flight}")
        west, south, east, north = about["bounds"]
        quarter = box((west + east) / 2, (south + north) / 2, east, north)
        wishes = [{"format": "geotiff", "crs": "utm"}, {"format": "geotiff", "crs": "EPSG:3857", "boundary": quarter},
                  {"format": "geotiff", "crs": "EPSG:4326", "resolution_m": 0.5, "boundary": quarter},
                  {"format": "mbtiles"}, {"format": "pmtiles", "boundary": quarter}, {"format": "kmz", "resolution_m": 0.3},
                  {"format": "geotiff", "crs": "utm", "index": "vari"}]
        if any(shutil.which(name) for name in PRINTERS):
            wishes.append({"format": "report"})
        asked = []
        for wish in wishes:
            status, export = self.ask(server, flight, **wish)
            self.assertEqual(status, 202, export)
            asked.append(export)
        # The same again is the same.
        self.assertEqual(self.ask(server, flight, **wishes[0])[1]["id"], asked[0]["id"])
        starts = {"geotiff": b"II", "mbtiles": b"SQLite format 3", "pmtiles": b"PMTiles", "kmz": b"PK", "report": b"%PDF-"}
        for wish, export in zip(wishes, asked):
            export = self.finished(server, export)
            self.assertEqual(export["state"], "successful", (wish, export, server.errors()))
            self.assertIsNotNone(export["expires_at"])
            self.assertTrue(export["is_current"])
            _, headers, body = server.request("GET", export["download"], code=200)
            self.assertEqual(len(body), export["bytes"])
            self.assertTrue(body.startswith(starts[wish["format"]]), body[:16])
            self.assertIn("attachment", headers["Content-Disposition"])
            part = server.request("GET", export["download"], headers={"Range": "bytes=2-9"})
            self.assertEqual((part[0], part[2]), (206, body[2:10]))
            self.assertEqual(server.request("GET", export["download"], headers={"If-None-Match": headers["ETag"]})[0], 304)
            if wish == {"format": "mbtiles"}:
                self.assertEqual(body, whole)
            if wish["format"] == "geotiff" and shutil.which("gdalinfo"):
                self.look_at(body, wish, quarter)
        listed = server.json("GET", f"/api/v1/flights/{flight}/exports")[1]["exports"]
        self.assertEqual({one["id"] for one in listed}, {one["id"] for one in asked})
        wait_until(lambda: not server.garbage(), "something was left over")  # a moment after the export is told of

        for wish, words in [({"format": "geotiff", "crs": "EPSG:12"}, "not known"), ({"format": "geotiff", "crs": "EPSG:32755"}, "the map lies at"),
                            ({"format": "pmtiles", "crs": "utm"}, "Web Mercator"), ({"format": "kmz", "boundary": box(1, 1, 2, 2)}, "outside the map"),
                            ({"format": "geotiff", "resolution_m": 0.0001}, "finest pixels"), ({"format": "report", "crs": "utm"}, "whole map"), ({"format": "geotiff", "index": "ndvi"}, "no band"), ({"crs": "utm"}, "Say the format"),
                            ({"format": "kmz", "boundary": {"type": "Point", "coordinates": [1, 2]}}, "Polygon"), ({"format": "kmz", "size": 3}, "size")]:
            status, refused = self.ask(server, flight, **wish)
            self.assertEqual(status, 422, refused)
            self.assertIn(words, refused["detail"])
        self.assertEqual(server.request("POST", f"/api/v1/flights/{flight}/exports", "{", AS_JSON)[0], 400)
        self.assertEqual(server.request("POST", f"/api/v1/flights/{flight}/exports", "format=kmz", {"Content-Type": "text/plain"})[0], 415)
        empty = server.json("POST", "/api/v1/flights", {"name": "empty"})[1]["id"]
        self.assertEqual(self.ask(server, empty, format="kmz")[0], 404)
        self.assertEqual(server.json("GET", f"/api/v1/flights/{empty}/exports"), (200, {"exports": []}))

        # Gone with its file.
        self.assertEqual(server.request("DELETE", asked[0]["href"])[0], 204)
        self.assertEqual(server.request("GET", asked[0]["href"])[0], 404)
        self.assertEqual(server.request("GET", asked[0]["href"] + "/file")[0], 404)
        self.assertEqual(len(self.files_of(flight)), len(asked) - 1)
        self.assertEqual(server.request("DELETE", f"/api/v1/flights/{flight}")[0], 204)
        self.assertEqual(server.request("GET", asked[1]["href"])[0], 404)

    def look_at(self, geotiff, wish, boundary):
        path = pathlib.Path(self.scratch, "look.tif")
        path.write_bytes(geotiff)
        told = json.loads(subprocess.run(["gdalinfo", "-json", path], check=True, capture_output=True, text=True).stdout)
        code = {"utm": None, "EPSG:3857": 3857, "EPSG:4326": 4326}[wish["crs"]]
        if code:
            self.assertEqual(told["stac"]["proj:epsg"] if "stac" in told else code, code)
        if wish["crs"] == "EPSG:4326":
            lons = [corner[0] for corner in boundary["coordinates"][0]]
            self.assertAlmostEqual(told["geoTransform"][0], min(lons), delta=2 * told["geoTransform"][1])
        if "index" in wish:
            self.assertEqual([(band["type"], band["description"]) for band in told["bands"]], [("Float32", "VARI")])
        if wish["crs"] == "utm":
            self.assertIn("UTM zone", told["coordinateSystem"]["wkt"])

    def programs(self, **scripts):
        """A folder of programs, for a PATH that has nothing else."""
        folder = pathlib.Path(tempfile.mkdtemp(dir=self.scratch))
        for name, script in scripts.items():
            (folder / name).write_text(f"#!/bin/sh\n{script}\n")
            (folder / name).chmod(0o755)
        return folder

    def serve_with(self, folder):
        with unittest.mock.patch.dict(os.environ, {"PATH": str(folder), "AWS_SECRET_ACCESS_KEY": "of the store"}):
            return self.serve_map()

    def test_who_prints_a_report(self):
        server, flight = self.serve_with(self.programs())
        status, refused = self.ask(server, flight, format="report")
        self.assertEqual((status, refused["reason"]["code"]), (503, "export_without_printer"), refused)
        server.stop()
        # One that fails makes way for the next, which gets nothing of the server's.
        folder = self.programs(weasyprint="exit 3", wkhtmltopdf=
                               'env > "$PATH/seen"; ls -l /proc/$$/fd > "$PATH/open" 2>&1; for last; do :; done; echo "%PDF-1.4 made" > "$last"'
                               .replace("env ", "/usr/bin/env ").replace("; ls ", "; /bin/ls "))
        server, flight = self.serve_with(folder)
        export = self.finished(server, self.ask(server, flight, format="report")[1])
        self.assertEqual(export["state"], "successful", (export, server.errors()))
        self.assertEqual(server.request("GET", export["download"])[2], b"%PDF-1.4 made\n")
        seen = (folder / "seen").read_text()
        self.assertNotIn("AWS_", seen)
        self.assertEqual({line.split("=")[0] for line in seen.splitlines()} - {"PWD", "OLDPWD", "SHLVL", "_"}, {"PATH", "HOME", "LC_ALL"})
        self.assertNotIn("socket:", (folder / "open").read_text())
        # Under another name it is another report; under the same it is the same.
        self.assertEqual(self.ask(server, flight, format="report")[1]["id"], export["id"])
        self.assertEqual(server.request("PATCH", f"/api/v1/flights/{flight}", '{"name": "Mill"}', AS_JSON)[0], 200)
        self.assertNotEqual(self.ask(server, flight, format="report")[1]["id"], export["id"])
        server.stop()
        # None of them prints.
        server, flight = self.serve_with(self.programs(weasyprint="echo a font is missing >&2; exit 3"))
        export = self.finished(server, self.ask(server, flight, format="report")[1])
        self.assertEqual((export["state"], export["error"]["reason"]["code"]), ("failed", "report_not_printed"), export)
        self.assertIn("a font is missing", server.errors())
        server.stop()
        # What nobody wants any more is ended, with what it started.
        folder = self.programs(weasyprint='/bin/sleep 500 & echo $! > "$PATH/pid"; wait')
        server, flight = self.serve_with(folder)
        export = self.ask(server, flight, format="report")[1]
        wait_until(lambda: (folder / "pid").exists() and (folder / "pid").read_text().strip(), "nothing prints")
        asleep = pathlib.Path("/proc", (folder / "pid").read_text().strip(), "cmdline")
        wait_until(lambda: b"sleep" in asleep.read_bytes(), "nothing sleeps")  # its number is known before it is another program
        self.assertEqual(server.request("DELETE", export["href"])[0], 204)

        def is_gone():
            try:
                return b"sleep" not in asleep.read_bytes()
            except OSError:
                return True
        wait_until(is_gone, "it prints on")
        wait_until(lambda: not server.garbage(), "something was left over")

    def test_a_map_that_is_replaced_and_a_day_that_ends(self):
        server, flight = self.serve_map()
        export = self.finished(server, self.ask(server, flight, format="kmz")[1])
        _, _, before = server.request("GET", export["download"])
        server.remade(flight, {"gsd_m": 0.4})
        self.assertFalse(server.json("GET", export["href"])[1]["is_current"])
        self.assertEqual(server.request("GET", export["download"])[2], before)
        again = self.finished(server, self.ask(server, flight, format="kmz")[1])
        self.assertNotEqual(again["id"], export["id"])
        # One whose map is gone before it begins says so (the map before the last may stay a while).
        self.assertEqual(server.stop(), 0)
        in_catalogue(self.data, "UPDATE map_export SET state='accepted', revision=77, lease_until_us=0, expires_us=NULL WHERE id=?", export["id"])
        in_catalogue(self.data, "UPDATE map_export SET expires_us=1 WHERE id=?", again["id"])
        stray = pathlib.Path(self.data, "flights", flight, "exports", "stray.tif")
        if BLOBS is None:
            stray.write_bytes(b"x")
        server = self.serve()
        failed = self.finished(server, export)
        self.assertEqual(failed["state"], "failed")
        self.assertIn("was replaced", failed["error"]["message"])
        self.assertEqual(server.request("GET", failed["href"] + "/file")[0], 409)
        # Its day was over: the first round of the housekeeper took it, and what nobody knows lies in lost/.
        wait_until(lambda: server.request("GET", again["href"])[0] == 404, "an export outlived its day")
        wait_until(lambda: not any(again["id"] in name for name in self.files_of(flight)), "the file of an expired export stayed")
        if BLOBS is not None:
            return  # what nobody knows there waits for the daily sweep of the store
        self.assertFalse(stray.exists())
        self.assertEqual([path.read_bytes() for path in pathlib.Path(self.data, "lost").rglob("stray.tif")], [b"x"])

    def test_a_killed_server_and_a_killed_process(self):
        server, flight = self.serve_map()
        # As many as it takes for one to be under way.
        asked = [self.ask(server, flight, format="geotiff", crs="EPSG:32632", resolution_m=0.1 + step / 100)[1] for step in range(3)]
        if any("id" not in one for one in asked):
            asked = [self.ask(server, flight, format="geotiff", crs="utm", resolution_m=0.2 + step / 100)[1] for step in range(3)]
        confined = wait_until(lambda: confined_exports(server), "no export began")
        server.kill()
        wait_until(lambda: not any(is_running(pid) for pid in confined), "an export outlived its server")
        server = self.serve()
        for export in asked:
            self.assertEqual(self.finished(server, export)["state"], "successful")
        wait_until(lambda: not server.garbage(), "something was left over")  # a moment after the export is told of

        def killed():
            for pid in confined_exports(server):
                try:
                    os.kill(pid, signal.SIGKILL)
                    return True
                except ProcessLookupError:
                    continue
            return False
        victim = self.ask(server, flight, format="kmz")[1]
        end_states = {"failed", "successful"}
        wait_until(lambda: killed() or server.json("GET", victim["href"])[1]["state"] in end_states, "nothing happened")
        shown = self.finished(server, victim)
        if shown["state"] == "failed":
            self.assertIn("its process ended", shown["error"]["message"])
        self.assertEqual(server.request("GET", "/healthz")[0], 200)
        wait_until(lambda: not server.garbage(), "something was left over")  # a moment after the export is told of

    def test_rights(self):
        owner, reader, other = (self.token(name, "--scope", scope) for name, scope in (("owner", "upload"), ("reader", "read"), ("other", "upload")))
        server = self.serve()
        flight = server.new_flight(self.photos, owner)
        job = server.json("POST", f"/api/v1/flights/{flight}/jobs", {}, owner)[1]["id"]
        def is_done():
            return server.json("GET", f"/api/v1/jobs/{job}", headers=owner)[1]["state"] == "successful"
        wait_until(is_done, "no map")
        share = server.json("POST", f"/api/v1/flights/{flight}/shares", {}, owner)[1]["token"]
        guest = bearer(share)
        elsewhere = server.new_flight(headers=owner)
        status, refused = self.ask(server, flight, format="kmz")
        self.assertEqual(status, 401, refused)
        status, of_guest = self.ask(server, flight, guest, format="kmz")
        self.assertEqual(status, 202, of_guest)
        self.assertEqual(self.ask(server, elsewhere, guest, format="kmz")[0], 404)
        status, of_reader = self.ask(server, flight, reader, format="pmtiles")
        self.assertEqual(status, 202, of_reader)
        self.assertEqual(server.request("GET", f"{of_reader['href']}?token={share}")[0], 200)
        for who in (other, guest):
            self.assertEqual(server.request("DELETE", of_reader["href"], headers=who)[0], 403)
        self.assertEqual(server.request("DELETE", of_reader["href"], headers=reader)[0], 204)
        self.assertEqual(server.request("DELETE", of_guest["href"], headers=owner)[0], 204)
        # What a link asked for goes with it, out of the list at once.
        status, of_guest = self.ask(server, flight, guest, format="mbtiles")
        self.assertEqual(status, 202, of_guest)
        shares = f"/api/v1/flights/{flight}/shares"
        link = server.json("GET", shares, headers=owner)[1]["shares"][0]["id"]
        self.assertEqual(server.request("DELETE", f"{shares}/{link}", headers=owner)[0], 204)
        self.assertEqual(server.request("GET", of_guest["href"], headers=owner)[0], 404)
        self.assertEqual(server.json("GET", f"/api/v1/flights/{flight}/exports", headers=owner)[1]["exports"], [])
