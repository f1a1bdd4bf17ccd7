"""Whose flights are whose: tokens that end, quotas, names and other sites, and tokens for one flight, from outside."""
import http.client
import io
import json
import pathlib
import re
import time
import zipfile

from program import run
from server_support import AS_JSON, CHUNK, TUS, ServerTestCase, bearer, catalogue_words, kept_of_flights, tus_metadata, wait_until


class AccessCase(ServerTestCase):
    def revoke(self, name):
        run("token", "revoke", name, "--data", self.data, *catalogue_words(self.data))


class LastToken(AccessCase):
    def test_revoking_the_last_token_opens_nothing(self):
        self.token("one", "--scope", "admin")
        server = self.serve("--workers", "0")
        self.assertEqual(server.request("GET", "/api/v1/flights")[0], 401)
        self.revoke("one")
        time.sleep(1.5)  # a running server looks at its tokens once a second
        for method, path in (("GET", "/api/v1/flights"), ("POST", "/api/v1/flights"), ("GET", "/metrics")):
            self.assertIn(b"--open", server.request(method, path, headers=AS_JSON, code=401)[2])
        server.stop()
        server = self.serve("--workers", "0")
        self.assertEqual(server.request("GET", "/api/v1/flights")[0], 401)
        self.assertIn("all tokens were revoked", server.errors())
        again = self.token("two")
        wait_until(lambda: server.request("GET", "/api/v1/flights", headers=again)[0] == 200, "a new token opens nothing")
        self.revoke("two")
        server.stop()
        # Said again, it is open, until there is a token again.
        server = self.serve("--workers", "0", "--open")
        self.assertEqual(server.request("GET", "/api/v1/flights")[0], 200)
        self.token("three")
        wait_until(lambda: server.request("GET", "/api/v1/flights")[0] == 401, "a token closes nothing")

    def test_a_token_that_ends_opens_nothing(self):
        ends = self.token("short", "--expires", "10s")  # longer than a busy machine takes to start the server
        server = self.serve("--workers", "0")
        self.assertEqual(server.request("GET", "/api/v1/flights", headers=ends)[0], 200)
        wait_until(lambda: server.request("GET", "/api/v1/flights", headers=ends)[0] == 401, "the token did not end")
        self.assertIn(b"have ended", server.request("GET", "/api/v1/flights")[2])


class Quotas(AccessCase):
    def test_20_mb_do_not_go_past_10_kb_at_any_door(self):
        small = self.token("small", "--scope", "upload", "--most-gb", "0.00001")
        server = self.serve("--workers", "0")
        flight = server.new_flight(headers=small)
        files = f"/api/v1/flights/{flight}/files"
        slices = [bytes(1 << 20)] * 20

        def send(method, path, body, headers):
            """The answer to a body of which the server may not want the rest."""
            connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=60)
            try:
                connection.putrequest(method, path)
                for name, value in {**small, **headers}.items():
                    connection.putheader(name, value)
                connection.endheaders()
                try:
                    for piece in body:
                        connection.send(piece)
                except (BrokenPipeError, ConnectionResetError):
                    pass
                response = connection.getresponse()
                return response.status, response.read()
            finally:
                connection.close()
        chunked = [b"%x\r\n%s\r\n" % (len(piece), piece) for piece in slices] + [b"0\r\n\r\n"]
        status, body = send("PUT", f"{files}/a.jpg", chunked, {"Transfer-Encoding": "chunked"})
        self.assertEqual((status, b"10.0 kB" in body), (413, True), body)
        head = b'--b\r\nContent-Disposition: form-data; name="images"; filename="a.jpg"\r\n\r\n'
        form = [head, *slices, b"\r\n--b--\r\n"]
        length = {"Content-Length": str(sum(map(len, form))), "Content-Type": "multipart/form-data; boundary=b"}
        self.assertEqual(send("POST", files, form, length)[0], 413)
        self.assertEqual(send("POST", "/api/v1/flights", form, length)[0], 413)
        status, body = send("POST", "/task/new", form, length)
        self.assertEqual((status, b"10.0 kB" in body), (200, True), body)
        _, headers, _ = server.request("POST", "/api/v1/uploads", headers={**small, **TUS, **tus_metadata(flight), "Upload-Defer-Length": "1"}, code=201)
        upload = headers["Location"]
        self.assertEqual(send("PATCH", upload, slices, {**CHUNK, "Upload-Offset": "0", "Content-Length": str(20 << 20)})[0], 413)
        archive = io.BytesIO()
        with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as made:
            made.writestr("a.txt", b"0123456789" * 4000)
        self.assertLess(len(archive.getvalue()), 2000)
        self.assertIn(b"10.0 kB", server.request("PUT", f"{files}/a.zip", archive.getvalue(), small, code=413)[2])
        self.assertEqual(server.json("GET", files, headers=small)[1], {"files": []})
        stored = sum(path.stat().st_size for path in kept_of_flights(self.data).values())
        stored += sum(path.stat().st_size for folder in ("incoming", "uploads")
                      for path in pathlib.Path(self.data, folder).rglob("*") if path.is_file())
        self.assertLessEqual(stored, 10_000)
        # What a resumable upload has so far counts too, until it ends.
        self.assertEqual(server.request("DELETE", upload, headers={**small, **TUS})[0], 204)
        self.assertEqual(server.request("PUT", f"{files}/b.jpg", bytes(9000), small)[0], 201)


