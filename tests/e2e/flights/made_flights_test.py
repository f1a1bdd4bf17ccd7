"""What tests share is there before they begin: `ctest` runs this first. A hand's test makes what it wants by itself."""
import pathlib
import tempfile
import unittest

from flights import made_flights
from server_support import put_map


class MadeFlights(unittest.TestCase):
    def test_they_are_made_once(self):
        made_flights.remove_those_of_other_builds()
        self.assertEqual(len(list((made_flights.small_flight() / "photos").iterdir())), 6)
        self.assertTrue((made_flights.small_map() / "mosaic.pmtiles").exists())
        with tempfile.TemporaryDirectory() as data:
            self.assertTrue(pathlib.Path(data, "flights", put_map(data), "r1", "mosaic.mbtiles").exists())
        with self.assertRaisesRegex(RuntimeError, "must not be made again"):
            made_flights.made("not_there", self.refuse)
        self.assertFalse((made_flights.small_map().parent / "not_there").exists())
        self.assertEqual(made_flights.made("map", self.refuse), made_flights.small_map())

    def refuse(self, folder):
        raise RuntimeError(f"{folder.name} must not be made again")
