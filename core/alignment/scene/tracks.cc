#include "core/alignment/scene/tracks.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>

#include "core/alignment/scene/disjoint_sets.h"
#include "core/geo/solvers/dense_solvers.h"

namespace skyquilt::alignment {
namespace {

constexpr double kFineScales = 60.0;    // keypoints of sizes up to this many sigmas are located alike
constexpr double kMaxCoarseness = 2.5;  // of the finest
constexpr int kThinnedCellsAcross = 14;

double Coarseness(const PhotoFeatures& features, int keypoint) {
  const double size = features.keypoints[keypoint].scale_px;
  return std::max(1.0, size / (features.sigma_px * kFineScales));
}

// Two keypoints of one photo that describe one place in two directions.
bool IsOnePlace(const PhotoFeatures& features, int a, int b) {
  const Keypoint& x = features.keypoints[a];
  const Keypoint& y = features.keypoints[b];
  return std::hypot(x.x_px - y.x_px, x.y_px - y.y_px) <= 1.0F;
}

// The keypoints of all photos under running numbers: the first of each photo, and at last how many there are.
std::vector<int> FirstKeypoints(const std::vector<const PhotoFeatures*>& features) {
  std::vector<int> first_of{0};
  for (const PhotoFeatures* one : features)
    first_of.push_back(first_of.back() + (one ? static_cast<int>(one->keypoints.size()) : 0));
  return first_of;
}

// Long tracks first, and of each photo only as many as its cells have room for.
std::vector<Track> Thin(std::vector<Track> tracks, const std::vector<View>& views,
                        int observations_per_photo) {
  std::stable_sort(tracks.begin(), tracks.end(), [](const Track& a, const Track& b) {
    return a.observations.size() > b.observations.size();
  });
  TrackSpread spread(views.size(), observations_per_photo, kThinnedCellsAcross);
  for (const Track& track : tracks) {
    spread.BeginTrack();
    for (const Observation& seen : track.observations)
      spread.SeenBy(seen.photo, seen.pixel_in_image, views[seen.photo].intrinsics);
  }
  std::vector<Track> thinned;
  for (const std::size_t t : spread.Choose()) thinned.push_back(std::move(tracks[t]));
  return thinned;
}

Eigen::Vector3d RayInEnu(const View& view, const geo::Rigid3& cam_from_enu, const Eigen::Vector2d& pixel) {
  return (cam_from_enu.rotation.conjugate() * view.intrinsics.Unproject(pixel)).normalized();
}

std::vector<Eigen::Vector3d> RaysInEnu(const std::vector<View>& views, const Track& track) {
  std::vector<Eigen::Vector3d> rays;
  rays.reserve(track.observations.size());
  for (const Observation& seen : track.observations) {
    const View& view = views[seen.photo];
    rays.push_back(RayInEnu(view, view.CamFromEnuAt(seen.pixel_in_image), seen.pixel_in_image));
  }
  return rays;
}

// Places the point; false where it lies nowhere that its photos can show.
bool Intersect(const std::vector<View>& views, Track& track) {
  RayIntersection intersection;
  for (const Observation& seen : track.observations) {
    const View& view = views[seen.photo];
    const geo::Rigid3 cam_from_enu = view.CamFromEnuAt(seen.pixel_in_image);
    intersection.Add(cam_from_enu.TargetOriginInSource(), RayInEnu(view, cam_from_enu, seen.pixel_in_image));
  }
  track.point_in_enu = intersection.Point();
  for (const Observation& seen : track.observations) {
    const View& view = views[seen.photo];
    const double depth = (view.cam_from_enu * track.point_in_enu).z();
    if (depth < 0.2 * view.height_above_ground_m || depth > 6.0 * view.height_above_ground_m) return false;
  }
  return true;
}

}  // namespace

Observation ObservationOf(const PhotoFeatures& features, const TrackElement& element) {
  const Keypoint& seen = features.keypoints[element.keypoint];
  return {element.photo, Eigen::Vector2d(seen.x_px, seen.y_px),
          features.sigma_px * Coarseness(features, element.keypoint)};
}

PhotoSet ObservingPhotos(std::size_t photos, const std::vector<Track>& tracks) {
  PhotoSet observing(photos);
  for (const Track& track : tracks) {
    for (const Observation& seen : track.observations) observing.Add(seen.photo);
  }
  return observing;
}

std::vector<Eigen::Vector3d> PointsWithHeights(const std::vector<Track>& tracks) {
  constexpr double kUsefulAngleRad = 0.06;
  std::vector<Eigen::Vector3d> points;
  for (const Track& track : tracks) {
    if (track.angle_rad > kUsefulAngleRad) points.push_back(track.point_in_enu);
  }
  return points;
}

double WidestAngle(const std::vector<View>& views, const Track& track) {
  const std::vector<Eigen::Vector3d> rays = RaysInEnu(views, track);
  double min_cosine = 1.0;
  for (std::size_t a = 0; a < rays.size(); ++a) {
    for (std::size_t b = a + 1; b < rays.size(); ++b) {
      min_cosine = std::min(min_cosine, rays[a].dot(rays[b]));
    }
  }
  return std::acos(std::clamp(min_cosine, -1.0, 1.0));
}

bool Triangulate(const std::vector<View>& views, Track& track) {
  track.angle_rad = WidestAngle(views, track);
  return track.angle_rad >= kMinAngleRad && Intersect(views, track);
}

bool TriangulateAgreed(const std::vector<View>& views, double max_sigmas, Track& track) {
  std::vector<Observation>& observations = track.observations;
  std::vector<Eigen::Vector3d> rays = RaysInEnu(views, track);
  WidePair wide(kMinAngleRad);
  while (wide.IsAmong(rays) && Intersect(views, track)) {
    double most = 0.0;
    std::size_t worst = 0;
    for (std::size_t k = 0; k < observations.size(); ++k) {
      const Observation& one = observations[k];
      const double error = ReprojectionErrorPx(views[one.photo], one, track.point_in_enu) / one.sigma_px;
      if (error <= most) continue;
      most = error;
      worst = k;
    }
    if (most <= max_sigmas) {
      track.angle_rad = WidestAngle(views, track);
      return true;
    }
    // It goes first, for it pulls the point away from the others.
    observations.erase(observations.begin() + static_cast<std::ptrdiff_t>(worst));
    rays.erase(rays.begin() + static_cast<std::ptrdiff_t>(worst));
    wide.TakeOut(worst);
  }
  return false;
}

double ReprojectionErrorPx(const View& view, const Observation& observation,
                           const Eigen::Vector3d& point_in_enu) {
  const Eigen::Vector3d in_cam = view.CamFromEnuAt(observation.pixel_in_image) * point_in_enu;
  if (in_cam.z() <= 1e-6) return std::numeric_limits<double>::infinity();
  const Eigen::Vector2d off_px = view.intrinsics.ProjectBeyondFold(in_cam) - observation.pixel_in_image;
  return std::hypot(off_px.x(), off_px.y());
}

std::vector<Track> BuildTracks(const std::vector<PhotoPair>& pairs,
                               const std::vector<const PhotoFeatures*>& features,
                               const std::vector<View>& views, const TrackOptions& options) {
  const std::vector<int> first_of = FirstKeypoints(features);
  DisjointSets sets(first_of.back());
  const auto set_of = [&](const TrackElement& one) { return sets.SetOf(first_of[one.photo] + one.keypoint); };
  for (const PhotoPair& pair : pairs) {
    for (const KeypointMatch& match : pair.matches) {
      sets.Join(set_of({pair.first, match.first}), set_of({pair.second, match.second}));
    }
  }
  const auto is_located = [&](const TrackElement& one) {
    return Coarseness(*features[one.photo], one.keypoint) <= kMaxCoarseness;
  };
  std::vector<std::vector<TrackElement>> members(sets.size());
  for (std::size_t i = 0; i < features.size(); ++i) {
    if (!features[i]) continue;
    for (int k = 0; k < static_cast<int>(features[i]->keypoints.size()); ++k) {
      const TrackElement one{static_cast<int>(i), k};
      // What is as large as a house has no place to within pixels.
      if (is_located(one)) members[set_of(one)].push_back(one);
    }
  }
  std::vector<Track> tracks;
  std::vector<bool> is_contradictory(members.size(), false);
  for (std::size_t set = 0; set < members.size(); ++set) {
    const std::vector<TrackElement>& group = members[set];
    if (group.size() < 2) continue;
    Track track;
    for (std::size_t m = 0; m < group.size(); ++m) {
      const auto& [photo, keypoint] = group[m];
      if (m > 0 && group[m - 1].photo == photo) {
        // Two keypoints of one photo: the same place seen in two directions is harmless, two places are not.
        if (!IsOnePlace(*features[photo], group[m - 1].keypoint, keypoint)) is_contradictory[set] = true;
        continue;
      }
      track.observations.push_back(ObservationOf(*features[photo], group[m]));
    }
    if (!is_contradictory[set] && track.observations.size() >= 2) tracks.push_back(std::move(track));
  }
  for (const PhotoPair& pair : pairs) {
    if (!options.splits_contradictory) break;
    for (const KeypointMatch& match : pair.matches) {
      const TrackElement first{pair.first, match.first}, second{pair.second, match.second};
      if (!is_contradictory[set_of(first)] || !is_located(first) || !is_located(second)) continue;
      Track track;
      track.observations = {ObservationOf(*features[first.photo], first),
                            ObservationOf(*features[second.photo], second)};
      tracks.push_back(std::move(track));
    }
  }
  return Thin(std::move(tracks), views, options.observations_per_photo);
}

std::vector<KeypointTrack> JoinMatches(const std::vector<const PhotoFeatures*>& features,
                                       const std::vector<PhotoPair>& pairs) {
  std::vector<std::size_t> order(pairs.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return pairs[a].matches.size() > pairs[b].matches.size();
  });
  const std::vector<int> first_of = FirstKeypoints(features);
  DisjointSets sets(first_of.back());
  const auto set_of = [&](const TrackElement& one) { return sets.SetOf(first_of[one.photo] + one.keypoint); };
  std::vector<KeypointTrack> members(sets.size());  // by set, each photo at most once
  for (std::size_t i = 0; i < features.size(); ++i) {
    if (!features[i]) continue;
    for (int k = 0; k < static_cast<int>(features[i]->keypoints.size()); ++k)
      members[set_of({static_cast<int>(i), k})] = {{static_cast<int>(i), k}};
  }
  const auto join = [&](const TrackElement& first, const TrackElement& second) {
    const int a = set_of(first), b = set_of(second);
    if (a == b) return;
    KeypointTrack& of_a = members[a];
    KeypointTrack& of_b = members[b];
    KeypointTrack merged;
    merged.reserve(of_a.size() + of_b.size());
    auto next_a = of_a.begin();
    auto next_b = of_b.begin();
    while (next_a != of_a.end() || next_b != of_b.end()) {
      if (next_b == of_b.end() || (next_a != of_a.end() && next_a->photo < next_b->photo)) {
        merged.push_back(*next_a++);
      } else if (next_a == of_a.end() || next_b->photo < next_a->photo) {
        merged.push_back(*next_b++);
      } else {
        if (!IsOnePlace(*features[next_a->photo], next_a->keypoint, next_b->keypoint)) return;
        merged.push_back(*next_a++);
        ++next_b;
      }
    }
    sets.Join(a, b);
    members[std::max(a, b)] = {};
    members[std::min(a, b)] = std::move(merged);
  };
  for (const std::size_t p : order) {
    const PhotoPair& pair = pairs[p];
    for (const KeypointMatch& match : pair.matches) {
      join({pair.first, match.first}, {pair.second, match.second});
    }
  }
  std::erase_if(members, [](const KeypointTrack& track) { return track.size() < 2; });
  members.shrink_to_fit();  // most keypoints are in no track
  return members;
}

