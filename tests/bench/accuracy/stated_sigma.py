"""Does the stated accuracy hold? Families of simulated flights whose positions err in a known way, stitched by the real
program; how many of the errors against the truth lie within the stated one sigma.

    python3 tests/bench/accuracy/stated_sigma.py PROGRAM [--seeds N] [--photos N] [--only NAME] [--keep DIR]

Photos are simulated without a position of their own; a geo.txt with noise and bias gives them one. Errors are those of the
photos' middles on level ground, every third photo of a flight, as the map has them. Prints the table of docs/accuracy.md.
Standard library only. About 30 s of one core a flight: 20 minutes for 3 seeds, an hour and a half for the 10 of the table.
"""
import argparse
import json
import math
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "e2e" / "command_line"))
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "e2e"))
from control_test import gcp_list, metres_a_degree, turned  # noqa: E402

# name: (noise of each axis in m, bias of each axis in m, what geo.txt states in m, surveyed points, named check points)
FAMILIES = {
    "RTK 0.02 m, bias 0.02 m": (0.02, 0.02, 0.02, 0, 0),
    "RTK 0.02 m, bias none": (0.02, 0.0, 0.02, 0, 0),
    "GNSS 1 m, bias 1.5 m": (1.0, 1.5, None, 0, 0),
    "GNSS 1 m, bias none": (1.0, 0.0, None, 0, 0),
    "GNSS 3 m, bias 1.5 m": (3.0, 1.5, None, 0, 0),
    "GNSS 3 m, bias none": (3.0, 0.0, None, 0, 0),
    "GNSS 1 m, bias 1.5 m, 5 control points": (1.0, 1.5, None, 5, 0),
    "GNSS 1 m, bias 1.5 m, 3 check points": (1.0, 1.5, None, 0, 3),
    "without positions": (None, 0.0, None, 0, 0),
}
AS_ASSUMED = [name for name in FAMILIES if "none" not in name and "without" not in name]
SURVEY_SIGMA_M = 0.02
MARK_SIGMA_PX = 0.5


def geo_txt(truth, family, seed, rng):
    noise_m, bias_m, stated_m, *_ = family
    east_m, north_m = metres_a_degree(truth)
    # Of a normal error of two axes, one from each of as many equally likely rings as there are seeds: few flights tell its shares.
    length = bias_m * math.sqrt(-2 * math.log(1 - (seed - 0.5) / OPTIONS.seeds))
    towards = rng.uniform(0, 2 * math.pi)
    bias = [length * math.cos(towards), length * math.sin(towards)]
    rows = ["EPSG:4326"]
    for photo in truth["photos"]:
        lon = photo["lon_deg"] + (bias[0] + noise_m * rng.gauss(0, 1)) / east_m
        lat = photo["lat_deg"] + (bias[1] + noise_m * rng.gauss(0, 1)) / north_m
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


def run(name, seed, scratch):
    """(stated sigma or None, errors) of one flight."""
    family = FAMILIES[name]
    rng = random.Random(f"{name} {seed}")
    flight = scratch / f"{list(FAMILIES).index(name)}_{seed}"
    has_positions = family[0] is not None
    subprocess.run([OPTIONS.program, "simulate", "-o", flight, "--photos", str(OPTIONS.photos), "--size", "800x600", "--no-world", "--noise",
                    "no-gps" if has_positions else "no-pose", "--seed", str(seed)], check=True, capture_output=True)
    truth = json.loads((flight / "truth" / "poses.json").read_text())
    inputs = [flight / "photos"]
    if has_positions:
        (flight / "geo.txt").write_text(geo_txt(truth, family, seed, rng))
        inputs.append(flight / "geo.txt")
    if family[3] + family[4] > 0:
        (flight / "gcp_list.txt").write_text(surveyed(truth, family[3], family[4], rng))
        inputs.append(flight / "gcp_list.txt")
    subprocess.run([OPTIONS.program, "stitch", *inputs, "-o", flight / "map"], check=True, capture_output=True)
    sigma_m = json.loads((flight / "map" / "report.json").read_text())["quality"]["absolute"]["sigma_m"]
    errors = [] if sigma_m is None else middle_errors_m(truth, flight / "map")
    if not OPTIONS.keep:
        shutil.rmtree(flight)
    return sigma_m, errors


def main():
    scratch = OPTIONS.keep or pathlib.Path(tempfile.mkdtemp(prefix="skyquilt_sigma_"))
    print("| positions | flights | stated, median | error, median | within the stated 1 sigma |\n|---|---|---|---|---|", flush=True)
    within_of = {}
    for name in OPTIONS.only or FAMILIES:
        flights = [run(name, seed, scratch) for seed in range(1, OPTIONS.seeds + 1)]
        stated = sorted(sigma for sigma, _ in flights if sigma is not None)
        if not stated:
            print(f"| {name} | {len(flights)} | none | | |", flush=True)
            continue
        errors = sorted(error for _, of_flight in flights for error in of_flight)
        within_of[name] = [error <= sigma for sigma, of_flight in flights for error in of_flight if sigma is not None]
        share = sum(within_of[name]) / max(1, len(within_of[name]))
        print(f"| {name} | {len(flights)} | {stated[len(stated) // 2]:.3g} m | {errors[len(errors) // 2]:.3g} m | {share:.0%} |",
              flush=True)
    assumed = [one for name in AS_ASSUMED for one in within_of.get(name, [])]
    if assumed:
        print(f"| all whose bias is as assumed | | | | {sum(assumed) / len(assumed):.0%} |")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--seeds", type=int, default=10, help="how many")
    parser.add_argument("--photos", type=int, default=24)
    parser.add_argument("--only", action="append", choices=list(FAMILIES))
    parser.add_argument("--keep", type=pathlib.Path, help="keep flights and maps in this folder")
    OPTIONS = parser.parse_args()
    main()
