"""Heights that a job is asked for: the files of `stitch --formats dtm`, offered for download, kept when the map is moved, and in
the archive of a processing node's task."""
import io
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest
import zipfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "clients"))
from gis_support import has_qgis  # noqa: E402
from server_support import BINARY, Server  # noqa: E402

OF_GROUND = ["dtm.tif", "dtm_ground.tif", "contours.gpkg", "contours.geojson", "contours.dxf"]
OF_SURFACE = ["dsm.tif", "dsm_photos.tif"]

QGIS_HEIGHTS_SCRIPT = r"""
import json
import sys
from qgis.core import QgsApplication, QgsRaster, QgsRasterLayer, QgsVectorLayer
dsm, dtm, *contours = sys.argv[1:]
application = QgsApplication([], False)
application.initQgis()
surface, ground = (QgsRasterLayer(source, "heights") for source in (dsm, dtm))
assert surface.isValid() and ground.isValid(), (surface.error().message(), ground.error().message())
extent = surface.extent()
values = []
for row in range(1, 10):
    for column in range(1, 10):
        place = extent.center()
        place.setX(extent.xMinimum() + extent.width() * column / 10)
        place.setY(extent.yMinimum() + extent.height() * row / 10)
        values.append([place.x(), place.y(), *(layer.dataProvider().identify(place, QgsRaster.IdentifyFormatValue).results().get(1)
                                               for layer in (surface, ground))])
lines = [QgsVectorLayer(source, "contours", "ogr") for source in contours]
assert all(layer.isValid() for layer in lines)
invalid = sum(not feature.geometry().isGeosValid() for layer in lines for feature in layer.getFeatures())
print(json.dumps({"system": surface.crs().authid(), "values": values, "lines": [layer.featureCount() for layer in lines],
                  "systems": [layer.crs().authid() for layer in lines], "invalid": invalid}))
"""


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

    def test_qgis_reads_the_heights_of_a_running_server(self):
        if not has_qgis():
            self.skipTest("python3-qgis is not here")
        from osgeo import gdal
        files = {name: self.scratch / f"served_{name}" for name in self.served}
        for name, file in files.items():
            file.write_bytes(self.served[name][2])
        status, made = self.server.upload(self.files, name="Seen in QGIS", options=json.dumps({"heights": "dtm"}))
        self.assertEqual(self.server.wait_for_job(made["job"]["id"])["state"], "successful")
        below = f"/vsicurl/http://127.0.0.1:{self.server.port}/api/v1/flights/{made['flight']['id']}"
        contours = [files[name] for name in ("contours.gpkg", "contours.geojson", "contours.dxf")]
        done = subprocess.run([sys.executable, "-c", QGIS_HEIGHTS_SCRIPT, f"{below}/dsm.tif", f"{below}/dtm.tif", *contours],
                              capture_output=True, text=True, timeout=300,
                              env={**os.environ, "QT_QPA_PLATFORM": "offscreen", "QGIS_CUSTOM_CONFIG_PATH": str(self.scratch), "XDG_CACHE_HOME": str(self.scratch)})
        self.assertEqual(done.returncode, 0, done.stderr)
        told = json.loads(next(line for line in done.stdout.splitlines() if line.startswith("{")))
        self.assertEqual((told["system"], told["systems"][:2]), ("EPSG:32632", ["EPSG:32632", "EPSG:4979"]))  # with heights
        self.assertEqual((len(set(told["lines"])), told["invalid"]), (1, 0), told["lines"])
        self.assertGreater(told["lines"][0], 3)
        seen = 0
        for number, name in ((2, "dsm.tif"), (3, "dtm.tif")):
            raster = gdal.Open(str(files[name]))
            left, step, _, top, _, down = raster.GetGeoTransform()
            heights = raster.ReadAsArray()
            for place in told["values"]:
                want = float(heights[int((place[1] - top) / down), int((place[0] - left) / step)])
                got = place[number]
                if want == want:
                    self.assertAlmostEqual(got, want, 3)
                    seen += 1
                else:
                    self.assertTrue(got is None or got != got, (got, want))
        self.assertGreater(seen, 60)

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
