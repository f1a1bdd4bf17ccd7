"""How long the program takes to build from nothing: a cold build of the release preset in a temporary folder, without
ccache and on as many jobs as asked for. Prints the seconds, what the processors spent on it, and the ten slowest objects.

    python3 tests/bench/build_time.py [--jobs 2] [--target skyquilt] [--unity OFF] [--most 300]

With --most it fails where the build took more seconds than that. Other work on the machine makes the seconds longer, but
hardly what the processors spent: half of that is what two idle cores would take."""
import argparse
import os
import pathlib
import resource
import subprocess
import sys
import tempfile
import time

import proof

ROOT = pathlib.Path(__file__).resolve().parents[2]


def slowest(log, count):
    """(seconds, output) of the steps in a .ninja_log, slowest first."""
    steps = {}
    for line in log.read_text().splitlines():
        fields = line.split("\t")
        if len(fields) == 5:
            steps[fields[3]] = (int(fields[1]) - int(fields[0])) / 1000.0
    return sorted(((seconds, output) for output, seconds in steps.items()), reverse=True)[:count]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--target", default="skyquilt")
    parser.add_argument("--unity", default="ON", choices=["ON", "OFF"])
    parser.add_argument("--most", type=float, help="seconds")
    arguments = parser.parse_args()
    environment = dict(os.environ, CCACHE_DISABLE="1")
    with tempfile.TemporaryDirectory(prefix="skyquilt_build_time_") as folder:
        configure = ["cmake", "--preset", "release", "-S", str(ROOT), "-B", folder, f"-DSKYQUILT_UNITY={arguments.unity}",
                     "-DCMAKE_CXX_COMPILER_LAUNCHER=", "-DSKYQUILT_TESTS=OFF"]
        subprocess.run(configure, check=True, env=environment, stdout=subprocess.DEVNULL)
        load_before, start = os.getloadavg()[0], time.monotonic()
        used_before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(["ninja", "-C", folder, f"-j{arguments.jobs}", arguments.target], check=True, env=environment,
                       stdout=subprocess.DEVNULL)
        seconds = time.monotonic() - start
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        processor_s = used.ru_utime + used.ru_stime - used_before.ru_utime - used_before.ru_stime
        print(f"{seconds:.0f} s with {arguments.jobs} jobs, {processor_s:.0f} s of processor time; "
              f"load before {load_before:.1f}, after {os.getloadavg()[0]:.1f}")
        if arguments.target == "skyquilt" and arguments.unity == "ON":
            print(proof.beside_recorded("cold_build_cpu_s", processor_s))
        for object_s, output in slowest(pathlib.Path(folder, ".ninja_log"), 10):
            print(f"{object_s:7.1f} s  {output}")
    return 1 if arguments.most is not None and seconds > arguments.most else 0


if __name__ == "__main__":
    sys.exit(main())
