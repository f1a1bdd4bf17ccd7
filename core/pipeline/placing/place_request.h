// PlaceRequest: what a user knows of where a finished map lies: a place with scale and north, surveyed
// points, or where things that the map shows really are. A value; any thread.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/flight/logs/texts/gcp_list.h"
#include "core/geo/lat_lon.h"

namespace skyquilt::pipeline {

// Something that the map shows at one place, and that is at another.
struct ShownPair {
  geo::LatLon shown, is;
};

struct PlaceRequest {
  // Of the take-off where the flight was reckoned from it, else of the middle of the photos, or of where
  // `origin_photo` was taken.
  std::optional<geo::LatLon> origin;
  std::string origin_photo;
  std::optional<double> photo_pixel_m;  // ground that a photo's pixel shows, in the median
  std::optional<double> factor;         // the map is to become so many times larger; not with photo_pixel_m
  // The direction on the map as it is that is north, clockwise from its top; nothing: its top, so far.
  std::optional<double> north_deg;
  std::vector<flight::GcpList> control;  // instead of all above
  std::vector<ShownPair> pairs;          // instead of all above
  bool is_by_lists = false;              // instead of all above: by the surveyed points among the files
  bool is_again = false;                 // also a map that has its place
};

}  // namespace skyquilt::pipeline
