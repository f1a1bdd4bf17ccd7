"""The same photos by Skyquilt and by others, one after the other on the same machine: OpenCV's Stitcher in its mode
for scans, and COLMAP (features, matching of all pairs, mapper; by default but for the number of features, COLMAP_FEATURES a photo: its
default of 8,192 takes the processor sixteen times as long to match). A peer that is not installed is
passed over with a word.

    python3 tests/bench/alignment/peers.py PROGRAM FLIGHT... [--scans BUILD/bin/stitch_scans] [--only NAME]

FLIGHT is a folder of photos, or one that `skyquilt simulate` made: of that the truth is known, and the error is CE90
of the cameras' horizontal places after the best similarity (for the Stitcher, which has none, of the photos' middles:
simulate without tilt). Processor time and peak memory are the whole process's with its children. "align" of Skyquilt
is what it takes until the photos lie; the Stitcher's and COLMAP's figures are for that alone: they make no map here.
Needs numpy and cv2.
"""
import argparse
import json
import os
import pathlib
import shutil
import subprocess
import tempfile
import time

import cv2
import numpy


COLMAP_FEATURES = 2048


class Failed(Exception):
    pass


def run(*command):
    """(output, wall seconds, processor seconds, peak MiB)."""
    started = time.monotonic()
    with tempfile.TemporaryFile() as output:
        process = subprocess.Popen([str(word) for word in command], stdout=output, stderr=subprocess.STDOUT,
                                   env={**os.environ, "QT_QPA_PLATFORM": "offscreen"})
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        output.seek(0)
        text = output.read().decode(errors="replace")
    if process.returncode != 0:
        raise Failed((text.strip().splitlines() or ["it died without a word"])[-1])
    return text, time.monotonic() - started, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def rotation(w, x, y, z):
    return numpy.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


def center(quaternion, translation):
    return -rotation(*quaternion).T @ numpy.array(translation)


def skyquilt(program, photos, scratch, _):
    out = scratch / "skyquilt"
    _, wall_s, cpu_s, peak_mib = run(program, "stitch", photos, "-o", out)
    report = json.loads((out / "report.json").read_text())
    located = json.loads((out / "locate.json").read_text())
    places = {camera["name"]: center(camera["rotation_wxyz"], camera["translation_m"]) for camera in located["cameras"]}
    until = [timing for timing in report["timings"] if timing["stage"] in ("read", "check", "pose", "align", "ground")]
    whole = ("with the whole map", wall_s, cpu_s, peak_mib, {})
    return [("skyquilt, align", sum(t["wall_s"] for t in until), sum(t["cpu_s"] for t in until), None, places), whole]


def opencv_scans(_, photos, __, scans):
    if scans is None or not scans.exists():
        raise Failed("not built (--scans BUILD/bin/stitch_scans, preset bench, where OpenCV has its stitching module)")
    text, *cost = run(scans, photos)
    rows = [line.split() for line in text.splitlines()]
    return [("OpenCV SCANS", *cost, {row[0]: numpy.array([float(row[1]), -float(row[2])]) for row in rows if len(row) == 3})]


def colmap(_, photos, scratch, __):
    if shutil.which("colmap") is None:
        raise Failed("not installed (apt-get install colmap)")
    folder = scratch / "colmap"
    (folder / "sparse").mkdir(parents=True)
    database = ("--database_path", folder / "database.db")
    # Pictures of one size are of one camera: a folder each, as COLMAP wants it said.
    images = folder / "images"
    for photo in photos.iterdir():
        size = "x".join(map(str, cv2.imread(str(photo), cv2.IMREAD_REDUCED_GRAYSCALE_8).shape))
        (images / size).mkdir(parents=True, exist_ok=True)
        (images / size / photo.name).symlink_to(photo.resolve())
    costs = [run("colmap", "feature_extractor", *database, "--image_path", images, "--ImageReader.single_camera_per_folder", 1,
                 "--ImageReader.camera_model", "SIMPLE_RADIAL", "--SiftExtraction.use_gpu", 0,
                 "--SiftExtraction.max_num_features", COLMAP_FEATURES),
             run("colmap", "exhaustive_matcher", *database, "--SiftMatching.use_gpu", 0),
             run("colmap", "mapper", *database, "--image_path", images, "--output_path", folder / "sparse")]
    largest = {}
    for model in sorted((folder / "sparse").iterdir()):
        run("colmap", "model_converter", "--input_path", model, "--output_path", model, "--output_type", "TXT")
        lines = [line.split() for line in (model / "images.txt").read_text().splitlines() if not line.startswith("#")]
        numbers = [(row[9], [float(word) for word in row[1:8]]) for row in lines[::2]]
        places = {pathlib.Path(name).name: center(pose[:4], pose[4:]) for name, pose in numbers}
        largest = max(largest, places, key=len)
    return [("COLMAP", sum(c[1] for c in costs), sum(c[2] for c in costs), max(c[3] for c in costs), largest)]


def ce90_m(places, truth):
    """Horizontal, after the best similarity (Umeyama 1991) in as many dimensions as the places have."""
    names = sorted(set(places) & set(truth))
    ours = numpy.array([places[name] for name in names])
    true = numpy.array([truth[name][:ours.shape[1]] for name in names])
    ours, true = ours - ours.mean(0), true - true.mean(0)
    left, stretch, right = numpy.linalg.svd(true.T @ ours)
    sign = numpy.ones(len(stretch))
    sign[-1] = numpy.sign(numpy.linalg.det(left @ right))
    scale = (stretch * sign).sum() / (ours ** 2).sum()
    off = true - scale * ours @ (left @ numpy.diag(sign) @ right).T
    return numpy.percentile(numpy.linalg.norm(off[:, :2], axis=1), 90)


def main():
    peers = {"skyquilt": skyquilt, "scans": opencv_scans, "colmap": colmap}
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("flight", nargs="+", type=pathlib.Path)
    parser.add_argument("--scans", type=pathlib.Path)
    parser.add_argument("--only", action="append", choices=peers)
    options = parser.parse_args()
    print(f"{'flight':20}{'by':20}{'placed':>9}{'wall s':>9}{'CPU s':>9}{'peak MiB':>10}{'CE90 m':>9}{'in GSD':>8}", flush=True)
    for flight in options.flight:
        photos = flight / "photos" if (flight / "photos").is_dir() else flight
        truth = {}
        gsd_m = None
        if (flight / "truth" / "poses.json").exists():
            known = json.loads((flight / "truth" / "poses.json").read_text())
            truth = {photo["name"]: numpy.array(photo["camera_center_in_enu"]) for photo in known["photos"]}
            gsd_m = known["gsd_m"]
        total = sum(1 for _ in photos.iterdir())
        for name in options.only or peers:
            with tempfile.TemporaryDirectory(prefix="skyquilt_peers_") as scratch:
                try:
                    rows = peers[name](options.program, photos, pathlib.Path(scratch), options.scans)
                except Failed as why:
                    print(f"{flight.name[:19]:20}{name:20}  {why}", flush=True)
                    continue
            for by, wall_s, cpu_s, peak_mib, places in rows:
                error = ce90_m(places, truth) if truth and len(places) > 2 else None
                print(f"{flight.name[:19]:20}{by:20}{f'{len(places)}/{total}' if places else '':>9}{wall_s:9.1f}{cpu_s:9.1f}"
                      f"{'' if peak_mib is None else f'{peak_mib:.0f}':>10}"
                      f"{'' if error is None else f'{error:.3f}':>9}{'' if error is None else f'{error / gsd_m:.2f}':>8}", flush=True)


if __name__ == "__main__":
    main()
