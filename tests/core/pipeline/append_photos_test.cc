// Photos of a recalled flight: what they are read as today, drawn in the range they were drawn in. Photos
// that are added to a map lie where it lies, also where it was moved since or nothing is recorded of them,
// and may bring in what it left out.
#include "core/pipeline/append_photos.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <set>
#include <utility>

#include "core/flight/photos/photo_decoder.h"
#include "core/pipeline/placing/recall_flight.h"
#include "tests/core/pipeline/displaced_flight.h"
#include "tests/support/rendered_once.h"
#include "tests/support/value_of.h"

namespace skyquilt::pipeline {
namespace {

using flight::SampleKind;

flight::Photo GreyPhoto(const std::string& name, SampleKind kind, double high) {
  flight::Photo photo;
  photo.name = name;
  photo.path = "/now/" + name;
  photo.camera_key = "camera";
  photo.sample_kind = kind;
  photo.sample_range = flight::SampleRange{0.0, high};
  return photo;
}

TEST(FillPhotos, KeepsTheRangeThatTheMapIsDrawnIn) {
  alignment::AlignedFlight known;
  known.photos.resize(2);
  known.photos[0].photo.name = "a";
  known.photos[0].photo.sample_range = flight::SampleRange{0.0, 40.0};
  known.photos[1].photo.name = "b";
  flight::Flight read;
  read.photos = {GreyPhoto("a", SampleKind::kFloating, 45.0), GreyPhoto("b", SampleKind::kFloating, 45.0)};
  FillPhotos(read, known);
  EXPECT_EQ(known.photos[0].photo.path, "/now/a");
  EXPECT_EQ(known.photos[0].photo.sample_range->high, 40.0);
  EXPECT_EQ(known.photos[1].photo.sample_range->high, 45.0) << "none was remembered";
}

TEST(TellReading, SaysWhatIsSoOfTheFilesNowAndLeavesWhatBecameOfThem) {
  using flight::Remark;
  using flight::RemarkCode;
  const auto without_position = [](int photos, int total) {
    return Remark{RemarkCode::kPhotosWithoutPosition, {{"photos", photos}, {"total", total}}};
  };
  const auto strays = [](const char* file, int marks) {
    return Remark{RemarkCode::kMarksNameNoPhoto, {{"file", file}, {"marks", marks}, {"first", "x.jpg"}}};
  };
  const auto noted = [](const char* first, int photos, int total, const char* note) {
    return Remark{RemarkCode::kOfPhotos,
                  {{"photos", photos}, {"total", total}, {"photo", first}, {"said", Remark(note)}}};
  };
  const Remark groups{RemarkCode::kGroups, {{"groups", 2}}};
  const Remark elsewhere{RemarkCode::kControlElsewhere, {{"file", "gcp_list.txt"}, {"apart_m", 5000.0}}};
  const Remark film{RemarkCode::kFilm, {{"file", "a.mp4"}}};
  alignment::AlignedFlight known;
  known.warnings = {without_position(2, 20), groups,    strays("gcp_list.txt", 3),
                    strays("other.txt", 1),  elsewhere, noted("c.jpg", 2, 20, "Zoomed.")};
  flight::Flight read;
  read.gcp_lists.emplace_back().file_name = "gcp_list.txt";
  read.warnings = {film, without_position(3, 21), noted("a.jpg", 3, 21, "Zoomed.")};
  const std::vector<Remark> told = {groups, strays("other.txt", 1),  elsewhere,
                                    film,   without_position(3, 21), noted("a.jpg", 3, 21, "Zoomed.")};
  for (int again = 0; again < 2; ++again) {
    TellReading(read, known);
    EXPECT_TRUE(known.warnings == told) << again;
  }
}

TEST(TellReading, SaysOnceOfSeveralPhotosWhatWasSaidOfTheFirst) {
  using flight::Remark;
  using flight::RemarkCode;
  const auto of_one = [](const char* photo, const char* note) {
    return Remark{RemarkCode::kOfPhoto, {{"photo", photo}, {"said", Remark(note)}}};
  };
  const Remark of_both{RemarkCode::kOfPhotos,
                       {{"photos", 2}, {"total", 21}, {"photo", "a.jpg"}, {"said", Remark("Zoomed.")}}};
  alignment::AlignedFlight known;
  known.warnings = {of_one("c.jpg", "Zoomed."), of_one("c.jpg", "Blurred.")};
  flight::Flight read;
  read.warnings = {of_both};
  TellReading(read, known);
  const std::vector<Remark> told = {of_one("c.jpg", "Blurred."), of_both};
  EXPECT_TRUE(known.warnings == told);
}

TEST(HasAllPhotosOf, MissesOneThatIsReadFromAnotherFileNow) {
  alignment::AlignedFlight known;
  known.photos.resize(1);
  known.photos[0].photo.name = "a";
  flight::Flight read;
  read.photos = {GreyPhoto("a", SampleKind::kLevels, 255.0), GreyPhoto("b", SampleKind::kLevels, 255.0)};
  EXPECT_TRUE(HasAllPhotosOf(known, read));
  read.photos = {GreyPhoto("a_geotag", SampleKind::kLevels, 255.0)};
  EXPECT_FALSE(HasAllPhotosOf(known, read));
}

// All photos but the `first` ones, as recorded.
poses::PosedFlight Posed(const simulate::SimulatedFlight& truth, std::size_t first = 0) {
  poses::PosedFlight posed;
  posed.frame = truth.frame;
  posed.report.height_rule = "by the log; the ground lies 0.3 m lower";
  for (std::size_t i = first; i < truth.photos.size(); ++i) {
    poses::PosedPhoto photo;
    photo.photo = truth.photos[i].photo;
    photo.photo.intrinsics = truth.options.intrinsics;
    photo.cam_from_enu = truth.photos[i].pose.cam_from_enu;
    photo.covariance = 1e-3 * poses::Matrix6d::Identity();
    photo.height_above_ground_m = photo.cam_from_enu.TargetOriginInSource().z();
    photo.error_radius_m = 1.5;
    posed.photos.push_back(photo);
  }
  return posed;
}

// By what the photos record alone.
FlightFacts AppendByRecords(const FlightFacts& known, const poses::PosedFlight& posed) {
  MosaicOptions options;
  options.method = AlignMethod::kImu;
  SilentProgress progress;
  auto grown = AppendPhotos(known, posed, options, flight::FilePhotoSource(), progress);
  EXPECT_TRUE(grown && *grown);
  return grown && *grown ? **grown : FlightFacts{};
}

// The last three of a flight, which was moved as a whole, are added by their records.
struct Added : Displaced {
  static constexpr std::size_t kFinished = 17;
  std::vector<alignment::AlignedPhoto> moved;  // where all of it lies on the moved map

