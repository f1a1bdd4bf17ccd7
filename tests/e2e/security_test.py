"""Who may do what, from outside: tokens, addresses, configuration."""
import os
import pathlib
import socket
import subprocess
import time

from program import BINARY, run
from server_support import AS_JSON, ServerTestCase, add_token, bearer, catalogue_words, storage_words, wait_until


class Security(ServerTestCase):
    def test_tokens_open_what_their_scope_says(self):
        read, upload, admin = (add_token(self.data, scope, "--scope", scope) for scope in ("read", "upload", "admin"))
        server = self.serve("--workers", "0")
        flights = "/api/v1/flights"
        self.assertEqual(server.request("GET", "/healthz")[0], 200)
        status, headers, _ = server.request("GET", flights)
        self.assertEqual((status, headers["WWW-Authenticate"]), (401, 'Bearer realm="skyquilt"'))
        self.assertEqual(server.request("GET", flights, headers=bearer("sq_guess"))[0], 401)
        self.assertEqual(server.request("GET", flights, headers=bearer(read))[0], 200)
        self.assertEqual(server.request("GET", f"{flights}?token={read}")[0], 200)
        self.assertEqual(server.request("POST", flights, "{}", {**AS_JSON, **bearer(read)})[0], 403)
        # In the address even a mighty token only reads.
        self.assertEqual(server.request("POST", f"{flights}?token={admin}", "{}", AS_JSON)[0], 403)
        _, headers, _ = server.request("POST", flights, "{}", {**AS_JSON, **bearer(upload)}, code=201)
        self.assertEqual(server.request("DELETE", headers["Location"], headers=bearer(read))[0], 403)
        self.assertEqual(server.request("GET", "/metrics", headers=bearer(upload))[0], 403)
        # Upload deletes what it made, and admin what anybody made.
        self.assertEqual(server.request("DELETE", headers["Location"], headers=bearer(upload))[0], 204)
        made = [server.request("POST", flights, "{}", {**AS_JSON, **bearer(token)})[1]["Location"] for token in (upload, admin)]
        self.assertEqual(server.request("DELETE", made[1], headers=bearer(upload))[0], 403)
        self.assertEqual([server.request("DELETE", path, headers=bearer(admin))[0] for path in made], [204, 204])
        # The node's clients send their token in the address, and take a refusal as an answer.
        self.assertIn(b"Invalid authentication token", server.request("GET", "/info", code=200)[2])
        self.assertEqual(server.request("GET", f"/info?token={read}")[0], 200)
        self.assertEqual(server.request("GET", f"/task/list?token={read}")[2], b"[]")
        for token in (read, upload, admin):
            self.assertNotIn(token, server.errors())
            catalogue = b"".join(path.read_bytes() for path in pathlib.Path(self.data).glob("catalogue.db*"))
            self.assertNotIn(token.encode(), catalogue)
        run("token", "revoke", "read", "--data", self.data, *catalogue_words(self.data))
        wait_until(lambda: server.request("GET", flights, headers=bearer(read))[0] == 401, "a revoked token goes on")
        listed = run("token", "list", "--data", self.data, *catalogue_words(self.data))
        self.assertEqual([line.split()[0] for line in listed.stdout.splitlines()], ["upload", "admin"])

    def test_others_are_let_in_only_with_a_token_or_a_word(self):
        asked = [BINARY, "serve", "--data", self.data, *storage_words(self.data), "--listen", "0.0.0.0:0", "--workers", "0"]
        self.assertIn("token add", self.refusal("--listen", "0.0.0.0:0", "--workers", "0"))
        self.token("one", "--scope", "read")
        server = subprocess.Popen(asked, stdout=subprocess.PIPE, text=True)
        self.assertIn("serving at", server.stdout.readline())
        server.terminate()
        self.assertEqual(server.wait(timeout=60), 0)
        server.stdout.close()

    def test_a_page_of_elsewhere_changes_nothing(self):
        server = self.serve("--workers", "0")
        headers = {**AS_JSON, "Origin": "http://evil.example"}
        self.assertEqual(server.request("POST", "/api/v1/flights", "{}", headers)[0], 403)
        server.request("GET", "/api/v1/flights", headers={"Host": "evil.example"}, code=421)

    def test_options_come_from_file_environment_and_command_line(self):
        config = pathlib.Path(self.scratch, "skyquilt.toml")
        config.write_text('workers = 0\npublic-url = "https://maps.example.org/"\n')
        server = self.serve("--config", str(config))
        self.assertEqual(server.json("GET", "/ogc")[1]["links"][0]["href"], "https://maps.example.org/ogc")
        self.assertEqual(server.workers(), [])
        server.stop()
        asked = [BINARY, "serve", "--data", self.data, "--listen", "127.0.0.1:0"]
        config.write_text("wrokers = 0\n")
        self.assertIn("wrokers", self.refusal("--listen", "127.0.0.1:0", "--config", str(config)))
        refused = subprocess.run(asked, capture_output=True, text=True, timeout=60,
                                 env={**os.environ, "SKYQUILT_SERVE_WROKERS": "1"})
        self.assertNotEqual(refused.returncode, 0)
        self.assertIn("SKYQUILT_SERVE_WROKERS", refused.stderr)

    def test_the_basemap_says_whose_it_is(self):
        text = "Makers <b>& Sons</b>, \u00a9 2026"
        config = pathlib.Path(self.scratch, "skyquilt.toml")
        config.write_text(f'workers = 0\nbasemap = "https://tiles.example/{{z}}/{{x}}/{{y}}.png"\nbasemap-attribution = "{text}"\n')
        server = self.serve("--config", str(config))
        basemap = {"tilejson": "3.0.0", "tiles": ["https://tiles.example/{z}/{x}/{y}.png"], "attribution": text, "public": []}
        self.assertEqual(server.json("GET", "/basemap.json"), (200, basemap))
        server.stop()
        self.assertIn("needs --basemap", self.refusal("--listen", "127.0.0.1:0", "--basemap-attribution", text))

    def test_without_a_choice_each_browser_may_choose_unless_the_operator_wants_none(self):
        server = self.serve("--workers", "0")
        basemap = server.json("GET", "/basemap.json")[1]
        self.assertEqual(basemap["tiles"], [])
        self.assertIn("openstreetmap", [one["name"] for one in basemap["public"]])
        policy = server.request("GET", "/")[1]["Content-Security-Policy"]
        for one in basemap["public"]:
            self.assertIn("/".join(one["tiles"][0].split("/")[:3]), policy)
        server.stop()
        server = self.serve("--workers", "0", "--basemap", "none")
        self.assertEqual(server.json("GET", "/basemap.json")[1], {"tilejson": "3.0.0", "tiles": [], "public": []})
        self.assertNotIn("https:", server.request("GET", "/")[1]["Content-Security-Policy"])
        server.stop()

    def test_a_public_basemap_is_had_by_its_name(self):
        server = self.serve("--workers", "0", "--basemap", "openstreetmap")
        _, basemap = server.json("GET", "/basemap.json", code=200)
        self.assertEqual(basemap["tiles"], ["https://tile.openstreetmap.org/{z}/{x}/{y}.png"])
        self.assertIn("OpenStreetMap contributors", basemap["attribution"])
        self.assertEqual(basemap["maxzoom"], 19)
        _, headers, _ = server.request("GET", "/")
        self.assertIn("https://tile.openstreetmap.org", headers["Content-Security-Policy"])
        server.stop()
        self.assertIn("openstreetmap", self.refusal("--listen", "127.0.0.1:0", "--basemap", "openstretmap"))

    def test_half_a_head_is_told_that_it_is_late(self):
        server = self.serve("--workers", "0")
        with socket.create_connection(("127.0.0.1", server.port)) as slow:
            slow.sendall(b"GET /healthz HTTP/1.1\r\nHost: loc")
            slow.settimeout(60)
            self.assertIn(b" 408 ", slow.recv(4096).split(b"\r\n")[0] + b" ")


