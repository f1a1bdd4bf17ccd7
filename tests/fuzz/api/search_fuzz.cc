// What clients look for maps and photos by: STAC's search, by address and by body, boxes, times and shapes.
#include <cmath>
#include <cstdint>
#include <string>

#include "api/http/target.h"
#include "api/stac/stac_search.h"
#include "core/base/check.h"

namespace {

void CheckSearch(const skyquilt::api::StacSearch& search) {
  SKYQUILT_CHECK(search.limit >= 1 && search.limit <= 200, "a page beyond the limit");
  SKYQUILT_CHECK(!(search.bbox && search.intersects), "two places at once");
  if (search.bbox) {
    SKYQUILT_CHECK(search.bbox->west_deg <= search.bbox->east_deg &&
                       search.bbox->south_deg <= search.bbox->north_deg &&
                       std::isfinite(search.bbox->west_deg + search.bbox->east_deg),
                   "a box that is none");
  }
  skyquilt::storage::ShownFlight map{"01hzzzzzzzzzzzzzzzzzzzzzzz", "field", {}};
  map.revision.bounds = {7.0, 46.0, 7.1, 46.1};
  map.revision.first_capture = map.revision.last_capture = "2024-06-01T10:00:00+02:00";
  (void)search.Finds(map);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace skyquilt::api;
  const std::string text(reinterpret_cast<const char*>(data), size);
  if (const auto search = ParseStacBody(text)) CheckSearch(*search);
  (void)ParseTimeSpan(text);
  (void)InstantOf(text);
  (void)UtcOfCapture(text, 7.0);
  auto query = ParseQuery(text);
  if (!query) return 0;
  Request request;
  request.query = *std::move(query);
  if (const auto search = ParseStacQuery(request)) CheckSearch(*search);
  return 0;
}
