"""The whole way against the real program: upload, job, tiles, downloads; bad input; workers and servers killed."""
import glob
import http.client
import json
import os
import pathlib
import re
import shutil
import signal
import socket
import subprocess
import tempfile
import time
import unittest
import urllib.error
import urllib.request

PROGRAM = os.environ["SKYQUILT_BINARY"]
DATA = pathlib.Path(os.environ.get("SKYQUILT_DATA", pathlib.Path(__file__).parents[2] / ".." / "shared" / "data"))


class Server:
    def __init__(self, data):
        self.data = data
        self.start()

    def start(self):
        self.process = subprocess.Popen([PROGRAM, "serve", "--data", self.data, "--listen", "127.0.0.1:0"],
                                        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        line = self.process.stdout.readline()
        self.url = re.search(r"http://[^ /]+", line).group(0)
        self.host = self.url.removeprefix("http://")

    def stop(self, how=signal.SIGTERM):
        self.process.send_signal(how)
        code = self.process.wait(timeout=60)
        self.process.stdout.close()
        return code

    def call(self, method, path, body=None, headers=None):
        request = urllib.request.Request(self.url + path, data=body, method=method, headers=headers or {})
        try:
            with urllib.request.urlopen(request, timeout=60) as answer:
                return answer.status, dict(answer.headers), answer.read()
        except urllib.error.HTTPError as error:
            with error:
                return error.code, dict(error.headers), error.read()

    def json(self, method, path, value=None):
        body = None if value is None else json.dumps(value).encode()
        status, headers, answer = self.call(method, path, body, {"Content-Type": "application/json"} if body else {})
        return status, json.loads(answer) if answer else None

    def make_flight(self, photos, name="test"):
        _, flight = self.json("POST", "/api/v1/flights", {"name": name})
        for photo in photos:
            status, _, _ = self.call("PUT", f"/api/v1/flights/{flight['id']}/files/{pathlib.Path(photo).name}",
                                     pathlib.Path(photo).read_bytes())
            assert status == 201, status
        return flight["id"]

    def wait(self, job, until=("successful", "failed", "dismissed"), seconds=240):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            _, state = self.json("GET", f"/api/v1/jobs/{job}")
            if state["state"] in until:
                return state
            time.sleep(0.1)
        raise AssertionError(f"job still {state}")


class FlightTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp())
        subprocess.run([PROGRAM, "simulate", "-o", cls.folder / "flight", "--photos", "5", "--size", "640x480", "--no-world"],
                       check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        cls.photos = sorted(glob.glob(str(cls.folder / "flight/photos/*.JPG")))
        cls.server = Server(cls.folder / "data")

    @classmethod
    def tearDownClass(cls):
        assert cls.server.stop() == 0
        shutil.rmtree(cls.folder)

    def start_job(self, flight):
        status, job = self.server.json("POST", f"/api/v1/flights/{flight}/jobs", {})
        self.assertEqual(status, 202)
        return job["id"]

    def assert_map_answers(self, flight, photos):
        _, state = self.server.json("GET", f"/api/v1/flights/{flight}")
        self.assertEqual(state["state"], "ready")
        self.assertEqual(state["photos"]["aligned"] + state["photos"]["pose_only"], photos)
        status, headers, body = self.server.call("GET", f"/api/v1/flights/{flight}/download.mbtiles")
        self.assertEqual(status, 200)
        self.assertTrue(body.startswith(b"SQLite format 3"))
        zoom = state["min_zoom"]
        west, south, east, north = state["bounds"]
        x = int((west + 180) / 360 * 2**zoom)
        import math
        y = int((1 - math.asinh(math.tan(math.radians((north + south) / 2))) / math.pi) / 2 * 2**zoom)
        status, headers, tile = self.server.call("GET", f"/tiles/{flight}/{zoom}/{x}/{y}.png")
        self.assertEqual(status, 200)
        self.assertGreater(len(tile), 300)
        etag = headers["ETag"]
        status, _, _ = self.server.call("GET", f"/tiles/{flight}/{zoom}/{x}/{y}.png", headers={"If-None-Match": etag})
        self.assertEqual(status, 304)

    def test_uploads_and_maps_a_flight(self):
        flight = self.server.make_flight(self.photos)
        self.assertEqual(self.server.wait(self.start_job(flight))["state"], "successful")
        self.assert_map_answers(flight, 5)
        status, _, _ = self.server.call("DELETE", f"/api/v1/flights/{flight}")
        self.assertEqual(status, 204)
        self.assertEqual(self.server.call("GET", f"/tiles/{flight}.json")[0], 404)

    def test_lists_bad_files_and_maps_the_rest(self):
        flight = self.server.make_flight(self.photos)
        good = pathlib.Path(self.photos[0]).read_bytes()
        for name, body in {"notes.jpg": b"just text", "cut.jpg": good[: len(good) // 2]}.items():
            self.assertEqual(self.server.call("PUT", f"/api/v1/flights/{flight}/files/{name}", body)[0], 201)
        self.assertEqual(self.server.wait(self.start_job(flight))["state"], "successful")
        _, report = self.server.json("GET", f"/api/v1/flights/{flight}/report")
        self.assertEqual({photo["name"] for photo in report["left_out_photos"]}, {"notes.jpg", "cut.jpg"})
        self.assert_map_answers(flight, 5)

    def test_a_flight_of_one_photo_makes_a_map(self):
        flight = self.server.make_flight(self.photos[:1])
        self.assertEqual(self.server.wait(self.start_job(flight))["state"], "successful")
        self.assert_map_answers(flight, 1)

    def test_nothing_usable_fails_with_words(self):
        _, flight = self.server.json("POST", "/api/v1/flights", {"name": "empty"})
        status, problem = self.server.json("POST", f"/api/v1/flights/{flight['id']}/jobs", {})
        self.assertGreaterEqual(status, 400)
        self.assertLess(status, 500)
        self.assertIn("detail", problem)

    def test_paths_in_file_names_stay_in_the_flight(self):
        _, flight = self.server.json("POST", "/api/v1/flights", {"name": "paths"})
        for name in ("..%2f..%2fevil.jpg", "%2e%2e%2fevil.jpg", "a%00b.jpg", "..%5cevil.jpg"):
            status, _, _ = self.server.call("PUT", f"/api/v1/flights/{flight['id']}/files/{name}", b"x")
            self.assertIn(status, (400, 404, 201), name)
        outside = [path for path in self.folder.rglob("*evil*") if "data" not in path.parts]
        self.assertEqual(outside, [])

    def test_a_declared_size_is_not_believed(self):
        _, flight = self.server.json("POST", "/api/v1/flights", {"name": "big"})
        host, port = self.server.host.split(":")
        with socket.create_connection((host, int(port)), timeout=30) as raw:
            raw.sendall(f"PUT /api/v1/flights/{flight['id']}/files/big.jpg HTTP/1.1\r\nHost: {host}\r\n"
                        f"Content-Length: {3 << 30}\r\n\r\n".encode() + b"x" * 1000)
        time.sleep(0.5)
        self.assertEqual(self.server.call("GET", "/healthz")[0], 200)
        _, files = self.server.json("GET", f"/api/v1/flights/{flight['id']}/files")
        self.assertEqual(files["files"], [])

    def test_bad_tile_paths_are_refused(self):
        flight = self.server.make_flight(self.photos[:2])
        self.assertEqual(self.server.wait(self.start_job(flight))["state"], "successful")
        for path in ("-1/0/0", "31/0/0", "99999999999/0/0", "3/8/0", "3/1e3/0", "3/+1/0", "3/0x1/0", "3/1.5/0", "3/1/0.exe"):
            status, headers, _ = self.server.call("GET", f"/tiles/{flight}/{path}")
            self.assertIn(status, (400, 404, 406, 415), path)
            self.assertEqual(headers["Content-Type"], "application/problem+json", path)

    def test_a_killed_worker_loses_no_job(self):
        flight = self.server.make_flight(self.photos)
        job = self.start_job(flight)
        self.server.wait(job, until=("running",))
        time.sleep(0.3)
        subprocess.run(["pkill", "-KILL", "-P", str(self.server.process.pid)], check=True)
        self.assertEqual(self.server.wait(job)["state"], "successful")
        self.assert_map_answers(flight, 5)

    def test_a_killed_server_loses_no_job(self):
        flight = self.server.make_flight(self.photos)
        job = self.start_job(flight)
        self.server.wait(job, until=("running",))
        time.sleep(0.3)
        self.server.stop(signal.SIGKILL)
        self.server.start()
        self.assertEqual(self.server.wait(job)["state"], "successful")
        self.assert_map_answers(flight, 5)


class RealFlightTest(unittest.TestCase):
    def test_cameras_lie_where_the_photos_gps_says(self):
        photos = DATA / "brighton_beach" / "images"
        if not photos.is_dir() or shutil.which("exiftool") is None:
            self.skipTest("the Brighton Beach photos or exiftool are not here")
        with tempfile.TemporaryDirectory() as out:
            subprocess.run([PROGRAM, "stitch", photos, "-o", out, "--method", "imu", "--no-cog"], check=True,
                           stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            report = json.loads(pathlib.Path(out, "report.json").read_text())
            features = json.loads(pathlib.Path(out, "photos.geojson").read_text())["features"]
        self.assertEqual(report["photos"], {"total": 18, "aligned": 0, "pose_only": 18, "left_out": 0})
        exif = json.loads(subprocess.run(["exiftool", "-j", "-n", "-GPSLatitude", "-GPSLongitude", photos], check=True,
                                         capture_output=True).stdout)
        recorded = {pathlib.Path(row["SourceFile"]).name: row for row in exif}
        west, south, east, north = report["bounds"]
        for feature in features:
            row = recorded[feature["properties"]["name"]]
            lat, lon = row["GPSLatitude"], row["GPSLongitude"]
            self.assertTrue(west <= lon <= east and south <= lat <= north)
            self.assertLess(abs(feature["properties"]["camera_lat"] - lat) * 111_000, 0.5)
            self.assertLess(abs(feature["properties"]["camera_lon"] - lon) * 76_000, 0.5)
            # The photos look straight down: the middle of the footprint lies below the camera.
            ring = feature["geometry"]["coordinates"][0][:-1]
            corners = [ring[i * len(ring) // 4] for i in range(4)]
            self.assertLess(abs(sum(c[1] for c in corners) / 4 - lat) * 111_000, 0.5)
            self.assertLess(abs(sum(c[0] for c in corners) / 4 - lon) * 76_000, 0.5)


if __name__ == "__main__":
    unittest.main()
