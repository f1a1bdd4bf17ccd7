"""What GIS programs cost the server: a tile as .png first and again, a tile as it is stored, and a pan over 200 tiles as QGIS
makes it, by QGIS itself where it is (python3-qgis) and by the same requests one by one. Milliseconds are the client's, CPU is
the server's with its children, from /proc: python3 tests/bench/tiles/pan_bench.py"""
import argparse
import http.client
import math
import os
import pathlib
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree as xml_parser

from tiles_bench import cpu_s, make_map

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "e2e"))
from server_support import Server  # noqa: E402

WORLD_M = 20037508.342789244
PAN_TILES, WINDOW_TILES, STORED_ROUNDS = 200, (4, 3), 20
QGIS_PAN = r"""
import sys
from qgis.core import QgsApplication, QgsCoordinateReferenceSystem, QgsMapRendererParallelJob, QgsMapSettings, QgsRasterLayer, QgsRectangle
from qgis.PyQt.QtCore import QSize
source, width, height, *extents = sys.argv[1:]
application = QgsApplication([], False)
application.initQgis()
layer = QgsRasterLayer(source, "map", "wms")
assert layer.isValid(), layer.error().message()
for extent in extents:
    settings = QgsMapSettings()
    settings.setLayers([layer])
    settings.setDestinationCrs(QgsCoordinateReferenceSystem("EPSG:3857"))
    settings.setExtent(QgsRectangle(*map(float, extent.split(","))))
    settings.setOutputSize(QSize(int(width), int(height)))
    settings.setOutputDpi(96)
    job = QgsMapRendererParallelJob(settings)
    job.start()
    job.waitForFinished()
    assert not job.errors(), [error.message for error in job.errors()]
"""


class Client:
    """One connection kept open, as map programs keep theirs; what it was answered is not looked at further."""

    def __init__(self, port):
        self.connection = http.client.HTTPConnection("127.0.0.1", port)

    def get(self, path):
        """Milliseconds until the last byte."""
        started = time.perf_counter()
        self.connection.request("GET", path, headers={"User-Agent": "Mozilla/5.0 QGIS/32214"})
        answer = self.connection.getresponse()
        answer.read()
        assert answer.status in (200, 204), (path, answer.status)
        return (time.perf_counter() - started) * 1e3


def spent(server, what):
    """(what it gives, the server's CPU seconds meanwhile)."""
    before = cpu_s(server.process.pid)
    given = what()
    return given, cpu_s(server.process.pid) - before


def inner_tiles(tiles):
    """Of the finest zoom, with neighbours all round: x, y from the north."""
    zoom = max(tile[0] for tile in tiles)
    there = {(column, 2**zoom - 1 - row) for level, column, row, _ in tiles if level == zoom}
    around = [(right, down) for right in (-1, 0, 1) for down in (-1, 0, 1)]
    return zoom, sorted((x, y) for x, y in there if all((x + right, y + down) in there for right, down in around))


def pan_windows(zoom, inner):
    """Windows of a screen, side by side over the map, until they show 200 tiles: (extent in EPSG:3857, tiles)."""
    tile_m = 2 * WORLD_M / 2**zoom
    wide, high = WINDOW_TILES
    (left, top), (right, _) = inner[0], inner[-1]
    columns = max(1, math.ceil((right + 1 - left) / wide))
    windows = []
    for number in range(math.ceil(PAN_TILES / (wide * high))):
        x, y = left + wide * (number % columns), top + high * (number // columns)
        west, north = x * tile_m - WORLD_M, WORLD_M - y * tile_m
        windows.append(((west, north - high * tile_m, west + wide * tile_m, north), [(x + i, y + j) for j in range(high) for i in range(wide)]))
    return windows


def tiles_answered(server):
    """Requests for tiles so far, as the server counts them."""
    lines = server.request("GET", "/metrics")[2].decode().splitlines()
    return sum(int(float(line.split()[-1])) for line in lines if line.startswith("skyquilt_request_seconds_count") and '"tile"' in line)


def qgis_pan(server, flight, windows):
    """(server CPU seconds of the pan by QGIS, tiles that it asked for), or None where QGIS is not here."""
    if subprocess.run([sys.executable, "-c", "import qgis.core"], capture_output=True).returncode != 0:
        return None
    xml = server.request("GET", f"/connect/{flight}/qgis.qlr")[2]
    source = xml_parser.fromstring(xml).find("maplayers/maplayer/datasource").text
    extents = [",".join(map(repr, extent)) for extent, _ in windows]
    with tempfile.TemporaryDirectory() as home:  # nothing is cached from the run before
        run = [sys.executable, "-c", QGIS_PAN, source, *(str(256 * tiles) for tiles in WINDOW_TILES), *extents]
        before = tiles_answered(server)
        _, cost_s = spent(server, lambda: subprocess.run(run, check=True, capture_output=True, cwd=home,
                                                         env={**os.environ, "QT_QPA_PLATFORM": "offscreen", "HOME": home}))
    return cost_s, tiles_answered(server) - before


def main():
    argparse.ArgumentParser(description=__doc__).parse_args()
    folder = pathlib.Path(tempfile.mkdtemp(prefix="skyquilt_bench_"))
    data, flight, tiles = make_map(folder)
    server = Server(data, "--workers", "0")
    try:
        client = Client(server.port)
        zoom, inner = inner_tiles(tiles)
        some = inner[:: max(1, len(inner) // 40)]
        path = lambda x, y, ending="": f"/tiles/{flight}/{zoom}/{x}/{y}{ending}"  # noqa: E731
        client.get(path(*inner[0]))
        for what in ("first", "again"):
            times_ms, cost_s = spent(server, lambda: [client.get(path(x, y, ".png")) for x, y in some])
            print(f"as .png, {what}: {statistics.median(times_ms):.2f} ms in the median of {len(some)} inner tiles, worst "
                  f"{max(times_ms):.2f} ms, {cost_s / len(some) * 1e3:.2f} ms of CPU each")
        asked = [path(x, y) for x, y in inner] * STORED_ROUNDS
        times_ms, cost_s = spent(server, lambda: [client.get(one) for one in asked])
        print(f"as stored: {statistics.median(times_ms):.2f} ms in the median of {len(asked)}, {cost_s / len(asked) * 1e6:.0f} us of "
              "CPU each on one connection (with 32 of them: tiles_bench.py)")
        windows = pan_windows(zoom, inner)
        count = sum(len(shown) for _, shown in windows)
        by_qgis = qgis_pan(server, flight, windows)
        print("pan by QGIS: python3-qgis is not here" if by_qgis is None
              else f"pan by QGIS over {count} tiles in {len(windows)} windows: {by_qgis[0]:.2f} s of CPU for {by_qgis[1]} requests")
        _, cost_s = spent(server, lambda: [client.get(path(x, y)) for _, shown in windows for x, y in shown])
        print(f"the same {count} requests alone: {cost_s:.2f} s of CPU")
    finally:
        server.stop()
        shutil.rmtree(folder)


if __name__ == "__main__":
    main()
