#include "core/bands/thermal.h"

#include <cmath>

namespace skyquilt::bands {
namespace {

constexpr double kZeroCelsiusK = 273.15;
constexpr double kMinSceneK = 150.0, kMaxSceneK = 1000.0;  // of air, sky and windows

bool IsWithin(double value, double least, double most) { return value >= least && value <= most; }

// Share of the light that comes through the air: FLIR's model, with water by the polynomial of its manuals.
double AirTransmission(const flight::FlirConstants& constants) {
  const double celsius = constants.atmosphere_k - kZeroCelsiusK;
  constexpr double kMaxDistanceM = 20'000.0;
  if (!IsWithin(constants.distance_m, 0.0, kMaxDistanceM) || !IsWithin(celsius, -80.0, 80.0) ||
      !IsWithin(constants.relative_humidity, 0.0, 1.0))
    return 1.0;
  const double water = constants.relative_humidity *
                       std::exp(1.5587 + celsius * (6.939e-2 + celsius * (-2.7816e-4 + celsius * 6.8455e-7)));
  const double distance = std::sqrt(constants.distance_m), vapour = std::sqrt(water);
  const auto through = [&](double alpha, double beta) {
    return std::exp(-distance * (alpha + beta * vapour));
  };
  const double x = constants.atmosphere_x;
  const double share = x * through(constants.alpha_1, constants.beta_1) +
                       (1.0 - x) * through(constants.alpha_2, constants.beta_2);
  constexpr double kMinShare = 0.05;
  return IsWithin(share, kMinShare, 1.0) ? share : 1.0;
}

}  // namespace

std::optional<Radiometry> LinearTemperature(std::string_view make, const flight::XmpTags& xmp) {
  Radiometry radiometry;
  radiometry.calibration = Calibration::kKelvin;
  constexpr double kMinGain = 1e-4, kMaxGain = 10.0;
  for (const char* name :
       {"FLIR:TLinearGain", "FLIR:TlinearGain", "Camera:TLinearGain", "Camera:TlinearGain"}) {
    const auto gain = xmp.Number(name);
    if (!gain || !IsWithin(*gain, kMinGain, kMaxGain)) continue;
    radiometry.per_level = *gain;
    radiometry.method = "levels linear in kelvins (FLIR 102-9012-01)";
    return radiometry;
  }
  if (make == "MicaSense") {
    radiometry.per_level = 0.01;
    radiometry.method = "levels in hundredths of a kelvin (MicaSense)";
    return radiometry;
  }
  return std::nullopt;
}

std::optional<Radiometry> FlirTemperature(const flight::FlirConstants& constants) {
  constexpr double kLarge = 1e12, kSmall = 1e-12;
  if (!IsWithin(constants.planck_r1, kSmall, kLarge) || !IsWithin(constants.planck_r2, kSmall, kLarge) ||
      !IsWithin(constants.planck_b, 1.0, 1e5) || !IsWithin(constants.planck_f, 0.0, 1e3))
    return std::nullopt;
  PlanckCurve curve;
  curve.r = constants.planck_r1 / constants.planck_r2;
  curve.b_k = constants.planck_b;
  curve.f = constants.planck_f;
  curve.o = constants.planck_o;
  const double emissivity = IsWithin(constants.emissivity, 0.01, 1.0) ? constants.emissivity : 1.0;
  const double window =
      IsWithin(constants.window_transmission, 0.01, 1.0) ? constants.window_transmission : 1.0;
  const double air = AirTransmission(constants);
  // What the sensor saw: the object through air and window, what the object reflects, and what air and
  // window shine themselves.
  double others = 0.0, shares = 0.0;
  const auto add = [&](double share, double kelvin) {
    if (!(share > 0.0) || !IsWithin(kelvin, kMinSceneK, kMaxSceneK)) return;
    others += share * curve.LevelOf(kelvin);
    shares += share;
  };
  add((1.0 - emissivity) * air * window, constants.reflected_k);
  add((1.0 - air) * window, constants.atmosphere_k);
  add(1.0 - window, constants.window_k);
  if (!std::isfinite(others)) return std::nullopt;
  curve.others_level = others;
  curve.object_share = 1.0 - shares;
  Radiometry radiometry;
  radiometry.planck = curve;
  radiometry.calibration = Calibration::kKelvin;
  radiometry.method =
      "FLIR's measurement formula, with emissivity, reflection and air as the camera has them";
  return radiometry;
}

}  // namespace skyquilt::bands
