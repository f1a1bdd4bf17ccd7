#include "core/alignment/from_images/register_photos.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <set>

#include "core/alignment/estimators/sampler.h"
#include "core/alignment/estimators/similarity.h"
#include "core/alignment/from_images/grow_block.h"
#include "core/alignment/from_images/grow_groups.h"
#include "core/alignment/from_images/join_groups.h"
#include "core/base/trace.h"

namespace skyquilt::alignment {
namespace {

constexpr double kOtherFocal = 0.05;
constexpr int kFewForALens = 5;
constexpr int kLastObservationsPerPhoto = 120;
constexpr int kMaxPasses = 2;
constexpr double kMinSigmaFocal = 0.02;  // what is recorded may be that of another image size
constexpr int kMinSeen = 12;             // points of a photo that counts as registered
constexpr int kMinShared = 12;
constexpr int kJoinSamples = 300;
constexpr double kToleranceShare = 0.02;  // of the depth
constexpr double kMinShareHeld = 0.3;

// larger_from_smaller, by the points that both see; nothing where too few agree on one similarity.
std::optional<Similarity3> FindJoint(const Block::Packed& larger, const Block::Packed& smaller) {
  std::vector<PlacePair> shared;
  auto in_larger = larger.points.begin();
  for (const Block::Packed::Known& known : smaller.points) {
    while (in_larger != larger.points.end() && in_larger->track < known.track) ++in_larger;
    if (in_larger == larger.points.end()) break;
    if (in_larger->track == known.track)
      shared.push_back({known.point, in_larger->point, Eigen::Vector3d::Ones()});
  }
  const int count = static_cast<int>(shared.size());
  if (count < kMinShared) return std::nullopt;
  const double tolerance = kToleranceShare * kMedianDepth;
  Sampler sampler(static_cast<std::uint64_t>(count));
  std::vector<PlacePair> most;
  for (int s = 0; s < kJoinSamples; ++s) {
    std::vector<PlacePair> three;
    for (const int k : sampler.Distinct<3>(count)) three.push_back(shared[k]);
    std::optional<Similarity3> proposed = FitSimilarity3(three);
    for (int round = 0; proposed && round < 3; ++round) {
      std::vector<PlacePair> held;
      for (const PlacePair& pair : shared) {
        if ((*proposed * pair.in_source - pair.in_target).norm() < tolerance) held.push_back(pair);
      }
      if (held.size() <= most.size()) break;
      proposed = FitSimilarity3(held);
      most = std::move(held);
    }
  }
  if (static_cast<int>(most.size()) < kMinShared ||
      static_cast<double>(most.size()) < kMinShareHeld * count) {
    return std::nullopt;
  }
  return FitSimilarity3(most);
}

// Takes the smaller one's photos over.
void JoinBlocks(const Similarity3& larger_from_smaller, const Block::Packed& smaller, int threads,
                Block& larger) {
  std::vector<int> taken;
  for (const Block::Packed::Placed& placed : smaller.photos) {
    if (larger.Has(placed.photo)) continue;
    larger.Place(placed.photo, larger_from_smaller.Moved(placed.cam_from_world));
    taken.push_back(placed.photo);
  }
  larger.TriangulateSeenBy(taken, threads);
}

void AdjustLast(int threads, Block& block) {
  block.Adjust({},
               {.cuts_px = {10.0, 0.0}, .max_iterations = 15, .adjust_lens = block.size() >= kFewForALens},
               kLastObservationsPerPhoto, threads);
}

// Each smaller block into the first larger one that it shares points with.
void JoinAll(const Registration& input, int threads, const Progress& progress,
             std::vector<Block::Packed>& blocks) {
  const auto take = [&](const Block::Packed& smaller, Block::Packed& larger) {
    if (progress.IsCancelled()) return false;
    const std::optional<Similarity3> joint = FindJoint(larger, smaller);
    if (!joint) return false;
    TraceDecision("groups joined", {{"photos", larger.size()}, {"more", smaller.size()}});
    Block joined(input, larger);
    JoinBlocks(*joint, smaller, threads, joined);
    AdjustLast(threads, joined);
    larger = joined.Pack();
    return true;
  };
  JoinGroups(take, blocks);
}

void MergeBlocks(const Registration& input, const std::vector<Block::Packed>& blocks,
                 Registration& registration) {
  registration.cam_from_world.resize(registration.Photos());
  registration.block_of.assign(registration.Photos(), -1);
  if (!blocks.empty()) registration.lenses = blocks.front().lenses;
  std::vector<int> told_by(registration.lenses.size(), 0);  // by lens, of how many photos the block is
  double square = 0.0;
  int observations = 0;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const Block block(input, blocks[b]);
    const std::vector<int> seen = block.PointsSeen();
    const std::vector<double> residuals = block.ResidualsPx();
    int size = 0;
    std::vector<int> photos_of(registration.lenses.size(), 0);
    for (std::size_t i = 0; i < registration.Photos(); ++i) {
      if (!block.Has(i) || seen[i] < kMinSeen) continue;
      ++photos_of[registration.lens_of[i]];
      registration.cam_from_world[i] = block.Pose(i);
      registration.block_of[i] = static_cast<int>(b);
      square += residuals[i] * residuals[i] * seen[i];
      observations += seen[i];
      ++size;
    }
    registration.block_sizes.push_back(size);
    // Each lens by the largest block with enough photos of it: one with none has it as it began.
    for (std::size_t c = 0; c < photos_of.size(); ++c) {
      if (photos_of[c] < kFewForALens || size <= told_by[c]) continue;
      told_by[c] = size;
      registration.lenses[c] = block.lenses()[c];
    }
    for (Track& track : block.Tracks()) registration.tracks.push_back(std::move(track));
  }
  registration.NumberBySize();  // of photos left out in the end one has more than another
  registration.residual_rms_px = observations > 0 ? std::sqrt(square / observations) : 0.0;
  for (const PhotoPair& pair : input.links) {
    const int block = registration.block_of[pair.first];
    if (block < 0 || block != registration.block_of[pair.second]) continue;
    registration.links.push_back(pair);
  }
}

// The scene of the links, and what each photo shows of it.
void JoinLinks(Registration& input) {
  input.scene = {};  // not both at a time
  input.tracks_of.assign(input.Photos(), {});
  input.scene = JoinMatches(input.features, input.links);
  for (std::size_t t = 0; t < input.scene.size(); ++t) {
    for (const TrackElement& element : input.scene[t])
      input.tracks_of[element.photo].push_back(static_cast<int>(t));
  }
}

std::vector<Block::Packed> GrowBlocks(const Registration& input, int threads, Progress& progress) {
  std::vector<BundleLens> lenses = input.lenses;
  std::set<std::size_t> failed;
  bool is_first = true;
  const auto begin = [&](const PhotoSet& used, const PhotoSet& spent) -> std::optional<Block::Packed> {
    const std::optional<Block> begun = BeginBlock(input, lenses, used, spent, threads, failed, progress);
    return begun ? std::optional(begun->Pack()) : std::nullopt;
  };
  const auto grow = [&](const PhotoSet& used, Block::Packed& packed) {
    Block block(input, packed);
    GrowBlock(used, threads, progress, block);
    AdjustLast(threads, block);
    packed = block.Pack();
    TraceDecision(block.size() > 0 ? "group grown" : "group fell apart", {{"photos", block.size()}});
    // The largest knows the lenses best: the others start from there.
    if (is_first && block.size() > 0) {
      lenses = block.lenses();
      failed.clear();
      is_first = false;
    }
  };
  std::vector<Block::Packed> blocks = GrowGroups(input.Photos(), begin, grow);
  JoinAll(input, threads, progress, blocks);
  return blocks;
}

// Lenses as they were found, where they are no more what they were taken for.
bool TakeLenses(const std::vector<Block::Packed>& blocks, const std::vector<BundleLens>& found,
                std::vector<BundleLens>& lenses) {
  if (blocks.empty() || blocks.front().size() < kFewForALens) return false;
  bool is_other = false;
  for (std::size_t c = 0; c < lenses.size(); ++c) {
    const camera::Intrinsics& lens = found[c].intrinsics;
    const double off = std::abs(std::log(lens.focal_x_px / lenses[c].intrinsics.focal_x_px));
    is_other = is_other || off > kOtherFocal;
    lenses[c].intrinsics = lens;
  }
  return is_other;
}

}  // namespace

