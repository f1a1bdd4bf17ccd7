// What generated lists are made of: a seeded choice, places with a reference system, numbers and degrees in
// the ways people and programs write them, rows in columns, text in bytes. Written apart from the parsers;
// the systems by PROJ. Deterministic: the same seed gives the same bytes. One thread.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "core/geo/lat_lon.h"

namespace skyquilt::testing {

inline constexpr double kMetresPerFoot = 0.3048;

class Dice {
 public:
  explicit Dice(std::uint32_t seed) : random_(seed) {}
  std::size_t Below(std::size_t count) { return random_() % count; }
  bool OneIn(std::size_t count) { return Below(count) == 0; }
  double Between(double low, double high) { return low + (high - low) * (random_() / 4294967296.0); }
  // The same, of either sign.
  double BetweenOrBelow(double low, double high) {
    const double size = Between(low, high);
    return OneIn(2) ? size : -size;
  }
  std::string Of(std::initializer_list<std::string_view> words) {
    return std::string(*(words.begin() + Below(words.size())));
  }
  template <typename T>
  const T& Of(const std::vector<T>& items) {
    return items[Below(items.size())];
  }
  template <typename T>
  void Shuffle(std::vector<T>& items) {
    for (std::size_t i = items.size(); i > 1; --i) std::swap(items[i - 1], items[Below(i)]);
  }

 private:
  std::mt19937 random_;
};

// A reference system as people name it. `code` is what PROJ knows it by.
struct System {
  std::string code;
  std::vector<std::string> names;
  bool is_degrees = false;
  bool is_metres = false;
  double datum_m = 0.0;  // how far two honest roads from it to WGS84 may lie apart
};

struct PlaceOnEarth {
  System system;
  geo::LatLon middle;
};

// Degrees anywhere, in all four quarters of the Earth.
PlaceOnEarth AnywhereInDegrees(Dice& dice);
// UTM of both hemispheres, state planes in feet, ETRS89, Gauss-Krueger, the British and other grids.
PlaceOnEarth AnywhereOnAGrid(Dice& dice);

struct OnGrid {
  double x = 0.0;  // east or longitude
  double y = 0.0;
};
OnGrid InSystem(const System& system, const geo::LatLon& at);

struct WayToWrite {
  char separator = ',';
  char decimal_mark = '.';
  bool is_quoted = false;
};
// No way in which a decimal comma would also part the columns.
WayToWrite ChooseWay(Dice& dice);
std::string Written(double value, int digits, const WayToWrite& way);

// "46.84", "N46.84", "46.84° N", "46°50'33.390\"", "46 deg 50' 33.39\" N" ...; one form a list.
enum class DegreeForm {
  kPlain,
  kSign,
  kLetterBefore,
  kLetterAfter,
  kMinutes,
  kSeconds,
  kSecondsBefore,
  kExiftool,
  kCount
};
std::string WrittenDegrees(double degrees, bool is_latitude, DegreeForm form, const WayToWrite& way);

std::string Row(const std::vector<std::string>& cells, const WayToWrite& way);

// Line ends and encoding: as it is, CRLF, with a byte order mark, UTF-16 of both orders.
std::string Encoded(std::string text, Dice& dice);

}  // namespace skyquilt::testing
