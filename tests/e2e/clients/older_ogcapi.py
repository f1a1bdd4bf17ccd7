"""What GDAL's OGCAPI driver needs before GDAL 3.8, put between it and a server.

Three faults of its raster tiles, mended together in GDAL 3.8 (OSGeo/gdal pull request 8130), keep it from any service
whose tile matrix set is not in degrees:
1. It takes the collection's bbox, which OGC API has in degrees, for coordinates of the tile matrix set. Its options MINX,
   MINY, MAXX and MAXY say them in metres.
2. It cuts the tile matrix to `tileMatrixSetLimits`, but counts rows and columns from the uncut corner; without any limits
   it opens nothing. Limits as wide as the matrix come out right: that is what is changed on the way here.
3. It stops at a zoom where the map is smaller than a pixel. Its option TILEMATRIX names one zoom.
Links, matrices, templates and every pixel still come from the server as they are.
"""
import contextlib
import http.server
import json
import threading
import urllib.error
import urllib.request

DRIVER_MENDED_IN = 3080000


@contextlib.contextmanager
def widened_limits(port):
    """A port that passes the server's answers on, tileset limits widened to the whole of each matrix."""

    class Forwarder(http.server.BaseHTTPRequestHandler):
        def do_GET(self):
            request = urllib.request.Request(f"http://127.0.0.1:{port}{self.path}", headers={"Host": self.headers["Host"]})
            try:
                answer = urllib.request.urlopen(request)
            except urllib.error.HTTPError as refusal:
                answer = refusal
            with answer:
                body = answer.read()
            if answer.status == 200 and answer.headers["Content-Type"] == "application/json":
                document = json.loads(body)
                if "tileMatrixSetLimits" in document:
                    scheme = next(link["href"] for link in document["links"] if link["rel"].endswith("/tiling-scheme"))
                    with urllib.request.urlopen(scheme.replace(self.headers["Host"], f"127.0.0.1:{port}")) as answer:
                        matrices = {matrix["id"]: matrix for matrix in json.load(answer)["tileMatrices"]}
                    for limits in document["tileMatrixSetLimits"]:
                        matrix = matrices[limits["tileMatrix"]]
                        limits.update(minTileRow=0, minTileCol=0, maxTileRow=matrix["matrixHeight"] - 1, maxTileCol=matrix["matrixWidth"] - 1)
                body = json.dumps(document).encode()
            self.send_response(answer.status)
            self.send_header("Content-Type", answer.headers["Content-Type"] or "application/octet-stream")
            self.send_header("Content-Length", str(len(body)))
            self.end_headers()
            self.wfile.write(body)

        def log_message(self, *_):
            pass

    forwarder = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Forwarder)
    thread = threading.Thread(target=forwarder.serve_forever)
    thread.start()
    try:
        yield forwarder.server_port
    finally:
        forwarder.shutdown()
        thread.join()
        forwarder.server_close()
