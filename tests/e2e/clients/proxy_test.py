"""The server behind nginx, below a path: one that leaves the path in place, and one that takes it off and says so."""
import http.client
import json
import pathlib
import shutil
import socket
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.parse
import urllib.request

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from server_support import BINARY, Server, ServerTestCase, catalogue_words, path_of, tile_of, wait_until  # noqa: E402

NGINX = shutil.which("nginx") or shutil.which("nginx", path="/usr/sbin")
CONF = """daemon off; worker_processes 1; pid {folder}/pid; error_log {folder}/error.log;
events {{ worker_connections 64; }}
http {{
  access_log off; client_max_body_size 0; client_body_temp_path {folder}/body; proxy_temp_path {folder}/proxy;
  fastcgi_temp_path {folder}/f; uwsgi_temp_path {folder}/u; scgi_temp_path {folder}/s;
  {more}
  server {{ listen 127.0.0.1:{port}; {locations} }}
}}
"""
BELOW_PATHS = """
    location /skyquilt {{ proxy_pass http://127.0.0.1:{kept}; }}
    location /stripped/ {{ proxy_pass http://127.0.0.1:{stripped}/; proxy_set_header X-Forwarded-Prefix /stripped;
                           proxy_set_header X-Forwarded-Proto https; proxy_set_header X-Forwarded-Host maps.example.org; }}
"""
KEEPING = """
    location / {{ proxy_pass http://127.0.0.1:{server}; proxy_cache kept; add_header X-Cache $upstream_cache_status; }}
"""


def free_port():
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        return taken.getsockname()[1]


def start_nginx(folder, port, locations, more):
    conf = pathlib.Path(folder, "nginx.conf")
    conf.write_text(CONF.format(folder=folder, port=port, locations=locations, more=more))
    nginx = subprocess.Popen([NGINX, "-c", str(conf), "-p", folder, "-e", f"{folder}/error.log"])
    for _ in range(100):
        with socket.socket() as probe:
            if probe.connect_ex(("127.0.0.1", port)) == 0:
                break
        time.sleep(0.1)
    return nginx


@unittest.skipIf(NGINX is None, "nginx is not here")
class Proxy(ServerTestCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.kept = Server(tempfile.mkdtemp(dir=cls.scratch), "--base-path", "/skyquilt")
        cls.stripped = Server(tempfile.mkdtemp(dir=cls.scratch), "--trusted-proxy", "127.0.0.1", "--host", "maps.example.org")
        cls.port = free_port()
        cls.nginx = start_nginx(tempfile.mkdtemp(dir=cls.scratch), cls.port,
                                BELOW_PATHS.format(kept=cls.kept.port, stripped=cls.stripped.port),
                                "proxy_set_header Host $http_host; proxy_request_buffering off; proxy_buffering off;")
        photos = pathlib.Path(tempfile.mkdtemp(dir=cls.scratch))
        for name, content in cls.photos[:4]:
            photos.joinpath(name).write_bytes(content)
        cls.base = f"http://127.0.0.1:{cls.port}/skyquilt"
        subprocess.run([BINARY, "upload", str(photos), "--server", cls.base], check=True, capture_output=True)
        cls.flight = cls.get("/skyquilt/api/v1/flights")["flights"][0]

    @classmethod
    def tearDownClass(cls):
        cls.nginx.terminate()
        cls.nginx.wait()
        for server in (cls.kept, cls.stripped):
            server.stop()
        super().tearDownClass()

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
    """nginx with a cache and its usual key, which knows of no tokens."""

    def test_what_a_token_opened_is_never_answered_without_one(self):
        server = self.serve()
        status, made = server.upload(self.photos[:4])
        self.assertEqual(status, 201, made)
        server.wait_for_job(made["job"]["id"])
        flight = made["flight"]["id"]
        tilejson = server.json("GET", f"/tiles/{flight}.json")[1]
        zoom, (west, south, east, north) = tilejson["minzoom"], tilejson["bounds"]
        x, y = tile_of((west + east) / 2, (south + north) / 2, zoom)
        tile = path_of(tilejson["tiles"][0].replace("{z}", str(zoom)).replace("{x}", str(x)).replace("{y}", str(y)))
        paths = [tile + "&empty=blank", tile.split("?")[0], f"/tiles/{flight}.json", f"/api/v1/flights/{flight}/thumbnail.png", "/wmts",
                 f"/api/v1/flights/{flight}/download.mbtiles", "/wms?service=WMS&request=GetCapabilities"]
        port, folder = free_port(), tempfile.mkdtemp(dir=self.scratch)
        nginx = start_nginx(folder, port, KEEPING.format(server=server.port), f"proxy_cache_path {folder}/kept keys_zone=kept:1m;")
        self.addCleanup(lambda: (nginx.terminate(), nginx.wait()))

        def get(path, **headers):
            connection = http.client.HTTPConnection("127.0.0.1", port, timeout=60)
            try:
                connection.request("GET", path, headers=headers)
                answer = connection.getresponse()
                answer.read()
                return answer.status, answer.headers["X-Cache"]
            finally:
                connection.close()

        self.assertEqual([get(tile)[1] for _ in range(2)], ["MISS", "HIT"])  # of an open server it keeps them
        token = subprocess.run([BINARY, "token", "add", "one", "--scope", "read", "--data", self.data, *catalogue_words(self.data)],
                               check=True, capture_output=True, text=True).stdout.strip()
        wait_until(lambda: server.request("GET", tile)[0] == 401, "the token closes nothing")
        for path in paths:
            self.assertEqual(get(path, Authorization=f"Bearer {token}")[0], 200, path)
            self.assertEqual(get(path)[0], 401, path)
            self.assertEqual(get(path, Authorization="Bearer sq_guess")[0], 401, path)


if __name__ == "__main__":
    unittest.main()
