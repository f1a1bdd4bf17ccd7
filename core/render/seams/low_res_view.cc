#include "core/render/seams/low_res_view.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/camera/footprint.h"
#include "core/camera/rolling_shutter.h"
#include "core/geo/web_mercator.h"

namespace skyquilt::render {
namespace {

// Seams keep off the outer part of a photo: lens fall-off and the worst of the distortion are there.
constexpr float kBorderShare = 0.06f;
// How far a photo gives way at its very border, in heights above ground.
constexpr float kBorderPenaltyHeights = 4.0f;
constexpr float kPoseOnlyPenaltyHeights = 0.3f;
constexpr double kCoarse = 3.0;  // times the ground that the map's pixels show
constexpr float kCoarsePenaltyHeights = 20.0f;
// The Earth's bend within so many cells is far below a cell: between them east and north are bilinear.
constexpr int kExactEvery = 8;

}  // namespace

ViewScore ViewScore::Of(const alignment::AlignedPhoto& photo) {
  ViewScore score;
  score.width_px = static_cast<float>(photo.intrinsics.width_px);
  score.height_px = static_cast<float>(photo.intrinsics.height_px);
  score.taper_px = std::max(1.0f, kBorderShare * std::min(score.width_px, score.height_px));
  score.border_penalty_m =
      kBorderPenaltyHeights * static_cast<float>(std::max(1.0, photo.height_above_ground_m));
  // Of two photos that see a point equally well, the one whose place is known better.
  score.constant_m = static_cast<float>(std::min(photo.error_radius_m, photo.height_above_ground_m));
  // Every seam between an aligned photo and one that is not shows a step: let there be few.
  if (photo.placement == alignment::Placement::kPoseOnly) {
    score.constant_m += kPoseOnlyPenaltyHeights * static_cast<float>(photo.height_above_ground_m);
  }
  score.coarse_penalty_m =
      kCoarsePenaltyHeights * static_cast<float>(std::max(1.0, photo.height_above_ground_m));
  return score;
}

float ViewScore::CoarsePenalty(const Eigen::Vector3d& offset_m, double focal_px, double map_gsd_m) const {
  // Along its ray a pixel is drawn out by the look angle.
  const double gsd_m = offset_m.squaredNorm() / (focal_px * std::max(1e-3, -offset_m.z()));
  const double times = gsd_m / (kCoarse * map_gsd_m);
  return times > 1.0 ? coarse_penalty_m * static_cast<float>(times) : 0.0f;
}

namespace {

// East and north of the cells' centres, row by row.
std::vector<Eigen::Vector2d> GroundOfCells(const LowResView& view, const SeamGrid& grid,
                                           const geo::LocalFrame& frame, double z_m) {
  const int nodes_x = view.columns / kExactEvery + 2, nodes_y = view.rows / kExactEvery + 2;
  std::vector<Eigen::Vector2d> nodes;
  nodes.reserve(static_cast<std::size_t>(nodes_x) * nodes_y);
  for (int y = 0; y < nodes_y; ++y) {
    for (int x = 0; x < nodes_x; ++x) {
      const Eigen::Vector2d merc = grid.CellInMerc(view.column + x * kExactEvery, view.row + y * kExactEvery);
      nodes.push_back(frame.EnuAtHeight(geo::LatLonFromMerc(merc), z_m).head<2>());
    }
  }
  std::vector<Eigen::Vector2d> cells;
  cells.reserve(static_cast<std::size_t>(view.columns) * view.rows);
  for (int y = 0; y < view.rows; ++y) {
    for (int x = 0; x < view.columns; ++x) {
      const Eigen::Vector2d* node =
          nodes.data() + static_cast<std::ptrdiff_t>(y / kExactEvery) * nodes_x + x / kExactEvery;
      const double u = static_cast<double>(x % kExactEvery) / kExactEvery;
      const double v = static_cast<double>(y % kExactEvery) / kExactEvery;
      cells.push_back((1 - v) * ((1 - u) * node[0] + u * node[1]) +
                      v * ((1 - u) * node[nodes_x] + u * node[nodes_x + 1]));
    }
  }
  return cells;
}

// How much of a cell a camera sees past what stands on the ground.
Seen PastWhatStands(const ground::GroundSurface& ground, const Eigen::Vector2d& middle, double cell_m,
                    const Eigen::Vector3d& camera_in_enu) {
  constexpr int kPointsPerSide = 5;
  int hidden = 0;
  for (int row = 0; row < kPointsPerSide; ++row) {
    for (int column = 0; column < kPointsPerSide; ++column) {
      const Eigen::Vector2d at = middle + cell_m * Eigen::Vector2d((column + 0.5) / kPointsPerSide - 0.5,
                                                                   (row + 0.5) / kPointsPerSide - 0.5);
      hidden += ground::IsOccluded(ground, {at.x(), at.y(), ground.HeightAt(at)}, camera_in_enu) ? 1 : 0;
    }
  }
  if (hidden == 0) return Seen::kFully;
  return hidden < kPointsPerSide * kPointsPerSide ? Seen::kPartly : Seen::kNot;
}

// Averages over about a cell, so that a sample stands for its whole cell.
cv::Mat3b SmoothedThumbnail(const Thumbnail& thumbnail, double cell_in_thumbnail_px) {
  const image::DecodedImage decoded = Decode(thumbnail);
  const cv::Mat3b sharp(decoded.height_px, decoded.width_px,
                        reinterpret_cast<cv::Vec3b*>(const_cast<std::uint8_t*>(decoded.rgb.data())));
  // Beyond the picture's size nothing changes any more, but the kernel would grow without bounds.
  const double max_sigma_px = 0.5 * std::max({1, sharp.cols, sharp.rows});
  cv::Mat3b smooth;
  cv::GaussianBlur(sharp, smooth, {0, 0}, std::clamp(0.4 * cell_in_thumbnail_px, 0.5, max_sigma_px), 0.0,
                   cv::BORDER_REPLICATE);
  return smooth;
}

}  // namespace

LowResView MakeLowResView(const alignment::AlignedPhoto& photo, const geo::Bounds2& seen_in_merc,
                          const geo::LocalFrame& frame, const ground::GroundSurface& ground,
                          const PhotoTone& tone, const Thumbnail& thumbnail, const SeamGrid& grid,
                          double map_gsd_m) {
  LowResView view;
  if (seen_in_merc.IsEmpty()) return view;
  const double cell_in_merc_m = grid.CellInMercM();
  const Eigen::Vector2d corner = grid.CellInMerc(0, 0);
  view.column = static_cast<int>(std::floor((seen_in_merc.min.x() - corner.x()) / cell_in_merc_m)) - 1;
  view.row = static_cast<int>(std::floor((corner.y() - seen_in_merc.max.y()) / cell_in_merc_m)) - 1;
  view.columns = static_cast<int>(seen_in_merc.Width() / cell_in_merc_m) + 4;
  view.rows = static_cast<int>(seen_in_merc.Height() / cell_in_merc_m) + 4;
  const auto cells = static_cast<std::size_t>(view.columns) * view.rows;
  view.seen.assign(cells, Seen::kNot);
  view.rgb.assign(cells, {});
  view.score_m.assign(cells, 0.0f);

  const camera::Intrinsics& lens = photo.intrinsics;
  const double cell_m = cell_in_merc_m * geo::GroundMetresPerMercMetre(frame.origin().lat_deg);
  const double cell_in_photo_px = cell_m * lens.MeanFocalPx() / std::max(1.0, photo.height_above_ground_m);
  const float half_cell_px = static_cast<float>(0.75 * cell_in_photo_px) + 1.0f;
  const double shrink = static_cast<double>(thumbnail.width_px) / lens.width_px;
  const cv::Mat3b picture = SmoothedThumbnail(thumbnail, cell_in_photo_px * shrink);
  const ViewScore score = ViewScore::Of(photo);
  const Eigen::Matrix3d rotation = photo.cam_from_enu.rotation.toRotationMatrix();
  const Eigen::Vector3d center = photo.cam_from_enu.TargetOriginInSource();
  view.camera_east_m = static_cast<float>(center.x());
  view.camera_north_m = static_cast<float>(center.y());
  const double max_radius_squared = lens.HasDistortion() ? lens.MaxRadiusSquared() : 1e300;
  const double widest_tangent = std::tan(photo.max_look_rad);
  const bool turns = !photo.readout_motion.turns_rad.empty();  // a shift alone is less than a cell
  const ShadeGrid shades(tone.shade, lens);
  // A long thin photo's thumbnail may be one pixel wide.
  const double last_u = std::max(0.0, picture.cols - 1.001), last_v = std::max(0.0, picture.rows - 1.001);
  const std::vector<Eigen::Vector2d> ground_of_cells = GroundOfCells(view, grid, frame, ground.MeanHeight());
  for (std::size_t i = 0; i < cells; ++i) {
    const Eigen::Vector2d& east_north = ground_of_cells[i];
    const double z_m = ground.IsPlane() ? ground.MeanHeight() : ground.HeightAt(east_north);
    const Eigen::Vector3d offset = Eigen::Vector3d(east_north.x(), east_north.y(), z_m) - center;
    const double sideways_m = offset.head<2>().norm();
    const Eigen::Vector3d in_cam = rotation * offset;
    if (in_cam.z() <= 1e-6 || offset.z() >= 0.0 || sideways_m > -offset.z() * widest_tangent) continue;
    const Eigen::Vector2d normalised = in_cam.head<2>() / in_cam.z();
    if (normalised.squaredNorm() > max_radius_squared) continue;
    const Eigen::Vector2d bent = lens.Distort(normalised);
    double x = lens.focal_x_px * bent.x() + lens.center_x_px;
    double y = lens.focal_y_px * bent.y() + lens.center_y_px;
    if (turns) {
      const auto pixel =
          camera::ProjectRolling(lens, photo.cam_from_enu, photo.readout_motion, center + offset);
      if (!pixel) continue;
      x = pixel->x();
      y = pixel->y();
    }
    const float margin_px = score.Margin(static_cast<float>(x), static_cast<float>(y));
    if (margin_px <= -half_cell_px) continue;
    view.seen[i] = margin_px >= half_cell_px ? Seen::kFully : Seen::kPartly;
    if (ground.HasSteps())
      view.seen[i] = std::min(view.seen[i], PastWhatStands(ground, east_north, cell_m, center));
    view.score_m[i] = score.Score(static_cast<float>(sideways_m), std::max(0.0f, margin_px)) +
                      score.CoarsePenalty(offset, lens.MeanFocalPx(), map_gsd_m);
    const double u = std::clamp((x + 0.5) * shrink - 0.5, 0.0, last_u);
    const double v = std::clamp((y + 0.5) * shrink - 0.5, 0.0, last_v);
    const int u0 = static_cast<int>(u), v0 = static_cast<int>(v);
    const int u1 = std::min(u0 + 1, picture.cols - 1), v1 = std::min(v0 + 1, picture.rows - 1);
    const double fu = u - u0, fv = v - v0;
    const auto shade = shades.At(static_cast<float>(x), static_cast<float>(y));
    for (int c = 0; c < 3; ++c) {
      const auto channel = static_cast<std::size_t>(c);
      const double value = (1 - fv) * ((1 - fu) * picture(v0, u0)[c] + fu * picture(v0, u1)[c]) +
                           fv * ((1 - fu) * picture(v1, u0)[c] + fu * picture(v1, u1)[c]);
      view.rgb[i][channel] = static_cast<std::uint8_t>(std::clamp(
          std::lround(value * tone.gain[channel] * static_cast<double>(shade[channel])), 0L, 255L));
    }
  }
  return view;
}

}  // namespace skyquilt::render
