#include "api/indices/indices.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "api/http/problem.h"
#include "api/http/responses.h"
#include "api/indices/index_legend.h"
#include "api/indices/zones.h"
#include "api/tiles/index_values.h"
#include "core/base/text/json_io.h"
#include "core/base/try.h"

namespace skyquilt::api {
namespace {

using BandsJson = nlohmann::ordered_json;

Result<Response> AnswerBands(Service& service, const Request& request) {
  const std::string& flight_id = request.Parameter("flight");
  SKYQUILT_TRY(CheckId(flight_id, "flight"));
  SKYQUILT_TRY_ASSIGN(const std::shared_ptr<const storage::Tileset> tileset, service.tilesets.Get(flight_id));
  SKYQUILT_TRY_ASSIGN(const std::vector<std::string> bands, BandsOf(service, *tileset));
  BandsJson json;
  json["revision"] = tileset->revision.revision;
  json["bands"] = bands;
  json["indices"] = BandsJson::array();
  for (const indices::SpectralIndex* index : indices::IndicesOf(bands)) {
    json["indices"].push_back({{"id", index->name},
                               {"title", index->title},
                               {"expression", index->expression},
                               {"rescale", {index->least, index->most}},
                               {"colormap", index->ramp}});
  }
  json["colormaps"] = BandsJson::array();
  for (const std::string_view name : indices::ColourRamp::Names()) {
    json["colormaps"].push_back({{"id", name}, {"colours", StopsOf(*indices::ColourRamp::Named(name))}});
  }
  Response response = Json(200, JsonText(json));
  response.headers.Add("Cache-Control", "no-cache");
  return response;
}

Result<Response> AnswerLegend(Service& service, const Request& request, LegendFormat format) {
  SKYQUILT_TRY_ASSIGN(const IndexLook look, LookRequiredIn(request));
  SKYQUILT_TRY(CheckId(request.Parameter("flight"), "flight"));
  SKYQUILT_TRY(service.catalogue.GetFlight(request.Parameter("flight")));
  Response response = LegendOf(look, format);
  response.headers.Add("Cache-Control", "public, max-age=3600");
  return Tagged(request, std::move(response));
}

Response OrProblem(Result<Response> answer, const Request& request) {
  return answer ? *std::move(answer) : Problem(answer.error(), request);
}

}  // namespace

void AddIndexRoutes(Router& router, Service& service) {
  router.Add(Method::kGet, "/api/v1/flights/{flight}/bands",
             [&](const Request& request) { return OrProblem(AnswerBands(service, request), request); });
  for (const auto& [path, format] : {std::pair{"/api/v1/flights/{flight}/legend.svg", LegendFormat::kSvg},
                                     std::pair{"/api/v1/flights/{flight}/legend.png", LegendFormat::kPng}}) {
    router.Add(Method::kGet, path, [&service, format = format](const Request& request) {
      return OrProblem(AnswerLegend(service, request, format), request);
    });
  }
  router.AddCompute(Method::kGet, "/api/v1/flights/{flight}/zones", [&](const Request& request) {
    return OrProblem(AnswerZones(service, request), request);
  });
}

}  // namespace skyquilt::api
