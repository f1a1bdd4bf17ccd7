"""How well the bands of a finished bands.tif lie on each other, measured by other means than the program's own.

The program registers pictures by correlating patches of gradient magnitude. Here the finished raster is measured by
enhanced correlation coefficient (OpenCV's findTransformECC, a shift alone) on the gradient magnitude of the bands'
logarithms, in windows all over the raster. A window counts where the bands show the same: a correlation of 0.5, and the
shift from one to the other is that from the other to the one, reversed, to 0.2 pixels (what is not measured both ways alike is
no measure), and edges run in more than one direction: along a lone kerb or painted line no shift is seen. Which windows count does not
depend on how large the shift is. Of the windows that count in all bands the most
textured of each third of the map is printed apart. Beside it: NDVI at the 5th, 50th and 95th percentile.

A raster's pixels are up to twice as fine as the cameras' own. With the report.json of the map beside it, figures are
given in both.

    python3 tests/bench/bands/registration.py map/bands.tif [--png ndvi.png]
"""
import argparse
import json
import pathlib
import sys

import cv2
import numpy
from osgeo import gdal

WINDOW = 160
MIN_CORRELATION, MAX_WAYS_APART_PX = 0.5, 0.2
MIN_ACROSS = 0.25  # of the slopes' squares along the direction of most, those across it: errors differ by a factor of two at most


def edges(values):
    """Gradient magnitude of the logarithm; zero where nothing is known."""
    known = ~numpy.isnan(values)
    values = numpy.log(numpy.maximum(numpy.where(known, values, numpy.nanmedian(values)), 1e-4)).astype(numpy.float32)
    values = cv2.GaussianBlur(values, (0, 0), 1.2)
    return cv2.magnitude(cv2.Scharr(values, cv2.CV_32F, 1, 0), cv2.Scharr(values, cv2.CV_32F, 0, 1)) ** 0.5 * known


def ecc(a, b):
    """Pixels by which the edges b lie off a; None where they show too little in common."""
    warp = numpy.eye(2, 3, dtype=numpy.float32)
    stop = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 200, 1e-6)
    try:
        correlation, warp = cv2.findTransformECC(a, b, warp, cv2.MOTION_TRANSLATION, stop, None, 3)
    except cv2.error:
        return None
    if correlation < MIN_CORRELATION:
        return None
    return float(warp[0, 2]), float(warp[1, 2])


def slopes_in_both_directions(values):
    dx, dy = cv2.Scharr(values, cv2.CV_32F, 1, 0), cv2.Scharr(values, cv2.CV_32F, 0, 1)
    least, most = numpy.linalg.eigvalsh([[(dx * dx).sum(), (dx * dy).sum()], [(dx * dy).sum(), (dy * dy).sum()]])
    return least >= MIN_ACROSS * most > 0


def shift_of_edges(a, b):
    """The same, measured both ways; None where the two ways say different things, or edges run in one direction alone."""
    if not slopes_in_both_directions(a) or not slopes_in_both_directions(b):
        return None
    there = ecc(a, b)
    back = ecc(b, a) if there else None
    if not back or numpy.hypot(there[0] + back[0], there[1] + back[1]) > MAX_WAYS_APART_PX:
        return None
    return (there[0] - back[0]) / 2, (there[1] - back[1]) / 2


def shift_between(a, b):
    return shift_of_edges(edges(a), edges(b))


def measure(path):
    """Bands, the reference's name, and by other band {(x, y): (dx, dy)} of the windows that count."""
    raster = gdal.Open(path)
    names = [raster.GetRasterBand(i + 1).GetDescription() for i in range(raster.RasterCount)]
    bands = {name: raster.GetRasterBand(i + 1).ReadAsArray() for i, name in enumerate(names)}
    reference = "green" if "green" in bands else names[0]
    height, width = bands[reference].shape
    drawn = {name: edges(values) for name, values in bands.items()}
    unknown = numpy.any([numpy.isnan(values) for values in bands.values()], axis=0)
    results = {name: {} for name in names if name != reference}
    for y in range(0, height - WINDOW, WINDOW // 2):
        for x in range(0, width - WINDOW, WINDOW // 2):
            window = (slice(y, y + WINDOW), slice(x, x + WINDOW))
            if unknown[window].any():
                continue
            for name, found in results.items():
                shift = shift_of_edges(drawn[reference][window], drawn[name][window])
                if shift:
                    found[x, y] = shift
    return bands, reference, results


def pixels_a_camera_pixel(path):
    """How many pixels of the raster a pixel of the cameras is; None where the map's report is not beside it."""
    report = pathlib.Path(path).with_name("report.json")
    if not report.exists():
        return None
    raster = gdal.Open(path)
    _, pixel_m, _, north_m, _, down_m = raster.GetGeoTransform()
    middle_m = north_m + down_m * raster.RasterYSize / 2
    ground_m = pixel_m / numpy.cosh(middle_m / 6378137.0)
    return json.loads(report.read_text())["bands"]["gsd_m"] / ground_m


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("bands")
    parser.add_argument("--png", help="NDVI as a picture")
    arguments = parser.parse_args()
    bands, reference, results = measure(arguments.bands)
    height, width = bands[reference].shape
    scale = pixels_a_camera_pixel(arguments.bands)
    print(f"{width} x {height} pixels, against {reference}" + (f"; a pixel of the cameras is {scale:.2f} of them" if scale else ""))
    worst = 0.0
    in_all = set.intersection(*(set(found) for found in results.values()))
    texture = {(x, y): float(numpy.log(numpy.maximum(bands[reference][y:y + WINDOW, x:x + WINDOW], 1e-4)).std()) for x, y in in_all}
    thirds = [[at for at in in_all if third * width <= 3 * (at[0] + WINDOW / 2) < (third + 1) * width] for third in range(3)]
    places = [max(inside, key=texture.get) for inside in thirds if inside]
    for name, found in results.items():
        if not found:
            print(f"{name:10s} no window shows enough in both bands")
            worst = numpy.inf
            continue
        shifts = numpy.array(list(found.values()))
        miss = numpy.hypot(*shifts.T)
        rms = float(numpy.sqrt((miss ** 2).mean()))
        worst = max(worst, rms)
        of_camera = f", of the cameras {rms / scale:.3f} rms, median {numpy.median(miss) / scale:.3f}" if scale else ""
        print(f"{name:10s} {len(found):4d} windows, {rms:.3f} px rms, median {numpy.median(miss):.3f}{of_camera}, "
              f"mean shift {shifts[:, 0].mean():+.3f} {shifts[:, 1].mean():+.3f}, within half a pixel {100 * (miss <= 0.5).mean():.0f} %")
        for x, y in places:
            print(f"           at {x:5d},{y:5d}: {found[x, y][0]:+.3f} {found[x, y][1]:+.3f}")
    if {"nir", "red"} <= bands.keys():
        ndvi = (bands["nir"] - bands["red"]) / (bands["nir"] + bands["red"])
        print("NDVI at 5, 50, 95 %:", *(f"{value:.2f}" for value in numpy.nanpercentile(ndvi, (5, 50, 95))))
        if arguments.png:
            grey = numpy.nan_to_num(numpy.clip((ndvi + 0.2) / 1.2, 0, 1) * 255).astype(numpy.uint8)
            colour = cv2.applyColorMap(grey, cv2.COLORMAP_SUMMER)
            colour[numpy.isnan(ndvi)] = 0
            cv2.imwrite(arguments.png, colour)
    return 0 if worst <= 0.3 else 1


if __name__ == "__main__":
    sys.exit(main())