TrackSpread::TrackSpread(std::size_t photos, int observations_per_photo, int cells_across)
    : photos_(photos), cells_across_(cells_across), observations_per_photo_(observations_per_photo) {}

void TrackSpread::SeenBy(int photo, const Eigen::Vector2d& pixel_in_image, const camera::Intrinsics& lens) {
  const auto across = static_cast<int>(cells_across_);
  const auto along = [&](double pixel, int size_px) {
    return std::clamp(static_cast<int>(pixel * across / size_px), 0, across - 1);
  };
  const std::size_t at = photo;
  seen_.push_back({at, (at * cells_across_ + along(pixel_in_image.y(), lens.height_px)) * cells_across_ +
                           along(pixel_in_image.x(), lens.width_px)});
}

std::vector<std::size_t> TrackSpread::Choose() const {
  const std::size_t cells = cells_across_ * cells_across_;
  std::vector<int> in_cell(photos_ * cells, 0), in_photo(photos_, 0);
  std::vector<bool> is_chosen(begins_.size(), false);
  const int rounds = 1 + 3 * observations_per_photo_ / static_cast<int>(cells);
  for (int round = 1; round <= rounds; ++round) {
    for (std::size_t t = 0; t < begins_.size(); ++t) {
      if (is_chosen[t]) continue;
      const std::size_t end = t + 1 < begins_.size() ? begins_[t + 1] : seen_.size();
      const std::span<const PhotoCell> seen(seen_.data() + begins_[t], end - begins_[t]);
      is_chosen[t] = std::any_of(seen.begin(), seen.end(), [&](const PhotoCell& one) {
        return in_cell[one.cell] < round && in_photo[one.photo] < observations_per_photo_;
      });
      if (!is_chosen[t]) continue;
      for (const PhotoCell& one : seen) {
        ++in_cell[one.cell];
        ++in_photo[one.photo];
      }
    }
  }
  std::vector<std::size_t> chosen;
  for (std::size_t t = 0; t < is_chosen.size(); ++t) {
    if (is_chosen[t]) chosen.push_back(t);
  }
  return chosen;
}

void RayIntersection::Add(const Eigen::Vector3d& center, const Eigen::Vector3d& ray) {
  const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - ray * ray.transpose();
  normal_ += across;
  right_ += across * center;
}

Eigen::Vector3d RayIntersection::Point() const { return geo::SolveSymmetric(normal_, right_); }

}  // namespace skyquilt::alignment
