// The beginning of a tus upload: of a whole file, of a part of one, or of a file out of its parts.
#pragma once

#include "api/uploads/tus_answers.h"

namespace skyquilt::api {

TusBegun BeginTusCreation(Service& service, const Request& request);

}  // namespace skyquilt::api
