"""How soon a flight shows: from the last byte of its first photo to the first tile of its preview, and to the preview of
all its photos; the machine otherwise as it is. Written to OUT as a table.
    python3 tests/bench/preview/first_tile.py PROGRAM PHOTOS [ROUNDS] [OUT]"""
import http.client
import json
import math
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile
import time

PATIENCE_S = 300


def request(port, method, path, body=None):
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=PATIENCE_S)
    headers = {"Content-Type": "application/json"} if method == "POST" else {}
    connection.request(method, path, body, headers)
    response = connection.getresponse()
    answer = response.status, response.read()
    connection.close()
    return answer


def preview_of(port, flight, least):
    """Seconds of the clock when the preview holds so many photos, and it."""
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        preview = json.loads(request(port, "GET", f"/api/v1/flights/{flight}")[1])["preview"]
        if preview and preview["photos"] >= least:
            return preview
        time.sleep(0.01)
    raise SystemExit("the preview did not come")


def one_round(port, photos):
    flight = json.loads(request(port, "POST", "/api/v1/flights", "{}")[1])["id"]
    content = photos[0].read_bytes()
    status, _ = request(port, "PUT", f"/api/v1/flights/{flight}/files/{photos[0].name}", content)
    arrived = time.monotonic()
    assert status == 201, status
    preview = preview_of(port, flight, 1)
    tilejson = json.loads(request(port, "GET", preview["tilejson"])[1])
    longitude, latitude, _ = tilejson["center"]
    zoom = tilejson["minzoom"]
    x = int((longitude + 180) / 360 * (1 << zoom))
    y = int((1 - math.asinh(math.tan(math.radians(latitude))) / math.pi) / 2 * (1 << zoom))
    status, tile = request(port, "GET", f"/tiles/{flight}/{zoom}/{x}/{y}?rev=preview")
    assert status == 200 and tile, status
    first_s = time.monotonic() - arrived
    for photo in photos[1:]:
        request(port, "PUT", f"/api/v1/flights/{flight}/files/{photo.name}", photo.read_bytes())
    arrived = time.monotonic()
    preview_of(port, flight, len(photos))
    return first_s, time.monotonic() - arrived


def main():
    program, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    rounds = int(sys.argv[3]) if len(sys.argv) > 3 else 5
    photos = sorted(path for path in folder.iterdir() if path.suffix.lower() in (".jpg", ".jpeg"))
    with tempfile.TemporaryDirectory(prefix="skyquilt_bench_") as data:
        server = subprocess.Popen([program, "serve", "--data", data, "--listen", "127.0.0.1:0"], stdout=subprocess.PIPE, text=True)
        try:
            port = int(re.search(r":(\d+)/", server.stdout.readline()).group(1))
            measured = [one_round(port, photos) for _ in range(rounds)]
        finally:
            server.terminate()
            server.wait()
    first = [row[0] for row in measured]
    rest = [row[1] for row in measured]
    table = (f"{len(photos)} photos of {photos[0].stat().st_size / 1e6:.1f} MB, {rounds} rounds\n"
             f"first preview tile after the first photo's last byte: median {statistics.median(first):.2f} s, worst {max(first):.2f} s\n"
             f"preview of all after the last photo's last byte: median {statistics.median(rest):.2f} s, worst {max(rest):.2f} s\n")
    print(table, end="")
    if len(sys.argv) > 4:
        pathlib.Path(sys.argv[4]).write_text(table)
    if max(first) > 3.0:
        raise SystemExit("later than 3 s")


if __name__ == "__main__":
    main()
