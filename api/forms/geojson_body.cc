#include "api/forms/geojson_body.h"

#include <fmt/format.h>

#include <utility>

#include "api/http/responses.h"
#include "core/base/try.h"

namespace skyquilt::api {

bool IsGeoJson(const Request& request) {
  const std::string_view type = request.headers.Find("Content-Type");
  return IsJson(request) ||
         EqualsIgnoringCase(type.substr(0, type.find_first_of("; ")), "application/geo+json");
}

void AddGeoJsonRoute(Router& router, std::string_view pattern, std::string what,
                     std::function<Result<GeoJsonAnswer>(const Request&)> prepare) {
  Route& route = router.AddUpload(
      Method::kPost, pattern,
      [what = std::move(what), prepare = std::move(prepare)](const Request& request) -> UploadBegun {
        if (!IsGeoJson(request)) {
          return Error{ErrorCode::kUnsupportedFormat,
                       fmt::format("Send the {} as GeoJSON: curl -H 'Content-Type: "
                                   "application/geo+json' -d @FILE.geojson ...",
                                   what)};
        }
        SKYQUILT_TRY_ASSIGN(GeoJsonAnswer prepared, prepare(request));
        return CollectBody(
            request,
            [answer = std::move(prepared)](const Request&, const std::string& body) -> Result<Response> {
              SKYQUILT_TRY_ASSIGN(std::string told, answer(body));
              return Json(200, std::move(told));
            });
      });
  route.scope = storage::Scope::kRead;
  route.work = Work::kCompute;
}

}  // namespace skyquilt::api
