// Registers the photos of a folder by what they show alone and prints what came of it:
// registration_bench DIR [threads [positions|nothing]]. "nothing": recorded positions are not looked at.
#include <map>
#include <string_view>

#include "core/alignment/align_flight.h"
#include "core/alignment/estimators/similarity.h"
#include "core/alignment/from_images/block.h"
#include "core/alignment/from_images/register_photos.h"
#include "core/base/median.h"
#include "core/base/parallel_for.h"
#include "core/flight/photos/photo_decoder.h"
#include "core/geo/local_frame.h"
#include "tests/bench/alignment/cpu_seconds.h"
#include "tests/bench/alignment/read_folder.h"

int main(int argc, char** argv) {
  using namespace skyquilt;
  if (argc < 2) {
    fmt::print(stderr, "usage: {} DIR [threads [positions|nothing]]\n", argv[0]);
    return 2;
  }
  SilentProgress progress;
  const flight::Flight read = ReadFolder(argv[1], progress);
  const int threads = argc > 2 ? std::atoi(argv[2]) : 0;
  const bool with_positions = argc <= 3 || std::string_view(argv[3]) != "nothing";
  const std::vector<flight::Photo>& photos = read.photos;
  std::vector<alignment::PhotoFeatures> features(photos.size());
  std::vector<char> is_read(photos.size(), 0);
  const flight::FilePhotoSource source;
  double cpu = CpuSeconds();
  ParallelFor(photos.size(), threads, [&](std::size_t i) {
    Result<alignment::PhotoFeatures> found = alignment::ExtractFeatures(photos[i], source);
    if (!found) return;
    features[i] = *std::move(found);
    is_read[i] = 1;
  });
  fmt::print("features: cpu {:.2f} s\n", CpuSeconds() - cpu);
  cpu = CpuSeconds();
  alignment::Registration input;
  std::map<std::string, int> lens_of_key;
  std::optional<geo::LocalFrame> frame;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    const auto [lens, is_new] =
        lens_of_key.emplace(photos[i].camera_key, static_cast<int>(input.lenses.size()));
    if (is_new) {
      alignment::BundleLens added;
      added.recorded = added.intrinsics = photos[i].intrinsics;
      added.sigma_focal_share = photos[i].focal_source == flight::FocalSource::kAssumed ? 0.1 : 0.02;
      added.sigma_k = 0.05;
      added.sigma_p = 0.0006;
      added.sigma_center_px = 0.004 * photos[i].intrinsics.width_px;
      input.lenses.push_back(added);
    }
    std::optional<Eigen::Vector3d> position_in_enu;
    if (photos[i].position) {
      const flight::RecordedPosition& at = *photos[i].position;
      const geo::Wgs84 here{at.position.lat_deg, at.position.lon_deg,
                            at.height_ellipsoid_m.value_or(at.height_amsl_m.value_or(0.0))};
      if (!frame) frame.emplace(here);
      position_in_enu = frame->EnuFromWgs84(here);
    }
    input.Add(is_read[i] ? &features[i] : nullptr, lens->second, position_in_enu);
  }
  alignment::Registration blind = input;
  if (!with_positions) blind.position_in_enu.assign(photos.size(), {});
  const alignment::Registration found = alignment::RegisterPhotos(blind, threads, progress);
  fmt::print("registration: cpu {:.2f} s\n", CpuSeconds() - cpu);
  fmt::print("pairs: {} compared, {} verified, {} refused; {} tracks\n", found.pairs_compared,
             found.pairs_verified, found.pairs_refused, found.tracks.size());
  const std::vector<int> links = alignment::CountPairs(photos.size(), found.links);
  for (std::size_t b = 0; b < found.block_sizes.size(); ++b) {
    std::vector<alignment::PlacePair> pairs;
    for (std::size_t i = 0; i < photos.size(); ++i) {
      if (found.block_of[i] != static_cast<int>(b) || !input.position_in_enu[i]) continue;
      pairs.push_back({found.cam_from_world[i].TargetOriginInSource(), *input.position_in_enu[i],
                       Eigen::Vector3d(2.0, 2.0, 5.0)});
    }
    fmt::print("block {}: {} photos", b, found.block_sizes[b]);
    if (const auto fitted = alignment::FitRobustly(pairs, {})) {
      fmt::print("; {} of {} positions hold, {:.2f} m off in the median, {:.1f} m up", fitted->held,
                 pairs.size(), fitted->median_residual,
                 fitted->target_from_source.scale * alignment::kMedianDepth);
    }
    fmt::print("\n");
  }
  for (std::size_t i = 0; i < photos.size(); ++i) {
    if (found.block_of[i] == 0) continue;
    fmt::print("  not in block 0: {} (block {}, {} links, {} features)\n", photos[i].name, found.block_of[i],
               links[i], features[i].keypoints.size());
  }
  for (const alignment::BundleLens& lens : found.lenses) {
    fmt::print("lens: focal {:.1f} -> {:.1f} px, k1 {:.4f} k2 {:.4f}\n", lens.recorded.focal_x_px,
               lens.intrinsics.focal_x_px, lens.intrinsics.k1, lens.intrinsics.k2);
  }
  fmt::print("{} of {} registered in block 0, residual {:.2f} px\n", found.LargestSize(), photos.size(),
             found.residual_rms_px);
  return 0;
}
