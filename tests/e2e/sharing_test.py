"""Several who use one server: limits of a token, turns, OGC API Processes, and others who want to be told."""
import hashlib
import hmac
import http.server
import json
import os
import pathlib
import shutil
import socket
import ssl
import subprocess
import threading
import time
from unittest import mock

from server_support import AS_JSON, TUS, ServerTestCase, bearer, path_of, tus_metadata, wait_until


class Receiver(http.server.ThreadingHTTPServer):
    """Hears webhooks; refuses the first it hears."""

    def __init__(self, certificate=None):
        self.heard = []
        outer = self

        class Handler(http.server.BaseHTTPRequestHandler):
            def do_POST(self):
                body = self.rfile.read(int(self.headers["Content-Length"]))
                outer.heard.append((self.path, dict(self.headers), body))
                self.send_response(500 if len(outer.heard) == 1 else 204)
                self.end_headers()

            def log_message(self, *_):
                pass
        super().__init__(("127.0.0.1", 0), Handler)
        if certificate:
            tls = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
            tls.load_cert_chain(certificate)
            self.socket = tls.wrap_socket(self.socket, server_side=True)
        threading.Thread(target=self.serve_forever, daemon=True).start()


def is_held(connection):
    """Whether who sent something over it still waits for an answer."""
    connection.setblocking(False)
    try:
        while connection.recv(65536):
            pass
    except BlockingIOError:
        return True
    return False


