#include "core/render/blocks/block_geometry.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/base/bilinear_grid.h"
#include "core/base/check.h"
#include "core/base/vector_clones.h"
#include "core/camera/footprint.h"
#include "core/camera/rolling_shutter.h"
#include "core/geo/web_mercator.h"

namespace skyquilt::render {

namespace {

// On nodes every kNodeStepPx, where they are exact.
std::vector<geo::Vertical> ExactVerticals(const geo::TileId& block_tile, int size_px,
                                          const geo::LocalFrame& frame) {
  const int nodes_per_side = size_px / kNodeStepPx + 1;
  std::vector<geo::Vertical> verticals;
  verticals.reserve(static_cast<std::size_t>(nodes_per_side) * nodes_per_side);
  const double pixel_m = geo::PixelSizeInMercM(block_tile.z(), size_px);
  for (int row = 0; row < nodes_per_side; ++row) {
    for (int column = 0; column < nodes_per_side; ++column) {
      // World-wide pixel numbers are exact in double, so every block gives a node the same place.
      const double world_x = static_cast<double>(block_tile.x()) * size_px + column * kNodeStepPx;
      const double world_y = static_cast<double>(block_tile.y()) * size_px + row * kNodeStepPx;
      verticals.push_back(
          frame.VerticalAt(geo::LatLonFromMerc({(world_x + 0.5) * pixel_m - geo::kMercHalfWidthM,
                                                geo::kMercHalfWidthM - (world_y + 0.5) * pixel_m})));
    }
  }
  return verticals;
}

geo::Vertical Between(const geo::Vertical& a, const geo::Vertical& b, double share) {
  return {a.on_ellipsoid + share * (b.on_ellipsoid - a.on_ellipsoid), a.up + share * (b.up - a.up)};
}

}  // namespace

BlockGeometry MakeBlockGeometry(const geo::TileId& block_tile, int size_px, const geo::LocalFrame& frame,
                                const ground::GroundSurface& ground) {
  SKYQUILT_CHECK(size_px % kNodeStepPx == 0, "a block must hold whole node cells");
  BlockGeometry block;
  block.size_px = size_px;
  block.node_step_px = ground.HasSteps() ? kNodeStepOverStepsPx : kNodeStepPx;
  block.nodes_per_side = size_px / block.node_step_px + 1;
  block.ground_in_enu.reserve(static_cast<std::size_t>(block.nodes_per_side) * block.nodes_per_side);
  const std::vector<geo::Vertical> exact = ExactVerticals(block_tile, size_px, frame);
  const int exact_per_side = size_px / kNodeStepPx + 1, nodes_between = kNodeStepPx / block.node_step_px;
  std::vector<geo::Vertical> along;  // the row's verticals, where columns are exact
  for (int row = 0; row < block.nodes_per_side; ++row) {
    const int north = row / nodes_between, south = std::min(north + 1, exact_per_side - 1);
    const double v = (row % nodes_between) * (1.0 / nodes_between);
    along.clear();
    for (int x = 0; x < exact_per_side; ++x) {
      const auto at = [&](int y) { return exact[static_cast<std::size_t>(y) * exact_per_side + x]; };
      along.push_back(Between(at(north), at(south), v));
    }
    for (int column = 0; column < block.nodes_per_side; ++column) {
      const auto west = static_cast<std::size_t>(column / nodes_between),
                 east = std::min(west + 1, along.size() - 1);
      const geo::Vertical vertical =
          Between(along[west], along[east], (column % nodes_between) * (1.0 / nodes_between));
      Eigen::Vector3d point = vertical.AtHeight(ground.MeanHeight());
      if (!ground.IsPlane()) point = vertical.AtHeight(ground.HeightAt(point.head<2>()));
      block.ground_in_enu.push_back(point);
    }
  }
  return block;
}

namespace {

// How a camera that moves while it reads its rows stood for each node of a fine grid: about which row sees a
// node is looked for on nodes kNodeStepPx apart, and where that row sees it says which it is.
class RowPoses {
 public:
  struct Pose {
    Eigen::Matrix3d cam_from_enu;
    Eigen::Vector3d shift;
  };

