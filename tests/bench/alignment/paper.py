"""Section III of Iz and Unel, "Aerial Image Stitching Using IMU Data from a UAV", made anew on simulated flights of
known truth: rough ground from 20 m with large displacements and rotations, and two photos of similar background (crop
rows, gravel), by every method side by side. Writes README.md (tables) and paper.jpg (pictures).

  python3 tests/bench/alignment/paper.py PROGRAM [-o tests/bench/alignment]

With --flight it is any flight instead: a table on standard output, the pictures in --out.
"""
import argparse
import json
import os
import pathlib
import platform
import resource
import subprocess
import sys
import tempfile
import time

import cv2
import numpy
from osgeo import gdal

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import chain_homographies  # noqa: E402
from map_against_truth import after_similarity, measure, metres_per_degree, rotation  # noqa: E402

METHODS = ("imu", "features", "auto")
PAIR = ["--photos", "2", "--overlap", "0.3", "--pixel-noise", "8", "--shutter-ms", "8", "--yaw", "any", "--tilt-deg", "5"]
SCENES = [
    ("Rough ground from 20 m, large displacement and rotation",
     ["--photos", "12", "--relief-m", "2", "--yaw", "any", "--tilt-deg", "6", "--jitter-m", "1.5"]),
    ("Two photos of crop rows", ["--texture", "rows", *PAIR]),
    ("Two photos of gravel", ["--texture", "bare", *PAIR]),
]
COMMON = ["--height", "20", "--size", "800x600", "--noise", "xmp", "--seed", "4", "--vignetting", "0.1",
          "--exposure-jitter", "0.05"]
PANEL_PX = 480
HEAD = ("| method | photos placed | by images | pieces | error CE90 m, absolute / relative | residual px "
        "| seam shift m, median / p90 | seconds | CPU s |\n|---|---|---|---|---|---|---|---|---|\n")
INTRODUCTION = """# The paper's comparison

Section III of Iz and Unel ("Aerial Image Stitching Using IMU Data from a UAV") shows that features tear or mismatch
where the ground is rough, the photos are far apart or all looks alike, and that recorded poses do not. The same
scenes here, simulated, so that the truth is known; positions 1.5 m, tilt 0.6 and yaw 1.5 degrees, focal length 1 %
off. `imu` is the paper's method with its geometry done exactly (`skyquilt stitch --method imu`), `features` its baseline
(homographies chained as in its equations 1 to 3, by OpenCV: `chain_homographies.py`), `auto` is what `skyquilt stitch`
does. Error: nine of ten patches of the map (on level ground: pixels of its photos) lie nearer to their true place;
relative, after the best shift, turn and scale of the whole map. The absolute error of all is that of the recorded
positions. A dash: too little to measure.

Made by `python3 tests/bench/alignment/paper.py PROGRAM` on {machine}.

![The maps of each scene by each method: the whole flight above, its middle below](paper.jpg)
"""


def number(value, digits=3):
    return "-" if value is None else f"{value:.{digits}f}"


def over_photo(size_px):
    """5 x 5 pixels, spread over a photo."""
    across = (numpy.arange(5) + 0.5) / 5
    return numpy.stack(numpy.meshgrid(across * size_px[0] - 0.5, across * size_px[1] - 0.5), -1).reshape(-1, 1, 2)


def on_the_ground(size_px, focal_px, center_px, distortion, cam_from_enu_wxyz, center_in_enu, ground_z):
    """Where a photo's pixels lie on level ground: east and north in metres."""
    lens = numpy.array([[focal_px[0], 0, center_px[0]], [0, focal_px[1], center_px[1]], [0, 0, 1]])
    rays = cv2.undistortPoints(over_photo(size_px), lens, numpy.array(distortion)).reshape(-1, 2)
    rays = numpy.column_stack([rays, numpy.ones(len(rays))]) @ rotation(cam_from_enu_wxyz)
    return center_in_enu[:2] + rays[:, :2] * ((ground_z - center_in_enu[2]) / rays[:, 2])[:, None]


def shown_by_cameras(located):
    """By name: where the photos' pixels lie on the map."""
    ground_z = numpy.median(located["ground"].get("heights_m") or [located["ground"]["z_m"]])
    return {camera["name"]: on_the_ground(camera["size_px"], camera["focal_px"], camera["center_px"], camera["distortion"],
                                          camera["rotation_wxyz"],
                                          -rotation(camera["rotation_wxyz"]).T @ camera["translation_m"], ground_z)
            for camera in located["cameras"]}


