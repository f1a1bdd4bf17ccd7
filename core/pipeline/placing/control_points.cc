#include "core/pipeline/placing/control_points.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "core/base/text/json_io.h"
#include "core/flight/remarks/remark_words.h"

namespace skyquilt::pipeline {
namespace {

std::vector<alignment::ControlPoint> MarkedPointsIn(const std::vector<flight::GcpList>& lists,
                                                    bool are_checks) {
  std::vector<alignment::ControlPoint> points;
  for (const flight::GcpList& list : lists) {
    const std::size_t first = points.size();
    for (const flight::GcpPoint& point : list.points) {
      alignment::ControlPoint control;
      control.list = list.file_name;
      control.name = point.name;
      control.position = point.position;
      control.height_m = point.height_m;
      control.system_error_m = list.system_error_m;
      points.push_back(std::move(control));
    }
    for (const flight::GcpSighting& sighting : list.sightings) {
      // The format counts from the corner of the first pixel, we from its middle.
      points[first + sighting.point].sightings.push_back(
          {sighting.image_name, {sighting.pixel_x - 0.5, sighting.pixel_y - 0.5}});
    }
  }
  std::erase_if(points, [&](const alignment::ControlPoint& point) {
    return point.sightings.empty() || flight::IsCheckPoint(point.name) != are_checks;
  });
  return points;
}

}  // namespace

std::vector<alignment::ControlPoint> ControlPointsOf(const std::vector<flight::GcpList>& lists) {
  return MarkedPointsIn(lists, false);
}

std::vector<alignment::ControlPoint> CheckPointsOf(const std::vector<flight::GcpList>& lists) {
  return MarkedPointsIn(lists, true);
}

std::string ControlJson(const flight::GcpList& list) {
  using Document = nlohmann::ordered_json;
  constexpr double kMiddleOfFirstPixel = 0.5;
  Document points = Document::array();
  for (const flight::GcpPoint& point : list.points) {
    points.push_back({{"name", point.name},
                      {"x", point.x},
                      {"y", point.y},
                      {"height", point.height ? Document(*point.height) : Document()},
                      {"lon", point.position.lon_deg},
                      {"lat", point.position.lat_deg},
                      {"marks", Document::array()}});
  }
  for (const flight::GcpSighting& sighting : list.sightings) {
    points[sighting.point]["marks"].push_back({{"photo", sighting.image_name},
                                               {"x", sighting.pixel_x - kMiddleOfFirstPixel},
                                               {"y", sighting.pixel_y - kMiddleOfFirstPixel}});
  }
  const Document document = {{"reference_system", list.reference_system},
                             {"points", points},
                             {"warnings", flight::InWords(list.warnings)}};
  return JsonText(document);
}

}  // namespace skyquilt::pipeline
