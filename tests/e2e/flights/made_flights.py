"""Flights and maps that several tests want and none is about: made by the program once, then only read or copied; and surveyed
points on simulated ground.

They lie in SKYQUILT_MADE_FLIGHTS (of the build, where the test e2e.made_flights makes them before the others), by hand in the
system's temporary folder, and are made where they are not there yet. Another build of the program makes them anew."""
import fcntl
import os
import pathlib
import shutil
import tempfile

from program import BINARY, run

ROOT = pathlib.Path(os.environ.get("SKYQUILT_MADE_FLIGHTS", pathlib.Path(tempfile.gettempdir(), f"skyquilt_made_flights_{os.getuid()}")))


def made(name, make):
    """The folder of this name, which make(folder) filled for whoever asked first. Nobody writes into it."""
    program = os.stat(BINARY)
    root = ROOT / f"{program.st_size}_{program.st_mtime_ns}"
    folder = root / name
    if not folder.exists():
        root.mkdir(parents=True, exist_ok=True)
        with open(root / f"{name}.lock", "w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            if not folder.exists():
                unfinished = root / f"{name}.unfinished"
                shutil.rmtree(unfinished, ignore_errors=True)
                unfinished.mkdir()
                make(unfinished)
                unfinished.rename(folder)
    return folder


def simulated(photos, size, *words):
    """A simulated flight, {photos, truth}."""
    name = "_".join(["flight", str(photos), size, *(word.strip("-") for word in words)])
    return made(name, lambda folder: run("simulate", "-o", folder, "--photos", str(photos), "--size", size, "--no-world", *words))


def small_flight():
    """What nearly every test uploads: six photos."""
    return simulated(6, "800x600")


def small_map():
    """What `stitch` makes of it, in the formats that GIS programs read."""
    return made("map", lambda folder: run("stitch", small_flight() / "photos", "-o", folder, "--formats", "geotiff,pmtiles"))


def remove_those_of_other_builds():
    program = os.stat(BINARY)
    for folder in ROOT.glob("*"):
        if folder.name != f"{program.st_size}_{program.st_mtime_ns}":
            shutil.rmtree(folder, ignore_errors=True)


def turned(quaternion, vector):
    """The vector turned by (w, x, y, z)."""
    w, *axis = quaternion
    cross = lambda a, b: [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    twice = [2 * x for x in cross(axis, vector)]
    return [v + w * t + c for v, t, c in zip(vector, twice, cross(axis, twice))]


def metres_a_degree(truth):
    """East and north at the flight, by its own photos."""
    def along(axis, key):
        photos = sorted(truth["photos"], key=lambda photo: photo[key])
        first, last = photos[0], photos[-1]
        return (last["camera_center_in_enu"][axis] - first["camera_center_in_enu"][axis]) / (last[key] - first[key])
    return along(0, "lon_deg"), along(1, "lat_deg")


def gcp_list(truth, places):
    """ODM's format, of places east and north of the flight's middle, marked in every photo that shows them."""
    lens, origin = truth["intrinsics"], truth["origin"]
    a_degree_east, a_degree_north = metres_a_degree(truth)
    rows = ["EPSG:4326"]
    for number, (east, north) in enumerate(places):
        lon, lat = origin["lon_deg"] + east / a_degree_east, origin["lat_deg"] + north / a_degree_north
        for photo in truth["photos"]:
            ray = [a - b for a, b in zip((east, north, 0.0), photo["camera_center_in_enu"])]
            x, y, z = turned(photo["cam_from_enu_wxyz"], ray)
            column = lens["focal_x_px"] * x / z + lens["center_x_px"] + 0.5
            row = lens["focal_y_px"] * y / z + lens["center_y_px"] + 0.5
            if 0 < column < lens["width_px"] and 0 < row < lens["height_px"]:
                rows.append(f"{lon:.10f} {lat:.10f} {origin['height_ellipsoid_m']:.3f} {column:.3f} {row:.3f} {photo['name']} p{number}")
    return "\n".join(rows) + "\n"
