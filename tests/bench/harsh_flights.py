"""Flights as they come in bad days: simulated ones, with their photos and records spoilt afterwards the way real
ones are. Used by map_accuracy.py; needs exiftool for the spoiling.

A flight is a list of recordings (options of `skyquilt simulate` each; they become one folder) and what spoils it.
"""
import json
import math
import pathlib
import random
import shutil
import subprocess
import sys

import cv2
import numpy

TESTS = pathlib.Path(__file__).resolve().parents[1]
sys.path += [str(TESTS / "e2e"), str(TESTS / "e2e" / "command_line")]
import film_test
from flights import made_flights
from map_against_truth import rotation


def exif(photos, *arguments):
    subprocess.run(["exiftool", "-q", "-overwrite_original_in_place", "-P", *arguments, str(photos)], check=True)


def truth_of(folder):
    return json.loads((folder / "truth" / "poses.json").read_text())


def keep(folder, is_kept):
    """Leaves only the photos whose truth says so."""
    for number, photo in enumerate(truth_of(folder)["photos"]):
        if not is_kept(number, photo):
            (folder / "photos" / photo["name"]).unlink()


def first_line(folder):
    photos = truth_of(folder)["photos"]
    east = photos[0]["camera_center_in_enu"][0]
    keep(folder, lambda _, photo: abs(photo["camera_center_in_enu"][0] - east) < 5.0)


def ring(folder):
    centers = numpy.array([photo["camera_center_in_enu"][:2] for photo in truth_of(folder)["photos"]])
    middle = (centers.min(0) + centers.max(0)) / 2
    reach = (centers.max(0) - centers.min(0)).min() / 2
    away = numpy.linalg.norm(centers - middle, axis=1) / reach
    keep(folder, lambda number, _: 0.6 < away[number] < 1.15)


def without_xmp(folder):
    exif(folder / "photos", "-XMP:all=")


def without_altitude(folder):
    without_xmp(folder)
    exif(folder / "photos", "-GPSAltitude=", "-GPSAltitudeRef=")


def at_one_time(folder):
    exif(folder / "photos", "-AllDates=2024:06:01 10:00:00", "-GPSTimeStamp=", "-SubSecTimeOriginal=")


def shuffled(folder):
    """Names in no order, and no times to order by."""
    at_one_time(folder)
    photos = sorted((folder / "photos").iterdir())
    names = [f"IMG_{number:04}.JPG" for number in random.Random(7).sample(range(1, 9999), len(photos))]
    for photo, name in zip(photos, names):
        photo.rename(photo.with_name(name))


def wrong_focal(folder):
    """Five per cent, by the maker's own tags; nothing says that it was calibrated."""
    focal = truth_of(folder)["intrinsics"]["focal_x_px"] * 1.05
    width = truth_of(folder)["intrinsics"]["width_px"]
    exif(folder / "photos", "-XMP:CalibratedFocalLength=", "-XMP:CalibratedOpticalCenterX=",
         "-XMP:CalibratedOpticalCenterY=", f"-FocalLengthIn35mmFormat={round(36 * focal / width)}",
         f"-FocalLength={36 * focal / width / 9:.3f}")


def stored_upright(folder):
    """As cameras store portrait photos: turned pixels, an Orientation that says so, recorded angles as before."""
    for photo in (folder / "photos").iterdir():
        picture = cv2.imread(str(photo), cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION)
        turned = photo.with_suffix(".turned.jpg")
        cv2.imwrite(str(turned), cv2.rotate(picture, cv2.ROTATE_90_COUNTERCLOCKWISE), [cv2.IMWRITE_JPEG_QUALITY, 95])
        subprocess.run(["exiftool", "-q", "-overwrite_original", "-TagsFromFile", str(photo), "-all:all", "-unsafe",
                        "-n", "-Orientation=6", str(turned)], check=True)
        turned.rename(photo)


def noisy_gnss(folder):
    """Five metres more, each photo for itself."""
    chance = random.Random(11)
    for photo in sorted((folder / "photos").iterdir()):
        move(photo, chance.gauss(0, 5.0), chance.gauss(0, 5.0))


