"""Killed workers and servers: after a restart the job ends well, nothing is published twice, nothing is left over."""
import os
import signal
import socket
import sqlite3

from server_support import POSTGRES, ServerTestCase, kept_of_flights, limits_of, open_files_of, parts_of, wait_until


class Kills(ServerTestCase):
    def wait_for_stage(self, server, job_id):
        """Until a worker is in the middle of the job (or, on a quick machine, through with it)."""
        return server.wait_for_job(job_id, until=lambda job: job["stage"] != "" or job["finished_at"])

    def check_ended_well(self, server, flight_id, job_id):
        job = server.ended(job_id)
        _, flight = server.json("GET", f"/api/v1/flights/{flight_id}")
        self.assertEqual(flight["state"], "ready")
        server.json("GET", flight["tilejson"], code=200)
        wait_until(lambda: server.garbage() == [], f"left over: {server.garbage()}")
        self.assertEqual(server.stop(), 0)
        self.assertEqual(parts_of(server.data, flight_id), ["files", f"r{flight['revision']}"])
        if POSTGRES is None:
            with sqlite3.connect(server.data / "catalogue.db") as catalogue:
                self.assertEqual(catalogue.execute("PRAGMA quick_check").fetchall(), [("ok",)])
        return job

    def test_a_killed_worker_is_replaced_and_its_job_done_again(self):
        server = self.serve()
        flight_id, job_id = server.begun(self.photos)
        self.wait_for_stage(server, job_id)
        for pid in server.workers():
            self.assertEqual(limits_of(pid)["Max core file size"], "0")
            # A worker that held the server's port would keep it from the next server for as long as it lives.
            if POSTGRES is None:  # else it has sockets of its own
                self.assertEqual([held for held in open_files_of(pid) if held.startswith("socket:")], [])
            os.kill(pid, signal.SIGKILL)
        self.assertLessEqual(self.check_ended_well(server, flight_id, job_id)["attempts"], 2)

    def test_a_killed_server_takes_its_job_up_again(self):
        server = self.serve()
        flight_id, job_id = server.begun(self.photos)
        self.wait_for_stage(server, job_id)
        server.kill()
        self.check_ended_well(self.serve(), flight_id, job_id)

    def test_a_stopped_server_gives_its_job_back(self):
        server = self.serve()
        flight_id, job_id = server.begun(self.photos)
        self.wait_for_stage(server, job_id)
        self.assertEqual(server.stop(), 0)
        self.check_ended_well(self.serve(), flight_id, job_id)

    def test_a_server_whose_starter_ignores_the_ends_of_processes_sees_those_of_its_own(self):
        before = signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # inherited
        try:
            server = self.serve("--workers", "1")
        finally:
            signal.signal(signal.SIGCHLD, before)
        for _ in range(2):  # a worker makes one map, and another is started when it has ended
            server.ended(server.begun(self.photos)[1])
        self.assertEqual(server.stop(), 0)

    def test_a_job_waits_for_a_worker_across_restarts(self):
        server = self.serve("--workers", "0")
        flight_id, job_id = server.begun(self.photos)
        server.kill()
        self.check_ended_well(self.serve(), flight_id, job_id)

    def test_an_upload_cut_by_a_killed_server_leaves_nothing(self):
        server = self.serve()
        _, flight = server.json("POST", "/api/v1/flights", {})
        with socket.create_connection(("127.0.0.1", server.port)) as client:
            client.sendall((f"PUT /api/v1/flights/{flight['id']}/files/a.jpg HTTP/1.1\r\nHost: localhost\r\n"
                            "Content-Length: 1000000\r\n\r\n" + "x" * 500000).encode())
            wait_until(lambda: any((server.data / "incoming").iterdir()), "the upload never began")
            server.kill()
        again = self.serve()
        self.assertEqual(again.garbage(), [])
        self.assertEqual(again.json("GET", f"/api/v1/flights/{flight['id']}/files")[1]["files"], [])

    def test_a_cancelled_job_is_dismissed(self):
        server = self.serve()
        _, job_id = server.begun(self.photos)
        server.json("DELETE", f"/api/v1/jobs/{job_id}", code=200)
        server.ended(job_id, "dismissed")
        wait_until(lambda: server.garbage() == [], "the work of a cancelled job is left over")

    def test_a_deleted_flight_stops_its_job(self):
        server = self.serve()
        flight_id, job_id = server.begun(self.photos)
        self.wait_for_stage(server, job_id)
        self.assertEqual(server.request("DELETE", f"/api/v1/flights/{flight_id}")[0], 204)
        wait_until(lambda: server.garbage() == [], "the work of a deleted flight is left over")
        self.assertEqual(server.request("DELETE", f"/api/v1/trash/{flight_id}")[0], 204)
        self.assertEqual(kept_of_flights(server.data), {})

    def test_two_servers_do_not_share_a_folder(self):
        self.serve()
        self.assertIn("Another server", self.refusal("--listen", "127.0.0.1:0"))
