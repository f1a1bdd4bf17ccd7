"""What a tile costs, beside other servers sending the same tiles in the same minutes: CPU microseconds a request (which a
busy machine spoils least), 304s, memory with a hundred maps. Needs wrk, and of the peers (peers.py) what is installed:
python3 tests/bench/tiles/tiles_bench.py [--tile-bytes N] [--out FILE]."""
import argparse
import os
import pathlib
import re
import shutil
import socket
import sqlite3
import statistics
import subprocess
import sys
import tempfile
import time

import peers as others

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "e2e"))
from server_support import BINARY, Server, stitch_simulated  # noqa: E402

SECONDS, ROUNDS, CONNECTIONS, SLOW = 4, 3, 32, 1000
TICKS = os.sysconf("SC_CLK_TCK")


def processes(pid):
    """A process with its children, theirs included."""
    children = [int(text) for task in pathlib.Path(f"/proc/{pid}/task").iterdir() for text in (task / "children").read_text().split()]
    return [pid] + [below for child in children for below in processes(child)]


def cpu_s(pid):
    fields = [pathlib.Path(f"/proc/{each}/stat").read_text().rsplit(")", 1)[1].split() for each in processes(pid)]
    return sum(int(field[11]) + int(field[12]) for field in fields) / TICKS


def memory_mib(pid):
    return sum(int(re.search(r"^Pss:\s+(\d+)", pathlib.Path(f"/proc/{each}/smaps_rollup").read_text(), re.M).group(1))
               for each in processes(pid)) / 1024


def load(url, paths, pid, folder, header=""):
    """(CPU microseconds a request, requests a second)."""
    script = folder / "load.lua"
    script.write_text("local paths = {" + ",".join(f'"{path}"' for path in paths) + "}\nrequest = function()\n"
                      f"  return wrk.format('GET', paths[math.random(#paths)], {{{header}}})\nend\n")
    before = cpu_s(pid)
    said = subprocess.run(["wrk", "-t1", f"-c{CONNECTIONS}", f"-d{SECONDS}s", "-s", script, url], check=True,
                          capture_output=True, text=True).stdout
    spent = cpu_s(pid) - before
    if "Non-2xx" in said and not header:
        raise AssertionError(said)
    count = int(re.search(r"(\d+) requests in", said).group(1))
    return spent / count * 1e6, count / SECONDS


def median_ms(url, paths, folder):
    """Of the time that a tile takes, as one who asks for one after the other sees it."""
    script = folder / "median.lua"
    script.write_text("local paths = {" + ",".join(f'"{path}"' for path in paths) + "}\nrequest = function()\n"
                      "  return wrk.format('GET', paths[math.random(#paths)])\nend\n")
    said = subprocess.run(["wrk", "-t1", "-c2", f"-d{SECONDS}s", "--latency", "-s", script, url], check=True, capture_output=True,
                          text=True).stdout
    number, unit = re.search(r"50%\s+([\d.]+)(us|ms|s)", said).groups()
    return float(number) * {"us": 1e-3, "ms": 1.0, "s": 1e3}[unit]


def beside_slow_ones(server, url, paths, folder):
    """A tile's median time alone and beside a thousand who never finish their request; medians of rounds in turns."""
    alone, crowded = [], []
    for _ in range(ROUNDS):
        alone.append(median_ms(url, paths, folder))
        slow = [socket.create_connection(("127.0.0.1", server.port)) for _ in range(SLOW)]
        for client in slow:
            client.sendall(b"GET /healthz HTTP/1.1\r\nHost: ")
        crowded.append(median_ms(url, paths, folder))
        for client in slow:
            client.close()
    return statistics.median(alone), statistics.median(crowded)


def hundred_maps(data, flight):
    """The flight's map under 99 more names; their ids."""
    names = [f"{number:026d}" for number in range(99)]
    with sqlite3.connect(data / "catalogue.db") as db:
        for table, key in (("flight", "id"), ("revision", "flight_id")):
            columns = [row[1] for row in db.execute(f"PRAGMA table_info({table})") if row[1] != key]
            for name in names:
                db.execute(f"INSERT INTO {table} ({key}, {', '.join(columns)}) SELECT ?, {', '.join(columns)} FROM {table} WHERE {key} = ?",
                           (name, flight))
    for name in names:
        shutil.copytree(data / "flights" / flight, data / "flights" / name, ignore=shutil.ignore_patterns("files"))
        (data / "flights" / name / "files").mkdir()
    return [flight, *names]


