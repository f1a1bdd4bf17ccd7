// BuildApi: every route of the server in one list. The service must outlive the router.
#pragma once

#include "api/http/router.h"
#include "api/service.h"

namespace skyquilt::api {

Router BuildApi(Service& service);

}  // namespace skyquilt::api
