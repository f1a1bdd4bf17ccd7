"""What the server's end-to-end tests share: the real binary on a free port, plain HTTP, a simulated flight."""
import base64
import concurrent.futures
import contextlib
import http.client
import json
import math
import os
import pathlib
import re
import shutil
import signal
import sqlite3
import subprocess
import tempfile
import time
import urllib.parse

import contract
import s3_store
from cluster import swift_store
from flights import made_flights
from program import BINARY, ScratchCase, run

AS_JSON = {"Content-Type": "application/json"}
BOUNDARY = "skyquilt-test-boundary"
FORM = {"Content-Type": f"multipart/form-data; boundary={BOUNDARY}"}
TUS = {"Tus-Resumable": "1.0.0"}
CHUNK = {**TUS, "Content-Type": "application/offset+octet-stream"}
# With the URL of a PostgreSQL server (tests/support/postgres_server.py) every data folder has its catalogue there.
POSTGRES = os.environ.get("SKYQUILT_TEST_POSTGRES")
# With the address of a bucket, and of s3rver's its folder, (cluster/both_stores.py) its photos and maps lie there.
BLOBS = os.environ.get("SKYQUILT_TEST_BLOBS")
BLOBS_FOLDER = os.environ.get("SKYQUILT_TEST_BLOBS_FOLDER")
PATIENCE_S = 240  # machines that test are slow and shared; nothing here measures time


def name_elsewhere(data):
    """What a data folder is called in PostgreSQL and in the store."""
    return "e" + "".join(f"_{c.lower()}" if c.isupper() else c for c in str(data) if c.isalnum())[-40:]


def catalogue_words(data):
    """Options that say where the catalogue of a data folder lies; none where it lies in the folder."""
    return [] if POSTGRES is None else ["--catalogue", f"{POSTGRES}&schema={name_elsewhere(data)}"]


def storage_words(data):
    """The same, and where its photos and maps lie: for servers and workers."""
    return catalogue_words(data) + ([] if BLOBS is None else ["--blobs", BLOBS + name_elsewhere(data)])


def preloading(library):
    """Variables of a process that loads a library before all others; a sanitizer wants to be that by itself."""
    checks = os.environ.get("ASAN_OPTIONS")
    return {"LD_PRELOAD": str(library)} | ({} if checks is None else {"ASAN_OPTIONS": checks + ":verify_asan_link_order=0"})


def kept_of_flights(data):
    """The files that are kept of flights, wherever they lie, by their names below flights/."""
    folder = pathlib.Path(data, "flights")
    kept = {str(path.relative_to(folder)): path for path in s3_store.files_below(folder)}
    if BLOBS is not None:
        below = f"{name_elsewhere(data)}/flights/"
        if BLOBS_FOLDER is None:  # a store that keeps its objects in a way of its own
            objects = swift_store.objects_in(os.environ["AWS_ENDPOINT_URL"], below)
        else:
            objects = s3_store.objects_in(pathlib.Path(BLOBS_FOLDER))
        kept.update({key.removeprefix(below): path for key, path in objects.items() if key.startswith(below)})
    return kept


def photos_of(data, flight):
    """The uploaded files of a flight."""
    return [path for name, path in kept_of_flights(data).items() if name.startswith(f"{flight}/files/")]


def parts_of(data, flight):
    """What there is of a flight: its files and its maps, without the record that a catalogue in the folder wants."""
    parts = {name.split("/")[1] for name in kept_of_flights(data) if name.startswith(f"{flight}/")}
    return sorted(parts - {"flight.jsonl"})


def in_catalogue(data, sql, *values):
    """The rows of a statement in the catalogue of a data folder, wherever it lies; values take the place of question marks."""
    if POSTGRES is None:
        with contextlib.closing(sqlite3.connect(pathlib.Path(data, "catalogue.db"), timeout=30, isolation_level=None)) as catalogue:
            return catalogue.execute(sql, values).fetchall()
    for value in values:
        sql = sql.replace("?", "'" + str(value).replace("'", "''") + "'", 1)
    said = subprocess.run(["psql", "-X", "-q", "-A", "-t", "-d", POSTGRES, "-c", f'SET search_path TO "{name_elsewhere(data)}"', "-c", sql],
                          check=True, stdout=subprocess.PIPE, text=True).stdout
    return [tuple(int(value) if value.lstrip("-").isdigit() else value for value in line.split("|"))
            for line in said.splitlines()]


