"""The recipes of docs/cluster.md under Slurm, on one node: an array of `worker --once` takes a job each and the task that finds
none says so by its exit code; workers that stay make a flight that is cut, and give back what they hold when told to end."""
import pathlib
import shlex
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "support"))
from cluster.shared_catalogue import NOTHING_TO_DO, SharedCatalogueCase
from server_support import BINARY, wait_until
from slurm_cluster import cluster_for, missing_programs


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
            self.assertEqual(server.wait_for_job(job)["state"], "successful")
        late = self.slurm.submit("--array=3", "--wrap", self.command("--once"))
        self.assertEqual(self.wait_for(late), [NOTHING_TO_DO])

    def test_workers_that_stay_make_a_flight_that_is_cut_and_end_when_told(self):
        server = self.serve_shared()
        array = self.slurm.submit("--array=1-2", "--cpus-per-task=1", "--signal=B:TERM@60", "--wrap",
                                  self.command("--cut-above", "3", "--part-files", "2"))
        flight, job = self.upload(server)
        self.assertEqual(server.wait_for_job(job)["state"], "successful")
        self.check_map(server, flight)
        self.slurm.run("scancel", "--batch", "--signal=TERM", array)
        self.wait_for(array)
        self.assertEqual(self.query("SELECT count(*) FROM unit WHERE state = 'running'"), "0")


if __name__ == "__main__":
    unittest.main()
