// Flight: all that was read, in the order of capture. Value of the first stage, input of estimate_poses.
#pragma once

#include <string>
#include <vector>

#include "core/flight/photo.h"

namespace skyquilt::flight {

struct Flight {
  std::vector<Photo> photos;           // readable photos, by time of capture, then by name
  std::vector<LeftOutPhoto> left_out;  // by name
  std::vector<std::string> warnings;   // about the flight as a whole
};

}  // namespace skyquilt::flight
