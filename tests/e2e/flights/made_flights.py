"""Flights and maps that several tests want and none is about: made by the program once, then only read or copied.

They lie in SKYQUILT_MADE_FLIGHTS (of the build, where the test e2e.made_flights makes them before the others), by hand in the
system's temporary folder, and are made where they are not there yet. Another build of the program makes them anew."""
import fcntl
import os
import pathlib
import shutil
import subprocess
import tempfile

BINARY = pathlib.Path(os.environ.get("SKYQUILT_BINARY", "build/release/bin/skyquilt"))
ROOT = pathlib.Path(os.environ.get("SKYQUILT_MADE_FLIGHTS", pathlib.Path(tempfile.gettempdir(), f"skyquilt_made_flights_{os.getuid()}")))


def made(name, make):
    """The folder of this name, which make(folder) filled for whoever asked first. Nobody writes into it."""
    program = BINARY.stat()
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


def run(*words):
    done = subprocess.run([BINARY, *words], capture_output=True, text=True)
    assert done.returncode == 0, (words, done.stderr)


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
    program = BINARY.stat()
    for folder in ROOT.glob("*"):
        if folder.name != f"{program.st_size}_{program.st_mtime_ns}":
            shutil.rmtree(folder, ignore_errors=True)
