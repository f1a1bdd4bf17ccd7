"""What it costs to cut a large flight into units: the same flight by one worker that does not cut it, then cut by one worker
and by more, each run on a server of its own.

    python3 tests/bench/cluster/units_bench.py PROGRAM PHOTOS WORKERS...

With --machines every worker has a data folder of its own, the catalogue lies in PostgreSQL and photos and maps in an S3 store,
both started here for the run. Prints wall and processor seconds of the workers with all that they start, the largest process, and digests of the map, which
must not depend on how many workers there were. Photos to try it with: skyquilt simulate -o F --photos 2500 --size 640x480
--no-world, then F/photos.
"""
import argparse
import contextlib
import hashlib
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time
import urllib.request


WHOLE = ["--cut-above", "0"]
TESTS = pathlib.Path(__file__).resolve().parents[2]
sys.path += [str(TESTS / "support"), str(TESTS / "e2e")]


@contextlib.contextmanager
def machines():
    """Words for servers and workers that share nothing but a database and a store."""
    import s3_store
    from postgres_server import PostgresServer
    with PostgresServer() as database:
        store = s3_store.S3Store()
        try:
            os.environ.update(store.environment())
            yield ["--catalogue", database.url, "--blobs", store.address("bench")]
        finally:
            store.stop()


def digest_of(address):
    hasher = hashlib.sha256()
    with urllib.request.urlopen(address) as answer:
        while block := answer.read(1 << 20):
            hasher.update(block)
    return hasher.hexdigest()[:12]


def run(program, photos, workers, words, storage):
    with tempfile.TemporaryDirectory(prefix="units_bench_") as folder:
        data = pathlib.Path(folder, "data")
        data_of = [pathlib.Path(folder, f"worker-{i}") if storage else data for i in range(workers)]
        with open(f"{folder}/server.log", "w") as log:
            server = subprocess.Popen([program, "serve", "--data", data, "--listen", "127.0.0.1:0", "--workers", "0", *storage],
                                      stdout=subprocess.PIPE, stderr=log, text=True)
        address = re.search(r"http://[\d.:]+", server.stdout.readline()).group()
        subprocess.run([program, "upload", photos, "--server", address, "--name", "field", "--no-wait"], check=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        begun = time.time()
        logs = [open(f"{folder}/worker-{i}.log", "w+") for i in range(workers)]
        started = [subprocess.Popen(["/usr/bin/time", "-f", "cost %U %S %M", program, "worker", "--data", of, *storage,
                                     *words], stderr=log) for of, log in zip(data_of, logs)]
        while True:
            job = json.load(urllib.request.urlopen(f"{address}/api/v1/jobs"))["jobs"][0]
            if job["finished_at"]:
                break
            time.sleep(0.5)
        wall_s = time.time() - begun
        for worker in started:
            subprocess.run(["pkill", "-TERM", "-P", str(worker.pid)], check=False)
        cpu_s, peak_kib = 0.0, 0
        for worker, log in zip(started, logs):
            worker.wait()
            log.seek(0)
            cost = re.search(r"^cost ([\d.]+) ([\d.]+) (\d+)$", log.read(), re.MULTILINE)
            cpu_s += float(cost[1]) + float(cost[2])
            peak_kib = max(peak_kib, int(cost[3]))
        flight = f"{address}/api/v1/flights/{job['flight_id']}"
        digests = [digest_of(f"{flight}/download.{ending}") for ending in ("mbtiles", "pmtiles")]
        server.terminate()
        server.wait()
        return job["state"], wall_s, cpu_s, peak_kib / 1024, *digests


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("photos")
    parser.add_argument("workers", nargs="+", type=int)
    parser.add_argument("--machines", action="store_true", help="a data folder for each worker, PostgreSQL and S3 between them")
    parser.add_argument("--cut-above", type=int, help="files from which on the flight is cut, for a smaller one")
    parser.add_argument("--part-files", type=int, help="files of a unit that looks")
    parser.add_argument("--uncut-cpu-s", type=float, help="what the flight takes uncut, if that was measured a moment ago")
    options = parser.parse_args()
    print(f"{'workers':12} {'wall s':>8} {'CPU s':>8} {'ratio':>6} {'peak MiB':>9}  mbtiles       pmtiles")
    cut = [word for name in ("cut_above", "part_files") if (value := getattr(options, name)) is not None
           for word in (f"--{name.replace(chr(95), chr(45))}", str(value))]
    whole = options.uncut_cpu_s
    runs = [] if whole else [(1, WHOLE)]
    for workers, words in [*runs, *((count, cut) for count in options.workers)]:
        with machines() if options.machines else contextlib.nullcontext([]) as storage:
            state, wall_s, cpu_s, peak_mib, mbtiles, pmtiles = run(options.program, options.photos, workers, words, storage)
        whole = whole or cpu_s
        name = "1, not cut" if words == WHOLE else str(workers)
        print(f"{name:12} {wall_s:8.0f} {cpu_s:8.1f} {cpu_s / whole:6.2f} {peak_mib:9.0f}  {mbtiles}  {pmtiles}  {state}",
              flush=True)


if __name__ == "__main__":
    main()
