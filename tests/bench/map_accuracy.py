"""How true finished maps are: simulates flights, stitches them with the real program and compares every map with
the world it shows, patch by patch.

    python3 tests/bench/map_accuracy.py PROGRAM [--seeds N] [--first-seed N] [--only NAME] [--photos N] [--method M] [--keep DIR]

Scenarios whose photos or records are spoilt on purpose (harsh_flights.py) come after the plain ones; --only harsh
takes all of those.

Per scenario, in ground pixels (GSD) and metres: CE90 of the patches' shifts as they are (with the GNSS' own bias),
after the best similarity (what is bent or torn inside the map), the largest of these, the share of patches that
could be compared, and for each kind of placement how far the photos' middles lie off the truth, after the median
shift of all, or where the map is not georeferenced after a similarity (on level ground only): median and worst. Needs python3-gdal with numpy, and cv2 and exiftool for
the harsh ones.
"""
import argparse
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile

import numpy

import harsh_flights
from map_against_truth import after_similarity, measure, metres_per_degree, rotation

SCENARIOS = {
    "exact": ["--noise", "exact"],
    "flat": ["--noise", "xmp"],
    "relief": ["--noise", "xmp", "--relief-m", "8"],
    "houses": ["--noise", "xmp", "--boxes"],
    "no_gimbal": ["--noise", "xmp", "--tilt-deg", "12", "--height-wander-m", "4", "--yaw-wander-deg", "8"],
    "any_yaw": ["--noise", "xmp", "--yaw", "any"],
    "no_attitude": ["--noise", "no-attitude"],
    # Leaning by up to that many degrees, turned all ways, and no angle recorded.
    "no_angles_15": ["--noise", "no-attitude", "--tilt-deg", "15", "--yaw", "any"],
    "no_angles_30": ["--noise", "no-attitude", "--tilt-deg", "30", "--yaw", "any"],
    "no_angles_45": ["--noise", "no-attitude", "--tilt-deg", "45", "--yaw", "any"],
    "rtk": ["--noise", "rtk"],
    "rolling": ["--noise", "xmp", "--speed", "10", "--readout-ms", "60"],
    "rolling_unknown": ["--noise", "xmp", "--speed", "10", "--readout-ms", "60"],
    # Photos turned all ways against the course: there the photos themselves show how their rows were read.
    "rolling_any_yaw": ["--noise", "xmp", "--speed", "10", "--readout-ms", "60", "--yaw", "any"],
    # A camera without gimbal that turns while its rows are read, with and without a gyro.
    "gyro": ["--noise", "xmp", "--speed", "10", "--readout-ms", "160", "--shaking-dps", "12", "--gyro"],
    "gyro_ignored": ["--noise", "xmp", "--speed", "10", "--readout-ms", "160", "--shaking-dps", "12"],
    "little_overlap": ["--noise", "xmp", "--overlap", "0.6", "--sidelap", "0.45"],
    "rows": ["--noise", "xmp", "--texture", "rows"],
    "bare": ["--noise", "xmp", "--texture", "bare"],
    "lens": ["--noise", "xmp", "--distortion", "-0.08", "0.03", "0.0005", "-0.0004", "--vignetting", "0.2",
             "--exposure-jitter", "0.08"],
    "blur": ["--noise", "xmp", "--shutter-ms", "8", "--pixel-noise", "4"],
    "low": ["--noise", "xmp", "--height", "20", "--relief-m", "1"],
    "log_only": ["--noise", "no-gps", "--log", "dataflash", "--mount", "gimbal", "--clock-offset-s", "3607.3"],
}


def after_any_similarity(misses, found):
    """As after_similarity, for places that may be turned by any angle: truth is laid on what was found."""
    truth = found - misses
    to, of = [points[:, 0] + 1j * points[:, 1] for points in (truth, found)]
    weights = numpy.ones(len(to))
    for _ in range(20):
        middle_to, middle_of = [numpy.average(points, weights=weights) for points in (to, of)]
        turn = (weights * (to - middle_to) * (of - middle_of).conj()).sum() / (weights * abs(of - middle_of) ** 2).sum()
        left = abs(to - middle_to - turn * (of - middle_of))
        weights = 1 / numpy.maximum(left, max(1.5 * numpy.median(left), 1e-4))
    return left


