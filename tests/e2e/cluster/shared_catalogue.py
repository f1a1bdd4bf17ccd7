"""What tests of servers and workers on one catalogue in PostgreSQL share. Skipped where it is not installed."""
import subprocess
import tempfile
import unittest

from postgres_server import LATE_WRITER, find_binaries, server_for
from program import BINARY
from server_support import ServerTestCase, children_of, is_running, middle_tile, wait_until

NOTHING_TO_DO = 3


class Worker:
    """`skyquilt worker` as one would start it on another machine."""

    def __init__(self, data, catalogue, *arguments):
        self.log = tempfile.NamedTemporaryFile("w+", suffix=".log")
        self.process = subprocess.Popen([BINARY, "worker", "--data", str(data), "--catalogue", catalogue, *arguments],
                                        stderr=self.log, stdout=self.log, text=True)

    def errors(self):
        self.log.seek(0)
        return self.log.read()

    def kill(self):
        """With the processes that it started, which follow it by themselves."""
        children = children_of(self.process.pid)
        self.process.kill()
        self.process.wait()
        for pid in children:
            wait_until(lambda: not is_running(pid), "a sandboxed process outlived its worker")

    def stop(self):
        if self.process.poll() is None:
            self.process.terminate()
        return self.process.wait(timeout=60)


@unittest.skipIf(find_binaries() is None, "PostgreSQL is not installed")
class SharedCatalogueCase(ServerTestCase):
    schemas = 0

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.postgres = server_for(cls, LATE_WRITER)

    def setUp(self):
        super().setUp()
        SharedCatalogueCase.schemas += 1
        self.schema = f"test{self.schemas}"
        self.catalogue = f"{self.postgres.url}&schema={self.schema}"
        self.workers = []

    def tearDown(self):
        for worker in self.workers:
            worker.stop()
        super().tearDown()

    def serve_shared(self, *arguments, workers=0):
        return self.serve("--catalogue", self.catalogue, "--workers", str(workers), *arguments)

    def work(self, *arguments):
        self.workers.append(Worker(self.data, self.catalogue, *arguments))
        return self.workers[-1]

    def upload(self, server):
        return server.begun(self.photos)

    def query(self, sql):
        return self.postgres.query(sql, self.schema)

    def check_map(self, server, flight_id):
        _, flight = server.json("GET", f"/api/v1/flights/{flight_id}")
        self.assertEqual(flight["state"], "ready", server.errors())
        _, _, bytes_of_tile = server.request("GET", middle_tile(server.json("GET", flight["tilejson"], code=200)[1]), code=200)
        self.assertGreater(len(bytes_of_tile), 100)
        self.assertEqual(self.query("SELECT count(*) FROM revision"), "1")
