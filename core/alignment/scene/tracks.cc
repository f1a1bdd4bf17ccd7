#include "core/alignment/scene/tracks.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/geo/solvers/dense_solvers.h"

namespace skyquilt::alignment {
namespace {

constexpr double kFineScales = 60.0;  // sizes up to this many sigmas are located alike
constexpr double kMaxCoarseness = 2.5;

class Sets {
 public:
  explicit Sets(std::size_t count) : root_(count) { std::iota(root_.begin(), root_.end(), 0); }
  int Find(int i) {
    while (root_[i] != i) i = root_[i] = root_[root_[i]];
    return i;
  }
  void Join(int a, int b) {
    a = Find(a);
    b = Find(b);
    root_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<int> root_;
};

// Long tracks first, and of each photo only as many as its cells have room for.
std::vector<Track> Thin(std::vector<Track> tracks, const std::vector<View>& views,
                        const TrackOptions& options) {
  std::stable_sort(tracks.begin(), tracks.end(), [](const Track& a, const Track& b) {
    return a.observations.size() > b.observations.size();
  });
  const int across = options.cells_across;
  const std::size_t cells = static_cast<std::size_t>(across) * across;
  std::vector<std::vector<int>> taken(views.size(), std::vector<int>(cells, 0));
  std::vector<int> total(views.size(), 0);
  const auto cell_of = [&](const Observation& seen) {
    const camera::Intrinsics& lens = views[seen.photo].intrinsics;
    const int x =
        std::clamp(static_cast<int>(seen.pixel_in_image.x() * across / lens.width_px), 0, across - 1);
    const int y =
        std::clamp(static_cast<int>(seen.pixel_in_image.y() * across / lens.height_px), 0, across - 1);
    return static_cast<std::size_t>(y) * across + x;
  };
  std::vector<char> kept(tracks.size(), 0);
  // Rounds fill every cell with one track before any cell gets the next.
  const int rounds = std::max(1, 3 * options.observations_per_photo / static_cast<int>(cells) + 1);
  for (int round = 1; round <= rounds; ++round) {
    for (std::size_t t = 0; t < tracks.size(); ++t) {
      if (kept[t]) continue;
      const auto& seen = tracks[t].observations;
      const bool wanted = std::any_of(seen.begin(), seen.end(), [&](const Observation& one) {
        return taken[one.photo][cell_of(one)] < round && total[one.photo] < options.observations_per_photo;
      });
      if (!wanted) continue;
      kept[t] = 1;
      for (const Observation& one : seen) {
        ++taken[one.photo][cell_of(one)];
        ++total[one.photo];
      }
    }
  }
  std::vector<Track> thinned;
  for (std::size_t t = 0; t < tracks.size(); ++t) {
    if (kept[t]) thinned.push_back(std::move(tracks[t]));
  }
  return thinned;
}

}  // namespace

double WidestAngle(const std::vector<View>& views, const Track& track) {
  std::vector<Eigen::Vector3d> rays;
  rays.reserve(track.observations.size());
  for (const Observation& seen : track.observations) {
    const View& view = views[seen.photo];
    const Eigen::Quaterniond enu_from_cam = view.CamFromEnuAt(seen.pixel_in_image).rotation.conjugate();
    rays.push_back((enu_from_cam * view.intrinsics.Unproject(seen.pixel_in_image)).normalized());
  }
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
  if (track.angle_rad < kMinAngleRad) return false;
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Observation& seen : track.observations) {
    const View& view = views[seen.photo];
    const geo::Rigid3 cam_from_enu = view.CamFromEnuAt(seen.pixel_in_image);
    const Eigen::Vector3d ray =
        (cam_from_enu.rotation.conjugate() * view.intrinsics.Unproject(seen.pixel_in_image)).normalized();
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - ray * ray.transpose();
    normal += across;
    right += across * cam_from_enu.TargetOriginInSource();
  }
  track.point_in_enu = geo::SolveSymmetric(normal, right);
  for (const Observation& seen : track.observations) {
    const View& view = views[seen.photo];
    const double depth = (view.cam_from_enu * track.point_in_enu).z();
    if (depth < 0.2 * view.height_above_ground_m || depth > 6.0 * view.height_above_ground_m) return false;
  }
  return true;
}

double ReprojectionErrorPx(const View& view, const Observation& observation,
                           const Eigen::Vector3d& point_in_enu) {
  const Eigen::Vector3d in_cam = view.CamFromEnuAt(observation.pixel_in_image) * point_in_enu;
  if (in_cam.z() <= 1e-6) return std::numeric_limits<double>::infinity();
  const Eigen::Vector2d bent = view.intrinsics.Distort(in_cam.head<2>() / in_cam.z());
  return std::hypot(
      view.intrinsics.focal_x_px * bent.x() + view.intrinsics.center_x_px - observation.pixel_in_image.x(),
      view.intrinsics.focal_y_px * bent.y() + view.intrinsics.center_y_px - observation.pixel_in_image.y());
}

std::vector<Track> BuildTracks(const std::vector<VerifiedPair>& pairs,
                               const std::vector<const PhotoFeatures*>& features,
                               const std::vector<View>& views, const TrackOptions& options) {
  std::vector<int> first_of(features.size() + 1, 0);
  for (std::size_t i = 0; i < features.size(); ++i) {
    first_of[i + 1] = first_of[i] + (features[i] ? static_cast<int>(features[i]->keypoints.size()) : 0);
  }
  Sets sets(first_of.back());
  for (const VerifiedPair& pair : pairs) {
    for (const KeypointMatch& match : pair.matches) {
      sets.Join(first_of[pair.first] + match.first, first_of[pair.second] + match.second);
    }
  }
  const auto coarseness = [&](std::size_t photo, int keypoint) {
    return std::max(
        1.0, features[photo]->keypoints[keypoint].scale_px / (features[photo]->sigma_px * kFineScales));
  };
  std::vector<std::vector<std::pair<int, int>>> members(first_of.back());  // photo, keypoint
  for (std::size_t i = 0; i < features.size(); ++i) {
    for (int k = first_of[i]; k < first_of[i + 1]; ++k) {
      // What is as large as a house has no place to within pixels.
      if (coarseness(i, k - first_of[i]) > kMaxCoarseness) continue;
      members[sets.Find(k)].emplace_back(static_cast<int>(i), k - first_of[i]);
    }
  }
  std::vector<Track> tracks;
  std::vector<char> is_contradictory(members.size(), 0);
  const auto observe = [&](std::size_t photo, int keypoint) {
    const Keypoint& seen = features[photo]->keypoints[keypoint];
    return Observation{static_cast<int>(photo), Eigen::Vector2d(seen.x_px, seen.y_px),
                       features[photo]->sigma_px * coarseness(photo, keypoint)};
  };
  for (std::size_t set = 0; set < members.size(); ++set) {
    const auto& group = members[set];
    if (group.size() < 2) continue;
    Track track;
    bool contradictory = false;
    for (std::size_t m = 0; m < group.size(); ++m) {
      const auto& [photo, keypoint] = group[m];
      const Keypoint& seen = features[photo]->keypoints[keypoint];
      if (m > 0 && group[m - 1].first == photo) {
        // Two keypoints of one photo: the same place seen in two directions is harmless, two places are not.
        const Keypoint& before = features[photo]->keypoints[group[m - 1].second];
        if (std::hypot(seen.x_px - before.x_px, seen.y_px - before.y_px) > 1.0F) contradictory = true;
        continue;
      }
      track.observations.push_back(observe(photo, keypoint));
    }
    is_contradictory[set] = contradictory ? 1 : 0;
    if (!contradictory && track.observations.size() >= 2) tracks.push_back(std::move(track));
  }
  for (const VerifiedPair& pair : pairs) {
    if (!options.splits_contradictory) break;
    for (const KeypointMatch& match : pair.matches) {
      if (!is_contradictory[sets.Find(first_of[pair.first] + match.first)]) continue;
      if (coarseness(pair.first, match.first) > kMaxCoarseness ||
          coarseness(pair.second, match.second) > kMaxCoarseness) {
        continue;
      }
      Track track;
      track.observations = {observe(pair.first, match.first), observe(pair.second, match.second)};
      tracks.push_back(std::move(track));
    }
  }
  return Thin(std::move(tracks), views, options);
}

}  // namespace skyquilt::alignment
