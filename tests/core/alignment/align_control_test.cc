// A flight among surveyed points: it lies where they say, and says which of them it cannot believe.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/alignment/align_flight.h"
#include "core/alignment/bundle/control_points.h"
#include "core/flight/remarks/remark_words.h"
#include "core/ground/model_ground.h"
#include "tests/core/alignment/simulated_case.h"
#include "tests/support/rendered_once.h"

namespace skyquilt::alignment {
namespace {

Result<AlignedFlight> Aligned(const simulate::SimulatedFlight& truth, const AlignOptions& options,
                              AlignReport& report) {
  SilentProgress progress;
  return AlignFlight(PosesOf(truth), test::PhotosOf(truth), options, report, progress);
}

TEST(AlignWithControl, LiesWhereSurveyedPointsSayAndNamesTheOneThatIsWrong) {
  const simulate::SimulatedFlight truth = SmallTruth(12, 0.0);
  AlignOptions options;
  options.control = SurveyControl(truth);
  ASSERT_GE(options.control.size(), 5u);
  options.control[1].position.lat_deg += 15.0 / 111'000.0;  // 15 m north of where it is
  AlignReport report;
  const auto aligned = Aligned(truth, options, report);
  ASSERT_TRUE(aligned.ok());
  ASSERT_EQ(report.control.size(), options.control.size());
  EXPECT_FALSE(report.control[1].is_used);
  ASSERT_TRUE(report.control[1].reason);
  EXPECT_EQ(report.control[1].reason->code, flight::RemarkCode::kPointFarFromOthers);
  EXPECT_TRUE(report.control[0].is_used);
  ground::ModelGroundReport ground_report;
  const GroundError error = MeasureGroundError(truth, *aligned, ground::ModelGround(*aligned, ground_report));
  EXPECT_LT(error.absolute_ce90_m, 2.0 * truth.GsdM());
}

TEST(AlignWithControl, LeavesOutAMarkThatTheOthersContradict) {
  const simulate::SimulatedFlight truth = SmallTruth(12, 0.0);
  AlignOptions options;
  options.control = SurveyControl(truth);
  ControlPoint& point = options.control[4];
  ASSERT_GE(point.sightings.size(), 3u);
  ControlSighting& wrong = point.sightings[1];
  wrong.pixel_in_image.x() += wrong.pixel_in_image.x() < 400.0 ? 300.0 : -300.0;
  AlignReport report;
  const auto aligned = Aligned(truth, options, report);
  ASSERT_TRUE(aligned.ok());
  EXPECT_TRUE(report.control[4].is_used);
  EXPECT_EQ(report.control[4].reason, flight::Remark(flight::RemarkCode::kPointMarksElsewhere,
                                                     {{"marks", 1}, {"names", wrong.photo_name}}));
  EXPECT_LT(std::hypot(report.control[4].miss_east_m, report.control[4].miss_north_m), 2.0 * truth.GsdM());
  EXPECT_FALSE(report.control[0].reason);
}

TEST(AlignWithControl, IsNotBentToASurveyThatContradictsThePhotos) {
  const simulate::SimulatedFlight truth = SmallTruth(12, 0.0);
  AlignOptions options;
  options.control = SurveyControl(truth);
  const double errors_m[5][2] = {
      {1.5, 0.0}, {0.0, 2.0}, {-1.8, 0.5}, {0.4, -1.9}, {1.1, 1.2}};  // a hand-held receiver's
  ASSERT_EQ(options.control.size(), 5u);
  for (std::size_t k = 0; k < 5; ++k) {
    options.control[k].position.lat_deg += errors_m[k][0] / 111'000.0;
    options.control[k].position.lon_deg += errors_m[k][1] / 76'000.0;
  }
  AlignReport report;
  const auto aligned = Aligned(truth, options, report);
  ASSERT_TRUE(aligned.ok());
  ASSERT_FALSE(aligned->warnings.empty());
  EXPECT_NE(InWords(aligned->warnings.front()).find("CONTRADICT"), std::string::npos)
      << InWords(aligned->warnings.front());
  ground::ModelGroundReport ground_report;
  const GroundError error = MeasureGroundError(truth, *aligned, ground::ModelGround(*aligned, ground_report));
  EXPECT_LT(error.relative_ce90_m, 1.5 * truth.GsdM());
}

TEST(AlignWithControl, NamesSurveyedPointsThatMissByFar) {
  const simulate::SimulatedFlight truth = SmallTruth(12, 0.0);
  AlignOptions options;
  options.control = SurveyControl(truth);
  options.control[1].position.lat_deg += 1.5 / 111'000.0;
  AlignReport report;
  const auto aligned = Aligned(truth, options, report);
  ASSERT_TRUE(aligned.ok());
  const auto names = [&](const std::string& point) {
    return std::count_if(aligned->warnings.begin(), aligned->warnings.end(), [&](const flight::Remark& said) {
      return InWords(said).find(point + " lies 1.5 m") != std::string::npos;
    });
  };
  EXPECT_EQ(names("point2"), 1);
  EXPECT_EQ(names("point1"), 0);
}

bool IsAnyUsed(const AlignReport& report) {
  return std::any_of(report.control.begin(), report.control.end(),
                     [](const ControlReport& point) { return point.is_used; });
}

std::ptrdiff_t Said(const AlignedFlight& flight, flight::RemarkCode code) {
  return std::count_if(flight.warnings.begin(), flight.warnings.end(),
                       [&](const flight::Remark& said) { return said.code == code; });
}

TEST(AlignWithControl, LeavesOutOfTwoSurveyedPointsTheOneThatThePositionsRefute) {
  const simulate::SimulatedFlight truth = SmallTruth(12, 0.0);
  AlignOptions options;
  options.control = SurveyControl(truth);
  options.control.resize(2);
  options.control[1].position.lat_deg += 100.0 / 111'000.0;
  AlignReport report;
  const auto aligned = Aligned(truth, options, report);
  ASSERT_TRUE(aligned.ok());
  EXPECT_TRUE(report.control[0].is_used);
  EXPECT_FALSE(report.control[1].is_used);
  ASSERT_TRUE(report.control[1].reason);
  EXPECT_EQ(report.control[1].reason->code, flight::RemarkCode::kPointFarFromRecords);
  EXPECT_LT(report.position_bias_m.head<2>().norm(), 10.0);
}

TEST(AlignWithControl, RefusesSurveyedPointsOfAnotherPlace) {
  const simulate::SimulatedFlight truth = SmallTruth(12, 0.0);
  AlignOptions options;
  options.control = SurveyControl(truth);
  for (ControlPoint& point : options.control) {
    point.list = "gcp_list.txt";
    point.position.lon_deg += 12'000.0 / 76'000.0;
  }
  AlignReport report;
  const auto aligned = Aligned(truth, options, report);
  ASSERT_TRUE(aligned.ok());
  EXPECT_FALSE(IsAnyUsed(report));
  EXPECT_EQ(Said(*aligned, flight::RemarkCode::kControlElsewhere), 1) << "once for all points";
  EXPECT_EQ(Said(*aligned, flight::RemarkCode::kControlNotUsed), 0);
  ground::ModelGroundReport ground_report;
  const GroundError error = MeasureGroundError(truth, *aligned, ground::ModelGround(*aligned, ground_report));
  EXPECT_LT(error.absolute_ce90_m, 15.0) << "the map is where its positions say";
}

TEST(AlignWithControl, RefusesMarksThatArePixelsOfSmallerPictures) {
  const simulate::SimulatedFlight truth = SmallTruth(12, 0.0);
  AlignOptions options;
  options.control = SurveyControl(truth);
  for (ControlPoint& point : options.control) {
    for (ControlSighting& mark : point.sightings) mark.pixel_in_image *= 0.5;
  }
  AlignReport report;
  const auto aligned = Aligned(truth, options, report);
  ASSERT_TRUE(aligned.ok());
  EXPECT_FALSE(IsAnyUsed(report));
  EXPECT_EQ(Said(*aligned, flight::RemarkCode::kControlOfOtherPixels), 1);
}

TEST(AlignWithControl, TakesNoHeightThatTheOtherSurveyedPointsContradict) {
  const simulate::SimulatedFlight truth = SmallTruth(12, 0.0);
  AlignOptions options;
  options.control = SurveyControl(truth);
  *options.control[2].height_m += 50.0;
  AlignReport report;
  const auto aligned = Aligned(truth, options, report);
  ASSERT_TRUE(aligned.ok());
  EXPECT_TRUE(report.control[2].is_used);
  ASSERT_TRUE(report.control[2].reason);
  EXPECT_EQ(report.control[2].reason->code, flight::RemarkCode::kPointHeightFarFromOthers);
  EXPECT_EQ(Said(*aligned, flight::RemarkCode::kControlNoted), 1);
}

ControlReport UsedPoint(const std::string& name, double east_m, double up_m) {
  ControlReport point;
  point.name = name;
  point.is_used = true;
  point.miss_east_m = east_m;
  point.miss_up_m = up_m;
  return point;
}

TEST(RemarksOnControl, NameHeightsAndPairsThatMiss) {
  using flight::RemarkCode;
  const std::vector<flight::Remark> high =
      RemarksOn({UsedPoint("a", 0.0, 0.1), UsedPoint("b", 0.0, -9.97), UsedPoint("c", 0.1, 0.0)});
  ASSERT_EQ(high.size(), 1u);
  EXPECT_EQ(high[0].code, RemarkCode::kControlHeightOff);
  EXPECT_NE(InWords(high[0]).find("point b lies 10.0 m above or below"), std::string::npos)
      << InWords(high[0]);
  const std::vector<flight::Remark> pair = RemarksOn({UsedPoint("a", 0.1, 0.0), UsedPoint("b", -9.0, 0.0)});
  ASSERT_EQ(pair.size(), 1u) << "which of two is wrong nothing tells";
  EXPECT_EQ(pair[0].code, RemarkCode::kControlPairDisagrees);
}

}  // namespace
}  // namespace skyquilt::alignment