def add_token(data, name, *options):
    """A new token of a data folder: the secret."""
    return run("token", "add", name, "--data", data, *catalogue_words(data), *options).stdout.strip()


def bearer(token):
    return {"Authorization": f"Bearer {token}"}


def form(fields=(), files=(), part="file", type_of_part=""):
    """The body of a form (FORM) with these fields, and of (name, bytes) pairs each as a file in a part of this name."""
    head = f'--{BOUNDARY}\r\nContent-Disposition: form-data; name='
    parts = [f'{head}"{name}"\r\n\r\n{value}\r\n'.encode() for name, value in dict(fields).items()]
    typed = f"\r\nContent-Type: {type_of_part}" if type_of_part else ""
    parts += [f'{head}"{part}"; filename="{name}"{typed}\r\n\r\n'.encode() + content + b"\r\n" for name, content in files]
    return b"".join(parts) + f"--{BOUNDARY}--\r\n".encode()


def tus_metadata(flight, name="a.jpg"):
    """The header that says what a resumable upload is of."""
    words = (f"{key} {base64.b64encode(value.encode()).decode()}" for key, value in (("flight", flight), ("filename", name)))
    return {"Upload-Metadata": ",".join(words)}


class Server:
    """`skyquilt serve` over one data folder."""

    def __init__(self, data, *arguments, listen="127.0.0.1:0"):
        self.data = pathlib.Path(data)
        self.log = tempfile.NamedTemporaryFile("w+", suffix=".log")
        self.process = subprocess.Popen(
            [BINARY, "serve", "--data", str(data), "--listen", listen, *storage_words(data), *arguments],
            stdout=subprocess.PIPE, stderr=self.log, text=True)
        line = self.process.stdout.readline()
        found = re.search(r"http://[\d.]+:(\d+)/", line)
        if not found:
            raise AssertionError(f"the server did not start: {line!r} {self.errors()}")
        self.port = int(found.group(1))

    def errors(self):
        self.log.seek(0)
        return self.log.read()

    def request(self, method, path, body=None, headers=None, code=None):
        """(status, headers, bytes) of one request, held against the contract; its status is this code, where one is given."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=PATIENCE_S)
        try:
            connection.request(method, path, body=body, headers=headers or {})
            response = connection.getresponse()
            answer = response.status, response.headers, response.read()
        finally:
            connection.close()
        contract.check(method, path, *answer)
        assert code in (None, answer[0]), (method, path, answer[0], answer[2][:1000])
        return answer

    def json(self, method, path, value=None, headers=None, code=None):
        body = None if value is None else json.dumps(value)
        status, _, answer = self.request(method, path, body, {**({} if value is None else AS_JSON), **(headers or {})}, code)
        return status, json.loads(answer) if answer else None

    def new_flight(self, photos=(), headers=None):
        """The id of a new flight that has these photos, as (name, bytes) pairs, and no job."""
        _, flight = self.json("POST", "/api/v1/flights", {}, headers, 201)
        self.put(flight["id"], photos, headers)
        return flight["id"]

    def put(self, flight, photos, headers=None):
        for name, content in photos:
            self.request("PUT", f"/api/v1/flights/{flight}/files/{name}", content, headers, 201)

    def upload(self, files, code=None, **fields):
        """POST /api/v1/flights with (name, bytes) pairs: (status, answer)."""
        status, _, answer = self.request("POST", "/api/v1/flights", form(fields, files), FORM, code)
        return status, json.loads(answer)

    def begun(self, files, **fields):
        """The ids of the flight that these files make, and of its job."""
        _, made = self.upload(files, 202, **fields)
        return made["flight"]["id"], made["job"]["id"]

    def stitched(self, files, **fields):
        """What the upload answers, once its job, in it as it ended, has made a map."""
        _, made = self.upload(files, 202, **fields)
        made["job"] = self.ended(made["job"]["id"])
        return made

    def remade(self, flight, options=None, state="successful"):
        """The job that makes a flight's map with these options, once it has ended so."""
        _, job = self.json("POST", f"/api/v1/flights/{flight}/jobs", {"options": options} if options else {}, code=202)
        return self.ended(job["id"], state)

    def ended(self, job_id, state="successful"):
        """The job, once it has ended so."""
        job = self.wait_for_job(job_id)
        assert job["state"] == state, (job, self.errors())
        return job

    def wait_for_job(self, job_id, until=lambda job: job["finished_at"] is not None):
        end = time.monotonic() + PATIENCE_S
        while time.monotonic() < end:
            _, job = self.json("GET", f"/api/v1/jobs/{job_id}", code=200)
            if until(job):
                return job
            time.sleep(0.1)
        raise AssertionError(f"the job did not get there: {job} {self.errors()}")

    def workers(self):
        """Process ids of the server's children."""
        path = f"/proc/{self.process.pid}/task/{self.process.pid}/children"
        return [int(pid) for pid in pathlib.Path(path).read_text().split()]

    def garbage(self):
        return sorted(str(path) for folder in ("incoming", "work") for path in (self.data / folder).iterdir())

    def kill(self):
        """What a power cut would do to the server; its workers follow by themselves."""
        children = self.workers()
        self.process.send_signal(signal.SIGKILL)
        self.process.wait()
        for pid in children:
            wait_until(lambda: not is_running(pid), "a worker outlived its server")
        self.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.stop()

    def stop(self):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM)
        code = self.process.wait(timeout=PATIENCE_S)
        self.close()
        return code

    def close(self):
        self.process.stdout.close()
        said = self.errors()  # also what its workers and their sandboxed processes said, whose end a test may not notice
        assert "Sanitizer:" not in said and ": runtime error: " not in said, said


