"""How light a map is at each photo's point opposite the sun, against the ring of 8 m around it: 1 where the sun's hot spot
was taken out and nothing more. Brighter: some is left; darker: more was taken than there is.

    python3 tests/bench/render/hot_spot.py PROGRAM [--by PROGRAM] [--photos N] [--seeds N]   simulated flights
    python3 tests/bench/render/hot_spot.py --map MAP --utc 2013-06-04T17:38                  finished maps of real flights

Simulated: hot spots of three widths and strengths, and none. The map is divided by the truth, so that content is gone; said
are the mean over cameras, the furthest of all and the scatter of one.

MAP is a folder that `skyquilt stitch --formats geotiff` made; --utc says when its middle photo was taken (cameras write local
time), or --look where the point is, "east,north" of a camera's foot as shares of its height. There is no truth to divide by:
content is averaged out over the cameras. The sigma of the mean is what content leaves, by their scatter. "Elsewhere" is the
mean of the same number at eight other points as far from each camera's foot: where content has a leaning of its own, it has
it there too.

Needs numpy and GDAL.
"""
import argparse
import datetime
import json
import pathlib
import subprocess
import tempfile

import numpy
from osgeo import gdal

from lattice import cameras_of

gdal.UseExceptions()
DISC_M, RING_M, RING_WIDTH_M = 3.0, 8.0, 2.0
PIXEL_M = 0.4
STRENGTHS = (0.1, 0.2, 0.4)
WIDTHS_DEG = (3.0, 6.0, 11.5)
# Noon there when simulated flights begin: the point lies well inside the photos.
LAT_DEG, LON_DEG = 40.0, 30.0
SIMULATED_UTC = datetime.datetime(2024, 6, 1, 10, 0)


def look_opposite_the_sun(lat_deg, lon_deg, utc):
    """East and north of a camera's foot as shares of its height (Astronomical Almanac, low precision)."""
    days = (utc - datetime.datetime(2000, 1, 1, 12)).total_seconds() / 86400
    mean, anomaly = numpy.radians(280.460 + 0.9856474 * days), numpy.radians(357.528 + 0.9856003 * days)
    ecliptic = mean + numpy.radians(1.915 * numpy.sin(anomaly) + 0.020 * numpy.sin(2 * anomaly))
    tilt = numpy.radians(23.439 - 4e-7 * days)
    right_ascension = numpy.arctan2(numpy.cos(tilt) * numpy.sin(ecliptic), numpy.cos(ecliptic))
    declination = numpy.arcsin(numpy.sin(tilt) * numpy.sin(ecliptic))
    hour = numpy.radians(15 * (18.697374558 + 24.06570982441908 * days) + lon_deg) - right_ascension
    lat = numpy.radians(lat_deg)
    up = numpy.sin(lat) * numpy.sin(declination) + numpy.cos(lat) * numpy.cos(declination) * numpy.cos(hour)
    if up <= 0.05:
        raise SystemExit(f"At {utc:%Y-%m-%dT%H:%M} UTC the sun is no more than 3 degrees high there.")
    east = -numpy.cos(declination) * numpy.sin(hour)
    north = numpy.cos(lat) * numpy.sin(declination) - numpy.sin(lat) * numpy.cos(declination) * numpy.cos(hour)
    return numpy.array([-east, -north]) / up


class Lightness:
    """Logarithm of a map's lightness over EPSG:3857, divided by the truth where there is one; not a number outside."""

    def __init__(self, mosaic, truth, pixel):
        size = gdal.Open(str(mosaic))
        left, per_px, _, top, _, _ = size.GetGeoTransform()
        bounds = (left, top - per_px * size.RasterYSize, left + per_px * size.RasterXSize, top)
        self.left, self.top, self.pixel = left, top, pixel
        self.log = self.read(mosaic, bounds)
        if truth:
            self.log = self.log - self.read(truth, bounds)

    def read(self, path, bounds):
        small = gdal.Warp("", str(path), format="MEM", dstSRS="EPSG:3857", xRes=self.pixel, yRes=self.pixel,
                          resampleAlg="average", outputBounds=bounds, dstAlpha=True)
        bands = [small.GetRasterBand(i + 1).ReadAsArray().astype(float) for i in range(small.RasterCount)]
        light = 0.299 * bands[0] + 0.587 * bands[1] + 0.114 * bands[2]
        # Clipped values say nothing of light.
        good = (bands[-1] > 250) & (numpy.array(bands[:3]) > 8).all(0) & (numpy.array(bands[:3]) < 247).all(0)
        return numpy.where(good, numpy.log(numpy.maximum(light, 1.0)), numpy.nan)

    def against_ring(self, east, north, stretch):
        """Of the disc at a point, against the ring around it; None where the map does not show nearly all of both."""
        reach = (RING_M + RING_WIDTH_M) * stretch / self.pixel
        column, row = (east - self.left) / self.pixel - 0.5, (self.top - north) / self.pixel - 0.5
        first_row, first_column = int(row - reach), int(column - reach)
        last_row, last_column = int(row + reach) + 2, int(column + reach) + 2
        if first_row < 0 or first_column < 0 or last_row > self.log.shape[0] or last_column > self.log.shape[1]:
            return None
        part = self.log[first_row:last_row, first_column:last_column]
        away_m = self.pixel / stretch * numpy.hypot(*numpy.ogrid[first_row - row:last_row - row - 0.5,
                                                                 first_column - column:last_column - column - 0.5])
        means = []
        for inside in (away_m < DISC_M, numpy.abs(away_m - RING_M) < 0.5 * RING_WIDTH_M):
            values = part[inside]
            if numpy.isfinite(values).mean() < 0.9:
                return None
            means.append(numpy.nanmean(values))
        return means[0] - means[1]


