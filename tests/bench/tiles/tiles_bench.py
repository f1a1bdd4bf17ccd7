"""What a tile costs, beside nginx sending the same tiles as files: CPU microseconds a request (which a busy machine does
not spoil), 304s, memory with many maps. Needs wrk and nginx: python3 tests/bench/tiles/tiles_bench.py [--out FILE]."""
import argparse
import os
import pathlib
import re
import shutil
import sqlite3
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "e2e"))
from server_support import BINARY, Server  # noqa: E402

SECONDS, ROUNDS, CONNECTIONS = 4, 3, 32
TICKS = os.sysconf("SC_CLK_TCK")
NGINX = """worker_processes 2; pid {folder}/nginx.pid; error_log stderr; daemon off; events {{ worker_connections 4096; }}
http {{ access_log off; sendfile on; tcp_nopush on; keepalive_requests 1000000; server {{ listen 127.0.0.1:{port}; root {folder}/tiles; }} }}"""


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


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--out", default="")
    arguments = parser.parse_args()
    for tool in ("wrk", "nginx"):
        if not shutil.which(tool):
            sys.exit(f"{tool} is not here: apt-get install wrk nginx-light")
    folder = pathlib.Path(tempfile.mkdtemp(prefix="skyquilt_bench_"))
    subprocess.run([BINARY, "simulate", "-o", folder / "sim", "--photos", "8", "--size", "1600x1200", "--no-world"], check=True,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    photos = [(path.name, path.read_bytes()) for path in sorted((folder / "sim/photos").iterdir()) if path.suffix.upper() == ".JPG"]
    server = Server(folder / "data", "--workers", "1")
    _, made = server.upload(photos)
    assert server.wait_for_job(made["job"]["id"])["state"] == "successful"
    flight = made["flight"]["id"]
    [mbtiles] = (folder / "data/flights" / flight).glob("r*/mosaic.mbtiles")
    tiles = []
    for zoom, column, tms_row, content in sqlite3.connect(mbtiles).execute("SELECT * FROM tiles"):
        path = f"{zoom}/{column}/{2**zoom - 1 - tms_row}"
        tiles.append((path, content))
        file = folder / "tiles" / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(content)
    os.chmod(folder, 0o755)
    server.stop()
    server = Server(folder / "data", "--workers", "0")
    port = server.port + 1 if server.port < 60000 else server.port - 1
    (folder / "nginx.conf").write_text(NGINX.format(folder=folder, port=port))
    nginx = subprocess.Popen(["nginx", "-c", folder / "nginx.conf"])
    time.sleep(1)
    mine = [f"/tiles/{flight}/{path}" for path, _ in tiles]
    theirs = [f"/{path}" for path, _ in tiles]
    etag = server.request("GET", mine[0])[1]["ETag"].replace('"', '\\"')
    rows = {"skyquilt": [], "skyquilt, 304": [], "nginx, static files": []}
    try:
        for _ in range(ROUNDS):  # in turns, so that a busy spell hits all alike
            rows["skyquilt"].append(load(f"http://127.0.0.1:{server.port}", mine, server.process.pid, folder))
            rows["skyquilt, 304"].append(load(f"http://127.0.0.1:{server.port}", mine[:1], server.process.pid, folder,
                                              f'["If-None-Match"]="{etag}"'))
            rows["nginx, static files"].append(load(f"http://127.0.0.1:{port}", theirs, nginx.pid, folder))
        used_mib = memory_mib(server.process.pid)
    finally:
        nginx.terminate()
        nginx.wait()
        server.stop()
        shutil.rmtree(folder)
    size = sum(len(content) for _, content in tiles) / len(tiles)
    lines = [f"{len(tiles)} tiles of {size / 1000:.1f} KB on average, {CONNECTIONS} connections, best of {ROUNDS} rounds of {SECONDS} s",
             "", "| server | CPU us a request | requests a second |", "|---|---|---|"]
    for name, rounds in rows.items():
        lines.append(f"| {name} | {min(cost for cost, _ in rounds):.1f} | {max(rate for _, rate in rounds):.0f} |")
    lines += ["", f"Memory of skyquilt after it: {used_mib:.0f} MiB"]
    text = "\n".join(lines) + "\n"
    print(text)
    if arguments.out:
        pathlib.Path(arguments.out).write_text(text)


if __name__ == "__main__":
    main()
