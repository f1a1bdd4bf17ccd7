"""The sixteen groups of bad input that a server of files meets, a test for each against the running program: every one is
refused with a reason or taken as the harmless thing it is, nothing of it stays behind, and the next request is answered.
What the parsers make of finer variations is in tests/api, tests/server, tests/core/flight and the fuzzers."""
import base64
import json
import os
import resource
import socket
import sqlite3
import struct
import subprocess
import tempfile
import threading
import xml.etree.ElementTree as xml_parser
import zipfile

import contract
from archive_test import zip_of
from program import BINARY
from server_support import (AS_JSON, BLOBS, CHUNK, POSTGRES, TUS, Server, ServerTestCase, add_token, bearer,
                            in_catalogue, middle_of, photos_of, side_by_side, tus_metadata, wait_until)

OF_B = "multipart/form-data; boundary=b"
EVIL = '<img src=x onerror="alert(1)">&\'"; DROP TABLE flight; --'


def raw(port, *pieces, half_close=False):
    """The status of what is answered to bytes that no client would send; 0 where the server just closes."""
    with socket.create_connection(("127.0.0.1", port), timeout=120) as client:
        try:
            for piece in pieces:
                client.sendall(piece)
            if half_close:
                client.shutdown(socket.SHUT_WR)
        except OSError:
            pass  # the server has heard enough: its answer is there to read
        try:
            line = client.makefile("rb").readline()
        except ConnectionResetError:
            return 0
    return int(line.split()[1]) if line else 0


