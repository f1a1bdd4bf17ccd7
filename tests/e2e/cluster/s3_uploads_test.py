"""Resumable uploads (tus) whose bytes go to S3: what was acknowledged is there, whatever becomes of the server."""
import http.client
import pathlib
import random

from cluster.s3_support import S3TestCase
from server_support import CHUNK, TUS, tus_metadata

MIB = 1 << 20


class Uploads(S3TestCase):
    def begin(self, server, content):
        _, flight = server.json("POST", "/api/v1/flights", {})
        _, headers, _ = server.request("POST", "/api/v1/uploads", headers={
            **TUS, "Upload-Length": str(len(content)), **tus_metadata(flight["id"])}, code=201)
        return flight["id"], headers["Location"]

    def send(self, server, place, content, begin, end):
        status, headers, _ = server.request("PATCH", place, content[begin:end], {**CHUNK, "Upload-Offset": str(begin)})
        self.assertEqual((status, headers["Upload-Offset"]), (204, str(end)), server.errors())

    def offset(self, server, place):
        return int(server.request("HEAD", place, headers=TUS)[1]["Upload-Offset"])

    def check_whole(self, server, flight_id, content):
        self.assertEqual(server.request("GET", f"/api/v1/flights/{flight_id}/files/a.jpg")[2], content)
        self.assertEqual(self.keys("uploads/"), [])
        self.assertEqual(len(self.keys("flights/")), 1)
        for folder in ("uploads", "incoming"):
            self.assertEqual(list(pathlib.Path(self.data, folder).iterdir()), [])

    def test_what_was_acknowledged_outlives_the_server_and_its_disk(self):
        content = random.Random(1).randbytes(23 * MIB + 5)
        server = self.serve_s3("--workers", "0")
        flight_id, place = self.begin(server, content)
        self.send(server, place, content, 0, 20 * MIB)
        self.send(server, place, content, 20 * MIB, 20 * MIB + 700)
        self.assertGreaterEqual(len(self.keys("uploads/")), 3)
        server.kill()
        for folder in ("uploads", "incoming", "cache/flights"):  # nothing of it was needed
            for path in pathlib.Path(self.data, folder).glob("*"):
                self.fail(f"{path} lies in the data folder")
        server = self.serve_s3("--workers", "0")
        self.assertEqual(self.offset(server, place), 20 * MIB + 700)
        self.send(server, place, content, 20 * MIB + 700, len(content))
        self.check_whole(server, flight_id, content)

    def test_a_connection_that_breaks_keeps_what_came(self):
        content = random.Random(2).randbytes(5 * MIB)
        server = self.serve_s3("--workers", "0")
        flight_id, place = self.begin(server, content)
        connection = http.client.HTTPConnection("127.0.0.1", server.port)
        connection.putrequest("PATCH", place)
        for name, value in {**CHUNK, "Upload-Offset": "0", "Content-Length": str(len(content))}.items():
            connection.putheader(name, value)
        connection.endheaders()
        connection.send(content[:3 * MIB])
        connection.close()
        status = 409
        while status == 409:  # the server may read the broken connection yet: as a client, look where it is, and go on
            kept = self.offset(server, place)
            self.assertLessEqual(kept, 3 * MIB)
            status, _, _ = server.request("PATCH", place, content[kept:], {**CHUNK, "Upload-Offset": str(kept)})
        self.assertEqual(status, 204)
        self.check_whole(server, flight_id, content)

    def test_what_comes_at_once_is_put_once(self):
        content = random.Random(3).randbytes(2 * MIB)
        server = self.serve_s3("--workers", "0")
        flight_id, place = self.begin(server, content)
        self.send(server, place, content, 0, len(content))
        puts = [path for method, path, _, _ in self.proxy.asked if method == "PUT" and ("/files/" in path or "/uploads/" in path)]
        self.assertEqual(len(puts), 1, puts)
        self.check_whole(server, flight_id, content)

    def test_parts_become_one_file_and_what_is_given_up_goes(self):
        content = random.Random(4).randbytes(2 * MIB)
        server = self.serve_s3("--workers", "0")
        _, flight = server.json("POST", "/api/v1/flights", {})
        places = []
        for part in (content[:MIB], content[MIB:], content[:10]):
            _, headers, _ = server.request("POST", "/api/v1/uploads", headers={
                **TUS, "Upload-Concat": "partial", "Upload-Length": str(len(part))}, code=201)
            places.append(headers["Location"])
            self.send(server, places[-1], part, 0, len(part))
        self.assertEqual(server.request("DELETE", places.pop(), headers=TUS)[0], 204)
        self.assertEqual(len(self.keys("uploads/")), 2)
        server.request("POST", "/api/v1/uploads", headers={
            **TUS, **tus_metadata(flight["id"]), "Upload-Concat": "final;" + " ".join(places)}, code=201)
        self.check_whole(server, flight["id"], content)

    def test_a_store_that_fails_and_stalls_loses_no_byte(self):
        self.proxy.fails, self.proxy.stalls = 0.05, 0.01
        server = self.serve_s3("--workers", "0")
        for seed in range(3):
            content = random.Random(seed).randbytes(4 * MIB + seed)
            flight_id, place = self.begin(server, content)
            for begin in range(0, len(content), 300_000):
                self.send(server, place, content, begin, min(begin + 300_000, len(content)))
            self.assertEqual(server.request("GET", f"/api/v1/flights/{flight_id}/files/a.jpg")[2], content)
        self.assertGreater(self.proxy.faults, 3, "the proxy was too kind for this test")
