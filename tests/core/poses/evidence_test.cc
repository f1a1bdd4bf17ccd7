// What recorded positions are taken to have in common.
#include <gmock/gmock.h>

#include <chrono>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "core/flight/logs/flight_log.h"
#include "core/flight/remarks/remark_words.h"
#include "core/poses/estimate_poses.h"
#include "core/poses/evidence/assumption.h"
#include "core/poses/evidence/common_error.h"
#include "core/poses/evidence/position_jump.h"
#include "core/poses/evidence/repeated_positions.h"
#include "tests/support/value_of.h"

namespace skyquilt::poses {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kMetresOfDegree = 111195.0;  // of a round Earth

std::vector<flight::GnssSample> Fixes(int count, bool is_rtk, std::optional<double> sigma_m) {
  flight::GnssSample one;
  one.is_rtk_fixed = is_rtk;
  one.sigma_horizontal_m = sigma_m;
  return std::vector<flight::GnssSample>(static_cast<std::size_t>(count), one);
}

std::vector<flight::GnssSample> operator+(std::vector<flight::GnssSample> a,
                                          const std::vector<flight::GnssSample>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

TEST(CommonError, IsAssumedWhereNothingStatesIt) {
  EXPECT_EQ(CommonErrorOf(Fixes(9, false, std::nullopt)), (CommonError{false, 1.5}));
  EXPECT_EQ(CommonErrorOf(Fixes(9, true, std::nullopt)), (CommonError{true, 0.02}));
  EXPECT_EQ(CommonErrorOf(std::vector<flight::GnssSample>()), CommonError());
}

TEST(CommonError, IsWhatMostPositionsStateWithinReason) {
  EXPECT_EQ(CommonErrorOf(Fixes(9, false, 4.0)), (CommonError{false, 4.0}));
  EXPECT_EQ(CommonErrorOf(Fixes(9, false, 0.2)), (CommonError{false, 0.3}));
  EXPECT_EQ(CommonErrorOf(Fixes(9, false, 1e9)), (CommonError{false, 15.0}));
  EXPECT_EQ(CommonErrorOf(Fixes(9, true, 0.05)), (CommonError{true, 0.05}));
  EXPECT_EQ(CommonErrorOf(Fixes(9, true, 0.001)), (CommonError{true, 0.02}));
  // A list computed afterwards (PPK) names no fix, and states centimetres.
  EXPECT_EQ(CommonErrorOf(Fixes(9, false, 0.03)), (CommonError{true, 0.03}));
  // One of ten speaks for itself alone.
  EXPECT_EQ(CommonErrorOf(Fixes(9, false, std::nullopt) + Fixes(1, true, 0.01)), (CommonError{false, 1.5}));
  // No receiver knows its place so well: these are no statements.
  for (const double sigma_m : {-1.0, 0.0, 1e-6, 0.001}) {
    EXPECT_EQ(CommonErrorOf(Fixes(9, false, sigma_m)), (CommonError{false, 1.5})) << sigma_m;
  }
}

// North by 20 m a photo, two seconds apart; each writes where the first of its `group` was.
std::vector<flight::Photo> RepeatingPhotos(int count, int group) {
  std::vector<flight::Photo> photos(static_cast<std::size_t>(count));
  for (int k = 0; k < count; ++k) {
    flight::Photo& photo = photos[static_cast<std::size_t>(k)];
    photo.captured_at = flight::UtcTime(std::chrono::seconds(1717243200 + 2 * k));
    photo.position.emplace().position = {47.4 + 20.0 * (k / group * group) / kMetresOfDegree, 8.5};
  }
  return photos;
}

// Nine photos of three fixes: what each third photo says is true, the others go on from it.
TEST(RepeatedPositions, CountOnceAndMoveOnToTheNext) {
  std::vector<flight::Photo> photos = RepeatingPhotos(9, 3);
  const auto remark = test::ValueOf(MoveRepeatedPositions(photos));
  EXPECT_THAT(flight::InWords(remark), HasSubstr("6 of 9 photos repeat the position"));
  for (int k = 0; k < 9; ++k) {
    const flight::RecordedPosition& position = *photos[static_cast<std::size_t>(k)].position;
    EXPECT_EQ(position.is_repeated, k % 3 != 0) << k;
    EXPECT_EQ(position.sigma_horizontal_m.has_value(), position.is_repeated) << k;
    const double north_m = (position.position.lat_deg - 47.4) * kMetresOfDegree;
    EXPECT_NEAR(north_m, 20.0 * (k < 6 ? k : 6), 0.01) << k;  // after the last nothing says where to
    EXPECT_NEAR(position.sigma_horizontal_m.value_or(0.0), 20.0 * (k % 3), 0.3) << k;
  }
}

TEST(RepeatedPositions, AreNoneOfPhotosOfOneMomentNorOfSeveralCameras) {
  std::vector<flight::Photo> moving = RepeatingPhotos(6, 1);
  EXPECT_FALSE(MoveRepeatedPositions(moving));
  std::vector<flight::Photo> bursts = RepeatingPhotos(6, 3);
  for (std::size_t k = 0; k < bursts.size(); ++k) bursts[k].captured_at = bursts[k / 3 * 3].captured_at;
  EXPECT_FALSE(MoveRepeatedPositions(bursts));
  std::vector<flight::Photo> cameras = RepeatingPhotos(6, 3);
  for (std::size_t k = 0; k < cameras.size(); ++k) cameras[k].camera_key = "ABC"[k % 3];
  EXPECT_FALSE(MoveRepeatedPositions(cameras));
  std::vector<flight::Photo> twice = RepeatingPhotos(6, 2);
  for (flight::Photo& photo : twice) photo.captured_at.reset();
  EXPECT_FALSE(MoveRepeatedPositions(twice)) << "without times a pair may be one picture twice";
}

// All at one place: nothing says that they moved, nor by how much, and one position is what there is.
TEST(RepeatedPositions, StayWhereAllAreOne) {
  std::vector<flight::Photo> photos = RepeatingPhotos(5, 5);
  ASSERT_TRUE(MoveRepeatedPositions(photos));
  EXPECT_FALSE(photos[0].position->is_repeated);
  EXPECT_TRUE(photos[4].position->is_repeated);
  EXPECT_EQ(photos[4].position->position.lat_deg, 47.4);
}

TEST(RepeatedPositions, HoldNoPhotoOfAFlight) {
  flight::Flight flight;
  flight.photos = RepeatingPhotos(9, 3);
  for (flight::Photo& photo : flight.photos) {
    photo.name = "IMG_" + std::to_string(&photo - flight.photos.data()) + ".JPG";
    photo.intrinsics = camera::Intrinsics::Centered(4000, 3000, 3665.0);
    photo.position->height_above_takeoff_m = 60.0;
  }
  const auto posed = test::ValueOf(EstimatePoses(flight, {}));
  ASSERT_EQ(posed.photos.size(), 9u);
  EXPECT_THAT(flight::InWords(posed.warnings), Contains(HasSubstr("6 of 9 photos repeat the position")));
  EXPECT_LT(posed.photos[0].covariance(3, 3), 3.0);
  EXPECT_GT(posed.photos[1].covariance(3, 3), 300.0);
  EXPECT_TRUE(posed.photos[1].photo.position->is_repeated);
}

const std::vector<Assumption> kBoth = {
    {"No height is recorded.", "91 m is assumed.", 91.0},
    {"No angles are recorded.", "Straight down is assumed.", std::nullopt}};

TEST(Assumption, StandsWherePosesAlonePlaceThePhotos) {
  EXPECT_EQ(InWords(AssumptionsByPoses(kBoth)).front(), "No height is recorded. 91 m is assumed.");
}

TEST(Assumption, IsNotStatedAsAFactWhereThePhotosShowedBetter) {
  const std::vector<std::string> words = InWords(AssumptionsAfterAlignment(kBoth, 40.2, 0));
  EXPECT_THAT(words, ElementsAre(HasSubstr("it was 40 m"), HasSubstr("found from what they show")));
  for (const std::string& one : words) EXPECT_THAT(one, Not(HasSubstr("is assumed")));
}

TEST(Assumption, StillHoldsForPhotosByPoseAlone) {
  EXPECT_THAT(InWords(AssumptionsAfterAlignment(kBoth, 40.2, 3)),
              ElementsAre(HasSubstr("For the 3 photos"), HasSubstr("Straight down is assumed.")));
}

// What a map that bends at it is missed by.
std::vector<Eigen::Vector2d> MissesAround(double jump_m, double noise_m) {
  std::vector<Eigen::Vector2d> misses;
  for (int i = 0; i < 40; ++i) {
    const double to_jump = i - 19.5;
    const double bent_m = -std::copysign(0.5 * jump_m * std::exp(-std::abs(to_jump) / 4.0), to_jump);
    misses.emplace_back(bent_m + noise_m * std::sin(12.0 * i), noise_m * std::cos(17.0 * i));
  }
  return misses;
}

TEST(JumpOf, FindsWhereCorrectedPositionsBeginToLieElsewhere) {
  const auto jump = test::ValueOf(JumpOf(MissesAround(0.5, 0.005), 0.02));
  EXPECT_EQ(jump.last_before, 19u);
  EXPECT_NEAR(jump.by_m, 0.35, 0.05);
  EXPECT_FALSE(JumpOf(MissesAround(0.0, 0.005), 0.02));
  EXPECT_FALSE(JumpOf(MissesAround(0.5, 0.1), 0.02)) << "no more than they scatter";
  EXPECT_FALSE(JumpOf(MissesAround(0.5, 0.005), 1.5)) << "a receiver that claims no more";
}

TEST(JumpOf, TakesOneWrongPositionForNoJump) {
  std::vector<Eigen::Vector2d> misses = MissesAround(0.0, 0.005);
  misses[10].x() += 5.0;
  EXPECT_FALSE(JumpOf(misses, 0.02));
  EXPECT_FALSE(JumpOf({}, 0.02));
  EXPECT_FALSE(JumpOf({misses[9], misses[10]}, 0.02));
}

// Lines flown to and fro, 60 m up.
std::vector<Eigen::Vector3d> LinesOf(int lines, int photos_of_line) {
  std::vector<Eigen::Vector3d> cameras;
  for (int i = 0; i < lines * photos_of_line; ++i) {
    const int line = i / photos_of_line, along = i % photos_of_line;
    cameras.emplace_back(10.0 * (line % 2 == 0 ? along : photos_of_line - 1 - along), 20.0 * line, 60.0);
  }
  return cameras;
}

// By what `miss_m` says of the photo of that number, give or take 4 mm; of a receiver that claims 4 cm.
template <typename MissM>
std::optional<PositionJump> JumpUp(const std::vector<Eigen::Vector3d>& cameras, const MissM& miss_m,
                                   double claimed_m = 0.04) {
  std::vector<double> misses_m;
  for (int i = 0; i < std::ssize(cameras); ++i) misses_m.push_back(miss_m(i) + 0.004 * std::sin(12.0 * i));
  return HeightJumpOf(cameras, misses_m, claimed_m);
}

TEST(HeightJumpOf, FindsWhereCorrectedHeightsBeginToLieElsewhere) {
  const auto cameras = LinesOf(6, 8);
  const auto at = [](int first) { return [first](int i) { return i < first ? -0.25 : 0.25; }; };
  const auto within_line = test::ValueOf(JumpUp(cameras, at(20)));
  EXPECT_NEAR(static_cast<double>(within_line.last_before), 19.0, 1.0);
  EXPECT_NEAR(within_line.by_m, 0.45, 0.03);
  EXPECT_TRUE(JumpUp(cameras, at(24))) << "at a turn";
  EXPECT_FALSE(JumpUp(cameras, at(20), 1.5)) << "a receiver that claims no more";
  const auto bent = test::ValueOf(JumpUp(
      cameras, [](int i) { return std::copysign(0.25 * std::exp(-std::abs(i - 23.5) / 4.0), i - 23.5); }));
  EXPECT_EQ(bent.last_before, 23u);
  EXPECT_NEAR(bent.by_m, 0.34, 0.03);
  EXPECT_TRUE(JumpUp(LinesOf(10, 12), [](int i) { return i >= 50 && i < 75 ? 0.5 : 0.0; }))
      << "there and back";
}

TEST(HeightJumpOf, TakesTheShapeOfAMapForNoJump) {
  const auto cameras = LinesOf(6, 8);
  EXPECT_FALSE(JumpUp(cameras, [&](int i) { return 1e-3 * (cameras[i].head<2>().squaredNorm()); }))
      << "a bowl";
  EXPECT_FALSE(JumpUp(cameras, [&](int i) { return 1e-5 * std::pow(cameras[i].y() - 50.0, 3); }));
  EXPECT_FALSE(JumpUp(cameras, [](int i) { return i / 8 % 2 == 0 ? -0.25 : 0.25; })) << "line by line";
  EXPECT_FALSE(JumpUp(cameras, [](int i) { return 0.8 * std::sin(0.13 * i); })) << "a drift";
  EXPECT_FALSE(JumpUp(LinesOf(4, 8), [](int i) { return i < 16 ? -0.25 : 0.25; }))
      << "or a bend: nothing tells";
  EXPECT_FALSE(HeightJumpOf({}, {}, 0.04));
}

TEST(HeightJumpOf, TakesWhatAWrongScaleMakesOfAClimbForNoJump) {
  auto cameras = LinesOf(6, 8);
  const auto miss_m = [](int i) { return i < 20 ? -0.2 : 0.2; };
  EXPECT_TRUE(JumpUp(cameras, miss_m));
  for (std::size_t i = 20; i < cameras.size(); ++i) cameras[i].z() += 20.0;
  EXPECT_FALSE(JumpUp(cameras, miss_m));
}

}  // namespace
}  // namespace skyquilt::poses
