"""How evenly simulated flights come out whose photos are not: dark corners, another exposure each, a hot spot opposite the
sun, and a field that really becomes brighter to the east. The map divided by the truth, as a logarithm, blurred to a
quarter of a photo, says what is left: its root mean square after one factor for the whole map, the part of it that is a plane
across the map (for which the photos hold no evidence but that exposures do not drift), the rest, and how much of the field's
own gradient the map has.

    python3 tests/bench/render/light.py PROGRAM [--seeds N] [--photos N] [--by PROGRAM]

"Recorded": the photos' exposure times say how each was exposed. Where they do not, overlaps cannot tell the plane in exposures
that differ at random by 5 % from one of the field: about 5 % x sqrt(2 / photos) rms, 0.9 % for 60 photos.

Needs numpy and GDAL.
"""
import argparse
import pathlib
import subprocess
import tempfile

import numpy
from osgeo import gdal

from lattice import box_mean

gdal.UseExceptions()
FLIGHTS = {
    "even": [],
    "lens": ["--vignetting", "0.25"],
    "lens, exposure": ["--vignetting", "0.25", "--exposure-jitter", "0.05"],
    "lens, exposure, sun": ["--vignetting", "0.25", "--exposure-jitter", "0.05", "--hot-spot", "0.25"],
    "field": ["--gradient-per-km", "1.5"],
    "recorded exposure, sun": ["--vignetting", "0.25", "--exposure-jitter", "0.05", "--exposure-recorded", "--hot-spot", "0.25"],
    "recorded exposure, sun, field": ["--vignetting", "0.25", "--exposure-jitter", "0.05", "--exposure-recorded", "--hot-spot", "0.25",
                                      "--gradient-per-km", "1.5"],
    "lens, exposure, sun, field": ["--vignetting", "0.25", "--exposure-jitter", "0.05", "--hot-spot", "0.25", "--gradient-per-km", "1.5"],
}


def measure(folder, gradient_per_km):
    """(rms, rms of the plane, rms of the rest, share of the field's gradient), shares of the light."""
    mosaic = gdal.Open(str(folder / "map" / "mosaic.tif"))
    left, pixel, _, top, _, _ = mosaic.GetGeoTransform()
    east, south = left + pixel * mosaic.RasterXSize, top - pixel * mosaic.RasterYSize
    step = 8 * pixel
    both = [gdal.Warp("", str(path), format="MEM", dstSRS="EPSG:3857", xRes=step, yRes=step, resampleAlg="average",
                      outputBounds=(left, south, east, top), dstAlpha=alpha)
            for path, alpha in ((folder / "map" / "mosaic.tif", True), (folder / "flight" / "truth" / "world.tif", False))]
    ours, truth = ([image.GetRasterBand(i + 1).ReadAsArray().astype(float) for i in range(3)] for image in both)
    covered = both[0].GetRasterBand(both[0].RasterCount).ReadAsArray() > 250
    for bands in (ours, truth):
        covered &= (numpy.array(bands) > 8).all(0) & (numpy.array(bands) < 247).all(0)
    ratio = sum(numpy.log(numpy.maximum(a, 1.0)) - numpy.log(numpy.maximum(b, 1.0)) for a, b in zip(ours, truth)) / 3
    side = max(3, int(0.25 * min(ratio.shape) / 3)) | 1
    weight = box_mean(covered.astype(float), side)
    smooth = box_mean(numpy.where(covered, ratio, 0.0), side) / numpy.maximum(weight, 1.0)
    inside = covered & (weight > 0.5 * side * side)
    rows, columns = numpy.nonzero(inside)
    lat = numpy.radians(gdal.Info(mosaic, format="json")["wgs84Extent"]["coordinates"][0][0][1])
    east_km = columns * step * numpy.cos(lat) / 1000
    basis = numpy.stack([numpy.ones(len(rows)), east_km, rows * step * numpy.cos(lat) / 1000], 1)
    values = smooth[inside]
    plane, *_ = numpy.linalg.lstsq(basis, values, rcond=None)
    values = values - values.mean()
    rest = values - (basis @ plane - (basis @ plane).mean())
    kept = 1.0 + plane[1] / gradient_per_km if gradient_per_km else None
    return values.std(), (basis @ plane).std(), rest.std(), kept


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--photos", default="60")
    parser.add_argument("--by", help="another skyquilt, which stitches the flights that PROGRAM simulates")
    options = parser.parse_args()
    print(f"{'flight':30}{'seed':>5}{'rms':>9}{'plane':>9}{'rest':>9}{'gradient kept':>15}", flush=True)
    for name, words in FLIGHTS.items():
        for seed in range(1, options.seeds + 1):
            with tempfile.TemporaryDirectory(prefix="skyquilt_light_") as scratch:
                folder = pathlib.Path(scratch)
                subprocess.run([options.program, "simulate", "-o", folder / "flight", "--photos", options.photos, "--seed", str(seed),
                                "--size", "800x600", "--noise", "rtk", *words], check=True, capture_output=True)
                subprocess.run([options.by or options.program, "stitch", folder / "flight" / "photos", "-o", folder / "map",
                                "--formats", "geotiff"], check=True,
                               capture_output=True)
                gradient = float(words[words.index("--gradient-per-km") + 1]) if "--gradient-per-km" in words else 0.0
                rms, plane, rest, kept = measure(folder, gradient)
            print(f"{name:30}{seed:5}{100 * rms:8.2f}%{100 * plane:8.2f}%{100 * rest:8.2f}%"
                  f"{'' if kept is None else f'{100 * kept:.1f}%':>15}", flush=True)


if __name__ == "__main__":
    main()
