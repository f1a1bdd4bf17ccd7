// Events as they happen, by Server-Sent Events (the HTML standard, 9.2): GET /api/v1/events, of all flights,
// one flight or one job. Every event has its number as its id: a client that comes back with Last-Event-ID
// gets what it missed. Between them, progress of running jobs, which is not replayed.
#pragma once

#include "api/http/router.h"
#include "api/service.h"

namespace skyquilt::api {

void AddEventRoutes(Router& router, Service& service);

}  // namespace skyquilt::api