def is_running(pid):
    try:
        return pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] not in "ZX"
    except FileNotFoundError:
        return False


def children_of(pid):
    """Process ids of a process's children, whichever of its threads made them."""
    children = []
    for task in pathlib.Path(f"/proc/{pid}/task").glob("*"):
        with contextlib.suppress(FileNotFoundError):
            children += [int(child) for child in (task / "children").read_text().split()]
    return children


def children_called(pid, word):
    """Those of them that have a word in their command line."""
    found = []
    for child in children_of(pid):
        with contextlib.suppress(FileNotFoundError):
            if word.encode() in pathlib.Path(f"/proc/{child}/cmdline").read_bytes():
                found.append(child)
    return found


def confined_of(server, kind):
    """Process ids of the processes that a server's workers have started to decode what others made."""
    return [pid for worker in server.workers() for pid in children_called(worker, kind)]


def kill_if_there(pid):
    with contextlib.suppress(ProcessLookupError):
        os.kill(pid, signal.SIGKILL)


def fill_disk(path):
    """Takes all that is left of a disk, to the last byte."""
    with open(path, "ab", buffering=0) as file:
        for size in (1 << 20, 4096, 512, 1):
            with contextlib.suppress(OSError):
                while True:
                    file.write(b"\0" * size)


def side_by_side(calls):
    """What calls answer that are made at the same time, each in a thread of its own."""
    with concurrent.futures.ThreadPoolExecutor(len(calls)) as threads:
        return list(threads.map(lambda call: call(), calls))


def open_files_of(pid):
    """What the descriptors of a process point to; those that it closes meanwhile are left out."""
    targets = []
    for entry in pathlib.Path(f"/proc/{pid}/fd").iterdir():
        with contextlib.suppress(FileNotFoundError):
            targets.append(os.readlink(entry))
    return targets


def limits_of(pid):
    """The soft limits of a process by the kernel's names for them."""
    lines = pathlib.Path(f"/proc/{pid}/limits").read_text().splitlines()[1:]
    return {line[:25].strip(): line[26:46].strip() for line in lines}


