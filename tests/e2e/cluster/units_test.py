"""A flight that is cut into units, by one worker, by three, and by three that are killed and stopped: the same map, published
once, nothing left over; cancelled in the middle of it: nothing goes on."""
import hashlib
import json
import os
import pathlib
import random
import shutil
import signal
import subprocess
import tempfile
import time
import unittest

import s3_store
from postgres_server import find_binaries, server_for
from program import BINARY, ScratchCase, run
from server_support import Server, children_of, kill_if_there, photos_in, wait_until

PHOTOS = 24
CUT = ("--cut-above", "10", "--part-files", "5")
KILLS = int(os.environ.get("SKYQUILT_UNIT_KILLS", "4"))
SEED = int(os.environ.get("SKYQUILT_UNIT_SEED", "1"))


class UnitsTest(ScratchCase):
    catalogue = ()  # words for servers and workers

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        run("simulate", "-o", cls.scratch / "sim", "--photos", str(PHOTOS), "--size", "800x600", "--no-world")
        cls.photos = photos_in(cls.scratch / "sim/photos")

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory(prefix="data_", dir=self.scratch)
        self.server = Server(self.folder.name, "--workers", "0", *self.catalogue)
        self.workers = []

    def tearDown(self):
        for worker in self.workers:
            worker.kill()
            worker.wait()
        self.server.stop()
        self.folder.cleanup()

    def start_worker(self, *arguments):
        log = open(f"{self.folder.name}.log", "a")
        worker = subprocess.Popen([BINARY, "worker", "--data", self.folder_of_worker(), *self.catalogue, *arguments], stderr=log, stdout=log)
        log.close()
        self.workers.append(worker)
        return worker

    def kill_and_replace(self, worker):
        """As its machine would go, and another come."""
        for child in children_of(worker.pid):
            kill_if_there(child)
        worker.kill()
        worker.wait()
        self.workers.remove(worker)
        self.start_worker(*CUT)

    def folder_of_worker(self):
        return self.folder.name

    def errors(self):
        return pathlib.Path(f"{self.folder.name}.log").read_text()

    def upload(self):
        return self.server.begun(self.photos, name="field")

    def map_of(self, flight):
        answers = {}
        for name in ("mbtiles", "pmtiles", "tif"):
            _, _, content = self.server.request("GET", f"/api/v1/flights/{flight}/download.{name}", code=200)
            answers[f"mosaic.{name}"] = hashlib.sha256(content).hexdigest()
        return answers

    def stitched(self, workers, *arguments):
        flight, job = self.upload()
        for _ in range(workers):
            self.start_worker(*arguments)
        ended = self.server.wait_for_job(job)
        self.assertEqual(ended["state"], "successful", (ended, self.errors()))
        return self.map_of(flight)

    def test_any_number_of_workers_makes_the_map_of_one(self):
        # The reference: one process, not cut.
        whole = self.stitched(1, "--cut-above", "0")
        self.assertNotIn("waits for its parts", self.errors())
        for worker in self.workers:
            worker.terminate()
            worker.wait()
        for workers in (1, 3):
            with self.subTest(workers=workers):
                pathlib.Path(f"{self.folder.name}.log").write_text("")
                self.assertEqual(self.stitched(workers, *CUT), whole)
                self.assertEqual(self.errors().count("waits for its parts"), 2, self.errors())
                self.assertIn("look 5 of 5", self.errors())
                self.assertIn("render 3 of 3", self.errors())
        wait_until(lambda: not self.server.garbage(), "something was left over")

    def test_progress_only_grows(self):
        _, job = self.upload()
        self.start_worker(*CUT)
        seen = []
        self.server.wait_for_job(job, lambda answer: seen.append((answer["progress"], answer["state"])) or answer["finished_at"])
        self.assertEqual(seen, sorted(seen, key=lambda entry: entry[0]))
        self.assertEqual({state for _, state in seen[1:-1]} - {"accepted", "running"}, set())
        self.assertEqual(seen[-1], (1, "successful"))

    def test_workers_that_die_or_stop_cost_time_alone(self):
        dice = random.Random(SEED)
        undisturbed = self.stitched(1, "--cut-above", "0")
        first = self.workers.pop()
        first.terminate()
        first.wait()
        flight, job = self.upload()
        for _ in range(3):
            self.start_worker(*CUT)
        stopped = []
        for kill in range(KILLS):
            time.sleep(dice.uniform(0.2, 1.2))
            worker = dice.choice(self.workers)
            if kill % 4 == 3 and worker not in stopped:
                worker.send_signal(signal.SIGSTOP)
                stopped.append(worker)
                self.start_worker(*CUT)
                continue
            self.kill_and_replace(worker)
        ended = self.server.wait_for_job(job)
        for worker in stopped:
            if worker in self.workers:
                worker.send_signal(signal.SIGCONT)
        self.assertEqual(ended["state"], "successful", (ended, self.errors()))
        self.assertEqual(self.map_of(flight), undisturbed)
        self.assertEqual(self.errors().count(f"job {job} is published"), 1)

    def test_the_next_job_goes_on_with_what_one_that_failed_had_made(self):
        whole = self.stitched(1, "--cut-above", "0")
        self.workers.pop().kill()
        flight, job = self.upload()

        def state():
            return self.server.json("GET", f"/api/v1/jobs/{job}")[1]["state"]
        once = ("--once", *CUT)
        for _ in range(6):  # it is cut, and its five parts are looked at
            self.assertEqual(self.start_worker(*once).wait(timeout=120), 0, self.errors())
        self.assertIn("look 5 of 5 begins", self.errors())
        # Placing dies for want of memory as often as it may.
        wait_until(lambda: self.start_worker(*once, "--job-memory", "1").wait(timeout=120) is not None and state() == "failed",
                   f"it does not fail: {self.errors()}")
        pathlib.Path(f"{self.folder.name}.log").write_text("")
        _, again = self.server.json("POST", f"/api/v1/flights/{flight}/jobs", {}, code=202)
        self.start_worker(*CUT)
        ended = self.server.wait_for_job(again["id"])
        self.assertEqual(ended["state"], "successful", (ended, self.errors()))
        self.assertIn("5 of 5 parts", self.errors())
        self.assertNotIn(": look ", self.errors())
        self.assertEqual(self.map_of(flight), whole)
        wait_until(lambda: not list(pathlib.Path(self.folder.name, "work").glob("*-units")), "parts stay")

    def test_cancelling_ends_what_is_at_work(self):
        _, job = self.upload()
        self.start_worker(*CUT)
        self.start_worker(*CUT)
        self.server.wait_for_job(job, lambda answer: answer["state"] == "running")
        self.server.json("DELETE", f"/api/v1/jobs/{job}", code=200)
        self.server.ended(job, "dismissed")
        wait_until(lambda: not any(children_of(worker.pid) for worker in self.workers), "a unit went on")
        # Whoever is started next has nothing to do.
        self.assertEqual(self.start_worker(*CUT, "--until-empty").wait(timeout=60), 0)


