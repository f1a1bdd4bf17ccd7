"""Does the stated accuracy hold? Families of simulated flights whose positions err in a known way, stitched by the real
program; how many of the errors against the truth lie within the stated one sigma.

    python3 tests/bench/accuracy/stated_sigma.py PROGRAM [--results FILE] [--minutes N] [--family KEY]... [--seeds 1-3]

Photos are simulated without a position of their own; a geo.txt with noise and bias gives them one. Errors are horizontal, as
the stated radius is: of the photos' middles on level ground, every third photo of a flight, as the map has them. Prints the
table of docs/accuracy.md of all flights there are in FILE. What is there is not run again, unless another program made it, so a
run that was stopped, or that --minutes ends, goes on where it was. Exits with 2 while flights are missing. Standard library only.
"""
import argparse
import hashlib
import json
import math
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "e2e"))
from flights.made_flights import gcp_list, metres_a_degree, turned  # noqa: E402

# key: (what the table calls it, noise of each axis in m, bias of each axis in m, what geo.txt states in m, surveyed points,
# named check points)
FAMILIES = {
    "rtk-bias": ("RTK 0.02 m, bias 0.02 m", 0.02, 0.02, 0.02, 0, 0),
    "rtk": ("RTK 0.02 m, bias none", 0.02, 0.0, 0.02, 0, 0),
    "gnss1-bias": ("GNSS 1 m, bias 1.5 m", 1.0, 1.5, None, 0, 0),
    "gnss1": ("GNSS 1 m, bias none", 1.0, 0.0, None, 0, 0),
    "gnss3-bias": ("GNSS 3 m, bias 1.5 m", 3.0, 1.5, None, 0, 0),
    "gnss3": ("GNSS 3 m, bias none", 3.0, 0.0, None, 0, 0),
    "control": ("GNSS 1 m, bias 1.5 m, 5 control points", 1.0, 1.5, None, 5, 0),
    "checks": ("GNSS 1 m, bias 1.5 m, 3 check points", 1.0, 1.5, None, 0, 3),
    "none": ("without positions", None, 0.0, None, 0, 0),
}
AS_ASSUMED = [key for key, family in FAMILIES.items() if family[2] > 0]
SURVEY_SIGMA_M = 0.02
MARK_SIGMA_PX = 0.5


def geo_txt(truth, family, seed, rng):
    _, noise_m, bias_m, stated_m, *_ = family
    east_m, north_m = metres_a_degree(truth)
    noises = [[noise_m * rng.gauss(0, 1) for _ in range(2)] for _ in truth["photos"]]
    middle = [sum(axis) / len(noises) for axis in zip(*noises)]
    # What all positions share, bias and the mean of their noise, is a normal error of two axes: one from each of as many equally
    # likely rings as there are seeds, because few flights tell its shares.
    length = math.sqrt(bias_m ** 2 + noise_m ** 2 / len(noises)) * math.sqrt(-2 * math.log(1 - (seed - 0.5) / OPTIONS.of))
    towards = rng.uniform(0, 2 * math.pi)
    shared = [length * math.cos(towards), length * math.sin(towards)]
    rows = ["EPSG:4326"]
    for photo, noise in zip(truth["photos"], noises):
        lon = photo["lon_deg"] + (shared[0] + noise[0] - middle[0]) / east_m
        lat = photo["lat_deg"] + (shared[1] + noise[1] - middle[1]) / north_m
        height_m = truth["origin"]["height_ellipsoid_m"] + photo["camera_center_in_enu"][2]
        stated = "" if stated_m is None else f" nan nan nan {stated_m} {2 * stated_m}"
        rows.append(f"{photo['name']} {lon:.10f} {lat:.10f} {height_m:.3f}{stated}")
    return "\n".join(rows) + "\n"


def surveyed(truth, control, checks, rng):
    """Points spread over the flight, surveyed and marked as well as people do."""
    east = [photo["camera_center_in_enu"][0] for photo in truth["photos"]]
    north = [photo["camera_center_in_enu"][1] for photo in truth["photos"]]
    places = [(rng.uniform(min(east), max(east)), rng.uniform(min(north), max(north))) for _ in range(control + checks)]
    east_m, north_m = metres_a_degree(truth)
    errors = [[SURVEY_SIGMA_M * rng.gauss(0, 1) for _ in range(2)] for _ in places]
    rows = []
    for row in gcp_list(truth, places).splitlines()[1:]:
        lon, lat, height, column, line, photo, name = row.split()
        number = int(name[1:])
        rows.append(f"{float(lon) + errors[number][0] / east_m:.10f} {float(lat) + errors[number][1] / north_m:.10f} {height} "
                    f"{float(column) + MARK_SIGMA_PX * rng.gauss(0, 1):.2f} {float(line) + MARK_SIGMA_PX * rng.gauss(0, 1):.2f} "
                    f"{photo} {name}{'_check' if number >= control else ''}")
    return "\n".join(["EPSG:4326", *rows]) + "\n"


def middle_errors_m(truth, folder):
    """Where the map has the ground at the middle of every third photo, against the truth; horizontal."""
    east_m, north_m = metres_a_degree(truth)
    errors = []
    for photo in truth["photos"][::3]:
        w, x, y, z = photo["cam_from_enu_wxyz"]
        down = turned([w, -x, -y, -z], [0.0, 0.0, 1.0])
        center = photo["camera_center_in_enu"]
        along = -center[2] / down[2]
        lens = truth["intrinsics"]
        done = subprocess.run([OPTIONS.program, "locate", folder, "--photo", photo["name"], "--pixel",
                               f"{lens['center_x_px']},{lens['center_y_px']}"], capture_output=True, text=True)
        if done.returncode != 0:
            continue  # not in the map
        lon, lat = map(float, done.stdout.split()[0].split(","))
        errors.append(math.hypot((lon - truth["origin"]["lon_deg"]) * east_m - (center[0] + along * down[0]),
                                 (lat - truth["origin"]["lat_deg"]) * north_m - (center[1] + along * down[1])))
    return errors


