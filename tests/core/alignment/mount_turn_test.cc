#include <gtest/gtest.h>

#include <numbers>

#include "core/alignment/from_records/correct_poses.h"
#include "core/flight/remarks/remark_words.h"
#include "tests/core/alignment/simulated_case.h"

namespace skyquilt::alignment {
namespace {

using Complex = std::complex<double>;

// A line of photos 12 m apart whose pictures lie turned by `turn` against their records, linked with the next
// two.
struct Line {
  std::vector<PhotoGround> priors;
  std::vector<PhotoPair> pairs;

  explicit Line(double turn, int photos = 8) {
    for (int i = 0; i < photos; ++i) priors.push_back({Complex(4.0 * i, 12.0 * i), 1.5, 0.05});
    const Complex back = std::polar(1.0, -turn);  // from the truth to where a wrongly turned photo puts it
    for (int i = 0; i < photos; ++i) {
      for (int j = i + 1; j < std::min(photos, i + 3); ++j) {
        const Complex m = priors[i].middle;
        const Complex n = priors[j].middle;
        PhotoPair pair;
        pair.first = i;
        pair.second = j;
        pair.second_from_first = {1.0, n - m + back * (m - n)};
        pairs.push_back(pair);
      }
    }
  }
};

TEST(CommonQuarterTurn, FindsEachQuarter) {
  for (const int quarters : {-1, 1, 2}) {
    const Line line(0.5 * std::numbers::pi * quarters + 0.1);
    EXPECT_NEAR(CommonQuarterTurn(line.priors, line.pairs), 0.5 * std::numbers::pi * quarters, 1e-9);
  }
}

TEST(CommonQuarterTurn, LeavesFlightsThatLieRightOrSayNothing) {
  for (const double turn : {0.0, 0.3, 0.8}) {
    const Line line(turn);
    EXPECT_EQ(CommonQuarterTurn(line.priors, line.pairs), 0.0) << turn;
  }
  const Line few(0.5 * std::numbers::pi, 4);
  EXPECT_EQ(CommonQuarterTurn(few.priors, few.pairs), 0.0);
  EXPECT_EQ(CommonQuarterTurn({}, {}), 0.0);
  // Two photos of eight stored turned are theirs alone.
  Line mixed(0.0);
  const Line turned(0.5 * std::numbers::pi);
  mixed.pairs[0] = turned.pairs[0];
  mixed.pairs[1] = turned.pairs[1];
  EXPECT_EQ(CommonQuarterTurn(mixed.priors, mixed.pairs), 0.0);
}

TEST(AlignFlight, TurnsAFlightWhoseCameraIsMountedSideways) {
  simulate::SimulateOptions options;
  options.noise = simulate::NoiseClass::kXmpTypical;
  options.intrinsics = camera::Intrinsics::Centered(800, 600, 750.0);
  options.trajectory.photos = 12;
  options.trajectory.photos_per_line = 4;
  const simulate::SimulatedFlight truth = *simulate::PlanSimulatedFlight(options);
  poses::PosedFlight posed = PosesOf(truth);
  for (poses::PosedPhoto& photo : posed.photos) {
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.5 * std::numbers::pi, Eigen::Vector3d::UnitZ()));
    photo.cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(turn * photo.cam_from_enu.rotation,
                                                                  photo.cam_from_enu.TargetOriginInSource());
  }
  const auto [aligned, report, error] = Align(truth, posed);
  EXPECT_EQ(report.aligned, 12);
  ASSERT_FALSE(report.corrections.empty());
  EXPECT_NE(InWords(report.corrections.front()).find("mounted sideways"), std::string::npos)
      << InWords(report.corrections.front());
  EXPECT_LT(error.relative_ce90_m, 3.0 * truth.GsdM());
}

}  // namespace
}  // namespace skyquilt::alignment
