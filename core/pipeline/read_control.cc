#include "core/pipeline/read_control.h"

#include <fmt/core.h>

#include <fstream>

#include "core/flight/logs/gcp_list.h"
#include "core/flight/side_files.h"

namespace skyquilt::pipeline {
namespace {

constexpr std::size_t kHeadBytes = 4096;

bool HoldsControl(const flight::InputFile& file) {
  if (!flight::IsSideFileName(file.name)) return false;
  std::string head(kHeadBytes, '\0');
  std::ifstream stream(file.path, std::ios::binary);
  stream.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(stream.gcount()));
  // A row cut off at the end of what was read must not spoil the look at it.
  if (const std::size_t end = head.find_last_of('\n');
      head.size() == kHeadBytes && end != std::string::npos) {
    head.resize(end + 1);
  }
  return flight::LooksLikeGcpList(flight::BytesOf(head));
}

}  // namespace

ReadControlResult ReadControl(const std::vector<flight::InputFile>& files) {
  ReadControlResult result;
  for (const flight::InputFile& file : files) {
    if (!HoldsControl(file)) continue;
    const Result<flight::GcpList> list = flight::ReadGcpList(file);
    if (!list) {
      result.warnings.push_back(
          fmt::format("the ground control points of {} are not used: {}", file.name, list.error().message));
      continue;
    }
    result.warnings.insert(result.warnings.end(), list->warnings.begin(), list->warnings.end());
    const std::size_t first = result.points.size();
    for (const flight::GcpPoint& point : list->points) {
      alignment::ControlPoint control;
      control.name = point.name;
      control.position = point.position;
      control.height_m = point.height_m;
      result.points.push_back(std::move(control));
    }
    for (const flight::GcpSighting& sighting : list->sightings) {
      // The format counts from the corner of the first pixel, we from its middle.
      result.points[first + sighting.point].sightings.push_back(
          {sighting.image_name, {sighting.pixel_x - 0.5, sighting.pixel_y - 0.5}});
    }
  }
  return result;
}

}  // namespace skyquilt::pipeline
