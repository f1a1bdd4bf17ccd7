#include "core/poses/heights/flight_heights.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "core/flight/remarks/remark_words.h"
#include "core/poses/estimate_poses.h"
#include "core/poses/heights/ground_below.h"
#include "tests/support/value_of.h"

namespace skyquilt::poses {
namespace {

constexpr double kDegPerM = 1.0 / 111'320.0;

// Photos 20 m apart towards north.
std::vector<flight::Photo> Photos(int count, std::optional<double> above_takeoff_m = {},
                                  std::optional<double> ellipsoid_m = {}) {
  std::vector<flight::Photo> photos(static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < photos.size(); ++i) {
    photos[i].intrinsics = camera::Intrinsics::Centered(4000, 3000, 3000.0);
    photos[i].position.emplace();
    photos[i].position->position = {50.8 + 20.0 * kDegPerM * static_cast<double>(i), -0.1};
    photos[i].position->height_above_takeoff_m = above_takeoff_m;
    photos[i].position->height_ellipsoid_m = ellipsoid_m;
  }
  return photos;
}

class FlatDem final : public geo::DemSource {
 public:
  explicit FlatDem(std::optional<double> height_m) : height_m_(height_m) {}
  std::optional<double> GroundHeightM(const geo::LatLon&) const override { return height_m_; }

