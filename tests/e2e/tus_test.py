"""Resumable uploads: tus-js-client through kills of the server, and answer for answer against the protocol's own
server. The clients come from npm; without them these tests skip."""
import hashlib
import http.client
import json
import pathlib
import random
import re
import socket
import subprocess
import tempfile
import time

from npm_clients import installed_clients, script
from server_support import AS_JSON, BLOBS, CHUNK, TUS, ServerTestCase, add_token, photos_of, tus_metadata, wait_until

MIB = 1 << 20


def ask(port, method, path, body=None, headers=None):
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=60)
    try:
        connection.request(method, path, body=body, headers=headers or {})
        response = connection.getresponse()
        response.read()
        return response.status, response.headers
    finally:
        connection.close()


class Tus(ServerTestCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.clients = installed_clients()

    def start(self, port=0):
        return self.serve("--workers", "0", listen=f"127.0.0.1:{port}")

    def stored(self, flight):
        return photos_of(self.data, flight)

    def test_tus_js_client_gets_300_mb_through_two_kills(self):
        if self.clients is None:
            self.skipTest("npm's tus-js-client cannot be had")
        source = pathlib.Path(self.scratch, "source.bin")
        with source.open("wb") as file:
            for part in range(300):
                file.write(random.Random(part).randbytes(MIB))
        server = self.start()
        _, flight = server.json("POST", "/api/v1/flights", {})
        client = subprocess.Popen(["node", script(self.clients, "tus_upload.mjs"), f"http://127.0.0.1:{server.port}/api/v1/uploads",
                                   source, flight["id"], "big.jpg"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        kills = [70 * MIB, 190 * MIB]
        lines = []
        for line in client.stdout:
            lines.append(line)
            sent = re.match(r"sent (\d+)", line)
            if sent and kills and int(sent.group(1)) > kills[0]:
                kills.pop(0)
                server.kill()
                server = self.start(server.port)
        self.assertEqual(client.wait(timeout=60), 0, lines[-3:])
        client.stdout.close()
        self.assertEqual(kills, [])
        [stored] = self.stored(flight["id"])
        with source.open("rb") as want, stored.open("rb") as got:
            self.assertEqual(hashlib.file_digest(want, "sha256").hexdigest(), hashlib.file_digest(got, "sha256").hexdigest())
        self.assertEqual(list((pathlib.Path(self.data) / "uploads").iterdir()), [])

    def test_tus_js_client_sends_four_parts_side_by_side(self):
        if self.clients is None:
            self.skipTest("npm's tus-js-client cannot be had")
        source = pathlib.Path(self.scratch, "parallel.bin")
        source.write_bytes(random.Random(5).randbytes(9 * MIB + 7))
        server = self.start()
        for guarded in (False, True):
            token = []
            if guarded:
                token = [add_token(self.data, "tus", "--scope", "upload")]
                server.stop()
                server = self.start()
            headers = {**AS_JSON, **{"Authorization": f"Bearer {one}" for one in token}}
            flight = json.loads(server.request("POST", "/api/v1/flights", "{}", headers)[2])
            send = ["node", script(self.clients, "tus_upload.mjs"), f"http://127.0.0.1:{server.port}/api/v1/uploads", source,
                   flight["id"], "big.jpg", "4"]
            said = subprocess.run(send + token, capture_output=True, text=True, timeout=60)
            self.assertEqual(said.returncode, 0, said.stdout + said.stderr)
            [stored] = self.stored(flight["id"])
            self.assertEqual(stored.read_bytes(), source.read_bytes())
            self.assertEqual(list((pathlib.Path(self.data) / "uploads").iterdir()), [])
        self.assertNotEqual(subprocess.run(send, capture_output=True, timeout=60).returncode, 0)

    def test_parts_outlive_a_kill_and_become_one_file(self):
        content = random.Random(3).randbytes(2 * MIB)
        server = self.start()
        _, flight = server.json("POST", "/api/v1/flights", {})
        status, headers, _ = server.request("OPTIONS", "/api/v1/uploads")
        self.assertIn("concatenation", headers["Tus-Extension"].split(","))
        places = []
        for part in (content[:MIB], content[MIB:]):
            _, headers, _ = server.request("POST", "/api/v1/uploads", headers={
                **TUS, "Upload-Concat": "partial", "Upload-Length": str(len(part))}, code=201)
            places.append(headers["Location"])
            self.assertEqual(server.request("PATCH", places[-1], part, {**CHUNK, "Upload-Offset": "0"})[0], 204)
        server.kill()
        server = self.start()
        self.assertEqual(self.stored(flight["id"]), [])
        final = {**TUS, **tus_metadata(flight["id"]), "Upload-Concat": "final;" + " ".join(places)}
        _, headers, _ = server.request("POST", "/api/v1/uploads", headers=final, code=201)
        status, told, _ = server.request("HEAD", headers["Location"], headers=TUS)
        self.assertEqual((told["Upload-Length"], told["Upload-Offset"], told["Upload-Concat"]),
                         (str(len(content)), str(len(content)), final["Upload-Concat"]))
        [stored] = self.stored(flight["id"])
        self.assertEqual(stored.read_bytes(), content)
        self.assertEqual(list((pathlib.Path(self.data) / "uploads").iterdir()), [])
        self.assertIn(b"concatenation", server.request("POST", "/api/v1/uploads", headers={**final, "Upload-Concat": "both"}, code=400)[2])
        self.assertEqual(server.request("PATCH", headers["Location"], b"x", {**CHUNK, "Upload-Offset": str(len(content))})[0], 403)

    def test_kills_at_random_points_lose_nothing_that_was_promised(self):
        content = random.Random(7).randbytes(3 * MIB)
        dice = random.Random(11)
        server = self.start()
        _, flight = server.json("POST", "/api/v1/flights", {})
        _, headers, _ = server.request("POST", "/api/v1/uploads", headers={
            **TUS, "Upload-Length": str(len(content)), **tus_metadata(flight["id"])}, code=201)
        place, promised = headers["Location"], 0
        for _ in range(12):
            status, headers, _ = server.request("HEAD", place, headers=TUS)
            offset = int(headers["Upload-Offset"])
            self.assertGreaterEqual(offset, promised)
            if offset == len(content):
                break
            end = min(len(content), offset + dice.randrange(1, MIB))
            with socket.create_connection(("127.0.0.1", server.port)) as client:
                head = (f"PATCH {place} HTTP/1.1\r\nHost: localhost\r\nTus-Resumable: 1.0.0\r\nUpload-Offset: {offset}\r\n"
                        f"Content-Type: application/offset+octet-stream\r\nContent-Length: {end - offset}\r\n\r\n")
                cut = dice.choice([end - offset, dice.randrange(end - offset)])
                client.sendall(head.encode() + content[offset:offset + cut])
                if cut == end - offset:
                    client.settimeout(60)
                    if b" 204 " in client.recv(4096):
                        promised = end
                else:
                    time.sleep(dice.random() * 0.05)
            server.kill()
            server = self.start()
        status, headers, _ = server.request("HEAD", place, headers=TUS)
        offset = int(headers["Upload-Offset"])
        if offset < len(content):
            server.request("PATCH", place, content[offset:], {**CHUNK, "Upload-Offset": str(offset)}, code=204)
        [stored] = self.stored(flight["id"])
        self.assertEqual(stored.read_bytes(), content)
        self.assertEqual(server.garbage(), [])

    def test_a_dead_connection_does_not_hold_its_upload(self):
        server = self.start()
        _, flight = server.json("POST", "/api/v1/flights", {})
        _, headers, _ = server.request("POST", "/api/v1/uploads",
                                       headers={**TUS, "Upload-Length": "10", **tus_metadata(flight["id"])})
        place = headers["Location"]
        with socket.create_connection(("127.0.0.1", server.port)) as silent:
            silent.sendall((f"PATCH {place} HTTP/1.1\r\nHost: localhost\r\nTus-Resumable: 1.0.0\r\nUpload-Offset: 0\r\n"
                            "Content-Type: application/offset+octet-stream\r\nContent-Length: 10\r\n\r\n01234").encode())
            offset = lambda: int(server.request("HEAD", place, headers=TUS)[1]["Upload-Offset"])
            if BLOBS is None:  # a store gets pieces of some size, the rest of one is sent again
                spooled = pathlib.Path(self.data, "uploads", place.rsplit("/", 1)[1])
                wait_until(lambda: spooled.stat().st_size == 5, "what came is not kept")
                self.assertEqual(offset(), 5)
            status = 409  # with a store: what the dead one sent is put while it ends, and the offset asked again, as clients do
            for _ in range(1 if BLOBS is None else 2):
                if status == 409:
                    begun = offset()
                    status, _, _ = server.request("PATCH", place, b"0123456789"[begun:], {**CHUNK, "Upload-Offset": str(begun)})
            self.assertEqual(status, 204)
        [stored] = self.stored(flight["id"])
        self.assertEqual(stored.read_bytes(), b"0123456789")

    def test_every_status_is_that_of_the_protocols_own_server(self):
        if self.clients is None:
            self.skipTest("npm's @tus/server cannot be had")
        folder = tempfile.mkdtemp(dir=self.scratch)
        reference = subprocess.Popen(["node", script(self.clients, "tus_reference.mjs"), folder], stdout=subprocess.PIPE, text=True)
        try:
            port = int(re.match(r"port (\d+)", reference.stdout.readline()).group(1))
            server = self.start()
            _, flight = server.json("POST", "/api/v1/flights", {})
            ours = self.walk(server.port, flight["id"])
            theirs = self.walk(port, flight["id"])
        finally:
            reference.kill()
            reference.wait()
            reference.stdout.close()
        # Where that server goes another way than the protocol's text, the text counts: 412 with Tus-Version for a
        # version that is not spoken, 415 for bytes of another type.
        by_the_text = {"create without the version": (412, "1.0.0"), "create with another version": (412,),
                       "patch with another type": (415,)}
        differing = {step: (ours[step], theirs[step]) for step in ours if ours[step] != theirs[step]}
        self.assertEqual({step: pair[0] for step, pair in differing.items()}, by_the_text, differing)

    def walk(self, port, flight):
        """The same requests to either server: what each step answered."""
        told = {}
        good = {**TUS, **tus_metadata(flight)}

        def step(name, method, path, body=None, headers=None, keep=()):
            status, got = ask(port, method, path, body, headers)
            told[name] = (status, *(got.get(header) for header in keep))
            return got
        step("options", "OPTIONS", "/api/v1/uploads", keep=("Tus-Version", "Tus-Max-Size"))
        step("create without a length", "POST", "/api/v1/uploads", headers=good)
        step("create with a bad length", "POST", "/api/v1/uploads", headers={**good, "Upload-Length": "-5"})
        step("create with both lengths", "POST", "/api/v1/uploads", headers={**good, "Upload-Length": "5", "Upload-Defer-Length": "1"})
        step("create with a wrong deferral", "POST", "/api/v1/uploads", headers={**good, "Upload-Defer-Length": "2"})
        step("create too large", "POST", "/api/v1/uploads", headers={**good, "Upload-Length": str(5 * 1024**3)})
        step("create with bad metadata", "POST", "/api/v1/uploads", headers={**TUS, "Upload-Length": "5", "Upload-Metadata": "a =="})
        step("create without the version", "POST", "/api/v1/uploads", headers={"Upload-Length": "5"}, keep=("Tus-Version",))
        step("create with another version", "POST", "/api/v1/uploads", headers={**good, "Tus-Resumable": "0.2.2", "Upload-Length": "5"})
        place = step("create", "POST", "/api/v1/uploads", headers={**good, "Upload-Length": "10"})["Location"]
        step("head", "HEAD", place, headers=TUS, keep=("Upload-Offset", "Upload-Length", "Cache-Control", "Upload-Metadata"))
        step("patch with another type", "PATCH", place, b"x", {**TUS, "Upload-Offset": "0", "Content-Type": "image/jpeg"})
        step("patch elsewhere", "PATCH", place, b"x", {**CHUNK, "Upload-Offset": "3"})
        step("patch of nothing known", "PATCH", place + "x", b"x", {**CHUNK, "Upload-Offset": "0"})
        step("patch", "PATCH", place, b"01234", {**CHUNK, "Upload-Offset": "0"}, keep=("Upload-Offset",))
        step("patch again", "PATCH", place, b"01234", {**CHUNK, "Upload-Offset": "0"})
        step("patch to the end", "PATCH", place, b"56789", {**CHUNK, "Upload-Offset": "5"}, keep=("Upload-Offset",))
        step("head at the end", "HEAD", place, headers=TUS, keep=("Upload-Offset",))
        place = step("create for ever", "POST", "/api/v1/uploads", headers={**good, "Upload-Defer-Length": "1"})["Location"]
        step("head for ever", "HEAD", place, headers=TUS, keep=("Upload-Offset", "Upload-Defer-Length"))
        step("patch for ever", "PATCH", place, b"01", {**CHUNK, "Upload-Offset": "0"}, keep=("Upload-Offset",))
        step("patch with the length", "PATCH", place, b"23", {**CHUNK, "Upload-Offset": "2", "Upload-Length": "6"}, keep=("Upload-Offset",))
        step("end", "DELETE", place, headers=TUS)
        step("head of the ended", "HEAD", place, headers=TUS)
        step("patch of the ended", "PATCH", place, b"x", {**CHUNK, "Upload-Offset": "4"})
        step("end again", "DELETE", place, headers=TUS)
        step("create with bytes", "POST", "/api/v1/uploads", b"0123", {**good, **CHUNK, "Upload-Length": "10"}, keep=("Upload-Offset",))
        return told
