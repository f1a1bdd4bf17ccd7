#include "core/bands/radiometry.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace skyquilt::bands {
namespace {

constexpr double kMinGain = 0.1, kMaxGain = 10.0;
constexpr int kNodeStep = 16;  // pixels: polynomials are smooth

// x to a power of a polynomial's term, without the errors of pow() for small whole ones.
double Power(double x, int power) {
  double product = 1.0;
  for (int i = 0; i < power; ++i) product *= x;
  return product;
}

// Sixteen bits have few levels: each one's temperature is worked out once.
image::FloatImage KelvinsOf(const image::SampleImage& picture, const PlanckCurve& curve) {
  constexpr std::size_t kLevels = std::size_t{1} << 16;
  std::vector<float> kelvins(kLevels);
  for (std::size_t level = 0; level < kLevels; ++level)
    kelvins[level] = static_cast<float>(curve.KelvinOf(static_cast<double>(level)));
  image::FloatImage values{picture.width_px, picture.height_px, {}};
  values.values.reserve(picture.samples.size());
  for (const std::uint16_t level : picture.samples) values.values.push_back(kelvins[level]);
  return values;
}

}  // namespace

double PlanckCurve::LevelOf(double kelvin) const { return r / (std::exp(b_k / kelvin) - f) - o; }

double PlanckCurve::KelvinOf(double level) const {
  const double of_object = (level - others_level) / object_share;
  const double kelvin = b_k / std::log(r / (of_object + o) + f);
  constexpr double kMaxKelvin = 5000.0;  // beyond, no camera measures
  return of_object + o > 0.0 && kelvin > 0.0 && kelvin < kMaxKelvin
             ? kelvin
             : std::numeric_limits<double>::quiet_NaN();
}

double BandVignetting::Gain(double x_px, double y_px, int width_px, int height_px) const {
  double sum = 1.0;
  if (kind == Kind::kPlaneDivides) {
    const double x = x_px / width_px, y = y_px / height_px;
    sum = 0.0;
    for (const Term& term : terms) sum += term.factor * Power(x, term.x_power) * Power(y, term.y_power);
  } else if (kind != Kind::kNone) {
    const double r = std::hypot(x_px - center_x_px, y_px - center_y_px);
    double power = 1.0;
    for (const double k : radial) sum += k * (power *= r);
  }
  const double gain = kind == Kind::kRadialMultiplies ? sum : 1.0 / sum;
  return gain > kMinGain ? std::min(gain, kMaxGain) : kMinGain;  // not a number: as far as no light
}

image::FloatImage ValuesOf(const image::SampleImage& picture, const Radiometry& radiometry) {
  if (radiometry.planck) return KelvinsOf(picture, *radiometry.planck);
  const int width = picture.width_px, height = picture.height_px;
  const int columns = width / kNodeStep + 2, rows = height / kNodeStep + 2;
  std::vector<float> gains;
  gains.reserve(static_cast<std::size_t>(columns) * rows);
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      gains.push_back(
          static_cast<float>(radiometry.vignetting.Gain(column * kNodeStep, row * kNodeStep, width, height)));
    }
  }
  image::FloatImage values{width, height, {}};
  values.values.resize(static_cast<std::size_t>(width) * height);
  std::vector<float> across(static_cast<std::size_t>(columns));
  for (int y = 0; y < height; ++y) {
    const int node_row = y / kNodeStep;
    const float v = static_cast<float>(y % kNodeStep) / kNodeStep;
    const float* north = gains.data() + static_cast<std::ptrdiff_t>(node_row) * columns;
    for (int column = 0; column < columns; ++column)
      across[static_cast<std::size_t>(column)] =
          north[column] + v * (north[columns + column] - north[column]);
    const double exposure = radiometry.rows.At(y);
    const auto scale = static_cast<float>(radiometry.per_level / exposure);
    const float black[2] = {static_cast<float>(radiometry.black[static_cast<std::size_t>(2 * (y % 2))]),
                            static_cast<float>(radiometry.black[static_cast<std::size_t>(2 * (y % 2) + 1)])};
    const std::uint16_t* from = picture.samples.data() + static_cast<std::ptrdiff_t>(y) * width;
    float* to = values.values.data() + static_cast<std::ptrdiff_t>(y) * width;
    for (int x = 0; x < width; ++x) {
      const float u = static_cast<float>(x % kNodeStep) / kNodeStep;
      const float* node = across.data() + x / kNodeStep;
      to[x] = scale * (static_cast<float>(from[x]) - black[x % 2]) * (node[0] + u * (node[1] - node[0]));
    }
  }
  return values;
}

const char* CalibrationName(Calibration calibration) {
  switch (calibration) {
    case Calibration::kReflectance:
      return "reflectance";
    case Calibration::kKelvin:
      return "kelvin";
    case Calibration::kRelative:
      return "relative reflectance";
    case Calibration::kRadiance:
      return "radiance";
    case Calibration::kLevels:
      break;
  }
  return "levels";
}

}  // namespace skyquilt::bands
