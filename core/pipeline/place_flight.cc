#include "core/pipeline/place_flight.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "core/alignment/align_by_pose.h"
#include "core/alignment/align_flight.h"
#include "core/bands/calibrate_by_panels.h"
#include "core/base/median.h"
#include "core/base/process/large_blocks_apart.h"
#include "core/base/try.h"
#include "core/flight/photos/sample_format.h"
#include "core/flight/remarks/because.h"
#include "core/flight/remarks/remark_words.h"
#include "core/geo/crs/reference_system.h"
#include "core/geo/lat_lon.h"
#include "core/ground/model_ground.h"
#include "core/pipeline/append_photos.h"
#include "core/pipeline/build_bands.h"
#include "core/pipeline/placing/control_points.h"
#include "core/pipeline/placing/move_flight.h"
#include "core/pipeline/placing/place_by_lists.h"
#include "core/pipeline/placing/place_known.h"
#include "core/pipeline/placing/recall_flight.h"
#include "core/pipeline/surface/choose_ground.h"
#include "core/poses/estimate_poses.h"
#include "core/poses/lists/compare_sources.h"
#include "core/poses/lists/marked_photos.h"
#include "core/poses/plausible_poses.h"
#include "core/render/plan_mosaic.h"

namespace skyquilt::pipeline {
namespace {

using flight::InputFile;

constexpr std::size_t kManyFiles = 500;  // whose features are most of the memory

// What lies in a zone of UTM cannot be written where there is none.
template <typename Flight>
Result<void> CheckUtm(const Flight& flight, const MosaicOptions& options) {
  const bool is_wanted = options.write_utm || options.heights != MapHeights::kNone;
  if (!is_wanted || flight.photos.empty()) return {};
  for (const auto& photo : flight.photos) {
    const geo::Wgs84 at = flight.frame.Wgs84FromEnu(photo.cam_from_enu.TargetOriginInSource());
    if (geo::IsWithinUtm({at.lat_deg, at.lon_deg})) return {};
  }
  return flight::Because(ErrorCode::kUnprocessable, flight::RemarkCode::kFailBeyondUtm);
}

// What a flight's records say already of what was asked for is better refused before photos are compared.
// Recorded places may be wrong, so that only what is far away is refused here; PlanMosaic refuses the rest.
Result<void> CheckBoundaryIsNear(const poses::PosedFlight& posed, const geo::Boundary& boundary) {
  constexpr double kMetresPerDegree = 111'320.0;
  constexpr double kFarM = 5'000.0, kFarInHeights = 20.0;
  if (!posed.is_placed || posed.photos.empty()) return {};
  const geo::LatLonBounds bounds = boundary.Bounds();
  const geo::LatLon middle = bounds.Middle();
  for (const poses::PosedPhoto& photo : posed.photos) {
    const geo::Wgs84 at = posed.frame.Wgs84FromEnu(photo.cam_from_enu.TargetOriginInSource());
    const double far_deg =
        (kFarM + kFarInHeights * std::max(0.0, photo.height_above_ground_m)) / kMetresPerDegree;
    const double far_lon_deg = far_deg / std::max(0.05, std::cos(geo::DegToRad(at.lat_deg)));
    const double beyond_lat_deg =
        std::abs(at.lat_deg - middle.lat_deg) - 0.5 * (bounds.north_deg - bounds.south_deg);
    const double beyond_lon_deg = std::abs(std::remainder(at.lon_deg - middle.lon_deg, 360.0)) -
                                  0.5 * (bounds.east_deg - bounds.west_deg);
    if (!(beyond_lat_deg > far_deg || beyond_lon_deg > far_lon_deg)) return {};
  }
  const geo::Wgs84& origin = posed.frame.origin();
  return render::BoundaryElsewhere(boundary, {origin.lat_deg, origin.lon_deg});
}

// By the heights that were recorded.
Result<void> CheckGsdByRecords(const poses::PosedFlight& posed, const MosaicOptions& options) {
  std::vector<double> gsds_m;
  for (const poses::PosedPhoto& photo : posed.photos)
    gsds_m.push_back(photo.height_above_ground_m / photo.photo.intrinsics.MeanFocalPx());
  std::erase_if(gsds_m, [](double gsd_m) { return !(gsd_m > 0.0 && std::isfinite(gsd_m)); });
  if (!posed.is_placed || gsds_m.empty()) return {};
  return options.CheckGsd(Median(std::move(gsds_m)));
}

Result<poses::PosedFlight> Pose(const flight::Flight& flight, const MosaicOptions& options,
                                const geo::DemSource* dem, StageRunner& stages, bool keep_unplaced) {
  return stages.Run("pose", [&] {
    return poses::EstimatePoses(
        flight, {options.origin, options.landed_at_start, dem, keep_unplaced, options.takeoff_height_amsl_m});
  });
}

Result<alignment::AlignedFlight> Align(const poses::PosedFlight& posed,
                                       const std::vector<flight::GcpList>& control,
                                       const MosaicOptions& options, const flight::PhotoSource& source,
                                       alignment::FoundFeatures found, alignment::AlignReport& report,
                                       Progress& progress) {
  alignment::AlignOptions align_options;
  align_options.threads = options.threads;
  align_options.control = ControlPointsOf(control);
  switch (options.method) {
    case AlignMethod::kImu:
      return alignment::AlignByPoseOnly(posed);
    case AlignMethod::kAuto:
      break;
    case AlignMethod::kImages:
      align_options.by_images = alignment::ByImages::kAlways;
      break;
  }
  return alignment::AlignFlight(posed, source, align_options, report, progress, std::move(found));
}

// In the order of the placed photos.
std::vector<render::Thumbnail> Ordered(const alignment::AlignedFlight& flight,
                                       const std::vector<render::Thumbnail>& thumbnails) {
  std::map<std::string, const render::Thumbnail*> by_name;
  for (const render::Thumbnail& thumbnail : thumbnails) by_name[thumbnail.photo_name] = &thumbnail;
  std::vector<render::Thumbnail> ordered;
  ordered.reserve(flight.photos.size());
  for (const alignment::AlignedPhoto& photo : flight.photos) ordered.push_back(*by_name.at(photo.photo.name));
  return ordered;
}

// By the heights that the photos carry, or over the ground where it is known.
std::size_t FilterOutliers(const ground::GroundSurface* ground, alignment::AlignedFlight& flight) {
  return poses::LeaveOutImplausible(
      flight.frame,
      [&](const alignment::AlignedPhoto& photo) {
        const Eigen::Vector3d center = photo.cam_from_enu.TargetOriginInSource();
        const double height_m = ground == nullptr || !center.allFinite()
                                    ? photo.height_above_ground_m
                                    : center.z() - ground->HeightAt(center.head<2>());
        return poses::CameraStand{photo.intrinsics, photo.cam_from_enu, height_m};
      },
      flight.photos, flight.left_out);
}

Error NothingLeft(const alignment::AlignedFlight& flight) {
  return flight::Because(ErrorCode::kUnprocessable, {flight::RemarkCode::kFailNoneDrawable,
                                                     {{"left", poses::FirstImplausible(flight.left_out)}}});
}

Result<FlightFacts> PlaceAnew(flight::Flight read, const MosaicOptions& options,
                              const flight::PhotoSource& source, const geo::DemSource* dem,
                              StageRunner& stages, Progress& progress, CheckedPhotos known) {
  SKYQUILT_TRY_ASSIGN(auto checked, stages.Run("check", [&] {
    return CheckPhotos(std::move(read), source, MayGoByImages(options), options.threads, progress,
                       std::move(known));
  }));
  SKYQUILT_TRY_ASSIGN(auto posed, Pose(checked.flight, options, dem, stages, MayGoByImages(options)));
  if (checked.flight.gcp_lists.empty()) {  // else these decide the place
    if (options.boundary) SKYQUILT_TRY(CheckBoundaryIsNear(posed, *options.boundary));
    if (posed.is_placed) SKYQUILT_TRY(CheckUtm(posed, options));
  }
  SKYQUILT_TRY(CheckGsdByRecords(posed, options));
  alignment::AlignReport report;
  SKYQUILT_TRY_ASSIGN(auto aligned, stages.Run("align", [&] {
    return Align(posed, checked.flight.gcp_lists, options, source, std::move(checked.features), report,
                 progress);
  }));
  FilterOutliers(nullptr, aligned);
  if (aligned.photos.empty()) return NothingLeft(aligned);
  FlightFacts facts;
  facts.ground = stages.Run("ground", [&] {
    std::optional<ground::ElevationModel> model;
    if (dem != nullptr && posed.dem_zero_m) model = ground::ElevationModel{dem, *posed.dem_zero_m};
    return ground::ModelGround(aligned, facts.ground_report, model);
  });
  FilterOutliers(&facts.ground, aligned);
  if (aligned.photos.empty()) return NothingLeft(aligned);
  facts.flight = std::move(aligned);
  facts.ground_choice = ChooseGround(facts.flight, facts.ground);
  facts.thumbnails = Ordered(facts.flight, checked.thumbnails);
  facts.poses_report = posed.report;
  facts.height_rule = posed.report.height_rule;
  facts.is_by_images =
      std::any_of(report.photo_reports.begin(), report.photo_reports.end(),
                  [](const alignment::AlignPhotoReport& photo) { return photo.is_by_images; });
  facts.is_placed = report.by_images.is_taken ? report.by_images.is_placed : posed.is_placed;
  if (options.method != AlignMethod::kImu) facts.align_report = std::move(report);
  return facts;
}

// `lists` as the map knew them: what it was not placed by is new to the next run too.
void KeepAsKnown(const std::vector<NamedDigest>& known, const std::set<std::string>& lists,
                 std::vector<NamedDigest>& inputs) {
  std::erase_if(inputs, [&](const NamedDigest& input) { return lists.contains(input.file.name); });
  for (const NamedDigest& input : known) {
    if (lists.contains(input.file.name)) inputs.push_back(input);
  }
}

// The finished map of these files, where the user says that it lies; surveyed points may have come or changed
// since it was made. `inputs`: becomes what the placed map is of. `contradict`: whether the finished map only
// fits them when it is bent.
Result<PlacedFlight> PlaceWhereTold(const flight::Flight& read, const PlaceRequest& request,
                                    const pyramid::MapMemory* memory, std::vector<NamedDigest>& inputs,
                                    StageRunner& stages, bool& contradict) {
  std::optional<Recalled> recalled;
  const std::set<std::string> lists = NamesOf(read.gcp_lists);
  if (memory != nullptr) recalled = RecallFiles(*memory, inputs, lists);
  if (!recalled || !recalled->added.empty() || !recalled->facts.appearance ||
      !HasAllPhotosOf(recalled->facts.flight, read)) {
    return flight::Because(ErrorCode::kConflict, flight::RemarkCode::kFailMapChanged);
  }
  FillPhotos(read, recalled->facts.flight);
  PlaceRequest named = request;
  const poses::NamedPhotos photos(read.photos);
  std::vector<flight::Remark> on_marks;
  bool is_any_found = false;
  for (flight::GcpList& list : named.control) {
    const poses::MarkedPhotosFound found = poses::FindMarkedPhotos(read.photos, photos, list);
    on_marks.insert(on_marks.end(), found.remarks.begin(), found.remarks.end());
    is_any_found = is_any_found || !list.sightings.empty();
  }
  // Without a mark there are no points of which anything else could be said.
  if (!is_any_found && !on_marks.empty())
    return flight::Because(ErrorCode::kUnprocessable, flight::InARow(std::move(on_marks)));
  for (const flight::Remark& told : on_marks) {
    std::vector<flight::Remark>& warnings = recalled->facts.flight.warnings;
    std::erase(warnings, told);  // of an earlier run
    warnings.push_back(told);
  }
  PlacedFlight placed;
  const double was_m = MedianGsdM(recalled->facts);
  SKYQUILT_TRY_ASSIGN(placed.facts, stages.Run("align", [&] {
    return request.is_by_lists ? PlaceByLists(recalled->facts, read.gcp_lists, &contradict)
                               : PlaceKnown(recalled->facts, named);
  }));
  if (request.is_by_lists)
    TellReading(read, placed.facts.flight);
  else
    KeepAsKnown(recalled->facts.inputs, lists, inputs);
  if (!named.control.empty()) TellMarks(named.control, placed.facts);
  placed.gsd_m = recalled->facts.appearance->gsd_m * MedianGsdM(placed.facts) / was_m;
  return placed;
}

// Nothing: better to place the flight as a whole.
Result<std::optional<FlightFacts>> PlaceAdded(Recalled recalled, const flight::Flight& read,
                                              const MosaicOptions& options, const flight::PhotoSource& source,
                                              const geo::DemSource* dem, StageRunner& stages,
                                              Progress& progress) {
  FlightFacts& known = recalled.facts;
  FillPhotos(read, known.flight);
  std::set<std::string> names;
  for (const NamedDigest& input : recalled.added) names.insert(input.file.name);
  // Photos that nothing placed are tried again; damaged ones are what they were.
  std::set<std::string> left_out, tried = names;
  for (const flight::LeftOutPhoto& photo : known.flight.left_out) {
    left_out.insert(photo.name);
    if (photo.code == ErrorCode::kNoPosition) tried.insert(photo.name);
  }
  flight::Flight whole = read, added;
  KeepSampleRanges(known.flight, whole.photos);
  std::copy_if(whole.photos.begin(), whole.photos.end(), std::back_inserter(added.photos),
               [&](const flight::Photo& photo) { return tried.contains(photo.name); });
  std::erase_if(whole.photos, [&](const flight::Photo& photo) {
    return tried.contains(photo.name) || left_out.contains(photo.name);
  });
  whole.left_out.clear();  // told of below, once
  SKYQUILT_TRY_ASSIGN(auto checked, stages.Run("check", [&] {
    return CheckPhotos(std::move(added), source, false, options.threads, progress);
  }));
  whole.photos.insert(whole.photos.end(), checked.flight.photos.begin(), checked.flight.photos.end());
  std::stable_sort(whole.photos.begin(), whole.photos.end(),
                   [](const flight::Photo& a, const flight::Photo& b) {
                     return a.captured_at != b.captured_at ? a.captured_at < b.captured_at : a.name < b.name;
                   });
  SKYQUILT_TRY_ASSIGN(auto posed, Pose(whole, options, dem, stages, MayGoByImages(options)));
  auto grown = stages.Run("align", [&] { return AppendPhotos(known, posed, options, source, progress); });
  if (!grown || !*grown) return grown;
  // What is left out now may be of the finished flight: then its tones and labels count other photos.
  const std::size_t finished = recalled.facts.flight.photos.size();
  alignment::AlignedFlight& flight = (*grown)->flight;
  if (FilterOutliers(&(*grown)->ground, flight) > 0) {
    const auto is_finished = [&](std::size_t i) {
      return i < flight.photos.size() &&
             flight.photos[i].photo.name == recalled.facts.flight.photos[i].photo.name;
    };
    for (std::size_t i = 0; i < finished; ++i) {
      if (!is_finished(i)) return std::optional<FlightFacts>();
    }
  }
  for (const std::vector<flight::LeftOutPhoto>& list : {read.left_out, checked.flight.left_out}) {
    for (const flight::LeftOutPhoto& photo : list) {
      if (names.contains(photo.name)) (*grown)->flight.left_out.push_back(photo);
    }
  }
  std::vector<render::Thumbnail> thumbnails = known.thumbnails;
  thumbnails.insert(thumbnails.end(), checked.thumbnails.begin(), checked.thumbnails.end());
  (*grown)->thumbnails = Ordered((*grown)->flight, thumbnails);
  return grown;
}

Result<flight::Flight> Read(const std::vector<InputFile>& files, const MosaicOptions& options,
                            const flight::PhotoSource& source, bands::Captures& captures,
                            Progress& progress) {
  SKYQUILT_TRY_ASSIGN(flight::Flight flight, flight::ReadFlight(files, options.threads, progress));
  captures = bands::SetBandsApart(flight, options.threads);
  SKYQUILT_TRY(poses::CompareSources(flight));
  bands::CalibrateByPanels(flight, captures, source);
  flight::ChooseSampleRanges(flight.photos, source, options.threads);
  if (options.readout_s) {
    for (flight::Photo& photo : flight.photos) photo.readout_s = options.readout_s;
  }
  return flight;
}

// A map that is brought elsewhere stays cut as it was.
std::optional<geo::Boundary> BoundaryOf(const MosaicOptions& options, const pyramid::MapMemory* memory) {
  if (options.boundary || !options.placing || memory == nullptr) return options.boundary;
  const Result<FlightFacts> known = ParseFacts(memory->Recall());
  return known ? known->boundary : std::nullopt;
}

}  // namespace

bool MayGoByImages(const MosaicOptions& options) {
  return options.method == AlignMethod::kAuto || options.method == AlignMethod::kImages;
}

Result<PlacedFlight> PlaceFlight(const std::vector<InputFile>& files, const MosaicOptions& options,
                                 const flight::PhotoSource& source, const geo::DemSource* dem,
                                 const pyramid::MapMemory* memory, StageRunner& stages, Progress& progress,
                                 FoundFiles found) {
  const LargeBlocksApart features_apart(files.size() >= kManyFiles);
  std::vector<NamedDigest> inputs;
  bands::Captures captures;
  auto read = stages.Run("read", [&] {
    if (memory != nullptr || !found.digests.empty())
      inputs = DigestsOf(files, found.digests, options.threads);
    return Read(files, options, source, captures, progress);
  });
  if (!read) return read.error();

  const std::vector<flight::GcpList> lists = read->gcp_lists;
  PlacedFlight placed;
  std::optional<FlightFacts> facts, placed_by_hand;
  bool is_told = options.placing.has_value(), is_less = false;
  if (is_told) {
    bool contradict = false;
    Result<PlacedFlight> told = PlaceWhereTold(*read, *options.placing, memory, inputs, stages, contradict);
    // Bent to such points is a map whose photos are aligned anew with them, as of a flight that came with
    // them.
    is_told = told || !contradict;
    if (is_told) {
      SKYQUILT_TRY_ASSIGN(placed, std::move(told));
      facts = std::move(placed.facts);
    }
  } else if (memory != nullptr) {
    std::optional<Recalled> recalled = RecallPlaced(*memory, options, inputs);
    if (recalled && recalled->facts.is_by_hand && read->gcp_lists.empty()) placed_by_hand = recalled->facts;
    is_less = !recalled;
    if (is_less && read->gcp_lists.empty()) placed_by_hand = RecallPlacedByHand(*memory, options, inputs);
    if (recalled && HasAllPhotosOf(recalled->facts.flight, *read)) {
      if (recalled->added.empty()) {
        facts = std::move(recalled->facts);
        FillPhotos(*read, facts->flight);
      } else if (dem == nullptr && MayMove(*recalled, *read, options)) {
        FillPhotos(*read, recalled->facts.flight);
        facts = stages.Run("align", [&] { return MoveToControl(recalled->facts, read->gcp_lists); });
        if (facts) TellReading(*read, facts->flight);
      } else if (dem == nullptr && MayAppend(*recalled, *read, options)) {
        // (An elevation model is fitted to the whole flight.)
        SKYQUILT_TRY_ASSIGN(auto grown,
                            PlaceAdded(*std::move(recalled), *read, options, source, dem, stages, progress));
        facts = std::move(grown);
        if (facts) TellReading(*read, facts->flight);
      }
    }
  }
  if (!facts) {
    SKYQUILT_TRY_ASSIGN(auto anew, PlaceAnew(*std::move(read), options, source, dem, stages, progress,
                                             std::move(found.photos)));
    facts = std::move(anew);
    // What is left of its files may be too little, or lie otherwise: it goes where its records put it.
    if (placed_by_hand && !KeepPlaceByHand(*placed_by_hand, *facts) && !is_less)
      return flight::Because(ErrorCode::kConflict, flight::RemarkCode::kFailMapChanged);
  }
  // A map that is only brought elsewhere stays whole without its UTM.
  if (!is_told) SKYQUILT_TRY(CheckUtm(facts->flight, options));
  placed.facts = *std::move(facts);
  placed.captures = std::move(captures);
  placed.facts.boundary = BoundaryOf(options, memory);
  TellMarks(lists, placed.facts);
  if (!is_told) {  // that keeps what the map was made with
    for (alignment::AlignedPhoto& photo : placed.facts.flight.photos)
      photo.max_look_rad = MaxLookRad(photo, options);
    DrawColourAlone(placed.captures, placed.facts.flight);
    placed.facts.options = DigestOfPlacing(options);
    placed.facts.asked = options.InWords();
  }
  placed.facts.inputs = inputs;
  std::map<std::string, Digest> by_path;
  for (const NamedDigest& input : inputs) by_path[input.file.path.string()] = input.digest;
  if (memory != nullptr) {
    for (const alignment::AlignedPhoto& photo : placed.facts.flight.photos) {
      placed.digests.push_back(by_path[photo.photo.path.string()]);
    }
  }
  return placed;
}

}  // namespace skyquilt::pipeline
