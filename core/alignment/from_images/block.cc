#include "core/alignment/from_images/block.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/base/median.h"
#include "core/base/parallel_for.h"

namespace skyquilt::alignment {
namespace {

constexpr double kToleranceSigmas = 6.0;
constexpr double kMinAngleOfPointRad = 0.015;
constexpr double kUnheldSigma = 1e6;
constexpr int kCellsAcross = 8;

}  // namespace

Block::Block(const Registration& input, std::vector<BundleLens> lenses)
    : input_(&input),
      lenses_(std::move(lenses)),
      placed_(input.Photos()),
      cam_from_world_(input.Photos()),
      rays_(input.Photos()),
      point_(input.scene.size(), Eigen::Vector3d::Zero()),
      seen_by_(input.scene.size()) {}

Block::Block(const Registration& input, const Packed& packed) : Block(input, packed.lenses) {
  for (const Packed::Placed& placed : packed.photos) Place(placed.photo, placed.cam_from_world);
  for (const Packed::Known& known : packed.points) {
    point_[known.track] = known.point;
    seen_by_[known.track] = known.seen_by;
  }
}

Block::Packed Block::Pack() const {
  Packed packed;
  packed.lenses = lenses_;
  for (std::size_t i = 0; i < placed_.Photos(); ++i) {
    if (Has(i)) packed.photos.push_back({static_cast<int>(i), Pose(i)});
  }
  for (std::size_t t = 0; t < seen_by_.size(); ++t) {
    if (HasPoint(t)) packed.points.push_back({static_cast<int>(t), Point(t), SeenBy(t)});
  }
  return packed;
}

const camera::Intrinsics& Block::Lens(int photo) const { return lenses_[input_->lens_of[photo]].intrinsics; }

Observation Block::ObservationOf(const TrackElement& element) const {
  return alignment::ObservationOf(*input_->features[element.photo], element);
}

void Block::FindRays(int photo) {
  const camera::Intrinsics& lens = Lens(photo);
  const PhotoFeatures& features = *input_->features[photo];
  std::vector<Eigen::Vector3d>& rays = rays_[photo];
  rays.assign(features.keypoints.size(), Eigen::Vector3d::Zero());
  for (const int t : input_->tracks_of[photo]) {
    for (const TrackElement& element : scene()[t]) {
      if (element.photo == photo) {
        rays[element.keypoint] = lens.Unproject(ObservationOf(element).pixel_in_image).normalized();
      }
    }
  }
}

void Block::Place(int photo, const geo::Rigid3& cam_from_world) {
  placed_.Add(photo);
  cam_from_world_[photo] = cam_from_world;
  FindRays(photo);
}

double Block::ResidualSigmas(const TrackElement& element, const Eigen::Vector3d& point) const {
  const Eigen::Vector3d in_cam = Pose(element.photo) * point;
  if (in_cam.z() <= 1e-6) return std::numeric_limits<double>::infinity();
  const Observation seen = ObservationOf(element);
  return (Lens(element.photo).ProjectBeyondFold(in_cam) - seen.pixel_in_image).norm() / seen.sigma_px;
}

// Where the rays come nearest; the observation with the largest residual goes until all agree.
void Block::Triangulate(int track) {
  const KeypointTrack& elements = scene()[track];
  std::vector<int>& kept = seen_by_[track];
  kept.clear();
  for (std::size_t s = 0; s < elements.size(); ++s) {
    if (Has(elements[s].photo)) kept.push_back(static_cast<int>(s));
  }
  std::vector<Eigen::Vector3d> rays;
  for (const int s : kept) {
    const auto& [photo, keypoint] = elements[s];
    rays.push_back(cam_from_world_[photo].rotation.conjugate() * rays_[photo][keypoint]);
  }
  WidePair wide(kMinAngleOfPointRad);
  while (wide.IsAmong(rays)) {
    RayIntersection intersection;
    for (std::size_t k = 0; k < kept.size(); ++k)
      intersection.Add(Pose(elements[kept[k]].photo).TargetOriginInSource(), rays[k]);
    const Eigen::Vector3d point = intersection.Point();
    double most = 0.0;
    std::size_t worst = 0;
    for (std::size_t k = 0; k < kept.size(); ++k) {
      const double residual = ResidualSigmas(elements[kept[k]], point);
      if (residual <= most) continue;
      most = residual;
      worst = k;
    }
    if (most <= kToleranceSigmas) {
      point_[track] = point;
      return;
    }
    kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(worst));
    rays.erase(rays.begin() + static_cast<std::ptrdiff_t>(worst));
    wide.TakeOut(worst);
  }
  kept.clear();
}

