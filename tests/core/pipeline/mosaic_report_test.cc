// What report.json tells is read again as it was, and nothing damaged is taken for a report or a remark; when
// the flight was taken, by the clock on the wall there.
#include "core/pipeline/report/mosaic_report.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/flight/remarks/remark_json.h"
#include "core/pipeline/inspect_flight.h"
#include "core/pipeline/report/report_codec.h"
#include "core/poses/conventions/attitude_convention.h"
#include "tests/core/pipeline/full_reports.h"

namespace skyquilt::pipeline {
namespace {

using Json = nlohmann::ordered_json;

template <typename Report>
bool IsRead(const Json& json) {
  try {
    ReportOf<Report>(Json::parse(json.dump()));
    return true;
  } catch (const Json::exception&) {
    return false;
  }
}

// Every place of a figure, as a JSON pointer. Lists may be of any length.
std::vector<std::string> PlacesOf(const Json& json) {
  std::vector<std::string> places;
  const Json flat = json.flatten();
  for (const auto& [place, value] : flat.items()) places.push_back(place);
  return places;
}

template <typename Report>
void ExpectReadAgain(const Report& full) {
  const Json json = JsonOf<Json>(full);
  EXPECT_EQ(ReportOf<Report>(Json::parse(json.dump())), full);
  // That `full` leaves no figure as it is by default is what makes the line above hold all of them.
  const Json plain = JsonOf<Json>(Report());
  for (const std::string& place : PlacesOf(plain)) {
    const Json::json_pointer pointer(place);
    EXPECT_NE(json.at(pointer), plain.at(pointer)) << place << " is not tried";
  }
}

template <typename Report>
void ExpectDamageRefused(const Report& full) {
  const Json json = JsonOf<Json>(full);
  ASSERT_TRUE(IsRead<Report>(json));
  for (const std::string& place : PlacesOf(json)) {
    const Json::json_pointer pointer(place);
    Json other_kind = json;
    other_kind[pointer] = json.at(pointer).is_string() ? Json(1) : Json("no word of ours");
    EXPECT_FALSE(IsRead<Report>(other_kind)) << place;
    if (!json.at(pointer.parent_pointer()).is_object()) continue;
    Json without = json;
    without[pointer.parent_pointer()].erase(pointer.back());
    EXPECT_FALSE(IsRead<Report>(without)) << place;
  }
  for (const Json& none : {Json(nullptr), Json(1), Json(""), Json::array(), Json::object()})
    EXPECT_FALSE(IsRead<Report>(none)) << none;
}

alignment::AlignedPhoto LookingDown() {
  alignment::AlignedPhoto photo;
  photo.photo.name = "A.JPG";
  photo.intrinsics = camera::Intrinsics::Centered(4000, 3000, 3000.0);
  photo.cam_from_enu =
      geo::Rigid3::FromRotationAndTargetOrigin(poses::NadirCamFromEnu(0.0), {0.0, 0.0, 60.0});
  photo.error_radius_m = 1.5;
  return photo;
}

// From 60 m above the antimeridian a photo sees some 40 m on either side of it.
TEST(PhotosGeoJson, AcrossTheAntimeridianARingDoesNotGoRoundTheEarth) {
  for (const double lon_deg : {180.0, -180.0, 179.9999, -179.9999}) {
    alignment::AlignedFlight flight;
    flight.frame = geo::LocalFrame({-17.0, lon_deg, 0.0});
    flight.photos.push_back(LookingDown());
    const Json photos = Json::parse(PhotosGeoJson(flight, ground::GroundSurface::Plane(0.0), {}));
    double west_deg = 1e9, east_deg = -1e9;
    for (const Json& corner : photos["features"][0]["geometry"]["coordinates"][0]) {
      west_deg = std::min(west_deg, corner[0].get<double>());
      east_deg = std::max(east_deg, corner[0].get<double>());
    }
    EXPECT_NEAR(east_deg - west_deg, 80.0 / 111320.0 / std::cos(17.0 * M_PI / 180.0), 1e-5) << lon_deg;
    EXPECT_LE(west_deg, 180.0) << lon_deg;
    EXPECT_GT(east_deg, 180.0) << lon_deg;
  }
}

// What an aligned photo and one that lies by its pose state of themselves.
std::vector<bool> SaysErrors(const AbsoluteAccuracy& absolute) {
  alignment::AlignedFlight flight;
  flight.photos = {LookingDown(), LookingDown()};
  flight.photos[0].placement = alignment::Placement::kAligned;
  std::vector<bool> said;
  const Json photos = Json::parse(PhotosGeoJson(flight, ground::GroundSurface::Plane(0.0), absolute));
  for (const Json& photo : photos["features"])
    said.push_back(photo["properties"]["error_radius_m"].is_number());
  return said;
}

TEST(PhotosGeoJson, SayNoErrorByRecordsWhereThesePlaceNoMap) {
  EXPECT_EQ(SaysErrors({2.0, AbsoluteSupport::kGnss, 9}), (std::vector<bool>{true, true}));
  EXPECT_EQ(SaysErrors({std::nullopt, AbsoluteSupport::kGnss, 2}), (std::vector<bool>{false, true}));
  EXPECT_EQ(SaysErrors({std::nullopt, AbsoluteSupport::kHand, 0}), (std::vector<bool>{false, false}));
  EXPECT_EQ(SaysErrors({}), (std::vector<bool>{false, false})) << "it lies nowhere";
}

TEST(ReportCodec, ReadsEveryFigureAgain) {
  ExpectReadAgain(FullPoseReport());
  ExpectReadAgain(FullGroundReport());
  ExpectReadAgain(FullAlignReport());
  // What its lists are made of.
  ExpectReadAgain(FullPhotoReport());
  ExpectReadAgain(FullPairReport());
  ExpectReadAgain(FullAlignReport().lenses.front());
  ExpectReadAgain(FullAlignReport().control.front());
  ExpectReadAgain(FullAlignReport().gyros.front());
}

// Clients read these names, and maps of earlier runs are gone on with by them: a change needs another version
// in flight_facts.cc.
TEST(ReportCodec, KeepsTheNamesThatFilesHave) {
  EXPECT_EQ(
      JsonOf<Json>(FullPoseReport()).dump(),
      R"({"method":"by the log","is_placed":false,"logs":["flight.bin: positions",)"
      R"("flight.bin: angles"],"series":["gnss"],"time_match":"by events","time_offset_s":-0.3333333333333333,)"
      R"("time_sigma_s":1e-09,"camera_ahead_of_utc_s":7200.25,"convention":"gimbal",)"
      R"("height_rule":"barometer","photos_by_log":17,"photos_by_records":3,)"
      R"("knots":2147483647,)"
      R"("iterations":5,"log_position_sigma_m":0.14285714285714285,"log_positions":"corrected"})");
  EXPECT_EQ(JsonOf<Json>(FullGroundReport()).dump(),
            R"({"model":"grid","reason":"held-back points lie nearer","points_given":900,)"
            R"("points_used":870,"plane_error_m":0.3333333333333333,"grid_error_m":0.05,)"
            R"("elevation_model_error_m":0.7,"elevation_model_shift_m":-512.125,"cell_m":2.5,)"
            R"("lowest_m":-3.0,"highest_m":4.0,"mean_m":-0.1,"seconds":0.001})");
  EXPECT_EQ(
      JsonOf<Json>(FullAlignReport()).dump(),
      R"({"photos":20,"aligned":19,"pieces":2,"pairs_tried":190,"pairs_linked":80,)"
      R"("pairs_rejected":4,"pairs_by_direct":1,"tie_points":5000,"observations":15000,)"
      R"("observations_dropped":30,"residual_rms_px":0.6666666666666666,"position_residual_m":1.5,)"
      R"("attitude_residual_deg":0.25,"solver":"sparse","iterations":12,"corrections":["DJI_1.JPG was stored turned"],)"
      R"("gyros":[{"camera_key":"key","pairs":10,"matches":900,"fitting":800,"fitting_without":500,)"
      R"("lag_s":-0.01,"is_used":false}],"timings_s":{"decode":1.25,"features":2.25,)"
      R"("matching_wall":3.25,"adjustment_wall":4.25,"total_wall":5.25},"cameras":[{"camera_key":"key",)"
      R"("recorded":{"width_px":800,"height_px":600,"focal_x_px":700.1,"focal_y_px":700.2,)"
      R"("center_x_px":399.5,"center_y_px":299.5,"k1":0.1,"k2":-0.2,"k3":0.3,"p1":0.0001,)"
      R"("p2":-0.0002},"adjusted":{"width_px":800,"height_px":600,"focal_x_px":698.5,)"
      R"("focal_y_px":700.2,"center_x_px":399.5,"center_y_px":299.5,"k1":0.1,"k2":-0.2,)"
      R"("k3":0.3,"p1":0.0001,"p2":-0.0002},"sigma_focal_px":0.4,"focal_is_held":false}],)"
      R"("photo_reports":[{"name":"DJI_1.JPG","placement":"aligned",)"
      R"("reason":"placed by its recorded pose; images were not compared; is blurred",)"
      R"("remarks":[{"code":"by_pose_alone","values":{}},{"code":"doubt_blurred","values":{}}],)"
      R"("features":4000,"links":6,"observations":321,"residual_rms_px":0.6,"moved_m":0.3333333333333333,)"
      R"("turned_deg":-2.5,"placed_by":"images","faults":["position_wrong",)"
      R"("yaw_wrong","stored_turned","copy","blurred","other_place","far_away"]}],)"
      R"("pairs":[{"first":"DJI_1.JPG","second":"DJI_2.JPG","matches":88,"rms_m":0.02,)"
      R"("rms_px":0.9,"by_direct":true},{"first":"DJI_1.JPG","second":"DJI_2.JPG",)"
      R"("matches":88,"rms_m":0.02,"rms_px":0.9,"by_direct":true}],"rejected_pairs":[{"first":"DJI_1.JPG",)"
      R"("second":"DJI_2.JPG","matches":88,"rms_m":0.02}],"ground_control":[{"name":"point1","lat":46.8,"lon":7.1,)"
      R"("sightings":3,"is_used":true,"is_check":true,)"
      R"("reason":"has marks that do not meet in one point on the ground",)"
      R"("remark":{"code":"point_marks_apart","values":{}},"miss_east_m":0.1,"miss_north_m":-0.2,)"
      R"("miss_up_m":0.3,"residual_px":1.5,"left_out":{"miss_east_m":0.4,"miss_north_m":-0.5,"miss_up_m":0.6}}],"position_bias_m":[0.1,-0.2,0.3],"placed_by":"images",)"
      R"("second_leg":{"why":"by their recorded poses no point found in several photos fits",)"
      R"("why_remark":{"code":"records_no_point","values":{}},)"
      R"("outcome":"; surveyed points say where on Earth",)"
      R"("outcome_remark":{"code":"images_on_control","values":{}},"is_taken":true,)"
      R"("registered":18,"groups":2,"pairs_compared":100,"pairs_verified":60,"pairs_refused":9,)"
      R"("residual_rms_px":0.8,"total_wall_s":33.0}})");
}

TEST(ReportCodec, ReadsPlainReportsAgain) {
  EXPECT_EQ(ReportOf<poses::PoseReport>(JsonOf<Json>(poses::PoseReport())), poses::PoseReport());
  EXPECT_EQ(ReportOf<ground::ModelGroundReport>(JsonOf<Json>(ground::ModelGroundReport())),
            ground::ModelGroundReport());
  EXPECT_EQ(ReportOf<alignment::AlignReport>(JsonOf<Json>(alignment::AlignReport())),
            alignment::AlignReport());
  alignment::AlignReport surveyed;
  surveyed.survey_above_records_m = -47.25;
  EXPECT_EQ(ReportOf<alignment::AlignReport>(JsonOf<Json>(surveyed)), surveyed);
}

TEST(ReportCodec, AHeightThatWasNotComparedIsNull) {
  Json json = JsonOf<Json>(alignment::ControlReport());
  EXPECT_TRUE(json.at("miss_up_m").is_null());
  EXPECT_TRUE(std::isnan(ReportOf<alignment::ControlReport>(json).miss_up_m));
  json["miss_up_m"] = 0;  // as maps of earlier versions have it
  EXPECT_EQ(ReportOf<alignment::ControlReport>(json).miss_up_m, 0.0);
}

TEST(ReportCodec, RefusesWhatIsMissingOrOfAnotherKind) {
  ExpectDamageRefused(FullPoseReport());
  ExpectDamageRefused(FullGroundReport());
  ExpectDamageRefused(FullAlignReport());
}

TEST(ReportCodec, RefusesCountsThatAreNone) {
  for (const Json& count : {Json(0.5), Json(1e300), Json(std::int64_t{1} << 31), Json(-1e18), Json(true),
                            Json(std::numeric_limits<std::uint64_t>::max()), Json(nullptr)}) {
    Json json = JsonOf<Json>(FullPoseReport());
    json["knots"] = count;
    EXPECT_FALSE(IsRead<poses::PoseReport>(json)) << count;
  }
}

TEST(ReportCodec, RefusesAPlaceOfFourNumbers) {
  Json json = JsonOf<Json>(FullAlignReport());
  json["position_bias_m"].push_back(1.0);
  EXPECT_FALSE(IsRead<alignment::AlignReport>(json));
}

// JSON has no such number; a report that holds one is no reason to lose a flight's state.
TEST(ReportCodec, KeepsWhatIsNoNumber) {
  alignment::AlignReport report;
  report.residual_rms_px = std::nan("");
  const std::string text = JsonOf<Json>(report).dump();
  const auto read = ReportOf<alignment::AlignReport>(Json::parse(text));
  EXPECT_TRUE(std::isnan(read.residual_rms_px));
  EXPECT_EQ(JsonOf<Json>(read).dump(), text);
}

TEST(ReportCodec, LeavesOutWhatOnlyTheRunItselfNeeds) {
  alignment::AlignReport report = FullAlignReport();
  const Json before = JsonOf<Json>(report);
  report.pairs[0].some.emplace_back();
  report.by_images.is_placed = true;
  EXPECT_EQ(JsonOf<Json>(report), before);
}

TEST(ReportCodec, TellsShiftsOfSeamsInPixelsToo) {
  const Json json = JsonOf<Json>(render::SeamShift{120, 90, 0.05, 0.1, 0.2});
  EXPECT_EQ(json.dump(),
            R"({"patches":120,"reliable":90,"median_m":0.1,"p90_m":0.2,"median_gsd":2.0,"p90_gsd":4.0})");
  EXPECT_EQ(JsonOf<Json>(render::SeamShift{1, 1, 0.0, 0.25, 0.5})["p90_gsd"], 0.5);
}

using flight::Remark;
using flight::RemarkCode;

TEST(RemarkJson, IsReadAgainAsItWas) {
  const std::vector<Remark> remarks{
      "as a reader has it",
      RemarkCode::kNoTies,
      {RemarkCode::kGroups, {{"groups", 3}}},
      {RemarkCode::kPlacedByControl, {{"points", 5}, {"apart_m", 2.0}, {"turn_deg", -0.25}, {"times", 1.0}}},
      {RemarkCode::kOfPhoto, {{"photo", "a.jpg"}, {"said", Remark(RemarkCode::kDoubtBlurred)}}}};
  const Json json = flight::JsonOfRemarks<Json>(remarks);
  EXPECT_EQ(json[0].dump(), R"({"code":"text","values":{"text_words":"as a reader has it"}})");
  EXPECT_EQ(
      json[4].dump(),
      R"({"code":"of_photo","values":{"photo":"a.jpg","said":[{"code":"doubt_blurred","values":{}}]}})");
  EXPECT_EQ(flight::RemarksOfJson(Json::parse(json.dump())), remarks);
  const auto cbor = nlohmann::json::to_cbor(flight::JsonOfRemarks<nlohmann::json>(remarks));
  EXPECT_EQ(flight::RemarksOfJson(nlohmann::json::from_cbor(cbor)), remarks);
}

TEST(ReportJson, SaysWhatTheHeightsOfTheSurfaceCountFrom) {
  MosaicReport report;
  report.surface.emplace();
  const auto told = [&report](const char* name) {
    return Json::parse(ReportJson(report)).at("surface").value(name, std::string("nothing"));
  };
  EXPECT_EQ(told("heights_from"), "records");
  EXPECT_EQ(told("records_from"), "nothing");
  report.poses_report.heights_above_ellipsoid = true;
  EXPECT_EQ(told("records_from"), "ellipsoid");
  EXPECT_EQ(ReportOf<poses::PoseReport>(JsonOf<Json>(report.poses_report)), report.poses_report);
  report.poses_report.heights_above_ellipsoid = false;
  EXPECT_EQ(told("records_from"), "take_off");
  report.align_report.emplace().survey_above_records_m = -47.25;
  EXPECT_EQ(told("heights_from"), "survey");
  EXPECT_EQ(told("records_from"), "nothing") << "they count as the surveyed points";
}

TEST(RemarkJson, OfAnotherKindIsRefused) {
  for (const char* damaged :
       {R"({})", R"({"code":"no_ties"})", R"({"code":"no_such_code","values":{}})",
        R"({"code":7,"values":{}})", R"({"code":"no_ties","values":"none"})",
        R"({"code":"groups","values":{"groups":null}})", R"({"code":"of_photo","values":{"said":[7]}})"}) {
    EXPECT_THROW(flight::RemarkOfJson(Json::parse(damaged)), Json::exception) << damaged;
  }
}

using namespace std::chrono;

flight::Photo At(flight::UtcTime time, std::optional<minutes> zone = {}, bool is_local = false) {
  flight::Photo photo;
  photo.captured_at = time;
  photo.captured_at_is_local = is_local;
  photo.clock_minus_utc = zone;
  return photo;
}

constexpr flight::UtcTime kEvening = sys_days(2015y / 10 / 27) + 23h + 50min + 2s + 900ms;

TEST(VerdictText, KeepsWhatFilesCallThingsWithinTheirLines) {
  FlightVerdict verdict;
  verdict.cameras["DJI\x1b[2J FC220"] = 1;
  verdict.gcp_lists = {"a\nStatus      Ready to use.txt: 5 points"};
  verdict.logs.resize(1);
  verdict.logs[0].file_name = "a\nb.csv";
  verdict.logs[0].mapping = {"\"t\r\" is the time"};
  const std::string text = VerdictText(verdict);
  EXPECT_EQ(text.find_first_of("\x1b\r"), std::string::npos) << text;
  EXPECT_EQ(text.find("\nStatus      Ready"), std::string::npos) << text;
  EXPECT_NE(text.find("Log         a?b.csv"), std::string::npos) << text;
}

TEST(CaptureSpan, IsWrittenInTheZoneOfTheCamerasClock) {
  const flight::Photo late = At(kEvening + 20min, -4h), early = At(kEvening, -4h), untimed;
  const auto span = CaptureSpanOf({&late, &untimed, &early});
  ASSERT_TRUE(span);
  EXPECT_EQ(span->first, "2015-10-27T19:50:02-04:00");
  EXPECT_EQ(span->last, "2015-10-27T20:10:02-04:00");
}

TEST(CaptureSpan, TakesTheZoneOfThePhotosThatKnowIt) {
  const flight::Photo first = At(kEvening), second = At(kEvening + 20min, 5h + 30min);
  const auto span = CaptureSpanOf({&first, &second});
  EXPECT_EQ(span->first, "2015-10-28T05:20:02+05:30");
  EXPECT_EQ(span->last, "2015-10-28T05:40:02+05:30");
}

TEST(CaptureSpan, SaysWhatIsNotKnown) {
  const flight::Photo utc = At(kEvening), local = At(kEvening - 30h, {}, true), untimed;
  EXPECT_EQ(CaptureSpanOf({&utc})->first, "2015-10-27T23:50:02Z");
  EXPECT_EQ(CaptureSpanOf({&local})->first, "2015-10-26T17:50:02");
  EXPECT_EQ(CaptureSpanOf({&local, &utc})->first, "2015-10-27T23:50:02Z")
      << "UTC counts before a local clock";
  EXPECT_EQ(CaptureSpanOf({&utc, &local})->last, "2015-10-27T23:50:02Z");
  EXPECT_FALSE(CaptureSpanOf({&untimed}));
  EXPECT_FALSE(CaptureSpanOf({}));
}

}  // namespace
}  // namespace skyquilt::pipeline