@unittest.skipIf(find_binaries() is None, "PostgreSQL is not installed")
class SharedCatalogueTest(UnitsTest):
    """The same over a catalogue in PostgreSQL."""

    schemas = 0

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.postgres = server_for(cls)

    def setUp(self):
        SharedCatalogueTest.schemas += 1
        self.catalogue = ("--catalogue", f"{self.postgres.url}&schema=units{self.schemas}")
        super().setUp()


class MachinesTest(SharedCatalogueTest):
    """Catalogue in PostgreSQL, photos and maps in S3: each worker, and a second server, has a folder of its own."""

    @classmethod
    def setUpClass(cls):
        cls.store = s3_store.store_for(cls)
        super().setUpClass()

    def setUp(self):
        SharedCatalogueTest.schemas += 1
        prefix = f"machines{self.schemas}"
        self.catalogue = ("--catalogue", f"{self.postgres.url}&schema={prefix}", "--blobs", self.store.address(prefix))
        UnitsTest.setUp(self)
        self.prefix = prefix
        self.folders = 0

    def folder_of_worker(self):
        self.folders += 1
        return f"{self.folder.name}-worker-{self.folders}"

    def test_a_second_server_shows_what_the_first_took(self):
        flight, job = self.upload()
        with Server(self.folder_of_worker(), "--workers", "0", *self.catalogue) as second:
            self.start_worker(*CUT)
            second.ended(job)
            _, _, content = second.request("GET", f"/api/v1/flights/{flight}/download.pmtiles", code=200)
            self.assertEqual(hashlib.sha256(content).hexdigest(), self.map_of(flight)["mosaic.pmtiles"])
            self.assertEqual(second.json("GET", f"/tiles/{flight}.json")[1], self.tilejson_of_first(flight, second))
            # What the parts of the flight left is gone, here and there.
            wait_until(lambda: not [key for key in self.store.keys(f"{self.prefix}/flights/") if "/units-" in key],
                       "parts stay in the store")

    def test_a_machine_in_trouble_costs_no_attempt_and_is_seen(self):
        broken = self.folder_of_worker()
        run("worker", "--data", broken, "--until-empty", *self.catalogue)
        work = pathlib.Path(broken, "work")
        shutil.rmtree(work)
        work.write_text("nothing can be written below this")
        flight, job = self.upload()
        log = open(f"{self.folder.name}.log", "a")
        self.workers.append(subprocess.Popen([BINARY, "worker", "--name", "broken", "--data", broken, *self.catalogue, *CUT],
                                             stderr=log, stdout=log))
        log.close()

        def metrics():
            return self.server.request("GET", "/metrics")[2].decode()
        wait_until(lambda: 'skyquilt_worker_aside_times{worker="broken"' in metrics(), f"it is not seen: {self.errors()}")
        self.start_worker(*CUT)
        ended = self.server.wait_for_job(job)
        self.assertEqual((ended["state"], ended["attempts"]), ("successful", 1), self.errors())
        self.map_of(flight)

    def tilejson_of_first(self, flight, second):
        _, tilejson = self.server.json("GET", f"/tiles/{flight}.json")
        return json.loads(json.dumps(tilejson).replace(f":{self.server.port}/", f":{second.port}/"))
