#include "server/reports/report_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "api/http/digest.h"
#include "core/base/median.h"
#include "core/base/text/json_io.h"
#include "core/base/text/xml_text.h"
#include "core/base/try.h"
#include "core/pipeline/report/map_quality.h"

namespace skyquilt::server {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kMaxRows = 2000;  // of one table

constexpr const char* kStyle = R"css(
body{font:15px/1.5 system-ui,sans-serif;color:#1b1f23;background:#fff;max-width:60rem;margin:2rem auto;padding:0 1rem}
h1{font-size:1.7rem;margin:0 0 .2rem}h2{font-size:1.15rem;margin:1.8rem 0 .5rem;border-bottom:1px solid #d0d7de}
.sub{color:#57606a;margin:0 0 1rem}.bad{color:#a40e26;font-weight:600}
figure{margin:0}figure svg{width:100%;height:auto;max-height:75vh;border:1px solid #d0d7de;background:#f2f3f5}
table{border-collapse:collapse;width:100%}th,td{text-align:left;vertical-align:top;padding:.25rem .6rem .25rem 0;border-bottom:1px solid #eaeef2}
th{font-weight:600;width:16rem}thead th{width:auto;border-bottom:2px solid #d0d7de}li{margin:.2rem 0}
footer{color:#57606a;margin-top:2rem;font-size:.85rem}
@page{size:A4;margin:16mm}@media print{body{margin:0;max-width:none;font-size:11pt}h2,tr,figure{break-inside:avoid}h2{break-after:avoid}figure svg{max-height:16cm}}
)css";

// A member at the end of a path of names; null where there is none.
const Json& At(const Json& json, std::initializer_list<const char*> path) {
  static const Json nothing;
  const Json* here = &json;
  for (const char* name : path) {
    if (!here->is_object() || !here->contains(name)) return nothing;
    here = &here->at(name);
  }
  return *here;
}

std::string TextAt(const Json& json, std::initializer_list<const char*> path) {
  const Json& found = At(json, path);
  return found.is_string() ? found.get<std::string>() : "";
}

std::optional<double> NumberAt(const Json& json, std::initializer_list<const char*> path) {
  const Json& found = At(json, path);
  return found.is_number() ? std::optional(found.get<double>()) : std::nullopt;
}

std::string Metres(double metres) {
  return std::abs(metres) < 1.0 ? fmt::format("{:.3g} cm", metres * 100.0) : fmt::format("{:.4g} m", metres);
}

std::string Area(double square_m) {
  return square_m >= 10'000.0 ? fmt::format("{:.2f} ha", square_m / 1e4) : fmt::format("{:.0f} m²", square_m);
}

class Table {
 public:
  void Row(const std::string& name, const std::string& value) {
    if (value.empty()) return;
    rows_ += fmt::format("<tr><th>{}</th><td>{}</td></tr>\n", XmlText(name), XmlText(value));
  }
  std::string Text(const std::string& title) const {
    return rows_.empty() ? "" : fmt::format("<h2>{}</h2>\n<table>\n{}</table>\n", XmlText(title), rows_);
  }

 private:
  std::string rows_;
};

std::string Figure(const MapPicture& picture, bool is_placed) {
  const double bar_m = ScaleBarM(0.28 * picture.width_px * picture.pixel_m);
  const double bar_px = bar_m / picture.pixel_m;
  const double unit =
      std::max(picture.width_px, picture.height_px) / 100.0;  // a hundredth of the longer side
  const std::string bytes(picture.webp.begin(), picture.webp.end());
  std::string svg = fmt::format(
      "<figure><svg viewBox=\"0 0 {0} {1:.0f}\" role=\"img\" aria-label=\"The map\" "
      "xmlns=\"http://www.w3.org/2000/svg\">\n<image width=\"{0}\" height=\"{2}\" "
      "href=\"data:image/webp;base64,{3}\"/>\n",
      picture.width_px, picture.height_px + 7.0 * unit, picture.height_px, api::EncodeBase64(bytes));
  const double base = picture.height_px + 5.0 * unit;
  if (is_placed) {
    svg += fmt::format(
        "<g fill=\"#1b1f23\" stroke=\"none\" font-family=\"sans-serif\" font-size=\"{0:.1f}\">\n"
        "<rect x=\"{1:.1f}\" y=\"{2:.1f}\" width=\"{3:.1f}\" height=\"{4:.1f}\"/><rect x=\"{5:.1f}\" y=\"{2:.1f}\" "
        "width=\"{3:.1f}\" height=\"{4:.1f}\" fill=\"#fff\" stroke=\"#1b1f23\" stroke-width=\"{6:.2f}\"/>\n"
        "<text x=\"{7:.1f}\" y=\"{8:.1f}\">{9}</text>\n",
        2.2 * unit, 2.0 * unit, base - unit, bar_px / 2.0, 0.9 * unit, 2.0 * unit + bar_px / 2.0, 0.15 * unit,
        3.0 * unit + bar_px, base,
        bar_m >= 1000.0 ? fmt::format("{:.0f} km", bar_m / 1000.0)
        : bar_m >= 1.0  ? fmt::format("{:.0f} m", bar_m)
                        : fmt::format("{:.0f} cm", bar_m * 100.0));
    const double x = picture.width_px - 4.0 * unit;
    svg += fmt::format(
        "<path d=\"M{0:.1f} {1:.1f}l{2:.1f} {3:.1f}l-{2:.1f} -{4:.1f}l-{2:.1f} {4:.1f}z\"/><text x=\"{0:.1f}\" "
        "y=\"{5:.1f}\" text-anchor=\"end\" dx=\"-{6:.1f}\">N</text></g>\n",
        x, base - 4.0 * unit, 1.2 * unit, 4.6 * unit, 1.2 * unit, base - 0.2 * unit, 1.8 * unit);
  }
  return svg + "</svg></figure>\n";
}

Table Facts(const Json& report, bool is_placed, bool is_scale_known) {
  Table table;
  const std::string first = TextAt(report, {"captured", "first"}),
                    last = TextAt(report, {"captured", "last"});
  table.Row("Photos taken", first.empty() || first == last ? first : first + " to " + last);
  std::vector<std::string> cameras;
  for (const Json& camera : At(report, {"alignment", "cameras"})) {
    std::string key = TextAt(camera, {"camera_key"});
    for (std::size_t at = key.find('|'); at != std::string::npos; at = key.find('|')) key.replace(at, 1, " ");
    if (!key.empty()) cameras.push_back(key);
  }
  table.Row(cameras.size() > 1 ? "Cameras" : "Camera", fmt::format("{}", fmt::join(cameras, "; ")));
  const auto total = NumberAt(report, {"photos", "total"});
  if (total && *total > 0)
    table.Row("Photos",
              fmt::format("{:.0f}: {:.0f} placed by what they show, {:.0f} by their records alone, {:.0f} "
                          "left out",
                          *total, NumberAt(report, {"photos", "aligned"}).value_or(0),
                          NumberAt(report, {"photos", "pose_only"}).value_or(0),
                          NumberAt(report, {"photos", "left_out"}).value_or(0)));
  constexpr const char* kNoScale = "unknown: the scale is a guess";
  if (const auto area = NumberAt(report, {"area_m2"}))
    table.Row("Ground covered", is_scale_known ? Area(*area) : kNoScale);
  if (const auto gsd = NumberAt(report, {"gsd_m"}); gsd && *gsd > 0)
    table.Row("Ground sample distance", is_scale_known ? Metres(*gsd) : kNoScale);
  const Json& bounds = At(report, {"bounds"});
  if (is_placed && bounds.is_array() && bounds.size() == 4 &&
      std::all_of(bounds.begin(), bounds.end(), [](const Json& one) { return one.is_number(); }))
    table.Row("Bounds (WGS 84)",
              fmt::format("{:.6f}, {:.6f} to {:.6f}, {:.6f} (latitude, longitude)", bounds[1].get<double>(),
                          bounds[0].get<double>(), bounds[3].get<double>(), bounds[2].get<double>()));
  table.Row("Coordinate system", is_placed ? "Web Mercator (EPSG:3857); positions are of WGS 84"
                                           : "none: the map is not georeferenced");
  // Of the first placing: what the map's ground is in the end stands among the accuracy.
  table.Row("Height above ground at first", TextAt(report, {"height_rule"}));
  return table;
}

// Leave-one-out: how far off a map placed by the other points alone puts each.
std::string PredictionInWords(const Json& control) {
  std::vector<double> misses;
  double worst_m = -1.0;
  std::string worst;
  if (!control.is_array()) return "";
  for (const Json& point : control) {
    const auto east = NumberAt(point, {"left_out", "miss_east_m"}),
               north = NumberAt(point, {"left_out", "miss_north_m"});
    if (!east || !north) continue;
    misses.push_back(std::hypot(*east, *north));
    if (misses.back() > worst_m) worst_m = misses.back(), worst = TextAt(point, {"name"});
  }
  if (misses.empty()) return "";
  return fmt::format("missed by {} in the median of {}, at worst {} ({})", Metres(Median(misses)),
                     misses.size(), Metres(worst_m), worst);
}

Table Accuracy(const Json& report, const std::optional<pipeline::MapQuality>& quality) {
  Table table;
  if (quality) {
    table.Row("Absolute", pipeline::AbsoluteInWords(*quality));
    table.Row("Relative", pipeline::RelativeInWords(*quality));
  }
  const Json& control = At(report, {"alignment", "ground_control"});
  if (control.is_array() && !control.empty())
    table.Row("Ground control points", fmt::format("{} given, in the table below", control.size()));
  if (const std::string words = PredictionInWords(control); !words.empty())
    table.Row("Each of them placed by the others", words);
  const std::string model = TextAt(report, {"ground", "model"}),
                    reason = TextAt(report, {"ground", "reason"});
  table.Row("Ground", reason.empty() ? model : model + ": " + reason);
  return table;
}

std::string PointUse(const Json& point) {
  const Json& used = At(point, {"is_used"});
  const Json& check = At(point, {"is_check"});
  if (!used.is_boolean() || !used.get<bool>()) return "not used";
  return check.is_boolean() && check.get<bool>() ? "check" : "control";
}

// Each with what the map misses it by; of one that is not used the reason. A height that was not compared is
// null, in reports of earlier versions 0 to the last digit.
std::string Points(const Json& report) {
  const Json& control = At(report, {"alignment", "ground_control"});
  if (!control.is_array() || control.empty()) return "";
  std::string rows;
  std::size_t count = 0;
  for (const Json& point : control) {
    if (count++ == kMaxRows) break;
    const std::string use = PointUse(point);
    const auto miss = [&](const char* name) {
      const auto metres = NumberAt(point, {name});
      return metres && *metres != 0.0 && use != "not used" ? Metres(*metres) : std::string();
    };
    rows += fmt::format(
        "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{:.0f}</td><td>{}</td></tr>\n",
        XmlText(TextAt(point, {"name"})), use, miss("miss_east_m"), miss("miss_north_m"), miss("miss_up_m"),
        NumberAt(point, {"sightings"}).value_or(0.0), XmlText(TextAt(point, {"reason"})));
  }
  if (control.size() > kMaxRows)
    rows += fmt::format("<tr><td colspan=\"7\">and {} more, in report.json</td></tr>\n",
                        control.size() - kMaxRows);
  return "<h2>Ground control points</h2>\n<p class=\"sub\">Where the map has each, less where it was "
         "surveyed.</p>\n<table><thead><tr><th>Point</th><th>Used as</th><th>East</th><th>North</th>"
         "<th>Up</th><th>Marks</th><th>Note</th></tr></thead>\n" +
         rows + "</table>\n";
}

std::string Warnings(const Json& report) {
  std::string items;
  for (const Json& warning : At(report, {"warnings"})) {
    if (warning.is_string()) items += "<li>" + XmlText(warning.get<std::string>()) + "</li>\n";
  }
  return items.empty() ? "" : "<h2>To be known</h2>\n<ul>\n" + items + "</ul>\n";
}

std::string LeftOut(const Json& report) {
  const Json& photos = At(report, {"left_out_photos"});
  if (!photos.is_array() || photos.empty()) return "";
  std::string rows;
  std::size_t count = 0;
  for (const Json& photo : photos) {
    if (count++ == kMaxRows) break;
    rows += fmt::format("<tr><td>{}</td><td>{}</td></tr>\n", XmlText(TextAt(photo, {"name"})),
                        XmlText(TextAt(photo, {"reason"})));
  }
  if (photos.size() > kMaxRows)
    rows += fmt::format("<tr><td colspan=\"2\">and {} more, in report.json</td></tr>\n",
                        photos.size() - kMaxRows);
  return "<h2>Photos left out</h2>\n<table><thead><tr><th>Photo</th><th>Why</th></tr></thead>\n" + rows +
         "</table>\n";
}

// Nothing for a report of before there was one.
std::optional<pipeline::MapQuality> QualityIn(const Json& report) {
  const auto quality = pipeline::ParseQuality(JsonText(At(report, {"quality"})));
  return quality ? std::optional(*quality) : std::nullopt;
}

std::string Verdict(const std::optional<pipeline::MapQuality>& quality) {
  const pipeline::MapStatus status = quality ? quality->status : pipeline::MapStatus::kUnknown;
  const bool is_bad = status == pipeline::MapStatus::kDoubtful || status == pipeline::MapStatus::kUnplaced;
  std::string text = fmt::format("{}.", pipeline::StatusInWords(status));
  if (quality) {
    for (const pipeline::MapLimit& limit : quality->limits) text += " " + pipeline::LimitInWords(limit);
  }
  return fmt::format("<p class=\"{}\">{}</p>\n", is_bad ? "bad" : "sub", XmlText(text));
}

}  // namespace

Result<std::string> ReportPage(std::string_view report_json, const std::optional<MapPicture>& picture,
                               const std::string& made, const std::string& name) {
  const Json report = ParseJson(report_json);
  if (!report.is_object())
    return Error{ErrorCode::kCorrupt, "report.json of the map is damaged. Make the map again."};
  const bool is_placed = !At(report, {"is_placed"}).is_boolean() || At(report, {"is_placed"}).get<bool>();
  std::string title = name.empty() ? TextAt(report, {"title"}) : name;
  if (title.empty()) title = "Map";
  std::string page = fmt::format(
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" "
      "content=\"width=device-width\">\n<title>{0}</title>\n<style>{1}</style>\n</head>\n<body>\n<h1>{0}</h1>\n"
      "<p class=\"sub\">Orthomosaic, {2}</p>\n",
      XmlText(title), kStyle,
      XmlText(TextAt(report, {"captured", "first"}).empty()
                  ? "date not known"
                  : TextAt(report, {"captured", "first"}).substr(0, 10)));
  const std::optional<pipeline::MapQuality> quality = QualityIn(report);
  const bool is_scale_known = quality ? !quality->IsLimitedBy(pipeline::LimitKind::kScaleGuessed) : is_placed;
  page += Verdict(quality);
  if (picture) page += Figure(*picture, is_placed && is_scale_known);
  page += Facts(report, is_placed, is_scale_known).Text("The map") +
          Accuracy(report, quality).Text("Accuracy") + Points(report) + Warnings(report) + LeftOut(report);
  return page + fmt::format("<footer>Report of {}, by Skyquilt.</footer>\n</body>\n</html>\n", XmlText(made));
}

}  // namespace skyquilt::server