Registration RegisterPhotos(const Registration& given, int threads, Progress& progress) {
  Registration registration;
  Registration input = given;
  for (BundleLens& lens : input.lenses)
    lens.sigma_focal_share = std::max(lens.sigma_focal_share, kMinSigmaFocal);
  BuildViewGraph(threads, progress, input);
  for (int pass = 0;; ++pass) {
    JoinLinks(input);
    const std::vector<Block::Packed> blocks = GrowBlocks(input, threads, progress);
    Registration grown = given;
    MergeBlocks(input, blocks, grown);
    const std::vector<BundleLens> found = grown.lenses;
    // Through the right lens more pairs agree, and with each other: one by which fewer do was not right.
    if (pass == 0 || grown.LargestSize() >= registration.LargestSize()) registration = std::move(grown);
    if (pass >= kMaxPasses || progress.IsCancelled() || !TakeLenses(blocks, found, input.lenses)) break;
    VerifyAgain(threads, input);
  }
  registration.pairs_compared = input.pairs_compared;
  registration.pairs_verified = input.pairs_verified;
  registration.pairs_refused = input.pairs_refused;
  for (std::size_t c = 0; c < given.lenses.size(); ++c) {
    registration.lenses[c].sigma_focal_share = given.lenses[c].sigma_focal_share;
  }
  return registration;
}

}  // namespace skyquilt::alignment
