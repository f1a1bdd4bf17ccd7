"""Commands and options of docs/operations.md do what the page says: the data folder, what the server tells, webhooks, basemaps."""
import json
import os
import pathlib
import re
import shlex
import shutil
import time

from operations_page import AS_JSON, FLIGHTS, OperationsCase, replays
from server_support import in_catalogue, put_map, wait_until


class OperationsData(OperationsCase):
    # The data folder

    @replays("skyquilt data check .*", "skyquilt data repair .*", "skyquilt data purge-lost --data data", "skyquilt data purge-lost .* --yes")
    def test_the_data_folder(self, check, repair, purge, purge_now):
        flight = put_map(self.data)
        data = pathlib.Path(self.data)
        self.token("admin")
        self.assertTrue((data / "skyquilt-data.json").is_file())
        self.run_page(check)
        server = self.serve("--workers", "0")
        self.assertEqual(data.stat().st_mode & 0o777, 0o700)
        self.run_page(check, code=1)  # one server at a time, and nobody beside it
        self.assertIn("another", self.refusal("--listen", "127.0.0.1:0"))
        server.stop()
        catalogue = (data / "catalogue.db").read_bytes()
        (data / "catalogue.db").unlink()
        self.assertIn("data repair", self.refusal("--listen", "127.0.0.1:0"))
        self.run_page(check, code=2)
        self.assertIn("1 flight", self.run_page(repair))
        (data / "flights" / "letter.txt").write_text("not ours")
        server = self.serve("--workers", "0")
        self.assertEqual(server.json("GET", f"{FLIGHTS}/{flight}")[1]["state"], "ready")  # the token was in the catalogue alone
        server.stop()
        self.assertIn("lost/", self.run_page(check, code=2))
        self.assertIn("1 file", self.run_page(purge, code=2))
        self.assertTrue(list(data.glob("lost/*/flights/letter.txt")))
        self.run_page(purge_now)
        self.assertEqual(list(data.glob("lost/*")), [])
        self.run_page(check)
        # A backup of the catalogue saves the token too.
        (data / "catalogue.db").write_bytes(catalogue)
        self.assertEqual(self.status(self.serve("--workers", "0")), 401)

    def test_backup(self):
        flight = put_map(self.data)
        who = self.token("read")
        server = self.serve("--workers", "0")
        tilejson = server.request("GET", f"/tiles/{flight}.json", headers=who)[2]
        server.stop()
        copy = f"{self.data}-copy"
        shutil.copytree(self.data, copy)
        self.serve("--workers", "0").stop()
        shutil.rmtree(self.data)
        self.data = copy
        server = self.serve("--workers", "0")
        strip = lambda body: re.sub(rb":\d{4,5}/", b"/", body)
        self.assertEqual(strip(server.request("GET", f"/tiles/{flight}.json", headers=who)[2]), strip(tilejson))

    @replays("--keep-days 90", "--trash-days 0", r'\{"keep": true\}', f"PATCH {FLIGHTS}/FLIGHT", "skyquilt upload --keep", "skyquilt upload")
    def test_old_flights(self, keep_days, trash_days, body, patch, upload_kept, upload):
        self.assertIn("--trash-days", self.refusal(*shlex.split(keep_days), *shlex.split(trash_days)))
        server = self.serve_page(keep_days)
        for command in (upload, upload_kept):
            folder = self.photos_in(command.split()[-1].strip("-"))
            self.run_page(f"{command} {folder} --server http://127.0.0.1:{server.port} --no-map")
        flights = {flight["name"]: flight["id"] for flight in server.json("GET", FLIGHTS)[1]["flights"]}
        self.assertEqual(set(flights), {"upload", "keep"})
        marked = server.new_flight()
        method, path = patch.replace("FLIGHT", marked).split()
        self.assertEqual(self.status(server, path, method, body, **AS_JSON), 200)
        server.stop()
        server = self.serve_page(keep_days)
        counted = lambda: in_catalogue(self.data, "SELECT count(*) FROM idle_flight")[0][0]
        wait_until(lambda: counted() == 3, "the flights were not looked at")
        server.stop()
        in_catalogue(self.data, f"UPDATE idle_flight SET since_us=since_us-{keep_days.split()[1]}*86400000000")
        server = self.serve_page(keep_days)
        trash = lambda: [flight["id"] for flight in server.json("GET", "/api/v1/trash")[1]["flights"]]
        wait_until(lambda: trash() == [flights["upload"]], "it stayed")
        self.assertIn(f"{FLIGHTS}/{flights['upload']}/restore", server.errors())
        self.assertEqual({flight["id"] for flight in server.json("GET", FLIGHTS)[1]["flights"]}, {marked, flights["keep"]})
        self.assertEqual(self.status(server, f"{FLIGHTS}/{flights['upload']}/restore", "POST"), 200)
        server.stop()
        server = self.serve_page(trash_days)
        self.assertEqual(self.status(server, f"{FLIGHTS}/{marked}", "DELETE"), 204)
        self.assertEqual(trash(), [])

    @replays("--watch DIR")
    def test_watched_folders(self, watch):
        server = self.serve_page(watch.replace("DIR", str(self.photos_in("card"))))
        wait_until(lambda: [flight["file_count"] for flight in server.json("GET", FLIGHTS)[1]["flights"]] == [2], server.errors())
        wait_until(pathlib.Path(self.data, "watch/sent.jsonl").is_file, "nothing is remembered")
        [watcher] = server.workers()
        server.stop()
        self.assertFalse(pathlib.Path(f"/proc/{watcher}").exists())

    def test_exports(self):
        flight = put_map(self.data)
        server = self.serve("--workers", "0")
        server.json("POST", f"{FLIGHTS}/{flight}/exports", {"format": "geotiff"}, code=202)
        wait_until(lambda: list(pathlib.Path(self.data, "flights", flight, "exports").glob("*.tif")), server.errors())

    # Watching it

    @replays("GET /healthz", "GET /readyz", "GET /metrics")
    def test_watching(self, *requests):
        server = self.serve()
        for request in requests:
            method, path = request.split()
            _, _, body = server.request(method, path, code=200)
        self.assertRegex(body.decode(), r"(?m)^# TYPE skyquilt_\w+ ")
        # What fails is written down, without what follows the question mark.
        away = f"{self.data}-away"
        os.rename(self.data, away)
        _, headers, _ = server.request("GET", "/readyz?token=sq_secret", code=503)
        os.rename(away, self.data)
        wait_until(lambda: '"/readyz' in server.errors(), "it is not written down")
        [line] = [json.loads(line) for line in server.errors().splitlines() if '"/readyz' in line]
        self.assertEqual([line[name] for name in ("method", "path", "status", "request_id")], ["GET", "/readyz", 503, headers["X-Request-Id"]])
        self.assertNotIn("sq_secret", server.errors())
        wait_until(lambda: self.status(server, "/readyz") == 200, "it does not come back")
        # A stop takes no longer than the page says, and a job goes on afterwards.
        _, job = server.begun(self.photos)
        server.wait_for_job(job, lambda job: job["state"] == "running")
        begun = time.monotonic()
        self.assertEqual(server.stop(), 0)
        self.assertLess(time.monotonic() - begun, 9)
        server = self.serve()
        server.ended(job)

    # Webhooks and basemaps

    @replays("serve --webhooks public", "any", "POST /api/v1/webhooks")
    def test_webhooks(self, public, any_address, request):
        method, path = request.split()
        name = lambda server, url: server.json(method, path, {"url": url})
        server = self.serve("--workers", "0")
        self.assertEqual(name(server, "http://192.0.2.1/")[0], 403)
        server.stop()
        server = self.serve_page(public)
        for url in ("http://127.0.0.1:9/", "http://10.0.0.1/", "http://192.168.1.1/", "http://[::1]/", "http://localhost/"):
            status, problem = name(server, url)
            self.assertEqual((status, "private address" in problem["detail"]), (422, True), (url, problem))
        self.assertEqual(name(server, "http://93.184.216.34/")[0], 201)
        server.stop()
        self.assertEqual(name(self.serve_page(public.replace("public", any_address)), "http://10.0.0.1/")[0], 201)

    @replays("serve --basemap", "--basemap-attribution", r"openstreetmap|opentopomap|[a-z]+-(?:light|dark|imagery)", "--basemap none")
    def test_basemaps(self, option, attribution, names, none):
        told = re.search(r"fetched by each browser from there: (.*?) \(read", self.run_page("skyquilt serve --help"))[1]
        self.assertEqual(names, told.split(", "))
        for name in names:
            server = self.serve_page(f"{option} {name}")
            self.assertNotEqual(server.json("GET", "/basemap.json", code=200)[1]["attribution"], "", name)
            self.assertEqual(server.stop(), 0)
        server = self.serve_page(f"{option} https://tiles.example/{{z}}/{{x}}/{{y}}.png {attribution} Makers")
        self.assertEqual(server.json("GET", "/basemap.json")[1]["attribution"], "Makers")
        server.stop()
        server = self.serve("--workers", "0")
        basemap = server.json("GET", "/basemap.json")[1]
        self.assertEqual((basemap["tiles"], bool(basemap["public"])), ([], True))
        server.stop()
        self.assertEqual(self.serve_page(f"serve {none}").json("GET", "/basemap.json")[1]["public"], [])
