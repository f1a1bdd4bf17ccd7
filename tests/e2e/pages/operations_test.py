"""Commands and options of docs/operations.md do what the page says: tokens, names, limits. All others are operations_data_test's."""
import contextlib
import http.client
import json
import os
import pathlib
import re
import tempfile
import time
import unittest
import unittest.mock
import urllib.request

import operations_data_test  # noqa: F401 what it replays counts
from operations_page import AS_JSON, COMMANDS, FLIGHTS, LIMITS, NAMES, OF_LIMITS, REPLAYED, SCOPES, SPANS, OperationsCase, bearer, replays
from nginx import NGINX, free_port, start_nginx
from server_support import middle_tile, put_map, wait_until


class Operations(OperationsCase):
    def test_nothing_of_the_page_is_left_out(self):
        for text in COMMANDS + SPANS:
            if text not in NAMES and text not in OF_LIMITS:
                self.assertTrue(any(re.fullmatch(pattern, text) for pattern in REPLAYED), f"nobody replays {text!r} of docs/operations.md")
        self.assertEqual(NAMES - set(SPANS), set())

    # Tokens and who may do what

    @replays("skyquilt token add field-team .*", "skyquilt token add guest .*", "skyquilt token list .*", "skyquilt token revoke guest .*",
             "skyquilt serve .*", "Authorization: Bearer ...", r"\?token=...")
    def test_tokens(self, add, add_guest, list_all, revoke, serve, header, query):
        self.assertIn("token add", self.refusal("--listen", "0.0.0.0:0"))  # without one it listens to its own machine only
        team = self.run_page(add)
        self.assertRegex(team, r"^sq_[\w-]+$")
        server = self.serve_page(serve)
        self.assertEqual(server.json("GET", "/ogc", headers=bearer(team))[1]["links"][0]["href"],
                         "https://maps.example.org/ogc")
        flight, other = (server.new_flight(headers=bearer(team)) for _ in range(2))
        guest = self.run_page(add_guest, FLIGHT=flight)
        name, value = header.replace("...", guest).split(": ")
        wait_until(lambda: self.status(server, f"{FLIGHTS}/{flight}", **{name: value}) == 200, "the token opens nothing")
        self.assertEqual(self.status(server, f"{FLIGHTS}/{flight}" + query.replace("...", guest)), 200)
        self.assertEqual(self.status(server, f"{FLIGHTS}/{other}", **bearer(guest)), 404)
        for path, who in ((f"{FLIGHTS}/{flight}", bearer(guest)), (f"{FLIGHTS}/{flight}{query.replace('...', team)}", {})):
            self.assertEqual(self.status(server, path, "DELETE", **who), 403)
        listed = self.run_page(list_all)
        self.assertRegex(listed, rf"(?m)^field-team .*upload")
        self.assertRegex(listed, rf"(?m)^guest .*read.*ends .*only flight {flight}")
        self.assertNotIn(team, listed)
        self.run_page(revoke)
        wait_until(lambda: self.status(server, f"{FLIGHTS}/{flight}", **bearer(guest)) == 401, "a revoked token goes on")
        self.assertEqual(self.status(server, **bearer(team)), 200)
        self.assertNotIn("guest", self.run_page(list_all))

    def test_scopes(self):
        self.assertEqual(SCOPES, ["read", "upload", "admin"])
        may = {scope: self.token(scope) for scope in SCOPES}
        server = self.serve("--workers", "0")
        of_admin = server.new_flight(headers=may["admin"])
        for scope, who in may.items():
            self.assertEqual(self.status(server, f"{FLIGHTS}/{of_admin}", **who), 200)
            self.assertEqual(self.status(server, FLIGHTS, "POST", "{}", **AS_JSON, **who), 403 if scope == "read" else 201)
        own = server.new_flight(headers=may["upload"])
        for path, scope, answer in ((of_admin, "upload", 403), (own, "read", 403), (own, "upload", 204), (of_admin, "admin", 204)):
            self.assertEqual(self.status(server, f"{FLIGHTS}/{path}", "DELETE", **may[scope]), answer, (path, scope))
        self.assertEqual([self.status(server, "/metrics", **who) for who in may.values()], [403, 403, 200])

    @replays("--open")
    def test_the_last_token(self, option):
        self.token("read")
        server = self.serve("--workers", "0")
        self.run_page("skyquilt token revoke read --data data")
        time.sleep(1.5)  # a server looks at its tokens once a second
        for _ in range(2):
            self.assertEqual(self.status(server), 401)
            server.stop()
            server = self.serve("--workers", "0")
        server.stop()
        server = self.serve_page(option)
        self.assertEqual(self.status(server), 200)
        self.token("read")
        wait_until(lambda: self.status(server) == 401, "a token closes nothing")

    @replays("--most-gb", "--per-minute")
    def test_limits_of_a_token(self, most_gb, per_minute):
        who = self.token("upload", most_gb, "0.0005", per_minute, "4")
        server = self.serve("--workers", "0")
        files = f"{FLIGHTS}/{server.new_flight(headers=who)}/files"
        self.assertEqual(self.status(server, f"{files}/a.jpg", "PUT", bytes(300_000), **who), 201)
        self.assertEqual(self.status(server, f"{files}/b.jpg", "PUT", bytes(300_000), **who), 413)
        self.assertEqual(self.status(server, files, **who), 200)
        _, headers, _ = server.request("GET", files, headers=who, code=429)
        self.assertGreater(int(headers["Retry-After"]), 0)

    @replays("POST /api/v1/network", "--public-url", "--host", "--trusted-proxy", r"--listen 0\.0\.0\.0:8080")
    def test_shares_and_the_network(self, request, public_url, host, trusted_proxy, listen):
        method, path = request.split()
        server = self.serve("--workers", "0")
        flight = f"{FLIGHTS}/{server.new_flight()}"
        _, share = server.json("POST", f"{flight}/shares", {})
        self.assertEqual(self.status(server, flight, **bearer(share["token"])), 200)
        self.assertEqual(self.status(server, flight, "DELETE", **bearer(share["token"])), 403)
        self.assertEqual(self.status(server, path, method, X_Forwarded_For="192.0.2.7"), 403)
        status, opened = server.json(method, path)
        if status != 409:  # this machine is in no network
            self.assertEqual((status, server.json("GET", f"{flight}/shares")[1]["addresses"]), (200, opened["addresses"]))
            self.assertEqual(opened["addresses"][0].rsplit(":", 1)[1], str(server.port))
            there = opened["addresses"][0].removeprefix("http://")
            link = bearer(share["token"])
            for asked, who, answer in (("GET", {}, 401), ("GET", link, 200), ("DELETE", {}, 401), ("DELETE", link, 403)):
                with contextlib.closing(http.client.HTTPConnection(there, timeout=60)) as connection:
                    connection.request(asked, flight, headers=who)
                    self.assertEqual(connection.getresponse().status, answer, (asked, who))
            self.assertEqual(self.status(server, flight), 200)
        self.assertEqual(self.status(server, f"{flight}/shares/{share['id']}", "DELETE"), 204)
        self.assertEqual(self.status(server, flight, **bearer(share["token"])), 401)
        server.stop()
        for option, value in ((public_url, "https://maps.example.org"), (host, "maps.example.org"), (trusted_proxy, "192.0.2.9")):
            server = self.serve("--workers", "0", option, value)
            self.assertEqual(self.status(server, path, method), 409, option)
            if option == public_url:
                self.assertEqual(server.json("GET", f"{flight}/shares")[1]["addresses"], ["https://maps.example.org"])
            server.stop()
        who = self.token("admin")
        server = self.serve_page(listen)
        addresses = server.json("GET", f"{flight}/shares", headers=who)[1]["addresses"]
        self.assertTrue(all(address.endswith(f":{server.port}") for address in addresses), addresses)
        if status != 409:
            self.assertEqual([address.rsplit(":", 1)[0] for address in addresses], [address.rsplit(":", 1)[0] for address in opened["addresses"]])

    # Names and other sites

    @replays("--host NAME", "--cors-origin https://host", "--trusted-proxy ADDRESS")
    def test_names(self, host, cors_origin, trusted_proxy):
        for more in ([], ["--open"]):
            server = self.serve_page(host.replace("NAME", "field.example"), *more, "--host", "other.example")
            self.assertEqual([self.status(server, Host=name) for name in ("field.example", "other.example", "evil.example")], [200, 200, 421])
            server.stop()
        allowed = lambda server, origin, **more: server.request("GET", FLIGHTS, headers={"Origin": origin, **more})[1]["Access-Control-Allow-Origin"]
        server = self.serve_page(cors_origin, "--cors-origin", "https://two.example")
        self.assertEqual([allowed(server, origin) for origin in ("https://host", "https://two.example", "https://evil.example")],
                         ["https://host", "https://two.example", None])
        server.stop()
        forwarded = {"X-Forwarded-Proto": "https", "X-Forwarded-Host": "maps.example.org", "X-Forwarded-Prefix": "/below"}
        href = lambda server: server.json("GET", "/ogc", headers=forwarded)[1]["links"][0]["href"]
        server = self.serve("--workers", "0", "--host", "maps.example.org")
        self.assertEqual(href(server), f"http://127.0.0.1:{server.port}/ogc")
        server.stop()
        server = self.serve_page(trusted_proxy.replace("ADDRESS", "192.0.2.9"), "--trusted-proxy", "127.0.0.0/8",
                                 "--host", "maps.example.org", "--listeners-per-address", "1")
        self.assertEqual(href(server), "https://maps.example.org/below/ogc")
        self.assertEqual(self.status(server, "/ogc", **{**forwarded, "X-Forwarded-Host": "evil.example"}), 421)
        # Whose X-Forwarded-For names the client: each has an event stream, and this machine as many as it likes.
        with contextlib.ExitStack() as streams:
            answers = []
            for client in ("203.0.113.5", "203.0.113.5", "203.0.113.6", None, None):
                connection = streams.enter_context(contextlib.closing(http.client.HTTPConnection("127.0.0.1", server.port, timeout=60)))
                connection.request("GET", "/api/v1/events", headers={"X-Forwarded-For": client} if client else {})
                answers.append(connection.getresponse())
        self.assertEqual([answer.status for answer in answers], [200, 429, 200, 200, 200])
        server.stop()
        who = self.token("read")
        server = self.serve("--workers", "0")
        self.assertIsNotNone(allowed(server, "https://any.example", **who))
        self.assertEqual(self.status(server, Host="any.example", **who), 200)
        server.stop()
        server = self.serve_page(host.replace("NAME", "field.example"))
        self.assertEqual([self.status(server, Host=name, **who) for name in ("field.example", "any.example")], [200, 421])

    @replays("--base-path /skyquilt", "location /skyquilt .*")
    def test_below_a_path(self, base_path, location):
        server = self.serve_page(base_path)
        at = f"http://127.0.0.1:{server.port}"
        for path in ("/ogc", "/skyquilt/ogc"):  # whether the proxy takes it off or not
            with urllib.request.urlopen(at + path, timeout=60) as answer:
                self.assertEqual(json.loads(answer.read())["links"][0]["href"], f"{at}/skyquilt/ogc")
        if NGINX is None:
            self.skipTest("nginx is not here")
        port = free_port()
        start_nginx(self, tempfile.mkdtemp(dir=self.scratch), port,
                    f"server {{ listen 127.0.0.1:{port}; {location.replace('8080', str(server.port))} }}")
        for path in ("/", FLIGHTS):
            with urllib.request.urlopen(f"http://127.0.0.1:{port}/skyquilt{path}", timeout=60) as answer:
                self.assertEqual(answer.status, 200)

    # Limits

    def test_the_table_of_limits_is_the_programs(self):
        told = self.run_page("skyquilt serve --help")
        words = []
        for options, default, _ in LIMITS:
            for option in re.findall(r"`(--[\w-]+)`", options):
                taken, of_program = re.search(rf"(?m)^  {option}( .*?)?(?:=(\d+))? \(Env:", told).groups()
                self.assertEqual((re.match(r"\d*", default).group() or {"off": "", "by number and size of files": "0"}[default]), of_program or "", option)
                words += [option] if taken is None else [option, of_program]
        self.assertIn("--waiting-requests", words)
        flight = put_map(self.data)
        who = self.token("read")
        kept = []
        for more in (words, [word for word in words if word != "--keyed-cache"]):
            server = self.serve(*more)
            tile = middle_tile(server.json("GET", f"/tiles/{flight}.json", headers=who)[1], "minzoom")
            kept.append(server.request("GET", tile, headers=who)[1]["Cache-Control"].split(",")[0])
            self.assertEqual(server.stop(), 0)
        self.assertEqual(kept, ["public", "private"])

    @replays("--config", r"SKYQUILT_SERVE_\.\.\.")
    def test_options_from_a_file_and_from_variables(self, config, variables):
        keep_days = lambda server: server.json("GET", "/api/v1/access")[1]["keep_days"]
        file = pathlib.Path(self.scratch, "skyquilt.conf")
        file.write_text("workers = 0\nkeep-days = 5\n")
        server = self.serve(config, str(file))
        self.assertEqual((keep_days(server), server.workers()), (5, []))
        server.stop()
        with unittest.mock.patch.dict(os.environ, {variables.replace("...", name): value for name, value in (("WORKERS", "0"), ("KEEP_DAYS", "7"))}):
            server = self.serve()
        self.assertEqual((keep_days(server), server.workers()), (7, []))
