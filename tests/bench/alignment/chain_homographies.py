"""The feature-based mosaic of Iz and Unel, their baseline, by OpenCV: SIFT features, each photo chained to the one before
it by a homography (their equation 1), then laid once more on all that the mosaic shows of it (equation 3). No recorded
pose is used until the end, where each connected component is laid on the recorded positions as a whole, so that it can be
drawn and measured. A photo that matches none of the three before it begins a component of its own; one alone is left out.
Used by paper.py.
"""
import dataclasses
import json

import cv2
import numpy
from osgeo import gdal, osr

from map_against_truth import rotation

STEPS_BACK, NEIGHBOURS = 3, 4
DISTANCE_RATIO = 0.8      # of the nearest to the second nearest descriptor
TOLERANCE_SHARE = 0.004   # of a photo's width
NEIGHBOUR_SHARE = 0.75    # of a photo's diagonal between middles: farther hardly overlaps
MAX_GROWTH = 6.0          # of a photo's area in the mosaic: more is a broken chain


@dataclasses.dataclass
class Photo:
    name: str
    picture: numpy.ndarray  # freed of lens bending
    position: complex       # recorded, east and north in metres
    lens: tuple             # matrix, distortion: as recorded
    places: numpy.ndarray = None       # of its features, pixels
    descriptors: numpy.ndarray = None
    mosaic_from_photo: numpy.ndarray = None  # nothing: it matches none
    component: int = -1
    square_px: float = 0.0  # of the features that agree with where it lies
    agreeing: int = 0

    @property
    def corners(self):
        height, width = self.picture.shape[:2]
        return numpy.array([[0, 0], [width - 1, 0], [width - 1, height - 1], [0, height - 1]], float)

    @property
    def middle(self):
        return mapped(self.mosaic_from_photo, self.corners.mean(0)[None])[0]

    @property
    def tolerance_px(self):
        return TOLERANCE_SHARE * self.picture.shape[1]


def mapped(homography, places):
    return cv2.perspectiveTransform(places.reshape(-1, 1, 2), homography).reshape(-1, 2)


def read(located, folder):
    """The photos in the order of capture, with their features."""
    sift, photos = cv2.SIFT_create(4000), []
    for camera in located["cameras"]:
        lens = (numpy.array([[camera["focal_px"][0], 0, camera["center_px"][0]], [0, camera["focal_px"][1], camera["center_px"][1]],
                             [0, 0, 1]]), numpy.array(camera["distortion"]))
        picture = cv2.undistort(cv2.imread(str(folder / camera["name"])), *lens)
        center = -rotation(camera["rotation_wxyz"]).T @ camera["translation_m"]
        photo = Photo(camera["name"], picture, complex(*center[:2]), lens)
        keypoints, photo.descriptors = sift.detectAndCompute(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), None)
        photo.places = numpy.array([keypoint.pt for keypoint in keypoints]).reshape(-1, 2)
        photos.append(photo)
    return photos


def robust(source, target, tolerance):
    """A homography and who agrees with it; believed by the rule of Brown and Lowe (2007)."""
    if len(source) < 4:
        return None
    found, agreeing = cv2.findHomography(source, target, cv2.USAC_MAGSAC, tolerance)
    if found is None or agreeing.sum() <= 5.9 + 0.22 * len(source):
        return None
    return found, agreeing.ravel().astype(bool)


def match(photo, other):
    """Places of features that agree, in the photo and in the other, and the homography between them."""
    if photo.descriptors is None or other.descriptors is None or len(other.places) < 2:
        return None
    pairs = [near[0] for near in cv2.BFMatcher().knnMatch(photo.descriptors, other.descriptors, 2)
             if near[0].distance < DISTANCE_RATIO * near[1].distance]
    source = photo.places[[pair.queryIdx for pair in pairs]].reshape(-1, 2)
    target = other.places[[pair.trainIdx for pair in pairs]].reshape(-1, 2)
    fit = robust(source, target, other.tolerance_px)
    return fit and (source[fit[1]], target[fit[1]], fit[0])


def is_sound(photo, mosaic_from_photo):
    """A photo of the ground from above stays a convex quadrangle of about its size, not mirrored."""
    corners = mapped(mosaic_from_photo, photo.corners)
    sides = numpy.roll(corners, -1, 0) - corners
    following = numpy.roll(sides, -1, 0)
    turns = sides[:, 0] * following[:, 1] - sides[:, 1] * following[:, 0]
    growth = cv2.contourArea(corners.astype(numpy.float32)) / cv2.contourArea(photo.corners.astype(numpy.float32))
    return (turns > 0).all() and 1 / MAX_GROWTH < growth < MAX_GROWTH


def neighbours(photos, index):
    """Earlier photos of its component that lie around it, the nearest first."""
    photo = photos[index]
    first, _, last, _ = mapped(photo.mosaic_from_photo, photo.corners)
    apart = [(numpy.linalg.norm(other.middle - photo.middle), i) for i, other in enumerate(photos[:index])
             if other.component == photo.component]
    return [photos[i] for distance, i in sorted(apart)[:NEIGHBOURS] if distance < NEIGHBOUR_SHARE * numpy.linalg.norm(last - first)]


