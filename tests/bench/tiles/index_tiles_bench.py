"""What an index tile of 256 pixels costs: CPU milliseconds of the server per tile that nobody asked for before, of a map of
colours and of one with bands, beside the same tile converted from one format to another:
python3 tests/bench/tiles/index_tiles_bench.py [--tiles N]. Needs python3-gdal and python3-numpy."""
import argparse
import http.client
import os
import pathlib
import sys

E2E = pathlib.Path(__file__).resolve().parents[2] / "e2e"
sys.path[:0] = [str(E2E), str(E2E / "indices")]
import indices_test as maps  # noqa: E402

TICKS = os.sysconf("SC_CLK_TCK")


def cpu_s(pid):
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / TICKS


def cost_ms(server, addresses):
    """CPU milliseconds per request; each address is another one, so that none is in memory."""
    connection = http.client.HTTPConnection("127.0.0.1", server.port)
    before = cpu_s(server.process.pid)
    for address in addresses:
        connection.request("GET", address)
        response = connection.getresponse()
        body = response.read()
        if response.status != 200:
            raise AssertionError(f"{address}: {body[:300]!r}")
    return (cpu_s(server.process.pid) - before) / len(addresses) * 1e3


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tiles", type=int, default=400)
    count = parser.parse_args().tiles
    maps.Indices.setUpClass()
    try:
        server, (colours, floats, whole) = maps.Indices.server, maps.Indices.flights
        at = f"{maps.ZOOM}/{maps.FIRST[0] + 1}/{maps.FIRST[1]}"
        # Ends of the colours that differ make tiles that differ.
        rows = [
            ("as WebP, of a JPEG", [f"/tiles/{colours}/{maps.ZOOM}/{maps.FIRST[0] + i % 3}/{maps.FIRST[1] + i // 3 % 2}.webp" for i in range(6)]),
            ("index=gli of colours", [f"/tiles/{colours}/{at}.png?index=gli&rescale=-0.4,{0.4 + i * 1e-5:.5f}" for i in range(count)]),
            ("index=ndvi of floats", [f"/tiles/{floats}/{at}.png?index=ndvi&rescale=-1,{1 + i * 1e-5:.5f}" for i in range(count)]),
            ("index=ndvi of whole numbers", [f"/tiles/{whole}/{at}.png?index=ndvi&rescale=-1,{1 + i * 1e-5:.5f}" for i in range(count)]),
            ("eight powers of colours", [f"/tiles/{colours}/{at}.png?expression=" + "%2B".join(["green**1.5"] * 8) + f"&rescale=0,{8 + i * 1e-4:.4f}" for i in range(count)]),
        ]
        for name, addresses in rows:
            print(f"{name:30} {cost_ms(server, addresses):6.2f} ms of CPU per tile")
    finally:
        maps.Indices.tearDownClass()


if __name__ == "__main__":
    main()
