#include "api/indices/index_legend.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "api/http/responses.h"
#include "api/tiles/recode_tile.h"
#include "core/base/text/xml_text.h"
#include "core/pyramid/draw_legend.h"

namespace skyquilt::api {
namespace {

constexpr int kRampStops = 17;
constexpr std::size_t kLegendMarks = 5;

std::string HexOf(const indices::ColourRamp::Colour& colour) {
  return fmt::format("#{:02x}{:02x}{:02x}", colour[0], colour[1], colour[2]);
}

std::array<std::string, kLegendMarks> MarksOf(const IndexLook& look) {
  std::array<std::string, kLegendMarks> marks;
  const double range = look.most - look.least;
  // Of a narrow range far from 0, as of kelvins, three digits do not tell the marks apart.
  const double times = std::max(std::abs(look.least), std::abs(look.most)) / range;
  const int digits = 3 + static_cast<int>(std::clamp(std::log10(times), 0.0, 12.0));
  for (std::size_t i = 0; i < kLegendMarks; ++i) {
    const double share = static_cast<double>(i) / (kLegendMarks - 1);
    marks[i] = fmt::format("{:.{}g}", look.least + share * range, digits);
  }
  return marks;
}

std::string LegendSvg(const IndexLook& look) {
  constexpr int kMarginPx = 16, kBarTopPx = 24, kBarHeightPx = 14;
  constexpr int kBarWidthPx = kLegendWidthPx - 2 * kMarginPx;
  std::string stops;
  const std::vector<std::string> colours = StopsOf(look.ramp);
  for (std::size_t i = 0; i < colours.size(); ++i) {
    stops += fmt::format(R"(<stop offset="{:.2f}%" stop-color="{}"/>)", 100.0 * double(i) / (kRampStops - 1),
                         colours[i]);
  }
  std::string texts;
  const std::array<std::string, kLegendMarks> marks = MarksOf(look);
  for (std::size_t i = 0; i < marks.size(); ++i) {
    const double share = static_cast<double>(i) / (kLegendMarks - 1);
    const char* anchor = i == 0 ? "start" : i + 1 == kLegendMarks ? "end" : "middle";
    texts += fmt::format(R"(<text x="{:.1f}" y="54" text-anchor="{}">{}</text>)",
                         kMarginPx + share * kBarWidthPx, anchor, marks[i]);
  }
  return fmt::format(
      R"(<svg xmlns="http://www.w3.org/2000/svg" width="{0}" height="{1}" viewBox="0 0 {0} {1}" font-family="sans-serif" font-size="11">)"
      R"(<rect width="{0}" height="{1}" fill="#ffffff"/><defs><linearGradient id="ramp">{2}</linearGradient></defs>)"
      R"(<text x="{3}" y="16" font-weight="bold">{4}</text>)"
      R"-(<rect x="{3}" y="{5}" width="{6}" height="{7}" fill="url(#ramp)" stroke="#444444" stroke-width="0.5"/>{8}</svg>)-"
      "\n",
      kLegendWidthPx, kLegendHeightPx, stops, kMarginPx, XmlText(look.title), kBarTopPx, kBarWidthPx,
      kBarHeightPx, texts);
}

std::string LegendPng(const IndexLook& look) {
  pyramid::Legend legend{look.title, {}, {}};
  for (int level = 0; level < indices::ColourRamp::kLevels; ++level)
    legend.colours.push_back(look.ramp.At(level));
  for (const std::string& mark : MarksOf(look)) legend.marks.push_back(mark);
  return EncodeTile(pyramid::DrawLegend(legend, kLegendWidthPx, kLegendHeightPx), image::PictureFormat::kPng);
}

}  // namespace

std::vector<std::string> StopsOf(const indices::ColourRamp& ramp) {
  std::vector<std::string> stops;
  for (int i = 0; i < kRampStops; ++i)
    stops.push_back(HexOf(ramp.At(i * (indices::ColourRamp::kLevels - 1) / (kRampStops - 1))));
  return stops;
}

std::optional<LegendFormat> LegendFormatOf(std::string_view content_type) {
  if (content_type.starts_with("image/png")) return LegendFormat::kPng;
  if (content_type.starts_with("image/svg")) return LegendFormat::kSvg;
  return std::nullopt;
}

Response LegendOf(const Request& request, const IndexLook& look, LegendFormat format) {
  Response response = format == LegendFormat::kSvg ? Text(200, LegendSvg(look), "image/svg+xml")
                                                   : Text(200, LegendPng(look), "image/png");
  response.headers.Add("Cache-Control", "public, max-age=3600");
  return Tagged(request, std::move(response));
}

std::string LegendPath(std::string_view flight_id, std::string_view index) {
  return fmt::format("/api/v1/flights/{}/legend.png?index={}", flight_id, index);
}

}  // namespace skyquilt::api
