"""`skyquilt upload` against the real server: a folder with spaces becomes a map, a server that is killed on the way is
waited for, what is there already is not sent again, and refusals are in words."""
import pathlib
import re
import socket
import subprocess
import tempfile
import threading

from program import BINARY, run
from server_support import ServerTestCase, add_token, wait_until


class BreakingProxy:
    """Passes connections on to a server, and breaks one of them, once, after so many bytes towards it."""

    def __init__(self, to_port, breaks_after):
        self.to_port, self.breaks_after = to_port, breaks_after
        self.passed, self.has_broken = 0, False
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        threading.Thread(target=self.accept, daemon=True).start()

    def accept(self):
        while True:
            client, _ = self.listener.accept()
            server = socket.create_connection(("127.0.0.1", self.to_port))
            threading.Thread(target=self.relay, args=(client, server, True), daemon=True).start()
            threading.Thread(target=self.relay, args=(server, client, False), daemon=True).start()

    def loses(self, answer):
        return False

    def relay(self, source, sink, counts):
        try:
            while data := source.recv(1 << 16):
                if not counts and self.loses(data):
                    break
                sink.sendall(data)
                self.passed += len(data) if counts else 0
                if counts and not self.has_broken and self.passed > self.breaks_after:
                    self.has_broken = True
                    break
        except OSError:
            pass  # an end has closed, or the other thread closed it
        for end in (source, sink):
            try:
                end.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass
            end.close()  # with what nobody read: else the other end goes on sending, into a full buffer, for a minute


class LosingProxy(BreakingProxy):
    """Loses the first answer that a flight is made (201), and the first that its job is queued (202)."""

    def __init__(self, to_port):
        self.lost = []
        super().__init__(to_port, breaks_after=1 << 40)

    def loses(self, answer):
        status = answer[9:12]
        if not answer.startswith(b"HTTP/1.1 20") or status not in (b"201", b"202") or status in self.lost:
            return False
        self.lost.append(status)
        return True


