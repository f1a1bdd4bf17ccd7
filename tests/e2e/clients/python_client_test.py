"""The Python client (api/clients/python), installed by pip as users install it, against the real server: uploads through a
kill of the server, downloads that go on, exports, places, errors, the contract and the examples of its README."""
import errno
import http.client
import http.server
import importlib.util
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import unittest.mock
import warnings

from server_support import ServerTestCase, add_token, photos_of

SOURCE = pathlib.Path(__file__).resolve().parents[3] / "api" / "clients" / "python"


def can_build():
    """Whether pip, setuptools and wheel are here, which build the package."""
    return all(importlib.util.find_spec(name) for name in ("pip", "setuptools", "wheel"))


class PythonClient(ServerTestCase):
    @classmethod
    def setUpClass(cls):
        if not can_build():
            raise unittest.SkipTest("python3-pip, python3-setuptools or python3-wheel is not here")
        super().setUpClass()
        copy, site = pathlib.Path(cls.scratch, "source"), pathlib.Path(cls.scratch, "site")
        shutil.copytree(SOURCE, copy, ignore=shutil.ignore_patterns("__pycache__", ".mypy_cache"))
        made = subprocess.run([sys.executable, "-m", "pip", "install", "--no-index", "--no-build-isolation", "--no-cache-dir", "--target", site, copy],
                              capture_output=True, text=True)
        assert made.returncode == 0, made.stderr
        cls.site = site
        sys.path.insert(0, str(site))
        import skyquilt
        assert pathlib.Path(skyquilt.__file__).is_relative_to(site)
        cls.skyquilt = skyquilt
        cls.folder = pathlib.Path(cls.scratch, "flight")
        cls.folder.mkdir()
        for name, content in cls.photos:
            (cls.folder / name).write_bytes(content)
        (cls.folder / ".hidden").write_bytes(b"x")
        (cls.folder / "empty.txt").write_bytes(b"")

    @classmethod
    def tearDownClass(cls):
        sys.path.remove(str(cls.site))
        super().tearDownClass()

    def start(self, *arguments, port=0):
        return self.serve(*arguments, listen=f"127.0.0.1:{port}")

    def client(self, server, token=None, **more):
        return self.skyquilt.Client(f"http://127.0.0.1:{server.port}", token, **more)

    def ready(self, server):
        return self.client(server).upload(self.folder, name="Field 7").wait()

    def token(self, scope):
        return add_token(self.data, scope, "--scope", scope)

    def test_an_upload_outlives_a_kill_and_becomes_a_map(self):
        server = self.start("--workers", "1")
        # Beside the photos a long file that is none: it must arrive as it is, through the kill.
        long_file = pathlib.Path(self.data, "..", "zz_notes.bin").resolve()
        long_file.write_bytes(os.urandom(40 << 20))
        told, killed = [], threading.Event()

        def start_again():
            time.sleep(1.0)
            self.start("--workers", "1", port=server.port)

        def on_progress(progress):
            told.append(progress)
            if progress.stage == "upload" and progress.done_bytes > 20 << 20 and not killed.is_set():
                killed.set()
                server.kill()  # here: beside it all could have been sent before
                self.again = threading.Thread(target=start_again)
                self.again.start()

        paths = [self.folder, long_file]
        flight = self.client(server, patience_s=120).upload(paths, name="Through a kill", progress=on_progress)
        self.again.join()
        self.assertTrue(killed.is_set())
        self.assertIn("waiting", {progress.stage for progress in told})
        fractions = [progress.fraction for progress in told if progress.stage == "upload"]
        self.assertEqual((fractions, fractions[-1]), (sorted(fractions), 1.0))
        sent = {file["name"]: file["bytes"] for file in flight.files()}
        self.assertEqual(sent, {**{name: len(content) for name, content in self.photos}, "zz_notes.bin": 40 << 20})
        self.assertEqual(flight.photo("zz_notes.bin"), long_file.read_bytes())
        self.assertEqual(flight.photo(self.photos[0][0]), self.photos[0][1])
        flight.wait(told.append)
        self.assertEqual((flight.state, flight.name, flight.has_map), ("ready", "Through a kill", True))
        self.assertEqual(told[-1].fraction, 1.0)
        # What is there is not sent again.
        kept = sorted(photos_of(self.data, flight.id))
        told.clear()
        self.client(server).upload(paths, flight=flight.id, progress=told.append, makes_map=False)
        self.assertEqual([progress for progress in told if progress.done_bytes], [])
        self.assertEqual(sorted(photos_of(self.data, flight.id)), kept)

    def test_a_job_is_waited_for_through_a_kill(self):
        server = self.start("--workers", "1")
        flight = self.client(server, patience_s=120).upload(self.folder)
        self.assertEqual(flight.name, "flight")
        server.kill()
        told = []
        again = threading.Timer(1.0, lambda: self.start("--workers", "1", port=server.port))
        again.start()
        self.assertTrue(flight.wait(told.append).has_map)
        again.join()
        self.assertIn("waiting", {progress.stage for progress in told})

    def test_files_exports_and_places(self):
        server = self.start("--workers", "1")
        client = self.client(server)
        flight = self.ready(server)
        self.assertEqual([one.id for one in client.flights()], [flight.id])
        out = pathlib.Path(self.data, "out")
        out.mkdir()
        whole = server.request("GET", f"/api/v1/flights/{flight.id}/download.tif")[2]
        self.assertEqual(flight.download("geotiff", out / "map.tif").read_bytes(), whole)
        # While an answer is read another question has a connection of its own.
        with client.api.download_geotiff(flight.id) as answer:
            begun = answer.read(1000)
            self.assertEqual(len(client.flights()), 1)
            self.assertEqual(begun + answer.read_all(), whole)
        # Broken off in an earlier call: what is there is kept.
        (out / "half.tif.part").write_bytes(whole[:1000] )
        etag = server.request("GET", f"/api/v1/flights/{flight.id}/download.tif", headers={"Range": "bytes=0-0"})[1]["ETag"]
        (out / "half.tif.part.etag").write_text(etag)
        told = []
        self.assertEqual(flight.download("geotiff", out / "half.tif", told.append).read_bytes(), whole)
        self.assertEqual((told[-1].done_bytes, told[-1].fraction), (len(whole), 1.0))
        # Of another map: it begins anew. All of it was there: likewise.
        for begun, mark in ((b"of another map", '"other"'), (whole, etag)):
            (out / "half.tif.part").write_bytes(begun)
            (out / "half.tif.part.etag").write_text(mark)
            self.assertEqual(flight.download("geotiff", out / "half.tif").read_bytes(), whole)

        # The network goes away while it comes: it is waited for.
        def cut(response, amount=None, read=http.client.HTTPResponse.read):
            if amount and cuts:
                raise OSError(cuts.pop(), "Network is unreachable")
            return read(response, amount)

        cuts = [errno.ENETUNREACH]
        told.clear()
        with unittest.mock.patch.object(http.client.HTTPResponse, "read", cut):
            self.assertEqual(flight.download("geotiff", out / "half.tif", told.append).read_bytes(), whole)
        self.assertEqual((cuts, told[0].stage), ([], "waiting"))
        self.assertEqual(sorted(path.name for path in out.iterdir()), ["half.tif", "map.tif"])
        for kind in self.skyquilt.DOWNLOADS:
            if not kind.startswith(("layer", "dsm", "dtm", "contours", "bands")):  # which not every map has
                self.assertGreater(flight.download(kind, out).stat().st_size, 0, kind)
        self.assertEqual(json.loads((out / f"{flight.id}_report.json").read_text()), flight.report())
        with self.assertRaisesRegex(self.skyquilt.NotFound, "."):
            flight.download("layer_height", out)
        with self.assertRaisesRegex(self.skyquilt.NotFound, "."):
            flight.download("dsm", out)
        with self.assertRaisesRegex(self.skyquilt.InputError, "geotiff, mbtiles"):
            flight.download("jpeg2000", out)
        exported = flight.export("geotiff", out / "utm.tif", crs="utm", resolution_m=0.5).read_bytes()
        self.assertIn(exported[:2], (b"II", b"MM"))
        self.assertNotEqual(exported, whole)
        self.assertEqual(flight.export("kmz", out).read_bytes()[:2], b"PK")
        with self.assertRaises(self.skyquilt.Unprocessable) as refused:
            flight.export("geotiff", out, crs="EPSG:1")
        self.assertIn("EPSG:1", str(refused.exception))
        west, south, east, north = flight.bounds
        lon, lat = (west + east) / 2, (south + north) / 2
        seen = flight.photos_at(lon, lat)
        self.assertTrue(seen)
        self.assertEqual([photo["name"] for photo in flight.photos_at(lon + 360, lat)], [photo["name"] for photo in seen])
        for photo in seen:
            ground = flight.ground_at(photo["name"], photo["x"], photo["y"])
            self.assertAlmostEqual(ground["lon"], lon, places=8)
            self.assertAlmostEqual(ground["lat"], lat, places=8)
        first = seen[0]
        self.assertEqual(flight.points(first["name"], [(first["x"], first["y"])] * 2), [flight.ground_at(first["name"], first["x"], first["y"])] * 2)
        self.assertEqual(len(flight.footprints()["features"]), len(self.photos))
        self.assertEqual(flight.tile_url(), flight.tile_json()["tiles"][0].split("?")[0])
        self.assertEqual(flight.rename("Field 8").refresh().name, "Field 8")
        flight.delete()
        self.assertEqual((client.flights(), [one["id"] for one in client.trash()]), ([], [flight.id]))
        self.assertEqual(client.restore(flight.id).bounds, flight.bounds)

    def test_a_map_below_its_photos_is_not_sent(self):
        listed = self.skyquilt.listing.list_files
        folder = pathlib.Path(tempfile.mkdtemp(prefix="mapped_", dir=self.scratch))
        of_map = b"EPSG:4326\na.jpg 7.1234567890 46.1234567890 650.1234 12.123456 0.000000 -1.123456 0.0312 0.0312\n# Heights count.\n"
        own = b"EPSG:4326\na.jpg 7.1 46.1 650\n"
        contents = {"map/geo.txt": of_map, "c/geo.txt": of_map}
        for name in ("a.jpg", "map/geo.txt", "map/mosaic.state", "map/report.json", "map/dsm.tif", "map/frames/f.jpg", "map/frames/frames.json",
                     "map/photos/b.jpg", "c/geo.txt"):
            (folder / name).parent.mkdir(exist_ok=True)
            (folder / name).write_bytes(contents.get(name, b"x"))
        self.assertEqual(sorted(file.name for file in listed(folder)), ["a.jpg", "b.jpg", "geo.txt"])
        self.assertEqual([file.path for file in listed(folder / "map" / "geo.txt")], [folder / "map" / "geo.txt"])
        self.assertEqual([file.name for file in listed(folder / "map" / "frames")], ["f.jpg", "frames.json"])
        # What else lies in it is sent, photos and logs, and the map's own is not for that.
        for name in ("d.jpg", "flight.bin"):
            (folder / "map" / name).write_bytes(b"x")
        self.assertEqual(sorted(file.name for file in listed(folder)), ["a.jpg", "b.jpg", "d.jpg", "flight.bin", "geo.txt"])
        # A list of positions that somebody put there is the flight's.
        (folder / "map" / "geo.txt").write_bytes(own)
        self.assertIn(folder / "map" / "geo.txt", [file.path for file in listed(folder)])

    def test_folders_that_cannot_be_read_are_told(self):
        folder, look = pathlib.Path(tempfile.mkdtemp(dir=self.scratch)), os.scandir
        (folder / "a.jpg").write_bytes(b"x")
        (folder / "closed").mkdir()

        def look_refused(code):
            def scandir(path):
                if pathlib.Path(path).name == "closed":
                    raise OSError(code, os.strerror(code), str(path))
                return look(path)
            return unittest.mock.patch("os.scandir", scandir)

        with look_refused(errno.EACCES), self.assertWarnsRegex(UserWarning, "want of permission: 1 folder .*closed first"):
            self.assertEqual([file.name for file in self.skyquilt.listing.list_files(folder)], ["a.jpg"])
        with look_refused(errno.EIO), self.assertRaisesRegex(self.skyquilt.InputError, "closed cannot be read"):
            self.skyquilt.listing.list_files(folder)

    def test_a_list_that_was_edited_is_sent_beside_the_one_there(self):
        client = self.client(self.start("--workers", "0"))
        folder = pathlib.Path(tempfile.mkdtemp(dir=self.scratch))
        (folder / "geo.txt").write_text("EPSG:4326\na.jpg 7.1 46.1\n")
        flight = client.upload(folder, makes_map=False).id

        def sent_again():
            return [file["name"] for file in client.upload(folder, flight=flight, makes_map=False).files()]
        with warnings.catch_warnings():
            warnings.simplefilter("error", UserWarning)
            self.assertEqual(sent_again(), ["geo.txt"])
        (folder / "geo.txt").write_text("EPSG:4326\na.jpg 7.2 46.2\n")  # as long as before
        with self.assertWarnsRegex(UserWarning, "Another geo.txt is in the flight"):
            both = sent_again()
        with self.assertWarnsRegex(UserWarning, "Another geo.txt is in the flight"):
            self.assertEqual(sent_again(), both)
        self.assertEqual(len(both), 2)
        self.assertEqual(client.flight(flight).photo(both[0]), (folder / "geo.txt").read_bytes())

    def test_a_flight_has_a_name_that_the_server_takes(self):
        called = self.skyquilt.listing.name_of
        folder = pathlib.Path(tempfile.mkdtemp(dir=self.scratch))
        for name, want in (("Поле" * 30, "Поле" * 25), (b"Feld M\xfcller", "Feld M?ller"), ("x" * 210, "x" * 200)):
            one = folder / os.fsdecode(name)
            one.mkdir()
            self.assertEqual(called(one), want)

    def test_errors_are_the_servers_sentences(self):
        server = self.start("--workers", "1")
        client = self.client(server)
        with self.assertRaises(self.skyquilt.NotFound) as refused:
            client.flight("0" * 26)
        self.assertEqual((refused.exception.status, refused.exception.problem["status"]), (404, 404))
        self.assertTrue(refused.exception.detail)
        with self.assertRaisesRegex(self.skyquilt.InputError, "no file or folder"):
            client.upload(pathlib.Path(self.data, "nothing"))
        self.assertEqual(client.flights(), [])
        bad = pathlib.Path(self.data, "bad")
        bad.mkdir()
        for number in range(2):
            (bad / f"{number}.jpg").write_bytes(b"\xff\xd8\xff\xe0 this is no photo" * 50)
        flight = client.upload(bad)
        with self.assertRaises(self.skyquilt.JobFailed) as failed:
            flight.wait()
        self.assertEqual(failed.exception.flight_id, flight.id)
        job = server.json("GET", f"/api/v1/flights/{flight.id}")[1]["job"]
        self.assertEqual((str(failed.exception), failed.exception.code), (job["error"]["message"], job["error"]["code"]))
        with self.assertRaisesRegex(self.skyquilt.NotFound, "."):
            flight.download("geotiff", self.data)

        class NoMore(Exception):
            pass

        def stop(progress):
            raise NoMore

        with self.assertRaises(NoMore):
            client.upload(self.folder, progress=stop)
        self.assertEqual(len(client.flights()), 2)  # and the client goes on
        going = pathlib.Path(self.data, "going")
        going.mkdir()
        for name in ("a.txt", "b.txt"):
            (going / name).write_bytes(b"x")
        with self.assertRaisesRegex(self.skyquilt.InputError, "b.txt cannot be read") as gone:
            client.upload(going, progress=lambda _: (going / "b.txt").unlink(missing_ok=True))
        self.assertTrue(gone.exception.flight_id)
        port = server.port
        server.stop()
        with self.assertRaisesRegex(self.skyquilt.ServerAway, f"Nothing answers at http://127.0.0.1:{port}"):
            self.client(server, patience_s=0).flights()
        for url in ("127.0.0.1:8080", "ftp://a/b", "http://", "http://[::1", "http://127.0.0.1:80800"):
            with self.assertRaisesRegex(self.skyquilt.InputError, "address of a server"):
                self.skyquilt.Client(url)
        with unittest.mock.patch.dict(os.environ, {"no_proxy": "*"}):
            for scheme, usual in (("http", 80), ("https", 443)):
                made = self.skyquilt.Client(f"{scheme}://[2001:db8::5]").transport._connect()[0]
                self.assertEqual((made.host, made.port), ("2001:db8::5", usual))

    def test_tokens_decide(self):
        read, upload = self.token("read"), self.token("upload")
        server = self.start("--workers", "1")
        for wrong in (None, "sq_mistyped"):
            with self.assertRaises(self.skyquilt.Unauthorized) as refused:
                self.client(server, wrong).flights()
            self.assertEqual(refused.exception.status, 401)
        with self.assertRaises(self.skyquilt.Forbidden):
            self.client(server, read).upload(self.folder)
        flight = self.client(server, upload).upload(self.folder).wait()
        self.assertEqual(self.client(server, upload + "\n").access()["scope"], "upload")  # as a file has it
        address = flight.tile_url()
        self.assertTrue(address.endswith(f"?token={upload}"))
        self.assertNotIn("token", flight.tile_url(with_token=False))
        status, _, _ = server.request("GET", address.removeprefix(f"http://127.0.0.1:{server.port}").format(z=0, x=0, y=0))
        self.assertIn(status, (200, 204, 404))

    def test_another_server_is_no_skyquilt(self):
        class Page(http.server.BaseHTTPRequestHandler):
            def do_GET(self):
                self.send_response(301 if "access" in self.path else 200)
                self.send_header("Location", "https://elsewhere.example/")
                self.send_header("Content-Length", "4")
                self.end_headers()
                self.wfile.write(b"<ht>")

            def log_message(self, *_):
                pass

        with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Page) as page:
            threading.Thread(target=page.serve_forever, daemon=True).start()
            client = self.skyquilt.Client(f"http://127.0.0.1:{page.server_port}")
            with self.assertRaisesRegex(self.skyquilt.NotASkyquilt, "no Skyquilt"):
                client.flights()
            with self.assertRaisesRegex(self.skyquilt.InputError, "https://elsewhere.example/"):
                client.access()
            page.shutdown()

    def test_the_networks_proxy_is_asked(self):
        import urllib.request
        server, asked = self.start("--workers", "0"), []

        class Proxy(http.server.BaseHTTPRequestHandler):
            def do_GET(self):
                asked.append((self.path, self.headers["Proxy-Authorization"]))
                direct = urllib.request.build_opener(urllib.request.ProxyHandler({}))
                with direct.open(self.path) as answer:
                    body = answer.read()
                self.send_response(200)
                self.send_header("Content-Length", str(len(body)))
                self.end_headers()
                self.wfile.write(body)

            def log_message(self, *_):
                pass

        with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Proxy) as proxy:
            threading.Thread(target=proxy.serve_forever, daemon=True).start()
            for name in ("", "me:a%40b@"):
                with unittest.mock.patch.dict(os.environ, {"http_proxy": f"http://{name}127.0.0.1:{proxy.server_port}", "no_proxy": ""}):
                    self.assertEqual(self.client(server).flights(), [])
            proxy.shutdown()
        address = f"http://127.0.0.1:{server.port}/api/v1/flights?limit=200"
        self.assertEqual(asked, [(address, None), (address, "Basic bWU6YUBi")])

    def test_the_examples_run(self):
        server = self.start("--workers", "1")
        where = pathlib.Path(tempfile.mkdtemp(dir=self.scratch))
        shutil.copytree(self.folder, where / "DCIM")
        examples = re.findall(r"```python\n(.*?)```", (SOURCE / "README.md").read_text(), re.S)
        self.assertGreaterEqual(len(examples), 5)
        for example in examples:
            done = subprocess.run([sys.executable, "-c", example.replace("127.0.0.1:8080", f"127.0.0.1:{server.port}")], cwd=where,
                                  env={**os.environ, "PYTHONPATH": str(self.site)}, capture_output=True, text=True)
            self.assertEqual((done.returncode, done.stderr), (0, ""), example)
        self.assertTrue((where / "field7.tif").exists() and (where / "field7_utm.tif").exists())


class Package(unittest.TestCase):
    """What needs no server."""

    def test_the_contract_is_the_servers(self):
        done = subprocess.run([sys.executable, SOURCE / "generate.py", "--check"], capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stdout + done.stderr), (0, ""))

    def test_types_are_strict(self):
        mypy = shutil.which("mypy")
        if mypy is None:
            self.skipTest("mypy is not here")
        with tempfile.TemporaryDirectory() as cache:
            done = subprocess.run([mypy, "--strict", "--cache-dir", cache, "-p", "skyquilt"], cwd=SOURCE, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
