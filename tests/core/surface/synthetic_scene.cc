#include "tests/core/surface/synthetic_scene.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace skyquilt::surface {
namespace {

std::uint32_t Mixed(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  std::uint32_t h = a * 0x9e3779b1U ^ b * 0x85ebca77U ^ c * 0xc2b2ae3dU;
  h ^= h >> 15;
  h *= 0x2c1b3c6dU;
  h ^= h >> 12;
  h *= 0x297a2d39U;
  return h ^ (h >> 15);
}

// Smooth noise from 0 to 1 with about one hill a unit.
double Noise(double x, double y, std::uint32_t salt) {
  const double left = std::floor(x), low = std::floor(y);
  const double u = x - left, v = y - low;
  const auto at = [&](int dx, int dy) {
    const auto column = static_cast<std::uint32_t>(static_cast<std::int64_t>(left) + dx),
               row = static_cast<std::uint32_t>(static_cast<std::int64_t>(low) + dy);
    return Mixed(column, row, salt) / 4294967296.0;
  };
  return (1 - v) * ((1 - u) * at(0, 0) + u * at(1, 0)) + v * ((1 - u) * at(0, 1) + u * at(1, 1));
}

double Texture(double x, double y, std::uint32_t salt, double finest_m) {
  double value = 0.0;
  for (int octave = 0; octave < 6; ++octave) {
    const double size_m = finest_m * (1 << octave);
    value += (Noise(x / size_m, y / size_m, salt + static_cast<std::uint32_t>(octave)) - 0.5) *
             (20.0 + 6.0 * octave);
  }
  return value;
}

}  // namespace

void SyntheticScene::Photograph(int east, int north, double spacing_m, double height_m, int width_px,
                                int height_px, double focal_px) {
  for (int row = 0; row < north; ++row) {
    for (int column = 0; column < east; ++column) {
      const Eigen::Vector3d center((column - 0.5 * (east - 1)) * spacing_m,
                                   (row - 0.5 * (north - 1)) * spacing_m, height_m);
      const int number = row * east + column;
      const Eigen::Quaterniond down(
          Eigen::AngleAxisd(M_PI + 0.01 * (number % 3 - 1), Eigen::Vector3d::UnitX()));
      const Eigen::Quaterniond turned(Eigen::AngleAxisd(0.05 * number, Eigen::Vector3d::UnitZ()));
      alignment::AlignedPhoto photo;
      photo.photo.name = std::to_string(number);
      photo.photo.intrinsics = photo.intrinsics = camera::Intrinsics::Centered(width_px, height_px, focal_px);
      photo.cam_from_enu = geo::Rigid3::FromRotationAndTargetOrigin(turned * down, center);
      photo.placement = alignment::Placement::kAligned;
      photo.height_above_ground_m = height_m;
      flight.photos.push_back(photo);
    }
  }
}

double SyntheticScene::HeightAt(const Eigen::Vector2d& east_north) const {
  double z_m = slope.dot(east_north);
  for (const StandingBox& box : boxes) {
    if (box.outline.Contains(east_north)) z_m = std::max(z_m, box.top_z_m);
  }
  return z_m;
}

std::uint8_t SyntheticScene::Shown(const Eigen::Vector3d& center, const Eigen::Vector3d& ray,
                                   std::uint32_t salt) const {
  // The ground: center.z + t ray.z = slope . (center + t ray).
  double nearest = (slope.dot(center.head<2>()) - center.z()) / (ray.z() - slope.dot(ray.head<2>()));
  std::uint32_t surface = 1;
  int face = 2;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const Eigen::Vector3d low(boxes[i].outline.min.x(), boxes[i].outline.min.y(), -100.0),
        high(boxes[i].outline.max.x(), boxes[i].outline.max.y(), boxes[i].top_z_m);
    double enter = 0.0, leave = 1e9;
    int through = 2;
    for (int axis = 0; axis < 3; ++axis) {
      const double speed = std::abs(ray[axis]) < 1e-9 ? 1e-9 : ray[axis];
      const double a = (low[axis] - center[axis]) / speed, b = (high[axis] - center[axis]) / speed;
      if (std::min(a, b) > enter) {
        enter = std::min(a, b);
        through = axis;
      }
      leave = std::min(leave, std::max(a, b));
    }
    if (enter >= leave || enter >= nearest) continue;
    nearest = enter;
    surface = 100 * static_cast<std::uint32_t>(i + 1);
    face = through;
  }
  const Eigen::Vector3d met = center + nearest * ray;
  const double finest_m = center.z() / flight.photos[0].intrinsics.focal_x_px;
  const double x = face == 0 ? met.y() : met.x(), y = face == 2 ? met.y() : met.z();
  double value = surface == 1 ? 110.0 : face == 2 ? 165.0 : 60.0;
  if (surface == 1 && even.Contains(met.head<2>())) {
    value += 3.0 * (Noise(2000.0 * met.x(), 2000.0 * met.y(), salt) - 0.5);
  } else {
    value += Texture(x, y, surface + static_cast<std::uint32_t>(10 * face), 1.5 * finest_m);
  }
  return static_cast<std::uint8_t>(std::clamp(value, 0.0, 255.0));
}

Result<image::DecodedImage> SyntheticScene::Decode(const flight::Photo& photo, int denominator) const {
  const auto found = std::find_if(flight.photos.begin(), flight.photos.end(),
                                  [&](const auto& one) { return one.photo.name == photo.name; });
  if (found == flight.photos.end() || photo.name == "damaged")
    return Error{ErrorCode::kCorrupt, "damaged", ""};
  const Eigen::Vector3d center = found->cam_from_enu.TargetOriginInSource();
  const Eigen::Matrix3d enu_from_cam = found->cam_from_enu.rotation.conjugate().toRotationMatrix();
  const auto salt = static_cast<std::uint32_t>(found - flight.photos.begin()) + 7;
  image::DecodedImage image;
  image.width_px = (found->intrinsics.width_px + denominator - 1) / denominator;
  image.height_px = (found->intrinsics.height_px + denominator - 1) / denominator;
  image.rgb.resize(static_cast<std::size_t>(image.width_px) * image.height_px * 3);
  for (int y = 0; y < image.height_px; ++y) {
    for (int x = 0; x < image.width_px; ++x) {
      int sum = 0;
      for (int part = 0; part < denominator * denominator; ++part) {
        const Eigen::Vector2d pixel(x * denominator + part % denominator,
                                    y * denominator + part / denominator);
        sum += Shown(center, enu_from_cam * found->intrinsics.Unproject(pixel), salt);
      }
      const auto gray = static_cast<std::uint8_t>(sum / (denominator * denominator));
      std::fill_n(image.rgb.data() + 3 * (static_cast<std::size_t>(y) * image.width_px + x), 3, gray);
    }
  }
  return image;
}

}  // namespace skyquilt::surface
