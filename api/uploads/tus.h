// tus 1.0 at /api/v1/uploads: resumable uploads of one file each, with the extensions creation,
// creation-with-upload, creation-defer-length, expiration, checksum, termination and concatenation. The
// metadata name the flight ("flight") and the file ("filename"). https://tus.io/protocols/resumable-upload
#pragma once

#include "api/http/router.h"
#include "api/service.h"

namespace skyquilt::api {

void AddTusRoutes(Router& router, Service& service);

}  // namespace skyquilt::api
