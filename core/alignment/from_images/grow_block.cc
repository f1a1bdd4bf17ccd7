#include "core/alignment/from_images/grow_block.h"

#include <algorithm>
#include <iterator>

#include "core/base/median.h"
#include "core/base/parallel_for.h"
#include "core/base/trace.h"

namespace skyquilt::alignment {
namespace {

constexpr std::ptrdiff_t kInitialPairsAtOnce = 6;
constexpr int kPhotosAfterInitialPair = 4;  // photos
constexpr int kEnoughPoints = 15;
constexpr int kMinAgreeing = 12;            // observations that agree on a new photo's pose
constexpr double kMinAgreeingShare = 0.25;  // of the points it shares with the block
constexpr double kMinAngleRad = 0.03, kWideAngleRad = 0.15;
constexpr double kNearlyTheMost = 0.5;  // photos that see so many points as the one that sees most come along
constexpr int kSmallBlock = 12;         // adjusted whole every time
constexpr double kGrown = 1.4;          // adjusted whole when grown by that
constexpr int kLensFromPhotos = 5;
constexpr int kObservationsPerPhoto = 80;
constexpr std::size_t kMaxNeighbours = 10;
constexpr int kMinKept = 10;  // points of a photo that stays
constexpr int kMinKeptOverGround = 20;
constexpr int kMaxTimesTaken = 10;  // of one photo, that goes again whenever the block is adjusted

struct InitialPair {
  std::size_t pair = 0, pose = 0;
};

// All that a block may begin with, the best first.
std::vector<InitialPair> InitialPairs(const Registration& input, const PhotoSet& used,
                                      const PhotoSet& spent) {
  std::vector<std::pair<double, std::size_t>> ranked;
  for (std::size_t p = 0; p < input.links.size(); ++p) {
    const PhotoPair& pair = input.links[p];
    if (used.Has(pair.first) || used.Has(pair.second)) continue;
    if (spent.Has(pair.first) || spent.Has(pair.second)) continue;
    if (pair.angle_rad < kMinAngleRad) continue;
    const double score =
        static_cast<double>(pair.matches.size()) * std::min(1.0, pair.angle_rad / kWideAngleRad);
    ranked.emplace_back(-score, p);
  }
  std::sort(ranked.begin(), ranked.end());
  // Not all from one place: a photo begins two at most.
  std::vector<int> begun(used.Photos(), 0);
  std::vector<InitialPair> chosen;
  for (const auto& [score, p] : ranked) {
    const PhotoPair& pair = input.links[p];
    int& first = begun[pair.first];
    int& second = begun[pair.second];
    if (first >= 2 || second >= 2) continue;
    ++first;
    ++second;
    for (std::size_t k = 0; k < pair.poses.size(); ++k) chosen.push_back({p, k});
  }
  return chosen;
}

// Whether a third photo sees enough of what both show.
bool MayGrow(const Registration& input, const PhotoSet& used, const PhotoPair& pair) {
  std::vector<int> seen(used.Photos(), 0);
  for (const int t : input.tracks_of[pair.first]) {
    const KeypointTrack& track = input.scene[t];
    if (std::none_of(track.begin(), track.end(),
                     [&](const TrackElement& element) { return element.photo == pair.second; }))
      continue;
    for (const TrackElement& element : track) {
      const bool is_third =
          element.photo != pair.first && element.photo != pair.second && !used.Has(element.photo);
      if (is_third && ++seen[element.photo] >= kMinAgreeing) return true;
    }
  }
  return false;
}

struct NextPhoto {
  int photo = 0;
  std::vector<int> tracks;  // with points
};

// Enough of the block's points.
std::vector<NextPhoto> PhotosThatSee(const Block& block, const PhotoSet& used) {
  std::vector<NextPhoto> candidates;
  for (std::size_t i = 0; i < used.Photos(); ++i) {
    if (used.Has(i) || block.Has(i)) continue;
    NextPhoto one{static_cast<int>(i), {}};
    for (const int t : block.input().tracks_of[i]) {
      if (block.HasPoint(t)) one.tracks.push_back(t);
    }
    if (one.tracks.size() >= kMinAgreeing) candidates.push_back(std::move(one));
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const NextPhoto& a, const NextPhoto& b) { return a.tracks.size() > b.tracks.size(); });
  return candidates;
}

std::optional<FoundPose> Resect(const Block& block, const NextPhoto& candidate) {
  std::vector<PointObservation> observations;
  for (const int t : candidate.tracks) {
    for (const TrackElement& element : block.scene()[t]) {
      if (element.photo != candidate.photo) continue;
      const Observation seen = block.ObservationOf(element);
      observations.push_back({seen.pixel_in_image, block.Point(t), seen.sigma_px});
    }
  }
  const int min_inliers =
      std::max(kMinAgreeing, static_cast<int>(kMinAgreeingShare * static_cast<double>(observations.size())));
  return FindPose(block.Lens(candidate.photo), observations, static_cast<std::uint64_t>(candidate.photo),
                  {.min_inliers = min_inliers});
}

// Photos that see most of what these see.
std::vector<int> WithNeighbours(const Block& block, const std::vector<int>& photos) {
  std::vector<int> shared(block.input().Photos(), 0);
  for (const int photo : photos) {
    for (const int t : block.input().tracks_of[photo]) {
      for (const int s : block.SeenBy(t)) {
        ++shared[block.scene()[t][s].photo];
      }
    }
  }
  std::vector<int> free = photos;
  for (const int photo : photos) shared[photo] = 0;
  std::vector<std::pair<int, int>> ranked;
  for (std::size_t i = 0; i < shared.size(); ++i) {
    if (shared[i] > 0) ranked.emplace_back(-shared[i], static_cast<int>(i));
  }
  for (const int photo : LeastFew(std::move(ranked), kMaxNeighbours + photos.size())) free.push_back(photo);
  return free;
}

// As a whole, whatever holds its photos.
void AdjustAll(int threads, Block& block) {
  block.Adjust({},
               {.cuts_px = {20.0, 8.0}, .max_iterations = 10, .adjust_lens = block.size() >= kLensFromPhotos},
               kObservationsPerPhoto, threads);
}

// Likewise, and out with photos that hardly any point still holds.
void AdjustWhole(int threads, Block& block) {
  AdjustAll(threads, block);
  const std::vector<int> seen = block.PointsSeen();
  const int before = block.size();
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (seen[i] < kMinKept) block.Remove(i);
  }
  if (block.size() < before) block.TriangulateAll(threads);
}