def low_heights(folder):
    """Recorded heights above take-off are two fifths of the true ones, as of a barometer that is wrong."""
    truth = truth_of(folder)
    for photo in truth["photos"]:
        height = 0.4 * photo["camera_center_in_enu"][2]
        exif(folder / "photos" / photo["name"], "-n", f"-XMP:RelativeAltitude={height:+.2f}",
             f"-XMP:AbsoluteAltitude={truth['origin'].get('height_ellipsoid_m', 500.0) + height:+.2f}",
             f"-EXIF:GPSAltitude={truth['origin'].get('height_ellipsoid_m', 500.0) + height:.2f}")


def without_focal(folder):
    exif(folder / "photos", "-XMP:CalibratedFocalLength=", "-XMP:CalibratedOpticalCenterX=", "-XMP:CalibratedOpticalCenterY=",
         "-FocalLengthIn35mmFormat=", "-FocalLength=", "-Make=", "-Model=")


def without_positions(folder):
    """What a camera on a kite records: the time, the focal length, nothing of where."""
    exif(folder / "photos", "-XMP:all=", "-GPS:all=")


def control_alone(folder):
    """No position, but six surveyed points on the ground, marked in every photo that sees them."""
    truth = truth_of(folder)
    centers = numpy.array([photo["camera_center_in_enu"][:2] for photo in truth["photos"]])
    south_west, north_east = centers.min(0), centers.max(0)
    shares = [(0.1, 0.1), (0.9, 0.15), (0.5, 0.5), (0.15, 0.9), (0.9, 0.85), (0.5, 0.05)]
    marked = made_flights.gcp_list(truth, [tuple(south_west + (north_east - south_west) * share) for share in shares])
    without_positions(folder)
    (folder / "photos" / "gcp_list.txt").write_text(marked)


def film(folder):
    """The frames of a film and the subtitles beside it; no photo. The film is the camera's, by a lossy codec."""
    photos = truth_of(folder)["photos"]
    first = cv2.imread(str(folder / "photos" / photos[0]["name"]))
    writer = cv2.VideoWriter(str(folder / "photos" / "DJI_0001.MP4"), cv2.VideoWriter_fourcc(*"mp4v"),
                             film_test.FRAMES_PER_S, first.shape[1::-1])
    for photo in photos:
        path = folder / "photos" / photo["name"]
        writer.write(cv2.imread(str(path)))
        path.unlink()
    writer.release()
    (folder / "photos" / "DJI_0001.SRT").write_text(
        "".join(film_test.subtitle(number, photo) for number, photo in enumerate(photos)))


def without_records(folder):
    exif(folder / "photos", "-all=")


def heights_in_feet(folder):
    for photo in truth_of(folder)["photos"]:
        exif(folder / "photos" / photo["name"], "-n", f"-XMP:RelativeAltitude={photo['camera_center_in_enu'][2] / 0.3048:+.2f}")


def late_positions(folder):
    """Every photo carries the position of the one before it."""
    tags = ("GPSLatitude", "GPSLongitude")
    photos = sorted((folder / "photos").iterdir())
    read = json.loads(subprocess.run(["exiftool", "-j", "-n", *(f"-EXIF:{tag}" for tag in tags), *map(str, photos)],
                                     check=True, capture_output=True, text=True).stdout)
    for before, photo in zip(read, photos[1:]):
        set_position(photo, before["GPSLatitude"], before["GPSLongitude"])


def yaw_of_the_mount(folder):
    """The camera is mounted a quarter turn from what the aircraft believes."""
    photos = sorted((folder / "photos").iterdir())
    read = json.loads(subprocess.run(["exiftool", "-j", "-n", "-XMP:GimbalYawDegree", *map(str, photos)],
                                     check=True, capture_output=True, text=True).stdout)
    for tags, photo in zip(read, photos):
        exif(photo, "-n", f"-XMP:GimbalYawDegree={(float(tags['GimbalYawDegree']) + 270) % 360 - 180:+.1f}")