  explicit Added(const Displacement& by) : Displaced(by), moved(known.flight.photos) {
    known.flight.photos.resize(kFinished);
    for (alignment::AlignedPhoto& photo : known.flight.photos)
      photo.photo.intrinsics = truth.options.intrinsics;
  }

  FlightFacts Append() const { return AppendByRecords(known, Posed(truth)); }

  // From `expected` to where the added ones were put.
  double WorstAddedM(const std::vector<geo::Rigid3>& expected) const {
    const FlightFacts grown = Append();
    EXPECT_EQ(grown.flight.photos.size(), expected.size());
    double worst_m = 0.0;
    for (std::size_t i = kFinished; i < grown.flight.photos.size(); ++i) {
      const geo::Rigid3& now = grown.flight.photos[i].cam_from_enu;
      worst_m = std::max(worst_m, (now.TargetOriginInSource() - expected[i].TargetOriginInSource()).norm());
      EXPECT_LT(now.rotation.angularDistance(expected[i].rotation), 1e-3);
    }
    return worst_m;
  }

  std::vector<geo::Rigid3> OnMovedMap() const {
    std::vector<geo::Rigid3> poses;
    for (const alignment::AlignedPhoto& photo : moved) poses.push_back(photo.cam_from_enu);
    return poses;
  }
  std::vector<geo::Rigid3> AsRecorded() const {
    std::vector<geo::Rigid3> poses;
    for (const simulate::SimulatedPhoto& photo : truth.photos) poses.push_back(photo.pose.cam_from_enu);
    return poses;
  }
};

TEST(AppendPhotos, GoWhereAMapWasMovedTo) {
  const Added far({0.0, 1.0, {150.0, 280.0}});
  EXPECT_LT(far.WorstAddedM(far.OnMovedMap()), 0.1) << "shifted, as by surveyed points";
  Added turned({0.4, 1.5, {3000.0, -70.0}});
  turned.known.flight.frame = geo::LocalFrame({0.0, 0.0, 0.0});  // a map that lay nowhere
  EXPECT_LT(turned.WorstAddedM(turned.OnMovedMap()), 0.1) << "turned and scaled";
  EXPECT_NEAR(turned.Append().flight.photos.back().height_above_ground_m,
              turned.moved.back().height_above_ground_m, 0.1);
}

TEST(AppendPhotos, GoWhereTheyWereRecordedOnAMapThatErrsAsReceiversDo) {
  Added near({0.0, 1.0, {2.0, -1.0}});
  EXPECT_LT(near.WorstAddedM(near.AsRecorded()), 1e-6);
  near.known.is_by_hand = true;  // what somebody said holds for them too
  EXPECT_LT(near.WorstAddedM(near.OnMovedMap()), 0.1);
}

TEST(AppendPhotos, LeaveAMapPlacedThatSomebodyPlacedAndNoneNowhereThatTheyPlace) {
  Added map({0.0, 1.0, {0.0, 0.0}});
  poses::PosedFlight nowhere = Posed(map.truth);
  nowhere.is_placed = nowhere.report.is_placed = false;
  EXPECT_TRUE(AppendByRecords(map.known, nowhere).poses_report.is_placed);
  map.known.is_placed = false;
  EXPECT_FALSE(AppendByRecords(map.known, nowhere).poses_report.is_placed);
  SilentProgress progress;
  const auto grown =
      test::ValueOf(AppendPhotos(map.known, Posed(map.truth), {}, flight::FilePhotoSource(), progress));
  EXPECT_FALSE(grown.has_value()) << "better to place the flight as a whole";
}

TEST(AppendPhotos, TellOfAllThatCameLaterTogether) {
  Added map({0.0, 1.0, {0.0, 0.0}});
  map.known.height_rule = "guessed";
  poses::PosedFlight posed = Posed(map.truth);
  posed.photos.resize(Added::kFinished + 1);
  map.known = AppendByRecords(map.known, posed);
  const FlightFacts twice = map.Append();
  EXPECT_EQ(twice.height_rule, "guessed; of photos added since: by the log");
  ASSERT_EQ(twice.flight.warnings.size(), 1U);
  EXPECT_TRUE(twice.flight.warnings[0] == flight::Remark(flight::RemarkCode::kPhotosAdded, {{"photos", 3}}));
}

TEST(AppendPhotos, SayWhatIsRemarkedWhileTheyArePosedAndAlignedAndNothingTwice) {
  using flight::Remark;
  using flight::RemarkCode;
  const auto repeated = [](int photos, int total) {
    return Remark{RemarkCode::kPositionsRepeated, {{"photos", photos}, {"total", total}}};
  };
  const auto no_angles = [](int photos, int total) {
    return Remark{RemarkCode::kNoAngles, {{"photos", photos}, {"total", total}}};
  };
  const auto assumed = [&](int photos, int total) {
    return Remark{RemarkCode::kSentences,
                  {{"first", no_angles(photos, total)}, {"then", Remark(RemarkCode::kAnglesAssumed)}}};
  };
  Added map({0.0, 1.0, {0.0, 0.0}});
  poses::PosedFlight posed = Posed(map.truth);
  posed.photos.resize(Added::kFinished + 1);
  posed.warnings = {repeated(2, 18)};
  posed.assumptions.push_back({no_angles(1, 18), RemarkCode::kAnglesAssumed, std::nullopt});
  map.known.flight.warnings = {repeated(1, 17)};
  const FlightFacts once = AppendByRecords(map.known, posed);
  const Remark one_added{RemarkCode::kPhotosAdded, {{"photos", 1}}};
  EXPECT_TRUE(once.flight.warnings == (std::vector<Remark>{repeated(2, 18), assumed(1, 18), one_added}));

  posed = Posed(map.truth);
  posed.warnings = {repeated(2, 20)};
  posed.assumptions.push_back({no_angles(3, 20), RemarkCode::kAnglesAssumed, std::nullopt});
  const FlightFacts twice = AppendByRecords(once, posed);
  const Remark all_added{RemarkCode::kPhotosAdded, {{"photos", 3}}};
  EXPECT_TRUE(twice.flight.warnings == (std::vector<Remark>{assumed(3, 20), repeated(2, 20), all_added}));
}

// The last photo of a flight was left out of its map, and comes again with two that are new.
struct LeftOut : Displaced {
  static constexpr std::size_t kFirst = 6, kFinished = 17;  // the map's photos: so few are rendered
  std::string name;

