// Which attempt places a flight, and why.
#include "core/alignment/attempts/attempt_evidence.h"

#include <gmock/gmock.h>

#include "core/flight/remarks/remark_words.h"

namespace skyquilt::alignment {
namespace {

using ::testing::HasSubstr;

AttemptEvidence Evidence(std::size_t readable, std::size_t tied, double residual_px = 1.0) {
  AttemptEvidence evidence;
  evidence.readable = readable;
  evidence.tied = tied;
  evidence.residual_rms_px = residual_px;
  evidence.positions = tied;
  return evidence;
}

TEST(WhyDoubted, GoodRecordsHold) {
  EXPECT_FALSE(WhyDoubted(Evidence(100, 100), 0.1));
  EXPECT_FALSE(WhyDoubted(Evidence(100, 90), 0.1));
  EXPECT_FALSE(WhyDoubted(Evidence(5, 4), 0.1)) << "one photo of a few";
  EXPECT_FALSE(WhyDoubted(Evidence(2, 0), 0.1)) << "two photos make no block";
}

TEST(WhyDoubted, SaysWhatFailed) {
  EXPECT_EQ(flight::InWords(WhyDoubted(Evidence(75, 46), 0.1).value()),
            "by their recorded poses 29 of 75 photos do not fit to the others");
  AttemptEvidence nowhere = Evidence(41, 0);
  nowhere.unplaced = 41;
  EXPECT_EQ(flight::InWords(WhyDoubted(nowhere, 0.4).value()),
            "41 of 41 photos have no usable position or height");
  EXPECT_THAT(flight::InWords(WhyDoubted(Evidence(50, 50, 7.0), 0.1).value()),
              HasSubstr("disagree by 7.0 pixels"));
  AttemptEvidence few = Evidence(50, 48);
  few.unplaced = 2;
  EXPECT_FALSE(WhyDoubted(few, 0.1)) << "two lost photos do not put the others in doubt";
}

TEST(WhyImagesLose, MorePhotosTiedTogetherWin) {
  EXPECT_FALSE(WhyImagesLose(Evidence(75, 60), Evidence(75, 75)));
}

TEST(WhyImagesLose, NoMorePhotosAreNoReason) {
  EXPECT_EQ(flight::InWords(WhyImagesLose(Evidence(75, 60), Evidence(75, 60)).value()),
            "what the photos show ties 60 of them together, the recorded poses 60");
  EXPECT_TRUE(WhyImagesLose(Evidence(75, 60), Evidence(75, 40)));
}

TEST(WhyImagesLose, AsManyThatFitFarBetterWin) {
  EXPECT_FALSE(WhyImagesLose(Evidence(75, 75, 7.0), Evidence(75, 75, 1.2)));
  EXPECT_TRUE(WhyImagesLose(Evidence(75, 75, 7.0), Evidence(75, 74, 1.2)));
}

TEST(WhyImagesLose, PhotosThatDisagreeDoNotWin) {
  EXPECT_THAT(flight::InWords(WhyImagesLose(Evidence(75, 60, 1.0), Evidence(75, 75, 3.0)).value()),
              HasSubstr("3.0 pixels"));
}

TEST(WhyImagesLose, AFewMorePhotosDoNotOutweighThePositions) {
  AttemptEvidence images = Evidence(75, 75);
  images.positions_contradicted = 40;
  EXPECT_THAT(flight::InWords(WhyImagesLose(Evidence(75, 60), images).value()),
              HasSubstr("40 of 75 recorded positions"));
  EXPECT_FALSE(WhyImagesLose(Evidence(75, 30), images)) << "far more photos do";
}

TEST(WhyImagesLose, AFewMorePhotosDoNotOutweighTheAngles) {
  AttemptEvidence images = Evidence(75, 75), records = Evidence(75, 60);
  images.attitudes = 75;
  images.attitudes_contradicted = 30;
  records.attitudes = 60;
  EXPECT_TRUE(WhyImagesLose(records, images));
  records.attitudes_contradicted = 30;
  EXPECT_FALSE(WhyImagesLose(records, images)) << "the records contradict themselves as much";
}

TEST(WhyImagesLose, PosesThatHardlyAnythingFitsAgreeWithTheirRecordsForNothing) {
  AttemptEvidence records = Evidence(18, 18), images = Evidence(18, 18);
  records.observations = 687;
  records.dropped = 3070;
  images.observations = 3500;
  images.dropped = 200;
  images.positions_contradicted = 17;
  EXPECT_THAT(flight::InWords(WhyDoubted(records, 0.1).value()), HasSubstr("only 687 of 3757 points"));
  EXPECT_FALSE(WhyImagesLose(records, images));
  std::swap(images.observations, images.dropped);
  EXPECT_TRUE(WhyImagesLose(records, images)) << "as few fit without the records";
  records.observations = 2000;
  EXPECT_FALSE(WhyDoubted(records, 0.1));
  records.observations = records.dropped = 0;
  EXPECT_FALSE(WhyDoubted(records, 0.1)) << "nothing was adjusted yet";
  records.is_adjusted = true;
  EXPECT_THAT(flight::InWords(WhyDoubted(records, 0.1).value()), HasSubstr("no point"));
}

TEST(WhyImagesLose, AsManyThatLieWhereTheyWereRecordedWin) {
  AttemptEvidence records = Evidence(24, 24, 0.5), images = Evidence(24, 24, 0.6);
  records.positions_contradicted = 12;
  EXPECT_FALSE(WhyDoubted(records, 0.1)) << "half of them are no majority";
  records.positions_contradicted = 23;
  EXPECT_THAT(flight::InWords(WhyDoubted(records, 0.1).value()),
              HasSubstr("23 of 24 photos do not lie where they were recorded"));
  images.positions_contradicted = 1;
  EXPECT_FALSE(WhyImagesLose(records, images));
  images.positions_contradicted = 15;
  EXPECT_TRUE(WhyImagesLose(records, images)) << "hardly better";
  images.positions_contradicted = 1;
  images.residual_rms_px = 4.0;
  EXPECT_TRUE(WhyImagesLose(records, images)) << "the photos come apart by it";
  records.positions = images.positions = 4;
  records.positions_contradicted = 4;
  EXPECT_FALSE(WhyDoubted(records, 0.1)) << "four positions are too few for a verdict";
}

TEST(ContradictionOf, IsSaidOfMostPositionsOnly) {
  AttemptEvidence evidence = Evidence(30, 28);
  evidence.median_error_m = 8.0;
  evidence.median_error_sigmas = 5.3;
  evidence.positions_off_claim = 14;
  EXPECT_FALSE(ContradictionOf(evidence));
  evidence.positions_off_claim = 15;
  EXPECT_THAT(flight::InWords(ContradictionOf(evidence).value()),
              HasSubstr("half of the 28 photos lie 8.0 m or more"));
}

// Photos side by side, tied in a row by pairs of one point each, and recorded `off_m` beside where they lie.
struct ExtractedRow {
  PhotoFeatures rich;
  ExtractedFlight flight;
  Attempt attempt;

