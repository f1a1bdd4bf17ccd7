#include "core/pipeline/report/flight_facts.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "core/pipeline/build_bands.h"
#include "core/pipeline/placing/recall_flight.h"
#include "tests/core/pipeline/full_reports.h"
#include "tests/support/value_of.h"

namespace skyquilt::pipeline {
namespace {

FlightFacts SomeFacts() {
  FlightFacts facts;
  facts.options = DigestOfPlacing({});
  facts.asked = MosaicOptions{}.InWords();
  facts.inputs = {{{"DJI_1.JPG", "/card/DJI_1.JPG"}, Digest{1, 2, 3}}, {{"n\xff.csv", "/card/n"}, Digest{4}}};
  facts.flight.frame = geo::LocalFrame({46.8, 7.1, 512.25});
  facts.flight.ground_z_in_enu_m = -0.125;
  facts.flight.warnings = {"a warning"};
  facts.flight.left_out = {{"n\xff.csv", ErrorCode::kCorrupt, "no photo"}};
  alignment::AlignedPhoto photo;
  photo.photo.name = "DJI_1.JPG";
  photo.photo.camera_key = "key";
  photo.intrinsics = camera::Intrinsics::Centered(800, 600, 700.0 / 3.0);
  photo.cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(
      Eigen::Quaterniond(0.1, 0.7, -0.7, 0.02).normalized(), {1.0 / 3.0, -20.1, 60.7});
  photo.placement = alignment::Placement::kAligned;
  photo.height_above_ground_m = 60.0 / 7.0;
  photo.readout_motion = {{1.0 / 3.0, -0.2, 1e-9},
                          {{0.1, -1.0 / 3.0, 1e-9}, {0.0, 0.0, 0.0}, {0.2, 0.1, 0.0}}};
  facts.flight.photos = {photo};
  facts.ground = ground::GroundSurface::Grid({-1.0, -2.0}, 0.3, 2, 2, {0.1F, 0.2F, 0.3F, 0.4F}, 0.25);
  facts.thumbnails = {{"DJI_1.JPG", 4, 3, {1, 2, 250}}};
  facts.poses_report = FullPoseReport();
  facts.ground_report = FullGroundReport();
  facts.ground_choice = GroundChoice{0.125, 0.75};
  facts.align_report = FullAlignReport();
  MapAppearance shown;
  shown.gsd_m = 0.031;
  shown.is_gsd_asked = true;
  shown.exposure.photos = {{{0.9, 1.0 / 3.0, 1.1}, {0.01, 0.0, 1.0 / 3.0}}};
  shown.exposure.light.cameras["key"][1][3] = -0.2;
  shown.exposure.light.of_directions[2][13] = 1.0 / 7.0;
  shown.exposure.light.directions = {Eigen::Vector2d(0.3, -0.1), 0.7};
  shown.grid = {19, 256, 32, 100'000'000'000, -5, 70, 3};
  shown.labels = render::SeamLabels(70, 3);
  shown.labels.Set(69, 2, 0);
  shown.labels.Set(3, 1, 0);
  facts.appearance = shown;
  facts.seams = render::SeamShift{120, 90, 0.031, 1.0 / 3.0, 0.7};
  return facts;
}

TEST(FlightFacts, AreReadAgainExactly) {
  const FlightFacts facts = SomeFacts();
  const auto read = test::ValueOf(ParseFacts(WriteFacts(facts)));
  EXPECT_EQ(read.options, facts.options);
  EXPECT_EQ(read.asked, facts.asked);
  ASSERT_EQ(read.inputs.size(), 2U);
  EXPECT_EQ(read.inputs[1].file.name, "n\xff.csv");
  EXPECT_EQ(read.inputs[0].digest, facts.inputs[0].digest);
  EXPECT_EQ(read.flight.left_out.front().code, ErrorCode::kCorrupt);
  const alignment::AlignedPhoto &now = read.flight.photos.front(), &was = facts.flight.photos.front();
  EXPECT_EQ(now.intrinsics, was.intrinsics);
  EXPECT_EQ(now.cam_from_enu.rotation.coeffs(), was.cam_from_enu.rotation.coeffs());
  EXPECT_EQ(now.cam_from_enu.translation, was.cam_from_enu.translation);
  EXPECT_EQ(now.height_above_ground_m, was.height_above_ground_m);
  EXPECT_EQ(now.readout_motion, was.readout_motion);
  EXPECT_EQ(read.ground.Heights(), facts.ground.Heights());
  EXPECT_EQ(read.thumbnails.front().jpeg, facts.thumbnails.front().jpeg);
  EXPECT_EQ(read.poses_report, facts.poses_report);
  EXPECT_EQ(read.ground_report, facts.ground_report);
  EXPECT_EQ(read.ground_choice, facts.ground_choice);
  EXPECT_EQ(read.align_report, facts.align_report);
  EXPECT_EQ(read.seams, facts.seams);
  ASSERT_TRUE(read.appearance);
  EXPECT_TRUE(read.appearance->is_gsd_asked);
  EXPECT_EQ(read.appearance->exposure.photos, facts.appearance->exposure.photos);
  EXPECT_EQ(read.appearance->exposure.light, facts.appearance->exposure.light);
  EXPECT_EQ(read.appearance->grid.first_column, facts.appearance->grid.first_column);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 70; ++column) {
      EXPECT_EQ(read.appearance->labels.At(column, row), facts.appearance->labels.At(column, row));
    }
  }
}

// A list placed the first, the second has no place; EXIF says otherwise of both.
TEST(FlightFacts, KeepThePositionsThatPlacedThePhotos) {
  FlightFacts facts = SomeFacts();
  flight::RecordedPosition listed;
  listed.position = {46.8 + 1.0 / 3.0, 7.1};
  listed.height_ellipsoid_m = 512.0 / 7.0;
  listed.sigma_horizontal_m = 0.01 / 3.0;
  listed.is_rtk_fixed = true;
  facts.flight.photos.resize(2, facts.flight.photos[0]);
  facts.flight.photos[0].photo.position = listed;
  facts.flight.photos[1].photo.name = "DJI_2.JPG";
  facts.thumbnails.resize(2, facts.thumbnails[0]);
  flight::Flight read;
  for (const alignment::AlignedPhoto& photo : facts.flight.photos) {
    flight::Photo& own = read.photos.emplace_back(photo.photo);
    own.path = "/now/" + own.name;
    own.position.emplace().position = {46.9, 7.2};
  }
  auto recalled = test::ValueOf(ParseFacts(WriteFacts(facts)));
  FillPhotos(read, recalled.flight);
  EXPECT_EQ(recalled.flight.photos[0].photo.path, "/now/DJI_1.JPG");
  const auto& kept = recalled.flight.photos[0].photo.position;
  ASSERT_TRUE(kept);
  EXPECT_EQ(kept->position.lat_deg, listed.position.lat_deg);
  EXPECT_EQ(kept->position.lon_deg, listed.position.lon_deg);
  EXPECT_EQ(kept->height_ellipsoid_m, listed.height_ellipsoid_m);
  EXPECT_EQ(kept->sigma_horizontal_m, listed.sigma_horizontal_m);
  EXPECT_FALSE(kept->height_amsl_m);
  EXPECT_TRUE(kept->is_rtk_fixed);
  EXPECT_FALSE(recalled.flight.photos[1].photo.position);

  for (alignment::AlignedPhoto& photo : facts.flight.photos) photo.photo.position.reset();
  auto of_before = test::ValueOf(ParseFacts(WriteFacts(facts)));
  FillPhotos(read, of_before.flight);
  EXPECT_TRUE(of_before.flight.photos[0].photo.position) << "an earlier version kept none";
}

// Two fields some tens of kilometres apart: between them lie more cells than 32 bits count.
TEST(FlightFacts, KeepTheLabelsOfFieldsFarApart) {
  FlightFacts facts = SomeFacts();
  MapAppearance& shown = *facts.appearance;
  shown.grid.columns = 1'100'000;
  shown.grid.rows = 2'000;
  shown.labels = render::SeamLabels(shown.grid.columns, shown.grid.rows);
  shown.labels.Set(5, 0, 0);
  shown.labels.Set(1'099'999, 1'999, 0);
  const auto read = test::ValueOf(ParseFacts(WriteFacts(facts)));
  ASSERT_TRUE(read.appearance);
  const render::SeamLabels& labels = read.appearance->labels;
  EXPECT_EQ(labels.At(5, 0), 0);
  EXPECT_EQ(labels.At(1'099'999, 1'999), 0);
  for (const auto& [column, row] : {std::pair{4, 0}, {6, 0}, {5, 1}, {1'099'998, 1'999}, {1'099'999, 1'998}})
    EXPECT_EQ(labels.At(column, row), render::kNoPhoto) << column << " " << row;
}

TEST(FlightFacts, CutOffAnywhereAreRefusedAndNeverBelieved) {
  const std::string bytes = WriteFacts(SomeFacts());
  for (std::size_t length = 0; length < bytes.size(); length += 7) {
    EXPECT_FALSE(ParseFacts(bytes.substr(0, length)).ok()) << length;
  }
}

TEST(FlightFacts, OfPosesAloneHaveNoFiguresOfAnAlignment) {
  FlightFacts facts = SomeFacts();
  facts.align_report.reset();
  EXPECT_FALSE(test::ValueOf(ParseFacts(WriteFacts(facts))).align_report);
}

TEST(FlightFacts, WithNamesThatAreNoTextAreReadAgain) {
  FlightFacts facts = SomeFacts();
  facts.align_report->photo_reports[0].name = "n\xff.jpg";
  const auto read = test::ValueOf(ParseFacts(WriteFacts(facts)));
  EXPECT_EQ(read.align_report->photo_reports[0].name, "n\xEF\xBF\xBD.jpg");
}

// The facts with the text of one of their reports changed.
std::string WithReport(const char* name, const std::string& text) {
  nlohmann::json json = nlohmann::json::from_cbor(WriteFacts(SomeFacts()));
  json[name] = text;
  const std::vector<std::uint8_t> bytes = nlohmann::json::to_cbor(json);
  return {bytes.begin(), bytes.end()};
}

TEST(FlightFacts, WithADamagedReportAreRefused) {
  for (const char* name : {"alignment", "ground", "poses"}) {
    const std::string text = nlohmann::json::from_cbor(WriteFacts(SomeFacts())).at(name);
    // Indented, as it was written once.
    EXPECT_TRUE(ParseFacts(WithReport(name, nlohmann::ordered_json::parse(text).dump(2))).ok()) << name;
    for (const std::string& damaged :
         {std::string("{}"), std::string("[1]"), text.substr(0, text.size() - 1)}) {
      const Result<FlightFacts> read = ParseFacts(WithReport(name, damaged));
      ASSERT_FALSE(read.ok()) << name << ": " << damaged;
      EXPECT_EQ(read.error().code, ErrorCode::kCorrupt);
    }
  }
}

TEST(DigestOfPlacing, ChangesWithWhatMovesPhotosAndNotWithWhatDrawsThem) {
  MosaicOptions options;
  const Digest before = DigestOfPlacing(options);
  options.jpeg_quality = 40;
  EXPECT_EQ(DigestOfPlacing(options), before);
  options.method = AlignMethod::kImu;
  EXPECT_NE(DigestOfPlacing(options), before);
  // Maps made before know their method by these, and 2 and 3 for what is gone.
  EXPECT_EQ(static_cast<int>(AlignMethod::kImu), 1);
  EXPECT_EQ(static_cast<int>(AlignMethod::kImages), 4);
}

TEST(BandedMapOf, ShowsNoMoreThanTheMapOfWhatNoOtherPhotoTies) {
  for (const auto& [tied_deg, shown_deg] :
       {std::pair{0.0, 55.0}, std::pair{60.0, 60.0}, std::pair{90.0, 65.0}}) {
    FlightFacts facts = SomeFacts();
    alignment::AlignedPhoto& photo = facts.flight.photos.front();
    photo.tied_look_rad = geo::DegToRad(tied_deg);
    photo.max_look_rad = 0.0;  // the map is drawn in colour
    bands::Captures captures;
    captures.captures.emplace_back().reference = photo.photo.name;
    const auto map = test::ValueOf(BandedMapOf(facts, captures, {}));
    EXPECT_NEAR(map.references.photos.at(0).max_look_rad, geo::DegToRad(shown_deg), 1e-9);
  }
}

}  // namespace
}  // namespace skyquilt::pipeline
