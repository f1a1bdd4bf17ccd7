"""Section III of Iz and Unel, "Aerial Image Stitching Using IMU Data from a UAV", made anew on simulated flights of
known truth: rough ground from 20 m with large displacements and rotations, and two photos of similar background (crop
rows, gravel), by every method side by side. Writes README.md (tables) and paper.jpg (pictures).

  python3 tests/bench/alignment/paper.py PROGRAM [-o tests/bench/alignment]
"""
import argparse
import os
import pathlib
import platform
import subprocess
import tempfile

import cv2
import numpy

PAIR = ["--photos", "2", "--overlap", "0.3", "--pixel-noise", "8", "--shutter-ms", "8", "--yaw", "any", "--tilt-deg", "5"]
SCENES = [
    ("Rough ground from 20 m, large displacement and rotation",
     ["--photos", "12", "--relief-m", "2", "--yaw", "any", "--tilt-deg", "6", "--jitter-m", "1.5"]),
    ("Two photos of crop rows", ["--texture", "rows", *PAIR]),
    ("Two photos of gravel", ["--texture", "bare", *PAIR]),
]
COMMON = ["--height", "20", "--size", "800x600", "--noise", "xmp", "--seed", "4", "--vignetting", "0.1",
          "--exposure-jitter", "0.05", "--no-world"]
INTRODUCTION = """# The paper's comparison

Section III of Iz and Unel ("Aerial Image Stitching Using IMU Data from a UAV") shows that features tear or mismatch
where the ground is rough, the photos are far apart or all looks alike, and that recorded poses do not. The same
scenes here, simulated, so that the truth is known; positions 1.5 m, tilt 0.6 and yaw 1.5 degrees, focal length 1 %
off. `imu` is the paper's method with its geometry done exactly, `features` its baseline (homographies chained as in
its equations 1 to 3), `direct` shifts whole pictures, `auto` is what `skyquilt stitch` does. Error: nine of ten pixels
lie nearer to their true place; relative, after the best shift, turn and scale of the whole map. The absolute error of
all is that of the recorded positions. A dash: too little to measure.

Made by `python3 tests/bench/alignment/paper.py PROGRAM` on {machine}.

![The maps of each scene by each method: the whole flight above, its middle below](paper.jpg)
"""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path, help="the skyquilt binary")
    parser.add_argument("-o", "--out", type=pathlib.Path, default=pathlib.Path(__file__).parent)
    arguments = parser.parse_args()
    text = INTRODUCTION.format(machine=f"{os.cpu_count()} cores, {platform.machine()}")
    pictures = []
    with tempfile.TemporaryDirectory(prefix="skyquilt_paper_") as scratch:
        for number, (title, scene) in enumerate(SCENES):
            print(title, flush=True)
            flight, compared = pathlib.Path(scratch, f"flight{number}"), pathlib.Path(scratch, f"compared{number}")
            subprocess.run([arguments.program, "simulate", "-o", flight, *COMMON, *scene], check=True, capture_output=True)
            subprocess.run([arguments.program, "compare", flight / "photos", "-o", compared], check=True, capture_output=True)
            table = (compared / "compare.md").read_text()
            text += f"\n## {title}\n\n`simulate {' '.join(COMMON + scene)}`\n\n{table}"
            print(table, flush=True)
            pictures.append(cv2.imread(str(compared / "compare.png")))
    # A method that made no map has no column.
    width = max(picture.shape[1] for picture in pictures)
    pictures = [cv2.copyMakeBorder(picture, 0, 0, 0, width - picture.shape[1], cv2.BORDER_CONSTANT, value=(255, 255, 255))
                for picture in pictures]
    sheet = numpy.vstack(pictures)
    half = cv2.resize(sheet, (sheet.shape[1] // 2, sheet.shape[0] // 2), interpolation=cv2.INTER_AREA)
    cv2.imwrite(str(arguments.out / "paper.jpg"), half, [cv2.IMWRITE_JPEG_QUALITY, 80])
    (arguments.out / "README.md").write_text(text)


if __name__ == "__main__":
    main()
