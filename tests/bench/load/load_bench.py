"""Everything at once: 10,000 queued jobs, 1,000 listeners to events, 8 clients on @2x tiles, 24 WMS pictures at a time, and for
30 s a write lock on the catalogue, while one client asks for plain tiles, one after the other, and one for /healthz. Only
loopback, about a minute. Prints a table in Markdown:
python3 tests/bench/load/load_bench.py [--claims PROGRAM] [--quiet-s 8] [--locked-s 30]
PROGRAM is build/release/bin/claim_jobs; without it claims are not measured."""
import argparse
import asyncio
import multiprocessing
import os
import pathlib
import re
import sqlite3
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "e2e"))
from server_support import BINARY, Server, stitch_simulated  # noqa: E402

JOBS, OWNERS, LISTENERS, DOUBLES, PICTURES = 10_000, 100, 1000, 8, 24
TICKS = os.sysconf("SC_CLK_TCK")


def make_map(folder):
    """(data folder, flight, its bounds, the paths of all its tiles)."""
    server, flight = stitch_simulated(folder)
    _, document = server.json("GET", f"/tiles/{flight}.json")
    server.stop()
    [mbtiles] = (folder / "data/flights" / flight).glob("r*/mosaic.mbtiles")
    rows = sqlite3.connect(mbtiles).execute("SELECT zoom_level, tile_column, tile_row FROM tiles").fetchall()
    return folder / "data", flight, document["bounds"], [f"/tiles/{flight}/{z}/{x}/{2**z - 1 - y}" for z, x, y in rows]


def queue_jobs(data):
    with sqlite3.connect(data / "catalogue.db") as db:
        numbers = f"WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < {JOBS})"
        db.execute(f"{numbers} INSERT INTO flight(id, name, created_us) SELECT printf('{'0' * 18}%08d', i), 'queued', 0 FROM n")
        db.execute(f"{numbers} INSERT INTO job(id, flight_id, state, created_us, owner) SELECT printf('{'0' * 18}%08d', i), "
                   f"printf('{'0' * 18}%08d', i), 'accepted', 0, 'owner' || (i % {OWNERS}) FROM n")


async def answer(reader):
    """(status, body) of one answer with a length."""
    head = (await reader.readuntil(b"\r\n\r\n")).decode()
    length = re.search(r"content-length: (\d+)", head, re.I)
    body = await reader.readexactly(int(length.group(1))) if length else b""
    return int(head.split()[1]), body


class Client:
    def __init__(self, port):
        self.port, self.writer = port, None

    async def get(self, path):
        if self.writer is None:
            self.reader, self.writer = await asyncio.open_connection("127.0.0.1", self.port)
        self.writer.write(f"GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n".encode())
        return (await answer(self.reader))[0]


def probe(port, paths, pause_s, end, results):
    """One after the other in a process of its own: [(when, took, status)]."""
    async def run():
        client, found, number = Client(port), [], 0
        while time.monotonic() < end:
            begin = time.monotonic()
            try:
                status = await asyncio.wait_for(client.get(paths[number % len(paths)]), 60)
            except (OSError, asyncio.IncompleteReadError, asyncio.TimeoutError):
                status, client.writer = 0, None
            found.append((begin, time.monotonic() - begin, status))
            number += 1
            await asyncio.sleep(pause_s)
        results.put(found)

    asyncio.run(run())


def crowd(port, paths, picture, end, ready, results):
    """Listeners, clients on @2x and on WMS, in a process of their own. They give way to the server: clients have
    processors of their own, and what is measured is the server."""
    os.nice(19)
    counts = {"heard": 0, "listening": 0}

    async def listen():
        reader, writer = await asyncio.open_connection("127.0.0.1", port)
        writer.write(b"GET /api/v1/events HTTP/1.1\r\nHost: localhost\r\n\r\n")
        if b" 200 " in await reader.readline():
            counts["listening"] += 1
        while line := await reader.readline():
            counts["heard"] += line.startswith(b"event:")

    async def ask(kind, path_of):
        client, number = Client(port), 0
        while time.monotonic() < end:
            try:
                status = await client.get(path_of(number))
            except (OSError, asyncio.IncompleteReadError):
                status, client.writer = 0, None
            counts[kind, status] = counts.get((kind, status), 0) + 1
            number += 1
            if status != 200:
                await asyncio.sleep(0.5)

    async def run():
        listeners = []
        for _ in range(LISTENERS):
            listeners.append(asyncio.create_task(listen()))
            if len(listeners) % 50 == 0:
                await asyncio.sleep(0.05)
        while counts["listening"] < LISTENERS and time.monotonic() < end:
            await asyncio.sleep(0.1)
        ready.set()
        await asyncio.gather(*(ask("@2x", lambda n, k=k: paths[(n * DOUBLES + k) % len(paths)] + "@2x.png") for k in range(DOUBLES)),
                             *(ask("WMS", lambda n: picture) for _ in range(PICTURES)))
        for task in listeners:
            task.cancel()
        results.put(counts)

    asyncio.run(run())


