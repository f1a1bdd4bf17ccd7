#include "core/pipeline/placing/control_points.h"

#include <utility>

namespace skyquilt::pipeline {
namespace {

std::vector<alignment::ControlPoint> MarkedPointsIn(const std::vector<flight::GcpList>& lists,
                                                    bool are_checks) {
  std::vector<alignment::ControlPoint> points;
  for (const flight::GcpList& list : lists) {
    const std::size_t first = points.size();
    for (const flight::GcpPoint& point : list.points) {
      alignment::ControlPoint control;
      control.name = point.name;
      control.position = point.position;
      control.height_m = point.height_m;
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

}  // namespace skyquilt::pipeline
