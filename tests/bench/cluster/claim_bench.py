"""How long a claim takes of a queue of 10,000 jobs in PostgreSQL, with 16 claimants at once. Server (fsync on, its settings
as Debian has them) and claimants share this machine.

python3 tests/bench/cluster/claim_bench.py build/bench/bin/claim_bench"""
import pathlib
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "support"))
from postgres_server import PostgresServer

CASES = [  # claimants, owners, pause after each claim in milliseconds
    (1, 1, 0),
    (16, 1, 0),
    (16, 1, 20),
    (16, 200, 0),
    (16, 200, 20),
]

print("| claimants | owners | pause, ms | claims | per second | median, ms | p99, ms | longest, ms |")
print("|---|---|---|---|---|---|---|---|")
with PostgresServer() as server:
    for claimants, owners, pause_ms in CASES:
        said = subprocess.run([sys.argv[1], server.url, "10000", str(claimants), str(owners), str(pause_ms)], check=True,
                              stdout=subprocess.PIPE, text=True).stdout
        count, rate, median, p99, longest = said.split()
        print(f"| {claimants} | {owners} | {pause_ms} | {count} | {rate} | {median} | {p99} | {longest} |", flush=True)
