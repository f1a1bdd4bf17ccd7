"""The server behind nginx, below a path: one that leaves the path in place, and one that takes it off and says so."""
import json
import pathlib
import re
import ssl
import tempfile
import unittest
import urllib.error
import urllib.parse
import urllib.request

from nginx import CONFIGURATIONS, NGINX, OPENSSL, free_port, http_of, start_nginx
from program import run
from server_support import Server, ServerTestCase, add_token, middle_tile, put_map, wait_until

BELOW_PATHS = """
  client_max_body_size 0; proxy_set_header Host $http_host; proxy_request_buffering off; proxy_buffering off;
  server {{
    listen 127.0.0.1:{port};
    location /skyquilt {{ proxy_pass http://127.0.0.1:{kept}; }}
    location /stripped/ {{ proxy_pass http://127.0.0.1:{stripped}/; proxy_set_header X-Forwarded-Prefix /stripped;
                           proxy_set_header X-Forwarded-Proto https; proxy_set_header X-Forwarded-Host maps.example.org; }}
  }}
"""
KEEPING = """
  proxy_cache_path {folder}/kept keys_zone=kept:1m;
  server {{
    listen 127.0.0.1:{port};
    location / {{ proxy_pass http://127.0.0.1:{server}; proxy_cache kept; {key} add_header X-Cache $upstream_cache_status always; }}
  }}
"""


