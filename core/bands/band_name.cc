#include "core/bands/band_name.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <utility>

namespace skyquilt::bands {
namespace {

constexpr std::array<std::pair<std::string_view, std::string_view>, 15> kSpellings = {{
    {"nearinfrared", "nir"},
    {"infrared", "nir"},
    {"ir", "nir"},
    {"reg", "rededge"},
    {"re", "rededge"},
    {"gre", "green"},
    {"g", "green"},
    {"r", "red"},
    {"b", "blue"},
    {"blu", "blue"},
    {"pan", "panchro"},
    {"panchromatic", "panchro"},
    {"thermal", "lwir"},
    {"thermalinfrared", "lwir"},
    {"longwaveinfrared", "lwir"},
}};
constexpr std::array<std::string_view, 6> kByAlignRank = {"green", "red",  "rededge",
                                                          "nir",   "blue", "panchro"};
constexpr std::size_t kMaxNameBytes = 40;

}  // namespace

std::string BandNameOf(std::string_view written) {
  std::string name;
  for (const char c : written.substr(0, kMaxNameBytes)) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) continue;
    name += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  for (const auto& [spelling, usual] : kSpellings) {
    if (name == spelling) return std::string(usual);
  }
  return name;
}

int AlignRank(std::string_view band_name) {
  return static_cast<int>(std::find(kByAlignRank.begin(), kByAlignRank.end(), band_name) -
                          kByAlignRank.begin());
}

}  // namespace skyquilt::bands
