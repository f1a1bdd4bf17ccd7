// ColourRamp: 256 colours from the least value to the most, by name (rdylgn, spectral, viridis ...), turned
// round with "_r" behind it: straight lines in sRGB between the control points that its makers published.
// Sources and licences stand in colour_ramp.cc. Constant; any thread.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

namespace skyquilt::indices {

class ColourRamp {
 public:
  using Colour = std::array<std::uint8_t, 3>;
  static constexpr int kLevels = 256;

  // In any case of letters. Absent: there is no such ramp.
  static std::optional<ColourRamp> Named(std::string_view name);
  static std::vector<std::string_view> Names();  // without those turned round

  const Colour& At(int level) const { return colours_[static_cast<std::size_t>(level)]; }
  // The level of a value: 0 at `least` and below, 255 at `most` and above. Precondition: finite, least <
  // most.
  static int LevelOf(double value, double least, double most);

 private:
  std::array<Colour, kLevels> colours_{};
};

}  // namespace skyquilt::indices
