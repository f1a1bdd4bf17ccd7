"""Does a list of surveyed points agree with its photos at all? Asked of COLMAP alone: its cameras triangulate each point
from the marks of the list, and the best similarity holds the points against the surveyed ones, all of them and each one
against the others. Distances between points need no similarity: in a list that agrees with the photos they are all the
same multiple of the reconstruction's.

    python3 tests/bench/alignment/control_by_colmap.py PHOTOS gcp_list.txt [--keep FOLDER]

The list is one in metres (the first line is not looked at), marks in pixels of the photos. Needs numpy, cv2 and colmap.
"""
import argparse
import pathlib
import sys
import tempfile

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import peers  # noqa: E402

MAX_MISS_PX = 5.0


def reconstruct(photos, folder):
    """(by photo: rotation, translation, camera; by camera: focal length, centre and radial distortion)."""
    if not (folder / "sparse").is_dir():
        (folder / "sparse").mkdir(parents=True)
        database = ("--database_path", folder / "database.db")
        peers.run("colmap", "feature_extractor", *database, "--image_path", photos, "--ImageReader.single_camera", 1,
                  "--ImageReader.camera_model", "SIMPLE_RADIAL", "--SiftExtraction.use_gpu", 0,
                  "--SiftExtraction.max_num_features", peers.COLMAP_FEATURES)
        peers.run("colmap", "exhaustive_matcher", *database, "--SiftMatching.use_gpu", 0)
        peers.run("colmap", "mapper", *database, "--image_path", photos, "--output_path", folder / "sparse")
    largest, lenses = {}, {}
    for model in sorted((folder / "sparse").iterdir()):
        peers.run("colmap", "model_converter", "--input_path", model, "--output_path", model, "--output_type", "TXT")
        lines = [line.split() for line in (model / "images.txt").read_text().splitlines() if not line.startswith("#")]
        poses = {row[9]: (peers.rotation(*map(float, row[1:5])), numpy.array(row[5:8], float), row[8]) for row in lines[::2]}
        if len(poses) > len(largest):
            cameras = [line.split() for line in (model / "cameras.txt").read_text().splitlines() if not line.startswith("#")]
            largest, lenses = poses, {row[0]: numpy.array(row[4:], float) for row in cameras}
    return largest, lenses


def seen_at(point, pose, lenses):
    rotation, translation, camera = pose
    focal, x, y, radial = lenses[camera]
    in_camera = rotation @ point + translation
    plane = in_camera[:2] / in_camera[2]
    return focal * (1 + radial * plane @ plane) * plane + (x, y)


def triangulate(marks, poses, lenses):
    """(point, root of the mean square miss in pixels), from marks (photo, pixel)."""
    rows = []
    for photo, pixel in marks:
        rotation, translation, camera = poses[photo]
        focal, x, y, radial = lenses[camera]
        distorted = (pixel - (x, y)) / focal
        plane = distorted.copy()
        for _ in range(20):
            plane = distorted / (1 + radial * plane @ plane)
        matrix = numpy.c_[rotation, translation]
        rows += [plane[0] * matrix[2] - matrix[0], plane[1] * matrix[2] - matrix[1]]
    point = numpy.linalg.svd(numpy.array(rows))[2][-1]
    point = point[:3] / point[3]

    def misses(at):
        return numpy.concatenate([seen_at(at, poses[photo], lenses) - pixel for photo, pixel in marks])

    for _ in range(10):
        slopes = numpy.array([(misses(point + step) - misses(point - step)) / 2e-4 for step in numpy.eye(3) * 1e-4]).T
        point = point - numpy.linalg.lstsq(slopes, misses(point), rcond=None)[0]
    return point, numpy.sqrt((misses(point) ** 2).sum() / len(marks))


def similarity(points, onto):
    """Umeyama 1991."""
    middle, there = points.mean(0), onto.mean(0)
    left, stretch, right = numpy.linalg.svd((onto - there).T @ (points - middle))
    sign = numpy.array([1, 1, numpy.sign(numpy.linalg.det(left @ right))])
    turn = left @ numpy.diag(sign) @ right
    scale = (stretch * sign).sum() / ((points - middle) ** 2).sum()
    return lambda point: scale * (turn @ (point - middle)) + there


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("photos", type=pathlib.Path)
    parser.add_argument("list", type=pathlib.Path)
    parser.add_argument("--keep", type=pathlib.Path, help="where COLMAP's work stays, for the next time")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="skyquilt_control_") as scratch:
        poses, lenses = reconstruct(options.photos, options.keep or pathlib.Path(scratch))
    print(f"{len(poses)} photos in COLMAP's largest model")
    marks = {}
    for row in (line.split() for line in options.list.read_text().splitlines()[1:] if line.strip()):
        if row[5] in poses:
            marks.setdefault((row[6], *map(float, row[:3])), []).append((row[5], numpy.array(row[3:5], float)))
    points, surveyed = [], []
    for (name, *place), seen in marks.items():
        if len(seen) < 2:
            print(f"{name}: marked in {len(seen)} of these photos")
            continue
        point, miss_px = triangulate(seen, poses, lenses)
        print(f"{name}: {len(seen)} marks, {miss_px:.2f} px" + ("; they contradict each other" if miss_px > MAX_MISS_PX else ""))
        if miss_px <= MAX_MISS_PX:
            points.append(point)
            surveyed.append(place)
    points, surveyed = numpy.array(points), numpy.array(surveyed)
    misses = [numpy.linalg.norm((similarity(points, surveyed)(points[i]) - surveyed[i])[:2]) for i in range(len(points))]
    print("all together, horizontal m:", *(f"{miss:.2f}" for miss in misses))
    left_out = []
    for i in range(len(points)):
        others = [k for k in range(len(points)) if k != i]
        left_out.append(numpy.linalg.norm((similarity(points[others], surveyed[others])(points[i]) - surveyed[i])[:2]))
    print("each by the others, horizontal m:", *(f"{miss:.2f}" for miss in left_out), f"median {numpy.median(left_out):.2f}")
    pairs = numpy.triu_indices(len(points), 1)
    apart = [numpy.linalg.norm(these[:, None] - these[None], axis=2)[pairs] for these in (surveyed, points)]
    ratios = apart[0] / apart[1] / numpy.median(apart[0] / apart[1])
    print(f"distances of the list, as multiples of the photos': {ratios.min():.2f} to {ratios.max():.2f} of their median")


if __name__ == "__main__":
    main()
