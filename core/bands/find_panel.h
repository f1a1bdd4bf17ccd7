// FindPanel: a MicaSense calibration panel in a picture, by the code (QR) beside its grey square. The square
// stands one and a half sides of the code away from it, in one of four directions; the evenest is taken. A
// picture without a panel, or with one that is cut off or unsharp, has none. Pure; any thread; some 50 ms for
// a picture of 1 MP. Never fails.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "core/image/decoded_image.h"

namespace skyquilt::bands {

// What the code on a MicaSense calibration panel says. Its text is a serial number,
// "RP04-1924106-OB", and on panels of version 4 and later after it the reflectance at two wavelengths, 4
// digits of nanometres and 3 of thousandths each ("...-OB04005250900524": 0.525 at 400 nm, 0.524 at 900),
// between which it is a line. Source: MicaSense's knowledge base, "What are the reflectance
// values for my panel".
struct PanelCode {
  std::string serial;  // without the reflectances
  int version = 0;
  struct Point {
    double wavelength_nm = 0.0, reflectance = 0.0;
  };
  std::optional<std::pair<Point, Point>> reflectances;

  // Nothing where the code does not say it.
  std::optional<double> ReflectanceAt(double wavelength_nm) const;
};

// Nothing for any other text.
std::optional<PanelCode> ParsePanelCode(std::string_view text);

// A four-sided area of a picture, its corners one after the other, in pixels.
using PanelArea = std::array<Eigen::Vector2d, 4>;

struct FoundPanel {
  PanelCode code;
  PanelArea area_px{};
};

std::optional<FoundPanel> FindPanel(const image::SampleImage& picture);

// Levels of 16 bits from here on are clipped: those of ten bits end at 65472. An area of which more is tells
// nothing.
inline constexpr std::uint16_t kClippedLevel = 65'000;
inline constexpr double kMaxClippedShare = 0.01;

// The levels within an area: their median, how far the middle half spreads around it (a share of it), and the
// share of them that the sensor clipped. Nothing where the area does not lie within the picture or holds less
// than some 20 pixels.
struct AreaLevels {
  double median = 0.0;
  double spread = 0.0;
  double clipped_share = 0.0;
};
std::optional<AreaLevels> LevelsIn(const image::SampleImage& picture, const PanelArea& area_px);

// The same of values.
std::optional<double> MedianIn(const image::FloatImage& values, const PanelArea& area_px);

}  // namespace skyquilt::bands
