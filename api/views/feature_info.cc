#include "api/views/feature_info.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "api/http/responses.h"
#include "core/base/text/json_io.h"
#include "core/base/text/xml_text.h"

namespace skyquilt::api {
namespace {

using InfoJson = nlohmann::ordered_json;
using NamedValues = std::vector<std::pair<std::string, InfoJson>>;

// In the order in which people read them.
NamedValues ValuesOf(const MapPoint& point) {
  NamedValues values = {{"flight", point.flight_id}, {"name", point.flight_name}};
  if (point.rgba) {
    const auto& [red, green, blue, alpha] = *point.rgba;
    values.insert(values.end(), {{"red", red}, {"green", green}, {"blue", blue}});
  }
  if (point.height_m) values.emplace_back("height_m", *point.height_m);
  if (point.photo) {
    values.emplace_back("photo", point.photo->photo);
    values.emplace_back("photo_x", point.photo->pixel_in_image.x());
    values.emplace_back("photo_y", point.photo->pixel_in_image.y());
    if (point.photo->sigma_m) values.emplace_back("sigma_m", *point.photo->sigma_m);
  }
  return values;
}

std::string TextOf(const InfoJson& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_number_float()) return fmt::format("{:.3f}", value.get<double>());
  return JsonText(value);
}

std::string GeoJsonText(const std::vector<MapPoint>& points) {
  InfoJson features = InfoJson::array();
  for (const MapPoint& point : points) {
    InfoJson properties = InfoJson::object();
    for (const auto& [name, value] : ValuesOf(point)) properties[name] = value;
    features.push_back(
        {{"type", "Feature"},
         {"id", point.flight_id},
         {"geometry", {{"type", "Point"}, {"coordinates", {point.position.lon_deg, point.position.lat_deg}}}},
         {"properties", properties}});
  }
  const InfoJson collection = {{"type", "FeatureCollection"}, {"features", features}};
  return JsonText(collection);
}

std::string PlainText(const std::vector<MapPoint>& points) {
  std::string text;
  for (const MapPoint& point : points) {
    for (const auto& [name, value] : ValuesOf(point)) text += fmt::format("{} = {}\n", name, TextOf(value));
    text += "\n";
  }
  return text;
}

std::string HtmlText(const std::vector<MapPoint>& points) {
  std::string text = "<!DOCTYPE html><html><head><meta charset=\"utf-8\"><title>Map</title></head><body>\n";
  for (const MapPoint& point : points) {
    text += "<table>\n";
    for (const auto& [name, value] : ValuesOf(point))
      text += fmt::format("<tr><th>{}</th><td>{}</td></tr>\n", name, XmlText(TextOf(value)));
    text += "</table>\n";
  }
  return text + "</body></html>\n";
}

}  // namespace

bool IsInfoFormat(std::string_view type) {
  return std::find(kInfoFormats.begin(), kInfoFormats.end(), type) != kInfoFormats.end();
}

Response InfoResponse(const std::vector<MapPoint>& points, std::string_view type) {
  std::string body = type == "text/plain"  ? PlainText(points)
                     : type == "text/html" ? HtmlText(points)
                                           : GeoJsonText(points);
  const std::string charset = type.starts_with("text/") ? "; charset=utf-8" : "";
  return NoCache(Text(200, std::move(body), std::string(type) + charset));
}

}  // namespace skyquilt::api
