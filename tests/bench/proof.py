"""What it costs to prove a change: runs the short suite in a built tree, prints its slowest tests and its totals beside those
recorded in proof.json, and answers what ctest answers.

    python3 tests/bench/proof.py [--jobs 2] [--build build/release]
    python3 tests/bench/proof.py --record [--jobs 2]        the totals become the recorded ones

`cold_build_cpu_s` of proof.json is build_time.py's. Seconds of the processor hold on a busy machine, those of the clock do not;
a total that grew by more than a tenth is said, and is either mended or recorded knowingly."""
import argparse
import json
import os
import pathlib
import resource
import subprocess
import sys
import time
import xml.etree.ElementTree

ROOT = pathlib.Path(__file__).resolve().parents[2]
RECORDED = pathlib.Path(__file__).with_name("proof.json")
SHOWN = 20


def beside_recorded(name, seconds):
    """The line about one total."""
    recorded = json.loads(RECORDED.read_text())[name]
    line = f"{name}: {seconds:.0f} (recorded: {recorded})"
    if seconds > 1.1 * recorded:
        line += f"\n  It grew by {100 * (seconds / recorded - 1):.0f} %: mend it, or record it in {RECORDED.relative_to(ROOT)} and say why."
    return line


def record(name, seconds):
    RECORDED.write_text(json.dumps({**json.loads(RECORDED.read_text()), name: round(seconds)}, indent=2) + "\n")


def children_cpu_s():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build" / "release")
    parser.add_argument("--record", action="store_true")
    arguments = parser.parse_args()
    told = arguments.build.resolve() / "short_suite.xml"
    start = time.monotonic()
    done = subprocess.run(["ctest", "--test-dir", str(arguments.build), "-LE", "long", "--output-on-failure", f"-j{arguments.jobs}",
                           "--output-junit", str(told)])
    cpu_s = children_cpu_s()
    cases = xml.etree.ElementTree.parse(told).getroot().iter("testcase")
    slowest = sorted(((float(case.get("time")), case.get("name")) for case in cases), reverse=True)[:SHOWN]
    for seconds, name in slowest:
        print(f"{seconds:7.1f} s  {name}")
    print(f"{len(slowest)} slowest tests above; all: {time.monotonic() - start:.0f} s by the clock")
    print(beside_recorded("short_suite_cpu_s", cpu_s))
    if arguments.record and done.returncode == 0:
        record("short_suite_cpu_s", cpu_s)
    return done.returncode


if __name__ == "__main__":
    sys.exit(main())
