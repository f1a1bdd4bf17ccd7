"""One flight over several machines while everything fails that can: workers are killed and stopped, PostgreSQL crashes, the store
answers 500 and 503 or not at all, and the network is cut. The map is that of an undisturbed run, published once, and the
sweep leaves nothing of the attempts.

SKYQUILT_FAULT_SEEDS (default 1) says how many runs, SKYQUILT_FAULT_SEED where they begin.
"""
import os
import pathlib
import random
import signal
import sys
import threading
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import s3_store
from cluster import units_test
from cluster.store_proxy import StoreProxy
from server_support import Server, wait_until

SEEDS = int(os.environ.get("SKYQUILT_FAULT_SEEDS", "1"))
FIRST_SEED = int(os.environ.get("SKYQUILT_FAULT_SEED", "1"))
MACHINES = 3
CUT_S = 20
DAYS_S = 2 * 86400


class Faults(threading.Thread):
    """One fault after the other until the job has ended."""

    def __init__(self, test, seed):
        super().__init__(daemon=True)
        self.test, self.dice, self.is_over, self.done, self.failure = test, random.Random(seed), threading.Event(), [], None

    def run(self):
        try:
            # Of the rare ones each comes once, the others fill the time between.
            kinds = [self.kill, self.stop_one, self.crash_database, self.kill, self.cut_network]
            self.dice.shuffle(kinds)
            for kind in kinds:
                if self.is_over.wait(self.dice.uniform(0.3, 2.5)):
                    return
                kind()
                self.done.append(kind.__name__)
        except Exception as failure:  # shown by the test
            self.failure = failure

    def kill(self):
        self.test.kill_and_replace(self.dice.choice(self.test.workers))

    def stop_one(self):
        worker = self.dice.choice(self.test.workers)
        worker.send_signal(signal.SIGSTOP)
        self.test.stopped.append(worker)
        self.test.start_worker(*units_test.CUT)

    def crash_database(self):
        self.test.postgres.stop(signal.SIGQUIT)
        self.test.postgres.start()

    def cut_network(self):
        """Neither the database nor the store is heard of."""
        self.test.proxy.is_cut.set()
        self.test.postgres.stop(signal.SIGQUIT)
        time.sleep(CUT_S)
        self.test.postgres.start()
        self.test.proxy.is_cut.clear()


@unittest.skipIf(units_test.find_binaries() is None, "PostgreSQL is not installed")
class FaultsTest(units_test.UnitsTest):
    @classmethod
    def setUpClass(cls):
        cls.store = s3_store.store_for(cls)
        super().setUpClass()
        cls.postgres = units_test.server_for(cls)
        cls.runs = 0

    def setUp(self):
        self.proxy = StoreProxy(self.store.port, s3_store.KEY, stall_s=15, seed=FIRST_SEED)
        os.environ.update(self.store.environment(self.proxy.endpoint))
        self.addCleanup(self.proxy.stop)
        self.stopped = []
        self.begin()

    def begin(self):
        FaultsTest.runs += 1
        self.prefix = f"faults{self.runs}"
        self.catalogue = ("--catalogue", f"{self.postgres.url}&schema={self.prefix}", "--blobs", self.store.address(self.prefix))
        self.folders = 0
        super().setUp()

    def folder_of_worker(self):
        self.folders += 1
        return f"{self.folder.name}-worker-{self.folders}"

    def end_workers(self):
        for worker in {*self.workers, *self.stopped}:
            worker.kill()
            worker.wait()
        self.workers, self.stopped = [], []

    def wait(self, job):
        """The job when it has ended; while the database is away the server says so, and is asked again."""
        answers = {}

        def has_ended():
            status, answers["job"] = self.server.json("GET", f"/api/v1/jobs/{job}")
            self.assertIn(status, (200, 503), answers)
            return status == 200 and answers["job"]["finished_at"]
        wait_until(has_ended, f"the job did not end: {answers}")
        return answers["job"]

    def keys(self):
        return self.store.keys(f"{self.prefix}/")

    def sweep_after_days(self):
        """As two days later."""
        self.assertEqual(self.server.stop(), 0)
        long_ago = time.time() - DAYS_S
        for path in self.store.bucket.rglob("*"):
            if path.is_file():
                os.utime(path, (long_ago, long_ago))
        self.server = Server(self.folder.name, "--workers", "0", *self.catalogue)

    def check_seed(self, seed, undisturbed):
        flight, job = self.upload()
        self.proxy.random, self.proxy.fails, self.proxy.stalls = random.Random(seed), 0.05, 0.01
        for _ in range(MACHINES):
            self.start_worker(*units_test.CUT)
        faults = Faults(self, seed)
        faults.start()
        ended = self.wait(job)
        faults.is_over.set()
        faults.join()
        self.proxy.fails = self.proxy.stalls = 0.0
        print(f"seed {seed}: {' '.join(faults.done)}, {self.proxy.faults} faults of the store, job {ended['state']}", flush=True)
        self.assertIsNone(faults.failure)
        self.assertEqual(ended["state"], "successful", (ended, self.errors()))
        self.assertEqual(self.map_of(flight), undisturbed)
        self.assertEqual(self.errors().count(f"job {job} is published"), 1)
        for worker in self.stopped:  # who wakes up late finds that others did its work
            worker.send_signal(signal.SIGCONT)
        time.sleep(1)
        self.end_workers()
        self.assertEqual(self.server.json("GET", f"/api/v1/flights/{flight}")[1]["revision"], 1)
        self.sweep_after_days()
        of_flights = [key for key in self.keys() if f"/flights/{flight}/" in key]
        shown = [key for key in of_flights if key.split("/")[3] in ("files", "r1")]
        wait_until(lambda: [key for key in self.keys() if "/flights/" in key and key.split("/")[3] not in ("files", "r1")] == [],
                   "the sweep left parts")
        self.assertEqual(len([key for key in shown if key.split("/")[3] == "files"]), len(self.photos))
        self.assertEqual([key for key in self.keys() if "/lost/" in key or "/deleted/" in key], [])
        self.assertEqual(self.map_of(flight), undisturbed)

    def test_nothing_that_fails_changes_the_map(self):
        undisturbed = self.stitched(1, "--cut-above", "0")
        self.end_workers()
        for seed in range(FIRST_SEED, FIRST_SEED + SEEDS):
            with self.subTest(seed=seed):
                self.server.stop()
                self.begin()
                self.check_seed(seed, undisturbed)


# Those of units_test run there.
for inherited in [name for name in dir(units_test.UnitsTest) if name.startswith("test_")]:
    setattr(FaultsTest, inherited, None)

if __name__ == "__main__":
    unittest.main(defaultTest="FaultsTest")
