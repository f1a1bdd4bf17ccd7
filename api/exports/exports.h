// Exports: a finished map as somebody wants it (format, coordinate system, area, resolution), made beside the
// requests and kept for a day. Who may read a flight may have its map exported; an export is deleted by who
// asked for it, and by who may change the flight.
#pragma once

#include "api/service.h"
#include "core/base/result.h"

namespace skyquilt::api {

// Those whose day is over, with their files. How many there were.
Result<int> RemoveExpiredExports(Service& service);

}  // namespace skyquilt::api