class Keys(AccessCase):
    def test_a_key_of_one_token_and_one_form(self):
        one, other = self.token("one", "--scope", "upload"), self.token("other", "--scope", "upload")
        server = self.serve("--workers", "0")

        def send(who, content, boundary):
            form = f'--{boundary}\r\nContent-Disposition: form-data; name="images"; filename="a.jpg"\r\n\r\n'.encode() + content
            return server.request("POST", "/api/v1/flights", form + f"\r\n--{boundary}--\r\n".encode(),
                                  {**who, "Idempotency-Key": "key", "Content-Type": f"multipart/form-data; boundary={boundary}"})
        first = send(one, b"first", "b1")
        self.assertEqual(first[0], 202)
        again = send(one, b"first", "b2")
        self.assertEqual((again[2], again[1]["Idempotency-Replayed"]), (first[2], "true"))
        self.assertEqual(send(one, b"second", "b1")[0], 422)
        foreign = send(other, b"first", "b1")
        self.assertEqual((foreign[0], foreign[1]["Idempotency-Replayed"]), (202, None))
        self.assertNotEqual(json.loads(foreign[2])["flight"]["id"], json.loads(first[2])["flight"]["id"])


class Names(AccessCase):
    def test_open_still_knows_its_name(self):
        server = self.serve("--workers", "0", "--open", "--host", "field.example,other.example", "--public-url", "https://maps.example.org")
        status = lambda host: server.request("GET", "/api/v1/flights", headers={"Host": host})[0]
        for host in ("localhost", "127.0.0.1:80", "field.example", "other.example:8080", "maps.example.org"):
            self.assertEqual(status(host), 200, host)
        self.assertEqual(status("evil.example"), 421)
        self.assertIn(b"--host", server.request("GET", "/api/v1/flights", headers={"Host": "evil.example"})[2])

    def test_a_page_of_elsewhere_reads_nothing_unless_it_is_named(self):
        evil = {"Origin": "https://evil.example"}
        server = self.serve("--workers", "0")
        for path in ("/api/v1/flights", "/ogc/collections", "/info", "/nowhere"):
            self.assertNotIn("Access-Control-Allow-Origin", server.request("GET", path, headers=evil)[1], path)
        server.stop()
        server = self.serve("--workers", "0", "--cors-origin", "https://one.example", "--cors-origin", "https://two.example")
        for origin in ("https://one.example", "https://two.example"):
            headers = server.request("GET", "/api/v1/flights", headers={"Origin": origin})[1]
            self.assertEqual(headers["Access-Control-Allow-Origin"], origin)
        self.assertNotIn("Access-Control-Allow-Origin", server.request("GET", "/api/v1/flights", headers=evil)[1])
        server.stop()
        self.assertIn("origin", self.refusal("--cors-origin", "https://one.example/path"))