@unittest.skipIf(NGINX is None, "nginx is not here")
class Proxy(ServerTestCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.kept = Server(tempfile.mkdtemp(dir=cls.scratch), "--base-path", "/skyquilt")
        cls.stripped = Server(tempfile.mkdtemp(dir=cls.scratch), "--trusted-proxy", "127.0.0.1", "--host", "maps.example.org")
        for server in (cls.kept, cls.stripped):
            cls.addClassCleanup(server.stop)
        cls.port = free_port()
        start_nginx(cls, tempfile.mkdtemp(dir=cls.scratch), cls.port,
                    BELOW_PATHS.format(port=cls.port, kept=cls.kept.port, stripped=cls.stripped.port))
        photos = pathlib.Path(tempfile.mkdtemp(dir=cls.scratch))
        for name, content in cls.photos[:4]:
            photos.joinpath(name).write_bytes(content)
        cls.base = f"http://127.0.0.1:{cls.port}/skyquilt"
        run("upload", str(photos), "--server", cls.base)
        cls.flight = cls.get("/skyquilt/api/v1/flights")["flights"][0]

    @classmethod
    def open(cls, path, body=None, **headers):
        request = urllib.request.Request(urllib.parse.urljoin(f"http://127.0.0.1:{cls.port}", path), data=body, headers=headers)
        return urllib.request.urlopen(request, timeout=60)

    @classmethod
    def get(cls, path):
        with cls.open(path) as answer:
            return json.loads(answer.read())

    def test_every_address_that_is_given_out_leads_somewhere(self):
        """From the lists on, whatever names an address of this server carries the path, and answers."""
        flight_id = self.flight["id"]
        seen, left = set(), [f"{self.base}{path}" for path in (
            "/api/v1/flights", "/stac", "/ogc", "/tiles/index.json", f"/stac/{flight_id}", f"/ogc/collections/{flight_id}.photos/items")]
        while left:
            address = left.pop()
            if address in seen or "{" in address:
                continue
            seen.add(address)
            with self.open(address) as answer:
                self.assertEqual(answer.status, 200, address)
                if "json" not in answer.headers["Content-Type"] or "openapi" in address or "photos.geojson" in address:
                    continue
                left += self.addresses_in(json.loads(answer.read()))
        self.assertGreater(len(seen), 25, seen)

    def addresses_in(self, value):
        if isinstance(value, dict):
            return [found for one in value.values() for found in self.addresses_in(one)]
        if isinstance(value, list):
            return [found for one in value for found in self.addresses_in(one)]
        if isinstance(value, str) and (value.startswith("/") or value.startswith(f"http://127.0.0.1:{self.port}")):
            address = urllib.parse.urljoin(self.base, value)
            self.assertTrue(address.startswith(self.base + "/") or address == self.base, value)
            return [address]
        return []

    def test_capabilities_and_tiles(self):
        flight_id = self.flight["id"]
        for path in ("/wmts", "/wms", f"/wmts/{flight_id}", f"/tms/1.0.0/{flight_id}", f"/connect/{flight_id}/gdal.xml"):
            with self.open(self.base + path) as answer:
                text = answer.read().decode()
            self.assertIn(self.base + "/", text, path)
            self.assertNotIn(f"127.0.0.1:{self.port}/w", text.replace(self.base, ""), path)
        tilejson = self.get(self.flight["tilejson"])
        west, south, east, north = tilejson["bounds"]
        self.assertTrue(tilejson["tiles"][0].startswith(self.base), tilejson)
        self.assertLess(west, east)

    def test_the_page_lies_behind_its_slash(self):
        with self.open("/skyquilt") as answer:  # follows the redirect
            self.assertEqual(answer.geturl(), self.base + "/")
            page = answer.read().decode()
        self.assertIn('src="src/main.js"', page)
        with self.open("/skyquilt/src/main.js") as answer:
            self.assertEqual(answer.status, 200)

    def test_locations_carry_the_path(self):
        with self.open("/skyquilt/api/v1/flights", b'{"name":"x"}', **{"Content-Type": "application/json"}) as answer:
            self.assertTrue(answer.headers["Location"].startswith("/skyquilt/api/v1/flights/"))

    def test_a_proxy_that_strips_says_how_it_is_reached(self):
        self.assertTrue(self.get("/stripped/stac")["links"][0]["href"].startswith("https://maps.example.org/stripped/"))
        with self.open("/stripped/api/v1/flights", b'{"name":"x"}', **{"Content-Type": "application/json"}) as answer:
            self.assertTrue(answer.headers["Location"].startswith("/stripped/api/v1/flights/"))
        # Who is no trusted proxy is not believed.
        _, _, body = self.kept.request("GET", "/stac", headers={"X-Forwarded-Host": "evil.example.org", "X-Forwarded-Prefix": "/evil"})
        self.assertNotIn(b"evil", body)


@unittest.skipIf(NGINX is None, "nginx is not here")
class Keeping(ServerTestCase):
    """nginx that keeps answers of a server that asks for a token."""

    def begin(self, *options):
        """A server that is open, with a map; the port of the nginx that is to come before it."""
        self.flight = put_map(self.data)
        self.server = server = self.serve("--workers", "0", *options)
        self.folder, self.port = tempfile.mkdtemp(dir=self.scratch), free_port()
        self.at = f"http://127.0.0.1:{self.port}"
        self.tile = middle_tile(server.json("GET", f"/tiles/{self.flight}.json")[1], "minzoom")

    def keep(self, key=""):
        start_nginx(self, self.folder, self.port, KEEPING.format(folder=self.folder, port=self.port, server=self.server.port, key=key))

    def guard(self):
        """Has the server ask for tokens: two of them, a share's id, and what its link puts behind an address."""
        _, share = self.server.json("POST", f"/api/v1/flights/{self.flight}/shares", {})
        tokens = [add_token(self.data, name, "--scope", "admin") for name in ("one", "other")]
        wait_until(lambda: self.server.request("GET", self.tile)[0] == 401, "the token closes nothing")
        return *(f"Bearer {token}" for token in tokens), share["id"], f"token={share['token']}"

    def get(self, path, token=None):
        """(status, what nginx says of its cache)"""
        request = urllib.request.Request(self.at + path, headers={"Authorization": token} if token else {})
        try:
            with urllib.request.urlopen(request, timeout=60, context=ssl._create_unverified_context()) as answer:
                answer.read()
                return answer.status, answer.headers["X-Cache"]
        except urllib.error.HTTPError as refused:
            with refused:
                return refused.code, refused.headers["X-Cache"]

    def check_nobody_gets(self, path):
        for token in (None, "Bearer sq_guess"):
            self.assertEqual(self.get(path, token)[0], 401, (path, token))

    def test_what_a_token_opened_is_never_answered_without_one(self):
        """The usual key knows of no tokens."""
        self.begin()
        self.keep()
        self.assertEqual([self.get(self.tile)[1] for _ in range(2)], ["MISS", "HIT"])  # of an open server it keeps them
        one, _, share, query = self.guard()
        tile, tiles, flight = self.tile.split("?")[0], f"/tiles/{self.flight}.json", f"/api/v1/flights/{self.flight}"
        photo = self.photos[0][0]
        for path in (f"{self.tile}&empty=blank", tile, f"{self.tile}&index=vari", f"{tile}.png?index=vari", tiles, f"{tiles}?index=vari",
                     flight, *(f"{flight}/{last}" for last in ("thumbnail.png", "download.mbtiles", "download.tif", f"files/{photo}",
                                                               "report", "legend.png?index=vari")),
                     "/wmts", f"/wmts/{self.flight}", "/wms?service=WMS&request=GetCapabilities", f"/stac/{self.flight}"):
            behind = f"{path}{'&' if '?' in path else '?'}{query}"
            self.assertEqual([self.get(path, one) for _ in range(2)], [(200, "MISS")] * 2, path)
            self.assertEqual([self.get(behind)[0] for _ in range(2)], [200, 200], path)
            self.check_nobody_gets(path)
            self.assertEqual(self.get(behind + "x")[0], 401, path)
            self.assertEqual(self.get(path, one)[0], 200, path)  # nor is the refusal kept
        # What a link opened ends with it.
        self.assertEqual(self.server.request("DELETE", f"{flight}/shares/{share}", headers={"Authorization": one})[0], 204)
        self.assertEqual(self.get(f"{tile}?{query}")[0], 401)

    def test_a_cache_with_the_token_in_its_key_keeps_tiles(self):
        self.begin("--keyed-cache")
        self.keep(re.search(r"proxy_cache_key .*;", (CONFIGURATIONS / "nginx-cluster.conf").read_text()).group())
        one, other, _, query = self.guard()
        behind = f"{self.tile}&{query}"
        for path, token in ((self.tile, one), (self.tile, other), (behind, None), (f"{self.tile}&index=vari", one)):
            self.assertEqual([self.get(path, token) for _ in range(2)], [(200, "MISS"), (200, "HIT")], (path, token))
        for path in (self.tile, self.tile.split("?")[0], f"{self.tile}&index=vari", behind + "x", f"/tiles/{self.flight}.json"):
            self.check_nobody_gets(path)

    @unittest.skipIf(OPENSSL is None, "openssl is not here")
    def test_that_of_many_machines_keeps_tiles_by_token(self):
        """docker/nginx-cluster.conf: also what is private, for this key."""
        self.begin()
        ports = {80: free_port(), 443: self.port}
        self.at = f"https://127.0.0.1:{self.port}"
        nodes = dict.fromkeys(("api1", "api2", "tiles1", "tiles2"), self.server.port)
        start_nginx(self, self.folder, self.port, http_of("nginx-cluster.conf", self.folder, ports, nodes))
        one, other, _, query = self.guard()

        def fetched():
            metrics = self.server.request("GET", "/metrics", headers={"Authorization": one})[2].decode()
            return int(re.search(r'skyquilt_requests_total\{route="tile",status="2xx"\} (\d+)', metrics)[1])
        before = fetched()
        for number, (path, token) in enumerate(((self.tile, one), (self.tile, other), (f"{self.tile}&{query}", None)), 1):
            self.assertEqual([self.get(path, token)[0] for _ in range(3)], [200] * 3, (path, token))
            self.assertEqual(fetched() - before, number)
        for path in (self.tile, self.tile.split("?")[0], f"{self.tile}&{query}x", f"/tiles/{self.flight}.json", f"/api/v1/flights/{self.flight}/thumbnail.png"):
            self.check_nobody_gets(path)
