#include "core/poses/lists/own_records.h"

#include <algorithm>
#include <map>
#include <string>
#include <tuple>

#include "core/poses/evidence/records_apart.h"
#include "core/poses/heights/flight_heights.h"

namespace skyquilt::poses {
namespace {

using flight::FlightLog;
using geo::LatLon;

using CameraPlace = std::tuple<std::string, double, double>;

CameraPlace CameraPlaceOf(const flight::Photo& photo) {
  return {photo.camera_key, photo.position->position.lat_deg, photo.position->position.lon_deg};
}

std::optional<LatLon> PlaceOfTracks(const std::vector<FlightLog>& logs) {
  for (const FlightLog& log : logs) {
    if (!log.gnss.empty()) return log.gnss[log.gnss.size() / 2].position;
  }
  return std::nullopt;
}

}  // namespace

OwnRecords OwnRecordsOf(const std::vector<flight::Photo>& photos, const std::vector<FlightLog>& logs) {
  std::map<CameraPlace, int> at_place;
  for (const flight::Photo& photo : photos) {
    if (photo.position) ++at_place[CameraPlaceOf(photo)];
  }
  OwnRecords own;
  std::vector<LatLon> moving, shared;
  for (const flight::Photo& photo : photos) {
    std::optional<LatLon>& place = own.moving.emplace_back();
    if (!photo.position) continue;
    const LatLon& at = photo.position->position;
    if (at_place[CameraPlaceOf(photo)] > kMaxAtOnePlace) {
      shared.push_back(at);
      continue;
    }
    place = at;
    moving.push_back(at);
  }
  if (moving.size() < shared.size()) {  // the few that differ may be of before it was lost
    own.is_stale = true;
    std::fill(own.moving.begin(), own.moving.end(), std::nullopt);
    own.anywhere = shared.front();
  } else {
    own.anywhere = MedianPosition(moving);
  }
  own.is_of_photos = own.anywhere.has_value();
  if (!own.anywhere || own.is_stale) {
    if (const auto track = PlaceOfTracks(logs)) {
      own.anywhere = track;
      own.is_stale = false;
      own.is_of_photos = false;
    }
  }
  return own;
}

}  // namespace skyquilt::poses