class OneFlight(AccessCase):
    def test_a_flight_is_shared_for_a_while_and_no_longer(self):
        owner, other, admin = (self.token(name, "--scope", scope) for name, scope in
                               (("owner", "upload"), ("other", "upload"), ("admin", "admin")))
        server = self.serve("--workers", "0")
        flight, foreign = server.new_flight(headers=owner), server.new_flight(headers=other)
        at = f"/api/v1/flights/{flight}/shares"
        _, made = server.json("POST", at, {"expires_in_days": 30}, owner, 201)
        self.assertEqual(made["page"], f"/#/flights/{flight}?token={made['token']}")
        self.assertEqual(made["embed"], f"/embed/{flight}#token={made['token']}")
        share = bearer(made["token"])
        self.assertEqual(server.request("PUT", f"/api/v1/flights/{flight}/files/a.jpg", b"abc", owner)[0], 201)
        self.assertEqual([entry["id"] for entry in server.json("GET", "/api/v1/flights", headers=share)[1]["flights"]], [flight])
        self.assertEqual(server.request("GET", f"/api/v1/flights/{flight}/files/a.jpg", headers=share)[2], b"abc")
        self.assertEqual(server.request("GET", f"/api/v1/flights/{foreign}", headers=share)[0], 404)
        self.assertEqual(server.request("PATCH", f"/api/v1/flights/{flight}", '{"name":"x"}', {**AS_JSON, **share})[0], 403)
        self.assertEqual(server.request("GET", at, headers=share)[0], 403)
        # Others neither see the shares nor make any.
        self.assertEqual(server.request("GET", at, headers=other)[0], 403)
        self.assertEqual(server.request("POST", at, "{}", {**AS_JSON, **other})[0], 403)
        self.assertEqual(server.request("POST", at, '{"expires_in_days": 0}', {**AS_JSON, **owner})[0], 422)
        _, _, body = server.request("GET", at, headers=admin)
        shares = json.loads(body)
        self.assertEqual([entry["id"] for entry in shares["shares"]], [made["id"]])
        self.assertNotIn(made["token"].encode(), body)
        self.assertTrue(shares["needs_token"])
        self.assertEqual(server.request("DELETE", f"/api/v1/flights/{foreign}/shares/{made['id']}", headers=other)[0], 404)
        self.assertEqual(server.request("DELETE", f"{at}/{made['id']}", headers=owner)[0], 204)
        self.assertEqual(server.request("GET", f"/api/v1/flights/{flight}", headers=share)[0], 401)
        self.assertNotIn(made["token"], server.errors())
        # A flight that goes takes its shares along.
        share = bearer(server.json("POST", at, {}, owner)[1]["token"])
        self.assertEqual(server.request("DELETE", f"/api/v1/flights/{flight}", headers=owner)[0], 204)
        self.assertIn(server.request("GET", f"/api/v1/flights/{flight}", headers=share)[0], (401, 404))

    def test_the_command_makes_one_too(self):
        admin = self.token("admin", "--scope", "admin")
        server = self.serve("--workers", "0")
        flight = server.new_flight(headers=admin)
        share = self.token("guest", "--flight", flight, "--expires", "30d")
        wait_until(lambda: server.request("GET", f"/api/v1/flights/{flight}", headers=share)[0] == 200, "the token opens nothing")
        listed = run("token", "list", "--data", self.data, *catalogue_words(self.data)).stdout
        self.assertRegex(listed, rf"guest .*ends .*only flight {flight}")
        for wrong in (["--flight", "0" * 26], ["--flight", flight, "--scope", "upload"], ["--expires", "soon"]):
            refused = run("token", "add", "wrong", "--data", self.data, *catalogue_words(self.data), *wrong, code=None)
            self.assertNotEqual(refused.returncode, 0, wrong)
            self.assertNotEqual(refused.stderr + refused.stdout, "", wrong)

    def test_a_share_of_an_open_server_only_reads_and_ends(self):
        server = self.serve("--workers", "0")
        flight = server.new_flight()
        at = f"/api/v1/flights/{flight}/shares"
        self.assertEqual(server.json("GET", at), (200, {"needs_token": False, "may_open_network": True, "addresses": [], "shares": []}))
        _, made = server.json("POST", at, {}, code=201)
        share = bearer(made["token"])
        one = f"/api/v1/flights/{flight}"
        self.assertEqual(server.request("GET", one, headers=share)[0], 200)
        self.assertEqual(server.request("DELETE", one, headers=share)[0], 403)
        self.assertEqual(server.request("DELETE", f"{one}?token={made['token']}")[0], 403)
        self.assertEqual(server.json("GET", "/api/v1/access", headers=share)[1]["scope"], "read")
        # It has closed the server to nobody; revoked, it opens nothing, and no more than it did.
        self.assertEqual(server.request("GET", "/api/v1/flights")[0], 200)
        self.assertEqual(server.request("DELETE", f"{at}/{made['id']}")[0], 204)
        self.assertEqual(server.request("GET", one, headers=share)[0], 401)
        self.assertEqual(server.request("DELETE", one, headers=share)[0], 401)
        self.assertEqual(server.request("GET", one)[0], 200)


class Secrets(AccessCase):
    def test_a_webhook_tells_its_secret_once(self):
        admin, upload = self.token("admin", "--scope", "admin"), self.token("upload", "--scope", "upload")
        server = self.serve("--workers", "0", "--webhooks", "any")
        secret = "a secret of sixteen or more"
        hook = {"url": "http://127.0.0.1:9/", "secret": secret}
        server.json("POST", "/api/v1/webhooks", hook, upload, 403)
        self.assertEqual(server.json("POST", "/api/v1/webhooks", hook, admin, 201)[1]["secret"], secret)
        self.assertEqual(server.request("GET", "/api/v1/webhooks", headers=upload)[0], 403)
        self.assertNotIn(secret.encode(), server.request("GET", "/api/v1/webhooks", headers=admin)[2])
        flight = server.new_flight(headers=upload)
        server.request("PUT", f"/api/v1/flights/{flight}/files/a.jpg", b"no picture", upload)
        _, job = server.json("POST", f"/api/v1/flights/{flight}/jobs", {}, upload)
        server.request("DELETE", f"/api/v1/jobs/{job['id']}", headers=upload)
        wait_until(lambda: '"where":"webhook"' in server.errors(), "the receiver that is not there was not told")
        self.assertNotIn(secret, server.errors())

    def test_the_proxy_writes_no_token_down(self):
        text = pathlib.Path(__file__, "../../../docker/nginx.conf").resolve().read_text()
        logs = re.findall(r"^\s*(?:log_format|access_log)\b[^;]*;", text, re.M)
        self.assertTrue(any("access_log" in line for line in logs))
        for line in logs:
            for variable in ("$request ", '$request"', "$request_uri", "$args", "$query_string", "$http_referer"):
                self.assertNotIn(variable, line)
