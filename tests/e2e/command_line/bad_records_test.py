"""Flights whose records are missing, in part or all, through the real program as it is: every photo on the map, and the
report says which of them their records placed and which what they show."""
import json
import pathlib
import shutil
import tempfile

from flights import made_flights
from program import DATA, ScratchCase, report_of, run, without_metadata

PHOTOS = 12


class BadRecords(ScratchCase):
    def recorded(self, noise):
        """The photos of one flight, recorded as a consumer drone does ("xmp") or not at all ("no-pose")."""
        return made_flights.simulated(PHOTOS, "800x600", "--relief-m", "2", "--noise", noise) / "photos"

    def test_both_are_one_flight(self):
        poses = [json.loads((self.recorded(noise).parent / "truth/poses.json").read_text())["photos"] for noise in ("xmp", "no-pose")]
        self.assertEqual(*[[photo["camera_center_in_enu"] for photo in flown] for flown in poses])

    def stitch(self, photos, *arguments):
        out = pathlib.Path(tempfile.mkdtemp(dir=self.scratch))
        run("stitch", photos, "-o", out, *arguments)
        self.report = report_of(out)
        return self.report

    def assert_whole(self, count):
        self.assertEqual(self.report["photos"], {"total": count, "aligned": count, "pose_only": 0, "left_out": 0})
        self.assertEqual(self.report["alignment"]["pieces"], 1)
        self.assertGreater(self.report["tile_count"], 0)

    def placed_by(self):
        return {photo["name"]: photo["placed_by"] for photo in self.report["alignment"]["photo_reports"]}

    def test_good_records_hold(self):
        alignment = self.stitch(self.recorded("xmp"))["alignment"]
        self.assert_whole(PHOTOS)
        self.assertEqual(alignment["placed_by"], "records")
        self.assertEqual(set(self.placed_by().values()), {"records"})
        self.assertEqual(alignment["second_leg"]["pairs_compared"], 0)
        self.assertIn("the recorded poses hold", alignment["second_leg"]["outcome"])

    def assert_not_georeferenced(self):
        self.assert_whole(PHOTOS)
        self.assertFalse(self.report["is_placed"])
        self.assertEqual(self.report["alignment"]["placed_by"], "images")
        self.assertEqual(set(self.placed_by().values()), {"images"})
        self.assertIn("no usable position or height", self.report["alignment"]["second_leg"]["why"])
        self.assertIn("NOT GEOREFERENCED", self.report["warnings"][0])

    def test_without_any_position_the_map_is_whole_and_not_georeferenced(self):
        self.stitch(self.recorded("no-pose"))
        self.assert_not_georeferenced()

    def test_so_it_is_with_bare_pictures(self):
        bare = self.scratch / "bare"
        bare.mkdir()
        for photo in self.recorded("xmp").iterdir():
            (bare / photo.name).write_bytes(without_metadata(photo.read_bytes()))
        self.stitch(bare)
        self.assert_not_georeferenced()

    def test_a_few_photos_without_position_join_the_others(self):
        mixed = self.scratch / "mixed"
        shutil.copytree(self.recorded("xmp"), mixed)
        names = sorted(photo.name for photo in mixed.iterdir())
        lost = {names[4], names[5]}
        for name in lost:
            shutil.copy(self.recorded("no-pose") / name, mixed / name)
        alignment = self.stitch(mixed)["alignment"]
        self.assert_whole(PHOTOS)
        self.assertTrue(self.report["is_placed"])
        self.assertEqual(alignment["placed_by"], "records")
        self.assertEqual({name for name, by in self.placed_by().items() if by == "images"}, lost)

    def test_photos_of_nothing_in_common_are_refused_with_the_reason(self):
        single = self.scratch / "single"
        single.mkdir()
        first = sorted(self.recorded("no-pose").iterdir())[0]
        shutil.copy(first, single / first.name)
        refused = run("stitch", single, "-o", self.scratch / "none", code=None)
        self.assertNotEqual(refused.returncode, 0)
        self.assertIn("No photo records where it was taken", refused.stderr)

    def real(self, name):
        folder = DATA / name
        if not folder.is_dir():
            self.skipTest(f"{name} is not here")
        return folder

    def test_a_climb_without_angles_is_one_block(self):
        self.stitch(self.real("caliterra_75"))
        self.assert_whole(75)
        self.assertLess(self.report["alignment"]["residual_rms_px"], 0.6)
        self.assertLess(self.report["seams"]["median_gsd"], 1.0)
        # Its receiver is far worse than it says, which must not pass in silence.
        self.assertIn("CONTRADICT", self.report["warnings"][0])

    def test_a_kites_flight_without_positions_is_a_map(self):
        photos = self.scratch / "kite"
        shutil.copytree(self.real("copr_41") / "images", photos)
        self.stitch(photos)
        # Three of them share a strip with one of the others and no point with two: COLMAP leaves them out.
        self.assert_whole(41)
        self.assertIn("41 of 41", self.report["alignment"]["second_leg"]["outcome"])
        self.assertFalse(self.report["is_placed"])
        self.assertIn("NOT GEOREFERENCED", self.report["warnings"][0])
