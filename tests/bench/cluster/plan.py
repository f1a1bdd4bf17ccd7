"""How long one large flight takes on N workers, on paper: a simulation, event by event, of the units that the program cuts a
flight into, with costs that were measured (unit_costs.json beside this file, with the commands). Deterministic.

python3 tests/bench/cluster/plan.py --photos 50000 --mpx 20 --mbyte 8

Phases follow each other: look (units of files), place (one unit, one worker), render (units of blocks), put together (one
unit). A worker takes one unit at a time: it fetches what the unit needs and it does not have, reckons on its cores, hands in.
Fetching and reckoning do not overlap, as in the program. Units of cores share perfectly: what a real machine loses there, to
memory and to a slowest block, comes on top."""
import argparse
import collections
import heapq
import json
import math
import pathlib

GBIT = 1e9 / 8

# What is fetched: by the program as it is, with its own cache or with one for the whole flight, and as it could be.
VARIANTS = {
    "today": "as it is: placing and putting together fetch all photos of the flight, a range those that it shows",
    "least": "if placing fetched headers and putting together none",
}

Flight = collections.namedtuple("Flight", "photos mpx photo_bytes")
Cluster = collections.namedtuple("Cluster", "workers cores link_gbit store_gbit cache_bytes", defaults=(0, math.inf))
Unit = collections.namedtuple("Unit", "photos fetch_bytes cpu_s cores disk_bytes put_bytes put_streams")
Plan = collections.namedtuple("Plan", "makespan_s idle fetched_bytes put_bytes phase_s place_gb disk_bytes")


def line_through(points, x):
    (x0, y0), (x1, y1) = points
    return y0 + (y1 - y0) * (x - x0) / (x1 - x0)


