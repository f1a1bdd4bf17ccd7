// BandRig: a simulated camera of five bands, each with a sensor, a lens and a shutter of its own: lenses that
// stand apart and look a little elsewhere, vignetting and exposure of each band's own, light that changes
// from capture to capture. What it shows of a place is linear in the place's colour in the simulated world,
// so that the truth of a band is known from the truth in colours. Deterministic in the seed. Values; any
// thread. Levels by the "Radiometric calibration model for MicaSense sensors", turned round.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/camera/intrinsics.h"
#include "core/geo/rigid3.h"
#include "core/image/decoded_image.h"
#include "core/simulate/sensors/trajectory.h"
#include "core/simulate/world/world.h"

namespace skyquilt::simulate {

struct RigBand {
  std::string name;
  int index = 0;  // from 0, in the rig
  double wavelength_nm = 0.0, width_nm = 0.0;
  // Reflectance of a place: first + the others times red, green and blue as shares of 255.
  Eigen::Vector4d reflectance_of_color = Eigen::Vector4d::Zero();
  camera::Intrinsics lens;
  Eigen::Quaterniond band_from_reference = Eigen::Quaterniond::Identity();
  Eigen::Vector3d center_in_reference_m = Eigen::Vector3d::Zero();
  double late_s = 0.0;  // its shutter, after the reference's
  std::array<double, 6> vignetting{};
  double vignetting_x_px = 0.0, vignetting_y_px = 0.0;
  double a1 = 0.0, a2 = 0.0, a3 = 0.0;
  std::uint16_t black_level = 0;
};

struct BandExposure {
  std::string capture_id;
  std::uint32_t exposure_us = 1000;
  std::uint16_t iso = 100;
  double irradiance = 1.0;  // W/m^2/nm
  std::uint32_t noise_seed = 0;
};

// The second one, green, is the reference: its lens is `lens`.
std::vector<RigBand> MakeBandRig(const camera::Intrinsics& lens, std::uint32_t seed);
inline constexpr std::size_t kReferenceBand = 1;

BandExposure ExposureOf(const RigBand& band, std::size_t capture, std::uint32_t seed);

geo::Rigid3 BandFromEnu(const RigBand& band, const TruePose& reference);

// What the band's sensor stores; `noise_levels` is the 1-sigma of its noise, of 65536.
image::SampleImage RenderBand(const World& world, const RigBand& band, const TruePose& reference,
                              const BandExposure& exposure, double noise_levels, int threads);

}  // namespace skyquilt::simulate
