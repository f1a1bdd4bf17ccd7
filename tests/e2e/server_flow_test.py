"""A flight in by HTTP, a map out: the way a browser, curl and a GIS go, and the same with bad files among the good."""
import gzip
import json
import socket

from server_support import ServerTestCase, kept_of_flights, middle_of, path_of


class Flow(ServerTestCase):
    def test_one_form_makes_a_map(self):
        server = self.serve()
        _, made = server.upload(self.photos, name="Demo field", options='{"quality": 80}', code=202)
        self.assertIn(made["flight"]["state"], ("queued", "processing"))  # a free worker takes it at once
        self.assertEqual(len(made["files"]), 6)
        self.assertEqual(server.ended(made["job"]["id"])["progress"], 1)
        flight_id = made["flight"]["id"]
        _, flight = server.json("GET", f"/api/v1/flights/{flight_id}")
        self.assertEqual(flight["state"], "ready")
        self.assertEqual(flight["photos"]["total"], 6)
        self.assertEqual(flight["photos"]["left_out"], 0)
        self.check_tiles(server, flight)
        self.check_downloads(server, flight_id)
        self.assertEqual(server.garbage(), [])
        self.assertEqual(server.stop(), 0)

    def check_tiles(self, server, flight):
        _, tilejson = server.json("GET", flight["tilejson"], code=200)
        zoom = tilejson["maxzoom"]
        x, y = middle_of(tilejson["bounds"], zoom)
        url = tilejson["tiles"][0].format(z=zoom, x=x, y=y)
        self.assertTrue(url.startswith(f"http://127.0.0.1:{server.port}/"))
        _, headers, body = server.request("GET", path_of(url), code=200)
        self.assertIn(headers["Content-Type"], ("image/jpeg", "image/png"))
        self.assertGreater(len(body), 500)
        self.assertIn("immutable", headers["Cache-Control"])
        self.assertEqual(server.request("GET", path_of(url), headers={"If-None-Match": headers["ETag"]}, code=304)[2], b"")
        base = f"/tiles/{flight['id']}/{zoom}/{x}/{y}"
        for extension, magic in ((".jpg", b"\xff\xd8\xff"), (".png", b"\x89PNG"), (".webp", b"RIFF")):
            self.assertTrue(server.request("GET", base + extension, code=200)[2].startswith(magic), extension)
        self.assertEqual(server.request("GET", f"/tiles/{flight['id']}/{zoom + 1}/{2 * x}/{2 * y}")[0], 404)
        for bad in ("-1/0/0", "1e1/0/0", "31/0/0", "2/9/0", "2/1/1.exe", "2/1/0x1"):
            self.assertEqual(server.request("GET", f"/tiles/{flight['id']}/{bad}")[0], 400, bad)

    def check_downloads(self, server, flight_id):
        base = f"/api/v1/flights/{flight_id}"
        self.assertEqual(server.json("GET", base + "/report", code=200)[1]["photos"]["total"], 6)
        self.assertEqual(len(server.json("GET", base + "/photos.geojson", code=200)[1]["features"]), 6)
        _, headers, whole = server.request("GET", base + "/download.mbtiles")
        self.assertTrue(whole.startswith(b"SQLite format 3"))
        self.assertEqual(int(headers["Content-Length"]), len(whole))
        status, headers, part = server.request("GET", base + "/download.mbtiles", headers={"Range": "bytes=100-299"})
        self.assertEqual((status, part), (206, whole[100:300]))
        self.assertEqual(headers["Content-Range"], f"bytes 100-299/{len(whole)}")
        status, headers, nothing = server.request("HEAD", base + "/download.mbtiles", headers={"Range": "bytes=100-299"})
        self.assertEqual((status, int(headers["Content-Length"]), nothing), (200, len(whole), b""))
        plain = server.request("GET", base + "/photos.geojson")
        packed = server.request("GET", base + "/photos.geojson", headers={"Accept-Encoding": "gzip"})
        self.assertEqual((packed[0], packed[1]["Content-Encoding"], gzip.decompress(packed[2])), (200, "gzip", plain[2]))
        self.assertLess(len(packed[2]), len(plain[2]) / 2)
        again = {"Accept-Encoding": "gzip", "If-None-Match": packed[1]["ETag"]}
        self.assertEqual(server.request("GET", base + "/photos.geojson", headers=again)[0], 304)
        _, headers, _ = server.request("GET", base + "/download.tif", headers={"Range": "bytes=99999999999-"}, code=416)
        self.assertTrue(headers["Content-Range"].startswith("bytes */"))

    def test_files_come_one_by_one_and_the_job_afterwards(self):
        server = self.serve()
        status, flight = server.json("POST", "/api/v1/flights", {"name": "Field 7"})
        self.assertEqual((status, flight["state"]), (201, "empty"))
        files = f"/api/v1/flights/{flight['id']}/files"
        for name, content in self.photos:
            self.assertEqual(server.request("PUT", f"{files}/{name}", content)[0], 201)
        self.assertEqual(server.request("PUT", f"{files}/{self.photos[0][0]}", self.photos[0][1])[0], 200)
        name, content = self.photos[1]
        status, headers, body = server.request("GET", f"{files}/{name}")
        self.assertEqual((status, headers["Content-Type"], body), (200, "image/jpeg", content))
        server.request("PUT", f"{files}/page.html", b"<script>alert(1)</script>")
        _, headers, _ = server.request("GET", f"{files}/page.html")
        self.assertEqual((headers["Content-Type"], headers["Content-Disposition"]), ("application/octet-stream", "attachment"))
        self.assertEqual(server.request("DELETE", f"{files}/page.html")[0], 204)
        self.assertEqual(server.request("GET", f"{files}/page.html")[0], 404)
        server.remade(flight["id"], {"gsd_m": 0.5})
        # The same again makes a second revision that takes the first one's place.
        server.remade(flight["id"], {"gsd_m": 0.5})
        _, flight = server.json("GET", f"/api/v1/flights/{flight['id']}")
        self.assertEqual((flight["revision"], flight["state"]), (2, "ready"))
        self.assertEqual(server.request("DELETE", f"/api/v1/flights/{flight['id']}")[0], 204)
        self.assertEqual(server.request("GET", flight["tilejson"])[0], 404)
        self.assertEqual(server.request("DELETE", f"/api/v1/trash/{flight['id']}")[0], 204)
        self.assertEqual(kept_of_flights(server.data), {})

    def test_bad_files_leave_the_rest_of_the_flight_intact(self):
        server = self.serve()
        name, content = self.photos[0]
        bad = [("notes.jpg", b"this is no picture"), ("empty.jpg", b""), ("../../evil.jpg", content),
               ("cut.jpg", content[: len(content) // 20]), (name, content)]
        _, made = server.upload(self.photos + bad, code=202)
        outcomes = {file["name"]: file for file in made["files"]}
        self.assertIn("error", outcomes["empty.jpg"])
        self.assertIn("error", outcomes["../../evil.jpg"])
        self.assertIn("note", made["files"][-1])
        self.assertNotEqual(made["files"][-1]["name"], name)
        server.ended(made["job"]["id"])
        _, report = server.json("GET", f"/api/v1/flights/{made['flight']['id']}/report")
        left_out = {photo["name"]: photo["reason"] for photo in report["left_out_photos"]}
        self.assertIn("notes.jpg", left_out)
        self.assertTrue(all(left_out.values()))

    def test_a_flight_of_one_photo_makes_a_map(self):
        server = self.serve()
        made = server.stitched(self.photos[:1])
        _, flight = server.json("GET", f"/api/v1/flights/{made['flight']['id']}")
        self.assertEqual((flight["state"], flight["photos"]["total"]), ("ready", 1))
        self.check_tiles(server, flight)

    def test_a_flight_without_any_photo_fails_with_a_reason(self):
        server = self.serve()
        flight_id, job_id = server.begun([("notes.jpg", b"this is no picture")])
        job = server.ended(job_id, "failed")
        self.assertEqual(job["attempts"], 1)
        self.assertTrue(job["error"]["message"])
        _, flight = server.json("GET", f"/api/v1/flights/{flight_id}")
        self.assertEqual(flight["state"], "failed")
        self.assertEqual(flight["error"], job["error"])
        self.assertEqual(server.garbage(), [])

    def test_uploads_that_cannot_be_taken_leave_nothing(self):
        server = self.serve()
        status, problem = server.upload([("empty.jpg", b"")])
        self.assertEqual((status, problem["status"]), (422, 422))
        server.upload([], code=422)
        files = f"/api/v1/flights/{server.new_flight()}/files"
        for name in ("..%2fevil.jpg", "%2e%2e", "a%00b", "a%5Cb", "%ff"):
            self.assertEqual(server.request("PUT", f"{files}/{name}", b"x")[0], 400, name)
        self.assertEqual(server.request("PUT", f"{files}/{'n' * 300}.jpg", b"x")[0], 400)
        with socket.create_connection(("127.0.0.1", server.port)) as client:
            client.sendall((f"PUT {files}/big.jpg HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 3221225472\r\n\r\n"
                            + "x" * 5000).encode())
        self.assertEqual(server.json("GET", files)[1]["files"], [])
        self.assertEqual(len(server.json("GET", "/api/v1/flights")[1]["flights"]), 1)

    def test_errors_are_problem_documents(self):
        server = self.serve()
        for method, path, status in (("GET", "/api/v1/flights/none", 404), ("DELETE", "/healthz", 405),
                                     ("GET", "/a//b", 400), ("GET", "/api/v1/flights?limit=x", 400)):
            got, headers, body = server.request(method, path)
            self.assertEqual((got, headers["Content-Type"]), (status, "application/problem+json"), path)
            problem = json.loads(body)
            self.assertEqual(problem["status"], status)
            self.assertEqual(problem["request_id"], headers["X-Request-Id"])

    def test_the_page_and_the_monitors_answer(self):
        server = self.serve()
        server.request("GET", "/", code=200)
        for path in ("/healthz", "/readyz", "/metrics", "/version", "/openapi.json"):
            self.assertEqual(server.request("GET", path)[0], 200, path)
        self.assertEqual(server.request("GET", "/package.json")[0], 404)

    def test_an_address_for_all_needs_a_clear_word(self):
        self.assertIn("--open", self.refusal("--listen", "0.0.0.0:0"))
