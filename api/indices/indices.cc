#include "api/indices/indices.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "api/http/problem.h"
#include "api/http/responses.h"
#include "api/indices/index_values.h"
#include "api/indices/zones.h"
#include "api/ogc/map_view.h"
#include "core/base/try.h"

namespace skyquilt::api {
namespace {

using BandsJson = nlohmann::ordered_json;

constexpr int kRampStops = 17;  // colours of a ramp, for who draws it

std::string HexOf(const indices::ColourRamp::Colour& colour) {
  return fmt::format("#{:02x}{:02x}{:02x}", colour[0], colour[1], colour[2]);
}

std::vector<std::string> StopsOf(const indices::ColourRamp& ramp) {
  std::vector<std::string> stops;
  for (int i = 0; i < kRampStops; ++i)
    stops.push_back(HexOf(ramp.At(i * (indices::ColourRamp::kLevels - 1) / (kRampStops - 1))));
  return stops;
}

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
  Response response = Json(200, json.dump(-1, ' ', false, BandsJson::error_handler_t::replace));
  response.headers.Add("Cache-Control", "no-cache");
  return response;
}

// The ramp from its least value to its most, with five values below.
std::string LegendSvg(const IndexLook& look) {
  constexpr int kMarginPx = 16, kBarTopPx = 24, kBarHeightPx = 14, kMarks = 5;
  constexpr int kBarWidthPx = kLegendWidthPx - 2 * kMarginPx;
  std::string stops;
  const std::vector<std::string> colours = StopsOf(look.ramp);
  for (std::size_t i = 0; i < colours.size(); ++i) {
    stops += fmt::format(R"(<stop offset="{:.2f}%" stop-color="{}"/>)", 100.0 * double(i) / (kRampStops - 1),
                         colours[i]);
  }
  std::string marks;
  for (int i = 0; i < kMarks; ++i) {
    const double share = static_cast<double>(i) / (kMarks - 1);
    const char* anchor = i == 0 ? "start" : i + 1 == kMarks ? "end" : "middle";
    marks +=
        fmt::format(R"(<text x="{:.1f}" y="54" text-anchor="{}">{:.3g}</text>)",
                    kMarginPx + share * kBarWidthPx, anchor, look.least + share * (look.most - look.least));
  }
  return fmt::format(
      R"(<svg xmlns="http://www.w3.org/2000/svg" width="{0}" height="{1}" viewBox="0 0 {0} {1}" font-family="sans-serif" font-size="11">)"
      R"(<rect width="{0}" height="{1}" fill="#ffffff"/><defs><linearGradient id="ramp">{2}</linearGradient></defs>)"
      R"(<text x="{3}" y="16" font-weight="bold">{4}</text>)"
      R"-(<rect x="{3}" y="{5}" width="{6}" height="{7}" fill="url(#ramp)" stroke="#444444" stroke-width="0.5"/>{8}</svg>)-"
      "\n",
      kLegendWidthPx, kLegendHeightPx, stops, kMarginPx, XmlText(look.title), kBarTopPx, kBarWidthPx,
      kBarHeightPx, marks);
}

Result<Response> AnswerLegend(Service& service, const Request& request) {
  SKYQUILT_TRY_ASSIGN(const IndexLook look, LookRequiredIn(request));
  SKYQUILT_TRY(CheckId(request.Parameter("flight"), "flight"));
  SKYQUILT_TRY(service.catalogue.GetFlight(request.Parameter("flight")));
  Response response = Text(200, LegendSvg(look), "image/svg+xml");
  response.headers.Add("Cache-Control", "public, max-age=3600");
  return Tagged(request, std::move(response));
}

Response OrProblem(Result<Response> answer, const Request& request) {
  return answer ? *std::move(answer) : Problem(answer.error(), request);
}

}  // namespace

std::string LegendPath(std::string_view flight_id, std::string_view index) {
  return fmt::format("/api/v1/flights/{}/legend.svg?index={}", flight_id, index);
}

void AddIndexRoutes(Router& router, Service& service) {
  router.Add(Method::kGet, "/api/v1/flights/{flight}/bands",
             [&](const Request& request) { return OrProblem(AnswerBands(service, request), request); });
  router.Add(Method::kGet, "/api/v1/flights/{flight}/legend.svg",
             [&](const Request& request) { return OrProblem(AnswerLegend(service, request), request); });
  router.AddCompute(Method::kGet, "/api/v1/flights/{flight}/zones", [&](const Request& request) {
    return OrProblem(AnswerZones(service, request), request);
  });
}

}  // namespace skyquilt::api
