"""Kills at random moments over upload, resumable upload, archive, job, append, preview and delete, then a catalogue that is
gone, emptied or an hour old: nothing accepted is lost, nothing is published twice, no attempt is wrongly counted.

SKYQUILT_KILLS (default 8) says how many kills, SKYQUILT_KILL_SEED where the dice start.
"""
import hashlib
import http.client
import io
import json
import os
import pathlib
import random
import shutil
import sqlite3
import subprocess
import threading
import time
import urllib.parse
import zipfile

from program import BINARY, run
from server_support import CHUNK, TUS, ServerTestCase, is_running, kill_if_there, parts_of, tus_metadata, wait_until

KILLS = int(os.environ.get("SKYQUILT_KILLS", "8"))
SEED = int(os.environ.get("SKYQUILT_KILL_SEED", "1"))
MAX_ATTEMPTS = 3
PIECE = 40_000  # bytes of one PATCH of a resumable upload


def digest(content):
    return hashlib.sha256(content).hexdigest()


def descendants(pid):
    """Process ids below a process, children first."""
    found = []
    try:
        children = pathlib.Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    except (FileNotFoundError, ProcessLookupError):
        return found
    for child in map(int, children):
        found.append(child)
        found.extend(descendants(child))
    return found


def role_of(pid):
    """What a process below the server is for, by its command line."""
    try:
        words = pathlib.Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0")
    except (FileNotFoundError, ProcessLookupError):
        return "gone"
    if b"--previews" in words or b"paint" in words[1:2]:
        return "painter"
    return words[1].decode() if len(words) > 1 else "gone"


class Client(threading.Thread):
    """A user with a bad server: tries everything again until it is answered, and writes down what was promised."""

    def __init__(self, test, number):
        super().__init__(name=f"client {number}")
        self.test = test
        self.random = random.Random(f"{SEED}/{number}")
        self.accepted = {}   # flight -> {file name: digest}
        self.deleted = set()
        self.in_doubt = set()  # deletes that were sent and not yet answered
        self.jobs = {}       # job -> flight
        self.failure = None

    def run(self):
        try:
            while not self.test.is_over.is_set():
                self.one_flight()
        except Exception as failure:  # shown by the test, which fails
            self.failure = failure

    def ask(self, method, path, body=None, headers=None, fine=(200, 201, 202, 204)):
        """Until answered. A refusal that says to wait (503, 429, 423) is asked again; any other is an error."""
        while True:
            try:
                connection = http.client.HTTPConnection("127.0.0.1", self.test.port, timeout=60)
                try:
                    connection.request(method, path, body=body, headers=headers or {})
                    response = connection.getresponse()
                    status, found, answer = response.status, response.headers, response.read()
                finally:
                    connection.close()
            except (OSError, http.client.HTTPException):
                time.sleep(0.05)
                if self.test.is_over.is_set() and not self.test.is_up.is_set():
                    raise InterruptedError("the server is not coming back")
                continue
            if status in fine:
                return status, found, answer
            if status in (429, 503, 423):
                time.sleep(0.1)
                continue
            raise AssertionError(f"{method} {path}: {status} {answer[:300]}")

    def json(self, method, path, value=None, fine=(200, 201, 202, 204)):
        body = None if value is None else json.dumps(value)
        headers = {} if value is None else {"Content-Type": "application/json"}
        status, _, answer = self.ask(method, path, body, headers, fine)
        return status, json.loads(answer) if answer else {}

    def put(self, flight, name, content):
        self.ask("PUT", f"/api/v1/flights/{flight}/files/{name}", content)
        self.accepted[flight][name] = digest(content)

    def tus(self, flight, name, content):
        _, found, _ = self.ask("POST", "/api/v1/uploads", None, {**TUS, **tus_metadata(flight, name), "Upload-Length": str(len(content))})
        where = "/api/v1/uploads/" + found["Location"].rstrip("/").rsplit("/", 1)[1]
        while True:
            status, found, _ = self.ask("HEAD", where, None, TUS, fine=(200, 204))
            offset = int(found["Upload-Offset"])
            if offset == len(content):
                break
            self.ask("PATCH", where, content[offset:offset + PIECE], {**CHUNK, "Upload-Offset": str(offset)}, fine=(204, 409, 423, 460))
        self.accepted[flight][name] = digest(content)

    def archive(self, flight, photos):
        packed = io.BytesIO()
        with zipfile.ZipFile(packed, "w") as made:
            for name, content in photos:
                made.writestr(name, content)
        self.ask("PUT", f"/api/v1/flights/{flight}/files/more-{self.random.randrange(10**6)}.zip", packed.getvalue())

    def start_job(self, flight):
        while True:
            status, job = self.json("POST", f"/api/v1/flights/{flight}/jobs", {}, fine=(200, 201, 202, 409))
            if status != 409:
                self.jobs[job["id"]] = flight
                return job["id"]
            time.sleep(0.2)

    def make_map(self, flight):
        """As a user would: a job that was killed too often is started again."""
        job = self.start_job(flight)
        while not self.test.is_over.is_set():
            _, state = self.json("GET", f"/api/v1/jobs/{job}")
            if state["state"] == "successful":
                return
            if state["finished_at"]:
                job = self.start_job(flight)
            time.sleep(0.2)

    def one_flight(self):
        _, made = self.json("POST", "/api/v1/flights", {"name": self.name})
        flight = made["id"]
        self.accepted[flight] = {}
        photos = list(self.test.photos)
        self.random.shuffle(photos)
        for name, content in photos[:2]:
            self.put(flight, name, content)
        self.tus(flight, photos[2][0], photos[2][1])
        if self.random.random() < 0.5:
            self.archive(flight, photos[3:5])
        else:
            for name, content in photos[3:5]:
                self.put(flight, name, content)
        self.make_map(flight)
        if self.random.random() < 0.6:  # append to what is finished
            self.put(flight, *photos[5])
            self.make_map(flight)
        if self.random.random() < 0.3:
            self.in_doubt.add(flight)
            self.ask("DELETE", f"/api/v1/flights/{flight}", fine=(204, 404))
            self.deleted.add(flight)


