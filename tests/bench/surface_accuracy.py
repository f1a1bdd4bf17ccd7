"""Do buildings stand upright, and are heights true? Simulates flights over houses, walls and trees, stitches them with the
real program and holds map and surface against the simulated world.

    python3 tests/bench/surface_accuracy.py PROGRAM [--seeds N] [--first-seed N] [--only NAME]... [--photos N] [--keep DIR]
        [--simulator PROGRAM] [--stitch OPTION ...]

What follows --stitch goes to `stitch` as it is. One row a flight and one of all of a family. Pixels are those of the photos on
level ground (GSD), except for CE90, which is in pixels of the map's tiles as map_accuracy.py has it:

- ground CE90: shifts of the map's patches that show open ground, after the best similarity;
- corners: how far each corner of a roof lies off in the map, against the median shift of the ground, in the median and at P90,
  and the share that was found: the roof of the true map within 32 pixels of the corner, sought in the map by normalised
  correlation, larger too, as a roof nearer to the camera is;
- with a dsm.tif beside the map: the share of cells answered of those that three photos see (nothing in the way, and no water),
  heights there on open ground (median, NMAD, RMSE) and on roofs but for the cell at their edge (median and P90 of the
  absolute), and the volumes of houses over the ground around each (median and worst error);
- with a dtm.tif as well: how far off the ground is where something stands on it, and elsewhere (median and P90 of the absolute,
  but for what all open ground of the dsm.tif is off by).

Needs python3-gdal with numpy.
"""
import argparse
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

import numpy
from osgeo import gdal

from heights_against_truth import measure_heights, numbers_on, truth_on
from map_against_truth import PATCH_PX, after_similarity, measure

VILLAGE = ["--houses", "10", "--trees", "14", "--walls", "5", "--noise", "rtk"]
FAMILIES = {
    f"houses_{height}m_{overlap}": [*VILLAGE, "--relief-m", "20", "--height", str(height), "--sidelap", f"0.{overlap}"]
    for height in (60, 100) for overlap in (60, 75)
}
FAMILIES["houses_level"] = [*VILLAGE, "--height", "60", "--sidelap", "0.75"]
FAMILIES["hills"] = ["--noise", "xmp", "--relief-m", "20", "--height", "60"]
SCALES = (1.0, 1.06, 1.12, 1.19, 1.26)
AROUND_CORNER_PX = 32
FARTHEST_M = 10.0
LEAST_ALIKE = 0.75


def luminance(dataset):
    red, green, blue = (dataset.GetRasterBand(i).ReadAsArray().astype(numpy.float32) for i in (1, 2, 3))
    return 0.3 * red + 0.59 * green + 0.11 * blue


def between_pixels(image, x, y):
    """Bilinear."""
    x, y = x.clip(0, image.shape[1] - 1.001), y.clip(0, image.shape[0] - 1.001)
    column, row = x.astype(int), y.astype(int)
    u, v = x - column, y - row
    return ((1 - v) * ((1 - u) * image[row, column] + u * image[row, column + 1])
            + v * ((1 - u) * image[row + 1, column] + u * image[row + 1, column + 1]))


