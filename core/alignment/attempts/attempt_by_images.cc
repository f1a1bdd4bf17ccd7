#include "core/alignment/attempts/attempt_by_images.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include "core/alignment/bundle/control_points.h"
#include "core/alignment/from_images/block.h"
#include "core/alignment/from_images/georeference.h"
#include "core/alignment/from_images/register_photos.h"
#include "core/alignment/from_records/bundle_setup.h"
#include "core/base/median.h"
#include "core/base/scoped_timer.h"
#include "core/base/trace.h"
#include "core/flight/remarks/because.h"
#include "core/flight/remarks/remark_words.h"
#include "core/poses/conventions/attitude_convention.h"

namespace skyquilt::alignment {
namespace {

constexpr double kSigmaTurnRad = 0.35;  // of poses from images alone, before they are asked again
constexpr double kFallbackSigmaM = 1e4;
constexpr double kFallbackSigmaRad = 3.0;
constexpr double kFallbackHeightM = 50.0;
constexpr double kAttitudeHoldsRad = 0.1;
constexpr double kHeightHoldsSigmas = 4.0;
constexpr double kTrustedHeightShare = 0.1;
constexpr double kLowestFlightM = 1.0;  // below it the height was not recorded, or nobody flew
constexpr double kOtherFocalSigmas = 3.0;
constexpr double kSigmaFoundFocal = 0.01;

constexpr double kMaxFromFlightM = 50'000.0;  // no flight is as long
constexpr double kMaxLatDeg = 85.0;

// Its recorded position, as high as the frame's origin; nothing where it cannot be of this flight, which is
// no better than none.
std::optional<Eigen::Vector3d> RecordedPlace(const flight::Photo& photo, const geo::LocalFrame& frame) {
  if (!photo.position) return std::nullopt;
  const geo::LatLon& at = photo.position->position;
  if (!std::isfinite(at.lat_deg + at.lon_deg) || std::abs(at.lat_deg) > kMaxLatDeg) return std::nullopt;
  const Eigen::Vector3d place =
      frame.EnuFromWgs84({at.lat_deg, at.lon_deg, frame.origin().height_ellipsoid_m});
  return place.norm() < kMaxFromFlightM ? std::optional(place) : std::nullopt;
}

poses::PosedPhoto FallbackPose(const flight::Photo& photo, const geo::LocalFrame& frame, double height_m,
                               double ground_z_m) {
  poses::PosedPhoto posed;
  posed.photo = photo;
  Eigen::Vector3d center = RecordedPlace(photo, frame).value_or(Eigen::Vector3d(0.0, 0.0, 0.0));
  center.z() = ground_z_m + height_m;
  Eigen::Matrix3d down;  // image top north
  down << 1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0;
  posed.cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(Eigen::Quaterniond(down), center);
  posed.covariance.diagonal() << Eigen::Vector3d::Constant(kFallbackSigmaRad * kFallbackSigmaRad),
      Eigen::Vector3d::Constant(kFallbackSigmaM * kFallbackSigmaM);
  posed.height_above_ground_m = height_m;
  posed.error_radius_m = kFallbackSigmaM;
  posed.attitude_origin = poses::AttitudeOrigin::kCourse;
  return posed;
}

PhotoRecord RecordOf(const poses::PosedPhoto& posed, bool is_unplaced, const geo::LocalFrame& frame) {
  PhotoRecord record;
  record.is_unplaced = is_unplaced;
  const std::optional<flight::RecordedPosition>& own = posed.photo.position;
  if (!is_unplaced) {
    // Where a receiver repeats itself the place is a guess, no record.
    const bool is_guessed = own && own->is_repeated && posed.position_source == own->source;
    if (!is_guessed) record.center_in_enu = posed.cam_from_enu.TargetOriginInSource();
    const double sigma_m = std::sqrt(std::max(1e-4, 0.5 * (posed.covariance(3, 3) + posed.covariance(4, 4))));
    record.sigma_m = {sigma_m, sigma_m, std::sqrt(std::max(1e-4, posed.covariance(5, 5)))};
    if (posed.attitude_origin == poses::AttitudeOrigin::kRecorded ||
        posed.attitude_origin == poses::AttitudeOrigin::kSmoothed) {
      record.cam_from_enu = posed.cam_from_enu.rotation;
      record.sigma_tilt_rad =
          std::sqrt(std::max(1e-6, 0.5 * (posed.covariance(0, 0) + posed.covariance(1, 1))));
    }
    return record;
  }
  if (posed.photo.attitude) record.cam_from_enu = poses::CamFromEnu(*posed.photo.attitude);
  // As high above the ground as above the place of take-off, as it is for other photos without more to go by.
  const std::optional<double>& lone_height_m = posed.photo.lone_height_above_takeoff_m;
  if (lone_height_m && *lone_height_m > kLowestFlightM) record.height_above_ground_m = lone_height_m;
  const std::optional<Eigen::Vector3d> place = RecordedPlace(posed.photo, frame);
  if (!place || own->is_repeated) return record;
  record.center_in_enu = place;
  const double sigma_m = flight::SigmaOfRecordM(*own);
  record.sigma_m = {sigma_m, sigma_m, std::numeric_limits<double>::infinity()};
  return record;
}

// What surveyed points say of a block's place.
std::vector<PlacePair> ControlOf(const Registration& registration, const PhotoSet& of_block,
                                 const std::vector<std::string>& names, const geo::LocalFrame& frame,
                                 const std::vector<ControlPoint>& control) {
  std::vector<View> views;
  for (std::size_t i = 0; i < registration.Photos(); ++i)
    views.push_back({registration.LensOf(i), registration.cam_from_world[i], kMedianDepth, {}});
  const MarkedPhotos marked(names, views, of_block);
  std::vector<PlacePair> pairs;
  for (const ControlPoint& point : control) {
    ControlReport ignored;
    const std::optional<Track> track = marked.TrackOf(point, ignored);
    if (!track) continue;
    PlacePair pair;
    pair.in_source = track->point_in_enu;
    pair.in_target = frame.EnuFromWgs84({point.position.lat_deg, point.position.lon_deg,
                                         point.height_m.value_or(frame.origin().height_ellipsoid_m)});
    pair.sigma = {point.sigma_horizontal_m, point.sigma_horizontal_m,
                  point.height_m ? point.sigma_vertical_m : std::numeric_limits<double>::infinity()};
    pairs.push_back(pair);
  }
  return pairs;
}

// Where a block's place puts the cameras; it says nothing of those of other blocks.
std::vector<Eigen::Vector3d> CentersInEnu(const Registration& registration, const BlockPlace& place) {
  std::vector<Eigen::Vector3d> centers_in_enu;
  for (const geo::Rigid3& cam_from_world : registration.cam_from_world)
    centers_in_enu.push_back(place.enu_from_world * cam_from_world.TargetOriginInSource());
  return centers_in_enu;
}

Registration InputOf(const ExtractedFlight& extracted, const BundleProblem& problem) {
  Registration input;
  input.lenses = problem.lenses;
  for (BundleLens& lens : input.lenses) lens.intrinsics = lens.recorded;
  for (std::size_t i = 0; i < problem.photos.size(); ++i)
    input.Add(extracted.readable[i], problem.photos[i].lens, extracted.records[i].center_in_enu);
  return input;
}

// What says where on Earth a block lies, and how large it is.
flight::Remark HowPlaced(const BlockPlace& place) {
  using flight::RemarkCode;
  switch (place.placing) {
    case Placing::kByPositions:
      if (place.spread_sigmas > kContradictedSigmas) {
        return {RemarkCode::kImagesAgainstPositions,
                {{"apart_m", place.median_residual_m}, {"times", place.spread_sigmas}}};
      }
      return {RemarkCode::kImagesOnPositions,
              {{"positions", place.positions_held}, {"total", place.positions}}};
    case Placing::kByControl:
      return place.ignores_surveyed_heights ? RemarkCode::kImagesOnControlWithoutHeights
                                            : RemarkCode::kImagesOnControl;
    case Placing::kByHeights:
      return RemarkCode::kImagesOnHeights;
    case Placing::kByGuess:
      break;
  }
  return place.positions > 0 ? RemarkCode::kImagesAboutPositions : RemarkCode::kImagesNowhere;
}

// The flying height, and a recorded or assumed one that it contradicts.
flight::Remark HowHigh(double found_m, std::optional<double> expected_m) {
  constexpr double kMaxHeightFactor = 1.25;
  if (expected_m && std::max(found_m, *expected_m) > kMaxHeightFactor * std::min(found_m, *expected_m)) {
    return {flight::RemarkCode::kFlownAtOtherThan, {{"height_m", found_m}, {"expected_m", *expected_m}}};
  }
  return {flight::RemarkCode::kFlownAt, {{"height_m", found_m}}};
}

// One photo of a block, as the block's place has it; whether its recorded position agrees.
bool MergePhoto(const Registration& registration, const BlockPlace& place, const PhotoRecord& record,
                double height_offset_m, double height_spread_m, std::size_t i, Attempt& second) {
  poses::PosedPhoto& photo = second.posed.photos[i];
  const geo::Rigid3 pose = place.enu_from_world.Moved(registration.cam_from_world[i]);
  const Eigen::Vector3d center = pose.TargetOriginInSource();
  photo.height_above_ground_m = std::max(0.5, center.z() - second.posed.ground_z_in_enu_m);
  const double unknown_m = kUnknownShare * photo.height_above_ground_m;
  Eigen::Vector3d expected = center, sigma = Eigen::Vector3d::Constant(unknown_m);
  PhotoFindings& corrected = second.matched.findings[i];
  // Positions that contradict the pictures say where the block is, not how its photos lie to each other.
  const bool is_contradicted = place.spread_sigmas > kContradictedSigmas;
  const bool has_record = place.holding.Has(i) && !is_contradicted;
  if (has_record) {
    expected.head<2>() = record.center_in_enu->head<2>();
    sigma.head<2>() = place.spread_sigmas * record.sigma_m.head<2>();
    const double height_m = record.center_in_enu->z() + height_offset_m;
    if (std::abs(height_m - center.z()) < kHeightHoldsSigmas * record.sigma_m.z()) {
      expected.z() = height_m;
      sigma.z() = std::min(unknown_m, std::max(record.sigma_m.z(), height_spread_m));
    }
  } else if (place.placing == Placing::kByPositions && photo.photo.position &&
             !photo.photo.position->is_repeated && !place.holding.Has(i)) {
    // Also where it is said to be so far away that it was no record at all.
    corrected.position_was_wrong = true;
    const Eigen::Vector3d recorded =
        second.posed.frame.EnuAtHeight(photo.photo.position->position, center.z());
    const double off_m = (recorded - center).head<2>().norm();
    if (std::isfinite(off_m))
      corrected.notes.push_back({flight::RemarkCode::kPositionElsewhere, {{"off_m", off_m}}});
  }
  // A recorded attitude that agrees goes on to hold, where north is the flight's own.
  const double turned =
      record.cam_from_enu ? record.cam_from_enu->angularDistance(pose.rotation) : kAttitudeHoldsRad;
  const bool attitude_holds = turned < kAttitudeHoldsRad && place.knows_north;
  const Eigen::Matrix3d attitude = photo.covariance.topLeftCorner<3, 3>();
  HoldLoosely(pose, sigma, photo);
  if (attitude_holds && !record.is_unplaced) photo.covariance.topLeftCorner<3, 3>() = attitude;
  photo.error_radius_m = sigma.head<2>().norm();
  corrected.start_cam_from_enu = pose;
  corrected.prior_cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(
      attitude_holds ? *record.cam_from_enu : pose.rotation, expected);
  return has_record;
}

}  // namespace

void HoldLoosely(const geo::Rigid3& cam_from_enu, const Eigen::Vector3d& sigma_m, poses::PosedPhoto& photo) {
  photo.cam_from_enu = cam_from_enu;
  photo.covariance.setZero();
  photo.covariance_with_next.setZero();
  photo.clock_sigma_s = 0.0;
  photo.covariance.diagonal() << Eigen::Vector3d::Constant(kSigmaTurnRad * kSigmaTurnRad),
      sigma_m.cwiseAbs2();
}

ExtractedFlight WithUnplaced(const poses::PosedFlight& recorded) {
  ExtractedFlight whole;
  whole.posed = recorded;
  poses::PosedFlight& posed = whole.posed;
  if (recorded.unplaced.empty()) {
    for (const poses::PosedPhoto& photo : posed.photos)
      whole.records.push_back(RecordOf(photo, false, posed.frame));
    return whole;
  }
  const double height_m = posed.photos.empty()
                              ? kFallbackHeightM
                              : MedianOf(posed.photos, &poses::PosedPhoto::height_above_ground_m);
  for (const flight::Photo& photo : recorded.unplaced)
    posed.photos.push_back(FallbackPose(photo, posed.frame, height_m, posed.ground_z_in_enu_m));
  posed.unplaced.clear();
  std::vector<std::size_t> order(posed.photos.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return flight::ComesBefore(posed.photos[a].photo, posed.photos[b].photo);
  });
  std::vector<poses::PosedPhoto> sorted;
  for (const std::size_t i : order) {
    whole.records.push_back(RecordOf(posed.photos[i], i >= recorded.photos.size(), posed.frame));
    sorted.push_back(std::move(posed.photos[i]));
    sorted.back().covariance_with_next.setZero();  // the next one is another now
  }
  posed.photos = std::move(sorted);
  return whole;
}

