"""A finished map as one file: formats, systems, areas, resolutions; and what is refused leaves nothing behind."""
import json
import pathlib
import shutil
import sqlite3
import subprocess
import tempfile

from flights import made_flights
from program import ScratchCase, run


class Export(ScratchCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        shutil.copytree(made_flights.small_map(), cls.scratch / "map")
        cls.report = json.loads((cls.scratch / "map/report.json").read_text())

    def setUp(self):
        self.out = pathlib.Path(tempfile.mkdtemp(prefix="out_", dir=self.scratch))

    def export(self, name, *words, source=None, code=None):
        return run("export", source or self.scratch / "map", "-o", self.out / name, *map(str, words), code=code)

    def exported(self, name, *words, source=None):
        self.export(name, *words, source=source, code=0)
        self.assertEqual([path.name for path in self.out.iterdir() if path.name.startswith(".")], [])
        return self.out / name

    def test_the_files_ending_says_the_format(self):
        for name, start in [("a.tif", b"II"), ("a.TIFF", b"II"), ("a.pmtiles", b"PMTiles"), ("a.mbtiles", b"SQLite"), ("a.kmz", b"PK")]:
            self.assertTrue(self.exported(name).read_bytes().startswith(start), name)
        self.assertTrue(self.exported("b", "--format", "kmz").read_bytes().startswith(b"PK"))
        self.assertEqual((self.out / "a.tif").read_bytes(), (self.scratch / "map/mosaic.tif").read_bytes())
        self.assertEqual((self.out / "a.pmtiles").read_bytes(), (self.scratch / "map/mosaic.pmtiles").read_bytes())

    def test_a_lone_mbtiles_is_a_map_too(self):
        lone = self.out / "lone.mbtiles"
        shutil.copy(self.scratch / "map/mosaic.mbtiles", lone)
        self.assertEqual(self.exported("from_lone.tif", source=lone).read_bytes(), (self.scratch / "map/mosaic.tif").read_bytes())

    def test_clip_resolution_and_system(self):
        west, south, east, north = self.report["bounds"]
        middle = (west + east) / 2
        ring = [[west, south], [middle, south], [middle, north], [west, north], [west, south]]
        (self.out / "half.geojson").write_text(json.dumps({"type": "Feature", "properties": {}, "geometry": {"type": "Polygon", "coordinates": [ring]}}))
        half = self.exported("half.mbtiles", "--clip", self.out / "half.geojson")
        count = lambda path: sqlite3.connect(path).execute("SELECT count(*) FROM tiles WHERE zoom_level=?", (self.report["max_zoom"],)).fetchone()[0]
        self.assertLess(count(half), count(self.scratch / "map/mosaic.mbtiles"))
        self.assertGreater(count(half), 0)
        bounds = [float(part) for part in dict(sqlite3.connect(half).execute("SELECT name, value FROM metadata"))["bounds"].split(",")]
        self.assertAlmostEqual(bounds[2], middle, places=9)
        tif = self.exported("half.tif", "--crs", "utm", "--resolution", "0.5", "--clip", self.out / "half.geojson")
        if shutil.which("gdalinfo"):
            told = json.loads(subprocess.run(["gdalinfo", "-json", tif], check=True, capture_output=True, text=True).stdout)
            self.assertAlmostEqual(told["geoTransform"][1], 0.5, places=9)
            self.assertIn("UTM zone", told["coordinateSystem"]["wkt"])

    def test_refusals_say_what_to_do_and_leave_nothing(self):
        (self.out / "point.geojson").write_text('{"type":"Point","coordinates":[1,2]}')
        (self.out / "far.geojson").write_text('{"type":"Polygon","coordinates":[[[1,1],[2,1],[2,2],[1,1]]]}')
        (self.out / "there.tif").write_bytes(b"mine")
        for name, words, said in [("a", [], "--format"), ("a.shp", [], "--format"), ("a.kmz", ["--crs", "utm"], "Web Mercator"),
                                  ("a.tif", ["--crs", "EPSG:1"], "not known"), ("a.tif", ["--crs", "swiss"], "EPSG:2056"),
                                  ("a.tif", ["--clip", self.out / "point.geojson"], "Polygon"), ("a.tif", ["--clip", self.out / "far.geojson"], "outside the map"),
                                  ("a.tif", ["--resolution", "0.0001"], "finest pixels"), ("there.tif", [], "--overwrite"),
                                  ("no/a.tif", [], "Make it first")]:
            done = self.export(name, *words)
            self.assertNotEqual(done.returncode, 0, words)
            self.assertIn(said, done.stderr)
        self.assertEqual(sorted(path.name for path in self.out.iterdir()), ["far.geojson", "point.geojson", "there.tif"])
        self.assertEqual((self.out / "there.tif").read_bytes(), b"mine")
        self.assertTrue(self.exported("there.tif", "--overwrite").read_bytes().startswith(b"II"))
        self.assertIn("no finished map", run("export", made_flights.small_flight(), "-o", self.out / "b.tif", code=None).stderr)
        itself = run("export", self.scratch / "map", "-o", self.scratch / "map/mosaic.tif", "--overwrite", code=None)
        self.assertIn("the map itself", itself.stderr)