def wait_until(condition, complaint):
    """What the condition answers once it is neither false nor empty."""
    end = time.monotonic() + PATIENCE_S
    while not (answer := condition()):
        if time.monotonic() > end:
            raise AssertionError(complaint() if callable(complaint) else complaint)
        time.sleep(0.05)
    return answer


def photos_in(folder):
    """(name, bytes) of the photos in a folder, by their names."""
    return [(path.name, path.read_bytes()) for path in sorted(pathlib.Path(folder).iterdir()) if path.suffix.lower() in (".jpg", ".tif")]


def stitch_simulated(folder):
    """(a server with the data folder `folder`/data, the one flight in it, simulated there and stitched)."""
    run("simulate", "-o", folder / "sim", "--photos", "8", "--size", "1600x1200", "--no-world")
    server = Server(folder / "data", "--workers", "1")
    return server, server.stitched(photos_in(folder / "sim/photos"))["flight"]["id"]


def small_photos():
    """(name, bytes) of the flight that nearly every test uploads."""
    return photos_in(made_flights.small_flight() / "photos")


def make_map(data, photos, **fields):
    """Has a server of its own make a flight and its map in a data folder; the flight's id."""
    with Server(data, "--workers", "1") as server:
        return server.stitched(photos, **fields)["flight"]["id"]


def put_map(data):
    """The small flight and its map in an empty data folder, for tests of what is done with a map; the flight's id."""
    if POSTGRES is not None or BLOBS is not None:
        return make_map(data, small_photos())

    def make(folder):
        (folder / "id").write_text(make_map(folder / "data", small_photos()))
    made = made_flights.made("data", make)
    shutil.copytree(made / "data", data, dirs_exist_ok=True)
    return (made / "id").read_text()


class ServerTestCase(ScratchCase):
    """A fresh data folder per test, and the photos of one small flight."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.scratch = str(cls.scratch)  # for libraries that want text
        cls.photos = small_photos()

    def setUp(self):
        self.data = tempfile.mkdtemp(prefix="data_", dir=self.scratch)
        self.servers = []

    def tearDown(self):
        for server in self.servers:
            if server.process.poll() is None:
                server.stop()

    def wait_for_preview(self, server, flight_id, photos):
        def has_come():
            preview = server.json("GET", f"/api/v1/flights/{flight_id}")[1]["preview"]
            return preview is not None and preview["photos"] == photos
        wait_until(has_come, f"no preview of {photos} photos: {server.errors()}")
        return server.json("GET", f"/api/v1/flights/{flight_id}")[1]["preview"]

    def refusal(self, *arguments):
        """What `skyquilt serve` says when it does not start."""
        refused = run("serve", "--data", self.data, *storage_words(self.data), *arguments, code=None, timeout=60)
        self.assertNotEqual(refused.returncode, 0)
        return refused.stderr

    def token(self, name, *options):
        """The header of a new token for the test's data folder."""
        return bearer(add_token(self.data, name, *options))

    def serve(self, *arguments, data=None, **where):
        """A server over the test's data folder, or another; it ends with the test."""
        server = Server(data or self.data, *arguments, **where)
        self.servers.append(server)
        return server


def tile_of(lon, lat, zoom):
    side = 1 << zoom
    x = int((lon + 180) / 360 * side)
    y = int((1 - math.asinh(math.tan(math.radians(lat))) / math.pi) / 2 * side)
    return x, y


def middle_of(bounds, zoom):
    """The tile in the middle of a map: its column and row."""
    west, south, east, north = bounds
    return tile_of((west + east) / 2, (south + north) / 2, zoom)


def middle_tile(tilejson, zoom="maxzoom"):
    """The address of the finest tile in the middle of a map; with "minzoom" of the coarsest."""
    x, y = middle_of(tilejson["bounds"], tilejson[zoom])
    return path_of(tilejson["tiles"][0].format(z=tilejson[zoom], x=x, y=y))


def path_of(url):
    parts = urllib.parse.urlsplit(url)
    return parts.path + ("?" + parts.query if parts.query else "")