  RowPoses(const alignment::AlignedPhoto& photo, const BlockGeometry& block)
      : nodes_per_side_(block.nodes_per_side),
        every_(kNodeStepPx / block.node_step_px),
        coarse_per_side_(block.size_px / kNodeStepPx + 1) {
    for (int row = 0; row < photo.intrinsics.height_px; ++row) {
      const geo::Rigid3 pose =
          camera::PoseAtRow(photo.cam_from_enu, photo.readout_motion, row, photo.intrinsics.height_px);
      poses_.push_back({pose.rotation.toRotationMatrix(), pose.translation});
    }
    for (int row = 0; row < nodes_per_side_; row += every_) {
      for (int column = 0; column < nodes_per_side_; column += every_) {
        const auto pixel = camera::ProjectRolling(
            photo.intrinsics, photo.cam_from_enu, photo.readout_motion,
            block.ground_in_enu[static_cast<std::size_t>(row) * nodes_per_side_ + column]);
        rows_px_.push_back(pixel ? static_cast<float>(pixel->y()) : std::numeric_limits<float>::quiet_NaN());
      }
    }
  }
  // Nothing where no row sees it.
  const Pose* At(std::size_t node) const {
    const int row = static_cast<int>(node) / nodes_per_side_,
              column = static_cast<int>(node) % nodes_per_side_;
    const double row_px = BilinearAt(rows_px_, coarse_per_side_, coarse_per_side_,
                                     static_cast<double>(column) / every_, static_cast<double>(row) / every_);
    return std::isnan(row_px) ? nullptr : &OfRow(row_px);
  }
  const Pose& OfRow(double row_px) const {
    const double last = static_cast<double>(poses_.size()) - 1.0;
    return poses_[static_cast<std::size_t>(std::clamp(row_px + 0.5, 0.0, last))];
  }

 private:
  const int nodes_per_side_, every_, coarse_per_side_;
  std::vector<Pose> poses_;     // by row of the picture
  std::vector<float> rows_px_;  // by coarse node
};

// Where a camera that stands still while it reads its rows sees places, not a number where it cannot, and how
// far from below it they lie.
SKYQUILT_VECTOR_CLONES void ProjectPlaces(const camera::Intrinsics& lens,
                                          const Eigen::Matrix3d& cam_from_enu_rotation,
                                          const Eigen::Vector3d& center_in_enu, double max_radius_squared,
                                          double widest_tangent, const Eigen::Vector3d* places, int count,
                                          Eigen::Vector2f* __restrict pixels,
                                          float* __restrict nadir_distances_m) {
  // Of one's own they need not be read again after each pixel written.
  const camera::Intrinsics own = lens;
  const Eigen::Matrix3d r = cam_from_enu_rotation;  // NOLINT(performance-unnecessary-copy-initialization)
  const Eigen::Vector3d center = center_in_enu;     // NOLINT(performance-unnecessary-copy-initialization)
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < count; ++i) {
    const double east = places[i].x() - center.x(), north = places[i].y() - center.y(),
                 up = places[i].z() - center.z();
    const double sideways_m = std::sqrt(east * east + north * north);
    const double depth = r(2, 0) * east + r(2, 1) * north + r(2, 2) * up;
    const double x = (r(0, 0) * east + r(0, 1) * north + r(0, 2) * up) / depth,
                 y = (r(1, 0) * east + r(1, 1) * north + r(1, 2) * up) / depth;
    const bool is_seen = (depth > 1e-6) & (up < 0.0) & (sideways_m <= -up * widest_tangent) &
                         (x * x + y * y <= max_radius_squared);
    const Eigen::Vector2d bent = own.Distort({x, y});
    const double column = own.focal_x_px * bent.x() + own.center_x_px,
                 row = own.focal_y_px * bent.y() + own.center_y_px;
    pixels[i].x() = static_cast<float>(is_seen ? column : kNan);
    pixels[i].y() = static_cast<float>(is_seen ? row : kNan);
    nadir_distances_m[i] = static_cast<float>(sideways_m);
  }
}

}  // namespace

PhotoView ViewBlock(const alignment::AlignedPhoto& photo, const BlockGeometry& block) {
  PhotoView view;
  ViewNodes(photo, block, std::vector<std::uint8_t>(block.ground_in_enu.size(), 1), view);
  return view;
}

