#include "core/alignment/attempts/lost_photos.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <unordered_map>
#include <utility>

#include "core/alignment/attempts/attempt_by_images.h"
#include "core/alignment/from_records/bundle_setup.h"
#include "core/alignment/from_records/correct_poses.h"
#include "core/alignment/matching/appearance.h"
#include "core/alignment/matching/match_descriptors.h"
#include "core/base/median.h"
#include "core/base/parallel_for.h"
#include "core/base/trace.h"

namespace skyquilt::alignment {
namespace {

constexpr int kMaxSteps = 3;             // in the order of capture, either way
constexpr std::size_t kNearest = 8;      // by recorded position
constexpr int kAlike = 8;                // of photos without one
constexpr std::size_t kMinInliers = 20;  // of one lost photo
constexpr int kMinMatchesOfALink = 6;
constexpr int kMaxFeatures = 2000;
constexpr int kMaxSamples = 1000;
constexpr double kMaxHeightRatio = 6.0;  // to the other photos' heights: a climb of five times is flown
constexpr std::uint64_t kSeed = 0x10571057;

using TrackOfPixel = std::unordered_map<std::uint64_t, const Track*>;

std::uint64_t KeyOf(double x_px, double y_px) {
  return (std::uint64_t{std::bit_cast<std::uint32_t>(static_cast<float>(x_px))} << 32) |
         std::bit_cast<std::uint32_t>(static_cast<float>(y_px));
}

// By photo, which track each of its pixels sees; of photos of the alignment.
std::vector<TrackOfPixel> IndexTracks(const PhotoSet& tied, const std::vector<Track>& tracks) {
  std::vector<TrackOfPixel> indexed(tied.Photos());
  for (const Track& track : tracks) {
    for (const Observation& one : track.observations) {
      if (!tied.Has(one.photo)) continue;
      indexed[one.photo].emplace(KeyOf(one.pixel_in_image.x(), one.pixel_in_image.y()), &track);
    }
  }
  return indexed;
}

std::vector<int> PartnersOf(const PhotoRecord& record, const std::vector<View>& views, const PhotoSet& tied,
                            int lost, const std::vector<int>& alike) {
  std::set<int> partners;
  const int count = static_cast<int>(views.size());
  for (const int step : {-1, 1}) {
    // The next aligned ones, over others that are lost too.
    int found = 0;
    for (int i = lost + step; i >= 0 && i < count && found < kMaxSteps; i += step) {
      if (!tied.Has(i)) continue;
      partners.insert(i);
      ++found;
    }
  }
  if (record.center_in_enu) {
    std::vector<std::pair<double, int>> near;
    for (int i = 0; i < count; ++i) {
      if (!tied.Has(i)) continue;
      const Eigen::Vector3d center = views[i].CenterInEnu();
      near.emplace_back((center - *record.center_in_enu).head<2>().norm(), i);
    }
    for (const int i : LeastFew(std::move(near), kNearest)) partners.insert(i);
  }
  for (const int i : alike) {
    if (tied.Has(i)) partners.insert(i);
  }
  return {partners.begin(), partners.end()};
}

struct Pairing {
  int partner = 0;
  KeypointMatch match;  // first: of the lost photo
};

std::vector<PhotoPair> LinksOf(const std::vector<Pairing>& pairings, const std::vector<int>& inliers,
                               int lost) {
  std::map<int, std::vector<KeypointMatch>> of_partner;
  for (const int k : inliers) {
    const Pairing& one = pairings[k];
    of_partner[one.partner].push_back(one.match);
  }
  std::vector<PhotoPair> links;
  for (auto& [partner, matches] : of_partner) {
    if (static_cast<int>(matches.size()) < kMinMatchesOfALink) continue;
    for (KeypointMatch& match : matches) {
      if (partner < lost) std::swap(match.first, match.second);
    }
    links.push_back({std::min(lost, partner), std::max(lost, partner), {}, std::move(matches), 0.0});
  }
  return links;
}

// What keypoints of aligned photos stand for: tracks alone, or the ground where they are none's.
enum class PointsOf { kTracks, kTracksAndGround };

std::optional<FoundPose> Resect(const ExtractedFlight& extracted, const Attempt& attempt,
                                const std::vector<TrackOfPixel>& indexed, const std::vector<int>& partners,
                                double median_height_m, int lost, PointsOf points_of) {
  const PhotoFeatures& features = *extracted.readable[lost];
  const std::vector<View>& views = attempt.matched.views;
  std::vector<PointObservation> observations;
  std::vector<Pairing> pairings;
  for (const int partner : partners) {
    const PhotoFeatures* other = extracted.readable[partner];
    if (!other) continue;
    for (const KeypointMatch& match : MatchDescriptors(features, *other, kMaxFeatures)) {
      const Keypoint& seen = other->keypoints[match.second];
      const auto track = indexed[partner].find(KeyOf(seen.x_px, seen.y_px));
      Eigen::Vector3d point_in_enu;
      if (track != indexed[partner].end()) {
        point_in_enu = track->second->point_in_enu;
      } else if (points_of == PointsOf::kTracks ||
                 !MeetGround(views[partner], attempt.relief, {seen.x_px, seen.y_px}, &point_in_enu)) {
        continue;
      }
      const Keypoint& keypoint = features.keypoints[match.first];
      observations.push_back({{keypoint.x_px, keypoint.y_px}, point_in_enu, features.sigma_px});
      pairings.push_back({partner, match});
    }
  }
  std::optional<FoundPose> found =
      FindPose(views[lost].intrinsics, observations, kSeed + static_cast<std::uint64_t>(lost),
               {.min_inliers = static_cast<int>(kMinInliers), .max_samples = kMaxSamples});
  if (!found) return std::nullopt;
  // A point seen by three partners is one witness, not three.
  std::set<std::pair<double, double>> pixels;
  std::vector<double> depths_m;
  for (const int k : found->inliers) {
    const PointObservation& observation = observations[k];
    pixels.emplace(observation.pixel_in_image.x(), observation.pixel_in_image.y());
    depths_m.push_back((found->cam_from_world.TargetOriginInSource() - observation.point_in_world).z());
  }
  if (pixels.size() < kMinInliers) return std::nullopt;
  const double height_m = Median(std::move(depths_m));
  if (height_m < median_height_m / kMaxHeightRatio || height_m > median_height_m * kMaxHeightRatio) {
    return std::nullopt;
  }
  found->photo = lost;
  found->links = LinksOf(pairings, found->inliers, lost);
  if (found->links.empty()) return std::nullopt;
  return found;
}

constexpr double kMaxLostShare = 0.3;

// A position that is as far off as this counts for nothing in what is said of the map.
bool IsSaidToBeFar(const flight::Photo& photo, const Eigen::Vector3d& center, const geo::LocalFrame& frame) {
  constexpr double kFarM = 1000.0;
  return photo.position &&
         !((frame.EnuAtHeight(photo.position->position, center.z()) - center).head<2>().norm() < kFarM);
}

// A photo without record: its pose is where it was found, give or take much.
PhotoFindings PlaceUnrecorded(const geo::Rigid3& cam_from_enu, double ground_z_m,
                              const geo::LocalFrame& frame, poses::PosedPhoto& photo) {
  photo.height_above_ground_m = std::max(0.5, cam_from_enu.TargetOriginInSource().z() - ground_z_m);
  const double unknown_m = kUnknownShare * photo.height_above_ground_m;
  HoldLoosely(cam_from_enu, Eigen::Vector3d::Constant(unknown_m), photo);
  photo.error_radius_m = unknown_m;
  PhotoFindings corrected;
  corrected.start_cam_from_enu = corrected.prior_cam_from_enu = cam_from_enu;
  corrected.notes = {flight::RemarkCode::kPlacedWithoutRecord};
  corrected.position_was_wrong = IsSaidToBeFar(photo.photo, cam_from_enu.TargetOriginInSource(), frame);
  return corrected;
}

}  // namespace

std::vector<FoundPose> RegisterLost(const ExtractedFlight& extracted, const Attempt& attempt,
                                    const PhotoSet& tied, const std::vector<Track>& tracks, int threads) {
  const std::vector<PhotoRecord>& records = extracted.records;
  const std::vector<View>& views = attempt.matched.views;
  const std::size_t count = views.size();
  std::vector<int> lost;
  std::vector<double> heights_m;
  bool any_without_position = false;
  for (std::size_t i = 0; i < count; ++i) {
    if (tied.Has(i)) {
      heights_m.push_back(views[i].height_above_ground_m);
    } else if (ShowsEnough(extracted.readable[i])) {
      lost.push_back(static_cast<int>(i));
      any_without_position = any_without_position || !records[i].center_in_enu;
    }
  }
  if (lost.empty() || heights_m.empty()) return {};
  const double median_height_m = Median(std::move(heights_m));
  std::vector<std::vector<int>> alike(count);
  // Learning what photos look like is worth its time only where no position says which are near.
  if (any_without_position) alike = Appearance::Learn(extracted.readable, threads).MostAlike(kAlike, threads);
  const std::vector<TrackOfPixel> indexed = IndexTracks(tied, tracks);
  return ParallelCollect(lost.size(), threads, [&](std::size_t k) {
    const int i = lost[k];
    const std::vector<int> partners =
        PartnersOf(records[i], views, tied, i, records[i].center_in_enu ? std::vector<int>() : alike[i]);
    const auto resect = [&](PointsOf points_of) {
      return Resect(extracted, attempt, indexed, partners, median_height_m, i, points_of);
    };
    if (auto found = resect(PointsOf::kTracks)) return found;
    return resect(PointsOf::kTracksAndGround);
  });
}

bool HasLost(const AttemptEvidence& evidence) {
  if (evidence.Lost() == 0 || evidence.tied < 2) return false;
  // What a map that stays holds is sound, however many are new beside it.
  const double most = std::max(1.0, kMaxLostShare * static_cast<double>(evidence.readable));
  return evidence.has_fixed || static_cast<double>(evidence.Lost()) <= most;
}

int TakeInLost(const ExtractedFlight& extracted, const std::vector<Track>& tracks, int threads,
               Attempt& attempt) {
  poses::PosedFlight& posed = attempt.posed;
  MatchedFlight& linked = attempt.matched;
  BundleProblem& problem = attempt.problem;
  const PhotoSet tied = TiedPhotos(attempt);
  const std::vector<FoundPose> found = RegisterLost(extracted, attempt, tied, tracks, threads);
  if (found.empty()) return 0;
  // Where the images placed the others, its record counts as little as theirs, and that is said of all of
  // them.
  const bool is_common = 2 * std::count_if(problem.photos.begin(), problem.photos.end(),
                                           [](const BundlePhoto& one) { return one.is_by_images; }) >
                         static_cast<std::ptrdiff_t>(problem.photos.size());
  const std::vector<PhotoGround> recorded = MakeGrounds(posed, MakeMatchedFlight(posed));
  for (const FoundPose& one : found) {
    const int i = one.photo;
    const geo::Rigid3& cam_from_enu = one.cam_from_world;
    std::erase_if(linked.links, [&](const PhotoPair& link) { return link.first == i || link.second == i; });
    linked.links.insert(linked.links.end(), one.links.begin(), one.links.end());
    if (problem.photos[i].is_fixed) continue;  // it stays, and holds those that it is tied to
    TraceDecision("lost photo registered", {{"photo", i}, {"tied_to", one.links.size()}},
                  posed.photos[i].photo.name);
    const bool is_unrecorded = is_common || extracted.records[i].is_unplaced;
    linked.findings[i] =
        is_unrecorded ? PlaceUnrecorded(cam_from_enu, posed.ground_z_in_enu_m, posed.frame, posed.photos[i])
                      : CorrectToPose(posed.photos[i], recorded[i], cam_from_enu);
    if (is_common) linked.findings[i].notes.clear();
    problem.photos[i] =
        MakeBundlePhoto(posed.photos[i], linked.findings[i], problem.photos[i].lens, problem.photos[i].line);
    problem.photos[i].has_record = !is_unrecorded;
    problem.photos[i].is_by_images = true;
    // Points are looked for about as deep as the photo was high: by what it shows, whatever was recorded.
    problem.photos[i].height_above_ground_m =
        std::max(0.5, cam_from_enu.TargetOriginInSource().z() - posed.ground_z_in_enu_m);
    linked.features[i] = extracted.readable[i];
    linked.views[i].cam_from_enu = cam_from_enu;
    linked.views[i].height_above_ground_m = problem.photos[i].height_above_ground_m;
  }
  return static_cast<int>(found.size());
}

}  // namespace skyquilt::alignment
