#include "api/build_api.h"

#include "api/auth/flight_access.h"
#include "api/routes.h"

namespace skyquilt::api {

Router BuildApi(Service& service) {
  Router router;
  for (AddRoutes* const add :
       {AddOpsRoutes,       AddDocsRoute,        AddBasemapRoutes,    AddOwnAccessRoute,
        AddNetworkRoute,    AddEventRoutes,      AddWebhookRoutes,    AddFlightRoutes,
        AddVerdictRoute,    AddTrashRoutes,      AddShareRoutes,      AddControlRoutes,
        AddNotesRoutes,     AddFileRoutes,       AddMultipartRoutes,  AddTusRoutes,
        AddJobRoutes,       AddLocateRoutes,     AddPointRoute,       AddHeightsRoute,
        AddStatisticsRoute, AddIndexRoutes,      AddDownloadRoutes,   AddOriginalFileRoutes,
        AddExportRoutes,    AddTileRoutes,       AddTerrainRoutes,    AddChangeRoutes,
        AddVolumeRoute,     AddTileJsonRoute,    AddTmsRoutes,        AddWmtsRoutes,
        AddWmsRoutes,       AddOgcRoutes,        AddMapRoutes,        AddFeatureRoutes,
        AddProcessRoutes,   AddArcgisRoutes,     AddStacRoutes,       AddConnectRoutes,
        AddNodeRoutes,      AddNodeChangeRoutes, AddNodeUploadRoutes, AddNodeArchiveRoute})
    add(router, service);
  router.PutBefore([&service](const Request& request, const Route& route) {
    return CheckFlightAccess(service, request, route);
  });
  return router;
}

}  // namespace skyquilt::api
