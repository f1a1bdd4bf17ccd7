#include "api/build_api.h"

#include "api/downloads/downloads.h"
#include "api/flights/flights.h"
#include "api/flights/verdict.h"
#include "api/jobs/jobs.h"
#include "api/ops/ops.h"
#include "api/tiles/tiles.h"
#include "api/uploads/files.h"

namespace skyquilt::api {

Router BuildApi(Service& service) {
  Router router;
  AddOpsRoutes(router, service);
  AddFlightRoutes(router, service);
  AddVerdictRoute(router, service);
  AddFileRoutes(router, service);
  AddMultipartRoutes(router, service);
  AddJobRoutes(router, service);
  AddDownloadRoutes(router, service);
  AddTileRoutes(router, service);
  AddTileJsonRoute(router, service);
  return router;
}

}  // namespace skyquilt::api
