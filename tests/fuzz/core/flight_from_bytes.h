// Flights out of a fuzzer's bytes: mostly ordinary numbers, now and then zero, huge, infinite or none, so
// that what has no neighbours, no extent or no scale is met often. Small, for speed.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "core/alignment/scene/aligned_flight.h"
#include "core/poses/plausible_poses.h"
#include "core/render/thumbnail.h"

namespace skyquilt::fuzz {

class Bytes {
 public:
  Bytes(const std::uint8_t* bytes, std::size_t size) : next_(bytes), end_(bytes + size) {}

  bool IsEmpty() const { return next_ == end_; }
  std::uint8_t Byte() { return IsEmpty() ? std::uint8_t{0} : *next_++; }
  int Below(int count) { return (Byte() | (Byte() << 8)) % count; }
  // Within +-scale, or one of those that spoil a sum.
  double Number(double scale) {
    const std::uint8_t kind = Byte();
    if (kind < 240) return scale * (((Byte() | (Byte() << 8)) - 32768) / 32768.0);
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    constexpr double kSpoilers[] = {0.0, -0.0, 1e-300, 1e9, -1e9, 1e300, kInfinity, -kInfinity};
    return kind < 248 ? kSpoilers[kind - 240] : std::numeric_limits<double>::quiet_NaN();
  }

 private:
  const std::uint8_t* next_;
  const std::uint8_t* end_;
};

inline geo::Rigid3 PoseFrom(Bytes& bytes) {
  const double yaw = bytes.Number(3.2), tilt = bytes.Number(1.6);
  const Eigen::Quaterniond down(0.0, 1.0, 0.0, 0.0);  // looks straight down
  const Eigen::Quaterniond turned = Eigen::Quaterniond(Eigen::AngleAxisd(tilt, Eigen::Vector3d::UnitX())) *
                                    Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()));
  const Eigen::Vector3d center(bytes.Number(60.0), bytes.Number(60.0), 50.0 + bytes.Number(60.0));
  return geo::Rigid3::FromRotationAndTargetOrigin((down * turned), center);
}

inline camera::Intrinsics LensFrom(Bytes& bytes) {
  constexpr std::pair<int, int> kSizes[] = {{64, 48}, {48, 64}, {16, 16}, {400, 16}, {16, 400}, {2000, 16}};
  const auto [width_px, height_px] = kSizes[bytes.Below(6)];
  camera::Intrinsics lens = camera::Intrinsics::Centered(width_px, height_px, 60.0);
  if (bytes.Below(4) == 0) lens.k1 = bytes.Number(0.5), lens.k2 = bytes.Number(0.5);
  if (bytes.Below(8) == 0) lens.focal_x_px = lens.focal_y_px = std::abs(bytes.Number(1e4));
  return lens;
}

inline alignment::AlignedFlight FlightFrom(Bytes& bytes) {
  alignment::AlignedFlight flight;
  const double lats[] = {46.8, 0.0, 84.9, -84.9}, lons[] = {7.1, 180.0, -180.0, 0.0};
  flight.frame = geo::LocalFrame({lats[bytes.Below(4)], lons[bytes.Below(4)], 500.0});
  const int photos = bytes.Below(9);
  for (int i = 0; i < photos; ++i) {
    alignment::AlignedPhoto photo;
    photo.photo.name = "P" + std::to_string(i);
    photo.photo.camera_key = bytes.Below(3) == 0 ? "other" : "camera";
    const bool is_same = i > 0 && bytes.Below(4) == 0;
    photo.intrinsics = is_same ? flight.photos.back().intrinsics : LensFrom(bytes);
    photo.photo.intrinsics = photo.intrinsics;
    photo.cam_from_enu = is_same ? flight.photos.back().cam_from_enu : PoseFrom(bytes);
    photo.height_above_ground_m =
        bytes.Below(8) == 0 ? bytes.Number(100.0) : photo.cam_from_enu.TargetOriginInSource().z();
    flight.photos.push_back(std::move(photo));
  }
  const int points = bytes.Below(200);
  for (int i = 0; i < points; ++i)
    flight.tie_points_in_enu.emplace_back(bytes.Number(60.0), bytes.Number(60.0), bytes.Number(5.0));
  return flight;
}

inline image::DecodedImage PictureFrom(Bytes& bytes, int width_px, int height_px) {
  image::DecodedImage image;
  image.width_px = width_px;
  image.height_px = height_px;
  image.rgb.resize(3 * static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px));
  const int kind = bytes.Below(4);
  std::uint32_t state = 1U + static_cast<std::uint32_t>(bytes.Below(3));
  for (std::uint8_t& value : image.rgb) {
    state = state * 1664525U + 1013904223U;
    value = kind == 0 ? 0 : kind == 1 ? 255 : static_cast<std::uint8_t>(state >> 24);
  }
  return image;
}

inline std::vector<render::Thumbnail> ThumbnailsFrom(Bytes& bytes, const alignment::AlignedFlight& flight) {
  std::vector<render::Thumbnail> thumbnails;
  for (const alignment::AlignedPhoto& photo : flight.photos) {
    thumbnails.push_back(render::MakeThumbnail(
        photo.photo, PictureFrom(bytes, photo.intrinsics.width_px, photo.intrinsics.height_px)));
  }
  return thumbnails;
}

// Without the photos that the program leaves out before it draws.
inline alignment::AlignedFlight PlausibleFlightFrom(Bytes& bytes) {
  alignment::AlignedFlight flight = FlightFrom(bytes);
  poses::LeaveOutImplausible(
      flight.frame,
      [](const alignment::AlignedPhoto& photo) {
        return poses::CameraStand{photo.intrinsics, photo.cam_from_enu, photo.height_above_ground_m};
      },
      flight.photos, flight.left_out);
  return flight;
}

}  // namespace skyquilt::fuzz
