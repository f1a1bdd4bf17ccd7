// ReadControl: the ground control points among a flight's files (ODM's gcp_list format). None is not an
// error; a list that cannot be read becomes a warning. Blocking; any thread.
#pragma once

#include <string>
#include <vector>

#include "core/alignment/ground_control.h"
#include "core/flight/read_flight.h"

namespace skyquilt::pipeline {

struct ReadControlResult {
  std::vector<alignment::ControlPoint> points;
  std::vector<std::string> warnings;
};

ReadControlResult ReadControl(const std::vector<flight::InputFile>& files);

}  // namespace skyquilt::pipeline
