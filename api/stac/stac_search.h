// StacSearch: which maps a client of STAC looks for (item search of STAC API 1.0), by the parameters of an
// address or by a JSON body. Bounded: a body of 64 KiB, 1,000 ids, pages of at most 200 maps. Values; any
// thread. Errors: kInvalidArgument, with the parameter and what to write instead.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "api/common/feature_query.h"
#include "api/http/http_message.h"
#include "core/base/result.h"
#include "storage/catalogue/catalogue.h"
#include "storage/rasters/geojson_shape.h"

namespace skyquilt::api {

// The one collection that maps belong to.
inline constexpr const char* kStacCollection = "flights";

struct StacSearch {
  int limit = 10;
  std::optional<std::string> cursor;  // id of the flight that an earlier page ended with
  std::optional<geo::LatLonBounds> bbox;
  std::optional<storage::GeoJsonShape> intersects;
  std::optional<TimeSpan> datetime;
  std::optional<std::vector<std::string>> ids;
  std::optional<std::vector<std::string>> collections;

  bool Finds(const storage::ShownFlight& map) const;
};

// Of the address of a GET.
Result<StacSearch> ParseStacQuery(const Request& request);
// Of a POST.
Result<StacSearch> ParseStacBody(const std::string& body);

// When the photos of a map were taken, first and last, in UTC; absent where no camera knew it.
struct StacTimes {
  std::string first, last;
};
std::optional<StacTimes> CaptureTimesOf(const storage::Revision& revision);

}  // namespace skyquilt::api
