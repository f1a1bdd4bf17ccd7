// The user's own files back: a photo as it was uploaded, shown in the browser where it can be; anything else
// only for saving, so that nothing uploaded runs as part of the page.
#pragma once

#include "api/http/router.h"
#include "api/service.h"

namespace skyquilt::api {

void AddOriginalFileRoutes(Router& router, Service& service);

}  // namespace skyquilt::api