def shown_by_chain(photos, placed):
    """The same of chained homographies."""
    return {photo.name: chain_homographies.mapped(
                placed[photo.name],
                cv2.undistortPoints(over_photo(photo.picture.shape[1::-1]), *photo.lens, P=photo.lens[0]))
            for photo in photos if photo.name in placed}


def shifts_of_pixels(origin, shown, truth):
    """As `measure`, by where the photos' pixels lie: on level ground that tells of photos that show nothing to compare by."""
    per_lat, per_lon = metres_per_degree(truth["origin"]["lat_deg"])
    moved = numpy.array([(origin[1] - truth["origin"]["lon_deg"]) * per_lon, (origin[0] - truth["origin"]["lat_deg"]) * per_lat])
    lens = truth["intrinsics"]
    real = {photo["name"]: on_the_ground((lens["width_px"], lens["height_px"]), (lens["focal_x_px"], lens["focal_y_px"]),
                                         (lens["center_x_px"], lens["center_y_px"]),
                                         [lens[name] for name in ("k1", "k2", "p1", "p2", "k3")], photo["cam_from_enu_wxyz"],
                                         numpy.array(photo["camera_center_in_enu"]), 0.0) for photo in truth["photos"]}
    if not shown:
        return numpy.empty((0, 2)), numpy.empty((0, 2))
    centres = numpy.vstack([real[name] for name in shown])
    return moved + numpy.vstack(list(shown.values())) - centres, centres


def truth_error(mosaic, origin, shown, made):
    """CE90 in metres, as it is and after a similarity: of the photos' pixels on level ground, of the map's patches on any
    other; none where too few can be compared, or the flight `made` was not simulated."""
    if not (made / "truth" / "poses.json").exists():
        return None, None
    truth = json.loads((made / "truth" / "poses.json").read_text())
    if truth["relief_m"] > 0:
        shifts, centres, _, _ = measure(mosaic, made / "truth" / "world.tif")
    else:
        shifts, centres = shifts_of_pixels(origin, shown, truth)
    if len(shifts) < 4:
        return None, None
    return (float(numpy.percentile(numpy.linalg.norm(shifts, axis=1), 90)),
            float(numpy.percentile(after_similarity(shifts, centres), 90)))


def cpu_s():
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(one.ru_utime + one.ru_stime for one in used)


def stitch(program, method, photos, folder, made):
    """A row of the table after its name, but for its cost; and the map where there is one."""
    ran = subprocess.run([program, "stitch", photos, "-o", folder, "--method", method, "--overwrite"], capture_output=True,
                         text=True)
    if ran.returncode != 0:
        return lambda: (f"none: {(ran.stderr.strip().splitlines() or [ran.returncode])[-1]} | - | - | - | - | -", None)

    def told():
        report = json.loads((folder / "report.json").read_text())
        counts, alignment, seams = report["photos"], report["alignment"] or {}, report["seams"] or {}
        if not seams.get("reliable"):
            seams = {}  # nothing was measured
        located = json.loads((folder / "locate.json").read_text())
        mosaic = folder / "mosaic.mbtiles"
        absolute_m, relative_m = truth_error(mosaic, located["origin"], shown_by_cameras(located), made)
        return (f"{counts['aligned'] + counts['pose_only']} of {counts['total']} | {counts['aligned']} "
                f"| {alignment.get('pieces') or '-'} | {number(absolute_m)} / {number(relative_m)} "
                f"| {number(alignment.get('residual_rms_px'), 2)} "
                f"| {number(seams.get('median_m'))} / {number(seams.get('p90_m'))}"), mosaic
    return told


def chain(located_file, photos_folder, folder, made):
    """The same by chained homographies."""
    if not located_file.exists():
        return lambda: ("none: no photo has a position | - | - | - | - | -", None)
    photos, placed = chain_homographies.make(photos_folder, located_file, folder)
    if not placed:
        return lambda: ("none: no two photos match | - | - | - | - | -", None)

    def told():
        origin = json.loads(located_file.read_text())["origin"]
        absolute_m, relative_m = truth_error(folder / "mosaic.tif", origin, shown_by_chain(photos, placed), made)
        agreeing = [photo for photo in photos if photo.name in placed and photo.agreeing]
        residual_px = numpy.sqrt(sum(photo.square_px for photo in agreeing) / max(1, sum(photo.agreeing for photo in agreeing)))
        return (f"{len(placed)} of {len(photos)} | {len(placed)} "
                f"| {len({photo.component for photo in photos if photo.name in placed})} "
                f"| {number(absolute_m)} / {number(relative_m)} | {number(residual_px, 2)} | - / -"), folder / "mosaic.tif"
    return told


