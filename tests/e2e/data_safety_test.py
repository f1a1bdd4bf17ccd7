"""Nothing that happens to the data folder loses a photo or a map: folders of others, a catalogue that is gone, emptied,
damaged or older, a lock file that is removed, a folder that is moved away or replaced while the server runs."""
import os
import pathlib
import shutil
import sqlite3
import subprocess
import tempfile
import unittest

from program import BINARY, run
from server_support import POSTGRES, Server, ServerTestCase, middle_of, path_of, storage_words, wait_until


def contents(folder):
    """Every file below a folder: {path: bytes}."""
    folder = pathlib.Path(folder)
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def digests(folder):
    """The bytes of photos and maps, wherever they lie: a set that must never lose a member."""
    return {path.read_bytes() for path in pathlib.Path(folder).rglob("*")
            if path.is_file() and (path.parent.name == "files" or path.name == "mosaic.mbtiles")}


class DataSafety(ServerTestCase):
    def setUp(self):
        super().setUp()
        self.data = os.path.join(self.data, "d")  # made by the server

    def data_command(self, name, *arguments, code=0):
        done = run("data", name, "--data", self.data, *arguments, code=None, timeout=120)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done.stdout + done.stderr

    def make_map(self, server, name="field"):
        return server.stitched(self.photos, name=name)["flight"]["id"]

    def view(self, server, flight_id):
        """All that a client sees of a flight: its name, its files with their bytes, and the tiles of its map."""
        _, flight = server.json("GET", f"/api/v1/flights/{flight_id}")
        _, listed = server.json("GET", f"/api/v1/flights/{flight_id}/files")
        files = {}
        for file in listed["files"]:
            files[file["name"]] = server.request("GET", f"/api/v1/flights/{flight_id}/files/{file['name']}", code=200)[2]
        tiles = {}
        if flight["state"] == "ready":
            _, tilejson = server.json("GET", path_of(flight["tilejson"]))
            for zoom in range(tilejson["minzoom"], tilejson["maxzoom"] + 1):
                x, y = middle_of(tilejson["bounds"], zoom)
                address = tilejson["tiles"][0].format(z=zoom, x=x, y=y)
                status, _, body = server.request("GET", path_of(address))
                tiles[zoom] = (status, body)
            self.assertEqual({status for status, _ in tiles.values()} & {200}, {200})
        facts = {key: flight.get(key) for key in ("name", "state", "revision", "created_at")}
        # A map's report has its figures with fewer digits than the catalogue that was lost.
        facts["bounds"] = [round(bound, 9) for bound in flight.get("bounds") or []]
        return facts, files, tiles

    def test_a_folder_of_others_is_refused_and_stays_as_it_is(self):
        for made in ("flights/2024/DJI_0001.JPG", "work/thesis.odt", "incoming/letter", "holiday.jpg"):
            folder = pathlib.Path(tempfile.mkdtemp(dir=self.scratch))
            path = folder / made
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(b"mine")
            self.data = str(folder)
            self.assertIn("is not a data folder of Skyquilt", self.refusal("--listen", "127.0.0.1:0"))
            self.assertEqual(contents(folder), {made: b"mine"})
            self.assertIn("is not a data folder", self.data_command("repair", code=1))
            self.assertIn("is not a data folder", self.data_command("check", code=1))
            self.assertEqual(contents(folder), {made: b"mine"})

    def test_what_is_no_folder_is_refused(self):
        path = pathlib.Path(self.data)
        path.write_bytes(b"mine")
        self.assertIn("is not a folder", self.refusal("--listen", "127.0.0.1:0"))
        path.unlink()
        path.symlink_to("nowhere")
        self.assertIn("is a link", self.refusal("--listen", "127.0.0.1:0"))

    def test_the_folder_is_its_owners_alone(self):
        server = self.serve("--workers", "0")
        self.assertEqual(os.stat(self.data).st_mode & 0o777, 0o700)
        for name in ("catalogue.db", "catalogue.db-wal", "catalogue.db-shm"):
            self.assertEqual(os.stat(f"{self.data}/{name}").st_mode & 0o777, 0o600, name)
        self.assertEqual(server.stop(), 0)

    def test_a_lost_catalogue_is_never_made_anew_in_silence_and_repair_brings_all_back(self):
        server = self.serve()
        mapped = self.make_map(server)
        _, plain = server.json("POST", "/api/v1/flights", {"name": "plain"}, code=201)
        server.request("PUT", f"/api/v1/flights/{plain['id']}/files/høyde 1.jpg".replace("ø", "%C3%B8").replace(" ", "%20"),
                       self.photos[0][1])
        server.json("PATCH", f"/api/v1/flights/{plain['id']}", {"name": "renamed"})
        before = {flight: self.view(server, flight) for flight in (mapped,)}
        _, listed = server.json("GET", f"/api/v1/flights/{plain['id']}/files")
        self.assertEqual(server.stop(), 0)
        bytes_before = digests(self.data)
        catalogue = pathlib.Path(self.data, "catalogue.db")
        whole = catalogue.read_bytes()

        def new_catalogue():
            other = pathlib.Path(tempfile.mkdtemp(dir=self.scratch), "other")
            Server(other, "--workers", "0").stop()
            shutil.copy(other / "catalogue.db", catalogue)

        for lose in (catalogue.unlink, lambda: catalogue.write_bytes(b""), lambda: catalogue.write_bytes(os.urandom(60000)),
                     lambda: catalogue.write_bytes(whole[:8192] + os.urandom(len(whole) - 8192)), new_catalogue):
            lose()
            left = catalogue.read_bytes() if catalogue.exists() else None
            said = self.refusal("--listen", "127.0.0.1:0")
            self.assertIn(f"skyquilt data repair --data {self.data}", said)
            self.assertNotIn("remove it", said)
            self.assertEqual(catalogue.read_bytes() if catalogue.exists() else None, left)
            self.assertEqual(digests(self.data), bytes_before)
            self.data_command("check", code=2)
            self.assertIn("2 flights, 7 files and 1 map were entered into a new catalogue", self.data_command("repair"))
            again = self.serve()
            self.assertEqual(self.view(again, mapped), before[mapped])
            self.assertEqual(again.json("GET", f"/api/v1/flights/{plain['id']}")[1]["name"], "renamed")
            self.assertEqual(again.json("GET", f"/api/v1/flights/{plain['id']}/files")[1], listed)
            self.assertEqual(again.stop(), 0)
            self.assertLessEqual(bytes_before, digests(self.data))

    def test_an_older_catalogue_loses_no_newer_flight(self):
        server = self.serve()
        first = self.make_map(server)
        self.assertEqual(server.stop(), 0)
        backup = pathlib.Path(self.data, "catalogue.db").read_bytes()
        server = self.serve()
        second = self.make_map(server, "newer")
        server.remade(first)
        before = {flight: self.view(server, flight) for flight in (first, second)}
        self.assertEqual(server.stop(), 0)
        bytes_before = digests(self.data)
        pathlib.Path(self.data, "catalogue.db").write_bytes(backup)
        self.assertIn("is older than what is on disk", self.refusal("--listen", "127.0.0.1:0"))
        self.assertEqual(digests(self.data), bytes_before)
        self.assertIn("into the catalogue", self.data_command("repair"))
        server = self.serve()
        for flight in (first, second):
            self.assertEqual(self.view(server, flight), before[flight])
        self.assertEqual(server.stop(), 0)
        self.assertLessEqual(bytes_before, digests(self.data))

    def test_what_belongs_nowhere_goes_to_lost_with_a_line_each_and_only_the_operator_removes_it(self):
        self.assertEqual(self.serve("--workers", "0").stop(), 0)
        strange = {"flights/2024/DJI_0001.JPG": b"photo", "work/notes": b"n", "incoming/mail": b"m", "uploads/x": b"u"}
        for name, content in strange.items():
            path = pathlib.Path(self.data, name)
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
        server = self.serve("--workers", "0")
        log = server.errors()
        self.assertEqual(server.stop(), 0)
        [lost] = pathlib.Path(self.data, "lost").iterdir()
        self.assertEqual(contents(lost), strange)
        self.assertEqual(log.count("moved to lost/"), len(strange), log)
        self.assertNotIn("leftovers", log)
        self.assertIn("lost/", self.data_command("check", code=2))
        self.assertIn("Say it again with --yes", self.data_command("purge-lost", code=2))
        self.assertEqual(contents(lost), strange)
        self.data_command("purge-lost", "--yes")
        self.assertFalse(lost.exists())
        self.assertIn("all is well", self.data_command("check"))

    def test_a_folder_of_an_earlier_version_is_adopted(self):
        server = self.serve()
        flight = self.make_map(server)
        before = self.view(server, flight)
        self.assertEqual(server.stop(), 0)
        pathlib.Path(self.data, "skyquilt-data.json").unlink()
        pathlib.Path(self.data, "flights", flight, "flight.jsonl").unlink()
        catalogue = sqlite3.connect(f"{self.data}/catalogue.db", isolation_level=None)
        catalogue.execute("DELETE FROM data_dir")
        catalogue.close()
        server = self.serve()
        self.assertEqual(self.view(server, flight), before)
        self.assertIn("got one", server.errors())
        self.assertEqual(server.stop(), 0)
        pathlib.Path(self.data, "catalogue.db").unlink()
        self.data_command("repair")
        self.assertEqual(self.view(self.serve(), flight), before)

    def test_a_removed_lock_file_lets_no_second_server_in(self):
        server = self.serve("--workers", "0")
        for name in ("server.lock", "skyquilt-data.json"):
            pathlib.Path(self.data, name).unlink(missing_ok=True)
        self.assertIn("Another server", self.refusal("--listen", "127.0.0.1:0"))
        self.assertIn("Another server", self.data_command("repair", code=1))
        self.assertEqual(server.stop(), 0)

    def test_a_folder_that_is_moved_away_takes_nothing_until_it_is_back(self):
        server = self.serve()
        address = f"/api/v1/flights/{server.new_flight()}"
        away = self.data + ".away"
        os.rename(self.data, away)
        for replaced in (False, True):
            if replaced:
                shutil.copytree(away, self.data)
            self.assertEqual(server.request("GET", "/readyz")[0], 503)
            self.assertEqual(server.request("GET", "/healthz")[0], 200)
            for method, path, body in (("PUT", f"{address}/files/a.jpg", b"x"), ("DELETE", address, None)):
                self.assertIn(b"data folder", server.request(method, path, body, code=503)[2])
            server.json("POST", "/api/v1/flights", {}, code=503)
            server.upload([("a.jpg", b"x")], code=503)
            wait_until(lambda: server.workers() == [], "workers go on in a folder that is gone")
        shutil.rmtree(self.data)
        os.rename(away, self.data)
        self.assertEqual(server.request("GET", "/readyz")[0], 200)
        self.make_map(server)
        self.assertEqual(server.stop(), 0)
        self.assertIn("all is well", self.data_command("check"))

    @unittest.skipUnless(POSTGRES is None, "the catalogue lies elsewhere")
    def test_a_worker_waits_for_its_folder_and_says_so(self):
        server = self.serve("--workers", "0")
        words = [BINARY, "worker", "--data", self.data, *storage_words(self.data)]
        with tempfile.NamedTemporaryFile() as log:
            worker = subprocess.Popen(words, stdout=log, stderr=log)
            try:
                def says(text):
                    return text in pathlib.Path(log.name).read_text()
                self.make_map(server)  # by it: it is at work
                os.rename(self.data, self.data + ".away")
                wait_until(lambda: says("the worker waits: "), "a worker in a folder that is gone says nothing")
                os.rename(self.data + ".away", self.data)
                wait_until(lambda: says("the worker goes on"), "the worker does not see that its folder is back")
                self.make_map(server)
            finally:
                worker.terminate()
                self.assertEqual(worker.wait(timeout=60), 0)
