"""A surface model of a simulated flight against the heights of the world that it shows. Used by surface_accuracy.py. Needs
python3-gdal with numpy.
"""
import pathlib

import numpy
from osgeo import gdal, osr

from map_against_truth import metres_per_degree, rotation

CELLS_ASKED = 40_000
UNKNOWN_M = -9999.0
NEAR_HOUSE_M, RING_M = 0.75, 2.5


def truth_on(grid, path, how, unknown=None):
    """The bands of a true raster on the grid of a dataset; `unknown` where it does not reach."""
    left, step, _, top, _, _ = grid.GetGeoTransform()
    bounds = (left, top - grid.RasterYSize * step, left + grid.RasterXSize * step, top)
    return gdal.Warp("", str(path), format="MEM", dstSRS=grid.GetProjection(), xRes=step, yRes=step, outputBounds=bounds,
                     resampleAlg=how, dstNodata=unknown)


def numbers_on(grid, folder):
    """Which object of the truth each cell shows, from 1; 0 is ground, -1 is water."""
    dataset = truth_on(grid, folder / "truth" / "surface.tif", "near")  # a band outlives its dataset by nothing
    return dataset.GetRasterBand(3).ReadAsArray().astype(int)


def grown(mask, cells):
    """With all that is so many cells away from it, along rows and columns."""
    out = mask.copy()
    for axis in (0, 1):
        now = out.copy()
        for by in range(1, cells + 1):
            for way in (by, -by):
                moved = numpy.roll(now, way, axis)
                edge = [slice(None)] * 2
                edge[axis] = slice(0, by) if way > 0 else slice(-by, None)
                moved[tuple(edge)] = False
                out |= moved
    return out


def seen_by(truth, east, north, height_m, surface, place_of):
    """By how many photos each point is seen, with nothing in the way. `place_of`: cell (column, row) of east and north."""
    lens = truth["intrinsics"]
    highest_m = numpy.nanmax(surface)
    counts = numpy.zeros(len(east), int)
    points = numpy.stack([east, north, height_m], 1)
    for photo in truth["photos"]:
        center = numpy.array(photo["camera_center_in_enu"])
        in_camera = (points - center) @ rotation(photo["cam_from_enu_wxyz"]).T
        x = lens["focal_x_px"] * in_camera[:, 0] / in_camera[:, 2] + lens["center_x_px"]
        y = lens["focal_y_px"] * in_camera[:, 1] / in_camera[:, 2] + lens["center_y_px"]
        inside = ((in_camera[:, 2] > 0) & (x > 0) & (y > 0) & (x < lens["width_px"] - 1) & (y < lens["height_px"] - 1))
        which = numpy.flatnonzero(inside)
        to_camera = center - points[which]
        to_top = ((highest_m - height_m[which]) / to_camera[:, 2]).clip(0, 1)
        free = numpy.ones(len(which), bool)
        for share in numpy.linspace(0, 1, 61)[1:]:
            on_way = points[which] + (share * to_top)[:, None] * to_camera
            column, row = place_of(on_way[:, 0], on_way[:, 1])
            known = (column >= 0) & (row >= 0) & (column < surface.shape[1]) & (row < surface.shape[0])
            free[known] &= ~(surface[row[known], column[known]] > on_way[known, 2] + 0.2)
        counts[which[free]] += 1
    return counts


def wgs84():
    system = osr.SpatialReference()
    system.ImportFromEPSG(4326)
    system.SetAxisMappingStrategy(osr.OAMS_TRADITIONAL_GIS_ORDER)
    return system


def volume_errors(truth, numbers, found, is_known, surface, terrain, cell_m):
    """Of each house that is known whole, relative; over the ground as the ring around it has it."""
    errors = []
    near, ring = (int(numpy.ceil(reach_m / cell_m)) for reach_m in (NEAR_HOUSE_M, RING_M))
    for number, house in enumerate(truth.get("objects", []), 1):
        rows, columns = numpy.nonzero(numbers == number)
        if not house["kind"].endswith("house") or len(rows) == 0:
            continue
        part = tuple(slice(max(0, at.min() - ring - 1), at.max() + ring + 2) for at in (rows, columns))
        own, other = numbers[part] == number, (numbers[part] != number) & (numbers[part] > 0)
        body = grown(own, near) & ~grown(other, near)
        around = grown(own, ring) & ~grown(own, near) & ~grown(other, near) & is_known[part]
        if around.sum() < 50 or is_known[part][body].mean() < 0.98:
            continue
        body &= is_known[part]
        base = numpy.median((found - terrain)[part][around])
        true = (surface - terrain)[part][body].sum()
        errors.append(abs((found - terrain)[part][body].sum() - base * body.sum() - true) / true)
    return errors