class Events(ServerTestCase):
    def follow(self, server, path, until, headers=None):
        """Event blocks of a stream as dicts, up to the first for which `until` says so."""
        import http.client
        connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=120)
        connection.request("GET", path, headers=headers or {})
        response = connection.getresponse()
        self.assertEqual((response.status, response.headers["Content-Type"]), (200, "text/event-stream"))
        events, block = [], {}
        try:
            while True:
                line = response.readline().decode().rstrip("\n")
                if line:
                    key, _, value = line.partition(": ")
                    block[key] = value
                    continue
                if "event" in block:
                    events.append(block)
                    if until(block):
                        return events
                block = {}
        finally:
            connection.close()

    def test_a_job_is_followed_and_replayed(self):
        server = self.serve()
        flight_id, job_id = server.begun(self.photos)
        is_shown = lambda event: event["event"] == "map"
        told = self.follow(server, f"/api/v1/events?flight={flight_id}&after=0", is_shown)
        kinds = [event["event"] for event in told]
        self.assertEqual(kinds.count("file"), 6)
        self.assertIn("job", kinds)
        numbers = [int(event["id"]) for event in told if "id" in event]
        self.assertEqual(numbers, sorted(set(numbers)))
        # Who comes back with the number of an event gets exactly what came after it.
        lasting = [event for event in told if "id" in event]
        again = self.follow(server, f"/api/v1/events?flight={flight_id}", is_shown, {"Last-Event-ID": lasting[3]["id"]})
        self.assertEqual([event["id"] for event in again if "id" in event], [event["id"] for event in lasting[4:]])
        server.wait_for_job(job_id)
        _, log = server.json("GET", f"/api/v1/jobs/{job_id}/log")
        states = [entry["job"]["state"] for entry in log["events"]]
        self.assertEqual((states[0], states[-1]), ("accepted", "successful"))
        self.assertEqual(server.request("GET", "/api/v1/events", headers={"Last-Event-ID": "x"})[0], 400)

    def test_a_stop_ends_the_streams(self):
        server = self.serve("--workers", "0")
        with socket.create_connection(("127.0.0.1", server.port)) as stream:
            stream.sendall(b"GET /api/v1/events HTTP/1.1\r\nHost: localhost\r\n\r\n")
            self.assertIn(b"200 OK", stream.recv(4096))
            began = time.monotonic()
            self.assertEqual(server.stop(), 0)
            self.assertLess(time.monotonic() - began, 9)  # not only at the end of the drain
