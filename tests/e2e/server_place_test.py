"""A finished map is brought to where things on it really are, by pairs of places given to a job, without its photos
being compared again."""
import math
import unittest

from server_support import ServerTestCase


def moved(place, north_m, east_m):
    lat, lon = place
    return [lat + north_m / 111_200, lon + east_m / (111_300 * math.cos(math.radians(lat)))]


class PlaceOnTheServer(ServerTestCase):
    def made(self, server):
        status, made = server.upload(self.photos[:6])
        self.assertEqual(status, 202, made)
        self.assertEqual(server.wait_for_job(made["job"]["id"])["state"], "successful")
        return made["flight"]["id"]

    def place(self, server, flight, pairs):
        status, job = server.json("POST", f"/api/v1/flights/{flight}/jobs", {"options": {"place": pairs}})
        self.assertEqual(status, 202, job)
        return server.wait_for_job(job["id"])

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
        status, refused = server.json("POST", f"/api/v1/jobs/{job['id']}/retry")
        self.assertEqual(status, 409, refused)
        # What comes after keeps the place.
        status, again = server.json("POST", f"/api/v1/flights/{flight}/jobs", {})
        self.assertEqual(server.wait_for_job(again["id"])["state"], "successful")
        self.assertEqual(self.bounds(server, flight), scaled)
        warnings = " ".join(server.json("GET", f"/api/v1/flights/{flight}/report")[1]["warnings"])
        self.assertIn("placed by hand", warnings)

    def test_refusals(self):
        server = self.serve()
        flight = self.made(server)
        corner = self.bounds(server, flight)["south_west"]
        pair = {"shown": corner, "is": corner}
        job = self.place(server, flight, [pair, pair])
        self.assertEqual(job["state"], "failed")
        self.assertIn("too near together", job["error"]["message"])
        status, refused = server.json("PATCH", f"/api/v1/flights/{flight}", {"options": {"place": [pair]}})
        self.assertEqual(status, 422, refused)
        status, refused = server.json("POST", f"/api/v1/flights/{flight}/jobs", {"options": {"place": [{"is": corner}]}})
        self.assertEqual(status, 422, refused)
        # A flight without a map has nothing to place.
        status, made = server.json("POST", "/api/v1/flights", {"name": "empty"})
        status, refused = server.json("POST", f"/api/v1/flights/{made['id']}/jobs", {"options": {"place": [pair]}})
        self.assertEqual(status, 409, refused)


if __name__ == "__main__":
    unittest.main()
