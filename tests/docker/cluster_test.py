"""The files for many machines, without a container engine: cluster.yaml is held against the program and nginx-cluster.conf,
and nginx is run by that configuration before nodes that write down what they are asked."""
import http.client
import http.server
import os
import pathlib
import re
import ssl
import subprocess
import tempfile
import threading
import time
import unittest

from nginx import NGINX, OPENSSL, free_port, http_of, start_nginx

ROOT = pathlib.Path(__file__).resolve().parents[2]
BINARY = pathlib.Path(os.environ.get("SKYQUILT_BINARY", ROOT / "build/release/bin/skyquilt")).resolve()
NODES = ("api1", "api2", "tiles1", "tiles2")
WAIT_S = 30


class Compose(unittest.TestCase):
    def setUp(self):
        try:
            import yaml
        except ImportError:
            self.skipTest("python3-yaml is not here")
        self.compose = yaml.safe_load((ROOT / "docker/cluster.yaml").read_text())
        self.services = self.compose["services"]

    def test_all_parts_are_there_and_name_each_other(self):
        self.assertEqual(set(self.services), {"postgres", "s3", "worker", "front", *NODES})
        for name, service in self.services.items():
            for needed, condition in service.get("depends_on", {}).items():
                self.assertIn(needed, self.services, name)
                if condition["condition"] == "service_healthy" and "healthcheck" not in self.services[needed]:
                    self.assertEqual(self.services[needed]["image"], "skyquilt", f"{name} waits for what has no health check")
            for volume in service.get("volumes", []):
                source = volume.split(":")[0]
                if source.startswith("./") and source != "./certs":
                    self.assertTrue((ROOT / "docker" / source).exists(), source)
                elif not source.startswith((".", "/")):
                    self.assertIn(source, self.compose["volumes"], name)
        reached = [name for name, service in self.services.items() if "ports" in service]
        self.assertEqual(reached, ["front"])

    def test_no_folder_is_shared(self):
        written = [volume.split(":")[0] for service in self.services.values() for volume in service.get("volumes", [])
                   if ":" in volume and not volume.startswith("./")]
        self.assertEqual(len(written), len(set(written)))
        self.assertNotIn("container_name", self.services["worker"])  # it could not be there four times
        self.assertNotIn("hostname", self.services["worker"])

    def test_what_it_says_to_the_program_the_program_takes(self):
        help_of = {word: subprocess.run([BINARY, word, "--help"], capture_output=True, text=True, check=True).stdout
                   for word in ("serve", "worker")}
        seen = set()
        for name in (*NODES, "worker"):
            service = self.services[name]
            for variable in service["environment"]:
                if variable.startswith("SKYQUILT_SERVE_"):
                    self.assertIn(f"(Env:{variable})", help_of["serve"], name)
            command = " ".join(service.get("command", []))
            if command:
                word = re.match(r"skyquilt (\w+) ", command).group(1)
                for option in re.findall(r" (--[\w-]+)", command):
                    self.assertRegex(help_of[word], rf"[ ,]{option}\b", name)
                    seen.add(option)
            self.assertEqual(service["environment"]["SKYQUILT_SERVE_WORKERS"], "0")
        self.assertLessEqual({"--catalogue", "--blobs", "--no-previews"}, seen)

    def test_one_node_alone_draws_previews_and_nginx_knows_which(self):
        # Said, for a server with no workers draws none by itself.
        drawing = [name for name in NODES if "--previews" in self.services[name].get("command", [])]
        text = (ROOT / "docker/nginx-cluster.conf").read_text()
        named = re.search(r"upstream preview_node \{(.*?)\}", text, re.S).group(1)
        self.assertEqual(re.findall(r"server (\w+):8080;", named), drawing)

    def test_nginx_names_the_nodes_that_there_are(self):
        text = (ROOT / "docker/nginx-cluster.conf").read_text()
        self.assertEqual(set(re.findall(r"server (\w+):8080;", text)), set(NODES))
        self.assertIn("./nginx-cluster.conf:/etc/nginx/conf.d/default.conf:ro", self.services["front"]["volumes"])
        kept = re.search(r"proxy_cache_path (\S+)", text).group(1)
        self.assertIn(kept, [place.split(":")[0] for place in self.services["front"]["tmpfs"]])  # keys hold tokens


class Node(http.server.ThreadingHTTPServer):
    """Answers as a server does whose map has revision 7, and writes down what it was asked."""
    daemon_threads = True

    def __init__(self, name):
        super().__init__(("127.0.0.1", 0), Answer)
        self.name, self.asked, self.may_end = name, [], threading.Event()
        threading.Thread(target=self.serve_forever, daemon=True).start()


