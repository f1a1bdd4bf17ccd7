"""Two API nodes and two tile nodes on one catalogue and one store, nginx in front: an upload begun on one node and ended on
the other while the first is killed, and tiles without a wrong one while the map is replaced.

SKYQUILT_TILES (default 2000) says how many tiles."""
import concurrent.futures
import hashlib
import http.client
import json
import os
import pathlib
import random
import subprocess
import tempfile
import time
import unittest

import s3_store
from nginx import NGINX, free_port, start_nginx
from postgres_server import find_binaries, server_for
from program import BINARY
from server_support import AS_JSON, CHUNK, FORM, TUS, ServerTestCase, form, tile_of, tus_metadata, wait_until

TILES = int(os.environ.get("SKYQUILT_TILES", "2000"))
# As docs/cluster.md has it, without what needs root.
HTTP = """
  client_max_body_size 0;
  upstream api {{ {api} }}
  upstream tiles {{ hash $uri consistent; {tiles} }}
  proxy_http_version 1.1; proxy_set_header Connection ""; proxy_set_header Host $http_host;
  proxy_request_buffering off; proxy_next_upstream error timeout;
  server {{
    listen 127.0.0.1:{port};
    location /tiles/ {{ proxy_pass http://tiles; }}
    location / {{ proxy_pass http://api; }}
  }}
"""


