"""Photos and maps in S3: a flight from its upload to its deletion, what the data folder keeps of it, and a store that fails,
stalls, is away or is another's. The store is s3rver from npm, behind a proxy that reckons every signature itself."""
import http.server
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import tempfile
import threading
import time

import s3_store
from cluster.s3_support import KEPT_BY_THE_FOLDER, S3TestCase
from program import BINARY, run
from server_support import confined_of, middle_of, wait_until


class Flow(S3TestCase):
    def test_a_flight_is_the_same_as_in_a_folder_and_lies_elsewhere(self):
        server = self.serve_s3("--trash-days", "0")
        flight_id = self.make_map(server, name="field", options='{"layers": ["photo"]}')
        base = f"/api/v1/flights/{flight_id}"
        names = {key.split("/", 2)[2] for key in self.keys("flights/")}
        self.assertEqual(len([name for name in names if name.startswith("files/")]), 6)
        for name in ("mosaic.pmtiles", "mosaic.mbtiles", "mosaic.state", "report.json", "layer_photo.mbtiles"):
            self.assertIn(f"r1/{name}", names)
        self.assertEqual(self.left_behind(server), [])
        here = self.serve("--trash-days", "0", data=tempfile.mkdtemp(dir=self.scratch))
        made = here.stitched(self.photos, name="field", options='{"layers": ["photo"]}')
        there_tiles, here_tiles = self.tiles_of(server, flight_id), self.tiles_of(here, made["flight"]["id"])
        self.assertGreater(len(here_tiles), 5)
        self.assertEqual(there_tiles, here_tiles)
        for name in ("download.mbtiles", "download.tif", "download.pmtiles", "thumbnail.png", "cameras.json", "geo.txt",
                     "layer_photo.mbtiles", "photos.geojson"):
            _, _, there_bytes = server.request("GET", f"{base}/{name}")
            self.assertEqual(there_bytes, here.request("GET", f"/api/v1/flights/{made['flight']['id']}/{name}")[2], name)
        self.check_downloads(server, flight_id)
        self.assertEqual(server.request("DELETE", base)[0], 204)
        self.assertEqual(self.keys("flights/"), [])
        self.assertEqual(len(self.keys("deleted/")), 1)  # for a day, for what comes late
        self.assertEqual(server.garbage(), [])
        self.assertEqual(server.stop(), 0)

    def check_downloads(self, server, flight_id):
        base = f"/api/v1/flights/{flight_id}"
        name, content = self.photos[0]
        status, headers, body = server.request("GET", f"{base}/files/{name}")
        self.assertEqual((status, body), (200, content))
        status, part_headers, body = server.request("GET", f"{base}/files/{name}", headers={"Range": "bytes=100-199"})
        self.assertEqual((status, body), (206, content[100:200]))
        self.assertEqual(part_headers["Content-Range"], f"bytes 100-199/{len(content)}")
        self.assertEqual(server.request("GET", f"{base}/files/{name}", headers={"If-None-Match": headers["ETag"]})[0], 304)
        self.assertEqual(server.request("GET", f"{base}/files/other.jpg")[0], 404)
        self.assertEqual(server.request("GET", f"{base}/download.zip", code=200)[2][:4], b"PK\x03\x04")
        _, stac = server.json("GET", f"/stac/{flight_id}", code=200)
        self.assertIn("pmtiles", stac["assets"])
        west, south, east, north = stac["bbox"]
        _, at = server.json("GET", f"{base}/at?lon={(west + east) / 2}&lat={(south + north) / 2}", code=200)
        self.assertGreater(len(at["photos"]), 0)
        server.json("GET", f"{base}/verdict", code=200)

    def test_a_photo_more_goes_on_from_the_map_that_is_there(self):
        server = self.serve_s3("--trash-days", "0")
        last, self.photos = self.photos[-1], self.photos[:-1]
        try:
            flight_id = self.make_map(server)
        finally:
            self.photos.append(last)
        shutil.rmtree(pathlib.Path(self.data, "cache"))  # as another machine would have it
        server.request("PUT", f"/api/v1/flights/{flight_id}/files/{last[0]}", last[1], code=201)
        server.remade(flight_id)
        _, report = server.json("GET", f"/api/v1/flights/{flight_id}/report")
        self.assertEqual(report["photos"]["total"], 6)
        self.assertIn("placed against the finished flight", json.dumps(report["warnings"]))
        server.remade(flight_id)
        # The first is retired a moment later, the second still read by some.
        wait_until(lambda: self.folders() == {"files", "r2", "r3"}, self.folders())
        run("data", "check", "--data", self.data, code=1)
        self.assertEqual(server.stop(), 0)
        run("data", "check", "--data", self.data)
        gone = next(key for key in self.keys("flights/") if "/files/" in key)
        for path in (self.store.folder / "data").rglob(f"{gone.rsplit('/', 1)[1]}._S3rver*"):
            path.unlink()
        self.assertIn(gone, run("data", "check", "--data", self.data, code=2).stdout)

    def test_a_cold_tile_takes_two_reads_and_a_hot_one_none(self):
        server = self.serve_s3()
        flight_id = self.make_map(server)
        self.assertEqual(server.stop(), 0)
        shutil.rmtree(pathlib.Path(self.data, "cache"))
        server = self.serve_s3()
        _, tilejson = server.json("GET", f"/tiles/{flight_id}.json")  # opens the map
        zoom = tilejson["maxzoom"]
        x, y = middle_of(tilejson["bounds"], zoom)
        opened = self.proxy.reads_of("mosaic.pmtiles")
        self.assertLessEqual(opened, 1)
        self.assertEqual(server.request("GET", f"/tiles/{flight_id}/{zoom}/{x}/{y}")[0], 200)
        cold = self.proxy.reads_of("mosaic.pmtiles") - opened
        self.assertLessEqual(cold, 2)
        before = self.proxy.reads_of("mosaic")
        for _ in range(20):
            self.assertEqual(server.request("GET", f"/tiles/{flight_id}/{zoom}/{x}/{y}")[0], 200)
        self.assertEqual(self.proxy.reads_of("mosaic"), before)
        self.tiles_of(server, flight_id)
        size = next(path for path in (self.store.folder / "data").rglob("mosaic.pmtiles._S3rver_object")
                    if self.prefix in str(path)).stat().st_size
        self.assertLessEqual(self.proxy.reads_of("mosaic.pmtiles"), size // (256 << 10) + 2)
        self.assertEqual(self.proxy.reads_of("mosaic.mbtiles"), 0)


class Places(S3TestCase):
    def test_neither_a_forgotten_option_nor_anothers_place_is_taken(self):
        server = self.serve_s3("--workers", "0")
        self.assertEqual(server.upload(self.photos[:1])[0], 202)
        self.assertEqual(server.stop(), 0)
        self.assertIn(f"--blobs {self.address()}", self.refusal("--listen", "127.0.0.1:0"))
        self.assertIn("not at", self.refusal("--listen", "127.0.0.1:0", "--blobs", self.store.address("elsewhere")))
        other, self.data = self.data, tempfile.mkdtemp(dir=self.scratch)
        self.assertIn("another catalogue", self.refusal("--listen", "127.0.0.1:0", "--blobs", self.address()))
        server = self.serve("--workers", "0")
        self.assertEqual(server.upload(self.photos[:1])[0], 202)
        self.assertEqual(server.stop(), 0)
        self.assertIn("skyquilt data move", self.refusal("--listen", "127.0.0.1:0", "--blobs", self.store.address("fresh")))
        self.data = other
        self.serve_s3("--workers", "0")

    def test_a_map_that_was_replaced_in_the_store_is_not_shown(self):
        server = self.serve_s3()
        mine = self.make_map(server)
        tiles = self.tiles_of(server, mine)
        made = server.stitched(self.photos[:5])
        flights = self.store.bucket / self.prefix / "flights"

        def swap():
            """As somebody would who has the keys of the store and nothing else; a node that has seen neither."""
            self.assertEqual(server.stop(), 0)
            one, two, aside = flights / mine / "r1", flights / made["flight"]["id"] / "r1", flights / "aside"
            for old, new in ((one, aside), (two, one), (aside, two)):
                old.rename(new)
            shutil.rmtree(pathlib.Path(self.data, "cache"))
            return self.serve_s3()

        server = swap()
        for tile in tiles:
            self.assertEqual(server.request("GET", f"/tiles/{mine}/{tile}")[0], 503)
        self.assertEqual(server.request("GET", f"/api/v1/flights/{mine}/photos.geojson")[0], 503)
        self.assertEqual(server.stop(), 0)
        check = [BINARY, "data", "check", "--data", self.data]
        self.assertEqual(subprocess.run(check, capture_output=True).returncode, 0)
        deep = subprocess.run([*check, "--deep"], capture_output=True, text=True)
        self.assertEqual(deep.returncode, 2, deep.stdout + deep.stderr)
        self.assertIn(f"flights/{mine}/r1/mosaic.pmtiles", deep.stdout)
        server = self.serve_s3()
        self.assertEqual(self.tiles_of(swap(), mine), tiles)

    def test_a_folder_moves_out_and_back(self):
        server = self.serve("--trash-days", "0")
        flight_id = self.make_map(server)
        tiles = self.tiles_of(server, flight_id)
        self.assertEqual(server.stop(), 0)
        before = {path: pathlib.Path(self.data, path).read_bytes() for path in self.kept() if path.startswith("flights/")}

        def move(*arguments):
            return run("data", "move", "--data", self.data, *arguments).stdout

        self.assertIn("The originals are still there", move("--to", self.address()))
        self.assertIn(f"{len(before) - 1} originals were removed", move("--to", self.address(), "--remove-source"))
        self.assertEqual([path for path in self.kept() if not KEPT_BY_THE_FOLDER.fullmatch(path)], [])
        server = self.serve_s3()
        self.assertEqual(self.tiles_of(server, flight_id), tiles)
        self.assertEqual(server.stop(), 0)
        move("--from", self.address(), "--remove-source")
        self.assertEqual(self.keys(), [])
        after = {path: pathlib.Path(self.data, path).read_bytes() for path in self.kept() if path.startswith("flights/")}
        self.assertEqual(after, before)
        self.assertEqual(self.tiles_of(self.serve(), flight_id), tiles)
        self.assertIn("--to s3://bucket/prefix", run("data", "move", "--data", self.data, code=None).stderr)

    def test_what_is_no_store_is_told_with_what_to_do(self):
        class NoStore(http.server.BaseHTTPRequestHandler):
            def answer(self):
                self.rfile.read(int(self.headers.get("Content-Length") or 0))
                self.send_error(404)

            do_GET = do_HEAD = do_PUT = do_DELETE = answer
            log_message = staticmethod(lambda *_: None)

        with http.server.ThreadingHTTPServer(("127.0.0.1", 0), NoStore) as web:
            threading.Thread(target=web.serve_forever, daemon=True).start()
            os.environ["AWS_ENDPOINT_URL"] = f"http://127.0.0.1:{web.server_port}"
            said = self.refusal("--listen", "127.0.0.1:0", "--blobs", self.address())
            web.shutdown()
        self.assertIn("is no S3 store", said)
        self.assertIn("AWS_ENDPOINT_URL", said)

    def test_an_older_catalogue_does_not_take_newer_photos_for_lost(self):
        server = self.serve_s3("--workers", "0")
        flight = server.new_flight()
        self.assertEqual(server.stop(), 0)
        backup = pathlib.Path(self.data, "catalogue.db").read_bytes()
        server = self.serve_s3("--workers", "0")
        server.put(flight, self.photos[:3])
        self.assertEqual(server.stop(), 0)
        for path in pathlib.Path(self.data).glob("catalogue.db-[ws]*"):
            path.unlink()
        pathlib.Path(self.data, "catalogue.db").write_bytes(backup)
        self.assertIn("older than what is on disk", self.refusal("--listen", "127.0.0.1:0", "--blobs", self.address()))
        self.assertEqual(len(self.keys("flights/")), 3)
        self.assertIn(f"below {self.address()}/flights/", run("data", "repair", "--data", self.data, code=1).stderr)
        # As the sentence says.
        for key in self.keys("flights/"):
            path = pathlib.Path(self.data, key)
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes((self.store.folder / "data" / s3_store.BUCKET / self.prefix / f"{key}._S3rver_object").read_bytes())
        pathlib.Path(self.data, "blobs.json").unlink()
        run("data", "repair", "--data", self.data)
        server = self.serve("--workers", "0")
        for name, content in self.photos[:3]:
            self.assertEqual(server.request("GET", f"/api/v1/flights/{flight}/files/{name}")[2], content)

    def test_a_store_that_cannot_be_used_is_named_before_anything_is_served(self):
        listen = ("--listen", "127.0.0.1:0", "--blobs")
        self.assertIn("no bucket \"missing-bucket\"", self.refusal(*listen, "s3://missing-bucket/x"))
        self.assertIn("s3://bucket/prefix", self.refusal(*listen, "bucket/prefix"))
        os.environ["AWS_SECRET_ACCESS_KEY"] = "a wrong secret"
        said = self.refusal(*listen, self.address())
        self.assertIn("refuses this server (SignatureDoesNotMatch)", said)
        self.assertNotIn("a wrong secret", said)
        self.proxy.forged.clear()
        del os.environ["AWS_SECRET_ACCESS_KEY"]
        os.environ["HOME"] = self.scratch
        self.assertIn("AWS_ACCESS_KEY_ID", self.refusal(*listen, self.address()))
        os.environ.update(self.store.environment("http://127.0.0.1:9"))
        self.assertIn("cannot be reached", self.refusal(*listen, self.address()))
        self.assertEqual(list(pathlib.Path(self.data).glob("flights/*")), [])


class Faults(S3TestCase):
    def test_a_worker_that_starts_before_the_store_waits_for_it(self):
        server = self.serve_s3("--workers", "0")
        _, job_id = server.begun(self.photos)
        self.proxy.is_cut.set()
        worker = subprocess.Popen([BINARY, "worker", "--once", "--data", self.data, "--blobs", self.address()])
        time.sleep(8)
        self.assertIsNone(worker.poll())
        self.proxy.is_cut.clear()
        self.assertEqual(worker.wait(timeout=240), 0)
        server.ended(job_id)

    def test_a_wrong_answer_is_neither_shown_nor_kept(self):
        server = self.serve_s3()
        flight_id = self.make_map(server)
        sound = self.tiles_of(server, flight_id)
        harms = [lambda content: content[:len(content) // 3],
                 lambda content: content[:len(content) // 2] + bytes([content[len(content) // 2] ^ 1]) + content[len(content) // 2 + 1:]]
        for harm in harms:
            self.assertEqual(server.stop(), 0)
            shutil.rmtree(pathlib.Path(self.data, "cache"))
            left = [6]

            def some(path, content):
                if "mosaic.pmtiles" not in path or left[0] == 0 or left[0] % 4 == 0 or not content:
                    left[0] = max(0, left[0] - 1)
                    return content
                left[0] -= 1
                return harm(content)
            self.proxy.harm = some
            server = self.serve_s3()
            self.assertEqual(self.tiles_of(server, flight_id), sound)
            self.assertEqual(left, [0], "the proxy was too kind for this test")
        # A store that is never right: 503, and all is well once it is.
        self.assertEqual(server.stop(), 0)
        shutil.rmtree(pathlib.Path(self.data, "cache"))
        self.proxy.harm = lambda path, content: harms[1](content) if "mosaic.pmtiles" in path else content
        server = self.serve_s3()
        self.assertEqual(server.request("GET", f"/tiles/{flight_id}.json")[0], 503)
        self.proxy.harm = None
        self.assertEqual(self.tiles_of(server, flight_id), sound)

    def test_a_store_that_fails_and_stalls_changes_no_byte(self):
        server = self.serve_s3()
        sound = self.tiles_of(server, self.make_map(server))
        self.assertEqual(server.stop(), 0)
        self.proxy.fails, self.proxy.stalls = 0.05, 0.01
        faults = 0
        for _ in range(3):
            self.data = tempfile.mkdtemp(prefix="data_", dir=self.scratch)
            self.prefix = os.path.basename(self.data)
            server = self.serve_s3("--trash-days", "0")
            flight_id = self.make_map(server)
            self.assertEqual(self.tiles_of(server, flight_id), sound)
            name, content = self.photos[2]
            self.assertEqual(server.request("GET", f"/api/v1/flights/{flight_id}/files/{name}")[2], content)
            self.assertEqual(self.folders(), {"files", "r1"})
            self.assertEqual(server.request("DELETE", f"/api/v1/flights/{flight_id}")[0], 204)
            self.assertEqual(self.keys("flights/"), [])
            self.assertEqual(server.stop(), 0)
            faults = self.proxy.faults
        self.assertGreater(faults, 3, "the proxy was too kind for this test")

    def test_a_store_that_is_away_is_said_so_and_comes_back(self):
        server = self.serve_s3()
        flight_id = self.make_map(server)
        _, tilejson = server.json("GET", f"/tiles/{flight_id}.json")
        zoom = tilejson["maxzoom"]
        x, y = middle_of(tilejson["bounds"], zoom)
        tile = f"/tiles/{flight_id}/{zoom}/{x}/{y}"
        hot = f"/tiles/{flight_id}/{zoom}/{x + 1}/{y}"
        whole = server.request("GET", hot)
        shutil.rmtree(pathlib.Path(self.data, "cache", "flights"))
        self.proxy.fails = 1.0  # every request
        self.assertEqual(server.request("GET", tile)[0], 503)
        self.assertEqual(server.request("GET", hot)[2], whole[2])  # in memory
        _, _, said = server.request("PUT", f"/api/v1/flights/{flight_id}/files/more.jpg", self.photos[0][1], code=503)
        self.assertIn("Try again later", json.loads(said)["detail"])
        self.assertEqual(len(server.json("GET", f"/api/v1/flights/{flight_id}/files")[1]["files"]), 6)
        self.proxy.fails = 0
        self.assertEqual(server.request("GET", tile)[0], 200)
        self.assertEqual(server.request("PUT", f"/api/v1/flights/{flight_id}/files/more.jpg", self.photos[0][1])[0], 201)

    def test_a_worker_that_is_killed_while_it_stores_leaves_no_orphan(self):
        server = self.serve_s3()
        flight_id, job_id = server.begun(self.photos)
        wait_until(lambda: any("/r1/" in key for key in self.keys("flights/")) or None, "no product was stored")
        for pid in server.workers():
            os.kill(pid, signal.SIGKILL)
        server.ended(job_id)
        _, flight = server.json("GET", f"/api/v1/flights/{flight_id}")
        shown = re.search(r"rev=(\d+)", json.dumps(server.json("GET", flight["tilejson"])[1])).group(1)
        self.assertEqual(self.folders(), {"files", f"r{shown}"})

    def test_processes_that_decode_photos_are_told_no_keys(self):
        server = self.serve_s3()
        _, job_id = server.begun(self.photos)
        seen = []

        def looked():
            for pid in confined_of(server, "stitch-sandboxed"):
                try:
                    seen.append(pathlib.Path(f"/proc/{pid}/environ").read_bytes())
                except (FileNotFoundError, ProcessLookupError):
                    continue
            return any(seen)
        wait_until(looked, "no process was seen that stitches")
        self.assertFalse([environ for environ in seen if b"AWS_" in environ])
        server.ended(job_id)
        self.assertNotIn(s3_store.KEY, server.errors())