void ViewNodes(const alignment::AlignedPhoto& photo, const BlockGeometry& block,
               const std::vector<std::uint8_t>& wanted, PhotoView& view) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  view.pixel_in_image.resize(block.ground_in_enu.size(), {kNan, kNan});
  view.nadir_distance_m.resize(block.ground_in_enu.size(), 0.0f);
  const camera::Intrinsics& lens = photo.intrinsics;
  const Eigen::Matrix3d rotation = photo.cam_from_enu.rotation.toRotationMatrix();
  const Eigen::Vector3d center = photo.cam_from_enu.TargetOriginInSource();
  const double max_radius_squared = lens.HasDistortion() ? lens.MaxRadiusSquared() : 1e300;
  const double widest_tangent = std::tan(photo.max_look_rad);
  const bool moves = !photo.readout_motion.IsStill(), turns = !photo.readout_motion.turns_rad.empty();
  std::optional<RowPoses> rows;
  if (moves && block.node_step_px < kNodeStepPx) rows.emplace(photo, block);
  const auto pixel_of = [&](const Eigen::Vector3d& in_cam) -> std::optional<Eigen::Vector2d> {
    if (in_cam.z() <= 1e-6) return std::nullopt;
    const Eigen::Vector2d normalised = in_cam.head<2>() / in_cam.z();
    if (normalised.squaredNorm() > max_radius_squared) return std::nullopt;
    const Eigen::Vector2d bent = lens.Distort(normalised);
    return Eigen::Vector2d(lens.focal_x_px * bent.x() + lens.center_x_px,
                           lens.focal_y_px * bent.y() + lens.center_y_px);
  };
  const auto pixel_while_moving = [&](std::size_t node) -> std::optional<Eigen::Vector2d> {
    const Eigen::Vector3d& place = block.ground_in_enu[node];
    if (rows) {
      const RowPoses::Pose* about = rows->At(node);
      if (about == nullptr) return std::nullopt;
      const auto first = pixel_of(about->cam_from_enu * place + about->shift);
      if (!first) return std::nullopt;
      const RowPoses::Pose& pose = rows->OfRow(first->y());
      return pixel_of(pose.cam_from_enu * place + pose.shift);
    }
    const Eigen::Vector3d in_cam = rotation * (place - center);
    // Where it turns, another row may see what the middle one cannot.
    if (turns ? in_cam.z() <= 1e-6 : !pixel_of(in_cam)) return std::nullopt;
    return camera::ProjectRolling(lens, photo.cam_from_enu, photo.readout_motion, place);
  };
  const std::size_t nodes = block.ground_in_enu.size();
  for (std::size_t i = 0; i < nodes; ++i) {
    if (wanted[i] == 0) continue;
    if (!moves) {
      const auto first = wanted.begin() + static_cast<std::ptrdiff_t>(i);
      const std::ptrdiff_t count = std::find(first, wanted.end(), 0) - first;
      ProjectPlaces(lens, rotation, center, max_radius_squared, widest_tangent,
                    block.ground_in_enu.data() + i, static_cast<int>(count), view.pixel_in_image.data() + i,
                    view.nadir_distance_m.data() + i);
      i += static_cast<std::size_t>(count);
      continue;
    }
    const Eigen::Vector3d offset = block.ground_in_enu[i] - center;
    const double sideways_m = offset.head<2>().norm();
    view.nadir_distance_m[i] = static_cast<float>(sideways_m);
    if (offset.z() >= 0.0 || sideways_m > -offset.z() * widest_tangent) continue;
    if (const auto pixel = pixel_while_moving(i)) view.pixel_in_image[i] = pixel->cast<float>();
  }
  // A cell touches the image if the box around its four corners does.
  const int n = block.nodes_per_side;
  for (int row = 0; row + 1 < n && !view.sees_block; ++row) {
    for (int column = 0; column + 1 < n; ++column) {
      const std::size_t k = static_cast<std::size_t>(row) * n + column;
      if (wanted[k] == 0) continue;
      Eigen::Vector2f low = view.pixel_in_image[k];
      Eigen::Vector2f high = low;
      for (const std::size_t other : {k + 1, k + n, k + n + 1}) {
        low = low.cwiseMin(view.pixel_in_image[other]);
        high = high.cwiseMax(view.pixel_in_image[other]);
      }
      if (low.x() <= lens.width_px && low.y() <= lens.height_px && high.x() >= -1.0f && high.y() >= -1.0f) {
        view.sees_block = true;
        break;
      }
    }
  }
}

BlockBoundary::BlockBoundary(const MosaicPlan& plan, const geo::TileId& block_tile)
    : side_(static_cast<std::size_t>(plan.BlockSizePx())) {
  if (plan.boundary_on_blocks == nullptr) return;
  if (plan.boundary_on_blocks->Mask(block_tile, inside_) == geo::Cover::kAll) inside_.clear();
}

void BlockBoundary::Cut(image::RgbaImage& image) const {
  for (std::size_t i = 0; i < inside_.size(); ++i) {
    if (inside_[i] == 0) std::fill_n(image.rgba.data() + 4 * i, 4, std::uint8_t{0});
  }
}

}  // namespace skyquilt::render
