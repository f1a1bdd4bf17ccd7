"""A map that is there already: photos added to it change the tiles below them alone, a killed job goes on where it stopped, and made again
nothing is rendered anew."""
import contextlib
import json
import math
import shutil
import signal
import sqlite3
import subprocess
import time

from program import BINARY, ScratchCase, cameras_of, report_of, run, tiles_of
from server_support import PATIENCE_S

HALO_TILES = 4  # of 256 pixels: as far as a seam evens out the light


def column_row(zoom, lon, lat):
    side = 2 ** zoom
    y = (1 - math.asinh(math.tan(math.radians(lat))) / math.pi) / 2
    return (lon + 180) / 360 * side, side - 1 - y * side


class Append(ScratchCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        run("simulate", "-o", cls.scratch / "sim", "--photos", "20", "--size", "800x600", "--noise", "xmp", "--exposure-jitter", "0.05",
            "--vignetting", "0.1", "--no-world")
        photos = sorted((cls.scratch / "sim" / "photos").iterdir())
        cls.first, cls.more = cls.scratch / "first", cls.scratch / "more"
        cls.first.mkdir()
        cls.more.mkdir()
        cls.new = photos[-1].name
        for photo in photos[:-1]:
            shutil.copy(photo, cls.first)
        shutil.copy(photos[-1], cls.more)
        cls.finished = cls.scratch / "finished"
        cls.stitch(cls.first, cls.finished)

    @classmethod
    def stitch(cls, photos, out, *arguments):
        run("stitch", photos, "-o", out, *arguments)
        return report_of(out)

    def check_figures(self, figures, before):
        """The new photo's stand behind those of the finished flight, which stay."""
        self.assertEqual((figures["photos"], figures["aligned"]), (20, before["aligned"] + 1))
        self.assertEqual(figures["photo_reports"][:-1], before["photo_reports"])
        self.assertEqual(figures["photo_reports"][-1]["name"], self.new)
        pairs = len(before["pairs"])
        self.assertEqual(figures["pairs"][:pairs], before["pairs"])
        self.assertGreater(len(figures["pairs"]), pairs)
        for pair in figures["pairs"][pairs:]:
            self.assertIn(self.new, (pair["first"], pair["second"]))
        self.assertEqual(figures["pieces"], before["pieces"])
        self.assertEqual(figures["pairs_linked"] - before["pairs_linked"], sum(not pair["by_direct"] for pair in figures["pairs"][pairs:]))
        for counted in ("tie_points", "observations"):
            self.assertGreater(figures[counted], before[counted])
        merged = ("photos", "aligned", "photo_reports", "pairs", "pairs_tried", "pairs_linked", "pairs_by_direct", "tie_points", "observations",
                  "residual_rms_px", "corrections")
        self.assertEqual({key: value for key, value in figures.items() if key not in merged},
                         {key: value for key, value in before.items() if key not in merged})

    def test_only_the_tiles_below_the_new_photo_change(self):
        out = self.scratch / "grown"
        shutil.copytree(self.finished, out)
        before = tiles_of(out)
        report = self.stitch(self.more, out, "--append")
        self.assertEqual(report["photos"]["total"], 20)
        self.assertEqual(report["photos"]["aligned"], 20)
        self.assertGreater(report["blocks"]["kept"], 0)
        self.check_figures(report["alignment"], report_of(self.finished)["alignment"])
        # What was placed stays exactly where it was.
        cameras, old_cameras = cameras_of(out), cameras_of(self.finished)
        self.assertEqual({name: cameras[name] for name in old_cameras}, old_cameras)
        after = tiles_of(out)
        self.assertEqual(set(before) - set(after), set())
        zoom = report["max_zoom"]
        changed = [key for key in after if key[0] == zoom and after[key] != before.get(key)]
        self.assertGreater(len(changed), 0)
        ring = next(photo["geometry"]["coordinates"][0]
                    for photo in json.loads((out / "photos.geojson").read_text())["features"]
                    if photo["properties"]["name"] == self.new)
        corners = [column_row(zoom, lon, lat) for lon, lat in ring]
        for _, column, row in changed:
            self.assertGreaterEqual(column, min(x for x, _ in corners) - 1 - HALO_TILES)
            self.assertLessEqual(column, max(x for x, _ in corners) + HALO_TILES)
            self.assertGreaterEqual(row, min(y for _, y in corners) - 1 - HALO_TILES)
            self.assertLessEqual(row, max(y for _, y in corners) + HALO_TILES)
        # Nothing is left of the finished map's tiles that a run from the new state would not make.
        told = run("stitch", self.more, "-o", out, "--append").stdout
        self.assertIn("1 file in the map already", told)
        again = report_of(out)
        self.assertEqual(again["blocks"]["kept"], again["blocks"]["total"])
        self.assertEqual(tiles_of(out), after)

    def test_a_card_that_was_emptied_since_does_not_take_the_maps_place(self):
        card, out = self.scratch / "card", self.scratch / "of_card"
        shutil.copytree(self.first, card)
        self.stitch(card, out, "--method", "imu")
        before = tiles_of(out)
        first = min(card.iterdir())
        shutil.copy(self.more / self.new, first)  # as numbers that begin anew
        for photos in (card, self.more):
            done = run("stitch", photos, "-o", out, "--append", code=1)
            self.assertIn(f"1 photo of the map there is another file now (first {first.name})", done.stderr)
            self.assertNotIn("in the map already", done.stdout)
        self.assertEqual(tiles_of(out), before)

    def test_it_is_added_to_from_any_folder(self):
        flights = self.scratch / "flights"
        (flights / "elsewhere").mkdir(parents=True)
        shutil.copytree(self.first, flights / "photos")
        run("stitch", "photos", "-o", "map", "--method", "imu", cwd=flights)
        run("stitch", self.more, "-o", "../map", "--append", cwd=flights / "elsewhere")
        self.assertEqual(report_of(flights / "map")["photos"]["total"], 20)

    def test_a_map_with_png_at_its_edge_becomes_the_same_as_one_made_anew(self):
        out = self.scratch / "png"
        self.stitch(self.first, out, "--format", "jpeg-png")
        before = tiles_of(out)
        self.assertEqual({tile[:4] for tile in before.values()}, {b"\xff\xd8\xff\xe0", b"\x89PNG"})
        report = self.stitch(self.first, out, "--overwrite")
        self.assertEqual(report["blocks"]["kept"], report["blocks"]["total"])
        self.assertEqual(tiles_of(out), tiles_of(self.finished))
        again = self.stitch(self.first, out)
        self.assertEqual(again["blocks"]["kept"], again["blocks"]["total"])
        # Who wants PNG again has it rendered: what WebP lost is gone.
        self.assertEqual(self.stitch(self.first, out, "--format", "jpeg-png", "--overwrite")["blocks"]["kept"], 0)
        self.assertEqual(tiles_of(out), before)

    def test_the_new_photo_lies_where_a_whole_alignment_puts_it(self):
        out, whole = self.scratch / "placed", self.scratch / "whole"
        shutil.copytree(self.finished, out)
        self.stitch(self.more, out, "--append")
        self.stitch(self.scratch / "sim" / "photos", whole)
        places = []
        for folder in (out, whole):
            text = run("locate", folder, "--photo", self.new, "--pixel", "400,300").stdout
            places.append([float(word) for word in text.split()[0].split(",")])
        lon, lat = (abs(a - b) * 111_000 for a, b in zip(*places))
        self.assertLess(math.hypot(lon, lat), 1.0)

    def folder_of(self, name, *photos):
        folder = self.scratch / name
        folder.mkdir()
        for photo, called in photos:
            shutil.copy(photo, folder / called)
        return folder

    def copy_of_map(self, name):
        out = self.scratch / name
        shutil.copytree(self.finished, out)
        return out

    def unplaced(self, name):
        """The new photo, without its position."""
        bare = self.scratch / "bare"
        if not bare.exists():
            run("simulate", "-o", bare, "--photos", "20", "--size", "800x600", "--noise", "no-gps", "--exposure-jitter", "0.05",
                "--vignetting", "0.1", "--no-world")
        return self.folder_of(name, (bare / "photos" / self.new, self.new))

    def place_of(self, photo, folder):
        text = run("locate", folder, "--photo", photo, "--pixel", "400,300").stdout
        return [float(word) for word in text.split()[0].split(",")]

    def halves(self, name):
        """Photos of a map, and as many more, which are too many to be placed against it."""
        photos = [(photo, photo.name) for photo in sorted((self.scratch / "sim" / "photos").iterdir())]
        return self.folder_of(f"first_{name}", *photos[:10]), self.folder_of(f"more_{name}", *photos[10:])

    def test_a_copy_that_is_read_in_place_of_a_photo_of_the_map(self):
        photos = sorted(self.first.iterdir())
        both = self.folder_of("with_copy", *((photo, photo.name) for photo in photos), (photos[0], "A_COPY.JPG"), (self.more / self.new, self.new))
        report = self.stitch(both, self.copy_of_map("copied"))
        self.assertEqual(report["photos"], {**report["photos"], "total": 21, "aligned": 20, "left_out": 1})

    def test_what_is_left_out_is_told_once(self):
        more = self.folder_of("copy_too", (self.first / "SIM_0001.JPG", "Z_COPY.JPG"), (self.more / self.new, self.new))
        report = self.stitch(more, self.copy_of_map("copied_later"), "--append")
        self.assertEqual([photo["name"] for photo in report["left_out_photos"]], ["Z_COPY.JPG"])
        self.assertEqual(report["photos"]["total"], 21)

    def test_a_photo_without_a_position_is_found_by_what_it_shows(self):
        out = self.copy_of_map("with_unplaced")
        report = self.stitch(self.unplaced("unplaced"), out, "--append")
        self.assertEqual(report["photos"]["aligned"], 20)
        self.assertIn("1 of 20 photos carry no usable position.", report["warnings"])
        # Against the finished photos, which stay where they are.
        self.assertTrue([line for line in report["warnings"] if line.startswith("1 photo was added")])
        cameras, old_cameras = cameras_of(out), cameras_of(self.finished)
        self.assertEqual({name: cameras[name] for name in old_cameras}, old_cameras)

    def test_a_photo_that_was_left_out_comes_in_with_those_beside_it(self):
        far = self.scratch / "far"  # 670 m, and another hour
        run("simulate", "-o", far, "--photos", "6", "--lat", "46.806", "--size", "800x600", "--noise", "xmp", "--seed", "7",
            "--clock-offset-s", "3600", "--no-world")
        photos = [(photo, f"FAR_{photo.name}") for photo in sorted((far / "photos").iterdir())]
        alone, beside = photos[-1], photos[:-1]
        out = self.scratch / "with_far"
        report = self.stitch(self.folder_of("one_far", *((photo, photo.name) for photo in sorted(self.first.iterdir())), alone), out)
        self.assertEqual([photo["name"] for photo in report["left_out_photos"]], [alone[1]])
        report = self.stitch(self.folder_of("beside_far", *beside), out, "--append")
        self.assertEqual(report["photos"], {"total": 25, "aligned": 25, "pose_only": 0, "left_out": 0})
        self.assertEqual(len({photo["name"] for photo in report["alignment"]["photo_reports"]}), report["alignment"]["photos"])

    def test_photos_go_where_the_map_was_brought(self):
        out, stays = self.copy_of_map("brought"), self.copy_of_map("stays")
        run("place", out, "--again", "--point", "46.8,7.1=46.803,7.1")  # 330 m
        self.stitch(self.more, out, "--append")
        self.stitch(self.more, stays, "--append")
        (lon, lat), (lon_was, lat_was) = self.place_of(self.new, out), self.place_of(self.new, stays)
        self.assertAlmostEqual(lat - lat_was, 0.003, delta=1e-5)
        self.assertAlmostEqual(lon, lon_was, delta=1e-5)

    def test_a_flight_aligned_anew_stays_where_somebody_brought_it(self):
        first, more = self.halves("of_brought")
        out = self.scratch / "brought_anew"
        self.stitch(first, out)
        run("place", out, "--again", "--point", "46.8,7.1=46.803,7.1")  # 330 m
        was = self.place_of("SIM_0001.JPG", out)
        report = self.stitch(more, out, "--append")
        self.assertEqual(report["photos"]["aligned"], 20)
        self.assertTrue([line for line in report["warnings"] if line.startswith("The map was placed by hand")])
        for now, before in zip(self.place_of("SIM_0001.JPG", out), was):
            self.assertAlmostEqual(now, before, delta=4e-5)

    def test_options_of_the_map_stay(self):
        area = self.scratch / "area.geojson"
        area.write_text(json.dumps({"type": "Polygon", "coordinates": [[[7.0998, 46.7998], [7.1002, 46.7998], [7.1002, 46.8002], [7.0998, 46.7998]]]}))
        out = self.scratch / "with_options"
        before = self.stitch(self.first, out, "--boundary", area, "--max-look-deg", "40", "--title", "Field 7", "--layers", "error")
        report = self.stitch(self.more, out, "--append")
        self.assertAlmostEqual(report["area_m2"], before["area_m2"], delta=0.05 * before["area_m2"])
        self.assertEqual(report["title"], "Field 7")
        self.assertTrue((out / "layer_error.mbtiles").exists())
        # Placed against it, as asked for the same: the photo is new, and nothing else.
        self.assertTrue([line for line in report["warnings"] if line.startswith("1 photo was added")])

    def test_a_ground_size_that_was_asked_for_stays_when_the_flight_is_aligned_anew(self):
        first, more = self.halves("of_coarse")
        out = self.scratch / "coarse"
        before = self.stitch(first, out, "--gsd", "0.2")
        report = self.stitch(more, out, "--append")
        self.assertEqual(report["photos"]["total"], 20)
        self.assertFalse([line for line in report["warnings"] if "of which nothing was moved" in line])
        self.assertAlmostEqual(report["gsd_m"], before["gsd_m"], delta=0.01 * before["gsd_m"])

    def test_a_folder_without_a_map_cannot_be_added_to(self):
        self.assertIn("no map that can be added to", run("stitch", self.more, "-o", self.scratch / "nothing", "--append", code=1).stderr)


class Resume(ScratchCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        run("simulate", "-o", cls.scratch / "sim", "--photos", "9", "--size", "1600x1200", "--no-world")
        cls.reference = cls.scratch / "reference"
        cls.first = cls.stitch(cls.reference)

    @classmethod
    def command(cls, out, *arguments):
        return ["stitch", cls.scratch / "sim" / "photos", "-o", out, "--method", "imu", "--threads", "1", *arguments]

    @classmethod
    def stitch(cls, out, *arguments):
        run(*cls.command(out, *arguments))
        return report_of(out)

    @staticmethod
    def blocks_in(state):
        if not state.exists():
            return 0
        try:
            with contextlib.closing(sqlite3.connect(f"file:{state}?mode=ro", uri=True)) as database:
                return database.execute("SELECT count(*) FROM blocks").fetchone()[0]
        except sqlite3.Error:  # just being made or written
            return 0

    def kill_in_mid_render(self, out):
        """Kills the job once some blocks are remembered, and before it is done."""
        job = subprocess.Popen([BINARY, *self.command(out)], stderr=subprocess.DEVNULL)
        state = out / "mosaic.state.tmp"
        deadline = time.monotonic() + PATIENCE_S
        while time.monotonic() < deadline and job.poll() is None:
            if self.blocks_in(state) > 0:
                break
            time.sleep(0.005)
        job.send_signal(signal.SIGKILL)
        job.wait()
        self.assertFalse((out / "mosaic.mbtiles").exists(), "the job was done before it could be killed")

    def test_a_killed_job_renders_only_the_rest(self):
        out = self.scratch / "killed"
        self.kill_in_mid_render(out)
        self.kill_in_mid_render(out)
        report = self.stitch(out)
        self.assertGreater(report["blocks"]["kept"], 0)
        self.assertLess(report["blocks"]["kept"], report["blocks"]["total"])
        self.assertEqual(tiles_of(out), tiles_of(self.reference))
        for field in ("bounds", "area_m2", "tile_count", "min_zoom", "max_zoom"):
            self.assertEqual(report[field], self.first[field])
        self.assertEqual([path.name for path in out.iterdir() if ".tmp" in path.name or ".part" in path.name], [])

    def test_a_left_over_that_is_damaged_is_not_believed(self):
        out = self.scratch / "damaged"
        self.kill_in_mid_render(out)
        (out / "mosaic.mbtiles.tmp").write_bytes(b"no database")
        self.assertEqual(self.stitch(out)["blocks"]["kept"], 0)
        self.assertEqual(tiles_of(out), tiles_of(self.reference))

    def test_made_again_nothing_is_rendered_unless_something_changed(self):
        out = self.scratch / "again"
        shutil.copytree(self.reference, out)
        report = self.stitch(out)
        self.assertEqual(report["blocks"]["kept"], report["blocks"]["total"])
        self.assertEqual(tiles_of(out), tiles_of(self.reference))
        self.assertEqual(self.stitch(out, "--quality", "70", "--overwrite")["blocks"]["kept"], 0)
        # The state of another map is not believed.
        shutil.copy(self.reference / "mosaic.state", out / "mosaic.state")
        with sqlite3.connect(out / "mosaic.mbtiles") as mbtiles:
            mbtiles.execute("DELETE FROM tiles_shallow WHERE zoom_level = "
                            "(SELECT max(zoom_level) FROM tiles_shallow)")
        self.assertEqual(self.stitch(out)["blocks"]["kept"], 0)
        self.assertEqual(tiles_of(out), tiles_of(self.reference))
