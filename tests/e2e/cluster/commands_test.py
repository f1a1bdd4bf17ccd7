"""Every command of docs/cluster.md does what the page says, on a fresh PostgreSQL and a fresh store; the recipes for Slurm on a Slurm of one
node. Those of other programs are read and not run."""
import os
import shlex
import subprocess
import tempfile
import time
import unittest

import s3_store
from cluster.shared_catalogue import NOTHING_TO_DO, SharedCatalogueCase
from page_commands import shell_blocks
from postgres_server import find_binaries, server_for
from program import BINARY
from server_support import wait_until
from slurm_cluster import cluster_for, missing_programs

NOT_HERE = ("sbatch", "export")  # what is exported is in the environment of the test already
STAYS = ("serve", "worker")  # until they are stopped


@unittest.skipIf(find_binaries() is None, "PostgreSQL is not installed")
class Commands(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.store = s3_store.store_for(cls)
        cls.postgres = server_for(cls)

    def setUp(self):
        scratch = tempfile.TemporaryDirectory(prefix="skyquilt_commands_")
        self.addCleanup(scratch.cleanup)
        self.folder = scratch.name
        self.running = []
        self.addCleanup(self.stop_all)
        # The test's cluster was made by a role and with a database of the page's names: the page's own are to be made.
        self.administer("createuser", "--superuser", "administrator", user="skyquilt")
        self.administer("dropdb", "--force", "skyquilt")

    def administer(self, program, *words, user="administrator"):
        done = subprocess.run([self.postgres.binaries / program, "-h", self.postgres.folder, "-U", user, *words], cwd="/",
                              capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)

    def stop_all(self):
        for process, log in self.running:
            process.terminate()
            process.wait(timeout=60)
            log.close()
        self.running = []

    def start(self, words):
        """A command that stays; a server, until it serves."""
        self.assertIn(words[0], STAYS)
        log = tempfile.TemporaryFile("w+")
        process = subprocess.Popen([os.path.abspath(BINARY), *words], cwd=self.folder, stdout=log, stderr=log)
        self.running.append((process, log))

        def said():
            log.seek(0)
            return log.read()
        if words[0] == "serve":
            wait_until(lambda: process.poll() is not None or "is serving at" in said(), f"{words} does not begin")
        else:
            time.sleep(3)
        self.assertIsNone(process.poll(), (words, said()))

    def replay(self, words, place):
        """A command of ours; `place`: the folder and prefix of its block."""
        words = [word.replace("postgresql://skyquilt@db.example.org/skyquilt",
                              f"postgresql://keeper@/skyquilt?host={self.postgres.folder}")
                 .replace("s3://bucket/prefix", self.store.address(place)).replace("0.0.0.0:8080", "0.0.0.0:0") for word in words]
        words = [f"{place}-{word}" if before == "--data" else word for before, word in zip(["", *words], words)]
        if words[0] == "serve":
            self.stop_all()
            return self.start(words if "--listen" in words else [*words, "--listen", "127.0.0.1:0"])
        if words[0] in STAYS:
            return self.start(words)
        self.stop_all()
        done = subprocess.run([os.path.abspath(BINARY), *words], cwd=self.folder, capture_output=True, text=True, timeout=120)
        self.assertEqual(done.returncode, 0, (words, done.stdout, done.stderr))
        return None

    def test_every_command_does_what_the_page_says(self):
        count = 0
        for number, block in enumerate(shell_blocks("cluster.md")):
            place = f"block{number}"
            self.stop_all()
            if any("--catalogue" in words and "--blobs" in words for words in block):
                # Another way to begin: what began in a folder stays there.
                self.administer("dropdb", "--force", "skyquilt")
                self.administer("createdb", "--owner", "keeper", "skyquilt")
            if any(words[1:3] == ["data", "move"] for words in block):
                self.start(["serve", "--data", f"{place}-data", "--listen", "127.0.0.1:0", "--workers", "0"])  # it had a server
            for words in block:
                if words[0] in NOT_HERE:
                    continue
                count += 1
                if words[0] == "createuser":
                    self.administer("createuser", "keeper")
                elif words[0] == "createdb":
                    self.administer(*[word.replace("skyquilt", "keeper") for word in words[:-1]], words[-1])
                else:
                    self.assertEqual(words[0], "skyquilt", f"nobody replays {words}")
                    self.replay(words[1:], place)
        self.assertGreater(count, 8)


@unittest.skipIf(missing_programs(), f"Slurm is not installed: {', '.join(missing_programs())}")
class SlurmTest(SharedCatalogueCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.slurm = cluster_for(cls)

    def command(self, *arguments):
        return "exec " + shlex.join([str(BINARY), "worker", "--data", str(self.data), "--catalogue", self.catalogue, *arguments])

    def wait_for(self, job):
        wait_until(lambda: self.slurm.ended(job) is not None, "the Slurm job did not end")
        return self.slurm.ended(job)

    def test_an_array_of_workers_takes_a_job_each(self):
        server = self.serve_shared()
        made = [self.upload(server) for _ in range(2)]
        array = self.slurm.submit("--array=1-2", "--cpus-per-task=1", "--wrap", self.command("--once"))
        self.assertEqual(self.wait_for(array), [0, 0])
        for _, job in made:
            server.ended(job)
        self.assertEqual(self.wait_for(self.slurm.submit("--array=3", "--wrap", self.command("--once"))), [NOTHING_TO_DO])

    def test_workers_that_stay_make_a_flight_that_is_cut_and_end_when_told(self):
        server = self.serve_shared()
        array = self.slurm.submit("--array=1-2", "--cpus-per-task=1", "--signal=B:TERM@60", "--wrap",
                                  self.command("--cut-above", "3", "--part-files", "2"))
        flight, job = self.upload(server)
        server.ended(job)
        self.check_map(server, flight)
        self.slurm.run("scancel", "--batch", "--signal=TERM", array)
        self.wait_for(array)
        self.assertEqual(self.query("SELECT count(*) FROM unit WHERE state = 'running'"), "0")
