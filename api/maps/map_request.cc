#include "api/maps/map_request.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include "api/http/parameters.h"
#include "api/wms/wms_request.h"
#include "core/base/try.h"
#include "core/geo/web_mercator.h"

namespace skyquilt::api {
namespace {

// A box or a place with the system that it is in; x before y.
struct GivenBox {
  MapCrs crs;
  geo::Bounds2 box;
};
struct GivenPlace {
  MapCrs crs;
  Eigen::Vector2d place;
};

constexpr double kMaxDeg = 400.0, kMaxUnits = 1e9;

Error BadParameter(std::string_view name, std::string_view what) {
  return {ErrorCode::kInvalidArgument, fmt::format("The parameter \"{}\" must be {}.", name, what)};
}

// Without the parameter CRS84.
Result<MapCrs> CrsIn(const Request& request, const char* name) {
  const auto text = request.Query(name);
  return text ? MapCrs::Named(*text) : MapCrs::Crs84();
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
  const std::optional<std::vector<double>> numbers = FiniteNumbers(text, 6);
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
  if (low != "*" && !(interval.low = ParseFiniteNumber(low))) return std::nullopt;
  if (high != "*" && !(interval.high = ParseFiniteNumber(high))) return std::nullopt;
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

// Absent: the request does not have the parameter.
Result<std::optional<double>> PositiveNumberIn(const Request& request, const char* name) {
  const auto text = request.Query(name);
  if (!text) return std::optional<double>();
  const std::optional<double> number = ParseFiniteNumber(*text);
  if (!number || !(*number > 0.0)) return BadParameter(name, "a number above zero");
  return number;
}

// A whole number of pixels. Error: kTooLarge beyond the limit.
Result<std::optional<int>> PixelsIn(const Request& request, const char* name) {
  SKYQUILT_TRY_ASSIGN(const std::optional<double> number, PositiveNumberIn(request, name));
  if (!number) return std::optional<int>();
  if (*number != std::floor(*number)) return BadParameter(name, "a whole number of pixels");
  if (*number > kMaxWmsSidePx) {
    return Error{ErrorCode::kTooLarge,
                 fmt::format("The parameter \"{}\" must not be above {} pixels.", name, kMaxWmsSidePx)};
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

// By "bbox" and "bbox-crs", or by "subset" and "subset-crs", which may say one axis alone: of the other it
// has all of `whole`.
Result<std::optional<GivenBox>> BoxGivenIn(const Request& request, const geo::LatLonBounds& whole) {
  const auto bbox = request.Query("bbox");
  const bool has_subset = request.Query("subset").has_value();
  if (bbox && has_subset) {
    return Error{ErrorCode::kInvalidArgument, "Say where by \"bbox\" or by \"subset\", not by both."};
  }
  if (!bbox && !has_subset) return std::optional<GivenBox>();
  SKYQUILT_TRY_ASSIGN(GivenBox given, bbox ? BoxOfBbox(request, *bbox) : BoxOfSubset(request, whole));
  return std::optional(std::move(given));
}

Result<std::optional<GivenPlace>> CenterGivenIn(const Request& request) {
  const auto text = request.Query("center");
  if (!text) return std::optional<GivenPlace>();
  SKYQUILT_TRY_ASSIGN(MapCrs crs, CrsIn(request, "center-crs"));
  const std::optional<std::vector<double>> numbers = FiniteNumbers(*text, 2);
  if (!numbers || numbers->size() != 2)
    return BadParameter("center", "two numbers with a comma between them");
  const Eigen::Vector2d place = Ordered(crs, (*numbers)[0], (*numbers)[1]);
  return std::optional(GivenPlace{std::move(crs), place});
}

constexpr double kUsualMmPerPixel = 0.28;

// What a request says of size and scale.
struct GivenSize {
  std::optional<int> width_px, height_px;
  std::optional<double> ground_m;  // of a pixel

  bool has_side() const { return width_px || height_px; }
};

Result<GivenSize> SizeIn(const Request& request) {
  GivenSize size;
  SKYQUILT_TRY_ASSIGN(size.width_px, PixelsIn(request, "width"));
  SKYQUILT_TRY_ASSIGN(size.height_px, PixelsIn(request, "height"));
  SKYQUILT_TRY_ASSIGN(const std::optional<double> denominator,
                      PositiveNumberIn(request, "scale-denominator"));
  SKYQUILT_TRY_ASSIGN(const std::optional<double> mm, PositiveNumberIn(request, "mm-per-pixel"));
  if (denominator) size.ground_m = *denominator * mm.value_or(kUsualMmPerPixel) / 1000.0;
  return size;
}

Error TooManyPixels() {
  return {ErrorCode::kTooLarge,
          "The picture would have more than 4096 pixels on a side, or more than 8 million. Ask for fewer by "
          "\"width\" and \"height\", for a larger \"scale-denominator\", or for a smaller box."};
}

// Pixels on a side of so many metres.
Result<int> SideOf(double metres, double ground_m) {
  const double side = std::max(1.0, std::round(metres / ground_m));
  if (!(side <= kMaxWmsSidePx)) return TooManyPixels();
  return static_cast<int>(side);
}

// What a box measures on the ground, by the scale at its middle. Where none can be told, its own units.
Eigen::Vector2d GroundSizeOf(const MapCrs& crs, const geo::Bounds2& box) {
  const Eigen::Vector2d metres =
      crs.MetresPerUnit((box.min + box.max) / 2).value_or(Eigen::Vector2d(1.0, 1.0));
  return (box.max - box.min).cwiseProduct(metres);
}

// A pixel of the map's finest zoom, on the ground.
double FinestGroundM(const WholeMap& map) {
  return map.pixel_in_merc_m * geo::GroundMetresPerMercMetre(map.bounds.Middle().lat_deg);
}

// A box in the shape of its pixels, or the pixels in the shape of a box.
struct Picture {
  geo::Bounds2 box;
  int width_px = 0, height_px = 0;
};

// The box as it is; what of the size is not said follows from it.
Result<Picture> PictureOfBox(const MapCrs& crs, const geo::Bounds2& box, const GivenSize& size,
                             const WholeMap& map) {
  const Eigen::Vector2d ground = GroundSizeOf(crs, box);
  double ground_m = std::max(FinestGroundM(map), ground.maxCoeff() / kUsualMapSidePx);
  if (size.ground_m) ground_m = *size.ground_m;
  if (size.width_px) {
    ground_m = ground.x() / *size.width_px;
  } else if (size.height_px) {
    ground_m = ground.y() / *size.height_px;
  }
  Picture picture{box, 0, 0};
  SKYQUILT_TRY_ASSIGN(picture.width_px,
                      size.width_px ? Result<int>(*size.width_px) : SideOf(ground.x(), ground_m));
  SKYQUILT_TRY_ASSIGN(picture.height_px,
                      size.height_px ? Result<int>(*size.height_px) : SideOf(ground.y(), ground_m));
  return picture;
}

// So many pixels of so much ground around a place.
Result<Picture> PictureAround(const MapCrs& crs, const Eigen::Vector2d& place, int width_px, int height_px,
                              double ground_m) {
  const std::optional<Eigen::Vector2d> metres = crs.MetresPerUnit(place);
  if (!metres) {
    return Error{ErrorCode::kInvalidArgument,
                 "The map's coordinate system has no scale there. Ask by \"bbox\", or in another \"crs\"."};
  }
  const Eigen::Vector2d half = Eigen::Vector2d(width_px, height_px).cwiseQuotient(*metres) * (ground_m / 2);
  Picture picture{{}, width_px, height_px};
  picture.box.min = place - half;
  picture.box.max = place + half;
  return picture;
}

// Without a box: the whole map where nothing says less.
Result<Picture> PictureOfMap(const MapCrs& crs, const geo::Bounds2& whole,
                             const std::optional<Eigen::Vector2d>& center, const GivenSize& size,
                             const WholeMap& map) {
  if (!center && !size.ground_m && !(size.width_px && size.height_px))
    return PictureOfBox(crs, whole, size, map);
  const Eigen::Vector2d middle = (whole.min + whole.max) / 2, ground = GroundSizeOf(crs, whole);
  const int other = size.width_px.value_or(size.height_px.value_or(kUsualMapSidePx));
  int width_px = size.width_px.value_or(other), height_px = size.height_px.value_or(other);
  double ground_m = FinestGroundM(map);
  if (size.ground_m) {
    ground_m = *size.ground_m;
    // No more than the map, which a picture around its middle would be too large for.
    const auto within = [&](double metres) {
      return static_cast<int>(
          std::clamp(std::ceil(metres / ground_m), 1.0, static_cast<double>(kUsualMapSidePx)));
    };
    if (!center && !size.has_side()) {
      width_px = within(ground.x());
      height_px = within(ground.y());
    }
  } else if (!center) {
    ground_m = std::max(ground.x() / width_px, ground.y() / height_px);
  }
  return PictureAround(crs, center.value_or(middle), width_px, height_px, ground_m);
}

Result<Picture> PictureIn(const Request& request, const MapCrs& crs, const WholeMap& map) {
  SKYQUILT_TRY_ASSIGN(const std::optional<GivenBox> given, BoxGivenIn(request, map.bounds));
  SKYQUILT_TRY_ASSIGN(const std::optional<GivenPlace> center, CenterGivenIn(request));
  SKYQUILT_TRY_ASSIGN(const GivenSize size, SizeIn(request));
  const auto beyond = [](const char* what) {
    return Error{ErrorCode::kInvalidArgument,
                 std::string("The coordinate system of \"crs\" does not reach ") + what + "."};
  };
  if (given) {
    if (center)
      return Error{ErrorCode::kInvalidArgument, "Say where by a box or by \"center\", not by both."};
    if (size.ground_m && size.has_side()) {
      return Error{ErrorCode::kInvalidArgument,
                   "Of a box say \"scale-denominator\", or \"width\" and \"height\", not both."};
    }
    const std::optional<geo::Bounds2> box = BoxIn(crs, given->box, given->crs);
    if (!box) return beyond("the box");
    return PictureOfBox(crs, *box, size, map);
  }
  const std::optional<geo::Bounds2> whole = BoxIn(crs, map.bounds);
  if (!whole) return beyond("the map");
  std::optional<Eigen::Vector2d> place;
  if (center) {
    const std::optional<geo::LatLon> position = center->crs.LatLonOf(center->place);
    if (position) place = crs.PlaceOf(*position);
    if (!place) return beyond("the center");
  }
  return PictureOfMap(crs, *whole, place, size, map);
}

Result<MapBackground> BackgroundIn(const Request& request) {
  MapBackground background;
  const auto colour = request.Query("bgcolor"), void_colour = request.Query("void-color");
  if (colour) {
    SKYQUILT_TRY_ASSIGN(background.colour, ParseColour(*colour, "bgcolor"));
  }
  background.void_colour = background.colour;
  if (void_colour) {
    SKYQUILT_TRY_ASSIGN(background.void_colour, ParseColour(*void_colour, "void-color"));
  }
  SKYQUILT_TRY_ASSIGN(const std::optional<bool> is_transparent, YesOrNoIn(request, "transparent"));
  SKYQUILT_TRY_ASSIGN(const std::optional<bool> is_void_transparent, YesOrNoIn(request, "void-transparent"));
  background.is_transparent = is_transparent.value_or(!colour);
  background.is_void_transparent = is_void_transparent.value_or(background.is_transparent);
  return background;
}

}  // namespace

Result<MapRequest> ParseMapRequest(const Request& request, const WholeMap& map) {
  const auto named = request.Query("crs");
  SKYQUILT_TRY_ASSIGN(MapCrs crs, named ? MapCrs::Named(*named) : MapCrs::Mercator());
  SKYQUILT_TRY_ASSIGN(const MapBackground background, BackgroundIn(request));
  SKYQUILT_TRY_ASSIGN(const Picture picture, PictureIn(request, crs, map));
  if (picture.width_px * picture.height_px > kMaxWmsPixels) return TooManyPixels();
  if (!(picture.box.Width() > 0.0) || !(picture.box.Height() > 0.0) || !picture.box.min.allFinite() ||
      !picture.box.max.allFinite()) {
    return Error{ErrorCode::kInvalidArgument, "The box has no area in the coordinate system of \"crs\"."};
  }
  return MapRequest{std::move(crs), picture.box, picture.width_px, picture.height_px, background};
}

}  // namespace skyquilt::api
