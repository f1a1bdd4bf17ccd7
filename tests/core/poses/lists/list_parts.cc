#include "tests/core/poses/lists/list_parts.h"

#include <fmt/format.h>
#include <proj.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <stdexcept>

namespace skyquilt::testing {
namespace {

struct Grid {
  System system;
  double south_deg, north_deg, west_deg, east_deg;
};

const std::vector<Grid>& Grids() {
  // code, names, metres, datum, then its area of use, a little within.
  static const std::vector<Grid> grids = {
      {{"EPSG:25832",
        {"EPSG:25832", "ETRS89 / UTM zone 32N", "epsg:25832", "EPSG:25832+7837"},
        false,
        true,
        1.5},
       47.5,
       54.5,
       6.5,
       11.5},
      {{"EPSG:25830", {"EPSG:25830", "ETRS89 / UTM zone 30N"}, false, true, 1.5}, 37.0, 43.0, -5.5, -0.5},
      {{"EPSG:31467", {"EPSG:31467", "DHDN / 3-degree Gauss-Kruger zone 3"}, false, true, 6.0},
       47.8,
       54.0,
       7.8,
       10.2},
      {{"EPSG:27700", {"EPSG:27700", "OSGB36 / British National Grid"}, false, true, 6.0},
       50.8,
       57.0,
       -4.5,
       0.5},
      {{"EPSG:2154", {"EPSG:2154", "RGF93 v1 / Lambert-93"}, false, true, 1.5}, 43.5, 49.5, 0.0, 6.0},
      {{"EPSG:2056", {"EPSG:2056", "CH1903+ / LV95"}, false, true, 3.0}, 46.2, 47.4, 7.0, 9.5},
      {{"EPSG:28355", {"EPSG:28355", "GDA94 / MGA zone 55"}, false, true, 3.0}, -38.0, -20.0, 144.5, 149.5},
      {{"EPSG:2236", {"EPSG:2236", "NAD83 / Florida East (ftUS)"}, false, false, 3.0},
       25.5,
       30.0,
       -81.8,
       -80.4},
      {{"EPSG:2227", {"EPSG:2227", "NAD83 / California zone 3 (ftUS)"}, false, false, 3.0},
       37.2,
       38.3,
       -122.0,
       -119.5},
      {{"EPSG:2263", {"EPSG:2263", "NAD83 / New York Long Island (ftUS)"}, false, false, 3.0},
       40.65,
       41.0,
       -73.9,
       -72.2},
  };
  return grids;
}

System UtmAt(const geo::LatLon& at) {
  const int zone = static_cast<int>((at.lon_deg + 180.0) / 6.0) + 1;
  const bool is_north = at.lat_deg >= 0.0;
  System system;
  system.code = fmt::format("EPSG:{}", (is_north ? 32600 : 32700) + zone);
  const char letter = is_north ? 'N' : 'S';
  system.names = {
      system.code,
      fmt::format("WGS84 UTM {}{}", zone, letter),
      fmt::format("WGS 84 / UTM zone {}{}", zone, letter),
      fmt::format("WGS84 UTM zone {}{}", zone, letter),
      fmt::format("wgs84 utm zone {} {}", zone, is_north ? "north" : "south"),
      fmt::format("+proj=utm +zone={}{} +datum=WGS84 +units=m +no_defs", zone, is_north ? "" : " +south"),
      system.code + "+5773"};
  system.is_metres = true;
  return system;
}

std::string Marked(std::string number, char decimal_mark) {
  std::replace(number.begin(), number.end(), '.', decimal_mark);
  return number;
}

struct ProjFree {
  void operator()(PJ* transform) const { proj_destroy(transform); }
  void operator()(PJ_CONTEXT* context) const { proj_context_destroy(context); }
};

}  // namespace

PlaceOnEarth AnywhereInDegrees(Dice& dice) {
  PlaceOnEarth place;
  place.system = {"EPSG:4326",
                  {"EPSG:4326", "WGS84", "epsg:4326", "WGS 84", "+proj=longlat +datum=WGS84 +no_defs"},
                  true,
                  false,
                  0.0};
  place.middle = {dice.BetweenOrBelow(3.0, 78.0), dice.BetweenOrBelow(3.0, 175.0)};
  return place;
}

PlaceOnEarth AnywhereOnAGrid(Dice& dice) {
  PlaceOnEarth place;
  if (dice.OneIn(2)) {
    // Well within a zone.
    const double lon_deg = -180.0 + 6.0 * static_cast<double>(dice.Below(60)) + dice.Between(0.5, 5.5);
    place.middle = {dice.BetweenOrBelow(3.0, 75.0), lon_deg};
    place.system = UtmAt(place.middle);
    return place;
  }
  const Grid& grid = dice.Of(Grids());
  place.system = grid.system;
  place.middle = {dice.Between(grid.south_deg, grid.north_deg), dice.Between(grid.west_deg, grid.east_deg)};
  return place;
}

OnGrid InSystem(const System& system, const geo::LatLon& at) {
  if (system.is_degrees) return {at.lon_deg, at.lat_deg};
  static const std::unique_ptr<PJ_CONTEXT, ProjFree> context(proj_context_create());
  static std::map<std::string, std::unique_ptr<PJ, ProjFree>> transforms;  // each takes milliseconds to find
  std::unique_ptr<PJ, ProjFree>& east_first = transforms[system.code];
  if (!east_first) {
    const std::unique_ptr<PJ, ProjFree> as_defined(
        proj_create_crs_to_crs(context.get(), "EPSG:4326", system.code.c_str(), nullptr));
    if (!as_defined) throw std::runtime_error("PROJ does not know " + system.code);
    east_first.reset(proj_normalize_for_visualization(context.get(), as_defined.get()));
  }
  const PJ_COORD to = proj_trans(east_first.get(), PJ_FWD, proj_coord(at.lon_deg, at.lat_deg, 0.0, 0.0));
  return {to.xy.x, to.xy.y};
}

WayToWrite ChooseWay(Dice& dice) {
  WayToWrite way;
  way.separator = dice.Of({",", ",", ";", "\t"})[0];
  way.decimal_mark = dice.OneIn(4) ? ',' : '.';
  way.is_quoted = dice.OneIn(6) || (way.separator == ',' && way.decimal_mark == ',');
  return way;
}

std::string Written(double value, int digits, const WayToWrite& way) {
  return Marked(fmt::format("{:.{}f}", value, digits), way.decimal_mark);
}

std::string WrittenDegrees(double degrees, bool is_latitude, DegreeForm form, const WayToWrite& way) {
  const double size = std::abs(degrees);
  const std::string letter = is_latitude ? (degrees < 0 ? "S" : "N") : (degrees < 0 ? "W" : "E");
  const std::string plain = Written(size, 8, way);
  // In whole thousandths of a second, so that no 60 is ever written.
  const auto thousandths = static_cast<std::int64_t>(std::llround(size * 3'600'000.0));
  const std::int64_t whole = thousandths / 3'600'000, minutes = thousandths / 60'000 % 60;
  const std::string seconds =
      Marked(fmt::format("{:.3f}", static_cast<double>(thousandths % 60'000) / 1000.0), way.decimal_mark);
  switch (form) {
    case DegreeForm::kSign:
      return Written(degrees, 8, way) + "°";
    case DegreeForm::kLetterBefore:
      return letter + plain;
    case DegreeForm::kLetterAfter:
      return plain + letter;
    case DegreeForm::kMinutes:
      return fmt::format(
          "{}°{}'{}", whole,
          Marked(fmt::format("{:.6f}", (size - static_cast<double>(whole)) * 60.0), way.decimal_mark),
          letter);
    case DegreeForm::kSeconds:
      return fmt::format("{}°{}'{}\"{}", whole, minutes, seconds, letter);
    case DegreeForm::kSecondsBefore:
      return fmt::format("{}{}°{}'{}\"", letter, whole, minutes, seconds);
    case DegreeForm::kExiftool:
      return fmt::format("{} deg {}' {}\" {}", whole, minutes, seconds, letter);
    case DegreeForm::kPlain:
    case DegreeForm::kCount:
      break;
  }
  return Written(degrees, 8, way);
}

std::string Row(const std::vector<std::string>& cells, const WayToWrite& way) {
  std::string row;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (i > 0) row += way.separator;
    const bool holds_separator = cells[i].find(way.separator) != std::string::npos;
    if (!way.is_quoted && !holds_separator) {
      row += cells[i];
      continue;
    }
    row += '"';
    for (const char c : cells[i]) row += c == '"' ? std::string("\"\"") : std::string(1, c);
    row += '"';
  }
  return row + "\n";
}

std::string Encoded(std::string text, Dice& dice) {
  if (dice.OneIn(3)) {
    std::string with_returns;
    for (const char c : text) with_returns += c == '\n' ? std::string("\r\n") : std::string(1, c);
    text = with_returns;
  }
  if (dice.OneIn(4)) return "\xEF\xBB\xBF" + text;
  if (!dice.OneIn(4)) return text;
  const bool big_end_first = dice.OneIn(2);
  std::string wide;
  const auto add = [&](unsigned unit) {
    const char high = static_cast<char>(unit >> 8), low = static_cast<char>(unit & 0xFF);
    wide += big_end_first ? high : low;
    wide += big_end_first ? low : high;
  };
  add(0xFEFF);
  // The texts here hold nothing beyond two bytes of UTF-8.
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    if (byte < 0x80) {
      add(byte);
    } else {
      add((byte & 0x1Fu) << 6 | (static_cast<unsigned char>(text[i + 1]) & 0x3Fu));
      ++i;
    }
  }
  return wide;
}

}  // namespace skyquilt::testing