// What rounds leave behind for the next one.
struct Rounds {
  std::vector<int> failed_at;    // by photo: of how many points it could not be registered
  std::vector<int> times_taken;  // by photo
  bool is_traced = false;        // of a trial nobody is told
};

// One round: what found its place.
std::vector<int> TakeRound(const PhotoSet& used, std::size_t most, int threads, Rounds& rounds,
                           Block& block) {
  std::vector<NextPhoto> candidates = PhotosThatSee(block, used);
  // Once refused, a photo is asked again when it sees a good deal more. One that comes and goes would do so
  // for ever.
  std::erase_if(candidates, [&](const NextPhoto& one) {
    const int before = rounds.failed_at[one.photo];
    return rounds.times_taken[one.photo] >= kMaxTimesTaken ||
           (before > 0 && static_cast<double>(one.tracks.size()) < 1.2 * before);
  });
  if (candidates.empty()) return {};
  const double enough = kNearlyTheMost * static_cast<double>(candidates.front().tracks.size());
  std::size_t count = 0;
  while (count < candidates.size() && count < most &&
         static_cast<double>(candidates[count].tracks.size()) >= enough)
    ++count;
  candidates.resize(count);
  std::vector<std::optional<FoundPose>> found(count);
  ParallelFor(count, threads, [&](std::size_t k) { found[k] = Resect(block, candidates[k]); });
  std::vector<int> taken;
  for (std::size_t k = 0; k < count; ++k) {
    if (rounds.is_traced)
      TraceDecision(found[k] ? "photo registered" : "photo not registered",
                    {{"photo", candidates[k].photo},
                     {"points", candidates[k].tracks.size()},
                     {"inliers", found[k] ? found[k]->inliers.size() : 0}});
    if (found[k]) {
      block.Place(candidates[k].photo, found[k]->cam_from_world);
      taken.push_back(candidates[k].photo);
      ++rounds.times_taken[candidates[k].photo];
    } else {
      rounds.failed_at[candidates[k].photo] = static_cast<int>(candidates[k].tracks.size());
    }
  }
  if (taken.empty()) return TakeRound(used, most, threads, rounds, block);
  block.TriangulateSeenBy(taken, threads);
  return taken;
}

// One photo that shows what placed ones show, but hardly any of their points (ResectOverGround), if it then
// shares points enough. Each that is tried is left out from then on.
bool TakeOverGround(int threads, const Progress& progress, PhotoSet& left_out, Block& block) {
  for (const FoundPose& one : ResectOverGround(block, left_out, threads)) {
    if (progress.IsCancelled()) break;
    left_out.Add(one.photo);
    Block grown = block;
    grown.Place(one.photo, one.cam_from_world);
    grown.TriangulateSeenBy({one.photo}, threads);
    AdjustWhole(threads, grown);
    if (grown.Has(one.photo) && grown.PointsSeen()[one.photo] >= kMinKeptOverGround &&
        grown.size() > block.size()) {
      TraceDecision("photo registered over ground", {{"photo", one.photo}, {"inliers", one.inliers.size()}});
      block = std::move(grown);
      return true;
    }
  }
  return false;
}