  ExtractedRow(std::size_t count, double sigma_m, double off_m) {
    rich.keypoints.resize(500);
    flight.readable.assign(count, &rich);
    flight.records.resize(count);
    attempt.posed.photos.resize(count);
    attempt.adjusted.rms_px = 1.5;
    for (std::size_t i = 0; i < count; ++i) {
      const Eigen::Vector3d center(10.0 * static_cast<double>(i), 0.0, 50.0);
      attempt.posed.photos[i].photo.intrinsics.width_px = 4000;
      attempt.problem.photos.emplace_back().cam_from_enu =
          geo::Rigid3::FromRotationAndTargetOrigin(Eigen::Quaterniond::Identity(), center);
      flight.records[i].center_in_enu = center + Eigen::Vector3d(0.0, off_m, 0.0);
      flight.records[i].sigma_m = {sigma_m, sigma_m, 5.0};
      flight.records[i].cam_from_enu = Eigen::Quaterniond::Identity();
      const int photo = static_cast<int>(i);
      if (i > 0) attempt.matched.links.push_back({photo - 1, photo, {}, {}, 0.0});
    }
  }
  ExtractedRow(const ExtractedRow&) = delete;  // the flight points to its features
};

TEST(Weigh, CountsWhatTheRecordsClaim) {
  ExtractedRow row(4, 2.0, 0.0);
  std::vector<PhotoRecord>& records = row.flight.records;
  row.attempt.matched.links.pop_back();
  records[1].center_in_enu->x() += 20.0;
  records[2].cam_from_enu = Eigen::Quaterniond(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitX()));
  records[3].is_unplaced = true;
  const AttemptEvidence evidence = Weigh(row.flight, row.attempt);
  EXPECT_EQ(evidence.readable, 4U);
  EXPECT_EQ(evidence.tied, 3U);
  EXPECT_EQ(evidence.Lost(), 1U);
  EXPECT_EQ(evidence.unplaced, 1U);
  EXPECT_EQ(evidence.positions, 3U);
  EXPECT_EQ(evidence.positions_contradicted, 1U);
  EXPECT_EQ(evidence.attitudes_contradicted, 1U);
  EXPECT_EQ(evidence.residual_rms_px, 1.5);
}

// Positions that claim two centimetres and are off by three tenths of a metre: no reason to doubt how the
// photos lie to each other, but nothing to call accurate.
TEST(Weigh, HoldsCorrectedPositionsToTheCentimetresThatTheyClaim) {
  const auto missed_by = [](double off_m) {
    const ExtractedRow row(6, 0.02, off_m);
    return Weigh(row.flight, row.attempt);
  };
  const AttemptEvidence off = missed_by(0.3);
  EXPECT_EQ(off.positions_contradicted, 0U);
  EXPECT_FALSE(WhyDoubted(off, 0.1));
  EXPECT_THAT(flight::InWords(ContradictionOf(off).value()), HasSubstr("lie 0.3 m or more"));
  EXPECT_FALSE(ContradictionOf(missed_by(0.09))) << "as far as an antenna is from its camera";
}

TEST(AttemptEvidence, SaysWhenAnAdjustmentKeptButAFewObservations) {
  EXPECT_FALSE(DroppedOf(0, 0));
  EXPECT_FALSE(DroppedOf(2563, 1361));
  EXPECT_THAT(flight::InWords(DroppedOf(687, 3070).value()), HasSubstr("687 of 3757"));
}

}  // namespace
}  // namespace skyquilt::alignment