void Block::TriangulateEach(const std::vector<int>& tracks, int threads) {
  constexpr std::size_t kChunk = 512;
  ParallelFor((tracks.size() + kChunk - 1) / kChunk, threads, [&](std::size_t chunk) {
    const std::size_t last = std::min(tracks.size(), (chunk + 1) * kChunk);
    for (std::size_t t = chunk * kChunk; t < last; ++t) Triangulate(tracks[t]);
  });
}

void Block::TriangulateAll(int threads) {
  std::vector<int> tracks(scene().size());
  std::iota(tracks.begin(), tracks.end(), 0);
  TriangulateEach(tracks, threads);
}

void Block::TriangulateSeenBy(const std::vector<int>& photos, int threads) {
  std::vector<int> tracks;
  for (const int photo : photos) {
    const std::vector<int>& seen = input_->tracks_of[photo];
    tracks.insert(tracks.end(), seen.begin(), seen.end());
  }
  std::sort(tracks.begin(), tracks.end());
  tracks.erase(std::unique(tracks.begin(), tracks.end()), tracks.end());
  TriangulateEach(tracks, threads);
}

Track Block::TrackOf(int track) const {
  Track observed;
  observed.point_in_enu = point_[track];
  for (const int s : seen_by_[track]) observed.observations.push_back(ObservationOf(scene()[track][s]));
  return observed;
}

// Points that many photos see first, and of each photo only as many as it needs, spread over its picture.
std::vector<int> Block::ChooseTracks(const PhotoSet& adjusted, int observations_per_photo) const {
  std::vector<int> order;
  for (std::size_t t = 0; t < scene().size(); ++t) {
    const KeypointTrack& elements = scene()[t];
    const bool counts = std::any_of(seen_by_[t].begin(), seen_by_[t].end(),
                                    [&](int s) { return adjusted.Has(elements[s].photo); });
    if (counts) order.push_back(static_cast<int>(t));
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return SeenBy(a).size() > SeenBy(b).size(); });
  TrackSpread spread(input_->Photos(), observations_per_photo, kCellsAcross);
  for (const int t : order) {
    spread.BeginTrack();
    for (const int s : SeenBy(t)) {
      const TrackElement& element = scene()[t][s];
      if (adjusted.Has(element.photo))
        spread.SeenBy(element.photo, ObservationOf(element).pixel_in_image, Lens(element.photo));
    }
  }
  std::vector<int> chosen;
  for (const std::size_t o : spread.Choose()) chosen.push_back(order[o]);
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