struct Tried {
  Block block;
  int observations = 0;
};

std::optional<Tried> Try(const Registration& input, const std::vector<BundleLens>& lenses,
                         const PhotoSet& used, const InitialPair& initial_pair, int threads) {
  const PhotoPair& pair = input.links[initial_pair.pair];
  if (!MayGrow(input, used, pair)) return std::nullopt;
  Block block(input, lenses);
  block.Place(pair.first, geo::Rigid3{});
  block.Place(pair.second, pair.poses[initial_pair.pose]);
  block.TriangulateSeenBy({pair.first, pair.second}, threads);
  if (block.PointsSeen()[pair.first] < kEnoughPoints) return std::nullopt;
  block.Normalise();
  AdjustAll(threads, block);
  Rounds rounds{std::vector<int>(input.Photos(), 0), std::vector<int>(input.Photos(), 0)};
  for (int round = 0; round < kPhotosAfterInitialPair && block.size() < 2 + kPhotosAfterInitialPair;
       ++round) {
    const std::vector<int> taken = TakeRound(used, 2, threads, rounds, block);
    if (taken.empty()) break;
    AdjustWhole(threads, block);
  }
  if (block.size() < 3) return std::nullopt;
  Tried tried{std::move(block), 0};
  // Points of three and more photos: two agree on anything.
  for (std::size_t t = 0; t < input.scene.size(); ++t) {
    const auto seen = static_cast<int>(tried.block.SeenBy(t).size());
    if (seen >= 3) tried.observations += seen;
  }
  return tried;
}

}  // namespace

std::optional<Block> BeginBlock(const Registration& input, const std::vector<BundleLens>& lenses,
                                const PhotoSet& used, const PhotoSet& spent, int threads,
                                std::set<std::size_t>& failed, const Progress& progress) {
  const std::vector<InitialPair> ranked = InitialPairs(input, used, spent);
  // The best few against each other; the next where none of them begins a block. Beyond the first few each
  // fails once for all blocks: by more used photos it would hardly do better.
  for (auto next = ranked.begin(); next != ranked.end() && !progress.IsCancelled();) {
    const auto first = next;
    while (next != ranked.end() &&
           (next - first < kInitialPairsAtOnce || next->pair == std::prev(next)->pair))
      ++next;
    const std::vector<InitialPair> initial_pairs(first, next);
    std::vector<std::optional<Tried>> tried(initial_pairs.size());
    ParallelFor(initial_pairs.size(), threads, [&](std::size_t b) {
      if (first != ranked.begin() && failed.contains(initial_pairs[b].pair)) return;
      tried[b] = Try(input, lenses, used, initial_pairs[b], 1);
    });
    std::optional<Tried>* best = nullptr;
    for (std::size_t b = 0; b < tried.size(); ++b) {
      std::optional<Tried>& one = tried[b];
      const PhotoPair& pair = input.links[initial_pairs[b].pair];
      TraceDecision("initial pair", {{"photo", pair.first},
                                     {"with", pair.second},
                                     {"photos", one ? one->block.size() : 0},
                                     {"observations", one ? one->observations : 0}});
      if (!one) continue;
      if (best == nullptr || one->observations > (*best)->observations) best = &one;
    }
    if (best != nullptr) return std::move((*best)->block);
    for (const InitialPair& one : initial_pairs) failed.insert(one.pair);
  }
  return std::nullopt;
}

void GrowBlock(const PhotoSet& used, int threads, Progress& progress, Block& block) {
  PhotoSet left_out = used;  // where photos are taken in over the ground
  Rounds rounds{std::vector<int>(used.Photos(), 0), std::vector<int>(used.Photos(), 0), true};
  int whole_at = block.size();
  bool asked_again = false;
  while (!progress.IsCancelled()) {
    const std::size_t most = std::max<std::size_t>(2, block.size() / 2);
    const std::vector<int> taken = TakeRound(used, most, threads, rounds, block);
    if (taken.empty()) {
      // Once more with everything in its best place, where somebody still waits for it.
      if (asked_again || PhotosThatSee(block, used).empty()) {
        if (!TakeOverGround(threads, progress, left_out, block)) break;
        rounds.failed_at.assign(used.Photos(), 0);
        asked_again = false;
        continue;
      }
      asked_again = true;
      AdjustWhole(threads, block);
      rounds.failed_at.assign(used.Photos(), 0);
      whole_at = block.size();
      continue;
    }
    asked_again = false;
    if (block.size() <= kSmallBlock || block.size() >= kGrown * whole_at) {
      AdjustWhole(threads, block);
      whole_at = block.size();
    } else {
      block.Adjust(WithNeighbours(block, taken), {.cuts_px = {15.0}, .max_iterations = 6},
                   kObservationsPerPhoto, threads);
    }
  }
}

}  // namespace skyquilt::alignment