class RandomKills(ServerTestCase):
    def setUp(self):
        super().setUp()
        self.is_over = threading.Event()
        self.is_up = threading.Event()
        self.port = 0
        self.alone_kills = 0  # of processes below a server that went on: each may cost one attempt

    def start(self):
        self.server = self.serve()
        self.port = self.server.port
        self.is_up.set()

    def kill_server(self):
        self.is_up.clear()
        self.server.kill()

    def strike(self, dice):
        """One kill of something that lives now; says what it was."""
        below = descendants(self.server.process.pid)
        if dice.random() < 0.35 or not below:
            self.kill_server()
            self.start()
            return "server"
        if dice.random() < 0.3:
            self.is_up.clear()
            for pid in [self.server.process.pid, *below]:
                kill_if_there(pid)
            self.server.process.wait()
            for pid in below:
                wait_until(lambda: not is_running(pid), "a killed process goes on")
            self.server.close()
            self.start()
            return "all at once"
        victim = dice.choice(below)
        role = role_of(victim)
        self.alone_kills += 1
        kill_if_there(victim)
        return role

    def test_nothing_accepted_is_lost(self):
        dice = random.Random(SEED)
        self.start()
        clients = [Client(self, number) for number in range(2)]
        for client in clients:
            client.start()
        struck = {}
        early = pathlib.Path(self.scratch, "earlier.db")
        for number in range(KILLS):
            time.sleep(dice.uniform(0.1, 1.6))
            what = self.strike(dice)
            struck[what] = struck.get(what, 0) + 1
            if number == KILLS // 2:
                with sqlite3.connect(self.server.data / "catalogue.db") as source, sqlite3.connect(early) as copy:
                    source.backup(copy)
            for client in clients:
                self.assertIsNone(client.failure, f"{client.failure!r} after {struck} {self.server.errors()}")
        print("kills:", struck, flush=True)
        self.is_over.set()
        for client in clients:
            client.join()
            self.assertIsNone(client.failure, f"{client.failure!r} after {struck} {self.server.errors()}")
        # The last one may have hit a single process: what it left is swept at the next start.
        self.kill_server()
        self.start()
        self.check_promises(clients)
        self.check_broken_catalogues(early)

    def check_promises(self, clients):
        extra_attempts = 0
        for client in clients:
            for job, flight in client.jobs.items():
                if flight in client.in_doubt:
                    continue
                state = self.server.wait_for_job(job)
                if state["state"] != "successful":
                    # Killed as often as a job may be, by itself or with its server, and said so.
                    is_given_up = state["attempts"] == MAX_ATTEMPTS or "was interrupted" in state["error"]["message"]
                    self.assertTrue(is_given_up, f"{state} {self.server.errors()}")
                extra_attempts += max(0, state["attempts"] - 1)
            for flight, files in client.accepted.items():
                if flight in client.deleted:
                    self.assertEqual(self.server.request("GET", f"/api/v1/flights/{flight}")[0], 404)
                if flight in client.in_doubt:
                    continue
                parts = parts_of(self.server.data, flight)  # its photos, the map that is shown, at most one before it
                self.assertLessEqual(len(parts), 3, parts)
                for name, expected in files.items():
                    status, _, content = self.server.request("GET", f"/api/v1/flights/{flight}/files/{name}")
                    self.assertEqual(status, 200, f"{flight}/{name} was accepted and is gone")
                    self.assertEqual(digest(content), expected, f"{flight}/{name} came back changed")
        self.assertLessEqual(extra_attempts, self.alone_kills, "a restart was counted as an attempt")
        wait_until(lambda: self.server.garbage() == [], lambda: f"left over: {self.server.garbage()}")
        with sqlite3.connect(self.server.data / "catalogue.db") as catalogue:
            self.assertEqual(catalogue.execute("PRAGMA quick_check").fetchall(), [("ok",)])
            twice = catalogue.execute(
                "SELECT flight_id, json_extract(body, '$.revision') AS r, count(*) FROM event WHERE kind = 'map' "
                "GROUP BY 1, 2 HAVING count(*) > 1").fetchall()
            self.assertEqual(twice, [], "a revision was shown twice")
            more = catalogue.execute(
                "SELECT e.flight_id, count(*) AS shown, (SELECT count(*) FROM job j WHERE j.flight_id = e.flight_id "
                "AND j.state = 'successful') AS jobs FROM event e WHERE kind = 'map' "
                "AND e.flight_id IN (SELECT id FROM flight) GROUP BY 1 HAVING shown > jobs").fetchall()
            self.assertEqual(more, [], "more maps were shown than jobs succeeded")

    def inventory(self):
        """Digests of every photo and map on disk, wherever below the data folder they lie."""
        found = []
        for path in pathlib.Path(self.data).rglob("*"):
            in_flight = "flights" in path.parts or "lost" in path.parts
            if path.is_file() and in_flight and path.suffix in (".mbtiles", ".tif") or path.parent.name == "files":
                found.append(digest(path.read_bytes()))
        return sorted(found)

    def shown(self):
        """What a client sees of every flight: bytes of each file and of one tile of its map."""
        seen = {}
        _, page = self.server.json("GET", "/api/v1/flights?limit=100")
        for flight in page["flights"]:
            where = f"/api/v1/flights/{flight['id']}"
            _, listed = self.server.json("GET", where + "/files")
            files = {file["name"]: digest(self.server.request("GET", f"{where}/files/{urllib.parse.quote(file['name'])}")[2])
                     for file in listed["files"]}
            status, _, map_bytes = self.server.request("GET", where + "/download.mbtiles")
            seen[flight["id"]] = (files, digest(map_bytes) if status == 200 else None)
        return seen

    def check_broken_catalogues(self, early):
        """A catalogue that is gone, emptied or old costs nothing, and `data repair` brings everything back."""
        before = self.shown()
        self.assertEqual(self.server.stop(), 0)
        good = pathlib.Path(self.scratch, "good.db")
        database = pathlib.Path(self.data, "catalogue.db")
        with sqlite3.connect(database) as source, sqlite3.connect(good) as copy:
            source.backup(copy)
        on_disk = self.inventory()
        self.assertTrue(on_disk)
        for kind in ("removed", "emptied", "an hour old"):
            with self.subTest(catalogue=kind):
                for path in database.parent.glob("catalogue.db*"):
                    path.unlink()
                if kind == "emptied":
                    database.touch()
                elif kind == "an hour old":
                    shutil.copy(early, database)
                # Whether it starts or refuses, it removes nothing.
                process = subprocess.Popen([BINARY, "serve", "--data", self.data, "--listen", "127.0.0.1:0", "--workers", "0"],
                                           stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
                said = process.stdout.readline()
                if "http://" in said:  # it serves: three seconds to do harm
                    time.sleep(3)
                    process.terminate()
                said += process.communicate(timeout=60)[0]
                if kind != "an hour old":
                    self.assertIn("skyquilt data repair", said)
                self.assertEqual(self.inventory(), on_disk, f"a photo or map is gone: {said}")
                repaired = run("data", "repair", "--data", self.data, timeout=300)
                self.assertEqual(self.inventory(), on_disk, repaired.stdout)
                self.start()
                after = self.shown()
                for flight, content in before.items():
                    self.assertEqual(after.get(flight), content, f"flight {flight} after repair: {repaired.stdout}")
                self.assertEqual(self.server.stop(), 0)
