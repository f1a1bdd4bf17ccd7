"""The whole job, photos to finished products, beside its floor: python3 tests/bench/whole_job.py PROGRAM FOLDER_OF_PHOTOS
[--runs N] [--threads N] [--peers]. Medians of the runs; per stage wall seconds and their share; processor time against one
full decode of all photos in the same run (by cv::imdecode where python3-opencv is installed); peak memory. With --peers whichever of gdal2tiles, GDAL's COG driver,
OpenCV's Stitcher and Hugin's command line is installed, on the same photos."""
import argparse
import ctypes
import ctypes.util
import json
import os
import pathlib
import platform
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

BAR_WALL_S, BAR_CPU_RATIO, BAR_PEAK_GIB = 8.0, 8.0, 1.0


def timed(command, cwd=None):
    """Wall seconds, processor seconds and peak bytes of one command, its children included."""
    start = time.monotonic()
    child = subprocess.Popen([str(word) for word in command], cwd=cwd, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode != 0:
        raise RuntimeError(f"{pathlib.Path(str(command[0])).name} ended with {child.returncode}")
    return time.monotonic() - start, usage.ru_utime + usage.ru_stime, usage.ru_maxrss * 1024


def decode_floor(photos):
    """Processor seconds to decode every photo once at full size into the same memory, by libjpeg-turbo in one thread."""
    jpeg = ctypes.CDLL(ctypes.util.find_library("turbojpeg"))
    jpeg.tjInitDecompress.restype = ctypes.c_void_p
    handle = ctypes.c_void_p(jpeg.tjInitDecompress())
    width, height, sampling, space = (ctypes.c_int() for _ in range(4))
    pixels, total = None, 0.0
    for photo in photos:
        data = photo.read_bytes()
        size = ctypes.c_ulong(len(data))
        if jpeg.tjDecompressHeader3(handle, data, size, *(ctypes.byref(v) for v in (width, height, sampling, space))) != 0:
            continue
        needed = width.value * height.value * 3
        if pixels is None or len(pixels) < needed:
            pixels = ctypes.create_string_buffer(needed)
        before = resource.getrusage(resource.RUSAGE_SELF)
        jpeg.tjDecompress2(handle, data, size, pixels, width, 0, height, 0, 0)
        after = resource.getrusage(resource.RUSAGE_SELF)
        total += after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    jpeg.tjDestroy(handle)
    return total


OPENCV_DECODE = """import sys, time, cv2, numpy
cv2.setNumThreads(1)
files = [numpy.fromfile(name, numpy.uint8) for name in sys.argv[1:]]
before = time.process_time()
for data in files: cv2.imdecode(data, cv2.IMREAD_COLOR)
print(time.process_time() - before)"""


def opencv_decode(photos):
    """Processor seconds to decode every photo once at full size as a program that uses OpenCV does, or nothing."""
    python = python_with_opencv()
    if not python:
        return None
    return float(subprocess.run([python, "-c", OPENCV_DECODE, *photos], check=True, capture_output=True, text=True).stdout)


def run_once(program, photos, threads):
    with tempfile.TemporaryDirectory() as out:
        wall_s, cpu_s, peak = timed([program, "stitch", photos, "-o", out, "--threads", threads])
        report = json.loads(pathlib.Path(out, "report.json").read_text())
        sizes = {path.name: path.stat().st_size for path in pathlib.Path(out).iterdir()}
    return {"wall_s": wall_s, "cpu_s": cpu_s, "peak": peak, "report": report, "sizes": sizes}


def hugin(folder, photos):
    def step(*command):
        return timed(command, cwd=folder)
    steps = [step("pto_gen", "-o", "a.pto", *photos), step("cpfind", "--multirow", "-o", "b.pto", "a.pto"),
             step("autooptimiser", "-a", "-l", "-s", "-o", "c.pto", "b.pto"), step("nona", "-m", "TIFF_m", "-o", "n", "c.pto")]
    steps.append(step("enblend", "-o", "map.tif", *sorted(path.name for path in pathlib.Path(folder).glob("n*.tif"))))
    return sum(s[0] for s in steps), sum(s[1] for s in steps), max(s[2] for s in steps)


STITCHER = """import sys, cv2
status, picture = cv2.Stitcher_create(cv2.Stitcher_SCANS).stitch([cv2.imread(name) for name in sys.argv[1:]])
sys.exit(status)"""


def is_there(*command):
    return subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode == 0


def python_with_opencv():
    return next((one for one in (sys.executable, "/usr/bin/python3") if is_there(one, "-c", "import cv2")), None)


def measure_peers(program, photos, files, threads):
    """A line a peer, as soon as it is measured; one that is not installed or fails is named and left out."""
    def add(name, needs, measure):
        missing = [tool for tool in needs if not shutil.which(tool)]
        if missing:
            print(f"{name:<34} left out: {', '.join(missing)} not installed")
            return
        try:
            wall_s, cpu_s, peak = measure()
        except RuntimeError as failure:
            print(f"{name:<34} failed: {failure}", flush=True)
            return
        print(f"{name:<34} wall {wall_s:7.1f} s  cpu {cpu_s:7.1f} s  peak {peak / (1 << 30):5.2f} GiB", flush=True)
    with tempfile.TemporaryDirectory() as out:
        timed([program, "stitch", photos, "-o", out, "--threads", threads, "--formats", "geotiff"])
        zoom = json.loads(pathlib.Path(out, "report.json").read_text())["max_zoom"]
        add("pyramid alone: gdal2tiles", ["gdal2tiles.py"], lambda: timed(
            ["gdal2tiles.py", "-q", "--xyz", f"--processes={os.cpu_count()}", f"{out}/mosaic.tif", f"{out}/tiles"]))
        add("GeoTIFF alone: GDAL's COG driver", ["gdal_translate"], lambda: timed(
            ["gdal_translate", "-q", "-of", "COG", "-co", "COMPRESS=JPEG", "-co", "QUALITY=85", "-co",
             "TILING_SCHEME=GoogleMapsCompatible", "-co", "ADD_ALPHA=NO", "-co", "NUM_THREADS=ALL_CPUS", "-oo",
             f"ZOOM_LEVEL={zoom}", "-oo", "BAND_COUNT=4", f"{out}/mosaic.mbtiles", f"{out}/gdal.tif"]))
    python = python_with_opencv()
    if python:
        add("whole job: OpenCV's Stitcher", [], lambda: timed([python, "-c", STITCHER, *(path.resolve() for path in files)]))
    else:
        print("whole job: OpenCV's Stitcher left out: python3-opencv not installed")
    with tempfile.TemporaryDirectory() as out:
        add("whole job: Hugin", ["pto_gen", "cpfind", "autooptimiser", "nona", "enblend"],
            lambda: hugin(out, [path.resolve() for path in files]))


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("program")
    arguments.add_argument("photos", type=pathlib.Path)
    arguments.add_argument("--runs", type=int, default=3)
    arguments.add_argument("--threads", type=int, default=0)
    arguments.add_argument("--peers", action="store_true")
    asked = arguments.parse_args()
    files = sorted(path for path in asked.photos.iterdir() if path.suffix.lower() in (".jpg", ".jpeg"))
    print(f"{len(files)} photos, {os.cpu_count()} cores, {platform.machine()}, load before {os.getloadavg()[0]:.1f}")
    bare_s = statistics.median(decode_floor(files) for _ in range(asked.runs))
    whole_s = [opencv_decode(files) for _ in range(asked.runs)]
    floor_s = bare_s if None in whole_s else statistics.median(whole_s)
    runs = [run_once(asked.program, asked.photos, asked.threads) for _ in range(asked.runs)]
    wall_s = statistics.median(run["wall_s"] for run in runs)
    cpu_s = statistics.median(run["cpu_s"] for run in runs)
    peak = max(run["peak"] for run in runs)
    stages = [timing["stage"] for timing in runs[0]["report"]["timings"]]
    for i, stage in enumerate(stages):
        stage_s, stage_cpu_s = (statistics.median(run["report"]["timings"][i][of] for run in runs) for of in ("wall_s", "cpu_s"))
        print(f"  {stage:<10} {stage_s:7.2f} s  {100 * stage_s / wall_s:5.1f} %   processor {stage_cpu_s:6.2f} s  {stage_cpu_s / floor_s:5.1f} x decode")
    print(f"  one full decode of all photos: {floor_s:.2f} s of processor time "
          f"{'by libjpeg-turbo' if None in whole_s else 'by cv::imdecode'}; {bare_s:.2f} s by libjpeg-turbo into memory that is there "
          f"(the whole job is {cpu_s / bare_s:.1f} x that)")
    for name, size in sorted(runs[0]["sizes"].items()):
        print(f"  {name:<18} {size / 1e6:8.1f} MB")
    good = True
    for name, value, bar, unit in (("wall", wall_s, BAR_WALL_S, "s"), ("processor over decode", cpu_s / floor_s, BAR_CPU_RATIO, "x"),
                                   ("peak memory", peak / (1 << 30), BAR_PEAK_GIB, "GiB")):
        good &= value <= bar
        print(f"{name:<24} {value:7.2f} {unit:<3} (bar {bar:g}) {'ok' if value <= bar else 'TOO MUCH'}")
    if asked.peers:
        measure_peers(asked.program, asked.photos, files, asked.threads)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
