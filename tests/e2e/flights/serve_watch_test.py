"""`skyquilt serve --watch`: a folder that fills becomes flights of the server itself, once through restarts and kills."""
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from server_support import BINARY, ServerTestCase, is_running, wait_until  # noqa: E402


class ServeWatch(ServerTestCase):
    def setUp(self):
        super().setUp()
        self.card = pathlib.Path(tempfile.mkdtemp(prefix="card_", dir=self.scratch))

    def fill(self, folder, photos):
        (self.card / folder).mkdir(parents=True, exist_ok=True)
        for name, content in photos:
            (self.card / folder / name).write_bytes(content)

    def flights(self, server, token=""):
        headers = {"Authorization": f"Bearer {token}"} if token else {}
        return json.loads(server.request("GET", "/api/v1/flights", headers=headers)[2])["flights"]

    def watcher(self, server):
        """The process that watches, once it is there."""
        found = []

        def is_there():
            found[:] = [pid for pid in server.workers() if b"watch" in pathlib.Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0")]
            return found
        wait_until(is_there, f"nobody watches: {server.errors()}")
        return found[0]

    def test_a_folder_becomes_flights_once(self):
        late = self.card.with_name(self.card.name + "_comes_later")
        server = self.serve("--workers", "1", "--watch", self.card, "--watch", late)
        self.fill("DCIM/100MEDIA", self.photos[:3])
        wait_until(lambda: [flight["state"] for flight in self.flights(server)] == ["ready"], server.errors())
        self.assertEqual(self.flights(server)[0]["photos"]["total"], 3)
        watcher = self.watcher(server)
        os.kill(watcher, signal.SIGKILL)
        wait_until(lambda: self.watcher(server) != watcher, "it was not started again")
        self.assertIn("watches folders ended by signal 9", server.errors())
        watcher = self.watcher(server)
        self.assertEqual(server.stop(), 0)
        self.assertFalse(is_running(watcher))
        # Another port, as after a change of its address: what was taken stays taken, and what came meanwhile joins its flight.
        self.fill("DCIM/100MEDIA", self.photos[3:4])
        server = self.serve("--workers", "1", "--watch", self.card, "--watch", late)
        wait_until(lambda: [(flight["photos"] or {}).get("total") for flight in self.flights(server)] == [4], server.errors())
        late.mkdir()
        (late / self.photos[5][0]).write_bytes(self.photos[5][1])
        wait_until(lambda: len(self.flights(server)) == 2, server.errors())
        # A kill of the server takes it along.
        watcher = self.watcher(server)
        server.kill()
        self.assertFalse(is_running(watcher))

    def test_where_tokens_are_asked_for(self):
        made = subprocess.run([BINARY, "token", "add", "cards", "--data", self.data, "--scope", "upload"], check=True, capture_output=True, text=True)
        token = next(word for word in made.stdout.split() if word.startswith("sq_"))
        self.assertIn("--watch-token-file", self.refusal("--watch", str(self.card)))
        file = pathlib.Path(self.scratch, "token")
        file.write_text(token + "\n")
        self.fill("DCIM", self.photos[:2])
        server = self.serve("--workers", "0", "--watch", self.card, "--watch-token-file", file)
        wait_until(lambda: [flight["file_count"] for flight in self.flights(server, token)] == [2], server.errors())
        self.assertNotIn(token, pathlib.Path(f"/proc/{self.watcher(server)}/cmdline").read_text())

    def test_the_data_folder_is_not_watched(self):
        for folder in (self.data, pathlib.Path(self.data).parent, pathlib.Path(self.data, "flights")):
            self.assertIn("data folder", self.refusal("--watch", str(folder)))


if __name__ == "__main__":
    unittest.main()
