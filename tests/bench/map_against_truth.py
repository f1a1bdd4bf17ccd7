"""A finished map of a simulated flight against the world that it shows, patch by patch. Used by map_accuracy.py and
surface_accuracy.py. Needs python3-gdal with numpy.
"""
import numpy
from osgeo import gdal

gdal.UseExceptions()
PATCH_PX = 192
STEP_PX = 256


def gray(dataset, window=None, size=None):
    """(luminance, covered) of a window."""
    options = {} if window is None else dict(xoff=window[0], yoff=window[1], win_xsize=window[2], win_ysize=window[3])
    if size is not None:
        options.update(buf_xsize=size[0], buf_ysize=size[1], resample_alg=gdal.GRIORA_Average)
    bands = [dataset.GetRasterBand(i + 1).ReadAsArray(**options).astype(numpy.float32) for i in range(3)]
    covered = numpy.ones_like(bands[0], bool)
    if dataset.RasterCount == 4:
        covered = dataset.GetRasterBand(4).ReadAsArray(**options) > 250
    return 0.3 * bands[0] + 0.59 * bands[1] + 0.11 * bands[2], covered


def shift_between(first, second):
    """By how many pixels `second` is shifted against `first` (x, y), and how sharp the peak is."""
    taper = numpy.outer(numpy.hanning(first.shape[0]), numpy.hanning(first.shape[1]))
    spectra = [numpy.fft.rfft2((image - image.mean()) * taper) for image in (first, second)]
    cross = spectra[1] * spectra[0].conj()
    # Whitened, but for frequencies that hold nothing but noise.
    magnitude = numpy.abs(cross)
    peaks = numpy.fft.irfft2(cross / (magnitude + 0.05 * magnitude.mean() + 1e-6), first.shape)
    row, column = numpy.unravel_index(numpy.argmax(peaks), peaks.shape)
    around = numpy.roll(peaks, (2 - row, 2 - column), (0, 1))[:5, :5].clip(0)
    offsets = numpy.arange(-2, 3)
    x = column + (around.sum(0) * offsets).sum() / around.sum()
    y = row + (around.sum(1) * offsets).sum() / around.sum()
    rest = peaks.copy()
    rest[numpy.ix_((row + numpy.arange(-4, 5)) % rest.shape[0], (column + numpy.arange(-4, 5)) % rest.shape[1])] = 0
    height, width = first.shape
    shift = numpy.array([x - width if x > width / 2 else x, y - height if y > height / 2 else y])
    return shift, peaks[row, column] / max(rest.max(), 1e-9)


def measure(mosaic_path, world_path):
    """(shifts in metres, patch centres in metres, ground metres a pixel, patches looked at)."""
    mosaic = gdal.Open(str(mosaic_path))
    left, pixel, _, top, _, _ = mosaic.GetGeoTransform()
    columns, rows = mosaic.RasterXSize, mosaic.RasterYSize
    world = gdal.Warp("", str(world_path), format="MEM", dstSRS="EPSG:3857", xRes=pixel, yRes=pixel, resampleAlg="cubic",
                      outputBounds=(left, top - rows * pixel, left + columns * pixel, top))
    # The whole map first: patches are too small for a shift of many metres.
    scale = max(1.0, max(columns, rows) / 1400)
    small = (int(columns / scale), int(rows / scale))
    map_small, covered = gray(mosaic, size=small)
    world_small, _ = gray(world, size=small)
    whole, _ = shift_between(numpy.where(covered, world_small, 0), numpy.where(covered, map_small, 0))
    coarse = numpy.round(whole * scale).astype(int)
    lat = gdal.Info(str(mosaic_path), format="json")["wgs84Extent"]["coordinates"][0][0][1]
    ground_m = pixel * numpy.cos(numpy.radians(lat))
    shifts, centres, looked_at = [], [], 0
    for y in range(0, rows - PATCH_PX, STEP_PX):
        for x in range(0, columns - PATCH_PX, STEP_PX):
            patch, covered = gray(mosaic, (x, y, PATCH_PX, PATCH_PX))
            if not covered.all():
                continue
            looked_at += 1
            from_x, from_y = x - coarse[0], y - coarse[1]
            if min(from_x, from_y) < 0 or from_x + PATCH_PX > columns or from_y + PATCH_PX > rows:
                continue
            truth, _ = gray(world, (int(from_x), int(from_y), PATCH_PX, PATCH_PX))
            if truth.std() < 1.0:
                continue
            shift, sharpness = shift_between(truth, patch)
            if sharpness > 1.6:
                shifts.append((shift + coarse) * ground_m)
                centres.append(numpy.array([x, y]) * ground_m)
    return numpy.array(shifts), numpy.array(centres), ground_m, looked_at


def after_similarity(shifts, centres):
    """What is left of the shifts when the map may be moved, turned and scaled as a whole (robust)."""
    x, y = (centres - centres.mean(0)).T
    zero, one = numpy.zeros_like(x), numpy.ones_like(x)
    design = numpy.concatenate([numpy.stack([x, -y, one, zero], 1), numpy.stack([y, x, zero, one], 1)])
    target = shifts.T.ravel()
    weights = numpy.ones_like(target)
    for _ in range(20):
        root = numpy.sqrt(weights)
        solution = numpy.linalg.lstsq(design * root[:, None], target * root, rcond=None)[0]
        left = (target - design @ solution).reshape(2, -1).T
        length = numpy.linalg.norm(left, axis=1)
        weights = numpy.tile(1 / numpy.maximum(length, max(1.5 * numpy.median(length), 1e-4)), 2)
    return length


def rotation(wxyz):
    w, x, y, z = wxyz
    return numpy.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


def metres_per_degree(lat_deg):
    """North and east."""
    return (111_132.95 - 559.85 * numpy.cos(2 * numpy.radians(lat_deg)),
            111_412.84 * numpy.cos(numpy.radians(lat_deg)))
