"""What the tests over S3 share: a server whose photos and maps lie in a store of objects, behind a proxy that reckons every
signature itself. Skipped where there is no such store."""
import os
import pathlib
import re

import s3_store
from cluster.store_proxy import StoreProxy
from server_support import ServerTestCase, tile_of, wait_until

KEPT_BY_THE_FOLDER = re.compile(
    r"(catalogue\.db[-\w]*|skyquilt-data\.json|blobs\.json|flights/\w+/flight\.jsonl|cache/.*|flights/\w+/preview-\w+/.*)")


class S3TestCase(ServerTestCase):
    @classmethod
    def setUpClass(cls):
        cls.store = s3_store.store_or_skip()
        cls.addClassCleanup(cls.store.stop)
        super().setUpClass()

    def setUp(self):
        super().setUp()
        self.prefix = os.path.basename(self.data)
        self.proxy = StoreProxy(self.store.port, s3_store.KEY)
        self.before = dict(os.environ)
        os.environ.update(self.store.environment(self.proxy.endpoint))

    def tearDown(self):
        super().tearDown()
        self.assertEqual(self.proxy.forged, [])
        self.proxy.stop()
        os.environ.clear()
        os.environ.update(self.before)

    def address(self):
        return self.store.address(self.prefix)

    def serve_s3(self, *arguments):
        return self.serve("--blobs", self.address(), *arguments)

    def keys(self, below=""):
        return [key.removeprefix(f"{self.prefix}/") for key in self.store.keys(f"{self.prefix}/{below}")]

    def kept(self):
        return sorted(str(path.relative_to(self.data)) for path in pathlib.Path(self.data).rglob("*") if path.is_file())

    def make_map(self, server, **fields):
        return server.stitched(self.photos, **fields)["flight"]["id"]

    def folders(self):
        return {key.split("/")[2] for key in self.keys("flights/")}

    def left_behind(self, server):
        """What the data folder keeps that it should not; a worker tidies up after its job is known to be done."""
        wait_until(lambda: not server.garbage(), server.garbage())
        return [path for path in self.kept() if not KEPT_BY_THE_FOLDER.fullmatch(path)]

    def tiles_of(self, server, flight_id):
        """Every tile of a map: address to (status, tag, bytes)."""
        _, tilejson = server.json("GET", f"/tiles/{flight_id}.json")
        west, south, east, north = tilejson["bounds"]
        found = {}
        for zoom in range(tilejson["minzoom"], tilejson["maxzoom"] + 1):
            left, top = tile_of(west, north, zoom)
            right, bottom = tile_of(east, south, zoom)
            for x in range(left, right + 1):
                for y in range(top, bottom + 1):
                    status, headers, body = server.request("GET", f"/tiles/{flight_id}/{zoom}/{x}/{y}?empty=204")
                    found[f"{zoom}/{x}/{y}"] = status, headers["ETag"], body
        return found
