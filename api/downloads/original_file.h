// The user's own files: a photo as it was uploaded is shown in the browser where possible; any other file is
// sent as a download only, so that nothing uploaded runs as part of the page.
#pragma once

#include "api/http/router.h"
#include "api/service.h"

namespace skyquilt::api {

void AddOriginalFileRoutes(Router& router, Service& service);

}  // namespace skyquilt::api
