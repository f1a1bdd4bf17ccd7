"""plan.py against flights whose time was reckoned by hand."""
import json
import math
import pathlib
import subprocess
import sys
import unittest

import plan

HERE = pathlib.Path(__file__).resolve().parent

# Four photos of 1 MP and 1.25 GB, which is a second of 10 Gbit/s; two workers of two cores; units of one file.
COSTS = {
    "look": {"cpu_s_by_mpx": [[0, 3], [2, 5]], "found_bytes_per_photo": 0},  # 4 at 1 MP: 2 s on two cores
    "place": {"cpu_s_per_photo": 1, "at_photos": 4, "exponent": 1.5, "cores": 1, "memory_mb_per_photo": 500,
              "facts_bytes_per_photo": 0, "header_bytes": 0},
    "render": {"cpu_s_per_mpx": 2, "range_halo": 1},
    "put_together": {"cpu_s_per_photo": 0.5, "cores": 1, "map_bytes_per_photo": 625_000_000, "products": 3},
    "machine": {"streams": 8, "stream_gbit": 10, "disk_gbyte_per_s": 10, "unit_start_s": 0},
}
FLIGHT = plan.Flight(photos=4, mpx=1, photo_bytes=1_250_000_000)


def of(variant="today", cache=math.inf, costs=COSTS, flight=FLIGHT, **cluster):
    return plan.simulate(flight, plan.Cluster(**{"workers": 2, "cores": 2, "link_gbit": 10, "cache_bytes": cache, **cluster}), costs, 1, variant)


class ByHand(unittest.TestCase):
    def test_all_photos_are_fetched_once_by_each_worker(self):
        got = of()
        # Looking: two units after each other, 1 s of network and 2 s of work each. Placing: the other worker's two photos, 4 s
        # on one core. Rendering: the first has all photos, 2 s and a second for its tiles; the other lacks one. Putting
        # together: 2 s for 2.5 GB of tiles, 2 s on one core (the disk would need one), 6 s for three times the map.
        self.assertEqual(got.phase_s, {"look": 6, "place": 6, "render": 4, "put together": 10})
        self.assertEqual(got.makespan_s, 26)
        self.assertAlmostEqual(got.idle, 1 - (16 + 4 + 8 + 2) / (26 * 4))
        self.assertEqual((got.fetched_bytes, got.put_bytes), (11_250_000_000, 10_000_000_000))
        self.assertEqual(got.place_gb, 2)
        self.assertEqual(got.disk_bytes, 15_000_000_000)  # all photos, the tiles, three products

    def test_without_a_cache_each_unit_fetches_again(self):
        got = of(cache=0)
        self.assertEqual(got.phase_s, {"look": 6, "place": 8, "render": 5, "put together": 14})
        self.assertEqual(got.fetched_bytes, 5e9 * 4 + 2.5e9)  # looking, placing, two ranges of half, putting together, tiles

    def test_a_cache_for_one_photo_keeps_the_latest(self):
        # Each worker has the last photo it looked at: placing lacks three. The worker that placed has photo 4 then, the other
        # one too: the first range lacks two, the second one, and putting together three.
        self.assertEqual(of(cache=FLIGHT.photo_bytes).phase_s, {"look": 6, "place": 7, "render": 5, "put together": 13})

    def test_nothing_is_fetched_that_is_not_needed(self):
        got = of("least")
        self.assertEqual(got.phase_s, {"look": 6, "place": 4, "render": 4, "put together": 10})
        self.assertEqual(got.fetched_bytes, 10_000_000_000)

    def test_what_one_connection_or_the_store_gives_is_a_limit(self):
        slow = {**COSTS, "machine": {**COSTS["machine"], "stream_gbit": 1, "streams": 5}}
        self.assertEqual(of(costs=slow).phase_s["look"], 2 * (2 + 2))  # five connections of 1 Gbit/s
        self.assertEqual(of(costs=slow).phase_s["put together"], 4 + 2 + 20)  # three
        self.assertEqual(of(store_gbit=10).phase_s["look"], 2 * (2 + 2))  # 5 Gbit/s for each of two

    def test_placing_grows_with_its_power_and_not_with_workers(self):
        self.assertEqual(of("least", flight=FLIGHT._replace(photos=16), workers=4).phase_s["place"], 4 * 4 ** 1.5)


class Program(unittest.TestCase):
    def test_it_says_the_same_twice_and_more_workers_are_never_slower(self):
        said = [subprocess.run([sys.executable, HERE / "plan.py"], check=True, capture_output=True, text=True).stdout for _ in range(2)]
        self.assertEqual(said[0], said[1])
        costs = json.loads((HERE / "unit_costs.json").read_text())
        flight = plan.Flight(50_000, 20, 8_000_000)
        for variant, cache in (("today", 21.5e9), ("today", math.inf), ("least", 21.5e9)):
            spans = [plan.simulate(flight, plan.Cluster(workers, 16, 10, 0, cache), costs, variant=variant).makespan_s for workers in (4, 8, 16, 32, 64)]
            self.assertEqual(spans, sorted(spans, reverse=True))
            self.assertIn(f"| 64 | {spans[-1] / 3600:.2f} |", said[0])

    def test_units_are_cut_as_the_program_cuts_them(self):
        header = (HERE.parents[2] / "core/pipeline/units/flight_cut.h").read_text()
        self.assertIn("kFilesPerLook = 200;", header)
        self.assertIn("kLooksPerRender = 2;", header)
        self.assertIn("return {unit * items / units, (unit + 1) * items / units};", header)
        self.assertEqual(plan.ranges(5, 2), [(0, 1), (1, 3), (3, 5)])

    def test_every_cost_says_where_it_comes_from(self):
        for name, cost in json.loads((HERE / "unit_costs.json").read_text()).items():
            self.assertTrue(name == "about" or cost.get("measured") or cost.get("assumed"), name)
