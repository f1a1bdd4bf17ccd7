#include "api/maps/map_parameters.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <string>
#include <vector>

#include "api/wms/wms_request.h"
#include "core/base/try.h"

namespace skyquilt::api {
namespace {

constexpr double kMaxDeg = 400.0, kMaxUnits = 1e9;

Error BadParameter(std::string_view name, std::string_view what) {
  return {ErrorCode::kInvalidArgument, fmt::format("The parameter \"{}\" must be {}.", name, what), ""};
}

std::optional<double> FiniteNumber(std::string_view text) {
  double number = 0.0;
  const auto parsed = std::from_chars(text.data(), text.data() + text.size(), number);
  if (text.empty() || parsed.ec != std::errc() || parsed.ptr != text.data() + text.size())
    return std::nullopt;
  return std::isfinite(number) ? std::optional(number) : std::nullopt;
}

// Absent: one of them is none, or there are more than six.
std::optional<std::vector<double>> FiniteNumbers(std::string_view text) {
  std::vector<double> numbers;
  while (numbers.size() < 6) {
    const std::size_t comma = text.find(',');
    const std::optional<double> number = FiniteNumber(text.substr(0, comma));
    if (!number) return std::nullopt;
    numbers.push_back(*number);
    if (comma == std::string_view::npos) return numbers;
    text.remove_prefix(comma + 1);
  }
  return std::nullopt;
}

// With x before y, whatever the system's order.
Eigen::Vector2d Ordered(const MapCrs& crs, double first, double second) {
  return crs.is_north_first() ? Eigen::Vector2d(second, first) : Eigen::Vector2d(first, second);
}

// East of the antimeridian a box may go on at its other side.
Result<GivenBox> CheckedBox(const char* name, MapCrs crs, Eigen::Vector2d low,
                            const Eigen::Vector2d& high_given) {
  Eigen::Vector2d high = high_given;
  if (crs.is_in_degrees() && high.x() < low.x()) high.x() += 360.0;
  const double most = crs.is_in_degrees() ? kMaxDeg : kMaxUnits;
  if (!(low.x() < high.x()) || !(low.y() < high.y()) || low.cwiseAbs().maxCoeff() > most ||
      high.cwiseAbs().maxCoeff() > most) {
    return BadParameter(name,
                        "a box from its lower left to its upper right corner, within the world, in the "
                        "order of axes of its coordinate system");
  }
  GivenBox given{std::move(crs), {}};
  given.box.min = low;
  given.box.max = high;
  return given;
}

Result<GivenBox> BoxOfBbox(const Request& request, std::string_view text) {
  SKYQUILT_TRY_ASSIGN(MapCrs crs, CrsIn(request, "bbox-crs"));
  const std::optional<std::vector<double>> numbers = FiniteNumbers(text);
  if (!numbers || (numbers->size() != 4 && numbers->size() != 6))
    return BadParameter("bbox", "four numbers, or six with heights, with commas between them");
  const std::size_t half = numbers->size() / 2;  // a height stands third in each corner
  const Eigen::Vector2d low = Ordered(crs, (*numbers)[0], (*numbers)[1]);
  const Eigen::Vector2d high = Ordered(crs, (*numbers)[half], (*numbers)[half + 1]);
  return CheckedBox("bbox", std::move(crs), low, high);
}

// "Lat(47:48)" of a subset. Absent: something else.
struct AxisInterval {
  std::string_view axis;
  std::optional<double> low, high;  // absent: "*", to the end of the map
};
std::optional<AxisInterval> ParseInterval(std::string_view text) {
  const std::size_t open = text.find('('), colon = text.find(':');
  if (open == std::string_view::npos || colon == std::string_view::npos || colon < open ||
      !text.ends_with(')'))
    return std::nullopt;
  AxisInterval interval{text.substr(0, open), std::nullopt, std::nullopt};
  const std::string_view low = text.substr(open + 1, colon - open - 1);
  const std::string_view high = text.substr(colon + 1, text.size() - colon - 2);
  if (low != "*" && !(interval.low = FiniteNumber(low))) return std::nullopt;
  if (high != "*" && !(interval.high = FiniteNumber(high))) return std::nullopt;
  return interval;
}

std::optional<int> AxisNamed(std::string_view name) {
  for (const char* known : {"Lon", "Long", "x", "E", "Easting"}) {
    if (EqualsIgnoringCase(name, known)) return 0;
  }
  for (const char* known : {"Lat", "y", "N", "Northing"}) {
    if (EqualsIgnoringCase(name, known)) return 1;
  }
  return std::nullopt;
}

Result<GivenBox> BoxOfSubset(const Request& request, const geo::LatLonBounds& whole) {
  SKYQUILT_TRY_ASSIGN(MapCrs crs, CrsIn(request, "subset-crs"));
  const std::optional<geo::Bounds2> all = BoxIn(crs, whole);
  if (!all) return BadParameter("subset-crs", "a coordinate system that reaches the map");
  Eigen::Vector2d low = all->min, high = all->max;
  for (const auto& [name, value] : request.query) {
    if (name != "subset") continue;
    std::string_view rest = value;
    while (!rest.empty()) {
      const std::size_t end = std::min(rest.find(')'), rest.size() - 1) + 1;
      const std::optional<AxisInterval> interval = ParseInterval(rest.substr(0, end));
      const std::optional<int> axis = interval ? AxisNamed(interval->axis) : std::nullopt;
      if (!axis)
        return BadParameter("subset",
                            "intervals of the axes Lon and Lat, or x and y: Lon(8.1:8.2),Lat(47:47.1)");
      if (interval->low) low[*axis] = *interval->low;
      if (interval->high) high[*axis] = *interval->high;
      rest.remove_prefix(end);
      if (rest.starts_with(',')) rest.remove_prefix(1);
    }
  }
  return CheckedBox("subset", std::move(crs), low, high);
}

}  // namespace

Result<std::optional<double>> PositiveNumberIn(const Request& request, const char* name) {
  const auto text = request.Query(name);
  if (!text) return std::optional<double>();
  const std::optional<double> number = FiniteNumber(*text);
  if (!number || !(*number > 0.0)) return BadParameter(name, "a number above zero");
  return number;
}

Result<std::optional<int>> PixelsIn(const Request& request, const char* name) {
  SKYQUILT_TRY_ASSIGN(const std::optional<double> number, PositiveNumberIn(request, name));
  if (!number) return std::optional<int>();
  if (*number != std::floor(*number)) return BadParameter(name, "a whole number of pixels");
  if (*number > kMaxWmsSidePx) {
    return Error{ErrorCode::kTooLarge,
                 fmt::format("The parameter \"{}\" must not be above {} pixels.", name, kMaxWmsSidePx), ""};
  }
  return std::optional(static_cast<int>(*number));
}

Result<std::optional<bool>> YesOrNoIn(const Request& request, const char* name) {
  const auto text = request.Query(name);
  if (!text) return std::optional<bool>();
  if (EqualsIgnoringCase(*text, "true")) return std::optional(true);
  if (EqualsIgnoringCase(*text, "false")) return std::optional(false);
  return BadParameter(name, "true or false");
}

Result<MapCrs> CrsIn(const Request& request, const char* name) {
  const auto text = request.Query(name);
  return text ? MapCrs::Named(*text) : MapCrs::Crs84();
}

Result<std::optional<GivenBox>> BoxGivenIn(const Request& request, const geo::LatLonBounds& whole) {
  const auto bbox = request.Query("bbox");
  const bool has_subset = request.Query("subset").has_value();
  if (bbox && has_subset) {
    return Error{ErrorCode::kInvalidArgument, "Say where by \"bbox\" or by \"subset\", not by both.", ""};
  }
  if (!bbox && !has_subset) return std::optional<GivenBox>();
  SKYQUILT_TRY_ASSIGN(GivenBox given, bbox ? BoxOfBbox(request, *bbox) : BoxOfSubset(request, whole));
  return std::optional(std::move(given));
}

Result<std::optional<GivenPlace>> CenterGivenIn(const Request& request) {
  const auto text = request.Query("center");
  if (!text) return std::optional<GivenPlace>();
  SKYQUILT_TRY_ASSIGN(MapCrs crs, CrsIn(request, "center-crs"));
  const std::optional<std::vector<double>> numbers = FiniteNumbers(*text);
  if (!numbers || numbers->size() != 2)
    return BadParameter("center", "two numbers with a comma between them");
  const Eigen::Vector2d place = Ordered(crs, (*numbers)[0], (*numbers)[1]);
  return std::optional(GivenPlace{std::move(crs), place});
}

}  // namespace skyquilt::api