 private:
  std::optional<double> height_m_;
};

// A receiver that still has its last fix: a quarter of the Earth to the south, from where these steps
// northward point straight down.
TEST(GuessHeightFromSpacing, IsNotMisledByAFirstFixFromElsewhere) {
  std::vector<flight::Photo> photos = Photos(10);
  EXPECT_NEAR(GuessHeightFromSpacing(photos), 80.0, 1.0);
  photos.front().position->position.lat_deg -= 90.0;
  EXPECT_NEAR(GuessHeightFromSpacing(photos), 80.0, 1.0);
}

TEST(ChooseHeights, TakesHeightsAboveTakeoffAsRecorded) {
  std::vector<flight::Photo> photos = Photos(3, 60.0, 145.0);
  const FlightHeights heights = ChooseHeights(photos, nullptr);
  EXPECT_EQ(heights.rule, HeightRule::kAboveTakeoff);
  for (const auto& height_m : heights.above_ground_m) EXPECT_EQ(height_m, 60.0);
  EXPECT_DOUBLE_EQ(heights.takeoff_ellipsoid_m, 85.0);
  EXPECT_TRUE(heights.is_above_ellipsoid);
  EXPECT_FALSE(heights.assumption.has_value());
  for (flight::Photo& photo : photos) photo.position->height_ellipsoid_m.reset();
  EXPECT_FALSE(ChooseHeights(photos, nullptr).is_above_ellipsoid) << "nothing but heights above take-off";
  EXPECT_TRUE(ChooseHeights(photos, nullptr, 85.0).is_above_ellipsoid) << "as given";
  for (flight::Photo& photo : photos)
    photo.position->height_above_ground_m = std::exchange(photo.position->height_above_takeoff_m, {});
  EXPECT_EQ(ChooseHeights(photos, nullptr).rule_in_words, "height above ground as recorded, flat ground");
}

// Debian without proj-data, say.
TEST(TellLackOfGeoid, SaysThatHeightsAboveTheSeaCountAsIfAboveTheEllipsoid) {
  std::vector<flight::Photo> of_sea = Photos(3, 60.0);
  for (flight::Photo& photo : of_sea) photo.position->height_amsl_m = 145.0;
  const std::vector<flight::Photo> of_ellipsoid = Photos(3, 60.0, 190.0);
  flight::FlightLog track;
  track.gnss.emplace_back().height_amsl_m = 145.0;
  const auto is_said = [](const std::optional<double>& geoid_m, const std::vector<flight::Photo>& photos,
                          const flight::FlightLog* log, bool is_zero_of_sea) {
    PosedFlight posed;
    posed.report.heights_above_ellipsoid = true;
    TellLackOfGeoid(geoid_m, photos, log, is_zero_of_sea, posed);
    EXPECT_EQ(posed.report.heights_above_ellipsoid.has_value(), posed.warnings.empty());
    return !posed.warnings.empty() && posed.warnings[0].code == flight::RemarkCode::kNoGeoid;
  };
  EXPECT_TRUE(is_said({}, of_sea, nullptr, false));
  EXPECT_FALSE(is_said(45.0, of_sea, nullptr, false));
  EXPECT_FALSE(is_said({}, of_ellipsoid, nullptr, false));
  EXPECT_TRUE(is_said({}, of_ellipsoid, nullptr, true)) << "over an elevation model, or a take-off as given";
  EXPECT_TRUE(is_said({}, of_ellipsoid, &track, false));
  PosedFlight from_takeoff;
  from_takeoff.report.heights_above_ellipsoid = false;
  TellLackOfGeoid({}, of_sea, nullptr, false, from_takeoff);
  EXPECT_TRUE(from_takeoff.warnings.empty());
}

TEST(ChooseHeights, TiesAPhotoWithoutRelativeHeightToTheOthersThroughItsAbsoluteOne) {
  std::vector<flight::Photo> photos = Photos(4, 60.0, 145.0);
  photos[2].position->height_above_takeoff_m.reset();
  photos[2].position->height_ellipsoid_m = 150.0;
  photos[3].position->height_above_takeoff_m = 0.0;  // a field that is never filled
  photos[3].position->height_ellipsoid_m.reset();
  const FlightHeights heights = ChooseHeights(photos, nullptr);
  EXPECT_EQ(heights.above_ground_m[2], 65.0);
  EXPECT_FALSE(heights.above_ground_m[3].has_value());
}

TEST(ChooseHeights, KeepsPhotosBelowTheTakeoffForAnElevationModel) {
  std::vector<flight::Photo> photos = Photos(4);
  const double above_takeoff_m[] = {40.0, 15.0, -12.0, -35.0};
  for (std::size_t i = 0; i < photos.size(); ++i) {
    photos[i].position->height_above_takeoff_m = above_takeoff_m[i];
    photos[i].position->height_ellipsoid_m = 500.0 + above_takeoff_m[i];
  }
  const FlightHeights heights = ChooseHeights(photos, nullptr);
  for (std::size_t i = 0; i < photos.size(); ++i) EXPECT_EQ(heights.above_ground_m[i], above_takeoff_m[i]);
  EXPECT_DOUBLE_EQ(heights.takeoff_ellipsoid_m, 500.0);
  // Of another take-off: its absolute height says where it was.
  photos[2].position->height_ellipsoid_m = 588.0;
  EXPECT_EQ(ChooseHeights(photos, nullptr).above_ground_m[2], 88.0);
}

// Falls by a twentieth towards north.
class FallingDem final : public geo::DemSource {
 public:
  std::optional<double> GroundHeightM(const geo::LatLon& at) const override {
    return 500.0 - 0.05 * (at.lat_deg - 50.8) / kDegPerM;
  }
};

TEST(ChooseHeights, PhotosBelowTheTakeoffLieOverAnElevationModel) {
  flight::Flight flight;
  flight.photos = Photos(5);
  for (std::size_t i = 0; i < flight.photos.size(); ++i) {
    flight.photos[i].name = "IMG_" + std::to_string(i) + ".JPG";
    flight.photos[i].position->position.lat_deg = 50.8 + 280.0 * kDegPerM * static_cast<double>(i);
    flight.photos[i].position->height_above_takeoff_m = 30.0 - 14.0 * static_cast<double>(i);
  }
  const FallingDem dem;
  EstimatePosesOptions options;
  const auto without = test::ValueOf(EstimatePoses(flight, options));
  ASSERT_FALSE(without.left_out.empty());
  EXPECT_NE(InWords(without.left_out.back().reason).find("--dem"), std::string::npos);
  options.dem = &dem;
  const auto over_model = test::ValueOf(EstimatePoses(flight, options));
  ASSERT_EQ(over_model.photos.size(), 5u);
  for (const PosedPhoto& photo : over_model.photos) EXPECT_NEAR(photo.height_above_ground_m, 30.0, 2.0);
}

// 85 m up to 50 m north of the first photo.
class SouthernDem final : public geo::DemSource {
 public:
  std::optional<double> GroundHeightM(const geo::LatLon& at) const override {
    ++asked_;
    if (at.lat_deg > 50.8 + 50.0 * kDegPerM) return std::nullopt;
    return 85.0;
  }
  std::size_t asked() const { return asked_; }

