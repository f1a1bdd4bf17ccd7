"""Heights as OpenCV's StereoSGBM and a median have them, beside ours: each photo with its neighbours, rectified, matched, and
what all pairs say of a cell of our dsm.tif fused by the median. The poses are the simulator's true ones, and the heights sought
those of the world and three metres: better than any pipeline has them. Heights count from the median of the open ground, for ours
lie off as a whole by what is not known of the focal length.

    python3 tests/bench/surface_accuracy.py PROGRAM --keep DIR --only houses_60m_75 --stitch --formats dsm
    python3 tests/bench/surface_by_stereo.py DIR/houses_60m_75_1 [--partners N]

Prints the row of ours and the one of StereoSGBM, with processor seconds. Needs python3-opencv and python3-gdal with numpy.
"""
import argparse
import json
import pathlib
import resource
import sys

import cv2
import numpy
from osgeo import gdal, osr

from heights_against_truth import UNKNOWN_M, measure_heights, truth_on, wgs84
from map_against_truth import metres_per_degree, rotation

BLOCK_PX = 5
LEAST_BASE, MOST_BASE = 0.15, 0.6  # over the height
AROUND_M = 3.0
NAMES = ("answered", "NMAD", "RMSE", "roofs", "roofs P90", "volume", "volume worst")


class Photo:
    def __init__(self, folder, told):
        self.name = told["name"]
        self.gray = cv2.imread(str(folder / "photos" / told["name"]), cv2.IMREAD_GRAYSCALE)
        self.center = numpy.array(told["camera_center_in_enu"])
        self.cam_from_enu = rotation(told["cam_from_enu_wxyz"])


def rectified(photo, axes, lens, side):
    """The photo as a camera of the axes sees it from the same place."""
    k = numpy.array([[lens["focal_x_px"], 0, lens["center_x_px"]], [0, lens["focal_y_px"], lens["center_y_px"]], [0, 0, 1]])
    bent = numpy.array([lens.get(name, 0.0) for name in ("k1", "k2", "p1", "p2", "k3")])
    straight = numpy.array([[lens["focal_x_px"], 0, side / 2], [0, lens["focal_x_px"], side / 2], [0, 0, 1]])
    maps = cv2.initUndistortRectifyMap(k, bent, axes @ photo.cam_from_enu.T, straight, (side, side), cv2.CV_32FC1)
    return cv2.remap(photo.gray, *maps, cv2.INTER_LINEAR), maps


def points_of_pair(first, second, lens, low_m, high_m):
    """What the pair shows, in enu."""
    base = second.center - first.center
    length = numpy.linalg.norm(base)
    x = base / length
    look = first.cam_from_enu[2] + second.cam_from_enu[2]
    z = look - look.dot(x) * x
    z /= numpy.linalg.norm(z)
    axes = numpy.stack([x, numpy.cross(z, x), z])
    side = int(numpy.hypot(lens["width_px"], lens["height_px"]))
    (left, maps), (right, _) = (rectified(photo, axes, lens, side) for photo in (first, second))
    height = first.center[2]
    nearest, farthest = (height - high_m) / -z[2], (height - low_m) / -z[2]
    least = int(lens["focal_x_px"] * length / farthest) - 8
    count = (int(lens["focal_x_px"] * length / nearest) + 8 - least + 15) // 16 * 16
    matcher = cv2.StereoSGBM_create(minDisparity=least, numDisparities=count, blockSize=BLOCK_PX, P1=8 * BLOCK_PX ** 2,
                                    P2=32 * BLOCK_PX ** 2, disp12MaxDiff=1, uniquenessRatio=10, speckleWindowSize=100,
                                    speckleRange=2)
    shift = matcher.compute(left, right).astype(numpy.float32) / 16
    inside = (maps[0] > 0) & (maps[1] > 0) & (maps[0] < lens["width_px"] - 1) & (maps[1] < lens["height_px"] - 1)
    row, column = numpy.nonzero(inside & (shift > least))
    depth = lens["focal_x_px"] * length / shift[row, column]
    rays = numpy.stack([(column - side / 2) / lens["focal_x_px"], (row - side / 2) / lens["focal_x_px"], numpy.ones(len(row))], 1)
    points = first.center + (depth[:, None] * rays) @ axes
    return points[(points[:, 2] > low_m) & (points[:, 2] < high_m)]


def partners_of(photos, most):
    """Of each photo those nearest to it with a base that is neither short nor long, each pair once."""
    pairs = set()
    for i, photo in enumerate(photos):
        near = []
        for j, other in enumerate(photos):
            base = numpy.linalg.norm(other.center - photo.center) / photo.center[2]
            if i != j and LEAST_BASE < base < MOST_BASE:
                near.append((base, j))
        pairs |= {(min(i, j), max(i, j)) for _, j in sorted(near)[:most]}
    return sorted(pairs)


