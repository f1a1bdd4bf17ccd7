#include "core/render/blocks/photo_regions.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include "core/camera/rolling_shutter.h"
#include "core/geo/web_mercator.h"

namespace skyquilt::render {
namespace {

using image::PixelBox;

// What a cell's centre is not told of: its own half, the cell and a half that it blends into.
constexpr double kCellsAround = 2.5;
// Where the map ends, pixels beyond the last cell are shown by whoever still sees them.
constexpr double kCellsAroundAtEnd = 6.0;

PixelBox Around(const Eigen::Vector2d& pixel_in_image) {
  constexpr double kBeyondPhotoPx = 1e6;  // beyond any photo, well within whole numbers
  const auto whole = [&](double at) {
    return static_cast<int>(std::floor(std::clamp(at, -kBeyondPhotoPx, kBeyondPhotoPx)));
  };
  const int x = whole(pixel_in_image.x()), y = whole(pixel_in_image.y());
  return {x, y, x + 2, y + 2};
}

}  // namespace

std::vector<PixelBox> ShownRegions(const alignment::AlignedFlight& flight,
                                   const ground::GroundSurface& ground, const SeamMap& seams) {
  std::vector<PixelBox> regions(flight.photos.size());
  const auto include = [&](std::int32_t photo_index, int column, int row) {
    const auto is_nothing = [&](int dx, int dy) {
      return seams.labels.At(column + dx, row + dy) == kNoPhoto;
    };
    const bool is_end = is_nothing(-1, 0) || is_nothing(1, 0) || is_nothing(0, -1) || is_nothing(0, 1);
    const alignment::AlignedPhoto& photo = flight.photos[static_cast<std::size_t>(photo_index)];
    const geo::Vertical vertical =
        flight.frame.VerticalAt(geo::LatLonFromMerc(seams.grid.CellInMerc(column, row)));
    Eigen::Vector3d point = vertical.AtHeight(ground.MeanHeight());
    if (!ground.IsPlane()) point = vertical.AtHeight(ground.HeightAt(point.head<2>()));
    const auto pixel =
        camera::ProjectRolling(photo.intrinsics, photo.cam_from_enu, photo.readout_motion, point);
    if (!pixel) return;
    const double cell_px =
        seams.cell_m * photo.intrinsics.MeanFocalPx() / std::max(1.0, photo.height_above_ground_m);
    PixelBox& region = regions[static_cast<std::size_t>(photo_index)];
    region = region.With(
        Around(*pixel).Grown(static_cast<int>((is_end ? kCellsAroundAtEnd : kCellsAround) * cell_px) + 1));
  };
  // A photo's cells side by side are seen side by side: the outer ones are enough.
  for (int row = 0; row < seams.labels.rows(); ++row) {
    std::int32_t last = kNoPhoto;
    for (int column = 0; column <= seams.labels.columns(); ++column) {
      const std::int32_t label = seams.labels.At(column, row);  // none beyond the last
      if (label == last) continue;
      if (last != kNoPhoto) include(last, column - 1, row);
      if (label != kNoPhoto) include(label, column, row);
      last = label;
    }
  }
  return regions;
}

PixelBox ShownBy(const PhotoShare& share, int square_px, const PhotoView& view,
                 const BlockGeometry& geometry) {
  Eigen::Vector2f low = Eigen::Vector2f::Constant(INFINITY), high = -low;
  const int cells = std::max(1, square_px / geometry.node_step_px);  // of nodes, along a square
  for (const SquareShare& square : share.squares) {
    const Eigen::Vector2f* nodes =
        view.pixel_in_image.data() +
        static_cast<std::ptrdiff_t>(square.y / geometry.node_step_px) * geometry.nodes_per_side +
        square.x / geometry.node_step_px;
    for (int row = 0; row <= cells; ++row, nodes += geometry.nodes_per_side) {
      for (int column = 0; column <= cells; ++column) {
        if (std::isnan(nodes[column].x())) continue;
        low = low.cwiseMin(nodes[column]);
        high = high.cwiseMax(nodes[column]);
      }
    }
  }
  if (!(low.x() <= high.x())) return {};
  return Around(low.cast<double>()).With(Around(high.cast<double>()));
}

}  // namespace skyquilt::render