def photo_errors(folder):
    """How far each photo's middle lies off on the ground, by placement; {} where the truth is not level."""
    truth = json.loads((folder / "truth" / "poses.json").read_text())
    if truth["relief_m"] > 0:
        return {}
    located = json.loads((folder / "map" / "locate.json").read_text())
    true_at = {photo["name"]: photo for photo in truth["photos"]}
    per_lat, per_lon = metres_per_degree(truth["origin"]["lat_deg"])
    origin = numpy.array([(located["origin"][1] - truth["origin"]["lon_deg"]) * per_lon,
                          (located["origin"][0] - truth["origin"]["lat_deg"]) * per_lat])
    ground_z = numpy.median(located["ground"].get("heights_m") or [located["ground"]["z_m"]])
    misses, middles, kinds = [], [], []
    for camera in located["cameras"]:
        if camera["name"] not in true_at:
            continue
        turn = rotation(camera["rotation_wxyz"]).T
        center = -turn @ camera["translation_m"]
        middle = center + (ground_z - center[2]) / turn[2, 2] * turn[:, 2]
        photo = true_at[camera["name"]]
        turn = rotation(photo["cam_from_enu_wxyz"]).T
        center = numpy.array(photo["camera_center_in_enu"])
        middles.append(middle[:2])
        misses.append(middle[:2] + origin - (center - center[2] / turn[2, 2] * turn[:, 2])[:2])
        kinds.append(camera["placement"])
    if not misses:
        return {}
    off = numpy.linalg.norm(numpy.array(misses) - numpy.median(misses, 0), axis=1)
    if not json.loads((folder / "map" / "report.json").read_text())["is_placed"]:  # any place, size and north
        off = after_any_similarity(numpy.array(misses), numpy.array(middles))
    return {kind: [o for o, k in zip(off, kinds) if k == kind] for kind in sorted(set(kinds))}


# What the product is told of the flight.
TOLD = {"rolling": ["--readout-ms", "60"]}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--seeds", type=int, default=1, help="how many")
    parser.add_argument("--first-seed", type=int, default=1)
    parser.add_argument("--only", action="append", choices=[*SCENARIOS, *harsh_flights.HARSH, "harsh"])
    parser.add_argument("--photos", default="24")
    parser.add_argument("--method", default=None)
    parser.add_argument("--keep", type=pathlib.Path, help="keep flights and maps in this folder")
    options = parser.parse_args()
    scratch = options.keep or pathlib.Path(tempfile.mkdtemp(prefix="skyquilt_accuracy_"))
    print(f"{'scenario':16}{'seed':>5}{'placed':>9}{'aligned':>9}{'CE90 abs m':>12}{'CE90 in GSD':>13}{'worst GSD':>11}"
          f"{'compared':>10}{'stitch s':>10}  photos' middles off, m", flush=True)
    wanted = options.only or [*SCENARIOS, *harsh_flights.HARSH]
    if "harsh" in wanted:
        wanted = [name for name in wanted if name != "harsh"] + [*harsh_flights.HARSH]
    for name in wanted:
        for seed in range(options.first_seed, options.first_seed + options.seeds):
            folder = scratch / f"{name}_{seed}"
            if not (folder / "truth").is_dir():
                if name in SCENARIOS:
                    subprocess.run([options.program, "simulate", "-o", folder, "--photos", options.photos, "--seed",
                                    str(seed), *SCENARIOS[name]], check=True, capture_output=True)
                else:
                    harsh_flights.make(name, options.program, folder, options.photos, seed)
            inputs = [folder / "photos"] + ([folder / "logs"] if (folder / "logs").is_dir() else [])
            method = ["--method", options.method] if options.method else []
            done = subprocess.run([options.program, "stitch", *inputs, "-o", folder / "map", *method,
                                   *TOLD.get(name, [])],
                                  capture_output=True, text=True)
            if done.returncode != 0:
                print(f"{name:16}{seed:5}  {done.stderr.strip().splitlines()[-1]}", flush=True)
                continue
            report = json.loads((folder / "map" / "report.json").read_text())
            shifts, centres, gsd_m, looked_at = measure(folder / "map" / "mosaic.mbtiles", folder / "truth" / "world.tif")
            photos = report["photos"]
            placed = photos["aligned"] + photos["pose_only"]
            seconds = sum(timing["wall_s"] for timing in report["timings"])
            row = f"{name:16}{seed:5}{placed:5}/{photos['total']:<3}{photos['aligned']:9}"
            told = "".join(f"  {kind} {numpy.median(off):.2f} {max(off):.2f}"
                           for kind, off in photo_errors(folder).items())
            if len(shifts) < 8:
                print(f"{row}  only {len(shifts)} of {looked_at} patches could be compared{told}", flush=True)
            else:
                length = after_similarity(shifts, centres)
                print(f"{row}{numpy.percentile(numpy.linalg.norm(shifts, axis=1), 90):12.2f}"
                      f"{numpy.percentile(length, 90) / gsd_m:13.2f}{length.max() / gsd_m:11.2f}"
                      f"{len(shifts) / looked_at:10.0%}{seconds:10.1f}{told}", flush=True)
            if not options.keep:
                shutil.rmtree(folder)


if __name__ == "__main__":
    sys.exit(main())
