"""How much of a map's lightness goes with where its photos were taken: hot spots, dark corners and steps at seams
repeat with the photos, the field does not. The map, blurred to a pixel of a fiftieth of a photo, divided by its mean
over a photo's width, is averaged by the place against the nearest photo; the mean square of that average is the
energy at all frequencies of the photos' lattice together. The field alone gives some too: that is measured by the same lattice
shifted to other places (median of 60), and taken off.

    python3 tests/bench/render/lattice.py MAP [MAP ...]

MAP is a folder that `skyquilt stitch` made, with mosaic.tif and locate.json. The first is what the others are
divided by. Needs numpy and GDAL.
"""
import argparse
import json
import pathlib

import numpy
from osgeo import gdal, osr

gdal.UseExceptions()
BINS = 9
PIXELS_A_PHOTO = 50


def cameras_of(folder):
    """(east, north) of each camera in EPSG:3857 and its height above the ground, the photos' width, in metres of EPSG:3857."""
    located = json.loads((folder / "locate.json").read_text())
    lat, lon = located["origin"][:2]
    to_merc = osr.CoordinateTransformation(spatial("EPSG:4326"), spatial("EPSG:3857"))
    east, north, _ = to_merc.TransformPoint(lon, lat)
    stretch = 1.0 / numpy.cos(numpy.radians(lat))
    places, widths = [], []
    for camera in located["cameras"]:
        w, x, y, z = camera["rotation_wxyz"]
        cam_from_enu = numpy.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                                    [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                                    [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])
        center = -cam_from_enu.T @ numpy.array(camera["translation_m"])
        height = stretch * (center[2] - located["ground"]["z_m"])
        places.append((east + stretch * center[0], north + stretch * center[1], height))
        widths.append(height * camera["size_px"][0] / camera["focal_px"][0])
    return numpy.array(places), float(numpy.median(widths))


def spatial(name):
    system = osr.SpatialReference()
    system.SetFromUserInput(name)
    system.SetAxisMappingStrategy(osr.OAMS_TRADITIONAL_GIS_ORDER)
    return system


def box_mean(values, side):
    """Mean over a square of `side` pixels; borders count what is there."""
    half = side // 2
    summed = numpy.pad(values, ((half + 1, half), (half + 1, half))).cumsum(0).cumsum(1)
    return summed[side:, side:] - summed[:-side, side:] - summed[side:, :-side] + summed[:-side, :-side]


def lightness(folder, pixel_m, width_m):
    """(relative lightness, covered, east of columns, north of rows)."""
    small = gdal.Warp("", str(folder / "mosaic.tif"), format="MEM", dstSRS="EPSG:3857", xRes=pixel_m, yRes=pixel_m,
                      resampleAlg="average", dstAlpha=True)
    bands = [small.GetRasterBand(i + 1).ReadAsArray().astype(float) for i in range(small.RasterCount)]
    luma = 0.299 * bands[0] + 0.587 * bands[1] + 0.114 * bands[2]
    covered = bands[-1] > 250
    side = int(width_m / pixel_m) | 1
    around = box_mean(luma * covered, side) / numpy.maximum(box_mean(covered.astype(float), side), 1.0)
    relative = numpy.where(covered, numpy.clip(luma / numpy.maximum(around, 1.0) - 1.0, -0.3, 0.3), 0.0)
    left, _, _, top, _, _ = small.GetGeoTransform()
    return (relative, covered, left + (numpy.arange(small.RasterXSize) + 0.5) * pixel_m,
            top - (numpy.arange(small.RasterYSize) + 0.5) * pixel_m)


def energy(relative, covered, east, north, places, spacing_m):
    nearest = numpy.full(relative.shape, numpy.inf)
    dx, dy = numpy.zeros(relative.shape), numpy.zeros(relative.shape)
    for x, y in places:
        off_x, off_y = (east - x)[None, :], (north - y)[:, None]
        squared = off_x ** 2 + off_y ** 2
        closer = squared < nearest
        nearest[closer] = squared[closer]
        dx[closer] = numpy.broadcast_to(off_x, relative.shape)[closer]
        dy[closer] = numpy.broadcast_to(off_y, relative.shape)[closer]
    inside = covered & (numpy.abs(dx) < spacing_m / 2) & (numpy.abs(dy) < spacing_m / 2)
    at = (((dy[inside] / spacing_m + 0.5) * BINS).astype(int) * BINS + ((dx[inside] / spacing_m + 0.5) * BINS).astype(int))
    count = numpy.bincount(at, minlength=BINS * BINS)
    mean = numpy.bincount(at, relative[inside], BINS * BINS) / numpy.maximum(count, 1)
    return float((mean ** 2).mean())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("map", nargs="+", type=pathlib.Path)
    options = parser.parse_args()
    print(f"{'map':24}{'of photos':>12}{'of the field':>14}{'more':>12}{'ratio':>8}")
    first = None
    for folder in options.map:
        places, width_m = cameras_of(folder)
        places = places[:, :2]
        seen = lightness(folder, width_m / PIXELS_A_PHOTO, width_m)
        to_others = numpy.sort(numpy.linalg.norm(places[:, None] - places[None], axis=2), axis=1)[:, 1:4]
        spacing_m = 1.2 * float(numpy.median(to_others))
        of_photos = energy(*seen, places, spacing_m)
        shifts = numpy.random.default_rng(1).uniform(-0.5, 0.5, (60, 2)) * spacing_m
        of_field = float(numpy.median([energy(*seen, places + shift, spacing_m) for shift in shifts]))
        more = of_photos - of_field
        first = first or more
        print(f"{folder.name:24}{of_photos:12.3e}{of_field:14.3e}{more:12.3e}{more / first:8.2f}", flush=True)


if __name__ == "__main__":
    main()