def measure_heights(dsm_path, folder, truth, gsd_m):
    """Numbers in GSD and shares, by name."""
    dsm = gdal.Open(str(dsm_path))
    band = dsm.GetRasterBand(1)
    found = band.ReadAsArray().astype(float)
    photos = gdal.Open(str(dsm_path).replace("dsm.tif", "dsm_photos.tif"))  # a band outlives its dataset by nothing
    is_answered = (photos.GetRasterBand(1).ReadAsArray() > 0) & numpy.isfinite(found)
    means, numbers = truth_on(dsm, folder / "truth" / "surface.tif", "average", UNKNOWN_M), numbers_on(dsm, folder)
    surface, terrain = (means.GetRasterBand(i).ReadAsArray().astype(float) for i in (1, 2))
    is_true = surface > UNKNOWN_M
    off = found - surface
    step = dsm.GetGeoTransform()[1]
    is_merc = "3857" in (dsm.GetSpatialRef().GetAuthorityCode(None) or "")
    cell_m = step * (numpy.cos(numpy.radians(truth["origin"]["lat_deg"])) if is_merc else 1.0)

    # Which of a sample of cells three photos see. Places in enu: from merc, by degrees.
    to_degrees = osr.CoordinateTransformation(dsm.GetSpatialRef(), wgs84())
    per_lat, per_lon = metres_per_degree(truth["origin"]["lat_deg"])
    left, _, _, top, _, _ = dsm.GetGeoTransform()
    corners = to_degrees.TransformPoints([(left, top), (left + step, top), (left, top - step)])
    enu = numpy.array([((c[0] - truth["origin"]["lon_deg"]) * per_lon, (c[1] - truth["origin"]["lat_deg"]) * per_lat)
                       for c in corners])
    axes = numpy.stack([enu[1] - enu[0], enu[2] - enu[0]], 1)
    back = numpy.linalg.inv(axes)

    def place_of(east, north):
        return numpy.floor(back @ (numpy.stack([east, north]) - enu[0][:, None])).astype(int)

    random = numpy.random.default_rng(1)
    rows, columns = numpy.nonzero(is_true)
    chosen = random.integers(0, len(rows), CELLS_ASKED)
    row, column = rows[chosen], columns[chosen]
    east, north = axes @ numpy.stack([column + 0.5, row + 0.5]) + enu[0][:, None]
    z = surface - truth["origin"]["height_ellipsoid_m"]
    is_seen = seen_by(truth, east, north, z[row, column], numpy.where(is_true, z, UNKNOWN_M), place_of) >= 3
    is_asked = is_seen & (numbers[row, column] >= 0)  # of water nothing is to be answered
    row, column = row[is_asked], column[is_asked]

    answered = is_answered[row, column]
    row, column = row[answered], column[answered]
    is_open = ~grown(numbers > 0, 2)
    on_ground = off[row, column][is_open[row, column]]
    kinds = numpy.array([0] + [1 if o["kind"].endswith("house") else 2 for o in truth.get("objects", [])])
    is_roof = kinds[numbers.clip(0)] == 1
    is_roof &= ~grown(~is_roof, 1)
    on_roofs = numpy.abs(off[is_roof & is_answered & is_true])
    median = numpy.median(on_ground)
    volumes = volume_errors(truth, numbers, found, is_answered & is_true, surface, terrain, cell_m)
    out = {"answered": answered.mean(), "ground": median / gsd_m,
           "NMAD": 1.4826 * numpy.median(numpy.abs(on_ground - median)) / gsd_m,
           "RMSE": numpy.sqrt((on_ground ** 2).mean()) / gsd_m}
    if len(on_roofs):
        out |= {"roofs": numpy.median(on_roofs) / gsd_m, "roofs P90": numpy.percentile(on_roofs, 90) / gsd_m}
    if len(volumes):
        out |= {"volume": numpy.median(volumes), "volume worst": max(volumes)}
    dtm_path = pathlib.Path(str(dsm_path).replace("dsm.tif", "dtm.tif"))
    if dtm_path.exists():
        ground = gdal.Open(str(dtm_path))
        below = numpy.abs(ground.GetRasterBand(1).ReadAsArray().astype(float) - terrain - median)
        is_told = is_true & numpy.isfinite(below)
        for name, where in (("below things", numbers > 0), ("beside", numbers <= 0)):
            where = where & is_told
            if where.any():
                out |= {name: numpy.median(below[where]) / gsd_m, f"{name} P90": numpy.percentile(below[where], 90) / gsd_m}
    return out
