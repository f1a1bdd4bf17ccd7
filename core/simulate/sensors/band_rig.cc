#include "core/simulate/sensors/band_rig.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/simulate/world/random.h"
#include "core/simulate/world/render_photo.h"

namespace skyquilt::simulate {
namespace {

constexpr double kLevels = 65536.0;
constexpr double kWhiteLevel = 52'000.0;  // of what the band shows at most, in the middle of the picture

struct BandKind {
  const char* name;
  double wavelength_nm, width_nm;
  double at_black, of_red, of_green, of_blue;
};
// Plants are green in the simulated world, and bright in the near infrared.
constexpr std::array<BandKind, 5> kKinds = {{{"Blue", 475, 32, 0.02, 0.0, 0.0, 0.26},
                                             {"Green", 560, 27, 0.02, 0.0, 0.32, 0.0},
                                             {"Red", 668, 14, 0.02, 0.36, 0.0, 0.0},
                                             {"Red edge", 717, 12, 0.05, 0.1, 0.35, 0.0},
                                             {"NIR", 842, 57, 0.2, -0.15, 0.6, 0.0}}};

double MostReflectance(const Eigen::Vector4d& of_color) {
  return of_color[0] + of_color.tail<3>().cwiseMax(0.0).sum();
}

double VignettingAt(const RigBand& band, double x, double y) {
  const double r = std::hypot(x - band.vignetting_x_px, y - band.vignetting_y_px);
  double sum = 1.0, power = 1.0;
  for (const double k : band.vignetting) sum += k * (power *= r);
  return sum;
}

}  // namespace

std::vector<RigBand> MakeBandRig(const camera::Intrinsics& lens, std::uint32_t seed) {
  RandomStream random(seed, 501);
  std::vector<RigBand> rig;
  const double half_diagonal_px = 0.5 * std::hypot(lens.width_px, lens.height_px);
  for (const BandKind& kind : kKinds) {
    RigBand band;
    band.index = static_cast<int>(rig.size());
    band.name = kind.name;
    band.wavelength_nm = kind.wavelength_nm;
    band.width_nm = kind.width_nm;
    band.reflectance_of_color = {kind.at_black, kind.of_red, kind.of_green, kind.of_blue};
    band.lens = lens;
    if (rig.size() != kReferenceBand) {
      constexpr double kTurnRad = 0.012, kApartM = 0.03, kLateS = 0.008;
      const auto any = [&](double most) { return random.Uniform(-most, most); };
      band.lens.focal_x_px *= 1.0 + any(0.004);
      band.lens.focal_y_px = band.lens.focal_x_px * lens.focal_y_px / lens.focal_x_px;
      band.lens.center_x_px += any(0.005 * lens.width_px);
      band.lens.center_y_px += any(0.005 * lens.width_px);
      band.lens.k1 += any(0.01);
      band.band_from_reference = geo::RotationFromVector({any(kTurnRad), any(kTurnRad), any(kTurnRad)});
      band.center_in_reference_m = {any(kApartM), any(kApartM), 0.0};
      band.late_s = random.Uniform(0.0, kLateS);
    }
    // A fifth to a third of the light is lost in the corners, most of it near them.
    const double lost = random.Uniform(0.2, 0.35);
    const double corner = 1.0 / (1.0 - lost) - 1.0;
    band.vignetting[1] = -0.7 * corner / std::pow(half_diagonal_px, 2);
    band.vignetting[3] = -0.05 * corner / std::pow(half_diagonal_px, 4);
    band.vignetting_x_px = lens.center_x_px + random.Uniform(-0.03, 0.03) * lens.width_px;
    band.vignetting_y_px = lens.center_y_px + random.Uniform(-0.03, 0.03) * lens.height_px;
    band.a1 = random.Uniform(1.0e-4, 2.5e-4);
    band.a2 = random.Uniform(0.5e-7, 1.5e-7);
    band.a3 = random.Uniform(1.0e-5, 3.0e-5);
    band.black_level = static_cast<std::uint16_t>(random.Uniform(4500.0, 5200.0));
    rig.push_back(band);
  }
  return rig;
}

BandExposure ExposureOf(const RigBand& band, std::size_t capture, std::uint32_t seed) {
  BandExposure exposure;
  exposure.capture_id = fmt::format("SIM{:08}", capture + 1);
  // Clouds are the same for all bands, the exposure is each camera's own.
  RandomStream light(seed, 600 + capture);
  exposure.irradiance = 1.1 * std::exp(0.12 * light.Gauss()) * (1.3 - 0.6 * band.wavelength_nm / 1000.0);
  const auto salt = HashCell(static_cast<std::int32_t>(capture), band.index, seed);
  RandomStream random(salt, 601);
  exposure.noise_seed = HashCell(band.index, static_cast<std::int32_t>(capture), seed + 29);
  exposure.iso = random.Uniform() < 0.3 ? 200 : 100;
  const double gain = exposure.iso / 100.0;
  const double radiance = MostReflectance(band.reflectance_of_color) * exposure.irradiance / std::numbers::pi;
  const double exposure_s = (kWhiteLevel - band.black_level) / kLevels * band.a1 / gain / radiance;
  exposure.exposure_us =
      static_cast<std::uint32_t>(std::clamp(1e6 * exposure_s * random.Uniform(0.6, 1.0), 20.0, 100'000.0));
  return exposure;
}

geo::Rigid3 BandFromEnu(const RigBand& band, const TruePose& reference) {
  const geo::Rigid3& pose = reference.cam_from_enu;
  const Eigen::Vector3d center = pose.TargetOriginInSource() +
                                 pose.rotation.conjugate() * band.center_in_reference_m +
                                 band.late_s * reference.velocity_in_enu_mps;
  return geo::Rigid3::FromRotationAndTargetOrigin((band.band_from_reference * pose.rotation).normalized(),
                                                  center);
}

image::SampleImage RenderBand(const World& world, const RigBand& band, const TruePose& reference,
                              const BandExposure& exposure, double noise_levels, int threads) {
  const Eigen::Vector4f of_color =
      (Eigen::Vector4d() << band.reflectance_of_color[0], band.reflectance_of_color.tail<3>() / 255.0)
          .finished()
          .cast<float>();
  const image::FloatImage reflectance =
      RenderLight(world, band.lens, BandFromEnu(band, reference), of_color, threads);
  image::SampleImage picture{reflectance.width_px, reflectance.height_px, {}};
  picture.samples.reserve(reflectance.values.size());
  const double exposure_s = 1e-6 * exposure.exposure_us, gain = exposure.iso / 100.0;
  std::size_t at = 0;
  for (int y = 0; y < picture.height_px; ++y) {
    const double row_s = exposure_s + band.a2 * y - band.a3 * exposure_s * y;
    for (int x = 0; x < picture.width_px; ++x, ++at) {
      const double radiance =
          static_cast<double>(reflectance.values[at]) * exposure.irradiance / std::numbers::pi;
      const double level = band.black_level +
                           kLevels * radiance * gain / band.a1 * row_s * VignettingAt(band, x, y) +
                           noise_levels * static_cast<double>(SensorNoise(x, y, 0, exposure.noise_seed));
      picture.samples.push_back(
          static_cast<std::uint16_t>(std::clamp(std::round(level), 0.0, kLevels - 1.0)));
    }
  }
  return picture;
}

}  // namespace skyquilt::simulate
