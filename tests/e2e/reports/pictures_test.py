"""Pictures beside the photos of a flight that are none of them: raw files, a panorama, exports, temperatures. The map is that
of the photos, and what is left aside is named with the reason."""
import unittest

from reported_flight import NAMES, ReportedFlight


class Pictures(ReportedFlight):
    def left_out(self, answer):
        return {photo["name"]: photo["reason"] for photo in answer.report["left_out_photos"]}

    def test_raw_files_beside_the_photos(self):
        photos = [f"photos/{name}" for name in NAMES[:4]]
        alone, answer = self.stitch(*photos), self.stitch(*photos, "nef-beside-jpeg")
        self.assertEqual(answer.report["photos"], {"total": 8, "aligned": 4, "pose_only": 0, "left_out": 4}, answer.said)
        self.assertAlmostEqual(answer.report["gsd_m"], alone.report["gsd_m"], delta=0.0005)
        self.assertAlmostEqual(answer.report["gsd_m"], 0.063, delta=0.003)
        self.assert_cameras(answer, within_m=(0.05, 0.1), names=NAMES[:4], places=alone.cameras)
        for name, reason in self.left_out(answer).items():
            self.assertRegex(reason, r"(?i)\braw\b", name)
        told = self.inspect(*photos, "nef-beside-jpeg")
        self.assertEqual(len(told["cameras"]), 1, told["cameras"])
        self.assertEqual([photo["name"].rsplit(".")[1] for photo in told["left_out"]], ["NEF"] * 4)

    def test_a_panorama_of_the_place_of_take_off(self):
        answer = self.stitch("photos", "panorama-apart")
        self.assert_map(answer)
        self.assertRegex(self.left_out(answer)["DJI_0036_PANO.JPG"], r"(?i)panorama")
        self.assertAlmostEqual(answer.report["area_m2"], 12_854, delta=130)

    def test_a_panorama_amid_the_others(self):
        folder = self.scratch / "amid"
        folder.mkdir()
        for photo in (self.folder / "photos").iterdir():
            (folder / photo.name).write_bytes(photo.read_bytes())
        panorama = self.folder / "panorama-apart" / "DJI_0036_PANO.JPG"
        (folder / "DJI_0026_PANO.JPG").write_bytes(panorama.read_bytes())
        answer = self.stitch(folder)
        self.assert_map(answer)
        self.assertIn("DJI_0026_PANO.JPG", self.left_out(answer))

    def test_exports_beside_their_originals(self):
        answer = self.stitch("photos", "edited-copies")
        self.assert_map(answer)
        for name in ("DJI_0021-2.jpg", "DJI_0022-2.jpg", "DJI_0023-2.jpg", "DJI_0024-2.jpg"):
            self.assertNotIn(name, answer.cameras, answer.said)  # drawn, they would make the map brighter
            self.assertIn("DJI_00" + name[6:8], self.left_out(answer)[name])

    def test_temperatures_as_floating_point(self):
        answer = self.stitch("float32-tiff")
        told = self.inspect("float32-tiff")
        if answer.report is None:
            self.assertRegex(answer.said, r"(?i)32.?bit|floating|float32")
            self.assertEqual(told["photos_readable"], 0, told)
            for photo in told["left_out"]:
                self.assertRegex(photo["reason"], r"(?i)32.?bit|floating|float32")
            return
        self.assertEqual((answer.report["photos"]["total"], answer.report["photos"]["left_out"], told["photos_readable"]), (3, 0, 3), answer.said)
        self.assert_cameras(answer, names=[name for name in answer.cameras], places=self.of_the_same_moment(answer))

    def of_the_same_moment(self, answer):
        """Temperatures were taken where the photo of the same number was."""
        return {name: self.places[name.split("_T")[0] + ".JPG"] for name in answer.cameras}


if __name__ == "__main__":
    unittest.main()