class Answer(http.server.BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"

    def log_message(self, *_):
        pass

    def send(self, status, body=b"", **headers):
        self.send_response(status)
        for name, value in {"Content-Length": str(len(body)), **headers}.items():
            self.send_header(name.replace("_", "-"), value)
        self.end_headers()
        self.wfile.write(body)

    def do_GET(self):
        self.server.asked.append(("GET", self.path, self.headers.get("Authorization")))
        if self.path.startswith("/api/v1/events"):
            self.send_response(200)
            self.send_header("Content-Type", "text/event-stream")
            self.send_header("Transfer-Encoding", "chunked")
            self.end_headers()
            self.wfile.write(b"6\r\ndata:\n\r\n")
            self.wfile.flush()
            self.server.may_end.wait(WAIT_S)
            self.wfile.write(b"0\r\n\r\n")
        elif self.headers.get("If-None-Match") == '"tile"':
            self.send(304, ETag='"tile"')
        else:
            kept = "public, max-age=31536000, immutable" if "rev=7" in self.path else "public, max-age=60, must-revalidate"
            self.send(200, b"tile", ETag='"tile"', Cache_Control=kept, Vary="Accept")

    def do_PATCH(self):
        length = int(self.headers["Content-Length"])
        first = self.rfile.read(1000)
        self.server.asked.append(("begun", self.path, len(first)))
        rest = self.rfile.read(length - 1000)
        self.server.asked.append(("PATCH", self.path, 1000 + len(rest)))
        self.send(204)


@unittest.skipUnless(NGINX and OPENSSL, "nginx and openssl are not here")
class Front(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = scratch.name

    def start(self):
        self.nodes = {name: Node(name) for name in NODES}
        for node in self.nodes.values():
            self.addCleanup(node.server_close)
            self.addCleanup(node.shutdown)
            self.addCleanup(node.may_end.set)
        ports = {80: free_port(), 443: free_port()}
        self.port = ports[443]
        nodes = {name: node.server_address[1] for name, node in self.nodes.items()}
        start_nginx(self, self.folder, self.port, http_of("nginx-cluster.conf", self.folder, ports, nodes))

    def connect(self):
        connection = http.client.HTTPSConnection("127.0.0.1", self.port, timeout=WAIT_S, context=ssl._create_unverified_context())
        self.addCleanup(connection.close)
        return connection

    def get(self, path, **headers):
        connection = self.connect()
        connection.request("GET", path, headers={name.replace("_", "-"): value for name, value in headers.items()})
        answer = connection.getresponse()
        return answer.status, answer.read()

    def asked(self, *names):
        return [request for name in names or NODES for request in self.nodes[name].asked]

    def test_addresses_that_never_change_are_asked_for_once(self):
        self.start()
        for _ in range(3):
            self.assertEqual(self.get("/tiles/f/9/100/200?rev=7"), (200, b"tile"))
        self.assertEqual(len(self.asked()), 1)
        # A node that shows another revision says that it changes: its answer is not kept under this address.
        for _ in range(3):
            self.get("/tiles/f/9/100/200?rev=8")
        self.assertEqual(len(self.asked()), 4)
        self.assertEqual(self.get("/tiles/f/9/100/200", If_None_Match='"tile"'), (304, b""))
        self.assertEqual(self.get("/tiles/f/9/100/200?rev=7", If_None_Match='"tile"'), (304, b""))
        self.assertEqual(len(self.asked()), 5)

    def test_nobody_sees_what_was_kept_for_anothers_token(self):
        self.start()
        for token in ("Bearer one", "Bearer two", "Bearer one"):
            self.get("/tiles/f/9/100/200?rev=7", Authorization=token)
        self.get("/tiles/f/9/100/200?rev=7")
        self.get("/tiles/f/9/100/200?rev=7&token=three")
        self.assertEqual([token for _, _, token in self.asked("tiles1", "tiles2")], ["Bearer one", "Bearer two", None, None])
        self.assertEqual(self.asked("api1", "api2"), [])

    def test_a_tile_has_its_node_and_neighbours_have_the_same(self):
        self.start()
        for block in range(40):
            for tile in ((0, 0), (9, 9), (0, 0)):
                self.get(f"/tiles/f/17/{4000 + 10 * block + tile[0]}/{2000 + tile[1]}.png")
        places = [{re.sub(r"\d/(\d*)\d\.png", r"/\1", path) for _, path, _ in self.nodes[name].asked} for name in ("tiles1", "tiles2")]
        self.assertEqual(places[0] & places[1], set())
        self.assertEqual(len(places[0] | places[1]), 40)
        self.assertGreater(min(len(place) for place in places), 5)
        # The rest of the maps' addresses go where tiles go, previews to the node that draws them.
        self.get("/tiles/f.json")
        self.get("/tiles/f/9/1/2?rev=preview")
        self.assertEqual([path for _, path, _ in self.asked("api1", "api2")], ["/tiles/f/9/1/2?rev=preview"])
        self.assertEqual([path for _, path, _ in self.asked("api1")], ["/tiles/f/9/1/2?rev=preview"])

    def test_a_node_that_is_gone_is_stepped_over(self):
        self.start()
        for name in ("api1", "tiles1"):
            self.nodes[name].shutdown()
            self.nodes[name].server_close()
        for number in range(20):
            self.assertEqual(self.get(f"/tiles/f/17/{number}1/11")[0], 200)
            self.assertEqual(self.get("/api/v1/flights")[0], 200)

    def test_events_and_uploads_are_not_held_back(self):
        self.start()
        listener = self.connect()
        listener.request("GET", "/api/v1/events")
        self.assertEqual(listener.getresponse().read(6), b"data:\n")  # the answer has no end yet
        upload = self.connect()
        upload.putrequest("PATCH", "/api/v1/uploads/u")
        upload.putheader("Content-Length", "30000000")
        upload.endheaders()
        upload.send(bytes(100_000))
        end = time.monotonic() + WAIT_S
        while not any(request[0] == "begun" for request in self.asked("api1", "api2")):
            self.assertLess(time.monotonic(), end, "the body waits in nginx")
            time.sleep(0.05)
        for _ in range(299):
            upload.send(bytes(100_000))
        self.assertEqual(upload.getresponse().status, 204)
        self.assertIn(("PATCH", "/api/v1/uploads/u", 30_000_000), self.asked("api1", "api2"))

    def test_metrics_stay_inside(self):
        self.start()
        self.assertEqual(self.get("/metrics")[0], 404)
        self.assertEqual(self.asked(), [])
