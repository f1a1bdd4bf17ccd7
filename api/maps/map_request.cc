#include "api/maps/map_request.h"

#include <algorithm>
#include <cmath>

#include "api/maps/map_parameters.h"
#include "api/wms/wms_request.h"
#include "core/base/try.h"
#include "core/geo/web_mercator.h"

namespace skyquilt::api {
namespace {

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
          "\"width\" and \"height\", for a larger \"scale-denominator\", or for a smaller box.",
          ""};
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
                 "The map's coordinate system has no scale there. Ask by \"bbox\", or in another \"crs\".",
                 ""};
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
                 std::string("The coordinate system of \"crs\" does not reach ") + what + ".", ""};
  };
  if (given) {
    if (center)
      return Error{ErrorCode::kInvalidArgument, "Say where by a box or by \"center\", not by both.", ""};
    if (size.ground_m && size.has_side()) {
      return Error{ErrorCode::kInvalidArgument,
                   "Of a box say \"scale-denominator\", or \"width\" and \"height\", not both.", ""};
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
    return Error{ErrorCode::kInvalidArgument, "The box has no area in the coordinate system of \"crs\".", ""};
  }
  return MapRequest{std::move(crs), picture.box, picture.width_px, picture.height_px, background};
}

}  // namespace skyquilt::api
