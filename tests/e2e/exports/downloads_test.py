"""One pyramid lies on the disk; the map as PMTiles and GeoTIFF is laid out over it as it is asked for: with a length, exact
ranges and a strong entity tag that stay through a restart. Files that a map of an earlier version has are sent as they are."""
import io
import pathlib
import random
import shutil
import subprocess
import tempfile
import zipfile

from program import run
from server_support import ServerTestCase

LAID = {"download.pmtiles": "mosaic.pmtiles", "download.tif": "mosaic.tif"}


class Downloads(ServerTestCase):
    def made(self, server):
        return server.stitched(self.photos)["flight"]["id"]

    def test_files_that_lie_nowhere_are_files_to_clients(self):
        server = self.serve()
        flight = self.made(server)
        folder = pathlib.Path(self.data, "flights", flight, "r1")
        out = pathlib.Path(tempfile.mkdtemp(dir=self.scratch))
        names = {path.name for path in folder.iterdir()}
        self.assertFalse(names & set(LAID.values()), names)
        whole = {}
        for name, kind in (("download.pmtiles", "application/vnd.pmtiles"), ("download.tif", "image/tiff; application=geotiff; profile=cloud-optimized")):
            path = f"/api/v1/flights/{flight}/{name}"
            status, headers, body = server.request("GET", path)
            self.assertEqual((status, int(headers["Content-Length"]), headers["Accept-Ranges"], headers["Content-Type"]),
                             (200, len(body), "bytes", kind))
            etag = headers["ETag"]
            self.assertRegex(etag, r'^"[^"]+"$')  # strong
            self.assertEqual(server.request("GET", path, headers={"If-None-Match": etag})[0], 304)
            status, headers, head = server.request("HEAD", path)
            self.assertEqual((status, int(headers["Content-Length"]), headers["ETag"], head), (200, len(body), etag, b""))
            dice = random.Random(3)
            for _ in range(60):
                first = dice.randrange(len(body))
                last = min(len(body) - 1, first + dice.choice([0, 1, 511, 16383, 200_000]))
                status, headers, part = server.request("GET", path, headers={"Range": f"bytes={first}-{last}", "If-Range": etag})
                self.assertEqual((status, headers["Content-Range"], headers["ETag"]), (206, f"bytes {first}-{last}/{len(body)}", etag))
                self.assertEqual(part, body[first:last + 1])
            self.assertEqual(server.request("GET", path, headers={"Range": "bytes=-100"})[2], body[-100:])
            self.assertEqual(server.request("GET", path, headers={"Range": "bytes=5-9", "If-Range": '"other"'})[2], body)
            status, headers, _ = server.request("GET", path, headers={"Range": f"bytes={len(body)}-"})
            self.assertEqual((status, headers["Content-Range"]), (416, f"bytes */{len(body)}"))
            whole[name] = (etag, body)
        _, _, archive = server.request("GET", f"/api/v1/flights/{flight}/download.zip", code=200)
        archive = zipfile.ZipFile(io.BytesIO(archive))
        self.assertIsNone(archive.testzip())
        for name, file in LAID.items():
            self.assertEqual(archive.read(file), whole[name][1])
        # Of the same tiles as the command line's files.
        run("export", folder, "-o", out / "a.pmtiles")
        self.assertEqual((out / "a.pmtiles").read_bytes(), whole["download.pmtiles"][1])
        for name, (_, body) in whole.items():
            (out / name).write_bytes(body)
            run("validate", out / name)
        if shutil.which("gdal_translate"):
            run("export", folder, "-o", out / "b.tif")
            pixels = []
            for name in ("download.tif", "b.tif"):
                raw = out / (name + ".raw")
                subprocess.run(["gdal_translate", "-q", "-of", "ENVI", "-b", "1", "-b", "mask", out / name, raw], check=True,
                               capture_output=True)
                pixels.append(raw.read_bytes())
            first, second = pixels
            # Colour and mask alternate.
            self.assertTrue(first[1::2] == second[1::2], "the masks")
            colours = list(zip(first[0::2], second[0::2], first[1::2]))
            far = [abs(a - b) for a, b, mask in colours if mask]
            self.assertLess(sum(far) / len(far), 0.5)
        self.assertEqual(server.stop(), 0)
        again = self.serve()
        for name, (etag, body) in whole.items():
            status, headers, same = again.request("GET", f"/api/v1/flights/{flight}/{name}")
            self.assertEqual((status, headers["ETag"], same == body), (200, etag, True))
        self.assertFalse({path.name for path in folder.iterdir()} & set(LAID.values()))

    def test_files_of_an_earlier_version_are_sent_as_they_are(self):
        server = self.serve()
        flight = self.made(server)
        for name, file in LAID.items():
            path = f"/api/v1/flights/{flight}/{name}"
            laid = server.request("GET", path)[1]["ETag"]
            pathlib.Path(self.data, "flights", flight, "r1", file).write_bytes(b"as it was written " + file.encode())
            status, headers, body = server.request("GET", path)
            self.assertEqual((status, body), (200, b"as it was written " + file.encode()))
            self.assertNotEqual(headers["ETag"], laid)
