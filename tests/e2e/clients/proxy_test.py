"""The server behind nginx, below a path: one that leaves the path in place, and one that takes it off and says so."""
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
from server_support import BINARY, Server, ServerTestCase  # noqa: E402

NGINX = shutil.which("nginx") or shutil.which("nginx", path="/usr/sbin")
CONF = """daemon off; worker_processes 1; pid {folder}/pid; error_log {folder}/error.log;
events {{ worker_connections 64; }}
http {{
  access_log off; client_max_body_size 0; client_body_temp_path {folder}/body; proxy_temp_path {folder}/proxy;
  fastcgi_temp_path {folder}/f; uwsgi_temp_path {folder}/u; scgi_temp_path {folder}/s;
  proxy_set_header Host $http_host; proxy_request_buffering off; proxy_buffering off;
  server {{
    listen 127.0.0.1:{port};
    location /skyquilt {{ proxy_pass http://127.0.0.1:{kept}; }}
    location /stripped/ {{ proxy_pass http://127.0.0.1:{stripped}/; proxy_set_header X-Forwarded-Prefix /stripped;
                           proxy_set_header X-Forwarded-Proto https; proxy_set_header X-Forwarded-Host maps.example.org; }}
  }}
}}
"""


def free_port():
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        return taken.getsockname()[1]


@unittest.skipIf(NGINX is None, "nginx is not here")
class Proxy(ServerTestCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.kept = Server(tempfile.mkdtemp(dir=cls.scratch), "--base-path", "/skyquilt")
        cls.stripped = Server(tempfile.mkdtemp(dir=cls.scratch), "--trusted-proxy", "127.0.0.1")
        cls.port = free_port()
        folder = tempfile.mkdtemp(dir=cls.scratch)
        conf = pathlib.Path(folder, "nginx.conf")
        conf.write_text(CONF.format(folder=folder, port=cls.port, kept=cls.kept.port, stripped=cls.stripped.port))
        cls.nginx = subprocess.Popen([NGINX, "-c", str(conf), "-p", folder, "-e", f"{folder}/error.log"])
        for _ in range(100):
            with socket.socket() as probe:
                if probe.connect_ex(("127.0.0.1", cls.port)) == 0:
                    break
            time.sleep(0.1)
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


if __name__ == "__main__":
    unittest.main()
