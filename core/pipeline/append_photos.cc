#include "core/pipeline/append_photos.h"

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "core/alignment/align_flight.h"
#include "core/alignment/baselines/align_by_pose.h"
#include "core/alignment/estimators/similarity.h"
#include "core/base/median.h"
#include "core/base/try.h"
#include "core/camera/footprint.h"
#include "core/ground/extend_ground.h"
#include "core/ground/model_ground.h"

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

// The new photos, in the frame of the finished flight and with the lenses found there.
std::vector<poses::PosedPhoto> NewPhotos(const FlightFacts& known, const poses::PosedFlight& posed,
                                         const alignment::Similarity3& known_from_posed) {
  std::set<std::string> finished;
  std::map<std::string, camera::Intrinsics> lens_of_key;
  for (const AlignedPhoto& photo : known.flight.photos) {
    finished.insert(photo.photo.name);
    lens_of_key.try_emplace(photo.photo.camera_key, photo.intrinsics);
  }
  std::vector<poses::PosedPhoto> added;
  for (poses::PosedPhoto photo : posed.photos) {
    if (finished.contains(photo.photo.name)) continue;
    Move(known_from_posed, photo);
    if (const auto lens = lens_of_key.find(photo.photo.camera_key); lens != lens_of_key.end()) {
      photo.photo.intrinsics = lens->second;
    }
    added.push_back(std::move(photo));
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

geo::Bounds2 SeenBy(const std::vector<AlignedPhoto>& photos, double ground_z_m) {
  geo::Bounds2 bounds;
  for (const AlignedPhoto& photo : photos) {
    bounds.Include(
        camera::BoundsOf(camera::GroundFootprint(photo.intrinsics, photo.cam_from_enu, ground_z_m)));
  }
  return bounds;
}

// The figures of the new photos beside those of the finished flight. One that it left out has some there,
// even as aligned, where its pose was one that no map is drawn with.
void AddFigures(const alignment::AlignReport& report, const std::set<std::string>& added,
                alignment::AlignReport& known) {
  std::erase_if(known.photo_reports, [&](const alignment::AlignPhotoReport& photo) {
    if (!added.contains(photo.name)) return false;
    --known.photos;
    if (photo.placement == alignment::Placement::kAligned) --known.aligned;
    return true;
  });
  std::erase_if(known.pairs, [&](const alignment::AlignPairReport& pair) {
    return added.contains(pair.first) || added.contains(pair.second);
  });
  for (const alignment::AlignPhotoReport& photo : report.photo_reports) {
    if (!added.contains(photo.name)) continue;
    ++known.photos;
    if (photo.placement == alignment::Placement::kAligned) ++known.aligned;
    known.photo_reports.push_back(photo);
  }
  for (const alignment::AlignPairReport& pair : report.pairs) {
    if (added.contains(pair.first) || added.contains(pair.second)) known.pairs.push_back(pair);
  }
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
  const std::optional<alignment::Similarity3> known_from_posed = KnownFromPosed(known, posed);
  if (!known_from_posed) return std::optional<FlightFacts>();
  std::set<std::string> left_out;
  for (const flight::LeftOutPhoto& photo : known.flight.left_out) left_out.insert(photo.name);
  std::vector<poses::PosedPhoto> added = NewPhotos(known, posed, *known_from_posed);
  DropBeyondReach(left_out, added);
  const std::set<std::size_t> around = Around(known, added);
  poses::PosedFlight part;
  part.frame = known.flight.frame;
  part.ground_z_in_enu_m = known.flight.ground_z_in_enu_m;
  alignment::AlignOptions align_options;
  align_options.threads = options.threads;
  for (const std::size_t i : around) {
    part.photos.push_back(AsPosed(known.flight.photos[i]));
    align_options.fixed.Append(true);
  }
  std::map<std::string, const poses::PosedPhoto*> recorded;
  std::set<std::string> names;
  for (const poses::PosedPhoto& photo : added) {
    part.photos.push_back(photo);
    align_options.fixed.Append(false);
    if (!left_out.contains(photo.photo.name)) names.insert(photo.photo.name);
  }
  for (const poses::PosedPhoto& photo : posed.photos) recorded[photo.photo.name] = &photo;

  FlightFacts grown = known;
  alignment::AlignReport report;
  SKYQUILT_TRY_ASSIGN(AlignedFlight aligned,
                      options.method == AlignMethod::kImu
                          ? Result<AlignedFlight>(alignment::AlignByPoseOnly(part))
                          : alignment::AlignFlight(part, source, align_options, report, progress));
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
    if (!was_left_out) ++looked_at;
    if (!was_left_out && photo.placement == alignment::Placement::kAligned) ++tied;
    photo.photo = recorded.at(photo.photo.name)->photo;  // with the lens as recorded
    placed.push_back(std::move(photo));
  }
  const bool is_compared = options.method != AlignMethod::kImu && !around.empty();
  if (is_compared && 2 * tied < looked_at) return std::optional<FlightFacts>();

  ground::ModelGroundReport ground_report;
  const ground::GroundSurface beyond = ground::ModelGround(aligned, ground_report);
  grown.ground = ground::ExtendGround(known.ground, beyond, SeenBy(placed, known.ground.MeanHeight()));
  if (grown.align_report) AddFigures(report, names, *grown.align_report);
  for (AlignedPhoto& photo : placed) grown.flight.photos.push_back(std::move(photo));
  std::erase_if(grown.flight.left_out,
                [&](const flight::LeftOutPhoto& photo) { return names.contains(photo.name); });
  for (const flight::LeftOutPhoto& photo : aligned.left_out) {
    if (names.contains(photo.name)) grown.flight.left_out.push_back(photo);
  }
  if (!placed.empty())
    grown.flight.warnings.push_back({flight::RemarkCode::kPhotosAdded, {{"photos", placed.size()}}});
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
