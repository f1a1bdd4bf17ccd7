"""A finished map and files of others in the folder of -o are replaced only by those who say so."""
import contextlib
import fcntl
import json
import os
import shutil
import sqlite3

from program import ScratchCase, report_of, run


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


class OutFolder(ScratchCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        for name, seed in (("one", "1"), ("other", "2")):
            run("simulate", "-o", cls.scratch / f"sim_{name}", "--photos", "4", "--size", "400x300", "--seed", seed, "--no-world")
            shutil.copytree(cls.scratch / f"sim_{name}" / "photos", cls.scratch / name)
        cls.map = cls.scratch / "map"
        cls.stitch(cls.scratch / "one", cls.map, code=0)

    @staticmethod
    def stitch(photos, out, *arguments, code=None):
        return run("stitch", photos, "-o", out, "--method", "imu", *arguments, code=code)

    def copy_of_map(self, name):
        out = self.scratch / name
        shutil.copytree(self.map, out)
        return out

    def check_refused(self, out, done, *words):
        self.assertEqual(done.returncode, 1, done.stderr)
        for word in words:
            self.assertIn(word, done.stderr)

    def test_a_map_of_other_photos_stays(self):
        out = self.copy_of_map("kept")
        before = contents(out)
        done = self.stitch(self.scratch / "other", out)
        self.check_refused(out, done, "finished map of other photos", "--append", "--overwrite")
        self.assertEqual(contents(out), before)
        # With the word it is replaced.
        self.stitch(self.scratch / "other", out, "--overwrite", code=0)
        self.assertNotEqual(contents(out)["mosaic.mbtiles"], before["mosaic.mbtiles"])

    def test_a_format_that_is_not_written_does_not_stay_of_the_map_before(self):
        out = self.scratch / "formats"
        self.stitch(self.scratch / "one", out, "--formats", "geotiff,pmtiles", code=0)
        self.assertLessEqual({"mosaic.tif", "mosaic.pmtiles"}, set(contents(out)))
        for asked, refused in (("geotiff", "--no-cog"), ("pmtiles", "--no-pmtiles")):
            done = self.stitch(self.scratch / "other", out, "--overwrite", "--formats", asked, refused)
            self.check_refused(out, done, f"--formats {asked}", refused)
        # What "export" copies as it lies there would show the other photos.
        self.stitch(self.scratch / "other", out, "--overwrite", "--no-cog", "--no-pmtiles", code=0)
        self.assertEqual({"mosaic.tif", "mosaic.pmtiles"} & set(contents(out)), set())

    def test_the_same_photos_are_stitched_again_wherever_they_lie(self):
        out = self.copy_of_map("again")
        elsewhere = self.scratch / "elsewhere"
        shutil.copytree(self.scratch / "one", elsewhere)
        self.stitch(elsewhere, out, code=0)

    def test_a_map_made_with_other_options_stays(self):
        out = self.copy_of_map("other_options")
        before = contents(out)
        area = self.scratch / "area.geojson"
        area.write_text(json.dumps({"type": "Polygon", "coordinates": [[[7.0, 46.0], [8.0, 46.0], [8.0, 47.0], [7.0, 46.0]]]}))
        for words, said in ((["--quality", "60"], "--quality 85 (now 60)"), (["--gsd", "30cm"], "(now 0.3)"), (["--boundary", area], "no --boundary"),
                            (["--max-look-deg", "40"], "--max-look-deg 65 (now 40)")):
            self.check_refused(out, self.stitch(self.scratch / "one", out, *words), "finished map of these photos", said, "--overwrite")
            self.assertEqual(contents(out), before)
        done = self.stitch(self.scratch / "one", out, "--gsd", "30cm", "--overwrite", code=0)
        # The resolution that is told is the map's, and it stays that where nothing is said of it.
        for again in (done, self.stitch(self.scratch / "one", out)):
            self.assertIn(" at 30.0 cm a pixel", again.stdout)
            self.assertEqual(report_of(out)["gsd_m"], 0.3)

    def test_a_map_made_with_a_list_stays_without_it(self):
        places = json.loads((self.scratch / "sim_one" / "truth" / "poses.json").read_text())["photos"]
        rows = [f"{photo['name']},{photo['lat_deg']:.9f},{photo['lon_deg']:.9f},{photo['height_ellipsoid_m']:.3f}" for photo in places]
        positions = self.scratch / "positions.csv"
        positions.write_text("\n".join(["name,latitude,longitude,ellipsoidal_height", *rows, ""]))
        out = self.scratch / "by_list"
        words = ["stitch", self.scratch / "one", positions, "-o", out, "--method", "imu"]
        run(*words)
        before = contents(out)
        self.check_refused(out, self.stitch(self.scratch / "one", out), "1 file more (positions.csv)", "is not given now", "--overwrite")
        self.assertEqual(contents(out), before)
        # A list that was corrected meanwhile is given.
        positions.write_text("\n".join(["name,latitude,longitude,ellipsoidal_height", *rows, "", ""]))
        run(*words)
        self.assertEqual(self.stitch(self.scratch / "one", out, "--overwrite").returncode, 0)

    def test_more_photos_with_all_of_the_map_make_it_grow(self):
        out = self.copy_of_map("grown")
        both = self.scratch / "both"
        both.mkdir()
        for name in ("one", "other"):
            for photo in (self.scratch / name).iterdir():
                shutil.copy(photo, both / f"{name}_{photo.name}")
        self.stitch(both, out, code=0)
        self.assertEqual(report_of(out)["photos"]["total"], 8)
        fewer = self.stitch(self.scratch / "one", out)
        self.check_refused(out, fewer, "4 of its 8 photos")

    def test_a_map_that_does_not_say_of_which_photos_stays(self):
        out = self.copy_of_map("unknown")
        (out / "mosaic.state").unlink()
        before = contents(out)
        done = self.stitch(self.scratch / "one", out)
        self.check_refused(out, done, "mosaic.mbtiles", "mosaic.state", "--overwrite")
        self.assertEqual(contents(out), before)
        (out / "mosaic.state").write_bytes(b"no database at all")
        self.check_refused(out, self.stitch(self.scratch / "one", out), "--overwrite")
        self.assertEqual(self.stitch(self.scratch / "one", out, "--overwrite").returncode, 0)

    def test_a_map_of_another_version_stays(self):
        out = self.copy_of_map("earlier")
        with contextlib.closing(sqlite3.connect(out / "mosaic.state")) as state, state:
            [facts] = state.execute("SELECT bytes FROM facts WHERE name='flight'").fetchone()
            at = facts.index(b"gversion") + len(b"gversion")  # CBOR: a text of 7 bytes, then a small number
            state.execute("UPDATE facts SET bytes=? WHERE name='flight'", (facts[:at] + bytes([facts[at] - 1]) + facts[at + 1:],))
        before = contents(out)
        self.check_refused(out, self.stitch(self.scratch / "other", out), "another version", "--overwrite")
        self.assertEqual(contents(out), before)

    def test_files_of_others_are_not_taken_for_products(self):
        for name in ("geo.txt", "report.json", "layers.json", "mosaic.tif"):
            out = self.scratch / f"others_{name}"
            out.mkdir()
            (out / name).write_text("mine")
            self.check_refused(out, self.stitch(self.scratch / "one", out), name, "--overwrite")
            self.assertEqual(contents(out), {name: b"mine"})
        # Files with names of their own are no hindrance, and stay.
        out = self.scratch / "with_notes"
        out.mkdir()
        (out / "notes.txt").write_text("mine")
        self.assertEqual(self.stitch(self.scratch / "one", out).returncode, 0)
        self.assertEqual((out / "notes.txt").read_text(), "mine")

    def test_a_map_among_its_photos_is_none_of_the_flight(self):
        photos = self.scratch / "with_map"
        shutil.copytree(self.scratch / "one", photos)
        self.stitch(photos, photos / "map", "--formats", "utm", code=0)
        first = report_of(photos / "map")
        # Its positions (geo.txt), pictures and heights came from these photos: they say nothing more of them.
        for out in (photos / "map", photos / "again"):
            self.stitch(photos, out, code=0)
            again = report_of(out)
            self.assertEqual(again["photos"], first["photos"])
            self.assertFalse([line for line in again["warnings"] if "geo.txt" in line], again["warnings"])
        self.assertNotIn("geo.txt", run("inspect", photos).stdout)
        # Given by itself it is a list as any other.
        self.assertIn("geo.txt", run("inspect", photos, photos / "map" / "geo.txt").stdout)

    def test_a_file_that_is_read_is_never_replaced(self):
        photos = self.scratch / "with_geo"
        shutil.copytree(self.scratch / "one", photos)
        (photos / "geo.txt").write_text("EPSG:4326\n")
        self.check_refused(photos, self.stitch(photos, photos), "geo.txt")
        self.check_refused(photos, self.stitch(photos, photos, "--overwrite"), "geo.txt", "one of the files given")
        self.assertEqual((photos / "geo.txt").read_text(), "EPSG:4326\n")

    def test_a_folder_in_which_a_map_is_made_is_left_alone(self):
        out = self.copy_of_map("at_work")
        before = contents(out)
        other_run = os.open(out, os.O_RDONLY)
        self.addCleanup(os.close, other_run)
        fcntl.flock(other_run, fcntl.LOCK_EX)
        for words in ((), ("--overwrite",), ("--append",)):
            self.check_refused(out, self.stitch(self.scratch / "one", out, *words), "another run makes its map")
        self.check_refused(out, run("place", out, "--point", "46,7=46.1,7.1", "--again", code=None), "another run makes its map")
        self.assertEqual(contents(out), before)
        fcntl.flock(other_run, fcntl.LOCK_UN)
        self.stitch(self.scratch / "other", out, "--overwrite", code=0)

    def test_a_list_that_somebody_put_beside_the_map_is_read_and_stays(self):
        photos = self.scratch / "with_map_and_list"
        shutil.copytree(self.scratch / "one", photos)
        self.stitch(photos, photos, code=0)
        places = json.loads((self.scratch / "sim_one" / "truth" / "poses.json").read_text())["photos"]
        rows = [f"{photo['name']} {photo['lon_deg']:.9f} {photo['lat_deg']:.9f} {photo['height_ellipsoid_m']:.3f}\n" for photo in places]
        own = "".join(["EPSG:4326\n", *rows])
        (photos / "geo.txt").write_text(own)
        self.assertIn("geo.txt", run("inspect", photos).stdout)
        for words in ((), ("--overwrite",), ("--append",)):
            self.check_refused(photos, self.stitch(photos, photos, *words), "geo.txt")
            self.assertEqual((photos / "geo.txt").read_text(), own)
        # Where it is none of the files given, the word replaces it.
        self.check_refused(photos, self.stitch(self.scratch / "one", photos), "geo.txt", "Move it")
        self.stitch(self.scratch / "one", photos, "--overwrite", code=0)
        self.assertNotEqual((photos / "geo.txt").read_text(), own)
