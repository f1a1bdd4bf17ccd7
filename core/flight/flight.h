// Flight: all that was read, in the order of capture. Value of the first stage, input of estimate_poses.
#pragma once

#include <string>
#include <vector>

#include "core/flight/lists/list_use.h"
#include "core/flight/lists/reflectance_list.h"
#include "core/flight/logs/flight_log.h"
#include "core/flight/logs/texts/gcp_list.h"
#include "core/flight/photo.h"
#include "core/flight/remarks/remark.h"

namespace skyquilt::flight {

struct Flight {
  std::vector<Photo> photos;                       // readable photos, by time of capture, then by name
  std::vector<FlightLog> logs;                     // readable logs and lists of positions, by name
  std::vector<GcpList> gcp_lists;                  // by name
  std::vector<ListUse> list_uses;                  // what became of the lists, once they were compared
  std::vector<ReflectanceList> reflectance_lists;  // by name
  std::vector<std::string> elevation_models;       // names of the files; the first holds
  std::vector<std::string> films;                  // names; their frames are photos only where they are taken
  std::vector<LeftOutPhoto> left_out;              // by name
  std::vector<Remark> warnings;                    // about the flight as a whole
};

}  // namespace skyquilt::flight
