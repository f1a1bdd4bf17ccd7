"""Heights along a line over HTTP: against the ground that lies beside the map and what /point says, on hills, on level
ground, of an imported map, and what is no line."""
import json
import math
import pathlib

from program import run
from server_support import ServerTestCase, photos_in

RELIEF_M = 15


class Heights(ServerTestCase):
    def ask(self, server, flight, line, kind="application/geo+json"):
        body = line if isinstance(line, (str, bytes)) else json.dumps(line)
        status, _, text = server.request("POST", f"/api/v1/flights/{flight}/heights", body, {"Content-Type": kind})
        return status, json.loads(text)

    def stitched(self, server, photos):
        made = server.stitched(photos)
        return server.json("GET", f"/api/v1/flights/{made['flight']['id']}")[1]

    def across(self, flight, from_share=0.3, to_share=0.7):
        west, south, east, north = flight["bounds"]
        return [[west + share * (east - west), south + share * (north - south)] for share in (from_share, to_share)]

    def test_hills(self):
        folder = pathlib.Path(self.scratch, "hills")
        run("simulate", "-o", folder, "--photos", "12", "--size", "600x450", "--relief-m", str(RELIEF_M), "--no-world")
        server = self.serve()
        flight = self.stitched(server, photos_in(folder / "photos"))
        first, last = self.across(flight)
        middle = [(first[0] + last[0]) / 2 + 1e-5, (first[1] + last[1]) / 2]
        status, told = self.ask(server, flight["id"], {"type": "LineString", "coordinates": [first, middle, last]})
        self.assertEqual(status, 200, told)
        self.assertEqual((told["ground"], told["revision"]), ("grid", flight["revision"]))
        samples = told["samples"]
        self.assertGreater(told["highest_m"] - told["lowest_m"], 0.5, "there are hills")
        self.assertLess(told["highest_m"] - told["lowest_m"], 4 * RELIEF_M)
        # Neighbours lie no farther apart than is said, and go from the line's beginning to its end by its corners.
        steps = [after["distance_m"] - before["distance_m"] for before, after in zip(samples, samples[1:])]
        self.assertLessEqual(max(steps), told["step_m"] + 1e-3)
        self.assertLessEqual(told["step_m"], told["cell_m"] / 2 + 1e-3)
        self.assertGreater(min(steps), 0)
        for corner in (first, middle, last):
            self.assertLess(min(math.hypot(one["lon"] - corner[0], one["lat"] - corner[1]) for one in samples), 1e-8)
        rise = [after["height_m"] - before["height_m"] for before, after in zip(samples, samples[1:])]
        self.assertAlmostEqual(told["climb_m"], sum(step for step in rise if step > 0), delta=0.05)
        self.assertAlmostEqual(told["climb_m"] - told["descent_m"], samples[-1]["height_m"] - samples[0]["height_m"], places=2)
        # The length against that on a sphere of the mean radius.
        self.assertAlmostEqual(told["length_m"], self.on_sphere(first, middle) + self.on_sphere(middle, last), delta=0.005 * told["length_m"])
        self.check_against_point(server, flight, samples)
        self.check_against_file(flight, samples)
        feature = {"type": "Feature", "properties": {}, "geometry": {"type": "LineString", "coordinates": [first, middle, last]}}
        self.assertEqual(self.ask(server, flight["id"], feature, "application/json"), (200, told))
        self.check_beside(server, flight)
        self.check_refusals(server, flight["id"], [first, last])
        self.check_import(server, flight)

    def on_sphere(self, a, b):
        (lon_a, lat_a), (lon_b, lat_b) = [[math.radians(degrees) for degrees in place] for place in (a, b)]
        half = math.sin((lat_b - lat_a) / 2) ** 2 + math.cos(lat_a) * math.cos(lat_b) * math.sin((lon_b - lon_a) / 2) ** 2
        return 2 * 6_371_008.8 * math.asin(math.sqrt(half))

    def check_against_point(self, server, flight, samples):
        for sample in samples[:: max(1, len(samples) // 5)]:
            _, point = server.json("GET", f"/api/v1/flights/{flight['id']}/point?lon={sample['lon']}&lat={sample['lat']}", code=200)
            if point["height_m"] is not None:
                self.assertAlmostEqual(point["height_m"], sample["height_m"], places=3)

    def check_against_file(self, flight, samples):
        """The grid beside the map, read and interpolated here, in a plane that touches the ellipsoid at its origin."""
        [file] = pathlib.Path(self.data).glob(f"flights/{flight['id']}/**/locate.json")
        located = json.loads(file.read_text())
        ground, (lat0, lon0, height0) = located["ground"], located["origin"]
        e2 = 0.00669437999014
        sin2 = math.sin(math.radians(lat0)) ** 2
        across_m = 6_378_137 / math.sqrt(1 - e2 * sin2) + height0
        along_m = 6_378_137 * (1 - e2) / (1 - e2 * sin2) ** 1.5 + height0
        for sample in samples:
            east = math.radians(sample["lon"] - lon0) * across_m * math.cos(math.radians(sample["lat"]))
            north = math.radians(sample["lat"] - lat0) * along_m
            x, y = [(value - corner) / ground["cell_m"] for value, corner in zip((east, north), ground["south_west_m"])]
            column, row = math.floor(x), math.floor(y)
            u, v = x - column, y - row
            z = [ground["heights_m"][(row + j) * ground["columns"] + column + i] for j in (0, 1) for i in (0, 1)]
            height = height0 + (1 - v) * ((1 - u) * z[0] + u * z[1]) + v * ((1 - u) * z[2] + u * z[3])
            self.assertAlmostEqual(sample["height_m"], height, delta=0.05)

    def check_beside(self, server, flight):
        first, last = self.across(flight, -1.0, -0.5)
        status, told = self.ask(server, flight["id"], {"type": "LineString", "coordinates": [first, last]})
        self.assertEqual((status, told["lowest_m"], told["highest_m"], told["climb_m"]), (200, None, None, 0))
        self.assertEqual({sample["height_m"] for sample in told["samples"]}, {None})

    def check_refusals(self, server, flight, line):
        refused = (("", 400), ("{", 400), ("[1,2]", 422), ("null", 422), ({}, 422), ({"type": "Point", "coordinates": line[0]}, 422),
                   ({"type": "LineString"}, 422), ({"type": "LineString", "coordinates": line[:1]}, 422), ({"type": "LineString", "coordinates": [line[0]] * 501}, 422),
                   ({"type": "LineString", "coordinates": [line[0], [7]]}, 422), ({"type": "LineString", "coordinates": [line[0], ["7", "46"]]}, 422),
                   ({"type": "LineString", "coordinates": [line[0], [7, 91]]}, 422), ({"type": "LineString", "coordinates": [line[0], [181, 0]]}, 422),
                   ({"type": "LineString", "coordinates": [[0, 0], [10, 10]]}, 422), ({"type": "Feature", "geometry": None}, 422),
                   ({"type": "MultiLineString", "coordinates": [line]}, 422), ("[" * 5000, 400), (b"\xff\xfe", 400))
        for body, status in refused:
            got, problem = self.ask(server, flight, body)
            self.assertEqual(got, status, (str(body)[:80], problem))
            self.assertTrue(problem["detail"], body)
        good = {"type": "LineString", "coordinates": line}
        self.assertEqual(self.ask(server, flight, good, "text/plain")[0], 415)
        self.assertEqual(self.ask(server, "01JZZZZZZZZZZZZZZZZZZZZZZZ", good)[0], 404)
        self.assertEqual(self.ask(server, server.json("POST", "/api/v1/flights", {"name": "empty"})[1]["id"], good)[0], 404)

    def check_import(self, server, flight):
        foreign = pathlib.Path(self.scratch, "foreign.tif")
        foreign.write_bytes(server.request("GET", f"/api/v1/flights/{flight['id']}/download.tif")[2])
        self.assertEqual(server.stop(), 0)
        run("import", foreign, "--data", self.data, "--name", "foreign", "--tag", "others")
        server = self.serve("--workers", "0")
        [imported] = server.json("GET", "/api/v1/flights?tag=others")[1]["flights"]
        first, last = self.across(flight)
        status, problem = self.ask(server, imported["id"], {"type": "LineString", "coordinates": [first, last]})
        self.assertEqual(status, 404, problem)

    def test_level_ground_says_that_it_is(self):
        server = self.serve()
        flight = self.stitched(server, self.photos)
        status, told = self.ask(server, flight["id"], {"type": "LineString", "coordinates": self.across(flight)})
        self.assertEqual((status, told["ground"], told["cell_m"]), (200, "plane", None))
        self.assertAlmostEqual(told["highest_m"], told["lowest_m"], delta=0.01)
