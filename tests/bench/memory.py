"""Peak memory of `skyquilt stitch`: python3 tests/bench/memory.py build/release/bin/skyquilt [FOLDER_OF_PHOTOS]
Prints a line for the given photos (skipped without) and one for a simulated flight of 500; fails above the bars."""
import pathlib
import resource
import subprocess
import sys
import tempfile
import time

GIB = 1 << 30


def stitch(program, photos, out):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    start = time.monotonic()
    subprocess.run([program, "stitch", str(photos), "-o", str(out)], check=True, stdout=subprocess.DEVNULL,
                   stderr=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    # The peak of all children so far; the simulator and the smaller flight stay below what is measured after them.
    return after.ru_maxrss * 1024, time.monotonic() - start, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def measure(program, name, photos, bar):
    with tempfile.TemporaryDirectory() as out:
        peak, wall_s, cpu_s = stitch(program, photos, out)
    verdict = "ok" if peak <= bar else "TOO MUCH"
    print(f"{name:<28} peak {peak / GIB:5.2f} GiB (bar {bar / GIB:.2f})  wall {wall_s:6.1f} s  cpu {cpu_s:6.1f} s  {verdict}", flush=True)
    return peak <= bar


def main():
    program = sys.argv[1]
    good = True
    if len(sys.argv) > 2:
        good &= measure(program, pathlib.Path(sys.argv[2]).parent.name, sys.argv[2], GIB)
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([program, "simulate", "-o", folder, "--photos", "500", "--size", "800x600", "--no-world"], check=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        good &= measure(program, "simulated, 500 photos", pathlib.Path(folder) / "photos", 1.5 * GIB)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
