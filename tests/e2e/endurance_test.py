"""What wears a server out: kills at random points, a full disk, maps replaced under load, slow connections."""
import base64
import http.client
import os
import pathlib
import random
import signal
import socket
import sqlite3
import subprocess
import tempfile
import threading
import time
import unittest

from server_support import BINARY, Server, ServerTestCase, path_of, tile_of, wait_until

# More of both for a night.
ROUNDS = int(os.environ.get("SKYQUILT_KILL_ROUNDS", "6"))
REPLACEMENTS = int(os.environ.get("SKYQUILT_REPLACEMENTS", "4"))


class Endurance(ServerTestCase):
    def test_kills_at_random_points_lose_nothing_and_publish_once(self):
        dice = random.Random(2026)
        server = self.serve()
        status, made = server.upload(self.photos)
        self.assertEqual(status, 202)
        flight_id, job_id, maps = made["flight"]["id"], made["job"]["id"], 0
        content = random.Random(1).randbytes(600_000)
        encoded = lambda text: base64.b64encode(text.encode()).decode()
        version = {"Tus-Resumable": "1.0.0"}
        _, other = server.json("POST", "/api/v1/flights", {})
        _, headers, _ = server.request("POST", "/api/v1/uploads", headers={
            **version, "Upload-Length": str(len(content)),
            "Upload-Metadata": f"flight {encoded(other['id'])},filename {encoded('a.jpg')}"})
        place = headers["Location"]
        for number in range(ROUNDS):
            offset = int(server.request("HEAD", place, headers=version)[1]["Upload-Offset"])
            end = min(len(content) - 1, offset + dice.randrange(1, 150_000))  # the last byte waits for the end
            with socket.create_connection(("127.0.0.1", server.port)) as client:
                client.sendall((f"PATCH {place} HTTP/1.1\r\nHost: localhost\r\nTus-Resumable: 1.0.0\r\nUpload-Offset: {offset}\r\n"
                                f"Content-Type: application/offset+octet-stream\r\nContent-Length: {end - offset}\r\n\r\n").encode())
                client.sendall(content[offset:end])
                time.sleep(dice.random() * dice.choice((0.6, 0.6, 3.0)))  # early, and as far as the map is shown
            for pid in server.workers():
                if dice.random() < 0.3:
                    os.kill(pid, signal.SIGKILL)
            server.kill()
            server = self.serve()
            # A kill meets a job every time; three dead workers fail one, that is the rule.
            ended = server.json("GET", f"/api/v1/jobs/{job_id}")[1]["state"]
            maps += ended == "successful"
            if ended in ("successful", "failed"):
                status, job = server.json("POST", f"/api/v1/flights/{flight_id}/jobs", {"options": {"quality": 50 + number % 40}})
                self.assertEqual(status, 202, job)
                job_id = job["id"]
        offset = int(server.request("HEAD", place, headers=version)[1]["Upload-Offset"])
        status, _, _ = server.request("PATCH", place, content[offset:], {
            **version, "Upload-Offset": str(offset), "Content-Type": "application/offset+octet-stream"})
        self.assertEqual(status, 204)
        [stored] = (server.data / "flights" / other["id"] / "files").iterdir()
        self.assertEqual(stored.read_bytes(), content)
        job = server.wait_for_job(job_id)
        if job["state"] == "failed":
            _, job = server.json("POST", f"/api/v1/flights/{flight_id}/jobs", {})
            job = server.wait_for_job(job["id"])
        self.assertEqual(job["state"], "successful", server.errors())
        wait_until(lambda: server.garbage() == [], f"left over: {server.garbage()}")
        _, flight = server.json("GET", f"/api/v1/flights/{flight_id}")
        self.assertEqual(server.stop(), 0)
        folders = sorted(path.name for path in (server.data / "flights" / flight_id).iterdir())
        self.assertEqual(flight["revision"], maps + 1)  # each job's map was published once
        self.assertIn(f"r{flight['revision']}", folders)
        self.assertLessEqual(len(folders), 4)  # the record, the files, this map, and perhaps the one before
        with sqlite3.connect(server.data / "catalogue.db") as catalogue:
            self.assertEqual(catalogue.execute("PRAGMA quick_check").fetchall(), [("ok",)])
            self.assertEqual(catalogue.execute("SELECT max(revision) FROM revision").fetchall(), [(maps + 1,)])

    def test_a_full_disk_is_said_and_a_later_try_succeeds(self):
        folder = tempfile.mkdtemp(dir=self.scratch)
        mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=80m", "tmpfs", folder], capture_output=True)
        if mounted.returncode != 0:
            self.skipTest("mounting a small disk needs root")
        try:
            server = Server(folder)
            self.servers.append(server)
            filler = pathlib.Path(folder, "filler")
            filler.write_bytes(bytes(30 << 20))  # what is left is hardly more than the server keeps free
            _, flight = server.json("POST", "/api/v1/flights", {})
            files = f"/api/v1/flights/{flight['id']}/files"
            status, _, body = server.request("PUT", f"{files}/big.jpg", bytes(40 << 20))
            self.assertEqual((status, b"disk" in body), (507, True))
            self.assertEqual(server.garbage(), [])
            for name, content in self.photos:
                self.assertEqual(server.request("PUT", f"{files}/{name}", content)[0], 201)
            # Full to the last page: the job fails with a reason, or waits for room.
            with pathlib.Path(folder, "rest").open("wb") as rest:
                try:
                    while True:
                        rest.write(bytes(1 << 16))
                        rest.flush()
                except OSError:
                    pass
            status, job = server.json("POST", f"/api/v1/flights/{flight['id']}/jobs", {})
            if status == 202:
                job = server.wait_for_job(job["id"], until=lambda job: job["finished_at"] or job["attempts"] >= 2)
                self.assertNotEqual(job["state"], "successful")
            else:
                self.assertEqual(status, 507, job)
            filler.unlink()
            pathlib.Path(folder, "rest").unlink()
            status, again = server.json("POST", f"/api/v1/flights/{flight['id']}/jobs", {})
            job_id = again["id"] if status == 202 else job["id"]  # or the first is still trying
            self.assertEqual(server.wait_for_job(job_id)["state"], "successful", server.errors())
            self.assertEqual(server.stop(), 0)
        finally:
            subprocess.run(["umount", "-l", folder], check=True)

    def test_a_map_replaced_under_load_never_fails_nor_mixes(self):
        server = self.serve()
        _, made = server.upload(self.photos, options='{"gsd_m": 0.4}')
        self.assertEqual(server.wait_for_job(made["job"]["id"])["state"], "successful")
        flight_id = made["flight"]["id"]
        _, tilejson = server.json("GET", f"/tiles/{flight_id}.json")
        west, south, east, north = tilejson["bounds"]
        zoom = tilejson["maxzoom"]
        x, y = tile_of((west + east) / 2, (south + north) / 2, zoom)
        wrong, asked, done = [], [0], threading.Event()

        def load():
            while not done.is_set():
                try:
                    status, got = server.json("GET", f"/tiles/{flight_id}.json")
                    tile = path_of(got["tiles"][0].format(z=zoom, x=x, y=y))
                    answers = [server.request("GET", tile) for _ in range(4)]
                except OSError as error:
                    if not done.is_set():
                        wrong.append(repr(error))
                    continue
                asked[0] += 5
                if status != 200 or any(answer[0] != 200 for answer in answers):
                    wrong.append((status, [answer[0] for answer in answers]))
                # One address, one picture: what says it is immutable never changes.
                fixed = {answer[2] for answer in answers if "immutable" in answer[1]["Cache-Control"]}
                if len(fixed) > 1:
                    wrong.append("two pictures at one immutable address")
        threads = [threading.Thread(target=load) for _ in range(4)]
        for thread in threads:
            thread.start()
        for replacement in range(REPLACEMENTS):
            _, job = server.json("POST", f"/api/v1/flights/{flight_id}/jobs", {"options": {"gsd_m": 0.4, "quality": 50 + replacement % 40}})
            self.assertEqual(server.wait_for_job(job["id"])["state"], "successful")
        done.set()
        for thread in threads:
            thread.join()
        self.assertEqual(wrong, [])
        self.assertGreater(asked[0], 100)
        self.assertEqual(server.json("GET", f"/api/v1/flights/{flight_id}")[1]["revision"], 1 + REPLACEMENTS)

    def test_a_stop_under_load_cuts_no_answer_short(self):
        server = self.serve("--workers", "0")
        failed, answered = [], [0]

        def load():
            connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=60)
            while True:
                try:
                    connection.request("GET", "/openapi.json")
                    response = connection.getresponse()
                except (ConnectionError, http.client.RemoteDisconnected, http.client.CannotSendRequest):
                    return  # the server let go of the connection between two answers
                try:
                    body = response.read()
                except http.client.IncompleteRead as cut:
                    failed.append(repr(cut))
                    return
                if response.status != 200 or len(body) != int(response.headers["Content-Length"]):
                    failed.append((response.status, len(body)))
                answered[0] += 1
        threads = [threading.Thread(target=load) for _ in range(16)]
        for thread in threads:
            thread.start()
        wait_until(lambda: answered[0] > 200, "the load does not get through")
        self.assertEqual(server.stop(), 0)
        for thread in threads:
            thread.join()
        self.assertEqual(failed, [])

    def test_a_thousand_slow_connections_hinder_nobody(self):
        server = self.serve("--workers", "0")
        slow = []
        try:
            for _ in range(1000):
                client = socket.create_connection(("127.0.0.1", server.port))
                client.sendall(b"GET /healthz HTTP/1.1\r\nHost: ")
                slow.append(client)
            for _ in range(50):
                self.assertEqual(server.request("GET", "/healthz")[0], 200)
            # Each is told that it is late, and let go.
            for client in slow:
                client.settimeout(60)
                self.assertIn(b" 408 ", client.recv(4096))
        finally:
            for client in slow:
                client.close()

    def test_a_job_cancelled_in_the_middle_does_not_go_on_to_its_end(self):
        server = self.serve()
        _, made = server.upload(self.photos * 3)
        job_id = made["job"]["id"]
        server.wait_for_job(job_id, until=lambda job: job["stage"] in ("align", "render") or job["finished_at"])
        status, _ = server.json("DELETE", f"/api/v1/jobs/{job_id}")
        if status == 409:
            self.skipTest("the job was quicker than its cancellation")
        self.assertEqual(server.wait_for_job(job_id)["state"], "dismissed")
        wait_until(lambda: server.garbage() == [], "the work of a cancelled job is left over")


if __name__ == "__main__":
    unittest.main(verbosity=2)