class Sharing(ServerTestCase):
    def test_a_token_takes_what_it_may(self):
        few = self.token("few", "--scope", "upload", "--per-minute", "30")
        small = self.token("small", "--scope", "upload", "--most-gb", "0.001")
        admin = self.token("admin", "--scope", "admin")
        server = self.serve("--workers", "0")
        answers = [server.request("GET", "/api/v1/flights", headers=few) for _ in range(40)]
        self.assertEqual([status for status, _, _ in answers[:30]], [200] * 30)
        status, headers, _ = answers[-1]
        self.assertEqual(status, 429)
        self.assertIn("Retry-After", headers)
        self.assertEqual(server.request("GET", "/api/v1/flights", headers=small)[0], 200)
        self.assertEqual(server.json("GET", "/api/v1/access", headers=small)[1], {"needs_token": True, "scope": "upload", "flight": None, "keep_days": 0})
        _, made = server.json("POST", "/api/v1/flights", {}, small)
        files = f"/api/v1/flights/{made['id']}/files"
        self.assertEqual(server.request("PUT", f"{files}/a.jpg", bytes(600_000), small)[0], 201)
        self.assertIn(b"Delete a flight", server.request("PUT", f"{files}/b.jpg", bytes(600_000), small, code=413)[2])
        refused = server.request("POST", "/api/v1/uploads", headers={**small, **TUS, **tus_metadata(files.split("/")[4], "b.jpg"), "Upload-Length": "600000"})
        self.assertEqual(refused[0], 413)
        self.assertEqual(server.request("PUT", f"{files}/b.jpg", bytes(300_000), small)[0], 201)
        jobs = files.replace("/files", "/jobs")
        self.assertIn(b"admin", server.request("POST", jobs, '{"priority": 5}', {**small, **AS_JSON}, code=403)[2])
        self.assertEqual(server.json("POST", jobs, {"priority": 5}, admin, 202)[1]["priority"], 5)

    def test_notes_are_for_all_who_open_the_flight(self):
        writer = self.token("writer", "--scope", "upload")
        server = self.serve("--workers", "0")
        _, made = server.json("POST", "/api/v1/flights", {}, writer)
        flight = f"/api/v1/flights/{made['id']}"
        guest = bearer(server.json("POST", f"{flight}/shares", {"expires_in_days": 1}, writer)[1]["token"])

        def put(names, headers):
            notes = [{"type": "Feature", "id": name, "geometry": {"type": "Point", "coordinates": [7.44, 46.95]}, "properties": {"name": name}} for name in names]
            body = json.dumps({"type": "FeatureCollection", "features": notes})
            return server.request("PUT", f"{flight}/notes", body, {"Content-Type": "application/geo+json", **headers})
        status, headers, _ = put(["well"], writer)
        self.assertEqual(status, 200)
        known = {**writer, "If-Match": headers["ETag"]}
        self.assertEqual(put([], writer)[0], 412, "nobody's notes go without a word of which")
        self.assertEqual(put(["well", "gate"], known)[0], 200)
        self.assertEqual(put(["tree"], known)[0], 412, "another was first")
        self.assertEqual(put(["guest"], guest)[0], 403)
        _, notes = server.json("GET", f"{flight}/notes", headers=guest, code=200)
        self.assertEqual([note["id"] for note in notes["features"]], ["well", "gate"])
        self.assertEqual([file["name"] for file in server.json("GET", f"{flight}/files", headers=guest)[1]["files"]], ["map_notes.geojson"])
        server.stop()
        again = self.serve("--workers", "0")
        self.assertEqual(len(again.json("GET", f"{flight}/notes", headers=guest)[1]["features"]), 2, "they outlive a restart")

    def test_a_process_is_the_same_job(self):
        server = self.serve()
        flight = server.new_flight(self.photos)
        _, headers, body = server.request("POST", "/ogc/processes/stitch/execution",
                                               json.dumps({"inputs": {"flight": flight, "options": {"gsd_m": 0.4}}}),
                                               AS_JSON, code=201)
        info = json.loads(body)
        server.ended(info["jobID"])
        _, info = server.json("GET", path_of(headers["Location"]))
        self.assertEqual((info["status"], info["progress"]), ("successful", 100))
        _, results = server.json("GET", path_of(headers["Location"]) + "/results")
        self.assertEqual(server.request("GET", path_of(results["map"]["href"]))[0], 200)
        self.assertEqual(server.json("DELETE", path_of(headers["Location"]))[1]["status"], "dismissed")
        self.assertEqual(server.request("GET", path_of(headers["Location"]))[0], 404)
        # What it took tells how long the next one will take, from its first second on.
        _, job = server.json("POST", f"/api/v1/flights/{flight}/jobs", {"options": {"gsd_m": 0.4}})
        seen = server.wait_for_job(job["id"], until=lambda job: job["eta_s"] is not None or job["finished_at"])
        if not seen["finished_at"]:
            self.assertLessEqual(seen["eta_low_s"], seen["eta_s"])
            self.assertLessEqual(seen["eta_s"], seen["eta_high_s"])
            self.assertGreater(seen["eta_high_s"], 0)
        server.wait_for_job(job["id"])

    def test_others_are_told_once_it_is_allowed_and_signed(self):
        receiver = Receiver()
        url = f"http://127.0.0.1:{receiver.server_port}/hook?x=1"
        server = self.serve("--webhooks", "any")
        _, hook = server.json("POST", "/api/v1/webhooks", {"url": url}, code=201)
        _, listed = server.json("GET", "/api/v1/webhooks")
        self.assertEqual([("secret" in entry, entry["url"]) for entry in listed["webhooks"]], [(False, url)])
        server.wait_for_job(server.begun(self.photos[:2])[1])
        wait_until(lambda: len(receiver.heard) >= 3, f"only {len(receiver.heard)} were heard: {server.errors()}")
        for path, headers, body in receiver.heard:
            self.assertEqual(path, "/hook?x=1")
            at, signature = (part.split("=", 1)[1] for part in headers["X-Skyquilt-Signature"].split(","))
            self.assertEqual(signature, hmac.new(hook["secret"].encode(), f"{at}.".encode() + body, hashlib.sha256).hexdigest())
        first = json.loads(receiver.heard[0][2])
        again = [json.loads(body) for _, _, body in receiver.heard[1:]]
        self.assertIn(first, again)  # what was refused came a second time
        told = {entry["event"]: entry for entry in again}
        self.assertEqual(set(told), {"job", "map"})
        self.assertEqual(told["job"]["job"]["state"], "successful")
        self.assertEqual(server.request("DELETE", f"/api/v1/webhooks/{hook['id']}")[0], 204)
        receiver.shutdown()

    def test_a_receiver_that_does_not_answer_keeps_no_other_waiting(self):
        receiver = Receiver()
        with socket.create_server(("127.0.0.1", 0)) as silent:
            server = self.serve("--workers", "0", "--webhooks", "any")
            for port, path in ((silent.getsockname()[1], "/a"), (silent.getsockname()[1], "/b"), (receiver.server_port, "/")):
                server.json("POST", "/api/v1/webhooks", {"url": f"http://127.0.0.1:{port}{path}"}, code=201)
            server.json("DELETE", f"/api/v1/jobs/{server.begun([('notes.jpg', b'no picture')])[1]}")
            silent.settimeout(60)
            with silent.accept()[0] as one, silent.accept()[0] as other:
                wait_until(lambda: receiver.heard, f"the other was not told: {server.errors()}")
                self.assertEqual([is_held(one), is_held(other)], [True, True], "it was told after they had been given up")
        receiver.shutdown()

    def test_over_tls_only_those_are_told_whose_certificate_is_good(self):
        if shutil.which("openssl") is None:
            self.skipTest("openssl is not here")
        both = f"{self.data}.pem"
        subprocess.run(["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", "/CN=receiver", "-addext",
                        "subjectAltName=IP:127.0.0.1", "-keyout", f"{both}.key", "-out", f"{both}.crt"], check=True, capture_output=True)
        pathlib.Path(both).write_text("".join(pathlib.Path(both + part).read_text() for part in (".key", ".crt")))
        receiver = Receiver(both)

        def tell(host):
            """A job ends, and this host is to hear of it."""
            _, hook = server.json("POST", "/api/v1/webhooks", {"url": f"https://{host}:{receiver.server_port}/{host}"})
            server.wait_for_job(server.begun([("notes.jpg", b"no picture")])[1])
            return hook
        server = self.serve("--webhooks", "any")
        tell("127.0.0.1")
        wait_until(lambda: "SSL certificate problem" in server.errors(), "a certificate of nobody was taken")
        server.stop()
        self.assertEqual(receiver.heard, [])
        with mock.patch.dict(os.environ, {"SSL_CERT_FILE": f"{both}.crt"}):
            server = self.serve("--webhooks", "any")
        tell("localhost")  # a name that the certificate does not have
        wait_until(lambda: any(path == "/127.0.0.1" for path, _, _ in receiver.heard), f"nothing was heard: {server.errors()}")
        wait_until(lambda: "certificate subject name" in server.errors(), "another's certificate was taken")
        self.assertEqual({path for path, _, _ in receiver.heard}, {"/127.0.0.1"})
        receiver.shutdown()

    def test_nobody_is_told_by_default_and_nothing_private(self):
        server = self.serve("--workers", "0")
        self.assertEqual(server.json("POST", "/api/v1/webhooks", {"url": "http://example.org/"})[0], 403)
        server.stop()
        receiver = Receiver()
        server = self.serve("--webhooks", "public")
        for bad in ("ftp://example.org/", "http://a b/", "http://user@host/", "javascript:alert(1)"):
            self.assertEqual(server.json("POST", "/api/v1/webhooks", {"url": bad})[0], 422, bad)
        private = {"url": f"http://localhost:{receiver.server_port}/"}
        self.assertIn("private address", server.json("POST", "/api/v1/webhooks", private, code=422)[1]["detail"])
        self.assertEqual(server.json("GET", "/api/v1/webhooks")[1]["webhooks"], [])
        # One of before, where any were allowed, is not told either.
        server.stop()
        server = self.serve("--webhooks", "any")
        self.assertEqual(server.json("POST", "/api/v1/webhooks", private)[0], 201)
        server.stop()
        server = self.serve("--webhooks", "public")
        server.wait_for_job(server.begun([("notes.jpg", b"no picture")])[1])
        wait_until(lambda: "private address" in server.errors(), "nothing was said of the private address")
        time.sleep(0.5)
        self.assertEqual(receiver.heard, [])
        receiver.shutdown()