def lay_on_mosaic(photo, others):
    """Equation 3: one homography for all that the mosaic already shows of this photo."""
    matches = [(other, found) for other in others if (found := match(photo, other))]
    source = numpy.vstack([found[0] for _, found in matches])
    target = numpy.vstack([mapped(other.mosaic_from_photo, found[1]) for other, found in matches])
    scale = max(numpy.sqrt(abs(numpy.linalg.det(other.mosaic_from_photo[:2, :2]))) for other, _ in matches)
    tolerance = 2 * photo.tolerance_px * scale
    fit = robust(source, target, tolerance)
    if fit and is_sound(photo, fit[0]):
        photo.mosaic_from_photo = fit[0]
    off = numpy.linalg.norm(mapped(photo.mosaic_from_photo, source) - target, axis=1)
    agreeing = off[off <= tolerance] / scale
    photo.agreeing, photo.square_px = len(agreeing), float((agreeing ** 2).sum())


def chain(photos):
    """Gives each photo its place in the mosaic of its component."""
    components = 0
    for index, photo in enumerate(photos):
        for other in reversed(photos[max(0, index - STEPS_BACK):index]):
            found = match(photo, other)
            if found and is_sound(photo, other.mosaic_from_photo @ found[2]):
                photo.mosaic_from_photo, photo.component = other.mosaic_from_photo @ found[2], other.component
                lay_on_mosaic(photo, [other, *(near for near in neighbours(photos, index) if near is not other)])
                break
        else:
            photo.mosaic_from_photo, photo.component = numpy.eye(3), components
            components += 1


def ground_from_mosaic(photos):
    """The similarity that brings a component's middles to the recorded positions, as if all looked straight down: east and
    north of the mosaic's x and y, which runs down."""
    middles = numpy.array([complex(photo.middle[0], -photo.middle[1]) for photo in photos])
    design = numpy.column_stack([middles, numpy.ones_like(middles)])
    turn, move = numpy.linalg.lstsq(design, numpy.array([photo.position for photo in photos]), rcond=None)[0]
    return numpy.array([[turn.real, turn.imag, move.real], [turn.imag, -turn.real, move.imag], [0, 0, 1]])


def place(photos):
    """By name: the homography from a photo's pixels to the ground, metres east and north."""
    placed = {}
    for component in {photo.component for photo in photos}:
        together = [photo for photo in photos if photo.component == component]
        if len(together) > 1:
            ground = ground_from_mosaic(together)
            placed.update((photo.name, ground @ photo.mosaic_from_photo) for photo in together)
    return placed


def draw(photos, placed, origin, file):
    """A GeoTIFF in EPSG:3857: each pixel of the photos that show it, the more the nearer it is to their middles."""
    shown = [photo for photo in photos if photo.name in placed]
    corners = numpy.vstack([mapped(placed[photo.name], photo.corners) for photo in shown])
    (west, south), (east, north) = corners.min(0), corners.max(0)
    size_m = numpy.median([cv2.contourArea(mapped(placed[photo.name], photo.corners).astype(numpy.float32)) for photo in shown])
    gsd_m = numpy.sqrt(size_m / numpy.median([photo.picture.shape[0] * photo.picture.shape[1] for photo in shown]))
    width, height = int((east - west) / gsd_m) + 1, int((north - south) / gsd_m) + 1
    pixel_from_ground = numpy.array([[1 / gsd_m, 0, -west / gsd_m], [0, -1 / gsd_m, north / gsd_m], [0, 0, 1]])
    total, weights = numpy.zeros((height, width, 3), numpy.float32), numpy.zeros((height, width), numpy.float32)
    for photo in shown:
        rows, columns = photo.picture.shape[:2]
        tent = numpy.minimum.outer(1 - abs(numpy.linspace(-1, 1, rows)), 1 - abs(numpy.linspace(-1, 1, columns)))
        to_map = pixel_from_ground @ placed[photo.name]
        weight = cv2.warpPerspective((tent + 1e-3).astype(numpy.float32) ** 4, to_map, (width, height))
        total += cv2.warpPerspective(photo.picture, to_map, (width, height)) * weight[..., None]
        weights += weight
    colours = numpy.round(total / numpy.maximum(weights, 1e-20)[..., None]).astype(numpy.uint8)
    local = gdal.GetDriverByName("MEM").Create("", width, height, 4)
    local.SetGeoTransform((west - gsd_m / 2, gsd_m, 0, north + gsd_m / 2, 0, -gsd_m))  # counted from corners
    reference = osr.SpatialReference()
    reference.ImportFromProj4(f"+proj=aeqd +lat_0={origin[0]} +lon_0={origin[1]} +datum=WGS84")
    local.SetProjection(reference.ExportToWkt())
    for band, values in enumerate([*(colours[..., channel] for channel in (2, 1, 0)), (weights > 0) * numpy.uint8(255)]):
        local.GetRasterBand(band + 1).WriteArray(values)
    local.GetRasterBand(4).SetColorInterpretation(gdal.GCI_AlphaBand)
    gdal.Warp(str(file), local, dstSRS="EPSG:3857", resampleAlg="cubic")


def make(folder, located_file, out):
    """Makes OUT/mosaic.tif. What came of it: the photos, and by name where each of those placed shows the ground."""
    cv2.setRNGSeed(1)
    located = json.loads(located_file.read_text())
    photos = read(located, folder)
    chain(photos)
    placed = place(photos)
    if placed:
        out.mkdir(parents=True, exist_ok=True)
        draw(photos, placed, located["origin"], out / "mosaic.tif")
    return photos, placed