def run(program, method, photos, out, made):
    """A row of the table, and the map where there is one."""
    used_s, start = cpu_s(), time.monotonic()
    if method == "features":  # the recorded positions as the first method took them
        told = chain(out / "imu" / "locate.json", photos, out / method, made)
    else:
        told = stitch(program, method, photos, out / method, made)
    cost = f"{time.monotonic() - start:.1f} | {cpu_s() - used_s:.1f} |"
    row, mosaic = told()
    return f"| {method} | {row} | {cost}\n", mosaic


def panels(file, method):
    """The whole map and its middle at full size, with the method's name over each."""
    mosaic = gdal.Open(str(file))
    width, height = mosaic.RasterXSize, mosaic.RasterYSize
    scale = PANEL_PX / max(width, height)
    size = (max(1, round(width * scale)), max(1, round(height * scale)))
    left, top = max(0, (width - PANEL_PX) // 2), max(0, (height - PANEL_PX) // 2)
    views = [mosaic.ReadAsArray(buf_xsize=size[0], buf_ysize=size[1], resample_alg=gdal.GRIORA_Average),
             mosaic.ReadAsArray(left, top, min(PANEL_PX, width), min(PANEL_PX, height))]
    drawn = []
    for view, name in zip(views, (method, f"{method}: the middle")):
        panel = numpy.full((PANEL_PX + 24, PANEL_PX, 3), 255, numpy.uint8)
        picture = numpy.moveaxis(view[:3][::-1], 0, 2)
        panel[24:24 + picture.shape[0], :picture.shape[1]] = picture
        drawn.append(cv2.putText(panel, name, (4, 17), cv2.FONT_HERSHEY_SIMPLEX, 0.5, (0, 0, 0), 1, cv2.LINE_AA))
    return numpy.vstack(drawn)


def compare(program, photos, made, out):
    """The table of one flight by every method, and their maps beside each other."""
    table, columns = HEAD, []
    for method in METHODS:
        row, mosaic = run(program, method, photos, out, made)
        table += row
        columns.append(panels(mosaic, method) if mosaic else numpy.full((2 * (PANEL_PX + 24), PANEL_PX, 3), 255, numpy.uint8))
    return table, numpy.hstack(columns)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path, help="the skyquilt binary")
    parser.add_argument("--flight", type=pathlib.Path, help="a folder of photos, or one that the simulator made")
    parser.add_argument("-o", "--out", type=pathlib.Path)
    arguments = parser.parse_args()
    if arguments.flight and not arguments.out:
        parser.error("--flight needs --out, where the maps of the methods go")
    arguments.out = arguments.out or pathlib.Path(__file__).parent
    arguments.out.mkdir(parents=True, exist_ok=True)
    if arguments.flight:
        photos = arguments.flight / "photos" if (arguments.flight / "photos").is_dir() else arguments.flight
        table, picture = compare(arguments.program, photos, arguments.flight, arguments.out)
        cv2.imwrite(str(arguments.out / "compare.png"), picture)
        print(table)
        return
    text = INTRODUCTION.format(machine=f"{os.cpu_count()} cores, {platform.machine()}")
    pictures = []
    with tempfile.TemporaryDirectory(prefix="skyquilt_paper_") as scratch:
        for index, (title, scene) in enumerate(SCENES):
            flight = pathlib.Path(scratch, f"flight{index}")
            subprocess.run([arguments.program, "simulate", "-o", flight, *COMMON, *scene], check=True, capture_output=True)
            table, picture = compare(arguments.program, flight / "photos", flight, pathlib.Path(scratch, f"compared{index}"))
            text += f"\n## {title}\n\n`simulate {' '.join(COMMON + scene)}`\n\n{table}"
            print(title, table, sep="\n", flush=True)
            pictures.append(picture)
    sheet = numpy.vstack(pictures)
    half = cv2.resize(sheet, (sheet.shape[1] // 2, sheet.shape[0] // 2), interpolation=cv2.INTER_AREA)
    cv2.imwrite(str(arguments.out / "paper.jpg"), half, [cv2.IMWRITE_JPEG_QUALITY, 80])
    readme = arguments.out / "README.md"
    rest = readme.read_text().partition("\n# ")[2] if readme.exists() else ""  # other comparisons, below the next heading
    readme.write_text(text + (f"\n# {rest}" if rest else ""))


if __name__ == "__main__":
    main()
