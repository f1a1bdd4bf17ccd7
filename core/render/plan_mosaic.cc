#include "core/render/plan_mosaic.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <utility>

#include "core/camera/footprint.h"
#include "core/flight/remarks/because.h"
#include "core/geo/tile_id.h"
#include "core/geo/web_mercator.h"
#include "core/image/picture_codec.h"

namespace skyquilt::render {
namespace {

using alignment::AlignedFlight;
using alignment::AlignedPhoto;

// GDAL (and with it QGIS) refuses MBTiles with a zoom above 22.
constexpr int kFinestZoom = 22;
constexpr int kPointsPerSide = 8;  // of a footprint
constexpr int kBlockSizePx = 1024;
constexpr std::int64_t kMaxBlocksAPhoto = 20'000;
constexpr std::int64_t kMaxOutputPixels = std::int64_t{1} << 40;
// Finer pixels than this share of the photos' show nothing more.
constexpr double kFinestShareOfPhoto = 1.0 / 16.0;
// The ground is looked at no deeper below a photo than this, in its heights above it: what the deepest point
// of a grid says of a valley elsewhere must not decide how far a photo sees.
constexpr double kDeepestHeights = 20.0;
// Measured with tests/bench/memory.py: the block itself, sums and weights along its seams, its overviews.
constexpr std::int64_t kBytesPerBlockPixel = 28;

// Across the date line the map goes on beyond the edge of the merc square, so that a flight stays in one
// part.
Eigen::Vector2d UnwrappedMerc(const geo::LatLon& position, const AlignedFlight& flight) {
  Eigen::Vector2d point = geo::MercFromLatLon(position);
  const double origin_x = geo::MercFromLatLon({0.0, flight.frame.origin().lon_deg}).x();
  point.x() = origin_x + std::remainder(point.x() - origin_x, 2.0 * geo::kMercHalfWidthM);
  return point;
}

std::vector<Eigen::Vector2d> FootprintInMerc(const AlignedPhoto& photo, const AlignedFlight& flight,
                                             double plane_z_m) {
  std::vector<Eigen::Vector2d> polygon = camera::GroundFootprint(
      photo.intrinsics, photo.cam_from_enu, plane_z_m, kPointsPerSide, photo.max_look_rad);
  for (Eigen::Vector2d& point : polygon) {
    const geo::Wgs84 wgs84 = flight.frame.Wgs84FromEnu({point.x(), point.y(), plane_z_m});
    point = UnwrappedMerc({wgs84.lat_deg, wgs84.lon_deg}, flight);
  }
  return polygon;
}

// What the photo can see for any height the ground takes.
geo::Bounds2 BoundsSeen(const AlignedPhoto& photo, const AlignedFlight& flight,
                        const ground::GroundSurface& ground) {
  geo::Bounds2 bounds;
  const double deepest_m = photo.cam_from_enu.TargetOriginInSource().z() -
                           kDeepestHeights * std::max(1.0, photo.height_above_ground_m);
  for (const double z_m : {std::max(ground.MinHeight(), deepest_m), ground.MaxHeight()}) {
    bounds.Include(camera::BoundsOf(FootprintInMerc(photo, flight, z_m)));
  }
  return bounds;
}

// Ground size of a pixel at the image centre: height along the axis over the focal length. Where the axis
// runs towards the horizon, at the furthest that is shown.
std::optional<double> GsdM(const AlignedPhoto& photo, double plane_z_m) {
  const Eigen::Vector3d axis = photo.cam_from_enu.rotation.conjugate() * Eigen::Vector3d::UnitZ();
  if (-axis.z() < std::cos(photo.max_look_rad)) {
    const double drop_m = photo.cam_from_enu.TargetOriginInSource().z() - plane_z_m;
    if (drop_m <= 0.0) return std::nullopt;
    return drop_m / std::cos(photo.max_look_rad) / photo.intrinsics.MeanFocalPx();
  }
  const Eigen::Vector2d middle{0.5 * (photo.intrinsics.width_px - 1), 0.5 * (photo.intrinsics.height_px - 1)};
  const auto ground = camera::GroundFromPixel(photo.intrinsics, photo.cam_from_enu, middle, plane_z_m);
  if (!ground) return std::nullopt;
  return (*ground - photo.cam_from_enu.TargetOriginInSource()).norm() / photo.intrinsics.MeanFocalPx();
}

struct PhotoGsd {
  double gsd_m = 0.0;
  std::int64_t pixels = 0;
};

// The median over the photos' pixels: of pictures of one size it is that of the pictures, and small ones, as
// many as there may be, do not make a map as coarse as they are of ground that large ones show.
double MedianGsdM(std::vector<PhotoGsd> photos) {
  std::sort(photos.begin(), photos.end(),
            [](const PhotoGsd& a, const PhotoGsd& b) { return a.gsd_m < b.gsd_m; });
  std::int64_t all = 0, up_to = 0;
  for (const PhotoGsd& photo : photos) all += photo.pixels;
  for (const PhotoGsd& photo : photos) {
    up_to += photo.pixels;
    if (2 * up_to > all) return photo.gsd_m;  // of two middles the upper, as Median takes it
  }
  return photos.back().gsd_m;
}

int CommonAncestorZoom(const std::vector<RenderBlock>& blocks) {
  int zoom = blocks.front().tile.z();
  std::uint32_t x = blocks.front().tile.x();
  std::uint32_t y = blocks.front().tile.y();
  for (const RenderBlock& block : blocks) {
    const int below = block.tile.z() - zoom;
    std::uint32_t other_x = block.tile.x() >> below;
    std::uint32_t other_y = block.tile.y() >> below;
    while (other_x != x || other_y != y) {
      other_x >>= 1, other_y >>= 1, x >>= 1, y >>= 1;
      --zoom;
    }
  }
  return zoom;
}

}  // namespace

Error BoundaryElsewhere(const geo::Boundary& boundary, const geo::LatLon& place) {
  const geo::LatLon middle = boundary.Bounds().Middle();
  return flight::Because(ErrorCode::kUnprocessable, {flight::RemarkCode::kFailBoundaryElsewhere,
                                                     {{"lat_deg", place.lat_deg},
                                                      {"lon_deg", place.lon_deg},
                                                      {"boundary_lat_deg", middle.lat_deg},
                                                      {"boundary_lon_deg", middle.lon_deg}}});
}

std::int64_t BlockBytes(int block_px) { return kBytesPerBlockPixel * block_px * block_px; }

std::int64_t OverviewBytes(const MosaicPlan& plan) {
  // Of one tile a level what the map covers, and the one that is being closed.
  double tiles = 1.0;
  for (int zoom = plan.min_zoom; zoom < plan.base_zoom - plan.block_levels; ++zoom) {
    const double size_m = geo::TileSizeInMercM(zoom);
    tiles += std::min(1.0, plan.bounds_in_merc.Width() / size_m) *
             std::min(1.0, plan.bounds_in_merc.Height() / size_m);
  }
  return static_cast<std::int64_t>(4.0 * tiles * plan.tile_size_px * plan.tile_size_px);
}

Result<MosaicPlan> PlanMosaic(const AlignedFlight& flight, const ground::GroundSurface& ground,
                              const PlanOptions& options) {
  MosaicPlan plan;
  std::vector<PhotoGsd> gsds;
  std::vector<geo::Bounds2>& seen = plan.seen_in_merc;
  seen.resize(flight.photos.size());
  for (std::size_t i = 0; i < flight.photos.size(); ++i) {
    seen[i] = BoundsSeen(flight.photos[i], flight, ground);
    if (seen[i].IsEmpty()) continue;
    plan.bounds_in_merc.Include(seen[i]);
    const camera::Intrinsics& lens = flight.photos[i].intrinsics;
    if (const auto gsd_m = GsdM(flight.photos[i], ground.MeanHeight()))
      gsds.push_back({*gsd_m, std::int64_t{lens.width_px} * lens.height_px});
  }
  if (gsds.empty()) {
    return flight::Because(ErrorCode::kUnprocessable, flight::RemarkCode::kFailAllLookUp);
  }
  plan.gsd_m = MedianGsdM(std::move(gsds));
  double output_gsd_m = options.gsd_m.value_or(plan.gsd_m);
  if (options.not_finer_than_photos) output_gsd_m = std::max(output_gsd_m, plan.gsd_m);
  if (output_gsd_m < kFinestShareOfPhoto * plan.gsd_m) {
    return flight::Because(ErrorCode::kInvalidArgument, {flight::RemarkCode::kFailFinerThanPhotos,
                                                         {{"asked_m", output_gsd_m},
                                                          {"photos_m", plan.gsd_m},
                                                          {"finest_m", kFinestShareOfPhoto * plan.gsd_m}}});
  }
  const double lat_deg = flight.frame.origin().lat_deg;
  plan.base_zoom = geo::ZoomForGsd(output_gsd_m, lat_deg, plan.tile_size_px);
  // Finer than the last zoom that GIS tools open, the tiles grow instead of the zoom: 512 pixels, 1024, ...
  while (plan.base_zoom > kFinestZoom) {
    --plan.base_zoom;
    if (2 * plan.tile_size_px <= image::kMaxPictureSidePx &&
        BlockBytes(2 * plan.tile_size_px) <= options.max_block_bytes)
      plan.tile_size_px *= 2;
  }
  plan.block_levels = 0;
  while (plan.block_levels < plan.base_zoom && plan.BlockSizePx() < kBlockSizePx) ++plan.block_levels;
  plan.max_seam_cells = options.max_seam_bytes / kSeamCellBytes;

  const int block_zoom = plan.base_zoom - plan.block_levels;
  // The ground bends and photos lean: a photo is asked about a little more than it may turn out to see.
  const double margin_m = 2.0 * geo::PixelSizeInMercM(plan.base_zoom, plan.tile_size_px);
  std::map<std::uint64_t, RenderBlock> by_hilbert;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (seen[i].IsEmpty()) continue;
    const double size_m = geo::TileSizeInMercM(block_zoom);
    const auto column_at = [&](double x_m) {
      return static_cast<std::int64_t>(std::floor((x_m + geo::kMercHalfWidthM) / size_m));
    };
    const auto row_at = [&](double y_m) { return geo::TileId::AtMerc(block_zoom, {0.0, y_m}).y(); };
    const std::int64_t first_column = column_at(seen[i].min.x() - margin_m);
    const std::int64_t last_column = column_at(seen[i].max.x() + margin_m);
    const std::uint32_t first_row = row_at(seen[i].max.y() + margin_m);
    const std::uint32_t last_row = row_at(seen[i].min.y() - margin_m);
    const std::int64_t across = last_column - first_column + 1;
    const std::int64_t down = std::int64_t{last_row} - first_row + 1;
    if (across * down > kMaxBlocksAPhoto) {
      return flight::Because(ErrorCode::kTooLarge,
                             {flight::RemarkCode::kFailPhotoTooWide,
                              {{"photo", flight.photos[i].photo.name}, {"across", across}, {"down", down}}});
    }
    const std::int64_t side = std::int64_t{1} << block_zoom;
    for (std::uint32_t y = first_row; y <= last_row; ++y) {
      for (std::int64_t column = first_column; column <= last_column; ++column) {
        const auto x = static_cast<std::uint32_t>(((column % side) + side) % side);
        RenderBlock& block = by_hilbert[geo::HilbertIndex(block_zoom, x, y)];
        if (block.photos.empty()) block.tile = *geo::TileId::Make(block_zoom, x, y);
        block.photos.push_back(static_cast<std::uint32_t>(i));
      }
    }
  }
  if (options.boundary != nullptr)
    plan.boundary_on_blocks =
        std::make_shared<geo::BoundaryOnZoom>(*options.boundary, block_zoom, plan.BlockSizePx());
  plan.blocks.reserve(by_hilbert.size());
  for (auto& [index, block] : by_hilbert) {
    const bool is_beyond = plan.boundary_on_blocks != nullptr &&
                           plan.boundary_on_blocks->CoverOf(block.tile) == geo::Cover::kNone;
    if (!is_beyond) plan.blocks.push_back(std::move(block));
  }
  if (plan.blocks.empty()) {
    const geo::Wgs84& origin = flight.frame.origin();
    return BoundaryElsewhere(*options.boundary, {origin.lat_deg, origin.lon_deg});
  }
  plan.min_zoom = CommonAncestorZoom(plan.blocks);
  plan.output_pixels =
      static_cast<std::int64_t>(plan.blocks.size()) * plan.BlockSizePx() * plan.BlockSizePx();
  if (plan.output_pixels > kMaxOutputPixels) {
    return flight::Because(ErrorCode::kTooLarge, flight::RemarkCode::kFailMapTooLarge);
  }
  return plan;
}

}  // namespace skyquilt::render
