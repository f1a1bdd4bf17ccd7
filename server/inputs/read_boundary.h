// ReadBoundary: the area that a map or an export is cut to, from a file that the user names. Exits with a
// message that names the file where it cannot be used.
#pragma once

#include <filesystem>

#include "core/geo/boundary.h"

namespace skyquilt::server {

geo::Boundary ReadBoundary(const char* command, const std::filesystem::path& file);

}  // namespace skyquilt::server