def against_rings(folder, look, truth=None):
    """(at each camera's point opposite the sun, at each camera the mean of eight points elsewhere)."""
    lat = json.loads((folder / "locate.json").read_text())["origin"][0]
    stretch = 1.0 / numpy.cos(numpy.radians(lat))
    places, _ = cameras_of(folder)
    light = Lightness(folder / "mosaic.tif", truth, PIXEL_M * stretch)
    there, elsewhere = [], []
    for east, north, height in places:
        at = light.against_ring(east + height * look[0], north + height * look[1], stretch)
        if at is not None:
            there.append(at)
        turned = []
        for step in range(1, 9):
            angle = 2 * numpy.pi * step / 9
            x = numpy.cos(angle) * look[0] - numpy.sin(angle) * look[1]
            y = numpy.sin(angle) * look[0] + numpy.cos(angle) * look[1]
            turned.append(light.against_ring(east + height * x, north + height * y, stretch))
        turned = [value for value in turned if value is not None]
        if turned:
            elsewhere.append(numpy.mean(turned))
    return numpy.array(there), numpy.array(elsewhere)


def say(name, there, elsewhere):
    if len(there) < 2:
        print(f"{name:34}no two cameras' points opposite the sun lie in the map", flush=True)
        return
    sigma = there.std(ddof=1)
    print(f"{name:34}{len(there):8}{numpy.exp(there.mean()):9.4f}{sigma / numpy.sqrt(len(there)):9.4f}"
          f"{numpy.exp(numpy.median(there)):9.4f}{sigma:9.4f}{numpy.exp(there[numpy.abs(there).argmax()]):9.4f}"
          f"{numpy.exp(numpy.mean(elsewhere)) if len(elsewhere) else numpy.nan:11.4f}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", nargs="?")
    parser.add_argument("--by", help="another skyquilt, which stitches the flights that PROGRAM simulates")
    parser.add_argument("--photos", default="60")
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--map", type=pathlib.Path)
    parser.add_argument("--utc", type=datetime.datetime.fromisoformat)
    parser.add_argument("--look", type=lambda text: numpy.array([float(part) for part in text.split(",")]))
    options = parser.parse_args()
    if (options.program is None) == (options.map is None):
        parser.error("give a PROGRAM, or --map with --utc or --look")
    print(f"{'':34}{'cameras':>8}{'mean':>9}{'sigma':>9}{'median':>9}{'of one':>9}{'furthest':>9}{'elsewhere':>11}", flush=True)
    if options.map:
        if options.utc is None and options.look is None:
            parser.error("--map needs --utc or --look")
        lat, lon = json.loads((options.map / "locate.json").read_text())["origin"][:2]
        look = options.look if options.look is not None else look_opposite_the_sun(lat, lon, options.utc)
        say(f"{options.map.name} ({look[0]:.3f},{look[1]:.3f})", *against_rings(options.map, look))
        return
    for strength, width in [(0.0, WIDTHS_DEG[0])] + [(s, w) for s in STRENGTHS for w in WIDTHS_DEG]:
        for seed in range(1, options.seeds + 1):
            with tempfile.TemporaryDirectory(prefix="skyquilt_hot_spot_") as scratch:
                folder = pathlib.Path(scratch)
                subprocess.run([options.program, "simulate", "-o", folder / "flight", "--photos", options.photos, "--seed", str(seed),
                                "--lat", str(LAT_DEG), "--lon", str(LON_DEG), "--size", "800x600", "--noise", "rtk", "--vignetting", "0.2",
                                "--exposure-jitter", "0.05", "--hot-spot", str(strength), "--hot-spot-deg", str(width)],
                               check=True, capture_output=True)
                subprocess.run([options.by or options.program, "stitch", folder / "flight" / "photos", "-o", folder / "map",
                                "--formats", "geotiff"], check=True, capture_output=True)
                lat, lon = json.loads((folder / "map" / "locate.json").read_text())["origin"][:2]
                look = look_opposite_the_sun(lat, lon, SIMULATED_UTC)
                result = against_rings(folder / "map", look, folder / "flight" / "truth" / "world.tif")
            say(f"{100 * strength:.0f} %, {width} deg, seed {seed}" if strength else f"none, seed {seed}", *result)


if __name__ == "__main__":
    main()
