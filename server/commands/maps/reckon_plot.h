// ReckoningSvg: a reckoning as a picture: displacement, rotation and drift of every interval by both rules
// beside the record, and the drift over fixed windows. Pure.
#pragma once

#include <string>

#include "core/poses/reckoning/reckon.h"

namespace skyquilt::server {

std::string ReckoningSvg(const poses::Reckoning& reckoning, const std::string& title);

}  // namespace skyquilt::server
