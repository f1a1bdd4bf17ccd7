"""The table of docs/cluster.md about what faults_test.py did: of lines that `--results` wrote, in one file or several.

    python3 tests/e2e/cluster/faults_table.py faults.jsonl...           writes it
    python3 tests/e2e/cluster/faults_table.py --print faults.jsonl...   prints it

A seed that was run again counts by its last line. Exit code 1 where one of them failed."""
import json
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[3]
PAGE = ROOT / "docs" / "cluster.md"
BEGIN, END = "<!-- faults: faults_table.py -->\n", "<!-- end of faults -->\n"

sys.path.insert(0, str(ROOT / "tests" / "e2e"))
sys.path.insert(0, str(ROOT / "tests" / "support"))
from cluster.fault_kinds import KINDS, OF_WORKERS  # noqa: E402
from cluster.faults_test import STAGES  # noqa: E402


def read(files):
    """By seed."""
    lines = [line for file in files for line in pathlib.Path(file).read_text().splitlines()]
    return {result["seed"]: result for result in map(json.loads, lines)}


def charged_in(results, took_a_worker):
    return sum(result.get("charged", 0) for result in results
               if any(fault["kind"] in OF_WORKERS for fault in result["faults"]) == took_a_worker)


def row(name, results, of_kind):
    """How often it fell in which stage, and what the seeds with it came to."""
    fell = [sum(of_kind(fault["kind"]) and fault["stage"] == stage for result in results for fault in result["faults"]) for stage in STAGES]
    mine = [result for result in results if any(of_kind(fault["kind"]) for fault in result["faults"])]
    well = sum("failure" not in result for result in mine)
    return f"| {name} | {' | '.join(str(count or '') for count in fell)} | {well} of {len(mine)} | {charged_in(mine, False)} |"


def table(results):
    head = f"| what | {' | '.join(STAGES)} | seeds well | attempts charged |\n|---|{'---|' * (len(STAGES) + 2)}\n"
    rows = [row(kind, results, lambda name, kind=kind: name == kind) for kind in KINDS]
    rows.append(row("all", results, lambda name: True))
    seconds = sum(result["seconds"] for result in results)
    failed = sum(result["store_answers_failed"] for result in results)
    return (head + "\n".join(rows) + f"\n\n{len(results)} seeds, {seconds / len(results):.0f} s each; {failed} answers of the store were a 500 or a 503. "
            f"Attempts charged are those of seeds in which no worker was taken; in the others {charged_in(results, True)}.\n")


def main(arguments):
    is_printed = arguments[0] == "--print"
    by_seed = read(arguments[is_printed:])
    made = table([by_seed[seed] for seed in sorted(by_seed)])
    if is_printed:
        print(made)
    else:
        page = PAGE.read_text()
        PAGE.write_text(re.sub(f"(?s)({re.escape(BEGIN)}).*?({re.escape(END)})", lambda found: found[1] + made + found[2], page, count=1))
    return any("failure" in result for result in by_seed.values())


if __name__ == "__main__":
    sys.exit(__doc__ if len(sys.argv) < 2 else main(sys.argv[1:]))