class Upload(ServerTestCase):
    def setUp(self):
        super().setUp()
        self.card = pathlib.Path(tempfile.mkdtemp(prefix="a card with spaces ", dir=self.scratch))
        for name, content in self.photos:
            (self.card / f"a {name}").write_bytes(content)

    def upload(self, server, *arguments, **how):
        return run("upload", self.card, "--server", f"http://127.0.0.1:{server.port}/", *arguments, **how)

    def test_a_folder_becomes_a_map_and_grows(self):
        server = self.serve()
        done = self.upload(server, "--name", "Field 7")
        self.assertIn("6 files sent", done.stdout)
        flight = server.json("GET", "/api/v1/flights")[1]["flights"][0]
        self.assertEqual((flight["name"], flight["state"], flight["photos"]["total"]), ("Field 7", "ready", 6))
        self.assertIn(f"http://127.0.0.1:{server.port}/#/flights/{flight['id']}", done.stdout)
        (self.card / "log.txt").write_text("nothing of interest")
        self.assertIn("1 file sent, 6 were there", self.upload(server, "--flight", flight["id"], "--no-map").stdout)

    def test_a_list_that_was_edited_is_sent_beside_the_one_there(self):
        server = self.serve("--workers", "0")
        list_here = self.card / "geo.txt"
        list_here.write_text("EPSG:4326\na.jpg 7.1 46.1\n")
        self.upload(server, "--no-map")
        flight = server.json("GET", "/api/v1/flights")[1]["flights"][0]["id"]

        def sent_again():
            done = self.upload(server, "--no-map", "--flight", flight)
            names = [file["name"] for file in server.json("GET", f"/api/v1/flights/{flight}/files")[1]["files"] if file["name"].startswith("geo")]
            return done.stdout.splitlines()[0], "Another geo.txt is there" in done.stderr, names
        self.assertEqual(sent_again(), ("0 files sent, 7 were there", False, ["geo.txt"]))
        list_here.write_text("EPSG:4326\na.jpg 7.2 46.2\n")  # as long as before
        first, is_told, names = sent_again()
        self.assertEqual((first, is_told, len(names)), ("1 file sent, 6 were there", True, 2))
        self.assertEqual(sent_again(), ("0 files sent, 7 were there", True, names))
        self.assertEqual(server.request("GET", f"/api/v1/flights/{flight}/files/{names[0]}")[2], list_here.read_bytes())

    def test_a_folder_whose_name_is_longer_than_a_flights_may_be_is_sent(self):
        server = self.serve("--workers", "0")
        self.card = self.card.rename(self.card.with_name("Ж" * 120))
        self.upload(server, "--no-map")
        self.assertEqual(server.json("GET", "/api/v1/flights")[1]["flights"][0]["name"], "Ж" * 100)

    def test_goes_on_where_the_connection_broke(self):
        (self.card / "long.bin").write_bytes(bytes(range(256)) * (160 << 10))  # 40 MB
        server = self.serve()
        proxy = BreakingProxy(server.port, breaks_after=20 << 20)
        self.upload(proxy, "--no-map")
        self.assertTrue(proxy.has_broken)
        self.assertLess(proxy.passed, 55 << 20)  # not sent from its beginning again
        flight = server.json("GET", "/api/v1/flights")[1]["flights"][0]
        files = server.json("GET", f"/api/v1/flights/{flight['id']}/files")[1]["files"]
        self.assertEqual(sorted(file["name"] for file in files), sorted(path.name for path in self.card.iterdir()))
        whole = server.request("GET", f"/api/v1/flights/{flight['id']}/files/long.bin")[2]
        self.assertEqual(whole, (self.card / "long.bin").read_bytes())

    def test_what_was_done_is_not_done_again_where_the_answer_was_lost(self):
        server = self.serve("--workers", "0")
        proxy = LosingProxy(server.port)
        self.upload(proxy, "--no-wait")
        self.assertEqual(proxy.lost, [b"201", b"202"])
        self.assertEqual(len(server.json("GET", "/api/v1/flights")[1]["flights"]), 1)
        self.assertEqual(len(server.json("GET", "/api/v1/jobs")[1]["jobs"]), 1)

    def test_a_server_that_is_not_there_yet_is_waited_for(self):
        with socket.create_server(("127.0.0.1", 0)) as free:
            port = free.getsockname()[1]
        upload = subprocess.Popen([BINARY, "upload", self.card, "--server", f"http://127.0.0.1:{port}", "--no-map"], stdout=subprocess.PIPE,
                                  stderr=subprocess.PIPE, text=True)
        for line in upload.stderr:
            if again := re.search(r"Trying again for (\d+) s", line):
                break
        self.assertGreater(int(again[1]), 500)  # as long as for one that goes away
        server = self.serve(listen=f"127.0.0.1:{port}")
        out, said = upload.communicate(timeout=240)
        self.assertEqual(upload.returncode, 0, said)
        self.assertIn("6 files sent", out)
        self.assertEqual(server.json("GET", "/api/v1/flights")[1]["flights"][0]["file_count"], 6)

    def test_refusals_are_in_words(self):
        server = self.serve()
        token = add_token(self.data, "pilot", "--scope", "upload")
        wait_until(lambda: server.request("GET", "/api/v1/flights")[0] == 401, "the token is not asked for")
        self.assertIn("SKYQUILT_TOKEN", self.upload(server, code=1).stderr)
        self.upload(server, "--no-map", env={"SKYQUILT_TOKEN": token})
        for address, words in (("nonsense", "is no address"), ("http://127.0.0.1:9", "does not answer")):
            self.assertIn(words, run("upload", self.card, "--server", address, "--patience", "1", code=1).stderr)
        (self.card / "a\\b.jpg").write_bytes(b"x")
        self.assertIn("a\\b.jpg: This file name cannot be used", self.upload(server, "--no-map", env={"SKYQUILT_TOKEN": token}, code=1).stderr)