def at(sorted_values, share):
    return sorted_values[min(len(sorted_values) - 1, int(len(sorted_values) * share))] if sorted_values else float("nan")


def row(name, found, begin, end):
    took = sorted(1e3 * time_s for when, time_s, _ in found if begin <= when < end)
    failed = sum(1 for when, _, status in found if begin <= when < end and status not in (200, 204))
    return f"| {name} | {len(took)} | {at(took, 0.5):.1f} | {at(took, 0.99):.1f} | {took[-1] if took else 0:.1f} | {failed} |"


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--claims", default="")
    parser.add_argument("--quiet-s", type=float, default=8)
    parser.add_argument("--locked-s", type=float, default=30)
    arguments = parser.parse_args()
    folder = pathlib.Path(tempfile.mkdtemp(prefix="skyquilt_load_"))
    data, flight, (west, south, east, north), paths = make_map(folder)
    queue_jobs(data)
    server = Server(data, "--workers", "0")
    picture = (f"/wms/{flight}?SERVICE=WMS&VERSION=1.1.1&REQUEST=GetMap&LAYERS=map&STYLES=&SRS=EPSG:4326"
               f"&BBOX={west},{south},{east},{north}&WIDTH=1600&HEIGHT=1600&FORMAT=image/png")
    results, ready = multiprocessing.Queue(), multiprocessing.Event()
    gather_s = 15
    end = time.monotonic() + gather_s + 2 * arguments.quiet_s + arguments.locked_s
    helpers = [multiprocessing.Process(target=crowd, args=(server.port, paths, picture, end, ready, results))]
    helpers[0].start()
    ready.wait(gather_s)
    crowded = time.monotonic()
    tiles, health = multiprocessing.Queue(), multiprocessing.Queue()
    helpers += [multiprocessing.Process(target=probe, args=(server.port, paths, 0.005, end, tiles)),
                multiprocessing.Process(target=probe, args=(server.port, ["/healthz"], 0.02, end, health))]
    for helper in helpers[1:]:
        helper.start()
    time.sleep(arguments.quiet_s / 2)
    claims = ""
    if arguments.claims:
        claims = subprocess.run([arguments.claims, data / "catalogue.db", "200"], check=True, capture_output=True, text=True).stdout
    time.sleep(arguments.quiet_s / 2)
    lock = sqlite3.connect(data / "catalogue.db", isolation_level=None, timeout=30)
    lock.execute("BEGIN IMMEDIATE")
    locked = time.monotonic()
    time.sleep(arguments.locked_s)
    lock.execute("ROLLBACK")
    unlocked = time.monotonic()
    of_tiles, of_health, counts = tiles.get(), health.get(), results.get()
    for helper in helpers:
        helper.join()
    fields = pathlib.Path(f"/proc/{server.process.pid}/stat").read_text().rsplit(")", 1)[1].split()
    cpu_s = (int(fields[11]) + int(fields[12])) / TICKS
    begin = time.monotonic()
    server.stop()
    stop_s = time.monotonic() - begin
    print(f"{JOBS} queued jobs, {counts['listening']} listeners, {DOUBLES} clients on @2x, {PICTURES} WMS pictures at once")
    print("\n| one after the other | answers | median ms | p99 ms | longest ms | not answered |\n|---|---|---|---|---|---|")
    for name, found in (("plain tile", of_tiles), ("/healthz", of_health)):
        print(row(name, found, crowded, locked))
        print(row(f"{name}, write lock held", found, locked, unlocked))
    if claims:
        count, median, p99, longest = claims.split()
        print(f"| claim | {count} | {median} | {p99} | {longest} | 0 |")
    kinds = ", ".join(f"{kind} {status}: {count}" for (kind, status), count in sorted(
        (key, value) for key, value in counts.items() if isinstance(key, tuple)))
    print(f"\nAnswers of the crowd: {kinds}. The server took {cpu_s:.1f} s of processor time and ended {stop_s:.1f} s after it was told to.")


if __name__ == "__main__":
    main()
