#include "core/pipeline/placing/control_json.h"

#include <nlohmann/json.hpp>

#include "core/base/text/json_io.h"
#include "core/flight/remarks/remark_words.h"

namespace skyquilt::pipeline {

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
