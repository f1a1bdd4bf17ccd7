"""A simulated rig of five bands, from its files to bands.tif: how far reflectance and places are off the truth.

The simulator writes captures of a camera whose bands have lenses, vignetting, exposures and light of their own, over
hills. The stitched raster is held against the simulator's map: reflectance, means of 4 x 4 pixels, as the root of the mean
square error over the mean; and how far the bands lie off each other, window by window.

    /usr/bin/python3 tests/bench/bands/simulated_rig.py [--photos 30] [--size 1280x960] [--relief-m 8] [--keep FOLDER]
"""
import argparse
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

import cv2
import numpy
from osgeo import gdal

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import registration  # noqa: E402

BINARY = os.environ.get("SKYQUILT_BINARY", "build/release/bin/skyquilt")
CELL = 4


def fly(folder, photos, size, relief_m, seed=1):
    subprocess.run([BINARY, "simulate", "-o", folder / "sim", "--bands", "--photos", str(photos), "--size", size, "--relief-m",
                    str(relief_m), "--noise", "xmp", "--seed", str(seed)], check=True, capture_output=True)
    subprocess.run([BINARY, "stitch", folder / "sim" / "photos", "-o", folder / "map", "--no-pmtiles"], check=True,
                   capture_output=True)


def truth_on(raster, folder):
    """The simulator's colours (0 to 1) on the raster's pixels."""
    west, step, _, north, _, down = raster.GetGeoTransform()
    box = (west, north + down * raster.RasterYSize, west + step * raster.RasterXSize, north)
    warped = gdal.Warp("", str(folder / "sim" / "truth" / "world.tif"), format="MEM", dstSRS="EPSG:3857", outputBounds=box,
                       width=raster.RasterXSize, height=raster.RasterYSize, resampleAlg="bilinear")
    return warped.ReadAsArray()[:3].astype(numpy.float32) / 255.0


def means(values):
    height, width = (side // CELL * CELL for side in values.shape)
    return values[:height, :width].reshape(height // CELL, CELL, width // CELL, CELL).mean(axis=(1, 3))


def truths_of(raster, folder):
    """By band, in the raster's order: what the ground sends back, on the raster's pixels."""
    colours = truth_on(raster, folder)
    kinds = {one["name"].lower().replace(" ", ""): one
             for one in json.loads((folder / "sim" / "truth" / "poses.json").read_text())["bands"]}
    names = [raster.GetRasterBand(i + 1).GetDescription() for i in range(raster.RasterCount)]
    return {name: (kinds[name]["reflectance_at_black"] +
                   numpy.tensordot(kinds[name]["reflectance_of_red_green_blue"], colours, 1)).astype(numpy.float32)
            for name in names}


def bands_and_truths(folder):
    raster = gdal.Open(str(folder / "map" / "bands.tif"))
    truths = truths_of(raster, folder)
    bands = {name: raster.GetRasterBand(i + 1).ReadAsArray() for i, name in enumerate(truths)}
    bend = bend_of(truths["green"], bands["green"])
    return {name: (bands[name], cv2.remap(truth, bend, None, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE))
            for name, truth in truths.items()}


def reflectance_errors(pairs):
    """By band: root of the mean square error over the mean, the ratio of the means, and how many cells."""
    errors = {}
    for name, (values, truth) in pairs.items():
        seen, there = means(values), means(truth)
        known = ~numpy.isnan(seen)
        miss = seen[known] - there[known]
        errors[name] = (float(numpy.sqrt((miss ** 2).mean()) / there[known].mean()),
                        float(seen[known].mean() / there[known].mean()), int(known.sum()))
    return errors


def bend_of(truth, seen):
    """Where each pixel of the map lies in the truth: places are as far off as positions were recorded. Smooth, and one for
    all bands, so that bands which lie beside each other stay so."""
    filled = numpy.where(numpy.isnan(seen), truth, seen).astype(numpy.float32)
    scale = 255.0 / max(float(truth.max()), 1e-6)
    to8 = lambda values: numpy.clip(values * scale, 0, 255).astype(numpy.uint8)  # noqa: E731
    flow = cv2.DISOpticalFlow_create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM).calc(to8(filled), to8(truth), None)
    flow = cv2.GaussianBlur(flow, (0, 0), 12)
    return flow + numpy.stack(numpy.meshgrid(numpy.arange(truth.shape[1]), numpy.arange(truth.shape[0])), -1).astype(numpy.float32)


def registration_errors(pairs):
    """By band: root of the mean square shift against green, pixels, and windows; each band by how it lies on the truth of its
    own, for bands look too different here for one to be found in another."""
    height, width = pairs["green"][0].shape
    side, found = registration.WINDOW, {name: [] for name in pairs if name != "green"}
    for y in range(0, height - side, side):
        for x in range(0, width - side, side):
            window = (slice(y, y + side), slice(x, x + side))
            if any(numpy.isnan(values[window]).any() for values, _ in pairs.values()):
                continue
            shifts = {name: registration.shift_between(truth[window], values[window]) for name, (values, truth) in pairs.items()}
            if shifts["green"] is None:
                continue
            for name in found:
                if shifts[name]:
                    found[name].append(numpy.subtract(shifts[name], shifts["green"]))
    return {name: (float(numpy.sqrt((numpy.array(one) ** 2).sum(axis=1).mean())), len(one)) for name, one in found.items() if one}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--photos", type=int, default=30)
    parser.add_argument("--size", default="1280x960")
    parser.add_argument("--relief-m", type=float, default=8.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", type=pathlib.Path, help="where to leave flight and map")
    arguments = parser.parse_args()
    folder = arguments.keep or pathlib.Path(tempfile.mkdtemp(prefix="skyquilt_rig_"))
    folder.mkdir(exist_ok=True)
    try:
        fly(folder, arguments.photos, arguments.size, arguments.relief_m, arguments.seed)
        pairs = bands_and_truths(folder)
        worst_share, worst_px = 0.0, 0.0
        for name, (rms, ratio, cells) in reflectance_errors(pairs).items():
            print(f"{name:10s} reflectance {100 * rms:.2f} % rms, {100 * (ratio - 1):+.2f} % in the mean, {cells} cells")
            worst_share = max(worst_share, rms)
        for name, (rms_px, windows) in registration_errors(pairs).items():
            print(f"{name:10s} {rms_px:.3f} px rms off green, {windows} windows")
            worst_px = max(worst_px, rms_px)
        return 0 if worst_share <= 0.03 and worst_px <= 0.3 else 1
    finally:
        if arguments.keep is None:
            shutil.rmtree(folder)


if __name__ == "__main__":
    sys.exit(main())
