"""A real flight against what its photos record: every camera where its own GPS says."""
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from server_support import BINARY, DATA  # noqa: E402


class RealFlight(unittest.TestCase):
    def test_cameras_lie_where_the_photos_gps_says(self):
        photos = DATA / "brighton_beach" / "images"
        if not photos.is_dir() or shutil.which("exiftool") is None:
            self.skipTest("the Brighton Beach photos or exiftool are not here")
        with tempfile.TemporaryDirectory() as out:
            subprocess.run([BINARY, "stitch", photos, "-o", out, "--method", "imu"], check=True,
                           stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            report = json.loads(pathlib.Path(out, "report.json").read_text())
            features = json.loads(pathlib.Path(out, "photos.geojson").read_text())["features"]
        self.assertEqual(report["photos"], {"total": 18, "aligned": 0, "pose_only": 18, "left_out": 0})
        exif = json.loads(subprocess.run(["exiftool", "-j", "-n", "-GPSLatitude", "-GPSLongitude", photos], check=True,
                                         capture_output=True).stdout)
        recorded = {pathlib.Path(row["SourceFile"]).name: row for row in exif}
        west, south, east, north = report["bounds"]
        for feature in features:
            row = recorded[feature["properties"]["name"]]
            lat, lon = row["GPSLatitude"], row["GPSLongitude"]
            self.assertTrue(west <= lon <= east and south <= lat <= north)
            self.assertLess(abs(feature["properties"]["camera_lat"] - lat) * 111_000, 0.5)
            self.assertLess(abs(feature["properties"]["camera_lon"] - lon) * 76_000, 0.5)
            # The photos look straight down: the middle of the footprint lies below the camera.
            ring = feature["geometry"]["coordinates"][0][:-1]
            corners = [ring[i * len(ring) // 4] for i in range(4)]
            self.assertLess(abs(sum(c[1] for c in corners) / 4 - lat) * 111_000, 0.5)
            self.assertLess(abs(sum(c[0] for c in corners) / 4 - lon) * 76_000, 0.5)


if __name__ == "__main__":
    unittest.main()