  LeftOut() : Displaced(Displacement{}), name(truth.photos.back().photo.name) {
    std::vector<alignment::AlignedPhoto>& photos = known.flight.photos;
    photos.resize(kFinished);
    photos.erase(photos.begin(), photos.begin() + kFirst);
    for (alignment::AlignedPhoto& photo : photos) photo.photo.intrinsics = truth.options.intrinsics;
    known.flight.left_out = {{name, ErrorCode::kNoPosition, flight::RemarkCode::kLeftWithoutPosition}};
    alignment::AlignReport figures;
    figures.photos = 12;
    figures.aligned = 11;
    figures.photo_reports.resize(1);
    figures.photo_reports[0].name = name;
    known.align_report = figures;
  }

  FlightFacts Append(AlignMethod method) const { return Append(Posed(truth, kFirst), method); }

  FlightFacts Append(const poses::PosedFlight& posed, AlignMethod method = AlignMethod::kAuto) const {
    const std::optional<FlightFacts> grown = TryToAppend(posed, test::PhotosOf(truth), method);
    EXPECT_TRUE(grown);
    return grown.value_or(FlightFacts{});
  }

  std::optional<FlightFacts> TryToAppend(const poses::PosedFlight& posed, const flight::PhotoSource& source,
                                         AlignMethod method = AlignMethod::kAuto) const {
    MosaicOptions options;
    options.method = method;
    options.threads = 2;
    SilentProgress progress;
    auto grown = AppendPhotos(known, posed, options, source, progress);
    EXPECT_TRUE(grown.ok());
    return grown ? *std::move(grown) : std::nullopt;
  }