def ranges(items, per_unit):
    """As pipeline::RangeOf: units of nearly the same size."""
    units = max(1, -(-items // per_unit))
    return [(unit * items // units, (unit + 1) * items // units) for unit in range(units)]


def phases_of(flight, costs, part_files, variant, cores):
    """(name, units) in their order; `photos` of a unit: the numbers of those it fetches, first and end."""
    n, everything = flight.photos, (0, flight.photos)
    look, place, render, last = (costs[name] for name in ("look", "place", "render", "put_together"))
    look_cpu_s = line_through(look["cpu_s_by_mpx"], flight.mpx)
    place_cpu_s = place["cpu_s_per_photo"] * place["at_photos"] * (n / place["at_photos"]) ** place["exponent"]
    found, facts, tiles = n * look["found_bytes_per_photo"], n * place["facts_bytes_per_photo"], n * last["map_bytes_per_photo"]
    whole = variant == "today"
    looks = [Unit((first, end), 0, (end - first) * look_cpu_s, cores, 0, (end - first) * look["found_bytes_per_photo"], 1)
             for first, end in ranges(n, part_files)]
    placing = Unit(everything if whole else None, found + (0 if whole else n * place["header_bytes"]), place_cpu_s, place["cores"], 0, facts, 1)
    renders = []
    for first, end in ranges(n, 2 * part_files):
        around = round((end - first) * (render["range_halo"] - 1) / 2)
        renders.append(Unit((max(0, first - around), min(n, end + around)), facts,
                            (end - first) * flight.mpx * render["cpu_s_per_mpx"], cores, 0, (end - first) * last["map_bytes_per_photo"], 1))
    together = Unit(everything if whole else None, facts + tiles, n * last["cpu_s_per_photo"], last["cores"], (1 + last["products"]) * tiles,
                    last["products"] * tiles, last["products"])
    return [("look", looks), ("place", [placing]), ("render", renders), ("put together", [together])]


class Worker:
    """Which photos it has, as ranges of numbers; the oldest go when its cache is full, but not while a unit uses them."""

    def __init__(self, photo_bytes, cache_bytes):
        self.photo_bytes, self.cache_bytes, self.kept = photo_bytes, cache_bytes, collections.deque()

    def take(self, photos):
        """Bytes to fetch for a unit of these photos."""
        if photos is None:
            return 0
        missing, taken = [photos], []
        for first, end in self.kept:
            missing = [part for f, e in missing for part in ((f, min(e, first)), (max(f, end), e)) if part[0] < part[1]]
            taken += [part for part in ((first, min(end, photos[0])), (max(first, photos[1]), end)) if part[0] < part[1]]
        self.kept = collections.deque([*taken, photos])
        over = sum(end - first for first, end in self.kept) - self.cache_bytes / self.photo_bytes
        while over > 0 and self.kept:
            first, end = self.kept.popleft()
            if end - first > over:
                self.kept.appendleft((first + math.ceil(over), end))
            over -= end - first
        return sum(end - first for first, end in missing) * self.photo_bytes


def simulate(flight, cluster, costs, part_files=200, variant="today"):
    machine = costs["machine"]
    link = cluster.link_gbit if not cluster.store_gbit else min(cluster.link_gbit, cluster.store_gbit / cluster.workers)
    rate = lambda streams: GBIT * min(link, streams * machine["stream_gbit"])
    workers = [Worker(flight.photo_bytes, cluster.cache_bytes) for _ in range(cluster.workers)]
    now, busy_core_s, fetched, put, phase_s, disk = 0.0, 0.0, 0, 0, {}, 0
    for name, units in phases_of(flight, costs, part_files, variant, cluster.cores):
        began = now
        free = [(now, number) for number in range(cluster.workers)]  # the one that waits longest, then by number
        for unit in units:
            at, number = heapq.heappop(free)
            bytes_in = unit.fetch_bytes + workers[number].take(unit.photos)
            work_s = max(unit.cpu_s / unit.cores, unit.disk_bytes / (machine["disk_gbyte_per_s"] * 1e9))
            took = machine["unit_start_s"] + bytes_in / rate(machine["streams"]) + work_s + unit.put_bytes / rate(unit.put_streams)
            busy_core_s += unit.cpu_s
            fetched, put = fetched + bytes_in, put + unit.put_bytes
            photos = unit.photos[1] - unit.photos[0] if unit.photos else 0
            disk = max(disk, photos * flight.photo_bytes + unit.fetch_bytes + unit.put_bytes)
            now = max(now, at + took)
            heapq.heappush(free, (at + took, number))
        phase_s[name] = now - began
    return Plan(now, 1 - busy_core_s / (now * cluster.workers * cluster.cores), fetched, put, phase_s,
                flight.photos * costs["place"]["memory_mb_per_photo"] / 1000, disk)


def parse():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--photos", type=int, default=50_000)
    parser.add_argument("--mpx", type=float, default=20, help="megapixels of a photo (20)")
    parser.add_argument("--mbyte", type=float, default=8, help="megabytes of its file (8)")
    parser.add_argument("--workers", type=int, nargs="+", default=[4, 8, 16, 32, 64])
    parser.add_argument("--cores", type=int, default=16, help="of each worker (16)")
    parser.add_argument("--link-gbit", type=float, default=10, help="of each worker (10)")
    parser.add_argument("--store-gbit", type=float, default=0, help="of the store, shared evenly by the workers; 0: no limit")
    parser.add_argument("--cache-gbyte", type=float, default=21.5, help="photos that a worker keeps between units, as --cache-bytes (21.5)")
    parser.add_argument("--part-files", type=int, default=200, help="as worker --part-files (200)")
    parser.add_argument("--costs", type=pathlib.Path, default=pathlib.Path(__file__).with_name("unit_costs.json"))
    return parser.parse_args()


def main():
    asked = parse()
    costs = json.loads(asked.costs.read_text())
    flight = Flight(asked.photos, asked.mpx, asked.mbyte * 1e6)
    cases = [("today", asked.cache_gbyte * 1e9, f"a cache of {asked.cache_gbyte:g} GB"), ("today", math.inf, "a cache for the whole flight"),
             ("least", asked.cache_gbyte * 1e9, f"a cache of {asked.cache_gbyte:g} GB")]
    for variant, cache, words in cases:
        print(f"\n{VARIANTS[variant]}; {words}\n")
        print("| workers | makespan, h | look | place | render | put together | idle | fetched, TB | put, TB | disk of a worker, GB |")
        print("|---|---|---|---|---|---|---|---|---|---|")
        for workers in asked.workers:
            plan = simulate(flight, Cluster(workers, asked.cores, asked.link_gbit, asked.store_gbit, cache), costs, asked.part_files, variant)
            hours = " | ".join(f"{seconds / 3600:.2f}" for seconds in (plan.makespan_s, *plan.phase_s.values()))
            print(f"| {workers} | {hours} | {plan.idle:.1%} | {plan.fetched_bytes / 1e12:.1f} | {plan.put_bytes / 1e12:.2f} |"
                  f" {plan.disk_bytes / 1e9:.0f} |")
    print(f"\nPlacing is one unit and takes {plan.place_gb:.1f} GB of memory.")


if __name__ == "__main__":
    main()
