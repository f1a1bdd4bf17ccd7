"""`skyquilt validate`: maps of ours and of other programs are sound, and each kind of damage is found and named."""
import contextlib
import json
import shutil
import sqlite3
import struct
import unittest

from flights import made_flights
from program import ScratchCase, report_of, run, tool

HAS_GDAL = all(shutil.which(name) for name in ("gdal_translate", "gdaladdo"))


def validate(path, *words):
    done = run("validate", path, "--json", *words, code=None, timeout=120)
    assert done.stdout, done.stderr
    told = json.loads(done.stdout)
    assert done.returncode == (0 if told["sound"] else 1), done
    return told


def findings(told, severity="error"):
    return [f"{file['file']}: {finding['what']}" for file in told["files"] for finding in file["findings"]
            if finding["severity"] == severity]


class Validate(ScratchCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        shutil.copytree(made_flights.small_map(), cls.scratch / "map")
        cls.map = cls.scratch / "map"

    def assert_found(self, path, words, severity="error", *options):
        found = findings(validate(path, *options), severity)
        self.assertTrue(any(words in what for what in found), (path.name, words, found))

    def changed(self, name, content):
        path = self.scratch / name
        path.write_bytes(content)
        return path

    def test_our_map_is_sound_whole_and_file_by_file(self):
        before = {path: path.stat().st_mtime_ns for path in self.map.iterdir()}
        for words in ([], ["--quick"], ["--strict"]):
            told = validate(self.map, *words)
            self.assertTrue(told["sound"], findings(told))
            self.assertEqual((told["errors"], told["warnings"]), (0, 0))
            self.assertEqual({"mosaic.mbtiles", "mosaic.pmtiles", "mosaic.tif", "report.json", "photos.geojson"} - {file["file"] for file in told["files"]}, set())
        report = report_of(self.map)
        for name, kind in (("mosaic.mbtiles", "MBTiles"), ("mosaic.pmtiles", "PMTiles"), ("mosaic.tif", "cloud-optimised GeoTIFF")):
            told = validate(self.map / name)["files"][0]
            self.assertEqual(told["kind"], kind)
            if kind != "cloud-optimised GeoTIFF":
                self.assertEqual((told["tiles"], told["min_zoom"], told["max_zoom"]), (report["tile_count"], report["min_zoom"], report["max_zoom"]))
        self.assertEqual({path: path.stat().st_mtime_ns for path in self.map.iterdir()}, before)

    def test_mbtiles_with_something_wrong(self):
        changes = [
            ("UPDATE metadata SET value='png8' WHERE name='name'", None),
            ("DELETE FROM metadata WHERE name='name'", "no name"),
            ("DELETE FROM metadata WHERE name='format'", "no format"),
            ("UPDATE metadata SET value='png' WHERE name='format'", "none is"),
            ("UPDATE metadata SET value='7' WHERE name='maxzoom'", "maxzoom is 7"),
            ("UPDATE metadata SET value='deep' WHERE name='maxzoom'", "no zoom"),
            ("UPDATE metadata SET value='1,2,3,4' WHERE name='bounds'", "the tiles lie at"),
            ("UPDATE metadata SET value='7.1,46.8' WHERE name='bounds'", "west,south,east,north"),
            ("UPDATE metadata SET value='9,8,7,6' WHERE name='bounds'", "west,south,east,north"),
            ("UPDATE metadata SET value='512' WHERE name='tile_size'", "512 pixels a side"),
            ("UPDATE tiles_data SET tile_data=x'' WHERE rowid=(SELECT min(rowid) FROM tiles_data)", "empty"),
            ("UPDATE tiles_data SET tile_data=x'00112233' WHERE rowid=(SELECT min(rowid) FROM tiles_data)", "no PNG"),
            ("UPDATE tiles_data SET tile_data=substr(tile_data,1,length(tile_data)/3)", "damaged pictures"),
            ("UPDATE tiles_data SET tile_data='text'", "not stored as a blob"),
            ("DELETE FROM tiles_data WHERE rowid=(SELECT min(rowid) FROM tiles_data)", "not there"),
            ("UPDATE tiles_shallow SET tile_column=tile_column+(1<<21) WHERE zoom_level=21", "lie nowhere"),
            ("DELETE FROM tiles_shallow WHERE zoom_level=15", "zoom 15 has no tiles"),
            ("DELETE FROM tiles_shallow", "no tiles"),
            ("DROP TABLE metadata", "\"metadata\""),
            ("DROP VIEW tiles", "\"tiles\""),
        ]
        for number, (sql, words) in enumerate(changes):
            path = self.scratch / f"changed_{number}.mbtiles"
            shutil.copy(self.map / "mosaic.mbtiles", path)
            with contextlib.closing(sqlite3.connect(path)) as db:
                db.execute(sql)
                db.commit()
            with self.subTest(sql):
                if words is None:
                    self.assertTrue(validate(path)["sound"])
                else:
                    self.assert_found(path, words)
        with contextlib.closing(sqlite3.connect(path := self.scratch / "holes.mbtiles")) as db:
            db.executescript("CREATE TABLE metadata(name, value); CREATE TABLE tiles(zoom_level, tile_column, tile_row, tile_data);")
            tile = sqlite3.connect(self.map / "mosaic.mbtiles").execute("SELECT tile_data FROM tiles LIMIT 1").fetchone()[0]
            db.executemany("INSERT INTO metadata VALUES(?,?)", [("name", "x"), ("format", "png"), ("minzoom", "1"), ("maxzoom", "2")])
            db.executemany("INSERT INTO tiles VALUES(?,?,?,?)", [(1, 0, 0, tile), (2, 3, 3, tile), (2, 0, 0, tile), (2, 0, 0, tile)])
            db.commit()
        self.assert_found(path, "there twice")
        self.assert_found(path, "vanish from afar", "warning")
        self.assert_found(path, "no bounds", "warning")
        whole = (self.map / "mosaic.mbtiles").read_bytes()
        self.assert_found(self.changed("cut.mbtiles", whole[:len(whole) // 2]), "damaged")
        self.assert_found(self.changed("page.mbtiles", whole[:8192] + bytes(4096) + whole[12288:]), "damaged")
        self.assert_found(self.changed("text.mbtiles", b"hello"), "no SQLite database")

    def test_pmtiles_with_something_wrong(self):
        whole = (self.map / "mosaic.pmtiles").read_bytes()
        root, root_bytes, tiles = struct.unpack_from("<QQ", whole, 8) + struct.unpack_from("<Q", whole, 56)

        def patched(name, offset, content):
            return self.changed(name + ".pmtiles", whole[:offset] + content + whole[offset + len(content):])

        self.assert_found(self.changed("cut.pmtiles", whole[:-1000]), "cut off")
        self.assert_found(self.changed("head.pmtiles", whole[:90]), "no PMTiles header")
        self.assert_found(patched("version", 7, b"\x02"), "version 2")
        self.assert_found(patched("count", 72, struct.pack("<Q", 5)), "counts 5 tiles")
        self.assert_found(patched("zoom", 101, b"\x09"), "maxzoom is 9")
        self.assert_found(patched("bounds", 102, struct.pack("<4i", 10**7, 10**7, 2 * 10**7, 2 * 10**7)), "the tiles lie at")
        self.assert_found(patched("format", 99, b"\x02"), "none is")
        self.assert_found(patched("overlap", 24, struct.pack("<Q", root)), "lie upon each other")
        self.assert_found(patched("root", root + root_bytes // 2, b"\0\0\0\0"), "root directory is damaged")
        self.assert_found(patched("tile", tiles + 200, bytes(4000)), "damaged pictures")
        self.assert_found(patched("short", 64, struct.pack("<Q", 1000)), "beyond the end")
        self.assertTrue(validate(patched("vector", 99, b"\x01"))["sound"])
        self.assert_found(self.scratch / "vector.pmtiles", "vector tiles", "note")

    @unittest.skipUnless(HAS_GDAL, "gdal-bin is not installed: it makes the maps of others for this test")
    def test_geotiffs_of_others(self):
        cog = self.map / "mosaic.tif"

        def made(name, *words):
            tool("gdal_translate", "-q", *words, cog, self.scratch / name)
            return self.scratch / name

        for name in ("cog.tif", "utm.tif"):
            words = ["-of", "COG", "-co", "BLOCKSIZE=256"]
            told = validate(made(name, *words))
            self.assertEqual((told["sound"], told["warnings"], told["files"][0]["kind"]), (True, 0, "cloud-optimised GeoTIFF"))
        strips = made("strips.tif")
        self.assertTrue(validate(strips)["sound"])
        self.assertFalse(validate(strips, "--strict")["sound"])
        for words in ("strips", "no overviews"):
            self.assert_found(strips, words, "warning")
        tiled = made("tiled.tif", "-co", "TILED=YES")
        tool("gdaladdo", "-q", tiled, "2", "4", "8")
        self.assert_found(tiled, "behind those of a finer one", "warning")
        outside = made("outside.tif", "-co", "TILED=YES")
        tool("gdaladdo", "-q", "-ro", outside, "2", "4")
        self.assert_found(outside, ".ovr", "warning")
        nowhere = made("nowhere.tif", "-co", "PROFILE=BASELINE")
        self.assert_found(nowhere, "not georeferenced")
        whole = cog.read_bytes()
        self.assert_found(self.changed("cut.tif", whole[:len(whole) * 2 // 3]), "cut off")
        self.assert_found(self.changed("head.tif", whole[:40]), "cannot be opened")
        self.assert_found(self.changed("holes.tif", whole[:-60000] + bytes(50000) + whole[-10000:]), "damaged")

    def test_what_the_files_of_a_map_say_of_each_other(self):
        def copy(name):
            shutil.copytree(self.map, self.scratch / name)
            return self.scratch / name

        report = report_of(self.map)
        for name, change, words in (("tiles", {"tile_count": 3}, "tile_count is 3"), ("bounds", {"bounds": [1, 2, 3, 4]}, "not those of mosaic.mbtiles"),
                                    ("photos", {"photos": {**report["photos"], "aligned": 5}}, "report.json counts 5")):
            folder = copy(name)
            (folder / "report.json").write_text(json.dumps({**report, **change}))
            self.assert_found(folder, words)
        folder = copy("cut")
        (folder / "report.json").write_text("{\"title\":")
        (folder / "thumbnail.png").write_bytes(b"\x89PNG\r\n\x1a\n")
        (folder / "mosaic.mbtiles").unlink()
        for words in ("report.json: it is no JSON", "thumbnail.png: it is a damaged", "mosaic.mbtiles is missing"):
            self.assert_found(folder, words)

    def test_words_for_people(self):
        done = run("validate", self.map, code=None)
        self.assertEqual((done.returncode, done.stdout.splitlines()[-1]), (0, "Sound: 0 errors, 0 warnings"))
        self.assertRegex(done.stdout, r"mosaic.mbtiles: MBTiles, \d+ tiles, zoom \d+ to \d+\n")
        for path, words in ((made_flights.small_flight() / "photos", "is no map"), (self.changed("a.jpg", b"\xff\xd8\xff"), "is no map"),
                            (self.scratch / "none", "does not exist")):
            done = run("validate", path, code=None)
            self.assertNotEqual(done.returncode, 0)
            self.assertIn(words, done.stderr)
