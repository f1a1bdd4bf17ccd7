"""How soon download.pmtiles and download.tif begin, which lie nowhere and are laid out over the tiles of a map: a made-up map of
1 GB (JPEG tiles of 256 pixels, PNG at its edge) in a data folder, asked right after the server started with the tileset out of
the page cache, then again; single ranges; and how fast the whole comes.
python3 tests/bench/tiles/downloads_bench.py [--megabytes N] [--side 256|512]."""
import argparse
import http.client
import os
import pathlib
import sqlite3
import statistics
import struct
import subprocess
import sys
import tempfile
import time

import cv2
import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "e2e"))
from server_support import BINARY, Server  # noqa: E402

ZOOM, COLUMN, ROW = 21, 1_000_000, 700_000
COMMENT = b"\xff\xfe"


def pictures(side):
    """An opaque JPEG and a PNG that is open in one half, of detail as photos have it."""
    random = numpy.random.default_rng(5)
    ground = cv2.GaussianBlur(random.integers(0, 256, (side, side, 3)).astype(numpy.float32), (0, 0), 1.2)
    ground = numpy.clip(128 + 3 * (ground - 128), 0, 255).astype(numpy.uint8)
    jpeg = cv2.imencode(".jpg", ground, [cv2.IMWRITE_JPEG_QUALITY, 85])[1].tobytes()
    alpha = numpy.where(numpy.arange(side)[None, :] + numpy.arange(side)[:, None] < side, 255, 0).astype(numpy.uint8)
    png = cv2.imencode(".png", numpy.dstack([ground, alpha]))[1].tobytes()
    return jpeg, png


def varied(jpeg, number):
    """The same picture, other bytes."""
    return jpeg[:2] + COMMENT + struct.pack(">HQ", 10, number) + jpeg[2:]


def write_map(path, megabytes, side):
    """As MbtilesWriter has it: a square of tiles, its overviews down to one."""
    jpeg, png = pictures(side)
    across = int((megabytes * 1e6 / len(jpeg) / 1.33) ** 0.5)
    path.unlink(missing_ok=True)
    db = sqlite3.connect(path)
    db.executescript("PRAGMA journal_mode=OFF; PRAGMA synchronous=OFF; CREATE TABLE metadata (name TEXT, value TEXT);"
                     "CREATE TABLE tiles_shallow (zoom_level INTEGER NOT NULL, tile_column INTEGER NOT NULL, tile_row INTEGER NOT NULL,"
                     " tile_data_id INTEGER NOT NULL, tile_bytes INTEGER NOT NULL, tile_format INTEGER NOT NULL,"
                     " PRIMARY KEY (zoom_level, tile_column, tile_row)) WITHOUT ROWID;"
                     "CREATE TABLE tiles_data (tile_data_id INTEGER PRIMARY KEY, tile_data BLOB NOT NULL);"
                     "CREATE VIEW tiles AS SELECT zoom_level, tile_column, tile_row, tile_data FROM tiles_shallow"
                     " JOIN tiles_data USING (tile_data_id);")
    number = tiles = 0
    for up in range(ZOOM + 1):
        first_column, first_row = COLUMN >> up, ROW >> up
        last_column, last_row = (COLUMN + across - 1) >> up, (ROW + across - 1) >> up
        for column in range(first_column, last_column + 1):
            for row in range(first_row, last_row + 1):
                number += 1
                at_edge = column in (first_column, last_column) or row in (first_row, last_row)
                content = png + struct.pack(">Q", number) if at_edge else varied(jpeg, number)
                key = (number * 0x9E3779B97F4A7C15) & (2**63 - 1)  # as a digest spreads them
                db.execute("INSERT INTO tiles_data VALUES (?, ?)", (key, content))
                db.execute("INSERT INTO tiles_shallow VALUES (?, ?, ?, ?, ?, ?)",
                           (ZOOM - up, column, (1 << (ZOOM - up)) - 1 - row, key, len(content), 2 if at_edge else 0))
                tiles += 1
        if first_column == last_column and first_row == last_row:
            min_zoom = ZOOM - up
            break
    for pair in (("name", "made up"), ("format", "jpg"), ("tile_size", str(side)), ("bounds", "-8.3,50.9,-8.2,51.0"), ("center", "-8.25,50.95,18"),
                 ("minzoom", str(min_zoom)), ("maxzoom", str(ZOOM))):
        db.execute("INSERT INTO metadata VALUES (?, ?)", pair)
    db.commit()
    db.close()
    return tiles


def forget(path):
    """Out of the page cache."""
    with open(path, "rb") as file:
        os.fsync(file.fileno())
        os.posix_fadvise(file.fileno(), 0, 0, os.POSIX_FADV_DONTNEED)


def first_byte(server, path, byte_range=None):
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=300)
    begun = time.perf_counter()
    connection.request("GET", path, headers={"Range": f"bytes={byte_range}"} if byte_range else {})
    answer = connection.getresponse()
    answer.read(1)
    took = time.perf_counter() - begun
    length = int(answer.headers["Content-Length"])
    connection.close()
    assert answer.status in (200, 206), answer.status
    return took, length


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--megabytes", type=float, default=1000)
    parser.add_argument("--side", type=int, default=256)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        scratch = pathlib.Path(scratch)
        write_map(scratch / "small.mbtiles", 0.1, options.side)
        subprocess.run([BINARY, "import", scratch / "small.mbtiles", "--data", scratch / "data"], check=True, capture_output=True)
        flight = next((scratch / "data/flights").iterdir()).name
        mbtiles = scratch / "data/flights" / flight / "r1/mosaic.mbtiles"
        tiles = write_map(mbtiles, options.megabytes, options.side)
        print(f"{mbtiles.stat().st_size / 1e6:.0f} MB, {tiles} tiles of {options.side} pixels")
        for name in ("download.pmtiles", "download.tif"):
            path = f"/api/v1/flights/{flight}/{name}"
            cold, warm = [], []
            for _ in range(3):
                forget(mbtiles)
                server = Server(scratch / "data", "--workers", "0")
                took, length = first_byte(server, path)
                cold.append(took)
                warm.append(first_byte(server, path)[0])
                parts = [first_byte(server, path, f"{length * i // 50}-{length * i // 50 + 16383}")[0] for i in range(50)]
                server.stop()
            print(f"{name}: {length / 1e6:.0f} MB, first byte {statistics.median(cold):.3f} s the first time, nothing of the map in the page "
                  f"cache; {statistics.median(warm):.4f} s after; 50 ranges of 16 kB {statistics.median(parts) * 1e3:.1f} ms in the median, "
                  f"{max(parts) * 1e3:.1f} ms at most")
        server = Server(scratch / "data", "--workers", "0")
        for name in ("download.mbtiles", "download.pmtiles", "download.tif"):
            begun = time.perf_counter()
            connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=600)
            connection.request("GET", f"/api/v1/flights/{flight}/{name}")
            answer = connection.getresponse()
            size = 0
            while part := answer.read(1 << 20):
                size += len(part)
            print(f"{name} whole: {size / 1e6 / (time.perf_counter() - begun):.0f} MB/s")
        server.stop()


if __name__ == "__main__":
    main()
