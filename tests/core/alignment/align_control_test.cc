// A flight among surveyed points: it lies where they say, and says which of them it cannot believe.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/alignment/bundle/control_points.h"
#include "core/flight/remarks/remark_words.h"
#include "tests/core/alignment/simulated_case.h"

namespace skyquilt::alignment {
namespace {

using flight::RemarkCode;

constexpr double kDegPerMetreNorth = 1.0 / 111'000.0, kDegPerMetreEast = 1.0 / 76'000.0;

// A flight that was aligned by its survey, of which `change` made what the test is about.
struct Surveyed : Outcome {
  simulate::SimulatedFlight truth = SmallTruth(12, 0.0);
  AlignOptions options;

  template <typename Change>
  explicit Surveyed(const Change& change) {
    options.control = SurveyControl(truth);
    EXPECT_EQ(options.control.size(), 5u);
    change(options.control);
    static_cast<Outcome&>(*this) = Align(truth, PosesOf(truth), options);
    EXPECT_EQ(report.control.size(), options.control.size());
    report.control.resize(options.control.size());
  }

  bool IsAnyUsed() const {
    return std::any_of(report.control.begin(), report.control.end(),
                       [](const ControlReport& point) { return point.is_used; });
  }
  std::ptrdiff_t Said(RemarkCode code) const {
    return std::count_if(flight.warnings.begin(), flight.warnings.end(),
                         [&](const flight::Remark& said) { return said.code == code; });
  }
  void ExpectReason(std::size_t point, RemarkCode code) const {
    ASSERT_TRUE(report.control[point].reason);
    EXPECT_EQ(report.control[point].reason->code, code);
  }
};

TEST(AlignWithControl, LiesWhereSurveyedPointsSayAndNamesTheOneThatIsWrong) {
  const Surveyed wrong([](auto& control) { control[1].position.lat_deg += 15.0 * kDegPerMetreNorth; });
  EXPECT_FALSE(wrong.report.control[1].is_used);
  wrong.ExpectReason(1, RemarkCode::kPointFarFromOthers);
  EXPECT_TRUE(wrong.report.control[0].is_used);
  EXPECT_LT(wrong.error.absolute_ce90_m, 2.0 * wrong.truth.GsdM());
}

TEST(AlignWithControl, LeavesOutAMarkThatTheOthersContradict) {
  const Surveyed mistaken([](auto& control) {
    double& pixel_x = control[4].sightings.at(1).pixel_in_image.x();
    pixel_x += pixel_x < 400.0 ? 300.0 : -300.0;
  });
  const std::vector<ControlSighting>& marks = mistaken.options.control[4].sightings;
  ASSERT_GE(marks.size(), 3u);
  const ControlReport& point = mistaken.report.control[4];
  EXPECT_TRUE(point.is_used);
  EXPECT_EQ(point.reason,
            flight::Remark(RemarkCode::kPointMarksElsewhere, {{"marks", 1}, {"names", marks[1].photo_name}}));
  EXPECT_LT(std::hypot(point.miss_east_m, point.miss_north_m), 2.0 * mistaken.truth.GsdM());
  EXPECT_FALSE(mistaken.report.control[0].reason);
}

TEST(AlignWithControl, IsNotBentToASurveyThatContradictsThePhotos) {
  const Surveyed bent([](auto& control) {
    const double errors_m[5][2] = {
        {1.5, 0.0}, {0.0, 2.0}, {-1.8, 0.5}, {0.4, -1.9}, {1.1, 1.2}};  // a hand-held receiver's
    for (std::size_t k = 0; k < 5; ++k) {
      control[k].position.lat_deg += errors_m[k][0] * kDegPerMetreNorth;
      control[k].position.lon_deg += errors_m[k][1] * kDegPerMetreEast;
    }
  });
  ASSERT_FALSE(bent.flight.warnings.empty());
  const std::string first = InWords(bent.flight.warnings.front());
  EXPECT_NE(first.find("CONTRADICT"), std::string::npos) << first;
  EXPECT_LT(bent.error.relative_ce90_m, 1.5 * bent.truth.GsdM());
}

TEST(AlignWithControl, NamesSurveyedPointsThatMissByFar) {
  const Surveyed missed([](auto& control) { control[1].position.lat_deg += 1.5 * kDegPerMetreNorth; });
  const auto names = [&](const std::string& point) {
    return std::count_if(missed.flight.warnings.begin(), missed.flight.warnings.end(),
                         [&](const flight::Remark& said) {
                           return InWords(said).find(point + " lies 1.5 m") != std::string::npos;
                         });
  };
  EXPECT_EQ(names("point2"), 1);
  EXPECT_EQ(names("point1"), 0);
}

TEST(AlignWithControl, LeavesOutOfTwoSurveyedPointsTheOneThatThePositionsRefute) {
  const Surveyed two([](auto& control) {
    control.resize(2);
    control[1].position.lat_deg += 100.0 * kDegPerMetreNorth;
  });
  EXPECT_TRUE(two.report.control[0].is_used);
  EXPECT_FALSE(two.report.control[1].is_used);
  two.ExpectReason(1, RemarkCode::kPointFarFromRecords);
  EXPECT_LT(two.report.position_bias_m.head<2>().norm(), 10.0);
}

TEST(AlignWithControl, RefusesSurveyedPointsOfAnotherPlace) {
  const Surveyed elsewhere([](auto& control) {
    for (ControlPoint& point : control) {
      point.list = "gcp_list.txt";
      point.position.lon_deg += 12'000.0 * kDegPerMetreEast;
    }
  });
  EXPECT_FALSE(elsewhere.IsAnyUsed());
  EXPECT_EQ(elsewhere.Said(RemarkCode::kControlElsewhere), 1) << "once for all points";
  EXPECT_EQ(elsewhere.Said(RemarkCode::kControlNotUsed), 0);
  EXPECT_LT(elsewhere.error.absolute_ce90_m, 15.0) << "the map is where its positions say";
}

TEST(AlignWithControl, RefusesMarksThatArePixelsOfSmallerPictures) {
  const Surveyed halved([](auto& control) {
    for (ControlPoint& point : control) {
      for (ControlSighting& mark : point.sightings) mark.pixel_in_image *= 0.5;
    }
  });
  EXPECT_FALSE(halved.IsAnyUsed());
  EXPECT_EQ(halved.Said(RemarkCode::kControlOfOtherPixels), 1);
}

TEST(AlignWithControl, TakesNoHeightThatTheOtherSurveyedPointsContradict) {
  const Surveyed raised([](auto& control) { *control[2].height_m += 50.0; });
  EXPECT_TRUE(raised.report.control[2].is_used);
  raised.ExpectReason(2, RemarkCode::kPointHeightFarFromOthers);
  EXPECT_EQ(raised.Said(RemarkCode::kControlNoted), 1);
}

TEST(AlignWithControl, TakesNoHeightThatWasLeftEmpty) {
  const Surveyed three([](auto& control) {
    control.resize(3);
    control[1].height_m = 0.0;
  });
  EXPECT_TRUE(three.report.control[1].is_used);
  three.ExpectReason(1, RemarkCode::kPointHeightFarFromOthers);
  EXPECT_EQ(three.Said(RemarkCode::kControlNoted), 1);
  EXPECT_TRUE(std::isnan(three.report.control[1].miss_up_m));
  EXPECT_TRUE(std::isfinite(three.report.control[0].miss_up_m));
  EXPECT_LT(three.report.control[1].residual_px, 8.0) << "it lies where the photos show it";
}

// At 2000 m, a kilometre and a half from the frame's origin: surveyed, marked and recorded without any error.
TEST(TieToControl, IsNoLargerForASurveyInTheMountains) {
  poses::PosedFlight posed;
  posed.frame = geo::LocalFrame({46.0, 8.0, 2000.0});
  const camera::Intrinsics lens = camera::Intrinsics::Centered(2000, 1500, 1400.0);
  const Eigen::Vector3d at_enu(1006.0, 1006.0, 0.0);
  const geo::Wgs84 at = posed.frame.Wgs84FromEnu(at_enu);
  ControlPoint point;
  point.name = "point";
  point.position = {at.lat_deg, at.lon_deg};
  point.height_m = at.height_ellipsoid_m;
  BundleProblem problem;
  problem.lenses.emplace_back();
  problem.lenses[0].recorded = problem.lenses[0].intrinsics = lens;
  Track shown;
  shown.point_in_enu = at_enu;
  for (int i = 0; i < 4; ++i) {
    BundlePhoto photo;
    photo.cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(
        Eigen::Quaterniond(Eigen::AngleAxisd(3.14159265358979, Eigen::Vector3d::UnitX())),
        {i % 2 == 0 ? 1000.0 : 1012.0, i < 2 ? 1000.0 : 1012.0, 60.0});
    photo.prior_cam_from_enu = photo.cam_from_enu;
    photo.height_above_ground_m = 60.0;
    problem.photos.push_back(photo);
    posed.photos.emplace_back().photo.name = "photo" + std::to_string(i);
    const std::optional<Eigen::Vector2d> pixel = lens.Project(photo.cam_from_enu * at_enu);
    ASSERT_TRUE(pixel);
    point.sightings.push_back({posed.photos.back().photo.name, *pixel});
    shown.observations.push_back({i, *pixel, 1.0});
  }
  problem.tracks.push_back(shown);
  std::vector<ControlReport> reports;
  TieToControl(posed, {point}, problem, reports);
  ASSERT_EQ(problem.control.size(), 1u);
  EXPECT_LT(problem.position_bias_m.norm(), 1e-3) << "nothing moves what lies where it was surveyed";
}

TEST(HeightsLeftEmpty, AreZerosThatTwoOthersAndThePhotosContradict) {
  const auto one = HeightsLeftEmpty({130.0, 0.0, 131.0}, {1.0, 0.5, 2.0});
  EXPECT_FALSE(one[0] || one[2]);
  ASSERT_TRUE(one[1]);
  EXPECT_NEAR(*one[1], 129.5, 1e-9);
  EXPECT_TRUE(HeightsLeftEmpty({0.0, 130.0, 0.0, 131.0, 0.0}, {0.5, 1.0, 0.5, 2.0, 0.0})[4])
      << "though most are";
  EXPECT_FALSE(HeightsLeftEmpty({0.0, 3.1, -2.0}, {10.0, 13.0, 8.0})[0]) << "as high as the photos show it";
  EXPECT_FALSE(HeightsLeftEmpty({0.0, 130.0}, {0.5, 1.0})[0]) << "either may be wrong";
  EXPECT_FALSE(HeightsLeftEmpty({std::nullopt, 130.0, 131.0}, {0.5, 1.0, 2.0})[0]);
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