void Block::Adjust(const std::vector<int>& free, BundleOptions options, int observations_per_photo,
                   int threads) {
  PhotoSet adjusted = free.empty() ? placed_ : PhotoSet(placed_.Photos());
  for (const int photo : free) {
    if (Has(photo)) adjusted.Add(photo);
  }
  BundleProblem problem;
  problem.lenses = lenses_;
  std::vector<int> number(placed_.Photos(), -1);
  std::vector<int> photo_of;
  const auto number_of = [&](int photo) {
    int& own = number[photo];
    if (own >= 0) return own;
    own = static_cast<int>(photo_of.size());
    photo_of.push_back(photo);
    BundlePhoto bundled;
    bundled.cam_from_enu = bundled.prior_cam_from_enu = Pose(photo);
    bundled.sigma_position_m.setConstant(kUnheldSigma);
    bundled.sigma_attitude_rad.setConstant(kUnheldSigma);
    bundled.lens = input_->lens_of[photo];
    bundled.height_above_ground_m = kMedianDepth;
    bundled.is_fixed = !adjusted.Has(photo);
    problem.photos.push_back(bundled);
    return own;
  };
  for (const int t : ChooseTracks(adjusted, observations_per_photo)) {
    Track& track = problem.tracks.emplace_back(TrackOf(t));
    for (Observation& seen : track.observations) seen.photo = number_of(seen.photo);
  }
  if (problem.tracks.empty()) return;
  options.adjust_lens = options.adjust_lens && free.empty();
  AdjustBundle(problem, options);
  for (std::size_t n = 0; n < photo_of.size(); ++n) {
    if (!problem.photos[n].is_fixed) {
      cam_from_world_[photo_of[n]] = problem.photos[n].cam_from_enu;
    }
  }
  if (!free.empty()) {
    TriangulateSeenBy(free, threads);
    return;
  }
  if (options.adjust_lens) {
    lenses_ = std::move(problem.lenses);
    ParallelFor(placed_.Photos(), threads, [&](std::size_t i) {
      if (placed_.Has(i)) FindRays(static_cast<int>(i));
    });
  }
  TriangulateAll(threads);
  Normalise();
}

void Block::Normalise() {
  std::vector<double> depths;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (std::size_t t = 0; t < point_.size(); ++t) {
    for (const int s : seen_by_[t]) {
      depths.push_back((Pose(scene()[t][s].photo) * point_[t]).z());
    }
  }
  const int placed = size();
  if (depths.empty() || placed == 0) return;
  for (std::size_t i = 0; i < placed_.Photos(); ++i) {
    if (placed_.Has(i)) middle += cam_from_world_[i].TargetOriginInSource() / placed;
  }
  const double scale = kMedianDepth / Median(std::move(depths));
  const Eigen::Vector3d shift = -scale * middle;
  for (std::size_t i = 0; i < placed_.Photos(); ++i) {
    if (!placed_.Has(i)) continue;
    cam_from_world_[i] = geo::Rigid3::FromRotationAndTargetOrigin(
        cam_from_world_[i].rotation.normalized(), scale * cam_from_world_[i].TargetOriginInSource() + shift);
  }
  for (std::size_t t = 0; t < point_.size(); ++t) {
    if (!seen_by_[t].empty()) point_[t] = scale * point_[t] + shift;
  }
}

std::vector<int> Block::PointsSeen() const {
  std::vector<int> seen(placed_.Photos(), 0);
  for (std::size_t t = 0; t < seen_by_.size(); ++t) {
    for (const int s : seen_by_[t]) {
      ++seen[scene()[t][s].photo];
    }
  }
  return seen;
}

std::vector<double> Block::ResidualsPx() const {
  std::vector<double> square(placed_.Photos(), 0.0);
  const std::vector<int> seen = PointsSeen();
  for (std::size_t t = 0; t < seen_by_.size(); ++t) {
    for (const int s : seen_by_[t]) {
      const TrackElement& element = scene()[t][s];
      const double residual = ResidualSigmas(element, point_[t]) * ObservationOf(element).sigma_px;
      square[element.photo] += residual * residual;
    }
  }
  for (std::size_t i = 0; i < square.size(); ++i)
    square[i] = seen[i] > 0 ? std::sqrt(square[i] / seen[i]) : 0.0;
  return square;
}

std::vector<Track> Block::Tracks() const {
  std::vector<Track> tracks;
  for (std::size_t t = 0; t < seen_by_.size(); ++t) {
    if (!seen_by_[t].empty()) tracks.push_back(TrackOf(static_cast<int>(t)));
  }
  return tracks;
}

}  // namespace skyquilt::alignment
