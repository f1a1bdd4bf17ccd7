"""How well the bands of a finished bands.tif lie on each other, measured by other means than the program's own.

The program registers pictures by correlating patches of gradient magnitude. Here the finished raster is measured by
enhanced correlation coefficient (OpenCV's findTransformECC, a shift alone) on the logarithm's Laplacian of the
bands, sign made equal by its magnitude, in windows all over the raster; the most textured window of each third of the map
is printed and drawn apart. Beside it: NDVI at the 5th, 50th and 95th percentile.

    python3 tests/bench/bands/registration.py map/bands.tif [--png ndvi.png]
"""
import argparse
import sys

import cv2
import numpy
from osgeo import gdal

WINDOW = 160


def edges(values):
    values = cv2.GaussianBlur(numpy.log(numpy.maximum(values, 1e-4)).astype(numpy.float32), (0, 0), 1.2)
    dx, dy = cv2.Scharr(values, cv2.CV_32F, 1, 0), cv2.Scharr(values, cv2.CV_32F, 0, 1)
    out = numpy.sqrt(dx * dx + dy * dy)
    return (out - out.mean()) / max(out.std(), 1e-9)


def shift_between(a, b):
    """Pixels by which b lies off a; None where they show too little in common."""
    warp = numpy.eye(2, 3, dtype=numpy.float32)
    stop = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 200, 1e-6)
    try:
        correlation, warp = cv2.findTransformECC(edges(a), edges(b), warp, cv2.MOTION_TRANSLATION, stop, None, 3)
    except cv2.error:
        return None
    if correlation < 0.5:
        return None
    return float(warp[0, 2]), float(warp[1, 2])


def measure(path):
    raster = gdal.Open(path)
    names = [raster.GetRasterBand(i + 1).GetDescription() for i in range(raster.RasterCount)]
    bands = {name: raster.GetRasterBand(i + 1).ReadAsArray() for i, name in enumerate(names)}
    reference = "green" if "green" in bands else names[0]
    height, width = bands[reference].shape
    results = {}
    for name in names:
        if name == reference:
            continue
        found = []
        for y in range(0, height - WINDOW, WINDOW // 2):
            for x in range(0, width - WINDOW, WINDOW // 2):
                a, b = (bands[key][y:y + WINDOW, x:x + WINDOW] for key in (reference, name))
                if numpy.isnan(a).any() or numpy.isnan(b).any():
                    continue
                shift = shift_between(a, b)
                if shift:
                    found.append((x, y, *shift, float(numpy.log(numpy.maximum(a, 1e-4)).std())))
        results[name] = found
    return bands, reference, results


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("bands")
    parser.add_argument("--png", help="NDVI as a picture")
    arguments = parser.parse_args()
    bands, reference, results = measure(arguments.bands)
    height, width = bands[reference].shape
    print(f"{width} x {height} pixels, against {reference}")
    worst = 0.0
    for name, found in results.items():
        if not found:
            print(f"{name:10s} no window shows enough in both bands")
            continue
        shifts = numpy.array([one[2:4] for one in found])
        rms = float(numpy.sqrt((shifts ** 2).sum(axis=1).mean()))
        share = float((numpy.hypot(*shifts.T) <= 0.5).mean())
        worst = max(worst, rms)
        print(f"{name:10s} {len(found):4d} windows, {rms:.3f} px rms, median {numpy.median(numpy.hypot(*shifts.T)):.3f}, "
              f"mean shift {shifts[:, 0].mean():+.3f} {shifts[:, 1].mean():+.3f}, within half a pixel {100 * share:.0f} %")
        for third in range(3):
            inside = [one for one in found if third * width <= 3 * (one[0] + WINDOW / 2) < (third + 1) * width]
            if inside:
                x, y, dx, dy, _ = max(inside, key=lambda one: one[4])
                print(f"           at {x:5d},{y:5d}: {dx:+.3f} {dy:+.3f}")
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
