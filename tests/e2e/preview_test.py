"""The map of a flight that is still uploading: it appears, grows, says where, and gives way to the map in one step."""
import http.client
import json
import pathlib
import threading
import time

from program import run
from server_support import ServerTestCase, in_catalogue, middle_tile, parts_of, photos_in, storage_words, wait_until


class Events(threading.Thread):
    """Collects a flight's events until the first of a kind."""

    def __init__(self, server, flight_id, last_kind):
        super().__init__(daemon=True)
        self.last_kind, self.seen = last_kind, []
        self.connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=120)
        self.connection.request("GET", f"/api/v1/events?flight={flight_id}&after=0")
        self.response = self.connection.getresponse()
        self.start()

    def run(self):
        kind = None
        while not self.seen or self.seen[-1][0] != self.last_kind:
            line = self.response.readline().decode().rstrip("\n")
            if line.startswith("event: "):
                kind = line[7:]
            elif line.startswith("data: "):
                self.seen.append((kind, json.loads(line[6:]).get(kind)))
        self.connection.close()

    def of(self, kind):
        return [body for seen, body in list(self.seen) if seen == kind]


def touch(a, b):
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


class Preview(ServerTestCase):
    def middle_tile(self, server, tilejson_path):
        url = middle_tile(server.json("GET", tilejson_path, code=200)[1])
        return url, server.request("GET", url)

    def test_it_grows_with_the_photos_and_gives_way_to_the_map(self):
        server = self.serve()
        _, flight = server.json("POST", "/api/v1/flights", {"name": "Live"})
        flight_id = flight["id"]
        self.assertIsNone(flight["preview"])
        self.assertEqual(server.request("GET", f"/tiles/{flight_id}.json")[0], 404)
        events = Events(server, flight_id, "map")
        server.put(flight_id, self.photos[:1])
        first = self.wait_for_preview(server, flight_id, 1)
        _, (status, headers, body) = self.middle_tile(server, first["tilejson"])
        self.assertEqual(status, 200)
        self.assertGreater(len(body), 500)
        self.assertEqual(headers["Cache-Control"], "no-cache")
        wait_until(lambda: len(events.of("preview")) == 1, "no event of the preview")
        server.put(flight_id, self.photos[1:])
        whole = self.wait_for_preview(server, flight_id, len(self.photos))
        self.assertGreater(whole["edition"], first["edition"])
        self.assertTrue(all(w <= f for w, f in zip(whole["bounds"][:2], first["bounds"][:2])))
        self.assertTrue(all(w >= f for w, f in zip(whole["bounds"][2:], first["bounds"][2:])))
        # Without a revision in its address a client gets what there is; by name it gets just that.
        url, (status, headers, body) = self.middle_tile(server, f"/tiles/{flight_id}.json")
        self.assertIn("rev=preview", url)
        self.assertEqual(server.request("GET", url, headers={"If-None-Match": headers["ETag"]})[0], 304)
        self.assertEqual(server.request("GET", url.replace("rev=preview", "rev=1"))[0], 404)
        self.assertEqual(server.request("GET", url.split("?")[0])[2], body)
        status, headers, webp = server.request("GET", url.replace("?", ".webp?"))
        self.assertTrue(webp.startswith(b"RIFF"))

        server.remade(flight_id)
        events.join(60)
        grown = events.of("preview")
        self.assertEqual([body["edition"] for body in grown], list(range(1, whole["edition"] + 1)))
        self.assertTrue(all(touch(body["changed"], body["bounds"]) for body in grown))
        _, ready = server.json("GET", f"/api/v1/flights/{flight_id}")
        self.assertIsNone(ready["preview"])
        self.assertTrue(touch(ready["bounds"], whole["bounds"]))
        # The preview's own address has nothing more to show; the plain one shows the map.
        wait_until(lambda: server.request("GET", url)[1]["Cache-Control"] == "no-store", "the preview did not end")
        status, headers, blank = server.request("GET", url)
        self.assertEqual((status, headers["Content-Type"], headers["ETag"]), (200, "image/png", '"blank-256"'))
        self.assertNotEqual(blank, body)
        self.assertEqual(server.request("GET", url + "&empty=204")[0], 204)
        self.assertEqual(server.request("GET", url + "&empty=404")[0], 404)
        map_url, (status, _, map_tile) = self.middle_tile(server, f"/tiles/{flight_id}.json")
        self.assertEqual(server.json("GET", f"/tiles/{flight_id}.json?rev=preview"), server.json("GET", f"/tiles/{flight_id}.json"))
        self.assertIn("rev=1", map_url)
        self.assertEqual(status, 200)
        self.assertEqual(parts_of(server.data, flight_id), ["files", "r1"])
        # Photos that come later wait for the next map.
        server.put(flight_id, [("late.jpg", self.photos[0][1])])
        time.sleep(1)
        self.assertIsNone(server.json("GET", f"/api/v1/flights/{flight_id}")[1]["preview"])

    def test_no_answer_mixes_preview_and_map(self):
        server = self.serve()
        flight_id = server.new_flight(self.photos)
        self.wait_for_preview(server, flight_id, len(self.photos))
        _, job = server.json("POST", f"/api/v1/flights/{flight_id}/jobs", {})
        kinds = []
        while True:
            _, tilejson = server.json("GET", f"/tiles/{flight_id}.json", code=200)
            is_preview = "rev=preview" in tilejson["tiles"][0]
            self.assertEqual(tilejson["version"].startswith("0."), is_preview)
            kinds.append(is_preview)
            if not is_preview:
                break
        self.assertIn(True, kinds)
        server.ended(job["id"])

    def test_what_is_no_photo_or_has_no_place_is_passed_over(self):
        scratch = pathlib.Path(self.data, "..", "unplaced").resolve()
        run("simulate", "-o", str(scratch), "--photos", "2", "--size", "640x480", "--no-world", "--noise", "no-gps")
        unplaced = [(f"unplaced_{name}", content) for name, content in photos_in(scratch / "photos")]
        server = self.serve()
        name, content = self.photos[0]
        flight = server.new_flight([("notes.jpg", b"no picture"), ("cut.jpg", content[: len(content) // 20]),
                                    ("log.csv", b"a,b\n1,2\n"), *unplaced])
        time.sleep(1.5)
        self.assertIsNone(server.json("GET", f"/api/v1/flights/{flight}")[1]["preview"])
        server.put(flight, [(name, content)])
        self.wait_for_preview(server, flight, 1)

    def test_a_photo_taken_out_is_taken_out_of_the_preview(self):
        server = self.serve()
        flight = server.new_flight(self.photos[:4])
        four = self.wait_for_preview(server, flight, 4)
        self.assertEqual(server.request("DELETE", f"/api/v1/flights/{flight}/files/{self.photos[0][0]}")[0], 204)
        self.assertNotEqual(four["bounds"], self.wait_for_preview(server, flight, 3)["bounds"])

    def test_a_server_without_workers_draws_where_it_is_told_to(self):
        server = self.serve("--workers", "0", "--previews")
        self.wait_for_preview(server, server.new_flight(self.photos[:2]), 2)

    def test_it_goes_on_where_it_was_after_a_kill(self):
        server = self.serve()
        flight = server.new_flight(self.photos[:3])
        self.wait_for_preview(server, flight, 3)
        server.kill()
        server = self.serve()
        server.put(flight, self.photos[3:])
        self.wait_for_preview(server, flight, len(self.photos))
        self.assertEqual(self.middle_tile(server, f"/tiles/{flight}.json")[1][0], 200)

    def test_a_worker_that_works_once_ends_where_the_catalogue_says_nothing(self):
        server = self.serve("--no-previews", "--workers", "0")
        server.new_flight(self.photos[:1])
        self.assertEqual(server.stop(), 0)
        for table, words in (("preview", ("--previews", "--once")), ("unit", ("--once",))):
            in_catalogue(self.data, f"DROP TABLE {table}")
            said = run("worker", "--data", self.data, *storage_words(self.data), *words, code=1, timeout=120)
            self.assertIn("skyquilt worker: ", said.stderr)
        # One that stays until the queue is empty waits half a minute for the catalogue, and then says so too.
        said = run("worker", "--data", self.data, *storage_words(self.data), "--until-empty", code=1, timeout=240)
        self.assertIn("skyquilt worker: ", said.stderr)
