// What report.json tells of the stages is read again as it was; nothing damaged is taken for a report.
#include "core/pipeline/report/report_codec.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

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

TEST(ReportCodec, ReadsPlainReportsAgain) {
  EXPECT_EQ(ReportOf<poses::PoseReport>(JsonOf<Json>(poses::PoseReport())), poses::PoseReport());
  EXPECT_EQ(ReportOf<ground::ModelGroundReport>(JsonOf<Json>(ground::ModelGroundReport())),
            ground::ModelGroundReport());
  EXPECT_EQ(ReportOf<alignment::AlignReport>(JsonOf<Json>(alignment::AlignReport())),
            alignment::AlignReport());
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
  report.second_leg.is_placed = true;
  EXPECT_EQ(JsonOf<Json>(report), before);
}

TEST(ReportCodec, TellsShiftsOfSeamsInPixelsToo) {
  const Json json = JsonOf<Json>(render::SeamShift{120, 90, 0.05, 0.1, 0.2});
  EXPECT_EQ(json.dump(),
            R"({"patches":120,"reliable":90,"median_m":0.1,"p90_m":0.2,"median_gsd":2.0,"p90_gsd":4.0})");
  EXPECT_EQ(JsonOf<Json>(render::SeamShift{1, 1, 0.0, 0.25, 0.5})["p90_gsd"], 0.5);
}

}  // namespace
}  // namespace skyquilt::pipeline
