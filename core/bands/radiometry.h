// Radiometry: what makes a band's stored levels values of light: for the pixel at column x and row y
//   value = per_level * (level - black(x, y)) / row_exposure(y) * vignetting(x, y)
// with everything that a photo's tags say of exposure, gain, sensor and sunlight in it; of thermal pictures
// kelvins, where their levels are not linear by a PlanckCurve. Values; any thread.
// Where the numbers come from, maker by maker, is in read_radiometry.h and thermal.h.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/image/decoded_image.h"

namespace skyquilt::bands {

// How a lens darkens its picture towards the corners.
struct BandVignetting {
  enum class Kind {
    kNone,
    kPlaneDivides,      // by a sum of c x^i y^j, x and y the shares of width and height
    kRadialDivides,     // by 1 + k0 r + k1 r^2 + ..., r in pixels from the centre
    kRadialMultiplies,  // times the same
  };
  struct Term {
    int x_power = 0;
    int y_power = 0;
    double factor = 0.0;
  };

  Kind kind = Kind::kNone;
  std::vector<Term> terms;     // of kPlaneDivides
  std::vector<double> radial;  // k0, k1, ...
  double center_x_px = 0.0, center_y_px = 0.0;

  // What a pixel is multiplied by. Between a tenth and ten: beyond, the polynomial is not of this picture.
  double Gain(double x_px, double y_px, int width_px, int height_px) const;
};

// MicaSense's sensors: the rows' exposure differs a little.
struct RowExposure {
  double exposure_s = 1.0;
  double a2 = 0.0, a3 = 0.0;
  double At(double y_px) const { return exposure_s + a2 * y_px - a3 * exposure_s * y_px; }
};

// Levels of a thermal sensor and the temperature that shines so: level = r / (exp(b / kelvin) - f) - o.
struct PlanckCurve {
  double r = 1.0, b_k = 1.0, f = 0.0, o = 0.0;
  double object_share = 1.0;  // of the level that the object itself makes
  double others_level = 0.0;  // the rest: reflected, of the air, of a window

  double LevelOf(double kelvin) const;
  // Of the object; not a number where no temperature makes such a level.
  double KelvinOf(double level) const;
};

enum class Calibration {
  kLevels,    // stored levels: nothing is known of exposure
  kRadiance,  // proportional to the light that came in, the same factor in all photos of the band
  kRelative,  // divided by the sunlight that the sensor on top measured: the same factor in all photos of the
              // band, which only a panel of known reflectance would tell
  kReflectance,  // divided by the sunlight, in which the band's sensors were calibrated together
  kKelvin,       // temperatures
};

struct Radiometry {
  double per_level = 1.0;
  std::array<double, 4> black{};  // levels, by 2 * (row % 2) + column % 2
  RowExposure rows{1.0, 0.0, 0.0};
  BandVignetting vignetting;
  std::optional<PlanckCurve> planck;  // in place of all of the above
  Calibration calibration = Calibration::kLevels;
  std::string method;              // for the report: by which document
  std::optional<double> sunlight;  // that per_level was divided by, in the unit of its sensor
};

// The photo's picture as values, same size.
image::FloatImage ValuesOf(const image::SampleImage& picture, const Radiometry& radiometry);

// "levels", "radiance", "relative reflectance", "reflectance", "kelvin"
const char* CalibrationName(Calibration calibration);

}  // namespace skyquilt::bands
