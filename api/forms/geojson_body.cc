#include "api/forms/geojson_body.h"

#include <fmt/format.h>

#include <utility>

#include "api/http/responses.h"

namespace skyquilt::api {

bool IsGeoJson(const Request& request) {
  const std::string_view type = request.headers.Find("Content-Type");
  return IsJson(request) ||
         EqualsIgnoringCase(type.substr(0, type.find_first_of("; ")), "application/geo+json");
}

void AddGeoJsonRoute(Router& router, std::string_view pattern, std::string what,
                     std::function<Result<GeoJsonAnswer>(const Request&)> prepare) {
  router
      .AddUpload(Method::kPost, pattern,
                 [what = std::move(what), prepare = std::move(prepare)](
                     const Request& request) -> std::variant<std::unique_ptr<BodySink>, Response> {
                   if (!IsGeoJson(request)) {
                     return Problem({ErrorCode::kUnsupportedFormat,
                                     fmt::format("Send the {} as GeoJSON: curl -H 'Content-Type: "
                                                 "application/geo+json' -d @FILE.geojson ...",
                                                 what),
                                     ""},
                                    request);
                   }
                   Result<GeoJsonAnswer> answer = prepare(request);
                   if (!answer) return Problem(answer.error(), request);
                   return CollectBody([request, answer = *std::move(answer)](const std::string& body) {
                     const Result<std::string> told = answer(body);
                     return told ? Json(200, *told) : Problem(told.error(), request);
                   });
                 })
      .scope = storage::Scope::kRead;
}

}  // namespace skyquilt::api
