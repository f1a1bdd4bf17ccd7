"""What wears a server out: a full disk, maps replaced under load, slow connections."""
import http.client
import os
import pathlib
import socket
import subprocess
import tempfile
import threading

from server_support import ServerTestCase, fill_disk, middle_of, path_of, wait_until

REPLACEMENTS = int(os.environ.get("SKYQUILT_REPLACEMENTS", "4"))  # more for a night


class Endurance(ServerTestCase):
    def test_a_full_disk_is_said_and_a_later_try_succeeds(self):
        folder = tempfile.mkdtemp(dir=self.scratch)
        mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=80m", "tmpfs", folder], capture_output=True)
        if mounted.returncode != 0:
            self.skipTest("mounting a small disk needs root")
        try:
            server = self.serve(data=folder)
            filler = pathlib.Path(folder, "filler")
            filler.write_bytes(bytes(30 << 20))  # what is left is hardly more than the server keeps free
            flight = server.new_flight()
            files = f"/api/v1/flights/{flight}/files"
            self.assertIn(b"disk", server.request("PUT", f"{files}/big.jpg", bytes(40 << 20), code=507)[2])
            self.assertEqual(server.garbage(), [])
            server.put(flight, self.photos)
            # Full to the last page: the job fails with a reason, or waits for room.
            fill_disk(pathlib.Path(folder, "rest"))
            status, job = server.json("POST", f"/api/v1/flights/{flight}/jobs", {})
            if status == 202:
                job = server.wait_for_job(job["id"], until=lambda job: job["finished_at"] or job["attempts"] >= 2)
                self.assertNotEqual(job["state"], "successful")
            else:
                self.assertEqual(status, 507, job)
            filler.unlink()
            pathlib.Path(folder, "rest").unlink()
            status, again = server.json("POST", f"/api/v1/flights/{flight}/jobs", {})
            job_id = again["id"] if status == 202 else job["id"]  # or the first is still trying
            server.ended(job_id)
            self.assertEqual(server.stop(), 0)
        finally:
            subprocess.run(["umount", "-l", folder], check=True)

    def test_a_map_replaced_under_load_never_fails_nor_mixes(self):
        server = self.serve()
        flight_id = server.stitched(self.photos, options='{"gsd_m": 0.4}')["flight"]["id"]
        _, tilejson = server.json("GET", f"/tiles/{flight_id}.json")
        zoom = tilejson["maxzoom"]
        x, y = middle_of(tilejson["bounds"], zoom)
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
            server.remade(flight_id, {"gsd_m": 0.4, "quality": 50 + replacement % 40})
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