def run(key, seed, scratch):
    """(stated sigma or None, errors) of one flight."""
    name, noise_m, *_, control, checks = family = FAMILIES[key]
    rng = random.Random(f"{name} {seed}")
    flight = scratch / f"{key}_{seed}"
    subprocess.run([OPTIONS.program, "simulate", "-o", flight, "--photos", str(OPTIONS.photos), "--size", "800x600", "--no-world", "--noise",
                    "no-pose" if noise_m is None else "no-gps", "--seed", str(seed)], check=True, capture_output=True)
    truth = json.loads((flight / "truth" / "poses.json").read_text())
    inputs = [flight / "photos"]
    if noise_m is not None:
        (flight / "geo.txt").write_text(geo_txt(truth, family, seed, rng))
        inputs.append(flight / "geo.txt")
    if control + checks > 0:
        (flight / "gcp_list.txt").write_text(surveyed(truth, control, checks, rng))
        inputs.append(flight / "gcp_list.txt")
    subprocess.run([OPTIONS.program, "stitch", *inputs, "-o", flight / "map"], check=True, capture_output=True)
    sigma_m = json.loads((flight / "map" / "report.json").read_text())["quality"]["absolute"]["sigma_m"]
    errors = [] if sigma_m is None else middle_errors_m(truth, flight / "map")
    if not OPTIONS.keep:
        shutil.rmtree(flight)
    return sigma_m, errors


def median(values):
    return sorted(values)[len(values) // 2]


def table(flights):
    """Markdown; flights are {(key, seed): (stated sigma or None, errors)}."""
    rows = ["| positions | flights | stated, median | error, median | within the stated 1 sigma |", "|---|---|---|---|---|"]
    assumed = []
    for key, (name, *_) in FAMILIES.items():
        of_family = [flight for (its_key, _), flight in flights.items() if its_key == key]
        stated = [flight for flight in of_family if flight[0] is not None]
        within = [error <= sigma_m for sigma_m, errors in stated for error in errors]
        if not of_family:
            continue
        if not within:
            rows.append(f"| {name} | {len(of_family)} | none | | |")
            continue
        if key in AS_ASSUMED:
            assumed += within
        # A flight without a number among those with one is told, not left out of sight.
        silent = "" if len(stated) == len(of_family) else f", {len(of_family) - len(stated)} none"
        rows.append(f"| {name} | {len(of_family)} | {median([sigma_m for sigma_m, _ in stated]):.3g} m{silent} | "
                    f"{median([error for _, errors in stated for error in errors]):.3g} m | {sum(within) / len(within):.0%} of {len(within)} |")
    if assumed:
        rows.append(f"| all whose bias is as assumed | | | | {sum(assumed) / len(assumed):.0%} of {len(assumed)} |")
    return "\n".join(rows)


def main():
    made_by = {"program": hashlib.sha256(OPTIONS.program.read_bytes()).hexdigest()[:16], "of": OPTIONS.of, "photos": OPTIONS.photos}
    lines = [json.loads(line) for line in OPTIONS.results.read_text().splitlines()] if OPTIONS.results and OPTIONS.results.exists() else []
    ours = [line for line in lines if {key: line[key] for key in made_by} == made_by]
    if len(ours) < len(lines):
        print(f"{len(lines) - len(ours)} flights of another program, or of other --of or --photos, do not count.", file=sys.stderr)
    flights = {(line["family"], line["seed"]): (line["sigma_m"], line["errors_m"]) for line in ours}
    first, _, last = (OPTIONS.seeds or f"1-{OPTIONS.of}").partition("-")
    missing = [(key, seed) for key in OPTIONS.family or FAMILIES for seed in range(int(first), int(last or first) + 1)
               if (key, seed) not in flights]
    scratch = OPTIONS.keep or pathlib.Path(tempfile.mkdtemp(prefix="skyquilt_sigma_"))
    began, longest_s = time.monotonic(), 0.0
    while missing and (OPTIONS.minutes is None or time.monotonic() - began + longest_s < 60 * OPTIONS.minutes):
        key, seed = missing.pop(0)
        since = time.monotonic()
        sigma_m, errors = flights[key, seed] = run(key, seed, scratch)
        longest_s = max(longest_s, time.monotonic() - since)
        print(f"{key} {seed}: {time.monotonic() - since:.0f} s", file=sys.stderr)
        if OPTIONS.results:
            with OPTIONS.results.open("a") as file:
                file.write(json.dumps({"family": key, "seed": seed, **made_by, "sigma_m": sigma_m, "errors_m": errors}) + "\n")
    if not OPTIONS.keep:
        shutil.rmtree(scratch)
    print(table(flights))
    if missing:
        print(f"{len(missing)} flights are missing; the same command goes on with them.", file=sys.stderr)
    return 2 if missing else 0


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("--of", type=int, default=10, help="flights of a family in the whole table")
    parser.add_argument("--seeds", help="of those: one, or first and last as in 1-3; without, all")
    parser.add_argument("--family", action="append", choices=list(FAMILIES))
    parser.add_argument("--photos", type=int, default=24)
    parser.add_argument("--results", type=pathlib.Path, help="what was run before, and what this run adds: a line a flight")
    parser.add_argument("--minutes", type=float, help="begin no flight that would end later")
    parser.add_argument("--keep", type=pathlib.Path, help="keep flights and maps in this folder")
    OPTIONS = parser.parse_args()
    sys.exit(main())