def make_map(folder, tile_bytes):
    """(the server's data folder, the flight, its tiles as zoom, column, row from the south, bytes), none shorter than `tile_bytes`."""
    server, flight = stitch_simulated(folder)
    server.stop()
    [mbtiles] = (folder / "data/flights" / flight).glob("r*/mosaic.mbtiles")
    db = sqlite3.connect(mbtiles, isolation_level=None)
    if tile_bytes:
        db.execute("UPDATE tiles_data SET tile_data = CAST(tile_data || zeroblob(max(0, ? - length(tile_data))) AS BLOB)", (tile_bytes,))
        db.execute("UPDATE tiles_shallow SET tile_bytes = max(tile_bytes, ?)", (tile_bytes,))
        db.execute("VACUUM")
    return folder / "data", flight, db.execute("SELECT * FROM tiles").fetchall()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--out", default="")
    parser.add_argument("--tile-bytes", type=int, default=0, help="shorter tiles are filled up with zeros")
    arguments = parser.parse_args()
    if not shutil.which("wrk"):
        sys.exit("wrk is not here: apt-get install wrk")
    folder = pathlib.Path(tempfile.mkdtemp(prefix="skyquilt_bench_"))
    os.chmod(folder, 0o755)
    data, flight, tiles = make_map(folder, arguments.tile_bytes)
    maps = hundred_maps(data, flight)
    started = time.monotonic()
    server = Server(data, "--workers", "0")
    ready_s = time.monotonic() - started
    below = [f"{zoom}/{column}/{2**zoom - 1 - row}" for zoom, column, row, _ in tiles]
    mine = [f"/tiles/{flight}/{path}" for path in below]
    url = f"http://127.0.0.1:{server.port}"
    etag = server.request("GET", mine[0])[1]["ETag"].replace('"', '\\"')
    known = f'["If-None-Match"]="{etag}"'
    rivals, missing = others.start_all(folder, tiles)
    rows = {name: [] for name in ["skyquilt", "skyquilt, 304", *(rival.name for rival in rivals)]}
    try:
        for _ in range(ROUNDS):  # in turns, so that a busy spell hits all alike
            rows["skyquilt"].append(load(url, mine, server.process.pid, folder))
            rows["skyquilt, 304"].append(load(url, mine[:1], server.process.pid, folder, known))
            for rival in rivals:
                rows[rival.name].append(load(rival.url, rival.paths, rival.pid, folder))
        alone_ms, crowded_ms = beside_slow_ones(server, url, mine, folder)
        load(url, [f"/tiles/{name}/{path}" for name in maps for path in below[:: max(1, len(below) // 20)]], server.process.pid, folder)
        used_mib = memory_mib(server.process.pid)
    finally:
        for rival in rivals:
            rival.stop()
        server.stop()
        shutil.rmtree(folder)
    best = {name: min(cost for cost, _ in rounds) for name, rounds in rows.items()}
    size = sum(len(content) for _, _, _, content in tiles) / len(tiles)
    lines = [f"{len(tiles)} tiles of {size / 1000:.1f} KB on average, {CONNECTIONS} connections, best of {ROUNDS} rounds of {SECONDS} s",
             "", "| server | CPU us a request | requests a second | skyquilt costs of it |", "|---|---|---|---|"]
    for name, rounds in rows.items():
        lines.append(f"| {name} | {best[name]:.1f} | {max(rate for _, rate in rounds):.0f} | {best['skyquilt'] / best[name]:.2f} |")
    lines += ["", f"Memory of skyquilt with {len(maps)} maps asked for: {used_mib:.0f} MiB; ready {ready_s:.2f} s after its start"]
    lines += [f"Median time of a tile {alone_ms:.3f} ms, beside {SLOW} slow connections {crowded_ms:.3f} ms ({crowded_ms / alone_ms:.2f} times)"]
    lines += [f"Not here: {name}" for name in missing]
    text = "\n".join(lines) + "\n"
    print(text)
    if arguments.out:
        pathlib.Path(arguments.out).write_text(text)


if __name__ == "__main__":
    main()
