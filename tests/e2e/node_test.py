"""The NodeODM-compatible node, call by call as its clients make them: a photo folder in, all.zip out."""
import io
import json
import re
import subprocess
import sys
import urllib.parse
import uuid as uuids
import zipfile

import server_support
from flights import made_flights
from program import DATA, run
from server_support import AS_JSON, FORM, ServerTestCase, kept_of_flights, photos_in, storage_words, wait_until
from sharing_test import Receiver

AS_FORM = {"Content-Type": "application/x-www-form-urlencoded"}
UUID = re.compile(r"[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}$")


def form(fields=(), files=()):
    return server_support.form(fields, files, "images", "application/octet-stream")


class Node(ServerTestCase):
    def ask(self, server, method, path, body=None, headers=None):
        """What a client sees: always 200 with JSON."""
        status, got, answer = server.request(method, path, body, headers)
        self.assertEqual((status, got["Content-Type"]), (200, "application/json"), answer)
        return json.loads(answer)

    def start(self, server, fields=(), headers=None):
        made = self.ask(server, "POST", "/task/new/init", form(fields), {**FORM, **(headers or {})})
        uuid = made["uuid"]
        for photo in self.photos:
            self.assertEqual(self.ask(server, "POST", f"/task/new/upload/{uuid}", form(files=[photo]), FORM), {"success": True})
        self.assertEqual(self.ask(server, "POST", f"/task/new/commit/{uuid}"), {"uuid": uuid})
        return uuid

    def wait(self, server, uuid, code):
        told = {}

        def is_there():
            told.update(self.ask(server, "GET", f"/task/{uuid}/info"))
            return told["status"]["code"] in (30, 40, 50)
        wait_until(is_there, f"the task did not end: {told}")
        self.assertEqual(told["status"]["code"], code, f"{told} {server.errors()}")
        return told

    def test_what_a_client_asks_first(self):
        server = self.serve("--workers", "2")
        told = self.ask(server, "GET", "/info")
        self.assertRegex(told["version"], r"^\d+\.\d+\.\d+$")
        self.assertGreaterEqual([int(n) for n in told["version"].split(".")], [1, 5, 1])
        self.assertEqual((told["taskQueueCount"], told["maxImages"], told["maxParallelTasks"], told["engine"]),
                         (0, None, 2, "skyquilt"))
        offered = self.ask(server, "GET", "/options")
        self.assertLessEqual({"dsm", "fast-orthophoto", "mesh-size", "pc-quality", "split"}, {option["name"] for option in offered})
        for option in offered:
            self.assertEqual(sorted(option), ["domain", "help", "name", "type", "value"])  # clients unpack exactly these
            self.assertIsInstance(option["value"], str)
            self.assertIn(option["type"], ("int", "float", "string", "bool", "enum"))
        self.assertEqual(self.ask(server, "GET", "/task/list"), [])
        self.assertEqual(self.ask(server, "GET", "/auth/info"),
                         {"message": "Authentication not available on this node", "loginUrl": None, "registerUrl": None})
        for call in ("login", "register"):
            self.assertEqual(self.ask(server, "POST", f"/auth/{call}", '{"username":"a","password":"b"}', AS_JSON),
                             {"error": "Not available"})

    def test_the_engine_is_the_one_that_clients_insist_on(self):
        self.assertEqual(self.ask(self.serve("--workers", "0", "--node-engine", "odm"), "GET", "/info")["engine"], "odm")
        self.assertIn("--node-engine", self.refusal("--node-engine", "Open Drone Map"))

    def test_a_task_goes_from_init_to_all_zip(self):
        server = self.serve()
        wanted = str(uuids.uuid4())
        options = [{"name": "orthophoto-quality", "value": "80"}, {"name": "fast-orthophoto", "value": True}]
        uuid = self.start(server, {"name": "North field", "options": json.dumps(options), "skipPostProcessing": "true",
                                   "dateCreated": "1700000000000"}, {"set-uuid": wanted})
        self.assertEqual(uuid, wanted)
        self.assertEqual(self.ask(server, "GET", "/task/list"), [{"uuid": uuid}])
        self.assertEqual(self.ask(server, "GET", f"/task/{uuid}/download/orthophoto.tif"), {"error": "Invalid asset"})
        told = self.wait(server, uuid, 40)
        self.assertEqual((told["name"], told["dateCreated"], told["imagesCount"], told["progress"]),
                         ("North field", 1700000000000, len(self.photos), 100))
        self.assertEqual(told["options"], [{"name": "orthophoto-quality", "value": 80}, {"name": "fast-orthophoto", "value": True}])
        self.assertGreater(told["processingTime"], 0)
        lines = self.ask(server, "GET", f"/task/{uuid}/output?line=0")
        self.assertTrue(any("stage align" in line for line in lines), lines)
        self.assertEqual(self.ask(server, "GET", f"/task/{uuid}/output?line=-1"), lines[-1:])
        self.assertEqual(self.ask(server, "GET", f"/task/{uuid}/info?with_output=1")["output"], lines[1:])
        self.check_archive(server, uuid)
        # A restart of the server loses nothing, whichever way it went down.
        server.kill()
        self.assertEqual(self.ask(self.serve(), "GET", f"/task/{uuid}/info")["status"]["code"], 40)

    def check_archive(self, server, uuid):
        path = f"/task/{uuid}/download/all.zip"
        status, headers, whole = server.request("GET", path)
        self.assertEqual((status, headers["Accept-Ranges"], int(headers["Content-Length"])), (200, "bytes", len(whole)))
        # 16 connections, as the clients do it.
        step = len(whole) // 16 + 1
        parts = b""
        for first in range(0, len(whole), step):
            last = min(first + step, len(whole)) - 1
            status, headers, part = server.request("GET", path, headers={"Range": f"bytes={first}-{last}"})
            self.assertEqual((status, headers["Content-Range"]), (206, f"bytes {first}-{last}/{len(whole)}"))
            parts += part
        self.assertEqual(parts, whole)
        archive = zipfile.ZipFile(io.BytesIO(whole))
        self.assertIsNone(archive.testzip())
        names = set(archive.namelist())
        self.assertNotIn("odm_orthophoto/odm_orthophoto.pmtiles", names)  # the same pyramid once more
        self.assertLessEqual({"odm_orthophoto/odm_orthophoto.tif", "odm_orthophoto/odm_orthophoto.mbtiles",
                              "odm_report/shots.geojson", "odm_report/stats.json", "images.json", "task_output.txt"}, names)
        shots = json.loads(archive.read("odm_report/shots.geojson"))
        self.assertEqual(sorted(shot["properties"]["filename"] for shot in shots["features"]),
                         sorted(name for name, _ in self.photos))
        stats = json.loads(archive.read("odm_report/stats.json"))
        self.assertGreater(stats["processing_statistics"]["area"], 0)
        made = stats["reconstruction_statistics"]
        self.assertEqual((made["has_gps"], made["has_gcp"], made["reconstructed_shots_count"]), (True, False, len(self.photos)))
        self.assertGreater(made["reconstructed_points_count"], 0)
        self.assertNotIn("gcp_errors", stats)
        self.check_cog(archive.extract("odm_orthophoto/odm_orthophoto.tif", self.data))

    def test_the_real_photos_make_a_valid_cog(self):
        folder = DATA / "brighton_beach" / "images"
        if not folder.is_dir():
            self.skipTest("the Brighton Beach photos are not here")
        self.photos = photos_in(folder)
        self.assertEqual(len(self.photos), 18)
        server = self.serve()
        uuid = self.start(server, {"name": "Brighton Beach"})
        self.assertEqual(self.wait(server, uuid, 40)["imagesCount"], 18)
        self.check_archive(server, uuid)

    def test_ground_control_among_the_images_is_told_of(self):
        server = self.serve()
        truth = json.loads((made_flights.small_flight() / "truth/poses.json").read_text())
        points = made_flights.gcp_list(truth, ((-15.0, -10.0), (15.0, -10.0), (0.0, 12.0)))
        made = self.ask(server, "POST", "/task/new", form({"name": "surveyed"}, [*self.photos, ("gcp_list.txt", points.encode())]), FORM)
        self.wait(server, made["uuid"], 40)
        whole = server.request("GET", f"/task/{made['uuid']}/download/all.zip")[2]
        stats = json.loads(zipfile.ZipFile(io.BytesIO(whole)).read("odm_report/stats.json"))
        self.assertTrue(stats["reconstruction_statistics"]["has_gcp"], server.errors())
        self.assertLess(stats["gcp_errors"]["average_error"], 0.5)

    def check_cog(self, path):
        self.imported("python3-gdal is not here", "osgeo.gdal")
        said = subprocess.run([sys.executable, "-m", "osgeo_utils.samples.validate_cloud_optimized_geotiff", path],
                              capture_output=True, text=True)
        self.assertIn("is a valid cloud optimized GeoTIFF", said.stdout, said.stdout + said.stderr)

    def test_all_in_one_form(self):
        server = self.serve()
        uuid = self.ask(server, "POST", "/task/new", form({"name": "One form"}, self.photos), FORM)["uuid"]
        self.assertRegex(uuid, UUID)
        self.assertEqual(self.wait(server, uuid, 40)["imagesCount"], len(self.photos))

    def test_init_and_changes_take_every_kind_of_form(self):
        server = self.serve("--workers", "0")
        options = [{"name": "mesh-size", "value": "300000"}, {"name": "dsm", "value": True}]
        as_text = json.dumps(options)
        bodies = (({"name": "A", "options": as_text, "dateCreated": "1700000000000"}, None),
                  (urllib.parse.urlencode({"name": "A", "options": as_text, "dateCreated": 1700000000000}), AS_FORM),
                  (json.dumps({"name": "A", "options": options, "dateCreated": 1700000000000}), AS_JSON),
                  (json.dumps({"name": "A", "options": as_text, "dateCreated": "1700000000000"}), AS_JSON))
        uuids_made = []
        for body, headers in bodies:
            made = self.ask(server, "POST", "/task/new/init", *((form(body), FORM) if headers is None else (body, headers)))
            self.ask(server, "POST", f"/task/new/upload/{made['uuid']}", form(files=self.photos[:1]), FORM)
            self.ask(server, "POST", f"/task/new/commit/{made['uuid']}")
            told = self.ask(server, "GET", f"/task/{made['uuid']}/info")
            self.assertEqual((told["name"], told["dateCreated"]), ("A", 1700000000000))
            self.assertEqual(told["options"], [{"name": "mesh-size", "value": 300000}, {"name": "dsm", "value": True}])
            uuids_made.append(made["uuid"])
        self.assertRegex(self.ask(server, "POST", "/task/new/init", b"")["uuid"], UUID)
        for uuid, (body, headers) in zip(uuids_made, ((form, FORM), (urllib.parse.urlencode, AS_FORM), (json.dumps, AS_JSON))):
            for call in ("cancel", "restart", "cancel", "remove"):
                self.assertEqual(self.ask(server, "POST", f"/task/{call}", body({"uuid": uuid}), headers), {"success": True})
        self.assertEqual(self.ask(server, "GET", "/task/list"), [{"uuid": uuids_made[3]}])

    def test_states_are_those_that_clients_wait_for(self):
        server = self.serve("--workers", "1")
        uuid = self.start(server)
        code = lambda task: self.ask(server, "GET", f"/task/{task}/info")["status"]["code"]  # noqa: E731
        self.assertEqual(code(uuid), 20)
        self.assertEqual(self.ask(server, "POST", "/task/cancel", f"uuid={uuid}"), {"success": True})
        self.assertEqual(code(uuid), 50)
        self.assertEqual(self.ask(server, "POST", "/task/restart", f"uuid={uuid}"), {"success": True})
        self.assertEqual(code(uuid), 20)
        self.assertEqual(code(self.start(server)), 10)
        self.wait(server, uuid, 40)
        # A task that is done becomes one that was cancelled; what it made is still there.
        self.assertEqual(self.ask(server, "POST", "/task/cancel", f"uuid={uuid}"), {"success": True})
        self.assertEqual(code(uuid), 50)
        self.assertEqual(server.request("GET", f"/task/{uuid}/download/all.zip")[1]["Content-Type"], "application/zip")
        self.assertEqual(self.ask(server, "POST", "/task/restart", f"uuid={uuid}"), {"success": True})
        self.wait(server, uuid, 40)

    def test_the_webhook_of_a_task_is_told_of_its_end(self):
        receiver = Receiver()
        url = f"http://127.0.0.1:{receiver.server_port}/done"
        server = self.serve("--webhooks", "any")
        uuid = self.start(server, {"name": "Told", "webhook": url})
        wait_until(lambda: len(receiver.heard) == 2, "nobody was told, or not again after a refusal")
        for path, _, body in receiver.heard:
            told = json.loads(body)
            self.assertEqual((path, told["uuid"], told["name"], told["status"]), ("/done", uuid, "Told", {"code": 40}))
            self.assertEqual(len(told["images"]), len(self.photos))
        receiver.shutdown()
        receiver.server_close()
        unusable = self.start(server, {"webhook": "gopher://example.org"})
        self.assertRegex(self.ask(server, "GET", f"/task/{unusable}/output")[0], "gopher.*http or https")
        server.stop()
        silent = self.serve("--workers", "0")
        uuid = self.start(silent, {"webhook": url})
        self.assertRegex(self.ask(silent, "GET", f"/task/{uuid}/output")[0], "will not be told.*--webhooks")

    def test_what_is_in_all_zip_is_for_the_task_to_say(self):
        server = self.serve()
        names = lambda task: zipfile.ZipFile(io.BytesIO(server.request(  # noqa: E731
            "GET", f"/task/{task}/download/all.zip")[2])).namelist()
        uuid = self.start(server, {"options": json.dumps([{"name": "archive-tiles", "value": "pmtiles"}])})
        self.wait(server, uuid, 40)
        tiles = [name for name in names(uuid) if name.startswith("odm_orthophoto/")]
        self.assertEqual(tiles, ["odm_orthophoto/odm_orthophoto.tif", "odm_orthophoto/odm_orthophoto.pmtiles"])
        wanted = ["odm_orthophoto/odm_orthophoto.tif", "odm_report/", "odm_dem/dsm.tif"]
        uuid = self.start(server, {"outputs": json.dumps(wanted)})
        self.wait(server, uuid, 40)
        self.assertTrue(all(name == wanted[0] or name.startswith(wanted[1]) for name in names(uuid)))
        self.assertLessEqual({"odm_orthophoto/odm_orthophoto.tif", "odm_report/stats.json"}, set(names(uuid)))
        for bad in ("{}", "[1]", "odm_report"):
            self.assertIn("error", self.ask(server, "POST", "/task/new/init", form({"outputs": bad}), FORM))

    def test_an_empty_file_and_an_unknown_option_do_not_end_a_task(self):
        server = self.serve("--workers", "0")
        options = {"options": json.dumps([{"name": "warp-speed", "value": 9}])}
        made = self.ask(server, "POST", "/task/new/init", form(options), FORM)
        self.assertEqual(made["ignoredOptions"], ["warp-speed"])
        uuid = made["uuid"]
        for file in (*self.photos, ("torn.jpg", b"")):
            self.assertEqual(self.ask(server, "POST", f"/task/new/upload/{uuid}", form(files=[file]), FORM), {"success": True})
        self.assertEqual(self.ask(server, "POST", f"/task/new/commit/{uuid}"), {"uuid": uuid})
        whole = self.ask(server, "POST", "/task/new", form(options, [("torn.jpg", b""), *self.photos]), FORM)["uuid"]
        for task in (uuid, whole):
            self.assertEqual(self.ask(server, "GET", f"/task/{task}/info")["imagesCount"], len(self.photos))
            output = self.ask(server, "GET", f"/task/{task}/output")
            self.assertIn("warp-speed", output[0])
            self.assertRegex(output[1], "torn.jpg.*empty")

    def test_refusals_are_answers(self):
        server = self.serve("--workers", "0")
        nobody = "11111111-2222-4333-8444-555555555555"
        self.assertIn("not found", self.ask(server, "GET", f"/task/{nobody}/info")["error"])
        self.assertIn("not found", self.ask(server, "GET", "/task/nonsense/output")["error"])
        self.assertEqual(self.ask(server, "POST", f"/task/new/upload/{nobody}", form(files=self.photos[:1]), FORM),
                         {"error": "Invalid uuid (not found)"})
        self.assertEqual(self.ask(server, "POST", f"/task/new/commit/{nobody}"), {"error": "Invalid uuid (not found)"})
        for bad in ("x", "11111111-2222-0333-8444-555555555555", "../../etc"):
            self.assertIn("Invalid uuid", self.ask(server, "POST", "/task/new/init", form(), {**FORM, "set-uuid": bad})["error"])
        for options, name in (([{"name": "orthophoto-quality", "value": "0"}], "orthophoto-quality"),
                              ([{"name": "tile-format", "value": "bmp"}], "tile-format"),
                              ([{"name": "orthophoto-resolution", "value": "fine"}], "orthophoto-resolution")):
            answer = self.ask(server, "POST", "/task/new/init", form({"options": json.dumps(options)}), FORM)
            self.assertEqual(json.loads(answer["error"])[0]["name"], name)
        for options in ("{", "{}", '[{"name":1}]', "[" * 100):
            self.assertIn("error", self.ask(server, "POST", "/task/new/init", form({"options": options}), FORM))
        self.assertIn("error", self.ask(server, "POST", "/task/new", form({"zipurl": "http://example.org/a.zip"}), FORM))
        self.assertIn("error", self.ask(server, "POST", "/task/new", b"not a form", FORM))
        self.assertIn("error", self.ask(server, "POST", "/task/new/init", b"[]", AS_JSON))
        for call in ("cancel", "remove", "restart"):
            self.assertEqual(self.ask(server, "POST", f"/task/{call}", b""), {"error": "uuid param missing."})
            self.assertFalse(self.ask(server, "POST", f"/task/{call}", f"uuid={nobody}")["success"])
        empty = self.ask(server, "POST", "/task/new/init", form(), FORM)["uuid"]
        self.assertTrue(self.ask(server, "POST", f"/task/new/upload/{empty}", form(), FORM)["noRetry"])
        nothing = form(files=[("a.jpg", b"")])
        self.assertEqual(self.ask(server, "POST", f"/task/new/upload/{empty}", nothing, FORM), {"success": True})
        self.assertRegex(self.ask(server, "POST", f"/task/new/commit/{empty}")["error"], "at least 1 file.*a.jpg.*empty")
        self.assertRegex(self.ask(server, "POST", "/task/new", nothing, FORM)["error"], "at least 1 file.*a.jpg.*empty")
        self.assertEqual(self.ask(server, "GET", "/task/list"), [])
        self.assertEqual(server.garbage(), [])

    def test_cancel_restart_remove(self):
        server = self.serve("--workers", "0")
        uuid = self.start(server)
        self.assertEqual(self.ask(server, "GET", f"/task/{uuid}/info")["status"], {"code": 10})
        self.assertEqual(self.ask(server, "GET", "/info")["taskQueueCount"], 1)
        self.assertEqual(self.ask(server, "GET", f"/task/{uuid}/download/all.zip"), {"error": "Asset not ready"})
        self.assertFalse(self.ask(server, "POST", "/task/restart", f"uuid={uuid}")["success"])
        self.assertEqual(self.ask(server, "POST", f"/task/new/commit/{uuid}"), {"uuid": uuid})  # a client that heard nothing
        for _ in range(2):
            answer = self.ask(server, "POST", "/task/cancel", json.dumps({"uuid": uuid}), AS_JSON)
            self.assertEqual(answer, {"success": True})
        self.assertEqual(self.ask(server, "GET", f"/task/{uuid}/info")["status"], {"code": 50})
        options = [{"name": "orthophoto-quality", "value": 70}]
        answer = self.ask(server, "POST", "/task/restart", json.dumps({"uuid": uuid, "options": options}), AS_JSON)
        self.assertEqual(answer, {"success": True})
        told = self.ask(server, "GET", f"/task/{uuid}/info")
        self.assertEqual((told["status"], told["options"]), ({"code": 10}, options))
        run("worker", "--data", self.data, *storage_words(self.data), "--until-empty")
        self.wait(server, uuid, 40)
        self.assertEqual(self.ask(server, "POST", "/task/remove", f"uuid={uuid}"), {"success": True})
        self.assertEqual(self.ask(server, "GET", "/task/list"), [])
        [removed] = server.json("GET", "/api/v1/trash")[1]["flights"]
        self.assertEqual(server.request("DELETE", f"/api/v1/trash/{removed['id']}")[0], 204)
        self.assertEqual(kept_of_flights(server.data), {})
