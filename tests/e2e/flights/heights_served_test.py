"""Heights that a job is asked for: the files of `stitch --formats dtm`, offered for download, kept when the map is moved, and in
the archive of a processing node's task."""
import io
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest
import zipfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from server_support import BINARY, Server  # noqa: E402

OF_GROUND = ["dtm.tif", "dtm_ground.tif", "contours.gpkg", "contours.geojson", "contours.dxf"]
OF_SURFACE = ["dsm.tif", "dsm_photos.tif"]


class HeightsServed(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = pathlib.Path(tempfile.mkdtemp(prefix="skyquilt_heights_served_"))
        cls.addClassCleanup(shutil.rmtree, cls.scratch)
        flight = cls.scratch / "flight"
        subprocess.run([BINARY, "simulate", "-o", flight, "--photos", "6", "--size", "400x300", "--height", "40", "--houses", "2",
                        "--relief-m", "3", "--noise", "rtk", "--seed", "3", "--no-world", "--sidelap", "0.75"], check=True, capture_output=True)
        cls.photos = flight / "photos"
        cls.files = [(path.name, path.read_bytes()) for path in sorted(cls.photos.glob("*.JPG"))]
        cls.server = Server(cls.scratch / "data")
        cls.addClassCleanup(cls.server.stop)
        status, made = cls.server.upload(cls.files, name="Village", options=json.dumps({"heights": "dtm"}))
        assert status == 202, made
        cls.job = cls.server.wait_for_job(made["job"]["id"])
        assert cls.job["state"] == "successful", cls.job
        cls.path = f"/api/v1/flights/{made['flight']['id']}"
        cls.served = {name: cls.server.request("GET", f"{cls.path}/{name}") for name in OF_SURFACE + OF_GROUND}

    def download(self, name, path=None):
        status, headers, body = self.server.request("GET", f"{path or self.path}/{name}")
        return status, headers, body

    def test_they_are_those_of_the_command_line(self):
        out = self.scratch / "map"
        subprocess.run([BINARY, "stitch", self.photos, "-o", out, "--formats", "dtm"], check=True, capture_output=True)
        for name in OF_SURFACE + OF_GROUND:
            status, headers, body = self.served[name]
            self.assertEqual(status, 200, name)
            self.assertTrue(body == (out / name).read_bytes(), name)
            self.assertIn(name, headers["Content-Disposition"])
        _, _, archive = self.download("download.zip")
        self.assertLessEqual(set(OF_SURFACE + OF_GROUND), set(zipfile.ZipFile(io.BytesIO(archive)).namelist()))

    def test_a_map_that_is_moved_keeps_them_where_it_is_now(self):
        west, south, _, _ = self.server.json("GET", f"{self.path}/report")[1]["bounds"]
        status, job = self.server.json("POST", f"{self.path}/jobs", {"options": {"place": [
            {"shown": [south, west], "is": [south + 1e-4, west]}]}})
        self.assertEqual((status, job["options"].get("heights")), (202, "dtm"), job)
        self.assertEqual(self.server.wait_for_job(job["id"])["state"], "successful")
        for name in OF_SURFACE + OF_GROUND:
            self.assertEqual(self.download(name)[0], 200, name)
        self.assertFalse(self.download("dsm.tif")[2] == self.served["dsm.tif"][2])

    def test_without_being_asked_there_are_none(self):
        status, made = self.server.upload(self.files, name="Plain")
        self.assertEqual(status, 202)
        self.server.wait_for_job(made["job"]["id"])
        path = f"/api/v1/flights/{made['flight']['id']}"
        for name in OF_SURFACE + OF_GROUND:
            status, headers, body = self.download(name, path)
            self.assertEqual((status, headers["Content-Type"]), (404, "application/problem+json"), name)
        status, job = self.server.json("POST", f"{path}/jobs", {"options": {"heights": "all"}})
        self.assertEqual(status, 422, job)
        self.assertIn('"dtm"', job["detail"])

    def test_the_archive_of_a_node_has_them_where_clients_look(self):
        boundary = "heights"
        options = json.dumps([{"name": "dsm", "value": True}])
        body = (f'--{boundary}\r\nContent-Disposition: form-data; name="options"\r\n\r\n{options}\r\n').encode()
        for name, content in self.files:
            body += (f'--{boundary}\r\nContent-Disposition: form-data; name="images"; filename="{name}"\r\n\r\n').encode() + content + b"\r\n"
        body += f"--{boundary}--\r\n".encode()
        status, _, answer = self.server.request("POST", "/task/new", body, {"Content-Type": f"multipart/form-data; boundary={boundary}"})
        uuid = json.loads(answer)["uuid"]
        while json.loads(self.server.request("GET", f"/task/{uuid}/info")[2])["status"]["code"] in (10, 20):
            pass
        _, _, archive = self.server.request("GET", f"/task/{uuid}/download/all.zip")
        names = zipfile.ZipFile(io.BytesIO(archive)).namelist()
        self.assertIn("odm_dem/dsm.tif", names)
        self.assertNotIn("odm_dem/dtm.tif", names)


if __name__ == "__main__":
    unittest.main()
