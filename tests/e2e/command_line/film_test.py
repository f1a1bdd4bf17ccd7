"""A film and its subtitles through the real server, and through `stitch`: frames are taken, placed by the subtitles
and told apart from photos; a film that cannot be read is named and the photos beside it become the map."""
import json
import math
import pathlib
import subprocess
import tempfile

from program import BINARY, ScratchCase, report_of, run
from server_support import Server

FRAMES_PER_S = 5


def subtitle(number, photo):
    begin, end = number / FRAMES_PER_S, (number + 1) / FRAMES_PER_S
    clock = [f"00:00:{s:06.3f}".replace(".", ",") for s in (begin, end)]
    return (f"{number + 1}\n{clock[0]} --> {clock[1]}\n"
            f'<font size="28">FrameCnt: {number + 1}, DiffTime: {1000 // FRAMES_PER_S}ms\n'
            f"2024-06-01 10:00:{begin:06.3f}\n"
            f"[iso: 100] [shutter: 1/1000.0] [fnum: 2.8] [latitude: {photo['lat_deg']:.7f}] "
            f"[longitude: {photo['lon_deg']:.7f}] [rel_alt: 60.000 abs_alt: 460.000] </font>\n\n")


class Films(ScratchCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        flight = cls.scratch / "flight"
        run("simulate", "-o", flight, "--photos", "60", "--size", "480x360", "--overlap", "0.93", "--no-world", "--seed", "5")
        cls.truth = json.loads((flight / "truth/poses.json").read_text())["photos"]
        cls.film, cls.subtitles = cls.scratch / "DJI_0007.MP4", cls.scratch / "DJI_0007.SRT"
        maker = pathlib.Path(BINARY).with_name("film_of_photos")
        subprocess.run([maker, flight / "photos", cls.film, str(FRAMES_PER_S)], check=True)
        cls.subtitles.write_text("".join(subtitle(n, photo) for n, photo in enumerate(cls.truth)))

    def look_at(self, report):
        photos = report["photos"]
        # Photos share 93 %, frames are wanted where they share 80 %: about every third.
        self.assertTrue(15 <= photos["total"] <= 35, photos)
        self.assertEqual(photos["aligned"], photos["total"], photos)
        self.assertEqual(report["alignment"]["pieces"], 1)
        self.assertTrue(report["is_placed"])

    def test_a_film_and_its_subtitles_become_a_map_at_the_server(self):
        with tempfile.TemporaryDirectory() as data:
            with Server(data) as server:
                files = [(p.name, p.read_bytes()) for p in (self.film, self.subtitles)]
                _, made = server.upload(files, name="A film", code=202)
                flight = f"/api/v1/flights/{made['flight']['id']}"
                _, verdict = server.json("GET", flight + "/verdict", code=200)
                self.assertTrue(any("DJI_0007.MP4 is a film" in text for text in verdict["warnings"]), verdict)
                self.assertFalse(any("nothing to place" in text for text in verdict["warnings"]), verdict)
                server.ended(made["job"]["id"])
                _, report = server.json("GET", flight + "/report", code=200)
                self.look_at(report)
                frame = report["alignment"]["photo_reports"][0]["name"]
                status, headers, bytes_of_frame = server.request("GET", f"{flight}/files/{frame}")
                self.assertEqual((status, headers["Content-Type"]), (200, "image/jpeg"))
                self.assertEqual(bytes_of_frame[:2], b"\xff\xd8")
                for name in ("frames.json", ".hidden.jpg", "none.jpg"):
                    self.assertEqual(server.request("GET", f"{flight}/files/{name}")[0], 404, name)

    def test_stitch_takes_the_film(self):
        out = self.scratch / "map"
        run("stitch", self.film, self.subtitles, "-o", out)
        report = report_of(out)
        self.look_at(report)
        truth_lat = sum(p["lat_deg"] for p in self.truth) / len(self.truth)
        features = json.loads((out / "photos.geojson").read_text())["features"]
        lat = sum(f["properties"]["camera_lat"] for f in features) / len(features)
        self.assertLess(abs(math.radians(lat - truth_lat)) * 6371000, 15)
        # The same film again is the same map; another of its name does not replace it.
        run("stitch", self.film, self.subtitles, "-o", out)
        other = self.scratch / "other"
        other.mkdir()
        (other / self.film.name).write_bytes(self.film.read_bytes() + b"\0\0\0\x08free")
        refused = run("stitch", other, "-o", out, code=None)
        self.assertNotEqual(refused.returncode, 0)
        self.assertIn("DJI_0007.MP4", refused.stderr)
        # Photos join a map of a film.
        photo = self.scratch / "flight/photos" / self.truth[-1]["name"]
        run("stitch", photo, "-o", out, "--append")
        self.assertEqual(report_of(out)["photos"]["total"], report["photos"]["total"] + 1)

    def test_a_run_that_ends_early_leaves_the_map_its_film(self):
        out = self.scratch / "cut_short"
        run("stitch", self.film, self.subtitles, "-o", out)
        of_film = report_of(out)["photos"]["total"]
        photo = self.scratch / "flight/photos" / self.truth[-1]["name"]
        frame, aside = out / "frames/DJI_0007_000000.jpg", self.scratch / "aside.jpg"
        frame.rename(aside)
        frame.mkdir()  # which cannot be written
        self.assertNotEqual(run("stitch", photo, "-o", out, "--append", code=None).returncode, 0)
        frame.rmdir()
        aside.rename(frame)
        refused = run("stitch", photo, "-o", out, code=None)
        self.assertNotEqual(refused.returncode, 0)
        self.assertIn("DJI_0007.MP4", refused.stderr)
        run("stitch", photo, "-o", out, "--append")
        self.assertEqual(report_of(out)["photos"]["total"], of_film + 1)

    def test_a_map_of_photos_in_place_of_a_films_has_nothing_of_the_film(self):
        out, photos = self.scratch / "replaced", [self.scratch / "flight/photos" / photo["name"] for photo in self.truth[:6]]
        run("stitch", self.film, self.subtitles, "-o", out)
        run("stitch", *photos[:-1], "-o", out, "--overwrite")
        run("stitch", *photos[:-1], "-o", out)
        run("stitch", photos[-1], "-o", out, "--append")
        self.assertEqual(report_of(out)["photos"]["total"], len(photos))

    def test_frames_replace_no_folder_of_the_users(self):
        out = self.scratch / "own"
        (out / "frames").mkdir(parents=True)
        (out / "frames" / "mine.jpg").write_bytes(b"mine")
        done = run("stitch", self.film, "-o", out, code=None)
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("holds other files", done.stderr)
        self.assertEqual([p.name for p in (out / "frames").iterdir()], ["mine.jpg"])

    def test_a_film_that_cannot_be_read_is_named_and_the_other_one_becomes_the_map(self):
        broken = self.scratch / "broken.MP4"
        broken.write_bytes(self.film.read_bytes()[:3000])
        out = self.scratch / "map_of_two"
        run("stitch", broken, self.film, self.subtitles, "-o", out)
        report = report_of(out)
        self.look_at(report)
        self.assertTrue(any("broken.MP4" in text for text in report["warnings"]), report["warnings"])