class Window:
    """A part of the map in which masked templates are sought."""

    def __init__(self, image):
        self.size = image.shape
        self.shape = [(side + 63) // 64 * 64 for side in image.shape]
        image = image - image.mean()
        self.spectra = [numpy.fft.rfft2(power, self.shape) for power in (image, image ** 2)]

    def correlated(self, power, kernel):
        product = self.spectra[power - 1] * numpy.fft.rfft2(kernel, self.shape).conj()
        rows, columns = (side - other + 1 for side, other in zip(self.size, kernel.shape))
        return numpy.fft.irfft2(product, self.shape)[:rows, :columns]

    def find(self, template, mask):
        """Where the template lies (x, y of its first pixel) and how alike both are there, -1 to 1."""
        count, mask = mask.sum(), mask.astype(float)
        own = mask * (template - (template * mask).sum() / count)
        spread = self.correlated(2, mask) - self.correlated(1, mask) ** 2 / count
        alike = self.correlated(1, own) / numpy.sqrt(spread.clip(count * 0.5) * (own ** 2).sum())
        row, column = numpy.unravel_index(numpy.argmax(alike), alike.shape)
        place = [float(column), float(row)]
        for axis, (at, line) in enumerate(((column, alike[row]), (row, alike[:, column]))):
            if 0 < at < len(line) - 1:
                before, here, after = line[at - 1:at + 2]
                place[axis] += 0.5 * (before - after) / (before - 2 * here + after)
        return numpy.array(place), alike[row, column]


def corner_shifts(mosaic_path, folder, truth, gsd_m):
    """(shifts of the roofs' corners in the map, in metres east and south; how many corners there are)."""
    fine = gdal.Open(str(mosaic_path))
    step = gsd_m / numpy.cos(numpy.radians(truth["origin"]["lat_deg"]))
    mosaic = gdal.Warp("", fine, format="MEM", xRes=step, yRes=step, resampleAlg="average")
    world = luminance(truth_on(mosaic, folder / "truth" / "world.tif", "average"))
    numbers = numbers_on(mosaic, folder)
    left, _, _, top, _, _ = mosaic.GetGeoTransform()
    mosaic = luminance(mosaic)
    shifts, corners = [], 0
    offsets_y, offsets_x = numpy.mgrid[-AROUND_CORNER_PX:AROUND_CORNER_PX + 1, -AROUND_CORNER_PX:AROUND_CORNER_PX + 1]
    for number, house in enumerate(truth["objects"], 1):
        if not house["kind"].endswith("house"):
            continue
        for merc_x, merc_y in house["corners_in_merc"]:
            at = numpy.array([(merc_x - left) / step - 0.5, (top - merc_y) / step - 0.5])
            reach = int(FARTHEST_M / gsd_m) + 2 * AROUND_CORNER_PX
            middle = numpy.round(at).astype(int)
            if (middle - reach).min() < 0 or middle[0] + reach >= mosaic.shape[1] or middle[1] + reach >= mosaic.shape[0]:
                continue
            corners += 1
            window = Window(mosaic[middle[1] - reach:middle[1] + reach + 1, middle[0] - reach:middle[0] + reach + 1])
            best = (None, LEAST_ALIKE)
            for scale in SCALES:
                x, y = at[0] + offsets_x / scale, at[1] + offsets_y / scale
                mask = numbers[numpy.round(y).astype(int), numpy.round(x).astype(int)] == number
                if mask.sum() < 200:
                    break
                place, alike = window.find(between_pixels(world, x, y), mask)
                if alike > best[1]:
                    best = (place + AROUND_CORNER_PX - reach - (at - middle), alike)
            if best[0] is not None:
                shifts.append(best[0] * gsd_m)
    return numpy.array(shifts).reshape(-1, 2), corners


def measure_flight(folder, seconds):
    """Numbers of one flight, by name."""
    truth = json.loads((folder / "truth" / "poses.json").read_text())
    gsd_m = truth["gsd_m"]
    mosaic = folder / "map" / "mosaic.mbtiles"
    shifts, centres, pixel_m, _ = measure(mosaic, folder / "truth" / "world.tif")
    numbers = numbers_on(gdal.Open(str(mosaic)), folder)
    places = numpy.round(centres / pixel_m).astype(int)
    is_open = numpy.array([(numbers[y:y + PATCH_PX, x:x + PATCH_PX] > 0).mean() < 0.02 for x, y in places], bool)
    out = {"stitch s": seconds}
    ground = numpy.zeros(2)
    if is_open.sum() >= 8:
        ground = numpy.median(shifts[is_open], 0)
        out["ground CE90"] = numpy.percentile(after_similarity(shifts[is_open], centres[is_open]), 90) / pixel_m
    if "objects" in truth:
        corner, corners = corner_shifts(mosaic, folder, truth, gsd_m)
        out["corners found"] = len(corner) / max(corners, 1)
        if len(corner):
            length = numpy.linalg.norm(corner - ground, axis=1) / gsd_m
            out |= {"corners": numpy.median(length), "corners P90": numpy.percentile(length, 90)}
    if (folder / "map" / "dsm.tif").is_file():
        out |= measure_heights(folder / "map" / "dsm.tif", folder, truth, gsd_m)
    return out


COLUMNS = {"ground CE90": 2, "corners": 2, "corners P90": 2, "corners found": "%", "answered": "%", "ground": 2, "NMAD": 2,
           "RMSE": 2, "roofs": 2, "roofs P90": 2, "volume": "%", "volume worst": "%", "below things": 2,
           "below things P90": 2, "beside": 2, "beside P90": 2, "stitch s": 1}


def row_of(numbers):
    def told(name, digits):
        if name not in numbers:
            return "-"
        return f"{100 * numbers[name]:.1f}%" if digits == "%" else f"{numbers[name]:.{digits}f}"
    return "".join(f"{told(name, digits):>{max(8, len(name) + 2)}}" for name, digits in COLUMNS.items())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--seeds", type=int, default=1, help="how many")
    parser.add_argument("--first-seed", type=int, default=1)
    parser.add_argument("--only", action="append", choices=FAMILIES)
    parser.add_argument("--photos", default="30")
    parser.add_argument("--keep", type=pathlib.Path, help="keep flights in this folder, and take those that are there")
    parser.add_argument("--simulator", help="the program that makes the flights, if it is another")
    parser.add_argument("--stitch", nargs=argparse.REMAINDER, default=[])
    options = parser.parse_args()
    scratch = options.keep or pathlib.Path(tempfile.mkdtemp(prefix="skyquilt_surface_"))
    print(f"{'family':16}{'seed':>5}" + "".join(f"{name:>{max(8, len(name) + 2)}}" for name in COLUMNS), flush=True)
    for name in options.only or FAMILIES:
        rows = []
        for seed in range(options.first_seed, options.first_seed + options.seeds):
            folder = scratch / f"{name}_{seed}"
            if not (folder / "truth" / "surface.tif").is_file():
                subprocess.run([options.simulator or options.program, "simulate", "-o", folder, "--photos", options.photos,
                                "--seed", str(seed), "--surface", *FAMILIES[name]], check=True, capture_output=True)
            shutil.rmtree(folder / "map", ignore_errors=True)
            began = time.monotonic()
            done = subprocess.run([options.program, "stitch", folder / "photos", "-o", folder / "map", *options.stitch],
                                  capture_output=True, text=True)
            if done.returncode != 0:
                print(f"{name:16}{seed:5}  {done.stderr.strip().splitlines()[-1]}", flush=True)
                continue
            rows.append(measure_flight(folder, time.monotonic() - began))
            print(f"{name:16}{seed:5}{row_of(rows[-1])}", flush=True)
            if not options.keep:
                shutil.rmtree(folder)
        if len(rows) > 1:
            mean = {key: numpy.mean([row[key] for row in rows if key in row]) for key in COLUMNS
                    if any(key in row for row in rows)}
            print(f"{name:16}{'mean':>5}{row_of(mean)}", flush=True)


if __name__ == "__main__":
    sys.exit(main())