def stereo_surface(folder, truth, partners):
    """dsm.tif and dsm_photos.tif in FOLDER/stereo, on the cells of ours."""
    ours = gdal.Open(str(folder / "map" / "dsm.tif"))
    rows, columns = ours.RasterYSize, ours.RasterXSize
    world = truth_on(ours, folder / "truth" / "surface.tif", "average", UNKNOWN_M)  # a band outlives its dataset by nothing
    surface = world.GetRasterBand(1).ReadAsArray()
    origin_m = truth["origin"]["height_ellipsoid_m"]
    true = surface[surface > UNKNOWN_M] - origin_m
    low_m, high_m = true.min() - AROUND_M, true.max() + AROUND_M
    from_degrees = osr.CoordinateTransformation(wgs84(), ours.GetSpatialRef())
    per_lat, per_lon = metres_per_degree(truth["origin"]["lat_deg"])
    corners = numpy.array(from_degrees.TransformPoints(
        [(truth["origin"]["lon_deg"] + e / per_lon, truth["origin"]["lat_deg"] + n / per_lat)
         for e, n in ((0, 0), (100, 0), (0, 100))]))[:, :2]
    axes = numpy.stack([corners[1] - corners[0], corners[2] - corners[0]], 1) / 100
    left, step, _, top, _, _ = ours.GetGeoTransform()
    photos = [Photo(folder, told) for told in truth["photos"]]
    cells, heights = [], []
    for i, j in partners_of(photos, partners):
        points = points_of_pair(photos[i], photos[j], truth["intrinsics"], low_m, high_m)
        place = points[:, :2] @ axes.T + corners[0]
        column, row = ((place[:, 0] - left) / step).astype(int), ((top - place[:, 1]) / step).astype(int)
        known = (column >= 0) & (row >= 0) & (column < columns) & (row < rows)
        cell = row[known] * columns + column[known]
        count = numpy.bincount(cell, minlength=rows * columns)
        some = numpy.flatnonzero(count)
        cells.append(some)
        heights.append((numpy.bincount(cell, points[known, 2], rows * columns)[some] / count[some]).astype(numpy.float32))
    cells, heights = numpy.concatenate(cells), numpy.concatenate(heights)
    order = numpy.lexsort((heights, cells))
    cells, heights = cells[order], heights[order]
    some, first, count = numpy.unique(cells, return_index=True, return_counts=True)
    out = {"dsm": numpy.full(rows * columns, numpy.nan), "dsm_photos": numpy.zeros(rows * columns)}
    out["dsm"][some] = (heights[first + (count - 1) // 2] + heights[first + count // 2]) / 2 + origin_m
    out["dsm_photos"][some] = numpy.minimum(count + 1, 255)
    (folder / "stereo").mkdir(exist_ok=True)
    for name, values in out.items():
        kind = gdal.GDT_Float32 if name == "dsm" else gdal.GDT_Byte
        made = gdal.GetDriverByName("GTiff").Create(str(folder / "stereo" / f"{name}.tif"), columns, rows, 1, kind)
        made.SetGeoTransform(ours.GetGeoTransform())
        made.SetProjection(ours.GetProjection())
        made.GetRasterBand(1).WriteArray(values.reshape(rows, columns))


def on_ground(folder, name, truth):
    """FOLDER/NAME moved to where its open ground is true in the median, in FOLDER/NAME/level."""
    off_m = measure_heights(folder / name / "dsm.tif", folder, truth, 1.0)["ground"]
    level = folder / name / "level"
    level.mkdir(exist_ok=True)
    for file in ("dsm.tif", "dsm_photos.tif"):
        gdal.Translate(str(level / file), str(folder / name / file))
    band = (moved := gdal.Open(str(level / "dsm.tif"), gdal.GA_Update)).GetRasterBand(1)
    band.WriteArray(band.ReadAsArray() - off_m)
    moved.FlushCache()
    return level / "dsm.tif"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--partners", type=int, default=4, help="of each photo")
    options = parser.parse_args()
    gdal.UseExceptions()
    truth = json.loads((options.folder / "truth" / "poses.json").read_text())
    began = resource.getrusage(resource.RUSAGE_SELF)
    stereo_surface(options.folder, truth, options.partners)
    ended = resource.getrusage(resource.RUSAGE_SELF)
    print(f"{'':12}" + "".join(f"{name:>14}" for name in NAMES))
    for name in ("map", "stereo"):
        numbers = measure_heights(on_ground(options.folder, name, truth), options.folder, truth, truth["gsd_m"])
        print(f"{'ours' if name == 'map' else 'StereoSGBM':12}" + "".join(f"{numbers.get(key, numpy.nan):14.3f}" for key in NAMES))
    seconds = ended.ru_utime + ended.ru_stime - began.ru_utime - began.ru_stime
    print(f"StereoSGBM and fusion: {seconds:.0f} s of processor time, {len(truth['photos'])} photos")


if __name__ == "__main__":
    sys.exit(main())