def second_take_off(folder):
    """The other half was flown from a place 15 m lower: its heights count from there."""
    photos = sorted((folder / "photos").iterdir())
    for photo in photos[len(photos) // 2:]:
        exif(photo, "-n", "-XMP:RelativeAltitude=" + f"{height_of(folder, photo) + 15:+.2f}")


def height_of(folder, photo):
    return next(one["camera_center_in_enu"][2] for one in truth_of(folder)["photos"] if one["name"] == photo.name)


def climbing(folder):
    """Of the flights at other heights only the photo that is nearest to the first one of the survey."""
    without_altitude(folder)
    photos = sorted((folder / "photos").iterdir())
    read = json.loads(subprocess.run(["exiftool", "-j", "-n", "-GPSLatitude", "-GPSLongitude", *map(str, photos)],
                                     check=True, capture_output=True, text=True).stdout)
    at = {photo: numpy.array([tags["GPSLatitude"], tags["GPSLongitude"] * math.cos(math.radians(tags["GPSLatitude"]))])
          for tags, photo in zip(read, photos)}
    first = next(photo for photo in photos if photo.name.startswith("SIM"))
    for part in "BCDEF":
        of_part = sorted((photo for photo in photos if photo.name.startswith(part)),
                         key=lambda photo: numpy.linalg.norm(at[photo] - at[first]))
        for photo in of_part[1:]:
            photo.unlink()


def wrong_positions(folder):
    """Three photos of ten were recorded 50 m from where they were taken."""
    chance = random.Random(13)
    for photo in sorted((folder / "photos").iterdir()):
        if chance.random() >= 0.3:
            continue
        turn = chance.uniform(0, 2 * math.pi)
        move(photo, 50 * math.sin(turn), 50 * math.cos(turn))


def with_foreign(folder):
    """Three photos of another place, with the records of photos beside which they lie."""
    names = sorted(photo.name for photo in (folder / "photos").iterdir())
    for number, name in enumerate(names[2::7][:3]):
        picture = folder / "photos" / f"Z{number}_foreign.JPG"
        chance = numpy.random.default_rng(100 + number)
        spots = cv2.resize(chance.normal(128, 60, (90, 120, 3)).clip(0, 255).astype(numpy.uint8), (1600, 1200),
                           interpolation=cv2.INTER_CUBIC)
        cv2.imwrite(str(picture), spots, [cv2.IMWRITE_JPEG_QUALITY, 92])
        subprocess.run(["exiftool", "-q", "-overwrite_original", "-TagsFromFile", str(folder / "photos" / name), "-all:all",
                        "-unsafe", str(picture)], check=True)


def move(photo, east_m, north_m):
    """The recorded position, and nothing else."""
    tags = json.loads(subprocess.run(["exiftool", "-j", "-n", "-GPSLatitude", "-GPSLongitude", str(photo)],
                                     check=True, capture_output=True, text=True).stdout)[0]
    set_position(photo, tags["GPSLatitude"] + north_m / 111_200,
                 tags["GPSLongitude"] + east_m / (111_200 * math.cos(math.radians(tags["GPSLatitude"]))))


def set_position(photo, lat, lon):
    exif(photo, "-n", f"-EXIF:GPSLatitude={lat}", f"-EXIF:GPSLongitude={lon}", f"-XMP:GpsLatitude={lat}",
         f"-XMP:GpsLongitude={lon}")


def over_water(folder):
    """The west of the place is a lake: nothing to match there, and never the same twice."""
    truth = truth_of(folder)
    lens = truth["intrinsics"]
    centers = numpy.array([photo["camera_center_in_enu"] for photo in truth["photos"]])
    shore = numpy.quantile(centers[:, 0], 0.36)
    columns, rows = numpy.meshgrid(numpy.arange(lens["width_px"]), numpy.arange(lens["height_px"]))
    rays = numpy.stack([(columns - lens["center_x_px"]) / lens["focal_x_px"],
                        (rows - lens["center_y_px"]) / lens["focal_y_px"], numpy.ones_like(columns)], -1)
    for number, photo in enumerate(truth["photos"]):
        chance = numpy.random.default_rng(number)
        ground = east_of(photo, rays)
        picture = cv2.imread(str(folder / "photos" / photo["name"]))
        waves = cv2.GaussianBlur(chance.normal(0, 30, picture.shape[:2]).astype(numpy.float32), None, 6)
        water = numpy.array([90, 70, 40]) + waves[..., None] + chance.normal(0, 1, picture.shape)
        shown = numpy.where((ground < shore)[..., None], water.clip(0, 255), picture).astype(numpy.uint8)
        path = folder / "photos" / photo["name"]
        wet = path.with_suffix(".wet.jpg")
        cv2.imwrite(str(wet), shown, [cv2.IMWRITE_JPEG_QUALITY, 92])
        subprocess.run(["exiftool", "-q", "-overwrite_original", "-TagsFromFile", str(path), "-all:all", "-unsafe",
                        str(wet)], check=True)
        wet.rename(path)


def east_of(photo, rays):
    """Where rays of a photo meet level ground, in metres east of the origin."""
    center = photo["camera_center_in_enu"]
    in_enu = rays @ rotation(photo["cam_from_enu_wxyz"])  # enu_from_cam is the transpose
    return center[0] - center[2] * in_enu[..., 0] / in_enu[..., 2]


def nothing(_):
    pass


XMP = ["--noise", "xmp"]
# name: (recordings, how they are spoilt)
HARSH = {
    "high": ([[*XMP, "--height", "120"]], nothing),
    "overlap_50_30": ([[*XMP, "--overlap", "0.5", "--sidelap", "0.3"]], nothing),
    "cross_hatch": ([XMP, [*XMP, "--heading", "90"]], nothing),
    "single_line": ([[*XMP, "--sidelap", "0.5"]], first_line),
    "ring": ([[*XMP, "--yaw", "any"]], ring),
    "steep_relief": ([[*XMP, "--relief-m", "20"]], nothing),
    "water": ([XMP], over_water),
    "wrong_focal": ([XMP], wrong_focal),
    "no_xmp": ([XMP], without_xmp),
    "no_altitude": ([XMP], without_altitude),
    "oblique_30": ([[*XMP, "--tilt-deg", "30"]], nothing),
    "portrait": ([XMP], stored_upright),
    "two_cameras": ([XMP, [*XMP, "--size", "1200x900", "--focal-px", "1300", "--height", "45"]], nothing),
    "one_time": ([XMP], at_one_time),
    "shuffled": ([XMP], shuffled),
    "gnss_5_m": ([XMP], noisy_gnss),
    "gnss_5_m_bare": ([[*XMP, "--texture", "bare"]], noisy_gnss),
    "low_heights": ([XMP], low_heights),
    "no_focal": ([XMP], without_focal),
    "wrong_positions": ([XMP], wrong_positions),
    "foreign": ([XMP], with_foreign),
    "climb": ([[*XMP, "--height", "100"], *([*XMP, "--height", height] for height in ("20", "30", "45", "67"))], climbing),
    "no_positions": ([XMP], without_positions),
    "no_positions_windy": ([[*XMP, "--tilt-deg", "12", "--yaw", "any"]], without_positions),
    "control_alone": ([XMP], control_alone),
    "no_records": ([XMP], without_records),
    # Three frames for one of the other flights' photos: a film's are close together.
    "film": ([[*XMP, "--size", "1280x720", "--overlap", "0.93"]], film),
    "feet": ([XMP], heights_in_feet),
    "late_positions": ([XMP], late_positions),
    "turned_mount": ([XMP], yaw_of_the_mount),
    "second_take_off": ([XMP], second_take_off),
    "two_flights": ([XMP, [*XMP, "--heading", "40", "--height", "50"]], nothing),
    "no_xmp_windy": ([[*XMP, "--tilt-deg", "8", "--yaw-wander-deg", "8", "--height-wander-m", "4"]], without_xmp),
}


def make(name, program, folder, photos, seed):
    """Simulates and spoils the flight `name` into `folder`/photos, with the truth beside it."""
    recordings, spoil = HARSH[name]
    for number, options in enumerate(recordings):
        part = folder if number == 0 else folder.with_name(f"{folder.name}_part{number}")
        subprocess.run([program, "simulate", "-o", part, "--photos", str(photos), "--seed", str(seed), *options],
                       check=True, capture_output=True)
        if number > 0:
            for photo in (part / "photos").iterdir():
                photo.rename(folder / "photos" / f"{chr(ord('A') + number)}{photo.name}")
            shutil.rmtree(part)
    spoil(pathlib.Path(folder))
