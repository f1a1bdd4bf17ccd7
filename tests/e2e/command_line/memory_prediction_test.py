"""Twenty flights: what `inspect` foretells of memory is an upper bound of what `stitch` takes, within a factor of
about two. python3 tests/e2e/command_line/memory_prediction_test.py [--quick]: with SKYQUILT_BINARY set. Prints the table."""
import json
import os
import pathlib
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from program import BINARY, run  # noqa: E402

MOST_TOO_HIGH = 2.2
# The limit is for the whole: small flights are mostly libraries, whose share of memory the machine decides.
SLACK_MIB = 60

SCENARIOS = [
    ("one photo", "--photos 1 --size 1600x1200"),
    ("three small", "--photos 3 --size 640x480"),
    ("forty small", "--photos 40 --size 800x600"),
    ("many small", "--photos 200 --size 800x600"),
    ("tiny photos", "--photos 120 --size 320x240"),
    ("middling", "--photos 30 --size 1600x1200"),
    ("middling, sixty", "--photos 60 --size 1600x1200"),
    ("large, four", "--photos 4 --size 4000x3000"),
    ("large, twenty", "--photos 20 --size 4000x3000"),
    ("very large, two", "--photos 2 --size 8000x6000"),
    ("upright", "--photos 20 --size 1200x1600"),
    ("very wide", "--photos 12 --size 3000x1000"),
    ("low flight, fine pixels", "--photos 12 --size 2000x1500 --height 8"),
    ("very low, large tiles", "--photos 6 --size 2000x1500 --height 4"),
    ("high flight", "--photos 20 --size 1600x1200 --height 400"),
    ("little overlap", "--photos 20 --size 1600x1200 --overlap 0.2 --sidelap 0.2"),
    ("much overlap", "--photos 40 --size 1600x1200 --overlap 0.95 --sidelap 0.9"),
    ("leaning", "--photos 20 --size 1600x1200 --tilt-deg 35"),
    ("hills", "--photos 30 --size 1600x1200 --relief-m 15"),
    ("date line and equator", "--photos 12 --size 1600x1200 --lat 0 --lon 180"),
]


def foretold_mib(photos):
    return json.loads(run("inspect", "--json", photos).stdout)["expected_memory_mib"]


def peak_mib(photos, out):
    job = subprocess.Popen([BINARY, "stitch", photos, "-o", out], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    errors = job.stderr.read()
    _, status, usage = os.wait4(job.pid, 0)
    job.returncode = os.waitstatus_to_exitcode(status)
    assert job.returncode == 0, errors.decode()
    return usage.ru_maxrss / 1024


def main():
    quick = "--quick" in sys.argv
    print(f"{'flight':<26}{'foretold':>10}{'peak MiB':>10}{'ratio':>8}")
    bad = []
    for name, options in SCENARIOS[::4] if quick else SCENARIOS:
        with tempfile.TemporaryDirectory() as folder:
            made = pathlib.Path(folder) / "flight"
            run("simulate", "-o", made, "--no-world", *options.split())
            foretold = foretold_mib(made / "photos")
            peak = peak_mib(made / "photos", pathlib.Path(folder) / "map")
        is_good = peak <= foretold <= MOST_TOO_HIGH * peak + SLACK_MIB
        print(f"{name:<26}{foretold:>10.0f}{peak:>10.0f}{foretold / peak:>8.2f}{'' if is_good else '  WRONG'}", flush=True)
        if not is_good:
            bad.append(name)
    assert not bad, f"foretold wrongly: {', '.join(bad)}"


if __name__ == "__main__":
    main()