@unittest.skipIf(find_binaries() is None, "PostgreSQL is not installed")
@unittest.skipIf(NGINX is None, "nginx is not installed")
class NodesTest(ServerTestCase):
    @classmethod
    def setUpClass(cls):
        cls.store = s3_store.store_for(cls)
        super().setUpClass()
        cls.postgres = server_for(cls)

    def setUp(self):
        super().setUp()
        name = pathlib.Path(self.data).name.lower()
        self.at = ("--catalogue", f"{self.postgres.url}&schema={name}", "--blobs", self.store.address(name))
        self.nodes = [self.node(f"node-{i}") for i in range(4)]
        folder = tempfile.mkdtemp(prefix="nginx_", dir=self.scratch)
        self.port = free_port()
        upstreams = [" ".join(f"server 127.0.0.1:{node.port} max_fails=1 fail_timeout=2s;" for node in pair)
                     for pair in (self.nodes[:2], self.nodes[2:])]
        start_nginx(self, folder, self.port, HTTP.format(port=self.port, api=upstreams[0], tiles=upstreams[1]))
        self.worker = subprocess.Popen([BINARY, "worker", "--data", f"{self.data}-worker", *self.at], stderr=subprocess.DEVNULL)
        wait_until(lambda: self.answers("/api/v1/flights"), "nginx does not answer")

    def tearDown(self):
        self.worker.terminate()
        self.worker.wait()
        super().tearDown()

    def node(self, name):
        return self.serve("--workers", "0", *self.at, data=f"{self.data}-{name}")

    def answers(self, path):
        try:
            return self.get(path)[0] == 200
        except OSError:
            return False

    def ask(self, method, path, body=None, headers=None, port=None):
        connection = http.client.HTTPConnection("127.0.0.1", port or self.port, timeout=60)
        try:
            connection.request(method, path, body, headers or {})
            response = connection.getresponse()
            return response.status, response.headers, response.read()
        finally:
            connection.close()

    def get(self, path, port=None):
        return self.ask("GET", path, port=port)

    def finished(self, job):
        def is_over():
            status, _, answer = self.get(f"/api/v1/jobs/{job}")
            return status == 200 and json.loads(answer)["finished_at"] is not None
        wait_until(is_over, "the job does not end")
        return json.loads(self.get(f"/api/v1/jobs/{job}")[2])["state"]

    def stitch(self, flight, options):
        status, _, answer = self.ask("POST", f"/api/v1/flights/{flight}/jobs", json.dumps({"options": options}),
                                     AS_JSON)
        self.assertIn(status, (200, 201, 202), answer)
        return json.loads(answer)["id"]

    def test_an_upload_goes_on_where_a_killed_node_left_it(self):
        first, second = self.nodes[:2]
        flight = json.loads(self.ask("POST", "/api/v1/flights", "{}", AS_JSON, first.port)[2])["id"]
        for name, content in self.photos[1:]:
            self.assertEqual(self.ask("PUT", f"/api/v1/flights/{flight}/files/{name}", content)[0] // 100, 2)
        name, content = self.photos[0]
        status, headers, answer = self.ask("POST", "/api/v1/uploads", None, {**TUS, **tus_metadata(flight, name), "Upload-Length": str(len(content))}, first.port)
        self.assertEqual(status, 201, answer)
        place = headers["Location"].split(str(first.port))[-1]
        half = len(content) // 2
        status, _, answer = self.ask("PATCH", place, content[:half], {**CHUNK, "Upload-Offset": "0"}, first.port)
        self.assertEqual(status, 204, answer)
        first.kill()
        # By nginx, which finds the node that is left.
        status, headers, _ = self.ask("HEAD", place, None, TUS)
        self.assertEqual((status, headers["Upload-Offset"]), (200, str(half)))
        status, _, answer = self.ask("PATCH", place, content[half:], {**CHUNK, "Upload-Offset": str(half)})
        self.assertEqual(status, 204, answer)
        self.assertEqual(self.get(f"/api/v1/flights/{flight}/files/{name}")[2], content)
        self.assertEqual(self.finished(self.stitch(flight, {})), "successful")
        for node in (second, *self.nodes[2:]):
            status, _, tilejson = self.get(f"/tiles/{flight}.json", node.port)
            self.assertEqual(status, 200)
            self.assertEqual(self.get(self.tiles_of(json.loads(tilejson), flight)[0] + "?empty=204", node.port)[0], 200)

    def tiles_of(self, tilejson, flight):
        west, south, east, north = tilejson["bounds"]
        addresses = []
        for zoom in range(tilejson["minzoom"], tilejson["maxzoom"] + 1):
            left, top = tile_of(west, north, zoom)
            right, bottom = tile_of(east, south, zoom)
            addresses += [f"/tiles/{flight}/{zoom}/{x}/{y}" for x in range(left, right + 1) for y in range(top, bottom + 1)]
        return addresses

    def test_no_tile_is_wrong_while_a_map_is_replaced(self):
        status, _, answer = self.ask("POST", "/api/v1/flights", form(files=self.photos), FORM)
        self.assertEqual(status, 202, answer)
        made = json.loads(answer)
        flight = made["flight"]["id"]
        self.assertEqual(self.finished(made["job"]["id"]), "successful")
        addresses = self.tiles_of(json.loads(self.get(f"/tiles/{flight}.json")[2]), flight)
        before = {address: self.digest(address + "?rev=1&empty=204") for address in addresses}
        job = self.stitch(flight, {"quality": 60})
        dice = random.Random(7)
        wanted = [dice.choice(addresses) for _ in range(TILES)]
        seen, versioned = [], []

        def fetch(number):
            address = wanted[number]
            while number > TILES // 2 and not over:
                time.sleep(0.05)  # half of them come after the map was replaced
            return address, self.digest(address + "?empty=204"), self.digest_and_life(address + "?rev=1&empty=204")

        over = []
        with concurrent.futures.ThreadPoolExecutor(8) as pool:
            answers = [pool.submit(fetch, number) for number in range(TILES)]
            self.assertEqual(self.finished(job), "successful")
            over.append(True)
            for answer in answers:
                address, now, then = answer.result()
                seen.append((address, now))
                versioned.append((address, then))
        time.sleep(3)  # a tile node looks a map up every so often
        after = {address: self.digest(address + "?empty=204") for address in addresses}
        self.assertNotEqual(before, after)
        for address, found in seen:
            self.assertIn(found, (before[address], after[address]), address)
        # What is called immutable is of the revision that its address names.
        for address, (found, is_immutable) in versioned:
            self.assertIn(found, (before[address],) if is_immutable else (before[address], after[address]), address)
        self.assertTrue(any(is_immutable for _, (_, is_immutable) in versioned))
        self.assertTrue(any(found == after[address] != before[address] for address, found in seen))

    def digest(self, address):
        return self.digest_and_life(address)[0]

    def digest_and_life(self, address):
        status, headers, content = self.get(address)
        self.assertIn(status, (200, 204), (address, content[:200]))
        return (status, hashlib.sha256(content).hexdigest()), "immutable" in headers["Cache-Control"]
