// What each room answers, as it adds it to the router; BuildApi calls all of them. What a room's routes are
// is said at the head of the file that defines them, or of its header. The service must outlive the router.
#pragma once

#include "api/http/router.h"
#include "api/service.h"

namespace skyquilt::api {

// The server itself.
void AddOpsRoutes(Router& router, Service& service);
void AddDocsRoute(Router& router);
void AddBasemapRoutes(Router& router, const Basemap& basemap);
void AddOwnAccessRoute(Router& router, Service& service);
void AddNetworkRoute(Router& router, Service& service);
void AddEventRoutes(Router& router, Service& service);
void AddWebhookRoutes(Router& router, Service& service);

// Flights, their files and jobs.
void AddFlightRoutes(Router& router, Service& service);
void AddVerdictRoute(Router& router, Service& service);
void AddTrashRoutes(Router& router, Service& service);
void AddShareRoutes(Router& router, Service& service);
void AddControlRoutes(Router& router, Service& service);
void AddNotesRoutes(Router& router, Service& service);
void AddFileRoutes(Router& router, Service& service);
void AddMultipartRoutes(Router& router, Service& service);
void AddTusRoutes(Router& router, Service& service);
void AddJobRoutes(Router& router, Service& service);

// What a finished map tells and gives away.
void AddLocateRoutes(Router& router, Service& service);
void AddPointRoute(Router& router, Service& service);
void AddHeightsRoute(Router& router, Service& service);
void AddStatisticsRoute(Router& router, Service& service);
void AddIndexRoutes(Router& router, Service& service);
void AddDownloadRoutes(Router& router, Service& service);
void AddOriginalFileRoutes(Router& router, Service& service);
void AddExportRoutes(Router& router, Service& service);
void AddTileRoutes(Router& router, Service& service);
void AddTerrainRoutes(Router& router, Service& service);
void AddChangeRoutes(Router& router, Service& service);
void AddVolumeRoute(Router& router, Service& service);

// Maps by the standards of others.
void AddTileJsonRoute(Router& router, Service& service);
void AddTmsRoutes(Router& router, Service& service);
void AddWmtsRoutes(Router& router, Service& service);
void AddWmsRoutes(Router& router, Service& service);
void AddOgcRoutes(Router& router, Service& service);
void AddMapRoutes(Router& router, Service& service);
void AddFeatureRoutes(Router& router, Service& service);
void AddProcessRoutes(Router& router, Service& service);
void AddArcgisRoutes(Router& router, Service& service);
void AddStacRoutes(Router& router, Service& service);
void AddConnectRoutes(Router& router, Service& service);

// The NodeODM-compatible node (api/nodeodm/nodeodm.h).
void AddNodeRoutes(Router& router, Service& service);        // questions: /info /options /task/...
void AddNodeChangeRoutes(Router& router, Service& service);  // cancel, remove, restart
void AddNodeUploadRoutes(Router& router, Service& service);  // new, init, upload, commit
void AddNodeArchiveRoute(Router& router, Service& service);  // all.zip

}  // namespace skyquilt::api
