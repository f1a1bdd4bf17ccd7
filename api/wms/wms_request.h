// The parameters of WMS' operations, checked. OGC 01-068r3 (1.1.1), 06-042 (1.3.0) and 05-078r4 (legends).
// Pure; any thread. Errors: kInvalidArgument, whose detail is WMS' own code or empty.
#pragma once

#include <string>
#include <vector>

#include "api/common/background.h"
#include "api/http/http_message.h"
#include "api/indices/index_legend.h"
#include "core/image/picture_format.h"

namespace skyquilt::api {

// The window of a GetMap request.
struct WmsMap {
  std::vector<std::string> layers = {};                     // from the bottom up; at least one
  std::vector<std::string> styles = {};                     // of the first layers; of the others the default
  double west = 0.0, south = 0.0, east = 0.0, north = 0.0;  // merc metres, or degrees where is_geographic
  bool is_geographic = false;
  int width_px = 0;
  int height_px = 0;
  bool is_transparent = false;
  Rgb background = kWhite;  // where it is not transparent
  image::PictureFormat format = image::PictureFormat::kPng;
};
Result<WmsMap> ParseGetMap(const Request& request);

// A pixel of such a window, whose format does not matter.
struct WmsInfo {
  WmsMap map;  // its layers are those that are asked
  int column = 0, row = 0;
  std::string type;
};
Result<WmsInfo> ParseGetFeatureInfo(const Request& request);

// The legend of one layer in one style. WIDTH and HEIGHT say what a legend would like to be, and are not
// taken.
struct WmsLegend {
  std::string layer, style;
  LegendFormat format = LegendFormat::kPng;
};
Result<WmsLegend> ParseGetLegendGraphic(const Request& request);

// 1.3.0, which is also meant where no version is said, nor a system as older ones name it.
bool IsNewerWms(const Request& request);

inline constexpr int kMaxWmsSidePx = 4096;
inline constexpr int kMaxWmsPixels = 8 << 20;
// What capabilities say of both, which have words for sides alone: of a square.
inline constexpr int kMaxWmsSquareSidePx = 2896;
static_assert(kMaxWmsSquareSidePx * kMaxWmsSquareSidePx <= kMaxWmsPixels);
inline constexpr std::size_t kMaxWmsLayers = 16;

}  // namespace skyquilt::api
