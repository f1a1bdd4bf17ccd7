"""Tags of flights over HTTP, from the command line and in STAC: set, listed, refused, kept through a lost catalogue."""
import json
import pathlib
import subprocess
import tempfile
import urllib.parse

from program import BINARY, run
from server_support import ServerTestCase


class Tags(ServerTestCase):
    def flight(self, server, **fields):
        return server.json("POST", "/api/v1/flights", fields, code=201)[1]

    def tagged(self, server, tag, more=""):
        return server.json("GET", "/api/v1/flights?tag=" + urllib.parse.quote(tag) + more, code=200)[1]

    def test_flights_are_found_by_their_tags(self):
        server = self.serve("--workers", "0")
        first = self.flight(server, name="first", tags=["north", "Gr\u00f6\u00dfe & Art", "north"])
        self.assertEqual((first["tags"], first["keep"]), (["Gr\u00f6\u00dfe & Art", "north"], False))
        others = [self.flight(server, name=f"other {i}", tags=["north", "mai"]) for i in range(3)]
        self.flight(server, name="untagged")
        everywhere = [one["id"] for one in self.tagged(server, "north")["flights"]]
        self.assertEqual(sorted(everywhere), sorted([first["id"], *(one["id"] for one in others)]))
        self.assertEqual([one["id"] for one in self.tagged(server, "Gr\u00f6\u00dfe & Art")["flights"]], [first["id"]])
        self.assertEqual(self.tagged(server, "nor")["flights"], [])
        # Page by page, by the link that the answer gives.
        seen, path = [], "/api/v1/flights?limit=2&tag=north"
        while path:
            _, headers, body = server.request("GET", path)
            seen += [one["id"] for one in json.loads(body)["flights"]]
            path = headers["Link"].split(">")[0].lstrip("<") if "Link" in headers else None
        self.assertEqual(seen, everywhere)
        status, changed = server.json("PATCH", f"/api/v1/flights/{first['id']}", {"tags": [], "keep": True})
        self.assertEqual((status, changed["tags"], changed["keep"], changed["name"]), (200, [], True, "first"))
        self.assertEqual(len(self.tagged(server, "north")["flights"]), 3)
        long = ["farm 3 north of the river", "maize"]
        self.assertEqual(server.json("PATCH", f"/api/v1/flights/{first['id']}", {"tags": long})[1]["tags"], long)
        self.assertEqual([one["id"] for one in self.tagged(server, long[0])["flights"]], [first["id"]])

    def test_what_is_no_tag_is_refused_in_words(self):
        server = self.serve("--workers", "0")
        flight = self.flight(server, name="f", tags=["a"])["id"]
        for tags in ("a", [1], [""], ["a,b"], [" a"], ["a\n"], ["x" * 41], [f"t{i}" for i in range(21)], None, {"a": 1}):
            _, problem = server.json("PATCH", f"/api/v1/flights/{flight}", {"name": "renamed", "tags": tags}, code=422)
            self.assertIn("tag", problem["detail"])
        self.assertIn("keep", server.json("PATCH", f"/api/v1/flights/{flight}", {"keep": "yes"}, code=422)[1]["detail"])
        for tag in ("", "a,b", "x" * 41, "%00", "%0A"):
            self.assertEqual(server.json("GET", f"/api/v1/flights?tag={tag}")[0], 400, tag)
        self.assertEqual((lambda one: (one["name"], one["tags"]))(server.json("GET", f"/api/v1/flights/{flight}")[1]), ("f", ["a"]))

    def test_an_upload_is_tagged_and_stac_knows_it(self):
        server = self.serve()
        card = pathlib.Path(tempfile.mkdtemp(dir=self.scratch))
        for name, content in self.photos:
            (card / name).write_bytes(content)
        send = [BINARY, "upload", card, "--server", f"http://127.0.0.1:{server.port}", "--tag", "north", "--tag", "maize", "--keep"]
        sent = subprocess.run(send, capture_output=True, text=True)
        self.assertEqual(sent.returncode, 0, sent.stderr)
        [flight] = self.tagged(server, "maize")["flights"]
        self.assertEqual((flight["tags"], flight["keep"], flight["state"]), (["maize", "north"], True, "ready"))
        items = server.json("GET", "/stac/collections/flights/items")[1]["features"]
        self.assertEqual([item["properties"]["keywords"] for item in items], [["maize", "north"]])
        refused = subprocess.run([*send[:-5], "--tag", "a,b"], capture_output=True, text=True)
        self.assertEqual(refused.returncode, 1, refused.stderr)
        self.assertIn("--tag", refused.stderr)
        # A catalogue that was lost comes back with them.
        self.assertEqual(server.stop(), 0)
        for name in pathlib.Path(self.data).glob("catalogue.db*"):
            name.unlink()
        run("data", "repair", "--data", self.data)
        server = self.serve("--workers", "0")
        [flight] = self.tagged(server, "maize")["flights"]
        self.assertEqual((flight["tags"], flight["keep"]), (["maize", "north"], True))