class BadInput(ServerTestCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.shared = Server(tempfile.mkdtemp(dir=cls.scratch))
        cls.addClassCleanup(cls.shared.stop)
        cls.map_id = cls.shared.stitched(cls.photos, name=EVIL, options='{"gsd_m": 0.4}')["flight"]["id"]
        _, cls.tilejson = cls.shared.json("GET", f"/tiles/{cls.map_id}.json")

    def tearDown(self):
        self.assertEqual(self.shared.request("GET", "/healthz")[0], 200)
        wait_until(lambda: self.shared.garbage() == [], f"left over: {self.shared.garbage()}")
        super().tearDown()

    def flights(self):
        return [flight["id"] for flight in self.shared.json("GET", "/api/v1/flights?limit=200")[1]["flights"]]

    def refused(self, method, path, body=None, headers=None, among=(400, 404)):
        status, _, answer = self.shared.request(method, path, body, headers)
        self.assertIn(status, among, (method, path[:120], answer[:200]))

    def test_01_paths(self):
        for bad in ("..%2f..%2fetc%2fpasswd", "%2e%2e/", "%00", "..%5c", "a%5cb", "/", ";x", "%c0%ae%c0%ae", "CON", "a."):
            for path in (f"/api/v1/flights/{bad}", f"/tiles/{bad}.json", f"/connect/{bad}/gdal.xml", f"/stac/{bad}"):
                self.refused("GET", path)
        self.refused("GET", "/api/v1/flights/" + "a" * 4096)
        self.refused("GET", "/tiles/" + "a" * 9000, among=(414,))
        if BLOBS is not None:  # there are no links
            return
        # A link that got into the store by whatever way leads nowhere.
        flight = self.shared.new_flight()
        self.shared.request("PUT", f"/api/v1/flights/{flight}/files/a.jpg", b"x")
        [stored] = photos_of(self.shared.data, flight)
        stored.unlink()
        stored.symlink_to("/etc/passwd")
        status, _, body = self.shared.request("GET", f"/api/v1/flights/{flight}/files/a.jpg")
        self.assertNotIn(b"root:", body)
        self.assertGreaterEqual(status, 400)

    def test_02_tiles(self):
        for bad in ("-1/0/0", "31/0/0", "99999999999/0/0", "2/4/0", "2/1e3/0", "2/+1/0", "2/%201/0", "2/0x1/0", "2/1.5/0",
                    f"2/{'1' * 500}/0", "2/%D9%A1/0", "2/0/0.exe", "2/0/0@9x.png"):
            for base in (f"/tiles/{self.map_id}/", f"/tiles/{self.map_id}/256/", f"/tms/1.0.0/{self.map_id}/",
                         f"/tms/1.0.0/{self.map_id}/256/", f"/arcgis/rest/services/{self.map_id}/MapServer/tile/",
                         f"/ogc/collections/{self.map_id}/map/tiles/WebMercatorQuad/"):
                self.refused("GET", base + bad)
        for path in (f"/tiles/{self.map_id}/2/0/0.png?rev=x", f"/tms/1.0.0/{self.map_id}/256x/2/0/0.png",
                     f"/tms/1.0.0/{self.map_id}/99999999999/2/0/0.png", f"/tms/1.0.0/{self.map_id}/512"):
            self.refused("GET", path)

    def test_03_http(self):
        host = b"Host: localhost\r\n"
        get, put = b"GET /healthz HTTP/1.1\r\n" + host, b"PUT /api/v1/flights/x/files/a HTTP/1.1\r\n" + host
        port = self.shared.port
        for among, pieces in (
                ((431,), [get + b"".join(b"X-%d: y\r\n" % n for n in range(10_000)) + b"\r\n"]),
                ((414, 431), [b"GET /" + b"a" * (1 << 20) + b" HTTP/1.1\r\n" + host + b"\r\n"]),
                ((200,), [get + b"Connection: Upgrade, HTTP2-Settings\r\nUpgrade: h2c\r\nHTTP2-Settings: AAMAAABk\r\n\r\n"]),
                ((400, 505), [b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"]),
                ((400, 404, 413), [put + b"Transfer-Encoding: chunked\r\n\r\nffffffffffffffff\r\n"]),
                ((417,), [put + b"Content-Length: 1\r\nExpect: the-unexpected\r\n\r\nx"]),
                ((501, 405), [b"TRACE / HTTP/1.1\r\n" + host + b"\r\n"]),
                ((400, 501), [b"CONNECT example.org:443 HTTP/1.1\r\n" + host + b"\r\n"]),
                ((400, 421), [b"GET http://evil.example/ HTTP/1.1\r\n" + host + b"\r\n"])):
            self.assertIn(raw(port, *pieces), among, pieces[0][:80])
        self.assertEqual(raw(port, get + b"\r\n", half_close=True), 200)
        self.assertEqual(raw(port, *(bytes([byte]) for byte in get + b"\r\n")), 200)
        # More promised than sent, and then the end.
        files = f"/api/v1/flights/{self.shared.new_flight()}/files"
        raw(port, f"PUT {files}/a HTTP/1.1\r\nHost: localhost\r\nContent-Length: 9999\r\n\r\nshort".encode(), half_close=True)
        self.assertEqual(self.shared.json("GET", files)[1]["files"], [])

    def test_04_ranges(self):
        path = f"/api/v1/flights/{self.map_id}/download.mbtiles"
        _, headers, whole = self.shared.request("GET", path)
        for bad, among in (("bytes=-0", (416,)), ("bytes=" + "0-0,2-3," * 500 + "5-6", (200,)), ("bytes=5-2", (200,)),
                           ("bytes=999999999999999999999-", (416,)), ("lines=1-2", (200,)), ("bytes=a-b", (200,))):
            self.assertIn(self.shared.request("GET", path, headers={"Range": bad})[0], among, bad[:40])
        weak = {"Range": "bytes=0-9", "If-Range": "W/" + headers["ETag"]}
        self.assertEqual(len(self.shared.request("GET", path, headers=weak)[2]), len(whole))

    def test_05_multipart(self):
        part = b'--b\r\nContent-Disposition: form-data; name="file"; filename="%s"\r\n\r\nx\r\n'
        bodies = (b"", b"--b", b"no boundary at all", part % b"a.jpg", part % b"a.jpg" + b"--b-",
                  b"--b\r\n" + b"X: " + b"y" * (1 << 20),
                  b"--b\r\nContent-Disposition: form-data; name=file; filename=a\r\nContent-Transfer-Encoding: base64\r\n\r\neA==\r\n--b--",
                  b"--b\r\nContent-Type: multipart/mixed; boundary=c\r\n\r\n--c\r\n\r\nx\r\n--c--\r\n--b--")
        before = self.flights()
        for body in bodies:
            self.refused("POST", "/api/v1/flights", body, {"Content-Type": OF_B}, (400, 413, 422))
        for kind in ("multipart/form-data", "multipart/form-data; boundary=" + "b" * 71, 'multipart/form-data; boundary="b'):
            self.refused("POST", "/api/v1/flights", part % b"a.jpg" + b"--b--", {"Content-Type": kind}, (400, 415))
        self.assertEqual(self.flights(), before)
        # A name with lines or a way out of it is data, or refused: never a header, never a path.
        for name in (b"a%0d%0aX-Evil: y", b'"; filename*=utf-8\'\'..%2f..%2fevil.jpg; x="'):
            status, headers, body = self.shared.request("POST", "/api/v1/flights", part % name + b"--b--", {"Content-Type": OF_B})
            self.assertIn(status, (202, 400, 422), body)
            self.assertNotIn("X-Evil", headers)
        self.assertEqual(list(self.shared.data.rglob("evil.jpg")), [])

    def test_06_tus(self):
        flight = self.shared.new_flight()
        good = {**TUS, **tus_metadata(flight)}
        for length in ("-1", "1e9", "99999999999999999999", "0x5"):
            self.refused("POST", "/api/v1/uploads", None, {**good, "Upload-Length": length}, (400, 413))
        for text in ("flight !!", "flight " + base64.b64encode(b"x\r\nX: y").decode(), "a YQ==,a YQ=="):
            self.refused("POST", "/api/v1/uploads", None, {**TUS, "Upload-Length": "5", "Upload-Metadata": text})
        place = self.shared.request("POST", "/api/v1/uploads", None, {**good, "Upload-Defer-Length": "1"})[1]["Location"]
        offset = {**CHUNK, "Upload-Offset": "0"}
        self.refused("PATCH", place, b"x", {**CHUNK, "Upload-Offset": "3"}, (409,))
        self.refused("PATCH", place, b"01234", {**offset, "Upload-Checksum": "sha256 AAAA"}, (400, 460))
        wrong = base64.b64encode(bytes(32)).decode()
        self.refused("PATCH", place, b"01234", {**offset, "Upload-Checksum": "sha256 " + wrong}, (460,))
        self.assertEqual(self.shared.request("PATCH", place, b"01234", {**offset, "Upload-Length": "10"})[0], 204)
        at = {**CHUNK, "Upload-Offset": "5"}
        self.refused("PATCH", place, b"5", {**at, "Upload-Length": "12"}, (409,))
        side_by_side([lambda: self.shared.request("PATCH", place, b"56789", at)] * 2)
        # One may have cut the other off: as the protocol has it, whoever was refused asks where to go on.
        done = int(self.shared.request("HEAD", place, headers=TUS)[1]["Upload-Offset"])
        if done < 10:
            self.shared.request("PATCH", place, b"0123456789"[done:], {**CHUNK, "Upload-Offset": str(done)})
        self.refused("PATCH", place, b"x", {**CHUNK, "Upload-Offset": "10"}, (413,))
        [stored] = photos_of(self.shared.data, flight)
        self.assertEqual(stored.read_bytes(), b"0123456789")

    def test_07_archives(self):
        one = zip_of(("a.jpg", b"x" * 5000))
        local, directory = one[: one.index(b"PK\1\2")], one[one.index(b"PK\1\2") : one.index(b"PK\5\6")]
        end = struct.pack("<IHHHHIIH", 0x06054B50, 0, 0, 200, 200, len(directory) * 200, len(local), 0)
        overlapping = local + directory * 200 + end  # one body, two hundred names for it
        nested = zip_of(("inner.zip", zip_of(("b.zip", zip_of(("c", bytes(1 << 20)), method=zipfile.ZIP_DEFLATED)))))
        huge = bytearray(one)
        struct.pack_into("<I", huge, one.index(b"PK\1\2") + 24, 0xFFFFFFFF)  # "see the zip64 field", which is not there
        polyglot = self.photos[0][1] + one
        files = f"/api/v1/flights/{self.shared.new_flight()}/files"
        for name, content in (("overlap.zip", overlapping), ("nested.zip", nested), ("zip64.zip", bytes(huge)), ("cut.zip", one[:-30])):
            status, _, body = self.shared.request("PUT", f"{files}/{name}", content)
            listed = self.shared.json("GET", files)[1]["files"]
            self.assertTrue(status == 422 or sum(file["bytes"] for file in listed) <= 5000, (name, status, body))
            for file in listed:
                self.shared.request("DELETE", f"{files}/{file['name']}")
        self.assertEqual(self.shared.request("PUT", f"{files}/photo.jpg", polyglot)[0], 201)
        self.assertEqual([file["bytes"] for file in self.shared.json("GET", files)[1]["files"]], [len(polyglot)])

    def map_of_good_and(self, bad):
        """The report of a job over the good photos and these files, which must not stop it."""
        made = self.shared.stitched([*self.photos, *bad.items()], options='{"gsd_m": 0.4}')
        self.assertEqual(made["job"]["attempts"], 1, made["job"])
        _, report = self.shared.json("GET", f"/api/v1/flights/{made['flight']['id']}/report")
        self.assertNotIn("root:", json.dumps(report))
        left_out = {photo["name"]: photo["reason"] for photo in report["left_out_photos"]}
        self.assertTrue(all(left_out.values()))
        self.assertFalse(left_out.keys() & {name for name, _ in self.photos}, left_out)
        return left_out

    def test_08_images(self):
        photo = self.photos[0][1]
        frame = photo.index(b"\xff\xc0")
        giant = photo[: frame + 5] + b"\xff\xff\xff\xff" + photo[frame + 9 :]
        loop = b"II*\0\x08\0\0\0" + struct.pack("<HHHIII", 1, 0x100, 3, 0xFFFFFFFF, 8, 8)
        vrt = (b'<VRTDataset rasterXSize="9" rasterYSize="9"><VRTRasterBand dataType="Byte" band="1"><SimpleSource>'
               b"<SourceFilename>/etc/passwd</SourceFilename></SimpleSource></VRTRasterBand></VRTDataset>")
        bad = {"giant.jpg": giant, "loop.tif": loop, "vrt.tif": vrt, "svg.jpg": b"<svg onload='alert(1)'/>", "cut.jpg": photo[:4096]}
        left_out = self.map_of_good_and({**bad, "script.jpg": self.photos[1][1] + b"<script>alert(1)</script>"})
        self.assertLessEqual(bad.keys(), left_out.keys())

    def test_09_logs(self):
        head = "t_s,lat_deg,lon_deg,height_m\n"
        self.map_of_good_and({
            "line.csv": head.encode() + b"9" * (4 << 20), "nul.csv": head.encode() + b"1,2,3\0,4\n" * 99,
            "wide.csv": head.encode("utf-16"), "nan.csv": (head + "1,nan,inf,-nan\n" * 99).encode(),
            "back.csv": (head + "".join(f"{-n},46.8,7.1,500\n" for n in range(99))).encode(),
            "far.csv": (head + "1,1e308,-1e308,1e308\n" * 99).encode(), "cell.csv": (head + "=cmd|' /C calc'!A0,1,2,3\n").encode()})

    def test_10_json(self):
        for bad in ("[" * 100_000, '{"name":1}', '{"name":null}', '{"nme":"x"}', '{"name":"\\ud800"}', '{"options":{"gsd_m":1e400}}',
                    '{"options":{"gsd_m":"1"}}', '{"options":{"quality":9007199254740993}}', '{"options":[]}', "nul", '"x"'):
            self.refused("POST", "/api/v1/flights", bad, AS_JSON, (400, 413, 422))
        # Of two equal names the last counts, for every reader alike.
        status, _, body = self.shared.request("POST", "/api/v1/flights", '{"name":"a","name":"b"}', AS_JSON)
        self.assertEqual((status, json.loads(body)["name"]), (201, "b"))
        for path in (f"/api/v1/flights/{self.map_id}/jobs", "/ogc/processes/stitch/execution"):
            for bad in ('{"priority":"high"}', '{"inputs":{"flight":1}}', '{"what":1}', "[" * 100_000):
                self.refused("POST", path, bad, AS_JSON, (400, 413, 422))
        far = '{"type":"FeatureCollection","features":[{"type":"Feature","id":"a","geometry":{"type":"Point","coordinates":[1e400,0]},"properties":{"name":"x"}}]}'
        for bad in ("", "[" * 100_000, "{}", '{"type":"FeatureCollection","features":{}}', '{"type":"FeatureCollection","features":[{}]}', far, far.replace("1e400", "181"), " " * 2_000_000):
            self.refused("PUT", f"/api/v1/flights/{self.map_id}/notes", bad, {"Content-Type": "application/geo+json"}, (400, 413, 422))

    def test_11_scripts_in_names(self):
        status, headers, page = self.shared.request("GET", "/")
        self.assertIn("default-src 'self'", headers["Content-Security-Policy"])
        self.assertEqual((status, headers["X-Content-Type-Options"]), (200, "nosniff"))
        self.assertNotIn(b"onerror", page)
        self.assertEqual(self.tilejson["name"], EVIL)
        for path in (f"/wmts/{self.map_id}?SERVICE=WMTS&REQUEST=GetCapabilities", f"/connect/{self.map_id}/josm.xml",
                     f"/wms/{self.map_id}?SERVICE=WMS&REQUEST=GetCapabilities", f"/connect/{self.map_id}/qgis.qlr",
                     f"/tms/1.0.0/{self.map_id}"):
            status, headers, body = self.shared.request("GET", path)
            self.assertEqual((status, headers["X-Content-Type-Options"]), (200, "nosniff"), path)
            self.assertNotIn(b"<img", body, path)
            told = xml_parser.fromstring(body)
            said = [text for element in told.iter() for text in (element.text, *element.attrib.values()) if text]
            self.assertTrue(any(EVIL in text for text in said), path)
        status, _, body = self.shared.request("GET", f"/wms/{self.map_id}", '<?xml version="1.0"?><!DOCTYPE a [<!ENTITY b SYSTEM "file:///etc/passwd">]>')
        self.assertNotIn(b"root:", body)

    def test_12_who_may(self):
        data = tempfile.mkdtemp(dir=self.scratch)
        add = lambda name, scope: add_token(data, name, "--scope", scope)
        one, other = add("one", "upload"), add("other", "upload")
        server = self.serve("--workers", "0", data=data)
        as_one, as_other = (bearer(token) for token in (one, other))
        # Without a token each operation of the contract is refused, but what monitors ask and what the page needs to ask for one.
        open_to_all = set()
        for template, operations in contract.SPEC["paths"].items():
            for method in operations.keys() & {"get", "put", "post", "patch", "delete"}:
                path = template.replace("{", "").replace("}", "")
                status, _, body = server.request(method.upper(), path)
                if status != 401 and b"Invalid authentication token" not in body:
                    open_to_all.add((method, template))
        self.assertEqual(open_to_all, {("post", "/auth/login"), ("post", "/auth/register")} | {("get", template) for template in (
            "/auth/info", "/basemap.json", "/basemap.pmtiles", "/docs", "/healthz", "/openapi.json", "/readyz", "/version")})
        # What one began to upload is not another's to go on with.
        made = server.request("POST", "/api/v1/uploads", None, {**TUS, **as_one, "Upload-Length": "5", **tus_metadata(server.new_flight(headers=as_one))})
        self.assertEqual(made[0], 201)
        for method, headers in (("HEAD", TUS), ("PATCH", {**CHUNK, "Upload-Offset": "0"}), ("DELETE", TUS)):
            self.assertIn(server.request(method, made[1]["Location"], headers={**headers, **as_other})[0], (403, 404), method)
        _, headers, _ = server.request("GET", f"/api/v1/flights?token={one}", headers={"Origin": "https://evil.example"})
        self.assertNotIn("Access-Control-Allow-Credentials", headers)
        self.assertNotIn(one, server.errors())
        self.assertEqual(server.stop(), 0)

    def test_13_requests_to_the_inside(self):
        heard = []
        inside = socket.create_server(("127.0.0.1", 0))
        inside.settimeout(0.1)
        port = inside.getsockname()[1]
        server = self.serve("--webhooks", "public")
        spellings = ("127.0.0.1", "localhost", "[::1]", "[::ffff:127.0.0.1]", "2130706433", "0x7f.1", "127.1", "0.0.0.0")
        taken = [spelling for spelling in (*spellings, "169.254.169.254")
                 if server.json("POST", "/api/v1/webhooks", {"url": f"http://{spelling}:{port}/"})[0] == 201]
        server.wait_for_job(server.begun([("notes.jpg", b"no picture")])[1])

        def is_over():
            """All have been refused; until then whoever connects is written down."""
            try:
                heard.append(inside.accept()[1])
            except TimeoutError:
                pass
            return server.errors().count("private address") >= len(taken)
        wait_until(is_over, "not all were refused")
        inside.close()
        self.assertEqual(heard, [])
        self.assertIn("error", server.json("POST", "/task/new?", None, code=200)[1])

    def test_14_other_hosts(self):
        self.assertEqual(self.shared.request("GET", f"/tiles/{self.map_id}.json", headers={"Host": "evil.example"})[0], 421)
        forged = {"X-Forwarded-Host": "evil.example", "X-Forwarded-Proto": "gopher", "Forwarded": "host=evil.example"}
        for path in (f"/tiles/{self.map_id}.json", f"/wmts/{self.map_id}?SERVICE=WMTS&REQUEST=GetCapabilities", "/ogc/collections"):
            status, _, body = self.shared.request("GET", path, headers=forged)
            self.assertEqual((status, b"evil.example" in body), (200, False), path)
        self.assertNotIn("evil", self.shared.request("POST", "/api/v1/flights", "{}", {**AS_JSON, **forged})[1]["Location"])

    def test_15_sql(self):
        quoted = "%27%3B%20DROP%20TABLE%20flight%3B--"
        for path in ("/api/v1/flights?cursor=", "/api/v1/flights?limit=", "/api/v1/jobs/", "/ogc/collections?cursor=", "/api/v1/events?flight=",
                     f"/api/v1/flights/{self.map_id}/files/", "/task/", "/api/v1/events?after="):
            status, _, body = self.shared.request("GET", path + quoted)
            self.assertIn(status, (400, 404), (path, body))
        self.assertEqual(in_catalogue(self.shared.data, "SELECT name FROM flight WHERE id = ?", self.map_id), [(EVIL,)])

    def test_16_exhaustion(self):
        for crs in ("EPSG:3857", "EPSG:4326"):
            self.refused("GET", f"/wms/{self.map_id}?request=GetMap&layers=map&styles=&version=1.3.0&crs={crs}&bbox=1,2,3,4"
                         "&width=100000&height=100000&format=image/png")
        x, y = middle_of(self.tilejson["bounds"], self.tilejson["maxzoom"])
        tile = f"/tiles/{self.map_id}/{self.tilejson['maxzoom']}/{x}/{y}"
        if POSTGRES is None:
            self.check_a_held_catalogue(tile)
        # Many who listen for events hinder nobody. Each is answered before the next one asks: that many who only
        # wait for a thread are refused, the tile among them, is another bound.
        listening = []
        answers = []
        for _ in range(200):
            client = socket.create_connection(("127.0.0.1", self.shared.port), timeout=120)
            listening.append(client)
            client.sendall(b"GET /api/v1/events HTTP/1.1\r\nHost: localhost\r\n\r\n")
            answers.append(client.recv(12))
        self.assertEqual(set(answers), {b"HTTP/1.1 200"})
        self.assertEqual(self.shared.request("GET", tile)[0], 200)
        for client in listening:
            client.close()
        # (UBSan looks at an object's type through a pipe: without descriptors left it takes every object for a wrong one.)
        if "ASAN_OPTIONS" not in os.environ:
            self.serves_on_once_there_are_descriptors()

    def check_a_held_catalogue(self, tile):
        """Another program holds it: what is read is answered, what is written waits its turn."""
        with sqlite3.connect(self.shared.data / "catalogue.db", isolation_level=None) as catalogue:
            catalogue.execute("BEGIN IMMEDIATE")
            written = threading.Thread(target=self.shared.new_flight)
            written.start()
            self.assertEqual(self.shared.request("GET", tile)[0], 200)
            catalogue.execute("ROLLBACK")
        written.join()

    def serves_on_once_there_are_descriptors(self):
        """More connections than the system has descriptors for: some wait, all is well once there is room."""
        few = lambda: resource.setrlimit(resource.RLIMIT_NOFILE, (64, 64))
        small = subprocess.Popen([BINARY, "serve", "--data", self.data, "--listen", "127.0.0.1:0", "--workers", "0"], preexec_fn=few,
                                 stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        try:
            port = int(small.stdout.readline().strip("/\n").rsplit(":", 1)[1])
            crowd = [socket.create_connection(("127.0.0.1", port)) for _ in range(200)]
            for client in crowd:
                client.close()
            self.assertEqual(raw(port, b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n"), 200)
        finally:
            small.terminate()
            self.assertEqual(small.wait(timeout=120), 0)
            small.stdout.close()
