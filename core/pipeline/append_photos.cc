#include "core/pipeline/append_photos.h"

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "core/alignment/align_by_pose.h"
#include "core/alignment/align_flight.h"
#include "core/alignment/estimators/similarity.h"
#include "core/alignment/scene/photo_set.h"
#include "core/base/median.h"
#include "core/base/try.h"
#include "core/camera/footprint.h"
#include "core/ground/extend_ground.h"
#include "core/ground/footprint_on_ground.h"
#include "core/ground/model_ground.h"
#include "core/pipeline/placing/tell_added.h"

namespace skyquilt::pipeline {
namespace {

using alignment::AlignedFlight;
using alignment::AlignedPhoto;

constexpr std::size_t kMaxAround = 10;  // finished photos that a new one is compared with
constexpr double kReachWidths = 1.0;    // of a photo's width on the ground between their middles
constexpr double kFixedSigma = 1e-4;    // metres and radians: known for good
// Of a photo's width: further than receivers err, so that somebody moved the map (surveyed points do, say).
constexpr double kMovedWidths = 0.25;
constexpr double kUprightRad = 0.003;  // what moves a map turns it about the vertical

// Of ground that a photo shows, along its longer side. Posed or aligned.
template <typename Photo>
double WidthM(const Photo& photo) {
  return photo.height_above_ground_m / photo.photo.intrinsics.MeanFocalPx() *
         std::max(photo.photo.intrinsics.width_px, photo.photo.intrinsics.height_px);
}

// How the finished map lies to what its photos record: as their frames do, or turned, scaled and shifted
// where somebody moved it since (by hand, say). Nothing where it lies in no such way to them.
std::optional<alignment::Similarity3> KnownFromPosed(const FlightFacts& known,
                                                     const poses::PosedFlight& posed) {
  const geo::Rigid3 by_frames = known.flight.frame.ecef_from_enu().Inverse() * posed.frame.ecef_from_enu();
  const alignment::Similarity3 as_recorded{1.0, by_frames.rotation, by_frames.translation};
  std::map<std::string, Eigen::Vector3d> recorded;
  for (const poses::PosedPhoto& photo : posed.photos)
    recorded.emplace(photo.photo.name, photo.cam_from_enu.TargetOriginInSource());
  std::vector<alignment::PlacePair> pairs;
  std::vector<double> apart_widths;
  for (const AlignedPhoto& photo : known.flight.photos) {
    const auto found = recorded.find(photo.photo.name);
    if (found == recorded.end()) continue;
    const Eigen::Vector3d center = photo.cam_from_enu.TargetOriginInSource();
    pairs.push_back({.in_source = found->second, .in_target = center});
    apart_widths.push_back((as_recorded * found->second - center).head<2>().norm() / WidthM(photo));
  }
  if (pairs.empty()) return as_recorded;
  if (!known.is_by_hand && Median(std::move(apart_widths)) < kMovedWidths) return as_recorded;
  const auto fitted = alignment::FitRobustly(
      pairs, alignment::UpDirection{.in_source = Eigen::Vector3d::UnitZ(), .sigma_rad = kUprightRad});
  if (!fitted) return std::nullopt;
  return fitted->target_from_source;
}

// `photo` where the finished map shows what it shows.
void Move(const alignment::Similarity3& known_from_posed, poses::PosedPhoto& photo) {
  photo.cam_from_enu = known_from_posed.Moved(photo.cam_from_enu);
  if (photo.velocity_in_enu_mps) {
    photo.velocity_in_enu_mps =
        known_from_posed.scale * (known_from_posed.rotation * *photo.velocity_in_enu_mps);
  }
  photo.height_above_ground_m *= known_from_posed.scale;
  photo.error_radius_m *= known_from_posed.scale;
  for (poses::Matrix6d* covariance : {&photo.covariance, &photo.covariance_with_next}) {
    covariance->bottomRows<3>() *= known_from_posed.scale;
    covariance->rightCols<3>() *= known_from_posed.scale;
  }
}

// What is placed against the finished flight, with the lenses found there.
struct AddedPhotos {
  std::vector<poses::PosedPhoto> posed;  // in its frame
  std::vector<flight::Photo> unplaced;   // no record says where
};

AddedPhotos PhotosAdded(const FlightFacts& known, const std::set<std::string>& finished,
                        const poses::PosedFlight& posed, const alignment::Similarity3& known_from_posed) {
  std::map<std::string, camera::Intrinsics> lens_of_key;
  for (const AlignedPhoto& photo : known.flight.photos)
    lens_of_key.try_emplace(photo.photo.camera_key, photo.intrinsics);
  const auto take_lens = [&](flight::Photo& photo) {
    const auto lens = lens_of_key.find(photo.camera_key);
    if (lens != lens_of_key.end()) photo.intrinsics = lens->second;
  };
  AddedPhotos added;
  for (poses::PosedPhoto photo : posed.photos) {
    if (finished.contains(photo.photo.name)) continue;
    Move(known_from_posed, photo);
    take_lens(photo.photo);
    added.posed.push_back(std::move(photo));
  }
  for (flight::Photo photo : posed.unplaced) {
    if (finished.contains(photo.name)) continue;
    take_lens(photo);
    added.unplaced.push_back(std::move(photo));
  }
  return added;
}

// Of photos that the finished flight left out, those stay that a new one may bridge to it.
void DropBeyondReach(const std::set<std::string>& left_out, std::vector<poses::PosedPhoto>& added) {
  struct Reach {
    Eigen::Vector2d middle_in_enu;
    double radius_m = 0.0;
  };
  std::vector<Reach> of_new;
  for (const poses::PosedPhoto& photo : added) {
    if (!left_out.contains(photo.photo.name))
      of_new.push_back({photo.cam_from_enu.TargetOriginInSource().head<2>(), kReachWidths * WidthM(photo)});
  }
  std::erase_if(added, [&](const poses::PosedPhoto& photo) {
    const Eigen::Vector2d middle = photo.cam_from_enu.TargetOriginInSource().head<2>();
    return left_out.contains(photo.photo.name) &&
           std::none_of(of_new.begin(), of_new.end(), [&](const Reach& reach) {
             return (reach.middle_in_enu - middle).norm() < reach.radius_m;
           });
  });
}

// Names of those that records put where neither the map reaches nor, from photo to photo, the other new ones.
std::set<std::string> SaidToBeApart(const FlightFacts& known, const std::vector<poses::PosedPhoto>& added) {
  std::vector<Eigen::Vector2d> reached_in_enu;
  for (const AlignedPhoto& photo : known.flight.photos)
    reached_in_enu.emplace_back(photo.cam_from_enu.TargetOriginInSource().head<2>());
  std::vector<const poses::PosedPhoto*> rest;
  for (const poses::PosedPhoto& photo : added) rest.push_back(&photo);
  const auto is_reached = [&](const poses::PosedPhoto* photo) {
    const Eigen::Vector2d middle = photo->cam_from_enu.TargetOriginInSource().head<2>();
    const double reach_m = kReachWidths * WidthM(*photo);
    const bool is_near =
        std::any_of(reached_in_enu.begin(), reached_in_enu.end(),
                    [&](const Eigen::Vector2d& other) { return (other - middle).norm() < reach_m; });
    if (is_near) reached_in_enu.push_back(middle);
    return is_near;
  };
  std::size_t left = 0;
  do {
    left = rest.size();
    std::erase_if(rest, is_reached);
  } while (rest.size() < left);
  std::set<std::string> names;
  for (const poses::PosedPhoto* photo : rest) names.insert(photo->photo.name);
  return names;
}

// Finished photos near the new ones, by number.
std::set<std::size_t> Around(const FlightFacts& known, const std::vector<poses::PosedPhoto>& added) {
  std::set<std::size_t> around;
  for (const poses::PosedPhoto& photo : added) {
    const Eigen::Vector2d middle = photo.cam_from_enu.TargetOriginInSource().head<2>();
    std::vector<std::pair<double, std::size_t>> near;
    for (std::size_t i = 0; i < known.flight.photos.size(); ++i) {
      const AlignedPhoto& other = known.flight.photos[i];
      const double apart = (other.cam_from_enu.TargetOriginInSource().head<2>() - middle).norm();
      if (apart < kReachWidths * WidthM(photo)) near.emplace_back(apart, i);
    }
    std::sort(near.begin(), near.end());
    if (near.size() > kMaxAround) near.resize(kMaxAround);
    for (const auto& [apart, i] : near) around.insert(i);
  }
  return around;
}

poses::PosedPhoto AsPosed(const AlignedPhoto& finished) {
  poses::PosedPhoto photo;
  photo.photo = finished.photo;
  photo.photo.intrinsics = finished.intrinsics;
  photo.cam_from_enu = finished.cam_from_enu;
  photo.covariance = poses::Matrix6d::Identity() * kFixedSigma * kFixedSigma;
  photo.height_above_ground_m = finished.height_above_ground_m;
  photo.error_radius_m = finished.error_radius_m;
  photo.readout_motion = finished.readout_motion;
  return photo;
}

// What is aligned: the finished photos around, then those that are placed against them.
poses::PosedFlight PartOf(const FlightFacts& known, const std::set<std::size_t>& around, AddedPhotos added) {
  poses::PosedFlight part;
  part.frame = known.flight.frame;
  part.ground_z_in_enu_m = known.flight.ground_z_in_enu_m;
  for (const std::size_t i : around) part.photos.push_back(AsPosed(known.flight.photos[i]));
  part.photos.insert(part.photos.end(), added.posed.begin(), added.posed.end());
  part.unplaced = std::move(added.unplaced);
  return part;
}

// Which photos of `part` stay, in the order of its alignment: as is, or of capture where some have no place.
alignment::PhotoSet FixedOf(const poses::PosedFlight& part, const std::set<std::string>& finished) {
  std::vector<const flight::Photo*> order;
  for (const poses::PosedPhoto& photo : part.photos) order.push_back(&photo.photo);
  for (const flight::Photo& photo : part.unplaced) order.push_back(&photo);
  if (!part.unplaced.empty()) {
    std::stable_sort(order.begin(), order.end(), [](const flight::Photo* a, const flight::Photo* b) {
      return flight::ComesBefore(*a, *b);
    });
  }
  alignment::PhotoSet fixed;
  for (const flight::Photo* photo : order) fixed.Append(finished.contains(photo->name));
  return fixed;
}

geo::Bounds2 SeenBy(const std::vector<AlignedPhoto>& photos, double ground_z_m) {
  geo::Bounds2 bounds;
  for (const AlignedPhoto& photo : photos) {
    bounds.Include(
        camera::BoundsOf(camera::GroundFootprint(photo.intrinsics, photo.cam_from_enu, ground_z_m)));
  }
  return bounds;
}

// Outlines on the ground of what finished photos show of an area.
std::vector<std::vector<Eigen::Vector2d>> ShownOf(const FlightFacts& known, const geo::Bounds2& area) {
  std::vector<std::vector<Eigen::Vector2d>> shown;
  for (const AlignedPhoto& photo : known.flight.photos) {
    auto outline = ground::FootprintOnGround(known.ground, photo.intrinsics, photo.cam_from_enu);
    if (camera::BoundsOf(outline).Intersects(area)) shown.push_back(std::move(outline));
  }
  return shown;
}

}  // namespace

AlignedFlight AddedAndAround(const AlignedFlight& flight, std::size_t finished) {
  AlignedFlight part = flight;
  const auto east_north = [](const AlignedPhoto& photo) -> Eigen::Vector2d {
    return photo.cam_from_enu.TargetOriginInSource().head<2>();
  };
  std::size_t number = 0;
  std::erase_if(part.photos, [&](const AlignedPhoto& photo) {
    if (number++ >= finished) return false;
    return std::none_of(flight.photos.begin() + static_cast<std::ptrdiff_t>(finished), flight.photos.end(),
                        [&](const AlignedPhoto& added) {
                          return (east_north(photo) - east_north(added)).norm() <
                                 kReachWidths * WidthM(added);
                        });
  });
  return part;
}

Result<std::optional<FlightFacts>> AppendPhotos(const FlightFacts& known, const poses::PosedFlight& posed,
                                                const MosaicOptions& options,
                                                const flight::PhotoSource& source, Progress& progress) {
  // All of the flight goes where its records put it now.
  if (!known.is_placed && posed.is_placed) return std::optional<FlightFacts>();
  const std::optional<alignment::Similarity3> known_from_posed = KnownFromPosed(known, posed);
  if (!known_from_posed) return std::optional<FlightFacts>();
  std::set<std::string> finished, left_out;
  for (const AlignedPhoto& photo : known.flight.photos) finished.insert(photo.photo.name);
  for (const flight::LeftOutPhoto& photo : known.flight.left_out) left_out.insert(photo.name);
  AddedPhotos added = PhotosAdded(known, finished, posed, *known_from_posed);
  DropBeyondReach(left_out, added.posed);
  std::map<std::string, const flight::Photo*> recorded;
  for (const poses::PosedPhoto& photo : posed.photos) recorded[photo.photo.name] = &photo.photo;
  for (const flight::Photo& photo : posed.unplaced) recorded[photo.name] = &photo;
  std::set<std::string> names, unplaced;  // of the new ones
  for (const poses::PosedPhoto& photo : added.posed) {
    if (!left_out.contains(photo.photo.name)) names.insert(photo.photo.name);
  }
  for (const flight::Photo& photo : added.unplaced) {
    if (!left_out.contains(photo.name)) unplaced.insert(photo.name);
  }
  for (const flight::LeftOutPhoto& photo : posed.left_out) {
    if (!finished.contains(photo.name) && !left_out.contains(photo.name)) names.insert(photo.name);
  }
  // Without any that is new nothing bridges to those that were left out.
  if (added.posed.empty() && unplaced.empty()) added.unplaced.clear();
  const bool is_by_records = options.method == AlignMethod::kImu;
  // What no record places, or records put far off, may be anywhere on the map.
  const std::set<std::string> apart = SaidToBeApart(known, added.posed);
  const bool is_sought = !is_by_records && (!unplaced.empty() || !apart.empty());
  std::set<std::size_t> around = Around(known, added.posed);
  for (std::size_t i = 0; is_sought && i < known.flight.photos.size(); ++i) around.insert(i);
  poses::PosedFlight part = PartOf(known, around, std::move(added));
  // It is compared with those taken before and after it, wherever they are said to be.
  if (is_sought) {
    std::stable_sort(part.photos.begin(), part.photos.end(),
                     [](const poses::PosedPhoto& a, const poses::PosedPhoto& b) {
                       return flight::ComesBefore(a.photo, b.photo);
                     });
  }
  part.left_out = posed.left_out;
  const bool is_compared = !is_by_records && !part.photos.empty();
  alignment::AlignOptions align_options;
  align_options.threads = options.threads;
  align_options.fixed = FixedOf(part, finished);

  FlightFacts grown = known;
  grown.poses_report = posed.report;
  grown.poses_report.is_placed = known.is_placed;  // by somebody since, whatever the records say
  if (known.is_by_hand) grown.poses_report.is_height_guessed = known.poses_report.is_height_guessed;
  std::vector<flight::Remark>& warnings = grown.flight.warnings;
  TellPosed(posed.warnings, known.is_placed, warnings);
  // What is assumed of the new ones alone; the map's own assumptions were told with what became of them.
  part.assumptions = posed.assumptions;
  std::erase_if(part.assumptions,
                [&](const poses::Assumption& one) { return SayAnew(one.missing, warnings); });
  alignment::AlignReport report;
  SKYQUILT_TRY_ASSIGN(AlignedFlight aligned,
                      is_compared ? alignment::AlignFlight(part, source, align_options, report, progress)
                                  : Result<AlignedFlight>(alignment::AlignByPoseOnly(part)));
  // What nothing ties now either stays left out, for the reason that was given.
  std::erase_if(aligned.photos, [&](const AlignedPhoto& photo) {
    return left_out.contains(photo.photo.name) && photo.placement != alignment::Placement::kAligned;
  });
  std::vector<AlignedPhoto> placed;
  std::size_t tied = 0, looked_at = 0;  // of the new ones
  for (AlignedPhoto& photo : aligned.photos) {
    const bool was_left_out = left_out.contains(photo.photo.name);
    if (was_left_out) names.insert(photo.photo.name);
    if (!names.contains(photo.photo.name)) continue;
    const bool is_tied = photo.placement == alignment::Placement::kAligned;
    // Of one beside the map no tie is to be expected.
    if (!was_left_out && (is_tied || !apart.contains(photo.photo.name))) ++looked_at;
    if (!was_left_out && is_tied) ++tied;
    photo.photo = *recorded.at(photo.photo.name);  // with the lens as recorded
    placed.push_back(std::move(photo));
  }
  // Photos that share nothing with the map may share it with each other.
  const auto lost =
      std::count_if(aligned.left_out.begin(), aligned.left_out.end(),
                    [&](const flight::LeftOutPhoto& photo) { return unplaced.contains(photo.name); });
  if (is_compared && (2 * tied < looked_at || lost > 1)) return std::optional<FlightFacts>();

  ground::ModelGroundReport ground_report;
  const ground::GroundSurface beyond = ground::ModelGround(aligned, ground_report);
  // Where the ground lies lower, more of it is seen.
  const geo::Bounds2 seen = SeenBy(placed, std::min(known.ground.MeanHeight(), beyond.MinHeight()));
  auto extended = ground::ExtendGround(known.ground, beyond, seen, ShownOf(known, seen));
  if (!extended) return std::optional<FlightFacts>();  // as a whole, its ground has larger cells
  grown.ground = *std::move(extended);
  if (known.ground.IsPlane() && !grown.ground.IsPlane()) grown.ground_report = ground_report;
  for (AlignedPhoto& photo : placed) grown.flight.photos.push_back(std::move(photo));
  TellAligned(aligned.warnings, names, warnings);
  if (grown.align_report) {
    AddFigures(report, names, grown.flight.photos, *grown.align_report);
    TellGroups(grown.align_report->components, grown.flight.photos.size(), warnings);
  }
  std::erase_if(grown.flight.left_out,
                [&](const flight::LeftOutPhoto& photo) { return names.contains(photo.name); });
  for (const flight::LeftOutPhoto& photo : aligned.left_out) {
    if (names.contains(photo.name)) grown.flight.left_out.push_back(photo);
  }
  if (!placed.empty()) {
    TellAdded(placed.size(), warnings);
    // The finished photos, and the ground below them, stay where the first rule put them. Figures in a rule
    // differ with every photo, and are left out.
    const std::string rule = posed.report.height_rule.substr(0, posed.report.height_rule.find(';'));
    if (grown.height_rule.find(rule) == std::string::npos)
      grown.height_rule += "; of photos added since: " + rule;
  }
  return std::optional<FlightFacts>(std::move(grown));
}

void KeepSampleRanges(const alignment::AlignedFlight& known, std::vector<flight::Photo>& photos) {
  std::map<std::pair<std::string, flight::SampleKind>, flight::SampleRange> ranges;
  for (const alignment::AlignedPhoto& photo : known.photos) {
    if (photo.photo.sample_range)
      ranges.emplace(std::pair(photo.photo.camera_key, photo.photo.sample_kind), *photo.photo.sample_range);
  }
  for (flight::Photo& photo : photos) {
    const auto range = ranges.find({photo.camera_key, photo.sample_kind});
    if (range != ranges.end() && photo.sample_range) photo.sample_range = range->second;
  }
}

}  // namespace skyquilt::pipeline