flight::Remark NotTaken(flight::Remark why) {
  return {flight::RemarkCode::kImagesNotTaken, {{"why", std::move(why)}}};
}

std::optional<Attempt> PlaceByImages(const ExtractedFlight& extracted, std::size_t tied_by_records,
                                     bool takes_equal, const std::vector<ControlPoint>& control, int threads,
                                     Attempt& by_records, Progress& progress) {
  ByImagesReport& report = by_records.report.by_images;
  ScopedTimer timer(report.total_s);
  const poses::PosedFlight& posed = by_records.posed;
  const std::size_t count = posed.photos.size();
  GeoreferenceRecords records;
  records.ground_z_in_enu_m = posed.ground_z_in_enu_m;
  records.photos = extracted.records;
  std::vector<double> sigmas, heights;
  for (std::size_t i = 0; i < count; ++i) {
    if (records.photos[i].is_unplaced) continue;
    sigmas.push_back(records.photos[i].sigma_m.z());
    heights.push_back(posed.photos[i].height_above_ground_m);
  }
  const std::optional<double> expected_height_m = MedianIfAny(std::move(heights));
  records.trusts_heights =
      expected_height_m && Median(std::move(sigmas)) < kTrustedHeightShare * *expected_height_m;
  records.has_own_zero = expected_height_m && posed.is_placed;
  for (std::size_t i = 0; i < count && records.trusts_heights; ++i) {
    if (!records.photos[i].is_unplaced)
      records.photos[i].height_above_ground_m = posed.photos[i].height_above_ground_m;
  }
  // Reckoned from nowhere: records say how photos lie to each other, not where on Earth.
  const bool is_reckoned = !posed.is_placed && expected_height_m;
  const Registration registration = RegisterPhotos(InputOf(extracted, by_records.problem), threads, progress);
  report.pairs_compared = registration.pairs_compared;
  report.pairs_verified = registration.pairs_verified;
  report.pairs_refused = registration.pairs_refused;
  report.residual_rms_px = registration.residual_rms_px;
  report.groups = static_cast<int>(registration.block_sizes.size());
  report.registered = registration.LargestSize();
  const std::size_t least = std::max<std::size_t>(3, tied_by_records + (takes_equal ? 0 : 1));
  TraceDecision("registered by images", {{"photos", report.registered},
                                         {"groups", report.groups},
                                         {"compared", report.pairs_compared},
                                         {"verified", report.pairs_verified},
                                         {"refused", report.pairs_refused},
                                         {"residual_px", report.residual_rms_px}});
  if (progress.IsCancelled() || report.registered < static_cast<int>(least)) {
    report.outcome = NotTaken(
        {flight::RemarkCode::kImagesTie, {{"photos", report.registered}, {"by_records", tied_by_records}}});
    return std::nullopt;
  }
  Attempt second;
  second.posed = posed;
  for (const poses::PosedPhoto& photo : posed.photos) {
    PhotoFindings& corrected = second.matched.findings.emplace_back();
    corrected.start_cam_from_enu = corrected.prior_cam_from_enu = photo.cam_from_enu;
  }
  const std::vector<std::string> names = posed.Names();
  PhotoSet placed(count), without_record(count);
  for (std::size_t b = 0; b < registration.block_sizes.size(); ++b) {
    const int block = static_cast<int>(b);
    PhotoSet of_block;
    for (const int of : registration.block_of) of_block.Append(of == block);
    records.control = ControlOf(registration, of_block, names, posed.frame, control);
    BlockPlace place = Georeference(registration, block, records);
    std::vector<Eigen::Vector3d> centers_in_enu = CentersInEnu(registration, place);
    const auto is_elsewhere = [&] {  // than the photos' own positions say
      const auto apart = RecordsApartOfBlock(posed, of_block, centers_in_enu);
      return apart && apart->IsElsewhere();
    };
    if (place.placing == Placing::kByControl && is_elsewhere()) {
      records.control.clear();  // refused, and said, where the flight is tied to them
      place = Georeference(registration, block, records);
      centers_in_enu = CentersInEnu(registration, place);
    }
    TraceDecision("group placed", {{"group", b},
                                   {"photos", registration.block_sizes[b]},
                                   {"by", static_cast<int>(place.placing)},
                                   {"positions_held", place.positions_held},
                                   {"residual_m", place.median_residual_m}});
    const bool is_on_earth = place.placing == Placing::kByPositions || place.placing == Placing::kByControl;
    // Where nothing says how two groups lie to each other, the larger one is the map.
    if (b > 0 && (!is_on_earth || report.is_adrift)) continue;
    if (b == 0) {
      const bool is_by_control = place.placing == Placing::kByControl;
      report.is_adrift = !(is_on_earth || place.positions > 0) || (is_reckoned && is_by_control);
      report.is_placed = is_by_control || (!is_reckoned && !report.is_adrift);
      report.ignores_surveyed_heights = place.ignores_surveyed_heights;
      if (!place.knows_north) report.is_north_guessed = true;
      if (place.placing == Placing::kByGuess) report.is_scale_guessed = true;
      std::vector<double> flown_m;
      for (std::size_t i = 0; i < count; ++i) {
        if (of_block.Has(i)) flown_m.push_back(centers_in_enu[i].z() - posed.ground_z_in_enu_m);
      }
      std::vector<flight::Remark> height;
      if (is_on_earth) height.push_back(HowHigh(Median(std::move(flown_m)), expected_height_m));
      report.outcome = flight::Remark{flight::RemarkCode::kImagesPlaced,
                                      {{"photos", report.registered},
                                       {"total", count},
                                       {"place", HowPlaced(place)},
                                       {"height", std::move(height)}}};
    }
    std::vector<double> offsets;
    for (std::size_t i = 0; i < count; ++i) {
      if (!place.holding.Has(i) || !std::isfinite(records.photos[i].sigma_m.z())) continue;
      offsets.push_back(centers_in_enu[i].z() - records.photos[i].center_in_enu->z());
    }
    const double height_offset_m = offsets.empty() ? 0.0 : Median(offsets);
    for (double& offset : offsets) offset = std::abs(offset - height_offset_m);
    const double height_spread_m = offsets.empty() ? 0.0 : 1.48 * Median(std::move(offsets));
    for (std::size_t i = 0; i < count; ++i) {
      if (!of_block.Has(i)) continue;
      placed.Add(i);
      if (!MergePhoto(registration, place, records.photos[i], height_offset_m, height_spread_m, i, second))
        without_record.Add(i);
    }
  }
  std::vector<PhotoFindings> corrected = std::move(second.matched.findings);
  second.matched = MakeMatchedFlight(second.posed);
  second.matched.findings = std::move(corrected);
  for (const PhotoPair& link : registration.links) {
    if (!placed.Has(link.first)) continue;
    second.matched.links.push_back(link);
    second.matched.pairs.push_back({.first = link.first, .second = link.second});
  }
  second.compared = second.matched.pairs;
  second.problem = MakeBundle(second.posed, second.matched.findings, extracted.lines);
  for (std::size_t c = 0; c < second.problem.lenses.size(); ++c) {
    BundleLens& lens = second.problem.lenses[c];
    lens.intrinsics = registration.lenses[c].intrinsics;
    // Where the images found another focal length than was recorded, theirs is the one to hold on to: level
    // ground alone says little of it, and heights that are wrong would bend it.
    const double off = std::abs(std::log(lens.intrinsics.focal_x_px / lens.recorded.focal_x_px));
    if (off <= kOtherFocalSigmas * lens.sigma_focal_share) continue;
    lens.recorded.focal_x_px = lens.intrinsics.focal_x_px;
    lens.recorded.focal_y_px = lens.intrinsics.focal_y_px;
    lens.sigma_focal_share = std::max(lens.sigma_focal_share, kSigmaFoundFocal);
  }
  second.matched.features = extracted.readable;
  for (std::size_t i = 0; i < count; ++i) {
    if (!placed.Has(i)) second.matched.features[i] = nullptr;
    second.problem.photos[i].has_record = !without_record.Has(i);
    second.problem.photos[i].is_by_images = placed.Has(i);
  }
  second.matched.views = ViewsOf(second.problem);
  return second;
}

