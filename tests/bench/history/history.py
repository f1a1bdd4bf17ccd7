"""Whether the program became slower: measures its stages on the same simulated flights as ever, and compares them with the
runs before.

    python3 tests/bench/history/history.py record PROGRAM [--runs N] [--file LINES]
    python3 tests/bench/history/history.py compare [--file LINES] [--more-than 5]

`record` appends one line of JSON: commit, day, cores, and for each stage of each flight its processor seconds (the median of the
runs) as a ratio to two loops that this process runs between them: one that decodes the same photos by libjpeg-turbo, and one
that copies memory. Machines differ and are noisy; the ratios much less. `compare` holds the last line against the median of up to
five before it with as many cores, prints what takes more than 5 % more by both loops, and ends with 1 then. The flights are
made anew each time, from the same seeds."""
import argparse
import ctypes
import datetime
import json
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from whole_job import decode_floor

LINES = HERE / "runs.jsonl"
BEFORE = 5
COPIED_BYTES = 256 << 20
# name: options of `simulate`, then of `stitch`
FLIGHTS = {
    "photos of 3 megapixels": (["--photos", "20", "--size", "2000x1500", "--noise", "xmp", "--no-world"], []),
    "many small photos": (["--photos", "120", "--size", "640x480", "--noise", "xmp", "--no-world"], []),
    "no records used": (["--photos", "24", "--size", "1200x900", "--noise", "xmp", "--no-world"], ["--method", "images"]),
}


def copy_loop():
    """Processor seconds to copy a quarter of a gibibyte four times."""
    source, target = (ctypes.create_string_buffer(COPIED_BYTES) for _ in range(2))
    ctypes.memmove(target, source, COPIED_BYTES)  # the pages are there now
    before = time.process_time()
    for _ in range(4):
        ctypes.memmove(target, source, COPIED_BYTES)
    return time.process_time() - before


def stages_of(program, photos, options):
    """Processor seconds by stage of one run, and of all."""
    with tempfile.TemporaryDirectory() as out:
        subprocess.run([program, "stitch", photos, "-o", out, "--threads", "2", *options], check=True, stdout=subprocess.DEVNULL,
                       stderr=subprocess.DEVNULL)
        report = json.loads(pathlib.Path(out, "report.json").read_text())
    seconds = {timing["stage"]: timing["cpu_s"] for timing in report["timings"]}
    return {**seconds, "all": sum(seconds.values())}


def measure(program, runs):
    """By "flight: stage": the seconds as ratios to decoding the flight's photos and to copying."""
    measured = {}
    with tempfile.TemporaryDirectory() as folder:
        for name, (simulate, stitch) in FLIGHTS.items():
            flight = pathlib.Path(folder, name.replace(" ", "_"))
            subprocess.run([program, "simulate", "-o", flight, "--seed", "1", *simulate], check=True, stdout=subprocess.DEVNULL,
                           stderr=subprocess.DEVNULL)
            photos = sorted((flight / "photos").glob("*.JPG"))
            taken, decoding, copying = [], [], []
            for run in range(runs):
                print(f"{name}: run {run + 1} of {runs}", file=sys.stderr, flush=True)
                decoding.append(decode_floor(photos))
                copying.append(copy_loop())
                taken.append(stages_of(program, flight / "photos", stitch))
            decode_s, copy_s = statistics.median(decoding), statistics.median(copying)
            for stage in taken[0]:
                seconds = statistics.median(run[stage] for run in taken)
                measured[f"{name}: {stage}"] = {"decode": round(seconds / decode_s, 4), "copy": round(seconds / copy_s, 4)}
    return measured


def slower(lines, more_than):
    """(name, how many times as long by the loop that is kinder) of the last line against those before it."""
    *before, last = lines
    alike = [line for line in before if line["cores"] == last["cores"]][-BEFORE:]
    found = []
    for name, now in last["ratios"].items():
        then = [line["ratios"][name] for line in alike if name in line["ratios"]]
        if not then:
            continue
        times = min(now[loop] / max(statistics.median(one[loop] for one in then), 1e-9) for loop in ("decode", "copy"))
        # A stage of next to nothing is noise.
        if times > 1 + more_than / 100 and now["decode"] > 0.02:
            found.append((name, times))
    return sorted(found, key=lambda one: -one[1])


def read(file):
    return [json.loads(line) for line in file.read_text().splitlines() if line] if file.exists() else []


def record(asked):
    commit = subprocess.run(["git", "-C", HERE, "describe", "--always", "--dirty"], stdout=subprocess.PIPE, text=True).stdout.strip()
    line = {"commit": commit, "day": datetime.date.today().isoformat(), "cores": os.cpu_count(), "runs": asked.runs,
            "ratios": measure(asked.program, asked.runs)}
    with asked.file.open("a") as lines:
        lines.write(json.dumps(line) + "\n")


def compare(asked):
    lines = read(asked.file)
    if len(lines) < 2:
        print("There is nothing to compare yet: two lines are needed.")
        return 0
    found = slower(lines, asked.more_than)
    for name, times in found:
        print(f"{name}: {100 * (times - 1):.0f} % more than before")
    if not found:
        print(f"Nothing takes more than {asked.more_than:g} % more than before.")
    return 1 if found else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    recorder = commands.add_parser("record")
    recorder.add_argument("program", type=pathlib.Path)
    recorder.add_argument("--runs", type=int, default=5)
    comparer = commands.add_parser("compare")
    comparer.add_argument("--more-than", type=float, default=5, help="per cent (5)")
    for one in (recorder, comparer):
        one.add_argument("--file", type=pathlib.Path, default=LINES)
    asked = parser.parse_args()
    if asked.command == "record":
        record(asked)
    return compare(asked) if asked.command == "compare" else 0


if __name__ == "__main__":
    sys.exit(main())
