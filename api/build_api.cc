#include "api/build_api.h"

#include "api/arcgis/arcgis.h"
#include "api/auth/flight_access.h"
#include "api/auth/own_access.h"
#include "api/basemap/basemap.h"
#include "api/common/locate.h"
#include "api/connect/connect.h"
#include "api/control/control.h"
#include "api/downloads/downloads.h"
#include "api/downloads/original_file.h"
#include "api/events/events.h"
#include "api/exports/exports.h"
#include "api/flights/flights.h"
#include "api/flights/heights.h"
#include "api/flights/point.h"
#include "api/flights/statistics.h"
#include "api/flights/trash.h"
#include "api/flights/verdict.h"
#include "api/indices/indices.h"
#include "api/jobs/jobs.h"
#include "api/maps/maps.h"
#include "api/nodeodm/nodeodm.h"
#include "api/notes/notes.h"
#include "api/ogc/features.h"
#include "api/ogc/ogc.h"
#include "api/ogc/processes.h"
#include "api/ops/ops.h"
#include "api/shares/open_network.h"
#include "api/shares/shares.h"
#include "api/stac/stac.h"
#include "api/surface/change.h"
#include "api/surface/terrain.h"
#include "api/surface/volume.h"
#include "api/tilejson/tilejson.h"
#include "api/tiles/tiles.h"
#include "api/tms/tms.h"
#include "api/uploads/files.h"
#include "api/uploads/tus.h"
#include "api/webhooks/webhooks.h"
#include "api/wms/wms.h"
#include "api/wmts/wmts.h"

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
