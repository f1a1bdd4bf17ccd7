// RenderPhoto: what a camera at a known pose sees of the simulated world, by exact ray casting: pixel,
// through the lens (Intrinsics::Unproject), to the first surface. 8-bit sRGB RGB. The result depends on the
// arguments alone, not on the number of threads. Any thread.
#pragma once

#include <Eigen/Core>
#include <chrono>
#include <cstdint>

#include "core/camera/intrinsics.h"
#include "core/camera/rolling_shutter.h"
#include "core/geo/lat_lon.h"
#include "core/geo/rigid3.h"
#include "core/image/decoded_image.h"
#include "core/simulate/world/world.h"

namespace skyquilt::simulate {

struct RenderPhotoOptions {
  double vignetting = 0.0;     // share of light lost in the corners (of the encoded value), falling with r^2
  double exposure_gain = 1.0;  // factor on the encoded values
  // How much brighter ground is that is seen with the sun behind, and towards the sun; half of it at
  // hot_spot_rad from there.
  double hot_spot = 0.0;
  double hot_spot_rad = 0.2;
  Eigen::Vector3d sun_in_enu = Eigen::Vector3d::UnitZ();
  Eigen::Vector3d motion_in_enu_m = Eigen::Vector3d::Zero();  // of the camera while the shutter is open
  camera::RowMotion readout_motion;                           // while it reads its rows
  double noise_counts = 1.0;  // 1-sigma of the sensor's noise, in 8-bit counts
  std::uint32_t noise_seed = 1;
  int threads = 1;  // 0 = all cores

  bool operator==(const RenderPhotoOptions&) const = default;
};

image::DecodedImage RenderPhoto(const World& world, const camera::Intrinsics& intrinsics,
                                const geo::Rigid3& cam_from_enu, const RenderPhotoOptions& options);

// The same of a band, without lens and sensor: first + the others times red, green and blue (0 to 255) of
// what each pixel shows.
image::FloatImage RenderLight(const World& world, const camera::Intrinsics& intrinsics,
                              const geo::Rigid3& cam_from_enu, const Eigen::Vector4f& of_color, int threads);

// A sensor's noise at a pixel: about Gaussian with 1-sigma of 1, the same at every call.
float SensorNoise(int x, int y, int channel, std::uint32_t seed);

// Where the sun stands, as a unit vector in enu (east, north, up) at a place; below the horizon `up` is
// negative. To 0.02 degrees between 1950 and 2050, refraction left out. Source: low-precision formulas of the
// Astronomical Almanac, section C.
Eigen::Vector3d SunDirection(const geo::LatLon& place, std::chrono::sys_time<std::chrono::microseconds> utc);

}  // namespace skyquilt::simulate