  // Takes one from amid the map's photos, so that it can come later. Its name.
  std::string TakeOut(std::size_t number) {
    std::vector<alignment::AlignedPhoto>& photos = known.flight.photos;
    const std::string taken = photos[number].photo.name;
    photos.erase(photos.begin() + static_cast<std::ptrdiff_t>(number));
    return taken;
  }

  // As recorded, up to the last of the map's photos or some more.
  poses::PosedFlight UpToMap(std::size_t more = 0) const {
    poses::PosedFlight posed = Posed(truth, kFirst);
    posed.photos.resize(kFinished - kFirst + more);
    return posed;
  }

  // From the truth to where it was put.
  double OffM(const alignment::AlignedPhoto& photo) const {
    for (const simulate::SimulatedPhoto& real : truth.photos) {
      if (real.photo.name == photo.photo.name) {
        return (photo.cam_from_enu.TargetOriginInSource() - real.pose.cam_from_enu.TargetOriginInSource())
            .norm();
      }
    }
    return 1e9;
  }
};

// As if the photo had recorded nothing.
void Forget(const std::string& name, poses::PosedFlight& posed) {
  const auto found = std::find_if(posed.photos.begin(), posed.photos.end(),
                                  [&](const poses::PosedPhoto& photo) { return photo.photo.name == name; });
  ASSERT_NE(found, posed.photos.end());
  flight::Photo bare = found->photo;
  bare.position.reset();
  bare.attitude.reset();
  posed.unplaced.push_back(std::move(bare));
  posed.left_out.push_back({name, ErrorCode::kNoPosition, flight::RemarkCode::kLeftWithoutPosition});
  posed.photos.erase(found);
}

TEST(AppendPhotos, TakeInOneThatWasLeftOutWhereItTiesNow) {
  const LeftOut map;
  const FlightFacts grown = map.Append(AlignMethod::kAuto);
  ASSERT_EQ(grown.flight.photos.size(), 14U);
  EXPECT_EQ(grown.flight.photos.back().photo.name, map.name);
  EXPECT_EQ(grown.flight.photos.back().placement, alignment::Placement::kAligned);
  EXPECT_TRUE(grown.flight.left_out.empty());
  ASSERT_TRUE(grown.align_report);
  EXPECT_EQ(grown.align_report->photos, 14);
  EXPECT_EQ(grown.align_report->photo_reports.size(), 3U) << "one of each";
  EXPECT_GT(grown.align_report->components, 0);
  EXPECT_GT(grown.align_report->tie_points, 0);
}

TEST(AppendPhotos, CountOneThatComesInOnceThoughItWasAlignedBefore) {
  LeftOut map;
  map.known.align_report->aligned = 12;
  map.known.align_report->photo_reports[0].placement = alignment::Placement::kAligned;
  map.known.align_report->pairs.resize(2);
  map.known.align_report->pairs[0].first = map.name;
  const FlightFacts grown = map.Append(AlignMethod::kAuto);
  ASSERT_TRUE(grown.align_report);
  const alignment::AlignReport& figures = *grown.align_report;
  EXPECT_EQ(figures.photos, 14);
  EXPECT_EQ(figures.aligned, 11 + std::count_if(figures.photo_reports.begin(), figures.photo_reports.end(),
                                                [](const alignment::AlignPhotoReport& photo) {
                                                  return photo.placement == alignment::Placement::kAligned;
                                                }));
  EXPECT_TRUE(std::none_of(
      figures.pairs.begin(), figures.pairs.end(),
      [&](const alignment::AlignPairReport& pair) { return pair.first == map.name && pair.second.empty(); }));
}

// Some photos are damaged files.
class Without final : public flight::PhotoSource {
 public:
  Without(const simulate::SimulatedFlight& truth, std::set<std::string> damaged)
      : source_(test::PhotosOf(truth)), damaged_(std::move(damaged)) {}
  Result<image::DecodedImage> Decode(const flight::Photo& photo, int denominator) const override {
    if (damaged_.contains(photo.name)) return Error{ErrorCode::kCorrupt, "the file is cut off", ""};
    return source_.Decode(photo, denominator);
  }

