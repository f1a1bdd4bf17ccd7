"""Logs and tracks for photos without GPS, and surveyed points, as users were reported to have them."""
import unittest

from reported_flight import OF_A_TRACK, ReportedFlight


class Tracks(ReportedFlight):
    def assert_placed(self, track):
        answer = self.stitch("photos-nogps", track)
        self.assert_map(answer, within_m=OF_A_TRACK)
        self.assertEqual(answer.report["poses"]["photos_by_log"], 18, answer.said)

    def test_tables_and_the_ways_to_write_dates(self):
        for case in ("DJIFlightRecord_2016-06-23_[16-31-29].csv", "us-dates.csv", "date-and-time-apart.csv", "epoch-ms.csv",
                     "2016-06-23_16-31-19_v2.csv"):
            with self.subTest(case):
                self.assert_placed(f"tracks/{case}")

    def test_tracks_of_other_programs(self):
        for case in ("gpx-prefix.gpx", "gpx-single-quotes.gpx", "nmea-without-checksums.nmea"):
            with self.subTest(case):
                self.assert_placed(f"tracks/{case}")

    def test_events_of_which_one_is_missing(self):
        answer = self.stitch("photos-nogps", "one-event-missing/raw_201606231916_UBX_events.pos")
        if not answer.is_placed():
            self.assert_told(answer, r"events\.pos", r"\b17\b", r"\b18\b")
            return
        self.assertEqual(answer.report["photos"]["aligned"], 18, answer.said)
        self.assert_cameras(answer, within_m=(0.7, 5.0))  # between its neighbours: half a step at most
        misses = sorted(max(abs(east), abs(north)) for east, north in answer.offsets_m(self.places).values())
        self.assertLess(misses[-2], 1.5, answer.said)

    def test_subtitles_of_another_maker(self):
        for case, cause in (("MAX_0001.ASS", r"MAX_0001\.ASS.*(Autel|subtitle)"), ("MAX_0001.SRT", r"MAX_0001\.SRT.*(this form|Autel|not read)")):
            with self.subTest(case):
                # Six decimals of a degree, and a caption holds until the next begins.
                self.assert_map_or_told(self.stitch("photos-nogps", f"autel-subtitles/{case}"), [cause], within_m=OF_A_TRACK)


class SurveyedPoints(ReportedFlight):
    """They lie 5 m east of where the photos alone put them."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.plain = cls.stitch(cls("test_the_plain_list_moves_the_map"), "photos", "gcp-plain/gcp_list.txt")

    def test_the_plain_list_moves_the_map(self):
        self.assert_cameras(self.plain, east_m=5.0, within_m=(1.5, 2.0))
        self.assertEqual([point["is_used"] for point in self.plain.report["alignment"]["ground_control"]], [True] * 5)

    def test_other_ways_to_write_the_same_list(self):
        for case, cause in (("gcp-compound-system", r"EPSG:32615\+5773"), ("gcp-crlf-tabs-header", r"gcp_list\.txt.*(line|row)")):
            with self.subTest(case):
                answer = self.stitch("photos", f"{case}/gcp_list.txt")
                if answer.report["alignment"]["ground_control"]:
                    self.assert_cameras(answer, within_m=(0.05, 0.1), places=self.plain.cameras)
                else:
                    self.assert_told(answer, cause)


if __name__ == "__main__":
    unittest.main()
