// PanelCode: what the code on a MicaSense calibration panel says. Its text is a serial number,
// "RP04-1924106-OB", and on panels of version 4 and later after it the reflectance at two wavelengths, 4
// digits of nanometres and 3 of thousandths each ("...-OB04005250900524": 0.525 at 400 nm, 0.524 at 900),
// between which it is a line. Pure; any thread. Source: MicaSense's knowledge base, "What are the reflectance
// values for my panel".
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace skyquilt::bands {

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

}  // namespace skyquilt::bands
