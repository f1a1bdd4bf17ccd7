#include "api/build_api.h"

#include "api/auth/flight_access.h"
#include "api/routes.h"

namespace skyquilt::api {

Router BuildApi(Service& service) {
  Router router;
  AddOpsRoutes(router, service);
  AddDocsRoute(router);
  AddBasemapRoutes(router, service.basemap);
  AddFlightRoutes(router, service);
  AddTrashRoutes(router, service);
  AddShareRoutes(router, service);
  AddNetworkRoute(router, service);
  AddOwnAccessRoute(router, service);
  AddVerdictRoute(router, service);
  AddLocateRoutes(router, service);
  AddPointRoute(router, service);
  AddHeightsRoute(router, service);
  AddStatisticsRoute(router, service);
  AddTerrainRoutes(router, service);
  AddChangeRoutes(router, service);
  AddVolumeRoute(router, service);
  AddIndexRoutes(router, service);
  AddControlRoutes(router, service);
  AddNotesRoutes(router, service);
  AddFileRoutes(router, service);
  AddMultipartRoutes(router, service);
  AddTusRoutes(router, service);
  AddJobRoutes(router, service);
  AddEventRoutes(router, service);
  AddWebhookRoutes(router, service);
  AddDownloadRoutes(router, service);
  AddOriginalFileRoutes(router, service);
  AddExportRoutes(router, service);
  AddTileRoutes(router, service);
  AddTileJsonRoute(router, service);
  AddTmsRoutes(router, service);
  AddWmtsRoutes(router, service);
  AddWmsRoutes(router, service);
  AddOgcRoutes(router, service);
  AddMapRoutes(router, service);
  AddFeatureRoutes(router, service);
  AddProcessRoutes(router, service);
  AddArcgisRoutes(router, service);
  AddStacRoutes(router, service);
  AddConnectRoutes(router, service);
  AddNodeRoutes(router, service);
  AddNodeChangeRoutes(router, service);
  AddNodeUploadRoutes(router, service);
  AddNodeArchiveRoute(router, service);
  router.PutBefore([&service](const Request& request, const Route& route) {
    return CheckFlightAccess(service, request, route);
  });
  return router;
}

}  // namespace skyquilt::api
