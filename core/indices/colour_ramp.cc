#include "core/indices/colour_ramp.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/base/text/plain_text.h"

namespace skyquilt::indices {
namespace {

struct RampTable {
  std::string_view name;
  std::array<std::uint32_t, 11> colours;  // 0xrrggbb
  std::size_t count;
};

// rdylgn, rdylbu, spectral, brbg, ylgn, greys: ColorBrewer 2.0 (Apache License 2.0), colours by Cynthia
// Brewer, Mark Harrower and The Pennsylvania State University, colorbrewer2.org. viridis, magma, inferno,
// plasma: by Nathaniel Smith, Stefan van der Walt and Eric Firing for matplotlib (CC0), every 28th or 29th of
// 256.
constexpr std::array kRampTables = {
    RampTable{"rdylgn",
              {0xa50026, 0xd73027, 0xf46d43, 0xfdae61, 0xfee08b, 0xffffbf, 0xd9ef8b, 0xa6d96a, 0x66bd63,
               0x1a9850, 0x006837},
              11},
    RampTable{"rdylbu",
              {0xa50026, 0xd73027, 0xf46d43, 0xfdae61, 0xfee090, 0xffffbf, 0xe0f3f8, 0xabd9e9, 0x74add1,
               0x4575b4, 0x313695},
              11},
    RampTable{"spectral",
              {0x9e0142, 0xd53e4f, 0xf46d43, 0xfdae61, 0xfee08b, 0xffffbf, 0xe6f598, 0xabdda4, 0x66c2a5,
               0x3288bd, 0x5e4fa2},
              11},
    RampTable{"brbg",
              {0x543005, 0x8c510a, 0xbf812d, 0xdfc27d, 0xf6e8c3, 0xf5f5f5, 0xc7eae5, 0x80cdc1, 0x35978f,
               0x01665e, 0x003c30},
              11},
    RampTable{"ylgn",
              {0xffffe5, 0xf7fcb9, 0xd9f0a3, 0xaddd8e, 0x78c679, 0x41ab5d, 0x238443, 0x006837, 0x004529},
              9},
    RampTable{"greys",
              {0xffffff, 0xf0f0f0, 0xd9d9d9, 0xbdbdbd, 0x969696, 0x737373, 0x525252, 0x252525, 0x000000},
              9},
    RampTable{
        "viridis",
        {0x440154, 0x482878, 0x3e4989, 0x31688e, 0x26828e, 0x1f9e89, 0x35b779, 0x6ece58, 0xb5de2b, 0xfde725},
        10},
    RampTable{
        "magma",
        {0x000004, 0x180f3d, 0x440f76, 0x721f81, 0x9e2f7f, 0xcd4071, 0xf1605d, 0xfd9668, 0xfeca8d, 0xfcfdbf},
        10},
    RampTable{
        "inferno",
        {0x000004, 0x1b0c41, 0x4a0c6b, 0x781c6d, 0xa52c60, 0xcf4446, 0xed6925, 0xfb9b06, 0xf7d13d, 0xfcffa4},
        10},
    RampTable{
        "plasma",
        {0x0d0887, 0x46039f, 0x7201a8, 0x9c179e, 0xbd3786, 0xd8576b, 0xed7953, 0xfb9f3a, 0xfdca26, 0xf0f921},
        10},
};

constexpr std::string_view kTurned = "_r";
constexpr std::size_t kMaxRampName = 16;

double ChannelOf(std::uint32_t colour, std::size_t channel) {
  return static_cast<double>((colour >> (16 - 8 * channel)) & 0xff);
}

}  // namespace

std::optional<ColourRamp> ColourRamp::Named(std::string_view text) {
  if (text.size() > kMaxRampName) return std::nullopt;
  std::string name = LowerCase(text);
  const bool is_turned = name.ends_with(kTurned);
  if (is_turned) name.resize(name.size() - kTurned.size());
  const auto* const table = std::find_if(kRampTables.begin(), kRampTables.end(),
                                         [&](const RampTable& known) { return known.name == name; });
  if (table == kRampTables.end()) return std::nullopt;
  ColourRamp ramp;
  for (int level = 0; level < kLevels; ++level) {
    const double share = static_cast<double>(level) / (kLevels - 1);
    const double place = (is_turned ? 1.0 - share : share) * static_cast<double>(table->count - 1);
    const auto first = std::min(static_cast<std::size_t>(place), table->count - 2);
    const double fraction = place - static_cast<double>(first);
    for (std::size_t channel = 0; channel < 3; ++channel) {
      const double from = ChannelOf(table->colours[first], channel);
      const double to = ChannelOf(table->colours[first + 1], channel);
      ramp.colours_[static_cast<std::size_t>(level)][channel] =
          static_cast<std::uint8_t>(std::lround(from + (to - from) * fraction));
    }
  }
  return ramp;
}

std::vector<std::string_view> ColourRamp::Names() {
  std::vector<std::string_view> names;
  for (const RampTable& table : kRampTables) names.push_back(table.name);
  return names;
}

int ColourRamp::LevelOf(double value, double least, double most) {
  const double share = std::clamp((value - least) / (most - least), 0.0, 1.0);
  return static_cast<int>(share * (kLevels - 1) + 0.5);
}

}  // namespace skyquilt::indices
