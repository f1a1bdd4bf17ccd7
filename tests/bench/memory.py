"""Peak memory and growth of `skyquilt stitch`: python3 tests/bench/memory.py PROGRAM [FOLDER_OF_PHOTOS]
[--photos 50,200,1000]. Simulated flights of these sizes (and the folder, if given): the peak must stay below the bar
whatever the size, and processor time must grow no faster than the number of photos to the power of 1.1."""
import argparse
import math
import pathlib
import subprocess
import sys
import tempfile

from whole_job import timed

GIB = 1 << 30
MOST_EXPONENT = 1.1


def measure(program, name, photos, bar):
    with tempfile.TemporaryDirectory() as out:
        wall_s, cpu_s, peak = timed([program, "stitch", photos, "-o", out])
    verdict = "ok" if peak <= bar else "TOO MUCH"
    print(f"{name:<28} peak {peak / GIB:5.2f} GiB (bar {bar / GIB:.2f})  wall {wall_s:6.1f} s  cpu {cpu_s:6.1f} s  {verdict}", flush=True)
    return peak <= bar, cpu_s


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("program")
    arguments.add_argument("folder", nargs="?", type=pathlib.Path)
    arguments.add_argument("--photos", default="50,200,1000")
    asked = arguments.parse_args()
    good = True
    if asked.folder:
        good &= measure(asked.program, asked.folder.resolve().parent.name, asked.folder, GIB)[0]
    costs = []
    for count in (int(number) for number in asked.photos.split(",")):
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([asked.program, "simulate", "-o", folder, "--photos", str(count), "--size", "800x600", "--no-world"],
                           check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            fits, cpu_s = measure(asked.program, f"simulated, {count} photos", pathlib.Path(folder) / "photos", 1.5 * GIB)
        good &= fits
        costs.append((count, cpu_s))
    if len(costs) > 1:
        (first, first_s), (last, last_s) = costs[0], costs[-1]
        exponent = math.log(last_s / first_s) / math.log(last / first)
        good &= exponent <= MOST_EXPONENT
        print(f"processor time grows with the photos to the power of {exponent:.2f} (bar {MOST_EXPONENT})")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
