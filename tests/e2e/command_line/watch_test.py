"""`skyquilt watch` against the real server, and `serve --watch`: a card becomes flights, once, through restarts, kills, a server that is away, a
disk that comes and goes and photos that are still being written. Nothing on the card changes."""
import os
import pathlib
import re
import shutil
import signal
import struct
import subprocess
import tempfile
import time

from program import BINARY, run
from server_support import ServerTestCase, add_token, bearer, is_running, wait_until


def at_hour(photo, hour):
    """The same photo of another time of day, by the clock of the camera and of the GPS."""
    clock, gps = b"2024:06:01 10:", struct.pack("<IIII", 10, 1, 0, 1)
    assert clock in photo and photo.count(gps) == 1
    return photo.replace(clock, b"2024:06:01 %02d:" % hour).replace(gps, struct.pack("<IIII", hour, 1, 0, 1))


def catches(pid, number):
    """Whether a process has a handler for a signal."""
    caught = re.search(r"^SigCgt:\s*([0-9a-f]+)$", pathlib.Path(f"/proc/{pid}/status").read_text(), re.MULTILINE)
    return bool(int(caught[1], 16) >> (number - 1) & 1)


class Watch(ServerTestCase):
    def setUp(self):
        super().setUp()
        self.card = pathlib.Path(tempfile.mkdtemp(prefix="card_", dir=self.scratch))
        self.state = pathlib.Path(tempfile.mkdtemp(prefix="state_", dir=self.scratch))
        self.watches = []

    def tearDown(self):
        for watch in self.watches:
            if watch.poll() is None:
                watch.kill()
            watch.wait()
            watch.stdout.close()
        super().tearDown()

    def fill(self, folder, photos, hour=10):
        folder = self.card / folder
        folder.mkdir(parents=True, exist_ok=True)
        for name, content in photos:
            (folder / name).write_bytes(at_hour(content, hour))

    def words(self, server, *words):
        return [BINARY, "watch", self.card, "--server", f"http://127.0.0.1:{server if isinstance(server, int) else server.port}",
                "--no-map", *([] if "--settle" in words else ["--settle", "1"]), *words]

    def env(self):
        return {**os.environ, "XDG_STATE_HOME": str(self.state)}

    def once(self, server, *words):
        """What is there, which nobody is writing any more."""
        return subprocess.run(self.words(server, "--once", "--settle", "0.2", *words), capture_output=True, text=True, env=self.env(), timeout=120)

    def watch(self, server, *words):
        log = open(self.state / "log", "a+")
        self.addCleanup(log.close)
        watch = subprocess.Popen(self.words(server, *words), stdout=subprocess.PIPE, stderr=log, text=True, env=self.env())
        self.watches.append(watch)
        return watch

    def hear(self, watch, words):
        """Waits for a line with these words."""
        while words not in (line := watch.stdout.readline()):
            self.assertTrue(line, f"it ended and never said {words!r}")

    def end(self, watch):
        # One that has only just begun is ended by the signal itself.
        wait_until(lambda: watch.poll() is not None or catches(watch.pid, signal.SIGTERM), "it never got ready to be stopped")
        watch.send_signal(signal.SIGTERM)
        said = watch.communicate(timeout=30)[0]
        self.assertEqual(watch.returncode, 0, said)
        return said

    def flights(self, server):
        """{name: names of its files}"""
        found = {}
        for flight in server.json("GET", "/api/v1/flights")[1]["flights"]:
            files = server.json("GET", f"/api/v1/flights/{flight['id']}/files")[1]["files"]
            found[flight["name"]] = sorted(file["name"] for file in files)
        return found

    def contents(self):
        return {path: (path.read_bytes(), path.stat().st_mtime_ns) for path in self.card.rglob("*") if path.is_file()}

    def test_a_map_below_its_photos_is_not_sent(self):
        self.fill("field", self.photos)
        self.fill("field/map", [("thumbnail.png", self.photos[0][1])])
        (self.card / "field/map/mosaic.state").write_bytes(b"of a map")
        (self.card / "field/map/geo.txt").write_text("EPSG:4326\n" + "".join(f"{name} 7.4000000000 46.9000000000 600.0000 0.000000 0.000000 0.000000\n" for name, _ in self.photos))
        server = self.serve()
        done = self.once(server)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("Not sent, as parts of a map that was made there: 3 files", done.stdout)
        self.assertEqual(list(self.flights(server).values()), [sorted(name for name, _ in self.photos)])

    def test_a_card_becomes_its_flights_and_only_once(self):
        self.fill("DCIM/100MEDIA", self.photos[:2])
        self.fill("DCIM/101MEDIA", [(self.photos[0][0], self.photos[2][1])])  # the camera counts from the start again
        self.fill("DCIM/101MEDIA", [("later.JPG", self.photos[3][1])], hour=15)
        self.fill("DCIM/field_7/images", self.photos[4:])
        (self.card / "DCIM/field_7/images/notes.docx").write_bytes(b"PK\3\4 of no interest")
        (self.card / "MISC/THM").mkdir(parents=True)
        (self.card / "MISC/THM/1.JPG").write_bytes(self.photos[0][1])
        before = self.contents()
        server = self.serve()
        done = self.once(server, "--name", "Farm: ")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("3 new flights, 6 files sent", done.stdout)
        flights = self.flights(server)
        field = next(name for name in flights if "field_7" in name)
        self.assertEqual(field, "Farm: field_7, 2024-06-01 10:00")
        self.assertEqual(flights[field], [name for name, _ in self.photos[4:]])
        self.assertEqual(sorted(len(files) for files in flights.values()), [1, 2, 3])
        rolled = next(files for files in flights.values() if len(files) == 3)
        self.assertEqual(rolled, sorted([self.photos[1][0], "100MEDIA_" + self.photos[0][0], "101MEDIA_" + self.photos[0][0]]))
        # The card again, in another slot, by another process: nothing.
        moved = self.card.with_name(self.card.name + "_slot_b")
        shutil.copytree(self.card, moved)
        self.assertEqual(self.contents(), before)
        self.card = moved
        self.assertIn("0 new flights, 0 files sent", self.once(server).stdout)
        self.assertEqual(self.flights(server), flights)
        # One photo more joins its flight.
        self.fill("DCIM/field_7/images", [("more.JPG", self.photos[3][1])])
        more = self.once(server)
        self.assertIn("0 new flights, 1 file sent", more.stdout)
        self.assertEqual(self.flights(server)[field], sorted(flights[field] + ["more.JPG"]))
        # Deleted there, it does not come back by itself.
        for flight in server.json("GET", "/api/v1/flights")[1]["flights"]:
            server.request("DELETE", f"/api/v1/flights/{flight['id']}")
        self.assertIn("0 new flights, 0 files sent", self.once(server).stdout)
        self.assertEqual(self.flights(server), {})
        self.fill("DCIM/field_7/images", [("last.JPG", self.photos[0][1] + b"\0")])
        self.assertIn("1 new flight, 4 files sent", self.once(server).stdout)

    def test_a_folder_that_fills_is_sent_when_it_rests(self):
        server = self.serve()
        watch = self.watch(server, "--settle", "2")
        self.fill("job", self.photos[:2])
        cut = self.card / "job" / self.photos[2][0]
        content = self.photos[2][1]
        for share in (0.2, 0.5, 0.8):
            cut.write_bytes(content[:int(len(content) * share)])
            time.sleep(0.8)
        self.assertEqual(self.flights(server), {})
        cut.write_bytes(content)
        wait_until(lambda: self.flights(server), "nothing was sent")
        wait_until(lambda: len(list(self.flights(server).values())[0]) == 3, f"not all was sent: {self.flights(server)}")
        self.fill("job", self.photos[3:5])
        self.hear(watch, "2 files sent to the flight they belong to")
        self.assertEqual(len(list(self.flights(server).values())[0]), 5)
        self.assertEqual(len(self.flights(server)), 1)
        self.assertIn("1 new flight, 5 files sent", self.end(watch))

    def test_a_photo_that_never_ends_holds_up_nobody(self):
        self.fill("job", self.photos[:2])
        (self.card / "job" / "broken.JPG").write_bytes(self.photos[2][1][:-5000])
        (self.card / "job" / "empty.JPG").write_bytes(b"")
        server = self.serve()
        done = self.once(server)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("2 photos are cut off", done.stdout)
        self.assertEqual(list(self.flights(server).values()), [[name for name, _ in self.photos[:2]]])

    def test_a_server_that_is_away_is_waited_for_and_a_kill_makes_nothing_twice(self):
        self.fill("job", self.photos)
        (self.card / "job" / "track.gpx").write_text("<gpx version='1.1'><trk><trkseg>" + "".join(
            f"<trkpt lat='46.8' lon='7.{i:04}'><time>2024-06-01T10:00:{i % 60:02}Z</time></trkpt>" for i in range(60)) + "</trkseg></trk></gpx>")
        first = self.serve()
        port = first.port
        first.kill()
        watch = self.watch(port)
        while "It is asked again" not in watch.stdout.readline():
            self.assertIsNone(watch.poll())
        for _ in range(4):  # killed wherever it is
            server = self.serve("--listen", f"127.0.0.1:{port}") if not self.servers[-1].process.poll() is None else self.servers[-1]
            time.sleep(0.7)
            watch.kill()
            watch.wait()
            watch = self.watch(port)
        wait_until(lambda: any(len(files) == 7 for files in self.flights(server).values()), "not all was sent")
        self.assertEqual(len(self.flights(server)), 1, self.flights(server))
        self.end(watch)
        self.assertIn("0 new flights, 0 files sent", self.once(server).stdout)
        self.assertEqual(len(self.flights(server)), 1)

    def test_a_disk_that_comes_goes_and_comes(self):
        server = self.serve()
        elsewhere = self.card.with_name(self.card.name + "_elsewhere")
        self.card.rename(elsewhere)
        watch = self.watch(server)
        self.assertIn("is not there; waiting for it", watch.stdout.readline())
        (elsewhere / "a").mkdir()
        (elsewhere / "a" / "1.JPG").write_bytes(self.photos[0][1])
        elsewhere.rename(self.card)
        self.hear(watch, "a, 2024-06-01 10:00: 1 file sent")
        self.card.rename(elsewhere)
        self.hear(watch, "is not there; waiting for it")
        (elsewhere / "b").mkdir()
        (elsewhere / "b" / "2.JPG").write_bytes(self.photos[1][1])
        elsewhere.rename(self.card)
        self.hear(watch, "b, 2024-06-01 10:00: 1 file sent")
        self.assertIn("2 new flights, 2 files sent", self.end(watch))
        self.assertEqual(sorted(self.flights(server).values()), [["1.JPG"], ["2.JPG"]])

    def test_a_folder_whose_name_is_longer_than_a_flights_may_be_is_sent(self):
        self.fill("Ж" * 120, self.photos[:1])
        server = self.serve()
        done = self.once(server)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertEqual(list(self.flights(server)), ["Ж" * 100])

    def test_maps_are_made_once(self):
        self.fill("job", self.photos)
        server = self.serve()
        done = subprocess.run([word for word in self.words(server, "--once") if word != "--no-map"], capture_output=True, text=True, env=self.env())
        self.assertEqual(done.returncode, 0, done.stderr)
        flight = server.json("GET", "/api/v1/flights")[1]["flights"][0]["id"]
        wait_until(lambda: server.json("GET", f"/api/v1/flights/{flight}")[1]["state"] == "ready", "no map was made")

    def test_refusals_are_in_words(self):
        server = self.serve()
        self.fill("job", self.photos[:1])
        gone = run("watch", self.card / "none", "--once", "--server", f"http://127.0.0.1:{server.port}", code=None, env=self.env())
        self.assertEqual((gone.returncode, gone.stderr.count("is not there")), (1, 1))
        away = subprocess.run(self.words(9, "--once", "--patience", "1"), capture_output=True, text=True, env=self.env(), timeout=120)
        self.assertEqual(away.returncode, 1)
        self.assertIn("does not answer", away.stderr)
        self.assertIn("is no address", run("watch", self.card, "--server", "maps", code=None, env=self.env()).stderr)
        self.token("pilot", "--scope", "upload")
        wait_until(lambda: server.request("GET", "/api/v1/flights")[0] == 401, "the token is not asked for")
        refused = self.once(server)
        self.assertEqual(refused.returncode, 1)
        self.assertIn("SKYQUILT_TOKEN", refused.stderr)


class ServeWatch(ServerTestCase):
    def setUp(self):
        super().setUp()
        self.card = pathlib.Path(tempfile.mkdtemp(prefix="card_", dir=self.scratch))

    def fill(self, folder, photos):
        (self.card / folder).mkdir(parents=True, exist_ok=True)
        for name, content in photos:
            (self.card / folder / name).write_bytes(content)

    def flights(self, server, token=""):
        headers = bearer(token) if token else {}
        return server.json("GET", "/api/v1/flights", headers=headers)[1]["flights"]

    def watcher(self, server):
        """The process that watches, once it is there."""
        def watchers():
            return [pid for pid in server.workers() if b"watch" in pathlib.Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0")]
        return wait_until(watchers, f"nobody watches: {server.errors()}")[0]

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
        token = add_token(self.data, "cards", "--scope", "upload")
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
