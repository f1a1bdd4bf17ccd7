"""Whoever brings another store than its catalogue's, or none, is refused before anything is written or claimed."""
import os
import pathlib
import subprocess
import tempfile

import s3_store
from cluster.shared_catalogue import SharedCatalogueCase
from program import BINARY, run


class WrongStore(SharedCatalogueCase):
    @classmethod
    def setUpClass(cls):
        cls.store = s3_store.store_for(cls)
        super().setUpClass()

    def setUp(self):
        super().setUp()
        self.prefix = f"wrong{self.schemas}"
        self.right = ("--blobs", self.store.address(self.prefix))

    def refused(self, command, data, *words, catalogue=None):
        return run(command, "--data", data, "--catalogue", catalogue or self.catalogue, *words, code=1, timeout=120).stderr

    def test_a_mistyped_prefix_takes_no_job_and_leaves_nothing(self):
        server = self.serve_shared(*self.right)
        _, job = self.upload(server)
        mistyped = ("--blobs", self.store.address("mistyped"))
        for words in (mistyped, ()):
            data = os.path.join(tempfile.mkdtemp(dir=self.scratch), "new")
            self.assertIn(f"--blobs {self.right[1]}", self.refused("worker", data, "--once", *words))
            self.assertIn(f"--blobs {self.right[1]}", self.refused("serve", data, "--listen", "127.0.0.1:0", *words))
            self.assertFalse(os.path.exists(data))
        self.assertEqual(self.store.keys("mistyped"), [])
        _, state = server.json("GET", f"/api/v1/jobs/{job}")
        self.assertEqual((state["state"], state["attempts"]), ("accepted", 0))
        # Nor does the server's own folder get anything where --blobs is forgotten.
        self.assertEqual(server.stop(), 0)
        before = sorted(pathlib.Path(self.data, "flights").rglob("*"))
        self.assertIn(f"--blobs {self.right[1]}", self.refused("serve", self.data, "--listen", "127.0.0.1:0"))
        self.assertEqual(sorted(pathlib.Path(self.data, "flights").rglob("*")), before)
        server = self.serve_shared(*self.right)
        # Also with a folder that has worked before.
        self.assertNotEqual(self.refused("worker", self.data, "--once", *mistyped), "")
        self.work("--once", *self.right)
        self.assertEqual(server.wait_for_job(job)["state"], "successful", self.workers[-1].errors())

    def test_a_store_of_another_catalogue_leaves_an_empty_database_empty(self):
        self.serve_shared(*self.right)
        data = os.path.join(tempfile.mkdtemp(dir=self.scratch), "new")
        empty = f"{self.postgres.url}&schema=empty{self.schemas}"
        for command in ("serve", "worker"):
            self.assertIn("another catalogue", self.refused(command, data, *self.right, catalogue=empty))
        self.assertEqual(self.postgres.query(f"SELECT count(*) FROM pg_namespace WHERE nspname='empty{self.schemas}'"), "0")
        self.assertFalse(os.path.exists(data))

    def test_a_token_is_made_beside_a_new_folder_with_the_store_that_is_named(self):
        self.serve_shared(*self.right)
        data = os.path.join(tempfile.mkdtemp(dir=self.scratch), "new")
        words = ("token", "add", "late", "--data", data, "--catalogue", self.catalogue)
        self.assertIn(f"--blobs {self.right[1]}", run(*words, code=1, timeout=120).stderr)
        self.assertFalse(os.path.exists(data))
        self.assertTrue(run(*words, *self.right, timeout=120).stdout.startswith("sq_"))

    def test_an_emptied_store_is_not_taken_for_a_new_one(self):
        server = self.serve_shared(*self.right)
        self.upload(server)
        self.assertEqual(server.stop(), 0)
        marker = next(path for key, path in s3_store.objects_in(self.store.bucket).items()
                      if key == f"{self.prefix}/skyquilt-data.json")
        text = marker.read_bytes()
        marker.unlink()
        self.assertIn("skyquilt-data.json", self.refused("serve", self.data, "--listen", "127.0.0.1:0", *self.right))
        self.assertNotIn(f"{self.prefix}/skyquilt-data.json", self.store.keys(self.prefix))
        marker.write_bytes(text)
        self.serve_shared(*self.right)

    def test_the_files_of_a_shared_catalogue_move_out_and_back(self):
        server = self.serve_shared()
        flight, job = self.upload(server)
        self.work("--once")
        self.assertEqual(server.wait_for_job(job)["state"], "successful", self.workers[-1].errors())
        self.assertEqual(server.stop(), 0)
        move = [BINARY, "data", "move", "--data", self.data]
        forgotten = subprocess.run([*move, "--to", self.right[1]], capture_output=True, text=True)
        self.assertEqual(forgotten.returncode, 1)
        self.assertIn("say --catalogue", forgotten.stderr)
        self.assertEqual(self.store.keys(self.prefix), [])
        move += ["--catalogue", self.catalogue, "--remove-source"]
        subprocess.run([*move, "--to", self.right[1]], check=True)
        self.assertIn(f"--blobs {self.right[1]}", self.refused("serve", self.data, "--listen", "127.0.0.1:0"))
        server = self.serve_shared(*self.right)
        self.check_map(server, flight)
        self.assertEqual(server.stop(), 0)
        subprocess.run([*move, "--from", self.right[1]], check=True)
        self.check_map(self.serve_shared(), flight)
