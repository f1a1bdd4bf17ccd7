#include "core/alignment/scene/tracks.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/alignment/scene/keypoint_sets.h"
#include "core/alignment/scene/ray_intersection.h"
#include "core/alignment/scene/track_spread.h"

namespace skyquilt::alignment {
namespace {

constexpr double kMaxCoarseness = 2.5;  // of the finest

// Long tracks first, and of each photo only as many as its cells have room for.
std::vector<Track> Thin(std::vector<Track> tracks, const std::vector<View>& views,
                        const TrackOptions& options) {
  std::stable_sort(tracks.begin(), tracks.end(), [](const Track& a, const Track& b) {
    return a.observations.size() > b.observations.size();
  });
  TrackSpread spread(views.size(), options.observations_per_photo, options.cells_across);
  for (const Track& track : tracks) {
    spread.BeginTrack();
    for (const Observation& seen : track.observations)
      spread.SeenBy(seen.photo, seen.pixel_in_image, views[seen.photo].intrinsics);
  }
  std::vector<Track> thinned;
  for (const std::size_t t : spread.Choose()) thinned.push_back(std::move(tracks[t]));
  return thinned;
}

}  // namespace

PhotoSet ObservingPhotos(std::size_t photos, const std::vector<Track>& tracks) {
  PhotoSet observing(photos);
  for (const Track& track : tracks) {
    for (const Observation& seen : track.observations) observing.Add(seen.photo);
  }
  return observing;
}

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
  RayIntersection intersection;
  for (const Observation& seen : track.observations) {
    const View& view = views[seen.photo];
    const geo::Rigid3 cam_from_enu = view.CamFromEnuAt(seen.pixel_in_image);
    const Eigen::Vector3d ray =
        (cam_from_enu.rotation.conjugate() * view.intrinsics.Unproject(seen.pixel_in_image)).normalized();
    intersection.Add(cam_from_enu.TargetOriginInSource(), ray);
  }
  track.point_in_enu = intersection.Point();
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
  const Eigen::Vector2d off_px = view.intrinsics.ProjectBeyondFold(in_cam) - observation.pixel_in_image;
  return std::hypot(off_px.x(), off_px.y());
}

std::vector<Track> BuildTracks(const std::vector<VerifiedPair>& pairs,
                               const std::vector<const PhotoFeatures*>& features,
                               const std::vector<View>& views, const TrackOptions& options) {
  KeypointSets sets(features);
  for (const VerifiedPair& pair : pairs) {
    for (const KeypointMatch& match : pair.matches) {
      sets.Join(sets.Find(sets.NumberOf(pair.first, match.first)),
                sets.Find(sets.NumberOf(pair.second, match.second)));
    }
  }
  const auto is_located = [&](std::size_t photo, int keypoint) {
    return KeypointCoarseness(*features[photo], keypoint) <= kMaxCoarseness;
  };
  std::vector<std::vector<std::pair<int, int>>> members(sets.size());  // photo, keypoint
  for (std::size_t i = 0; i < features.size(); ++i) {
    if (!features[i]) continue;
    for (int k = 0; k < static_cast<int>(features[i]->keypoints.size()); ++k) {
      // What is as large as a house has no place to within pixels.
      if (is_located(i, k)) members[sets.Find(sets.NumberOf(i, k))].emplace_back(static_cast<int>(i), k);
    }
  }
  std::vector<Track> tracks;
  std::vector<bool> is_contradictory(members.size(), false);
  const auto observe = [&](std::size_t photo, int keypoint) {
    const Keypoint& seen = features[photo]->keypoints[keypoint];
    return Observation{static_cast<int>(photo), Eigen::Vector2d(seen.x_px, seen.y_px),
                       KeypointSigmaPx(*features[photo], keypoint)};
  };
  for (std::size_t set = 0; set < members.size(); ++set) {
    const auto& group = members[set];
    if (group.size() < 2) continue;
    Track track;
    for (std::size_t m = 0; m < group.size(); ++m) {
      const auto& [photo, keypoint] = group[m];
      if (m > 0 && group[m - 1].first == photo) {
        // Two keypoints of one photo: the same place seen in two directions is harmless, two places are not.
        if (!IsOnePlace(*features[photo], group[m - 1].second, keypoint)) is_contradictory[set] = true;
        continue;
      }
      track.observations.push_back(observe(photo, keypoint));
    }
    if (!is_contradictory[set] && track.observations.size() >= 2) tracks.push_back(std::move(track));
  }
  for (const VerifiedPair& pair : pairs) {
    if (!options.splits_contradictory) break;
    for (const KeypointMatch& match : pair.matches) {
      if (!is_contradictory[sets.Find(sets.NumberOf(pair.first, match.first))]) continue;
      if (!is_located(pair.first, match.first) || !is_located(pair.second, match.second)) continue;
      Track track;
      track.observations = {observe(pair.first, match.first), observe(pair.second, match.second)};
      tracks.push_back(std::move(track));
    }
  }
  return Thin(std::move(tracks), views, options);
}

}  // namespace skyquilt::alignment