 private:
  mutable std::size_t asked_ = 0;
};

TEST(TellGapsOfDem, SaysBelowHowManyOfThePhotosInTheMapTheModelHasNoHeight) {
  flight::Flight flight;
  flight.photos = Photos(6, 60.0);
  for (std::size_t i = 0; i < flight.photos.size(); ++i)
    flight.photos[i].name = "IMG_" + std::to_string(i) + ".JPG";
  flight.photos[5].position->position.lat_deg = 60.8;  // left out
  const SouthernDem southern;
  const FlatDem whole(85.0);
  const auto times_said = [&flight](const geo::DemSource& dem) {
    EstimatePosesOptions options;
    options.dem = &dem;
    const auto posed = test::ValueOf(EstimatePoses(flight, options));
    EXPECT_TRUE(posed.dem_zero_m);
    EXPECT_EQ(posed.photos.size(), 5u);
    const flight::Remark said{flight::RemarkCode::kElevationModelInPart, {{"photos", 2}, {"total", 5}}};
    return std::count(posed.warnings.begin(), posed.warnings.end(), said);
  };
  EXPECT_EQ(times_said(southern), 1);
  EXPECT_LE(southern.asked(), flight.photos.size() + 1) << "once below each, and at take-off";
  EXPECT_EQ(times_said(whole), 0);
}

TEST(ChooseHeights, LetsSurveyedHeightsDifferAsTheyWereMeasured) {
  std::vector<flight::Photo> photos = Photos(3);
  const double ellipsoid_m[] = {145.0, 145.4, 144.7};
  for (std::size_t i = 0; i < 3; ++i) {
    photos[i].position->height_above_takeoff_m = 60.0;
    photos[i].position->height_ellipsoid_m = ellipsoid_m[i];
    photos[i].position->is_rtk_fixed = true;
  }
  const FlightHeights heights = ChooseHeights(photos, nullptr);
  EXPECT_NEAR(*heights.above_ground_m[1] - *heights.above_ground_m[2], 0.7, 1e-9);
  EXPECT_NEAR(*heights.above_ground_m[0], 60.0, 1e-9);
}

TEST(ChooseHeights, PutsAbsoluteHeightsOverTheElevationModel) {
  std::vector<flight::Photo> photos = Photos(3);
  for (flight::Photo& photo : photos) photo.position->height_amsl_m = 140.0;
  const FlatDem dem(85.0);
  const FlightHeights heights = ChooseHeights(photos, &dem);
  EXPECT_EQ(heights.rule, HeightRule::kElevationModel);
  for (const auto& height_m : heights.above_ground_m) EXPECT_NEAR(*height_m, 55.0, 0.2);
}

TEST(ChooseHeights, DoesNotTakeAnElevationModelAboveTheCameras) {
  std::vector<flight::Photo> photos = Photos(3);
  for (flight::Photo& photo : photos) photo.position->height_amsl_m = 140.0;
  const FlatDem above(138.0), nowhere(std::nullopt);
  EXPECT_EQ(ChooseHeights(photos, &above).rule, HeightRule::kSpacing);
  EXPECT_EQ(ChooseHeights(photos, &nowhere).rule, HeightRule::kSpacing);
}

TEST(ChooseHeights, GuessesFromTheSpacingAndWarns) {
  std::vector<flight::Photo> photos = Photos(6);
  const FlightHeights heights = ChooseHeights(photos, nullptr);
  EXPECT_EQ(heights.rule, HeightRule::kSpacing);
  // Steps of a quarter of the picture's shorter side: 20 m / 0.25 * 3000 px / 3000 px.
  for (const auto& height_m : heights.above_ground_m) EXPECT_NEAR(*height_m, 80.0, 0.5);
  ASSERT_TRUE(heights.assumption.has_value());
  EXPECT_NEAR(*heights.assumption->height_above_ground_m, 80.0, 0.5);
  EXPECT_NE(InWords(heights.assumption->assumed).find("80 m is assumed"), std::string::npos)
      << InWords(heights.assumption->assumed);
}

TEST(ChooseHeights, TakesPhotosWithoutAnyPosition) {
  std::vector<flight::Photo> photos = Photos(2);
  for (flight::Photo& photo : photos) photo.position.reset();
  const FlightHeights heights = ChooseHeights(photos, nullptr);
  for (const auto& height_m : heights.above_ground_m) EXPECT_FALSE(height_m.has_value());
  EXPECT_EQ(ChooseHeights({}, nullptr).above_ground_m.size(), 0u);
}

TEST(ChooseHeights, CountsFromAGivenTakeoffInsteadOfWhatIsRecordedOfIt) {
  std::vector<flight::Photo> photos = Photos(4, 60.0, 245.0);  // a hundred metres too high
  photos[3].position->height_above_takeoff_m.reset();
  photos[3].position->height_ellipsoid_m = 250.0;
  const FlightHeights heights = ChooseHeights(photos, nullptr, 85.0);
  EXPECT_EQ(heights.rule, HeightRule::kAboveTakeoff);
  EXPECT_DOUBLE_EQ(heights.takeoff_ellipsoid_m, 85.0);
  EXPECT_EQ(heights.above_ground_m[0], 60.0);
  EXPECT_EQ(heights.above_ground_m[3], 65.0) << "against the others, whose error it shares";
}

TEST(ChooseHeights, CountsAbsoluteHeightsFromAGivenTakeoffBesidePhotosThatHaveNone) {
  std::vector<flight::Photo> photos = Photos(4, 60.0);
  photos[3].position->height_above_takeoff_m.reset();
  photos[3].position->height_ellipsoid_m = 150.0;
  EXPECT_FALSE(ChooseHeights(photos, nullptr).above_ground_m[3].has_value());
  const FlightHeights heights = ChooseHeights(photos, nullptr, 85.0);
  EXPECT_EQ(heights.above_ground_m[0], 60.0);
  EXPECT_EQ(heights.above_ground_m[3], 65.0);
}

TEST(ChooseHeights, PutsAbsoluteHeightsOverAGivenTakeoff) {
  const std::vector<flight::Photo> photos = Photos(3, std::nullopt, 145.0);
  const FlightHeights heights = ChooseHeights(photos, nullptr, 85.0);
  EXPECT_EQ(heights.rule, HeightRule::kAboveTakeoff);
  EXPECT_FALSE(heights.assumption.has_value());
  for (const auto& height_m : heights.above_ground_m) EXPECT_DOUBLE_EQ(height_m.value_or(0.0), 60.0);
  EXPECT_EQ(ChooseHeights(photos, nullptr, 300.0).rule, HeightRule::kSpacing)
      << "a take-off above the cameras";
}

// Three photos 20 m apart at the height of the ground.
PosedFlight OnTheGround() {
  PosedFlight posed;
  posed.frame = geo::LocalFrame({50.8, -0.1, 0.0});
  for (int i = 0; i < 3; ++i) {
    PosedPhoto& photo = posed.photos.emplace_back();
    photo.photo.intrinsics = camera::Intrinsics::Centered(4000, 3000, 3000.0);
    photo.cam_from_enu =
        geo::Rigid3::FromRotationAndTargetOrigin(Eigen::Quaterniond::Identity(), {0.0, 20.0 * i, 0.0});
  }
  return posed;
}

TEST(PutGroundBelow, SaysThatHeightsContradictOnlyWhereSomeAreRecorded) {
  PosedFlight recorded = OnTheGround();
  PutGroundBelow(recorded);
  ASSERT_EQ(recorded.assumptions.size(), 1U);
  EXPECT_EQ(recorded.assumptions[0].missing.code, flight::RemarkCode::kOnTheGround);
  // A track without heights.
  PosedFlight untold = OnTheGround();
  untold.report.is_height_guessed = true;
  untold.assumptions.push_back(
      {flight::RemarkCode::kNoHeights, {flight::RemarkCode::kHeightBySpacing, {{"height_m", 50.0}}}, 50.0});
  PutGroundBelow(untold);
  EXPECT_NEAR(untold.photos[1].height_above_ground_m, 80.0, 0.1);
  ASSERT_EQ(untold.assumptions.size(), 1U);
  EXPECT_EQ(untold.assumptions[0].missing.code, flight::RemarkCode::kNoHeights);
  EXPECT_NEAR(untold.assumptions[0].height_above_ground_m.value_or(0.0), 80.0, 0.1);
  EXPECT_NE(flight::InWords(untold.assumptions[0].assumed).find("80 m is assumed"), std::string::npos);
}

}  // namespace
}  // namespace skyquilt::poses
