"""A map's GeoTIFF in UTM: processor seconds of the program and of GDAL's two steps (gdalwarp, COG driver) in one run, and how far
their pixels differ.

    python3 tests/bench/exports/utm_against_gdal.py PROGRAM PHOTOS

PHOTOS: a flight, stitched first, whose processor seconds stand beside."""
import os
import pathlib
import re
import resource
import subprocess
import sys
import tempfile

import numpy
from osgeo import gdal

gdal.UseExceptions()
BLOCK_PX = 2048


def cpu_s(*words):
    def spent():
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        return used.ru_utime + used.ru_stime
    before = spent()
    subprocess.run([str(word) for word in words], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return spent() - before


def compared(one, other):
    """(mean difference of levels where both show something, share of pixels that one of them alone shows)."""
    difference, both, either, alone = 0.0, 0, 0, 0
    width, height = min(one.RasterXSize, other.RasterXSize), min(one.RasterYSize, other.RasterYSize)  # halves are rounded up here, down there
    for top in range(0, height, BLOCK_PX):
        for left in range(0, width, BLOCK_PX):
            box = left, top, min(BLOCK_PX, width - left), min(BLOCK_PX, height - top)
            a, b = (raster.ReadAsArray(*box)[:3].astype(numpy.int16) for raster in (one, other))
            shown_a, shown_b = (raster.GetRasterBand(1).GetMaskBand().ReadAsArray(*box) > 127 for raster in (one, other))
            seen = shown_a & shown_b
            difference += float(abs(a - b)[:, seen].sum()) / 3.0
            both += int(seen.sum())
            either += int((shown_a | shown_b).sum())
            alone += int((shown_a ^ shown_b).sum())
    return difference / both, alone / either


def main():
    program, photos = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        made, ours, warped, theirs = folder / "map", folder / "ours.tif", folder / "warped.tif", folder / "theirs.tif"
        stitch_s = cpu_s(program, "stitch", photos, "-o", made)
        ours_s = cpu_s(program, "export", made, "-o", ours, "--crs", "utm")
        subprocess.run([program, "export", made, "-o", folder / "merc.tif"], check=True, stderr=subprocess.DEVNULL)
        raster = gdal.Open(str(ours))
        left, pixel, _, top, _, _ = raster.GetGeoTransform()
        box = [left, top - pixel * raster.RasterYSize, left + pixel * raster.RasterXSize, top]
        code = raster.GetSpatialRef().GetAuthorityCode(None)
        threads = str(os.cpu_count())
        warp_s = cpu_s("gdalwarp", "-q", "-t_srs", f"EPSG:{code}", "-te", *box, "-tr", pixel, pixel, "-r", "cubic", "-dstalpha", "-multi",
                       "-wo", f"NUM_THREADS={threads}", "-co", "TILED=YES", "-co", "COMPRESS=DEFLATE", "-co", "ZLEVEL=1", folder / "merc.tif", warped)
        cog_s = cpu_s("gdal_translate", "-q", "-of", "COG", "-co", "COMPRESS=JPEG", "-co", "QUALITY=85", "-co",
                      "OVERVIEW_RESAMPLING=AVERAGE", "-co", f"NUM_THREADS={threads}", warped, theirs)
        print(f"map {stitch_s:.1f} CPU-s; UTM {ours_s:.1f}; GDAL {warp_s + cog_s:.1f} (gdalwarp {warp_s:.1f}, COG {cog_s:.1f}): "
              f"{ours_s / stitch_s:.2f} of the map, {ours_s / (warp_s + cog_s):.2f} of GDAL")
        for number in range(-1, raster.GetRasterBand(1).GetOverviewCount()):
            pair = []
            for path in (ours, theirs):
                level = gdal.OpenEx(str(path), open_options=[] if number < 0 else [f"OVERVIEW_LEVEL={number}"])
                pair.append(level)
            mean, alone = compared(*pair)
            print(f"level {number + 1} ({pair[0].RasterXSize} x {pair[0].RasterYSize}): mean difference {mean:.2f} levels, "
                  f"{100 * alone:.3f} % of pixels shown by one alone")
        info = subprocess.run(["gdalinfo", ours], check=True, capture_output=True, text=True).stdout
        print(", ".join(sorted(re.findall(r"LAYOUT=\w+|COMPRESSION=[\w ]+|Mask Flags: \w+", info))), f"{ours.stat().st_size / 1e6:.1f} MB,",
              f"GDAL's {theirs.stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    main()
