"""A server and workers of their own on one catalogue in PostgreSQL: upload, job, tiles; PostgreSQL restarted in the middle;
a worker killed and its job taken by another; a password that nobody shows."""
import http.client
import os
import pathlib
import signal
import tempfile
import time

from cluster.shared_catalogue import NOTHING_TO_DO, SharedCatalogueCase
from program import run
from server_support import children_of, middle_tile, wait_until


class SharedCatalogue(SharedCatalogueCase):
    def test_a_worker_of_its_own_makes_the_map_of_an_upload(self):
        server = self.serve_shared()
        self.work()
        flight_id, job_id = self.upload(server)
        job = server.wait_for_job(job_id)
        self.assertEqual(job["state"], "successful", self.workers[0].errors())
        self.assertEqual(job["attempts"], 1)
        self.check_map(server, flight_id)
        self.assertFalse((pathlib.Path(self.data) / "catalogue.db").exists())
        self.assertEqual(server.stop(), 0)
        # And again, by the server's own workers, after a restart.
        again = self.serve_shared(workers=1)
        again.remade(flight_id)

    def test_once_runs_one_job_and_says_when_there_is_none(self):
        server = self.serve_shared()
        self.assertEqual(self.work("--once").process.wait(timeout=60), NOTHING_TO_DO)
        jobs = [self.upload(server)[1] for _ in range(2)]
        worker = self.work("--once")
        self.assertEqual(worker.process.wait(timeout=240), 0, worker.errors())
        states = sorted(server.json("GET", f"/api/v1/jobs/{job}")[1]["state"] for job in jobs)
        self.assertEqual(states, ["accepted", "successful"])

    def test_a_restart_of_postgresql_ends_nothing(self):
        server = self.serve_shared()
        worker = self.work()
        flight_id, job_id = self.upload(server)
        server.wait_for_job(job_id, until=lambda job: job["stage"] != "")
        self.postgres.stop(signal.SIGQUIT)  # as a crash
        server.json("GET", "/api/v1/flights", code=503)
        self.assertNotIn("FATAL", str(server.upload(self.photos, code=503)[1]))
        time.sleep(3)
        self.postgres.start()
        wait_until(lambda: server.json("GET", "/api/v1/flights")[0] == 200, "the server did not come back: " + server.errors())
        job = server.wait_for_job(job_id)
        self.assertEqual(job["state"], "successful", worker.errors())
        self.assertEqual(job["attempts"], 1, worker.errors())
        self.assertIsNone(worker.process.poll())
        self.check_map(server, flight_id)

    def test_a_frozen_database_keeps_hot_tiles_and_is_said_so(self):
        server = self.serve_shared(workers=1)
        flight_id, job_id = self.upload(server)
        server.ended(job_id)
        tile = middle_tile(server.json("GET", f"/tiles/{flight_id}.json")[1])
        sound = server.request("GET", tile)[2]
        frozen = [self.postgres.process.pid, *children_of(self.postgres.process.pid)]
        for pid in frozen:
            os.kill(pid, signal.SIGSTOP)
        try:
            begin = time.monotonic()
            for _ in range(50):
                status, _, content = server.request("GET", tile)
                self.assertEqual((status, content), (200, sound))
            self.assertLess(time.monotonic() - begin, 10)
            begin = time.monotonic()
            self.assertEqual(server.request("GET", "/readyz")[0], 503)
            self.assertLess(time.monotonic() - begin, 5)
            self.assertEqual(server.request("GET", "/healthz")[0], 200)
        finally:
            for pid in reversed(frozen):
                os.kill(pid, signal.SIGCONT)
        wait_until(lambda: server.request("GET", "/readyz")[0] == 200, "the server is not ready again: " + server.errors())
        self.assertEqual(server.request("GET", tile)[2], sound)

    def test_a_worker_that_starts_before_the_database_waits_for_it(self):
        server = self.serve_shared()
        _, job_id = self.upload(server)
        self.postgres.stop()
        worker, stopped = self.work("--once"), self.work()
        for one in (worker, stopped):
            wait_until(lambda: "the worker waits" in one.errors(), "a worker does not wait")
        self.assertEqual(stopped.stop(), 0, stopped.errors())
        self.assertIsNone(worker.process.poll(), worker.errors())
        self.postgres.start()
        self.assertEqual(worker.process.wait(timeout=240), 0, worker.errors())
        wait_until(lambda: server.json("GET", "/api/v1/flights")[0] == 200, "the server did not come back")
        self.assertEqual(server.wait_for_job(job_id)["state"], "successful", worker.errors())

    def test_the_job_of_a_killed_worker_is_anothers(self):
        server = self.serve_shared()
        first = self.work()
        flight_id, job_id = self.upload(server)
        server.wait_for_job(job_id, until=lambda job: job["stage"] != "")
        first.kill()
        self.work()
        self.assertEqual(server.ended(job_id)["attempts"], 2)
        self.check_map(server, flight_id)

    def test_a_restart_of_the_server_leaves_the_jobs_of_others(self):
        server = self.serve_shared()
        self.work()
        flight_id, job_id = self.upload(server)
        server.wait_for_job(job_id, until=lambda job: job["stage"] != "")
        server.kill()
        again = self.serve_shared()
        job = again.wait_for_job(job_id)
        self.assertEqual((job["state"], job["attempts"]), ("successful", 1))
        self.check_map(again, flight_id)

    def test_events_of_another_process_arrive_within_a_second(self):
        server = self.serve_shared()
        _, flight = server.json("POST", "/api/v1/flights", {})
        connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=30)
        connection.request("GET", "/api/v1/events")
        response = connection.getresponse()
        self.assertEqual(response.status, 200)
        time.sleep(1)
        self.query(f"INSERT INTO event(flight_id, kind, body) VALUES('{flight['id']}', 'file', '{{\"name\":\"told\",\"bytes\":1}}')")
        said = time.monotonic()
        while "told" not in (line := response.readline().decode()):
            self.assertNotEqual(line, "")
        self.assertLess(time.monotonic() - said, 1.0)
        connection.close()

    def test_a_folder_with_flights_of_another_catalogue_is_refused_and_repair_moves_it(self):
        local = self.serve("--workers", "1")
        flight_id, job_id = self.upload(local)
        local.wait_for_job(job_id)
        self.assertEqual(local.stop(), 0)
        words = ["--catalogue", self.catalogue]
        self.assertIn("skyquilt data repair", self.refusal(*words))
        run("data", "repair", "--data", self.data, *words)
        shared = self.serve_shared()
        self.check_map(shared, flight_id)
        shared.stop()
        run("data", "check", "--data", self.data, *words)
        # Without the option a second catalogue would be served: the old one, which is still there.
        self.assertIn("is in PostgreSQL", self.refusal())
        self.assertIn("say --catalogue", run("token", "list", "--data", self.data, code=None).stderr)
        # What another folder's catalogue knows is not mixed with a new folder.
        self.data = tempfile.mkdtemp(prefix="data_", dir=self.scratch)
        self.assertIn("another data folder", self.refusal(*words))

    def test_a_password_is_used_and_never_shown(self):
        self.query("CREATE ROLE guarded LOGIN PASSWORD 'open-sesame'; GRANT ALL ON DATABASE skyquilt TO guarded")
        hba = self.postgres.folder / "data" / "pg_hba.conf"
        hba.write_text("local all guarded scram-sha-256\n" + hba.read_text())
        self.postgres.stop()
        self.postgres.start()
        guarded = self.catalogue.replace("skyquilt@", "guarded@") + "_guarded"
        self.assertIn("password", self.refusal("--catalogue", guarded).lower())
        secret = pathlib.Path(self.scratch, "secret")
        secret.write_text("open-sesame\n")
        self.assertNotIn("sesame", self.refusal("--catalogue", guarded.replace("guarded@", "guarded:wrong-sesame@")))
        server = self.serve("--catalogue", guarded, "--catalogue-password-file", str(secret), "--workers", "1")
        flight_id, job_id = self.upload(server)
        seen = set()
        while not (job := server.json("GET", f"/api/v1/jobs/{job_id}")[1])["finished_at"]:
            for worker in children_of(server.process.pid):
                for pid in [worker, *children_of(worker)]:
                    try:
                        line = pathlib.Path(f"/proc/{pid}/cmdline").read_bytes()
                        environment = pathlib.Path(f"/proc/{pid}/environ").read_bytes()
                    except OSError:
                        continue
                    self.assertNotIn(b"sesame", line)
                    if b"\0worker\0" not in line:  # nor one that is still becoming another program
                        seen.add(pid)
                        self.assertNotIn(b"sesame", environment)  # it decodes what others made
        self.assertEqual(job["state"], "successful", server.errors())
        self.assertTrue(seen)
        self.assertNotIn("sesame", server.errors())
