"""The source paper's case through the real program, over many flights: 20 m high, a hop without GNSS, a marker at
take-off, a range finder. Simulates and stitches each flight and holds the cameras and their stated error radius
against the truth.

    python3 tests/bench/hop_without_gnss.py PROGRAM [--seeds N] [--method imu|auto]

Per case: the mean over flights of the RMS over photos, the largest of it, the mean stated radius (1 sigma of both
directions together), and the share of photos within 1.73 of theirs, which is 95 % of a round normal distribution.
"""
import argparse
import json
import math
import pathlib
import subprocess
import tempfile

FLIGHT = ["--photos", "8", "--size", "640x480", "--height", "20", "--speed", "4", "--overlap", "0.7", "--sidelap", "0.6",
          "--noise", "no-pose", "--log", "dataflash", "--log-without-gnss", "--log-range", "--no-world"]
CASES = {"start marker": ([], 14.0), "landed at start": (["--landed-at-start"], 2.1)}
EARTH_RADIUS_M = 6371000.0


def rms(values):
    return math.sqrt(sum(v * v for v in values) / len(values))


def errors_of(truth, features):
    """Per photo: how far the camera lies from the truth across, and the radius stated for it."""
    true = {p["name"]: p for p in truth["photos"]}
    for photo in (feature["properties"] for feature in features):
        at = true[photo["name"]]
        north = math.radians(photo["camera_lat"] - at["lat_deg"]) * EARTH_RADIUS_M
        east = math.radians(photo["camera_lon"] - at["lon_deg"]) * EARTH_RADIUS_M * math.cos(math.radians(at["lat_deg"]))
        yield math.hypot(north, east), photo["error_radius_m"]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--method", default="imu")
    arguments = parser.parse_args()
    measured = {case: [] for case in CASES}
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(1, arguments.seeds + 1):
            flight = pathlib.Path(folder) / str(seed)
            subprocess.run([arguments.program, "simulate", "-o", flight, *FLIGHT, "--seed", str(seed)], check=True,
                           capture_output=True)
            truth = json.loads((flight / "truth/poses.json").read_text())
            origin = "{lat_deg},{lon_deg}".format(**truth["origin"])
            for case, (more, _) in CASES.items():
                out = flight / case.replace(" ", "_")
                subprocess.run([arguments.program, "stitch", flight / "photos", flight / "logs/flight.BIN", "-o", out,
                                "--method", arguments.method, "--origin", origin, *more], check=True,
                               capture_output=True)
                features = json.loads((out / "photos.geojson").read_text())["features"]
                measured[case].append(list(errors_of(truth, features)))
    print(f"{'case':<18}{'mean RMS m':>11}{'largest':>9}{'reference':>11}{'ratio':>7}{'stated m':>10}{'within 95 %':>13}")
    for case, flights in measured.items():
        by_flight = [rms([error for error, _ in flight]) for flight in flights]
        photos = [photo for flight in flights for photo in flight]
        mean = sum(by_flight) / len(by_flight)
        within = sum(error <= 1.73 * radius for error, radius in photos) / len(photos)
        stated = sum(radius for _, radius in photos) / len(photos)
        reference = CASES[case][1]
        print(f"{case:<18}{mean:>11.2f}{max(by_flight):>9.2f}{reference:>11.1f}{mean / reference:>7.2f}{stated:>10.2f}"
              f"{100 * within:>12.1f}%")


if __name__ == "__main__":
    main()
