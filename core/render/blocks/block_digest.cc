#include "core/render/blocks/block_digest.h"

#include <algorithm>
#include <cmath>

#include "core/render/blocks/block_weights.h"

namespace skyquilt::render {
namespace {

// Raised whenever the same input gives other pixels than before.
constexpr int kRendererVersion = 6;
// Ground nearer together than this is the same: a grid that grew tells it a rounding error differently.
constexpr double kGroundStepM = 1e-4;
constexpr std::int32_t kOtherPhoto = -2;  // one that shows nothing of the block itself

void AddPhoto(const alignment::AlignedPhoto& photo, const PhotoTone& tone, Hasher& hasher) {
  const camera::Intrinsics& lens = photo.intrinsics;
  hasher.Add(lens.width_px).Add(lens.height_px).Add(lens.focal_x_px).Add(lens.focal_y_px);
  hasher.Add(lens.center_x_px).Add(lens.center_y_px);
  hasher.Add(lens.k1).Add(lens.k2).Add(lens.k3).Add(lens.p1).Add(lens.p2);
  hasher.AddBytes(photo.cam_from_enu.rotation.coeffs().data(), 4 * sizeof(double));
  hasher.AddBytes(photo.cam_from_enu.translation.data(), 3 * sizeof(double));
  hasher.AddBytes(photo.readout_motion.shift_in_enu_m.data(), 3 * sizeof(double));
  for (const Eigen::Vector3d& turn : photo.readout_motion.turns_rad)
    hasher.AddBytes(turn.data(), 3 * sizeof(double));
  hasher.Add(static_cast<int>(photo.placement)).Add(photo.error_radius_m).Add(photo.height_above_ground_m);
  hasher.Add(photo.max_look_rad);
  // The same file in another range is another picture.
  if (photo.photo.sample_range) hasher.Add(photo.photo.sample_range->low).Add(photo.photo.sample_range->high);
  for (const double gain : tone.gain) hasher.Add(gain);
  hasher.AddBytes(tone.shade.terms.data(), sizeof(tone.shade.terms));
  for (const float at : tone.shade.spot_place) hasher.Add(at);
  for (const float change : tone.shade.look_by_place) hasher.Add(change);
  for (const auto& channel : tone.shade.spot_log_gains) {
    for (const float log_gain : channel) hasher.Add(log_gain);
  }
}

}  // namespace

Digest DigestSteps(const ground::GroundSurface& ground) {
  Hasher hasher;
  hasher.Add(ground.SouthWest().x()).Add(ground.SouthWest().y()).Add(ground.CellSize());
  hasher.Add(ground.Columns()).Add(ground.Rows()).Add(ground.MeanHeight());
  hasher.AddBytes(ground.Heights().data(), ground.Heights().size() * sizeof(float));
  return hasher.Finish();
}

Digest DigestBlock(const RenderContext& context, const pyramid::EncodeOptions& encode,
                   const std::vector<Digest>& photo_digests, const RenderBlock& block,
                   const BlockGeometry& geometry, const std::optional<Digest>& steps) {
  const MosaicPlan& plan = context.plan;
  const SeamGrid& grid = context.seams.grid;
  Hasher hasher;
  hasher.Add(kRendererVersion).Add(static_cast<std::uint8_t>(encode.encoding)).Add(encode.quality);
  hasher.Add(plan.block_levels).Add(plan.tile_size_px);
  hasher.Add(0.0);  // an option that was never chosen: blocks of earlier maps are kept
  hasher.Add(grid.cell_px).Add(context.seams.cell_m).Add(context.flight.frame.origin().lat_deg);
  if (steps) {  // all of the ground, in fewer bytes than the block's nodes have
    const geo::Wgs84& origin = context.flight.frame.origin();
    hasher.AddBytes(steps->data(), steps->size());
    hasher.Add(block.tile.z()).Add(block.tile.x()).Add(block.tile.y());
    hasher.Add(origin.lon_deg).Add(origin.height_ellipsoid_m);
  } else {
    for (const Eigen::Vector3d& node : geometry.ground_in_enu) {
      for (const double metres : {node.x(), node.y(), node.z()})
        hasher.Add(std::llround(metres / kGroundStepM));
    }
  }
  const BlockBoundary boundary(plan, block.tile);
  if (!boundary.CutsNothing()) hasher.AddBytes(boundary.inside().data(), boundary.inside().size());
  const BlockCells cells(context.seams, block.tile, plan.block_levels);
  const std::vector<std::uint32_t> photos = cells.PhotosOf(block);
  for (const std::uint32_t photo : photos) {
    hasher.AddBytes(photo_digests[photo].data(), photo_digests[photo].size());
    AddPhoto(context.flight.photos[photo], context.exposure.tones[photo], hasher);
  }
  // Cells and their neighbours, by place in the list above: numbers of photos change when photos are added.
  for (int row = -1; row <= cells.side; ++row) {
    for (int column = -1; column <= cells.side; ++column) {
      const int x = cells.corner.x() + column, y = cells.corner.y() + row;
      const std::int32_t label = context.seams.labels.At(x, y);
      std::int32_t place = label;
      if (label != kNoPhoto) {
        const auto at = std::lower_bound(photos.begin(), photos.end(), static_cast<std::uint32_t>(label));
        const bool is_known = at != photos.end() && *at == static_cast<std::uint32_t>(label);
        place = is_known ? static_cast<std::int32_t>(at - photos.begin()) : kOtherPhoto;
      }
      hasher.Add(place);
      for (const std::uint32_t photo : photos) {
        const PhotoLevels& levels = context.seams.levels[photo];
        hasher.Add(levels.SeesWhole(x, y));
        for (const float level : levels.At(x, y)) hasher.Add(level);
      }
    }
  }
  return hasher.Finish();
}

}  // namespace skyquilt::render
