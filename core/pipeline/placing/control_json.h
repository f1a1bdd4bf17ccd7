// ControlJson: a list of surveyed points and their marks as the API's JSON (api/openapi.json, ControlPoints).
// Pixels count from the middle of the first one there, from its corner in the list. Pure; any thread.
#pragma once

#include <string>

#include "core/flight/logs/texts/gcp_list.h"

namespace skyquilt::pipeline {

std::string ControlJson(const flight::GcpList& list);

}  // namespace skyquilt::pipeline