Result<void> SettleUnplaced(const ExtractedFlight& extracted, AlignedFlight& flight, AlignReport& report) {
  // Nothing says how the map lies to photos that it does not show.
  const bool is_adrift = report.by_images.is_taken && report.by_images.is_adrift;
  std::set<std::string> unplaced, found;
  for (std::size_t i = 0; i < extracted.records.size(); ++i) {
    if (extracted.records[i].is_unplaced) unplaced.insert(extracted.posed.photos[i].photo.name);
  }
  if (unplaced.empty() && !is_adrift) return {};
  for (const AlignedPhoto& photo : flight.photos) {
    if (photo.placement == Placement::kAligned)
      found.insert(photo.photo.name);
    else if (is_adrift && unplaced.insert(photo.photo.name).second)
      flight.left_out.push_back(
          {photo.photo.name, ErrorCode::kNoPosition, flight::RemarkCode::kLeftBesideAdrift});
  }
  const auto is_nowhere = [&](const std::string& name) {
    return unplaced.contains(name) && !found.contains(name);
  };
  std::erase_if(flight.photos, [&](const AlignedPhoto& photo) { return is_nowhere(photo.photo.name); });
  std::erase_if(report.photo_reports, [&](const AlignPhotoReport& photo) { return is_nowhere(photo.name); });
  report.photos = static_cast<int>(report.photo_reports.size());
  const bool was_tried = report.by_images.why.has_value();
  std::set<std::string> told;
  std::erase_if(flight.left_out, [&](const flight::LeftOutPhoto& photo) {
    // One that nothing placed may have been found far away as well: the first reason is the one.
    return found.contains(photo.name) || (is_nowhere(photo.name) && !told.insert(photo.name).second);
  });
  for (flight::LeftOutPhoto& photo : flight.left_out) {
    if (is_nowhere(photo.name) && was_tried && photo.reason.code != flight::RemarkCode::kLeftBesideAdrift) {
      photo.reason = {
          flight::RemarkCode::kSentences,
          {{"first", photo.reason}, {"then", flight::Remark(flight::RemarkCode::kLeftNothingInCommon)}}};
    }
  }
  if (!flight.photos.empty()) return {};
  return flight::Because(
      ErrorCode::kUnprocessable,
      was_tried ? flight::RemarkCode::kFailNothingInCommon : flight::RemarkCode::kFailTooFewWithoutPlaces,
      report.by_images.outcome ? flight::InWords(*report.by_images.outcome) : "");
}

std::vector<flight::Remark> RemarksOn(const ByImagesReport& report) {
  using flight::RemarkCode;
  std::vector<flight::Remark> remarks;
  if (!report.is_taken || !report.why || !report.outcome) return remarks;
  if (!report.is_placed && report.is_adrift) {
    const flight::Remark north =
        report.is_north_guessed.value_or(false) ? RemarkCode::kNorthGuessed : RemarkCode::kNorthByCameras;
    const flight::Remark as_if{RemarkCode::kScaleAsIf, {{"width_m", kGuessedWidthM}}};
    const bool is_guessed = report.is_scale_guessed.value_or(false);
    remarks.push_back({RemarkCode::kNotGeoreferenced,
                       {{"north", north}, {"scale", is_guessed ? as_if : RemarkCode::kScaleByHeights}}});
  }
  remarks.push_back({RemarkCode::kPlacedByImages, {{"why", *report.why}, {"outcome", *report.outcome}}});
  return remarks;
}

}  // namespace skyquilt::alignment
