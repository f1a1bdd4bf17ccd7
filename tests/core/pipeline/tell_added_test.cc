// What is said of a map that got photos: figures that count the new ones, remarks that stand once, and seams
// no better than they were.
#include "core/pipeline/placing/tell_added.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "core/flight/photos/photo_decoder.h"
#include "core/flight/read_flight.h"
#include "core/pipeline/build_mosaic.h"
#include "core/pipeline/report/flight_facts.h"
#include "core/simulate/simulate_flight.h"
#include "tests/core/pipeline/judged_flight.h"
#include "tests/support/facts_alone.h"
#include "tests/support/memory_sink.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::pipeline {
namespace {

using flight::Remark;
using flight::RemarkCode;

// A surveyed field of ten photos, and one of ten more that was added and is tied within itself alone.
struct FieldAdded : JudgedFlight {
  std::set<std::string> added;
  alignment::AlignReport part;

  FieldAdded() : JudgedFlight(20) {
    report.components = 1;
    report.observations = 3000;
    report.pairs_tried = 40;
    report.pairs_linked = 9;
    for (int k = 0; k < 4; ++k) Surveyed(false, 0.01, 0.01, true);
    for (alignment::ControlReport& point : report.control)
      point.marks.push_back({.photo = "p3", .residual_px = 0.5, .residual_m = 0.01, .is_used = true});
    for (std::size_t i = 1; i < 10; ++i) Tie(i - 1, i, report);
    for (std::size_t i = 10; i < flight.photos.size(); ++i) {
      alignment::AlignPhotoReport& photo = part.photo_reports.emplace_back();
      photo.name = flight.photos[i].photo.name;
      photo.placement = alignment::Placement::kAligned;
      photo.observations = 50;
      photo.residual_rms_px = 1.0;
      added.insert(photo.name);
      if (i > 10) Tie(i - 1, i, part);
    }
    Tie(0, 1, part);  // of photos around, which is known
    part.tie_points = 900;
    part.tie_points_of_new = 200;
  }
  void Tie(std::size_t first, std::size_t second, alignment::AlignReport& in) const {
    alignment::AlignPairReport& pair = in.pairs.emplace_back();
    pair.first = flight.photos[first].photo.name;
    pair.second = flight.photos[second].photo.name;
  }
};

TEST(AddFigures, ASecondFieldWithoutTiesDoesNotTakeTheSurveyOfTheFirst) {
  FieldAdded map;
  AddFigures(map.part, map.added, map.flight.photos, map.report);
  EXPECT_EQ(map.report.components, 2);
  const AbsoluteAccuracy of_both = map.Judge().absolute;
  EXPECT_EQ(of_both.by, AbsoluteSupport::kGnss);
  EXPECT_GT(*of_both.sigma_m, 1.0);

  FieldAdded tied;
  tied.Tie(9, 10, tied.part);
  AddFigures(tied.part, tied.added, tied.flight.photos, tied.report);
  EXPECT_EQ(tied.report.components, 1);
  EXPECT_EQ(tied.Judge().absolute.by, AbsoluteSupport::kControlPoints);
}

TEST(AddFigures, CountsWhatTheNewPhotosAreTiedBy) {
  FieldAdded map;
  AddFigures(map.part, map.added, map.flight.photos, map.report);
  EXPECT_EQ(map.report.pairs_linked, 18);
  EXPECT_EQ(map.report.pairs_tried, 49);
  EXPECT_EQ(map.report.tie_points, 1200);
  EXPECT_EQ(map.report.observations, 3500);
  EXPECT_NEAR(map.report.residual_rms_px, std::sqrt((3000 * 0.25 + 500 * 1.0) / 3500), 1e-9);
  // The same once more: what they had counts no longer.
  map.part.tie_points_of_new = 0;
  AddFigures(map.part, map.added, map.flight.photos, map.report);
  EXPECT_EQ(map.report.pairs_linked, 18);
  EXPECT_EQ(map.report.pairs_tried, 49);
  EXPECT_EQ(map.report.observations, 3500);
  EXPECT_NEAR(map.report.residual_rms_px, std::sqrt((3000 * 0.25 + 500 * 1.0) / 3500), 1e-9);
}

TEST(TellPosed, SaysOfAllPhotosWhatIsSoNowAndNotThatTheyLieNowhereOnceTheyWerePlaced) {
  const Remark groups{RemarkCode::kGroups, {{"groups", 2}}};
  const auto repeated = [](int photos, int total) {
    return Remark{RemarkCode::kPositionsRepeated, {{"photos", photos}, {"total", total}}};
  };
  for (const bool is_placed : {true, false}) {
    std::vector<Remark> warnings = {repeated(1, 17), groups};
    std::vector<Remark> told = {groups, repeated(2, 20)};
    if (!is_placed) told.emplace_back(RemarkCode::kReckonedFromNowhere);
    for (int again = 0; again < 2; ++again) {
      TellPosed({repeated(2, 20), RemarkCode::kReckonedFromNowhere}, is_placed, warnings);
      EXPECT_TRUE(warnings == told) << is_placed << again;
    }
  }
}

TEST(TellAligned, SaysWhatIsNewOfTheNewPhotos) {
  const auto of = [](const char* photo, double off_deg) {
    return Remark{RemarkCode::kOfPhoto,
                  {{"photo", photo}, {"said", Remark(RemarkCode::kYawCorrected, {{"off_deg", off_deg}})}}};
  };
  const auto turned = [](const char* first, const char* last) {
    return Remark{RemarkCode::kPhotosStoredTurned, {{"first", first}, {"last", last}, {"turn_deg", 90}}};
  };
  const auto dropped = [](int used, int points) {
    return Remark{RemarkCode::kPointsDropped, {{"used", used}, {"points", points}}};
  };
  std::vector<Remark> warnings = {dropped(500, 2000), of("old.jpg", 30.0)};
  const std::vector<Remark> aligned = {
      dropped(10, 80),       RemarkCode::kNoTies,          of("new.jpg", 40.0),     of("old.jpg", 31.0),
      of("other.jpg", 20.0), turned("old.jpg", "new.jpg"), turned("a.jpg", "b.jpg")};
  TellAligned(aligned, {"new.jpg"}, warnings);
  EXPECT_TRUE(warnings == (std::vector<Remark>{dropped(500, 2000), of("old.jpg", 30.0), of("new.jpg", 40.0),
                                               turned("old.jpg", "new.jpg")}));
}

TEST(TellGroups, SaysInItsPlaceHowTheWholeMapHangsTogether) {
  const auto groups = [](int count) { return Remark{RemarkCode::kGroups, {{"groups", count}}}; };
  const Remark other = "Zoomed.";
  std::vector<Remark> warnings = {groups(2), other};
  TellGroups(3, 20, warnings);
  EXPECT_TRUE(warnings == (std::vector<Remark>{groups(3), other}));
  TellGroups(1, 20, warnings);
  EXPECT_TRUE(warnings == std::vector<Remark>{other});
  TellGroups(0, 20, warnings);
  EXPECT_TRUE(warnings == (std::vector<Remark>{other, RemarkCode::kNoTies}));
  TellGroups(2, 20, warnings);
  EXPECT_TRUE(warnings == (std::vector<Remark>{other, groups(2)}));
}

TEST(SeamShift, OfAMapThatGotPhotosIsTheWorseOneThatWasMeasured) {
  const render::SeamShift before{60, 40, 0.02, 0.03, 0.05}, worse{9, 6, 0.02, 0.4, 0.5},
      better{9, 6, 0.02, 0.01, 0.02}, unknown{9, 4, 0.02, 0.4, 0.5};
  EXPECT_EQ(render::WorseOf(before, worse), worse);
  EXPECT_EQ(render::WorseOf(before, better), before);
  EXPECT_EQ(render::WorseOf(before, unknown), before) << "too few beside the new photos";
}

Result<BuiltMosaic> Build(const std::filesystem::path& photos, pyramid::MapMemory& memory) {
  MosaicOptions options;
  options.method = AlignMethod::kImu;
  test::MemorySink tiles;
  SilentProgress progress;
  return BuildMosaic(test::ValueOf(flight::ListInputFiles({photos})), options, flight::FilePhotoSource(),
                     tiles, progress, nullptr, &memory);
}

TEST(BuildMosaic, StatesNoBetterSeamsOfAMapThatGotAPhoto) {
  const test::TemporaryFolder folder;
  simulate::SimulateOptions simulated;
  simulated.trajectory.photos = 8;
  simulated.intrinsics = camera::Intrinsics::Centered(400, 300, 320.0);
  simulated.write_world = false;
  SilentProgress progress;
  ASSERT_TRUE(simulate::SimulateFlight(simulated, folder.path(), progress).ok());
  const std::filesystem::path photos = folder / "photos", last = photos / "SIM_0008.JPG";
  std::filesystem::rename(last, folder / "later.JPG");
  test::FactsAlone memory;
  const render::SeamShift measured = test::ValueOf(Build(photos, memory)).report.seam_shift;
  FlightFacts known = test::ValueOf(ParseFacts(memory.Recall()));
  EXPECT_EQ(known.seams, measured);

  const render::SeamShift far_apart{60, 50, 0.2, 1000.0, 2000.0};
  known.seams = far_apart;
  ASSERT_TRUE(memory.Remember(WriteFacts(known)).ok());
  std::filesystem::rename(folder / "later.JPG", last);
  const BuiltMosaic grown = test::ValueOf(Build(photos, memory));
  ASSERT_EQ(std::count_if(grown.report.warnings.begin(), grown.report.warnings.end(),
                          [](const Remark& said) { return said.code == RemarkCode::kPhotosAdded; }),
            1);
  EXPECT_EQ(grown.report.seam_shift, far_apart);
  EXPECT_EQ(test::ValueOf(ParseFacts(memory.Recall())).seams, far_apart) << "for the next photos";
  // Made again all of them are measured.
  EXPECT_LT(test::ValueOf(Build(photos, memory)).report.seam_shift.median_m, 1000.0);
}

}  // namespace
}  // namespace skyquilt::pipeline