 private:
  simulate::SimulatedPhotoSource source_;
  std::set<std::string> damaged_;
};

TEST(AppendPhotos, DoNotPassForTiedBecauseOneThatWasLeftOutIs) {
  LeftOut map;
  map.known.flight.left_out[0].name = map.truth.photos[LeftOut::kFinished].photo.name;
  const poses::PosedFlight posed = map.UpToMap(2);
  const Without source(map.truth, {posed.photos.back().photo.name});  // the one that is new
  EXPECT_FALSE(map.TryToAppend(posed, source));
}

TEST(AppendPhotos, FindOneThatRecordsNothingAnywhereOnTheMap) {
  LeftOut map;
  const std::string bare = map.TakeOut(5);
  poses::PosedFlight posed = map.UpToMap();
  Forget(bare, posed);
  const FlightFacts grown = map.Append(posed);
  ASSERT_EQ(grown.flight.photos.size(), 11U);
  EXPECT_EQ(grown.flight.photos.back().photo.name, bare);
  EXPECT_EQ(grown.flight.photos.back().placement, alignment::Placement::kAligned);
  EXPECT_FALSE(grown.flight.photos.back().photo.position) << "as recorded";
  for (const alignment::AlignedPhoto& photo : grown.flight.photos)
    EXPECT_LT(map.OffM(photo), photo.photo.name == bare ? 2.0 : 1e-9) << photo.photo.name;
  EXPECT_EQ(grown.flight.left_out.size(), 1U) << "the one that it lacked before";
}

// As if it were said to be elsewhere.
void MoveRecord(const std::string& name, const Eigen::Vector3d& by_m, poses::PosedFlight& posed) {
  for (poses::PosedPhoto& photo : posed.photos) {
    if (photo.photo.name != name) continue;
    photo.cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(
        photo.cam_from_enu.rotation, photo.cam_from_enu.TargetOriginInSource() + by_m);
  }
}

TEST(AppendPhotos, FindOneThatIsSaidToBeFarOff) {
  LeftOut map;
  const std::string far = map.TakeOut(5);
  poses::PosedFlight posed = map.UpToMap();
  MoveRecord(far, {900.0, 400.0, 0.0}, posed);
  const FlightFacts grown = map.Append(posed);
  ASSERT_EQ(grown.flight.photos.size(), 11U);
  EXPECT_EQ(grown.flight.photos.back().photo.name, far);
  EXPECT_LT(map.OffM(grown.flight.photos.back()), 2.0);
}

// Neither the last photos of the map nor those nearest to where it is said to be show anything of it.
TEST(AppendPhotos, FindOneThatIsSaidToBeFarOffBesideThoseTakenAfterIt) {
  LeftOut map;
  map.known = Displaced(Displacement{}).known;
  for (alignment::AlignedPhoto& photo : map.known.flight.photos)
    photo.photo.intrinsics = map.truth.options.intrinsics;
  const std::string far = map.TakeOut(0);  // the southern end of the first line
  poses::PosedFlight posed = Posed(map.truth);
  MoveRecord(far, {0.0, 900.0, 0.0}, posed);
  const FlightFacts grown = map.Append(posed);
  ASSERT_EQ(grown.flight.photos.size(), 20U);
  EXPECT_EQ(grown.flight.photos.back().photo.name, far);
  EXPECT_EQ(grown.flight.photos.back().placement, alignment::Placement::kAligned);
  EXPECT_LT(map.OffM(grown.flight.photos.back()), 2.0);
}

TEST(AppendPhotos, MoveNothingForOneBesideTheMapThatTiesToNothing) {
  LeftOut map;
  const std::string beside = map.TakeOut(5);
  poses::PosedFlight posed = map.UpToMap();
  MoveRecord(beside, {-250.0, 0.0, 0.0}, posed);
  const auto grown = map.TryToAppend(posed, Without(map.truth, {beside}));
  ASSERT_TRUE(grown) << "its record places it";
  ASSERT_EQ(grown->flight.photos.size(), 11U);
  EXPECT_EQ(grown->flight.photos.back().photo.name, beside);
  EXPECT_EQ(grown->flight.photos.back().placement, alignment::Placement::kPoseOnly);
}

TEST(AppendPhotos, TakeInOneThatRecordsNothingWhereNewOnesBridgeToIt) {
  const LeftOut map;
  poses::PosedFlight posed = Posed(map.truth, LeftOut::kFirst);
  Forget(map.name, posed);
  const FlightFacts grown = map.Append(posed);
  ASSERT_EQ(grown.flight.photos.size(), 14U);
  EXPECT_EQ(grown.flight.photos.back().photo.name, map.name);
  EXPECT_LT(map.OffM(grown.flight.photos.back()), 2.0);
  EXPECT_TRUE(grown.flight.left_out.empty());
}

TEST(AppendPhotos, LeaveOutOneThatNothingPlacesForThatReason) {
  LeftOut map;
  const std::string bare = map.TakeOut(5);
  poses::PosedFlight posed = map.UpToMap(1);
  Forget(bare, posed);
  const auto grown = test::ValueOf(map.TryToAppend(posed, Without(map.truth, {bare})));
  EXPECT_EQ(grown.flight.photos.size(), 11U) << "the other one came";
  ASSERT_EQ(grown.flight.left_out.size(), 2U);
  EXPECT_EQ(grown.flight.left_out[1].name, bare);
  EXPECT_EQ(grown.flight.left_out[1].reason.code, flight::RemarkCode::kLeftWithoutPosition);
}

TEST(AppendPhotos, LeaveSeveralThatNothingPlacesToTheWholeFlight) {
  LeftOut map;
  const std::string first = map.TakeOut(5), second = map.TakeOut(5);
  poses::PosedFlight posed = map.UpToMap();
  Forget(first, posed);
  Forget(second, posed);
  EXPECT_FALSE(map.TryToAppend(posed, Without(map.truth, {first, second})));
}

TEST(AppendPhotos, LeaveOutAgainWhatNothingTies) {
  const LeftOut map;
  const FlightFacts grown = map.Append(AlignMethod::kImu);
  EXPECT_EQ(grown.flight.photos.size(), 13U);
  ASSERT_EQ(grown.flight.left_out.size(), 1U);
  EXPECT_EQ(grown.flight.left_out[0].name, map.name);
}

TEST(KeepSampleRanges, GivesNewPhotosTheRangeOfTheirCameraAndKind) {
  alignment::AlignedFlight known;
  known.photos.resize(1);
  known.photos[0].photo = GreyPhoto("a", SampleKind::kFloating, 40.0);
  std::vector<flight::Photo> photos{GreyPhoto("b", SampleKind::kFloating, 45.0),
                                    GreyPhoto("c", SampleKind::kLevels, 9000.0),
                                    GreyPhoto("d", SampleKind::kFloating, 45.0)};
  photos[2].sample_range.reset();
  KeepSampleRanges(known, photos);
  EXPECT_EQ(photos[0].sample_range->high, 40.0);
  EXPECT_EQ(photos[1].sample_range->high, 9000.0);
  EXPECT_FALSE(photos[2].sample_range) << "one that cannot be decoded";
}

}  // namespace
}  // namespace skyquilt::pipeline
