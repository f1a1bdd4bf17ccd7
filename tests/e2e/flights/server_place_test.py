"""A finished map is brought to where things on it really are, by pairs of places given to a job, without its photos
being compared again."""
import json
import math

from flights.made_flights import gcp_list, small_flight
from server_support import ServerTestCase


def moved(place, north_m, east_m):
    lat, lon = place
    return [lat + north_m / 111_200, lon + east_m / (111_300 * math.cos(math.radians(lat)))]


class PlaceOnTheServer(ServerTestCase):
    def made(self, server):
        return server.stitched(self.photos[:6])["flight"]["id"]

    def place(self, server, flight, pairs):
        return server.wait_for_job(server.json("POST", f"/api/v1/flights/{flight}/jobs", {"options": {"place": pairs}}, code=202)[1]["id"])

    def bounds(self, server, flight):
        west, south, east, north = server.json("GET", f"/api/v1/flights/{flight}")[1]["bounds"]
        return {"south_west": [south, west], "north_east": [north, east],
                "size_m": ((north - south) * 111_200, (east - west) * 111_300 * math.cos(math.radians(south)))}

    def test_one_pair_shifts_and_two_scale(self):
        server = self.serve()
        flight = self.made(server)
        before = self.bounds(server, flight)
        corner = before["south_west"]
        job = self.place(server, flight, [{"shown": corner, "is": moved(corner, 40, -25)}])
        self.assertEqual(job["state"], "successful", job)
        shifted = self.bounds(server, flight)
        for corner in ("south_west", "north_east"):
            for got, wanted in zip(shifted[corner], moved(before[corner], 40, -25)):
                self.assertAlmostEqual(got, wanted, delta=2e-5)
        first, second = shifted["south_west"], shifted["north_east"]
        height_m, width_m = shifted["size_m"]
        job = self.place(server, flight, [{"shown": first, "is": first},
                                          {"shown": second, "is": moved(second, height_m, width_m)}])
        self.assertEqual(job["state"], "successful", job)
        scaled = self.bounds(server, flight)
        for now, was in zip(scaled["size_m"], shifted["size_m"]):
            self.assertAlmostEqual(now / was, 2.0, delta=0.1)
        # Once more would move it again.
        server.json("POST", f"/api/v1/jobs/{job['id']}/retry", code=409)
        # What comes after keeps the place.
        server.remade(flight)
        self.assertEqual(self.bounds(server, flight), scaled)
        warnings = " ".join(server.json("GET", f"/api/v1/flights/{flight}/report")[1]["warnings"])
        self.assertIn("placed by hand", warnings)
        # Also where a photo goes, and the others are aligned anew.
        self.assertEqual(server.request("DELETE", f"/api/v1/flights/{flight}/files/{self.photos[5][0]}")[0], 204)
        server.remade(flight)
        warnings = " ".join(server.json("GET", f"/api/v1/flights/{flight}/report")[1]["warnings"])
        self.assertIn("placed by hand", warnings)

    def test_control_points_are_kept_and_place_the_map(self):
        server = self.serve()
        flight = self.made(server)
        truth = json.loads((small_flight() / "truth/poses.json").read_text())
        rows = [row.split() for row in gcp_list(truth, [(-6, -6), (8, -5), (0, 9)]).splitlines()[1:]]
        points = {}
        for x, y, z, column, row, photo, name in rows:
            # Surveyed elsewhere, so that the map has to move.
            point = points.setdefault(name, {"name": name, "x": float(x) + 0.001, "y": float(y), "height": float(z), "marks": []})
            point["marks"].append({"photo": photo, "x": float(column) - 0.5, "y": float(row) - 0.5})
        address = f"/api/v1/flights/{flight}/control"
        failed = server.remade(flight, {"place": "control"}, state="failed")
        self.assertIn("No surveyed point is marked", failed["error"]["message"])
        self.assertEqual(server.json("GET", address)[1]["points"], [])
        _, kept = server.json("PUT", address, {"reference_system": "EPSG:4326", "points": list(points.values())}, code=200)
        self.assertEqual(len(server.json("GET", address)[1]["points"]), 3)
        before = self.bounds(server, flight)
        job = server.remade(flight, {"place": "control"})
        self.assertAlmostEqual(self.bounds(server, flight)["south_west"][1] - before["south_west"][1], 0.001, delta=1e-4)
        report = server.json("GET", f"/api/v1/flights/{flight}/report")[1]
        control = report["alignment"]["ground_control"]
        self.assertEqual([point["is_used"] for point in control], [True] * 3)
        self.assertEqual(sum(len(point["marks"]) for point in control), len(rows))
        self.assertLess(max(mark["residual_px"] for point in control for mark in point["marks"]), 20)
        # Once more finds nothing to move, and more of the same job is no harm.
        self.assertEqual(server.json("POST", f"/api/v1/jobs/{job['id']}/retry")[0], 202)
        # A mark that changed is no reason to align anew where the map is moved by hand.
        kept["points"][0]["marks"][0]["x"] += 1
        self.assertEqual(server.wait_for_job(server.json("GET", f"/api/v1/jobs?flight={flight}")[1]["jobs"][0]["id"])["state"], "successful")
        server.json("PUT", address, kept, code=200)
        corner = self.bounds(server, flight)["south_west"]
        job = self.place(server, flight, [{"shown": corner, "is": moved(corner, 5, 5)}])
        self.assertEqual(job["state"], "successful", job)
        server.json("PUT", address, {"points": [{"name": "a", "x": 1}]}, code=422)

    def test_refusals(self):
        server = self.serve()
        flight = self.made(server)
        corner = self.bounds(server, flight)["south_west"]
        pair = {"shown": corner, "is": corner}
        job = self.place(server, flight, [pair, pair])
        self.assertEqual(job["state"], "failed")
        self.assertIn("too near together", job["error"]["message"])
        server.json("PATCH", f"/api/v1/flights/{flight}", {"options": {"place": [pair]}}, code=422)
        server.json("POST", f"/api/v1/flights/{flight}/jobs", {"options": {"place": [{"is": corner}]}}, code=422)
        # A flight without a map has nothing to place.
        status, made = server.json("POST", "/api/v1/flights", {"name": "empty"})
        server.json("POST", f"/api/v1/flights/{made['id']}/jobs", {"options": {"place": [pair]}}, code=409)
