// What each room answers, as it adds it to the router; BuildApi calls all of them. What a room's routes are
// is said at the head of the file that defines them, or of its header. The service must outlive the router.
#pragma once

#include "api/http/router.h"
#include "api/service.h"

namespace skyquilt::api {

using AddRoutes = void(Router& router, Service& service);

// The server itself.
AddRoutes AddOpsRoutes, AddDocsRoute, AddBasemapRoutes, AddOwnAccessRoute, AddNetworkRoute, AddEventRoutes,
    AddWebhookRoutes;

// Flights, their files and jobs.
AddRoutes AddFlightRoutes, AddVerdictRoute, AddTrashRoutes, AddShareRoutes, AddControlRoutes, AddNotesRoutes,
    AddFileRoutes, AddMultipartRoutes, AddTusRoutes, AddJobRoutes;

// What a finished map tells and gives away.
AddRoutes AddLocateRoutes, AddPointRoute, AddHeightsRoute, AddStatisticsRoute, AddIndexRoutes,
    AddDownloadRoutes, AddOriginalFileRoutes, AddExportRoutes, AddTileRoutes, AddTerrainRoutes,
    AddChangeRoutes, AddVolumeRoute;

// Maps by the standards of others.
AddRoutes AddTileJsonRoute, AddTmsRoutes, AddWmtsRoutes, AddWmsRoutes, AddOgcRoutes, AddMapRoutes,
    AddFeatureRoutes, AddProcessRoutes, AddArcgisRoutes, AddStacRoutes, AddConnectRoutes;

// The NodeODM-compatible node (api/nodeodm/nodeodm.h): questions (/info, /options, /task/...), changes
// (cancel, remove, restart), uploads (new, init, upload, commit) and all.zip.
AddRoutes AddNodeRoutes, AddNodeChangeRoutes, AddNodeUploadRoutes, AddNodeArchiveRoute;

}  // namespace skyquilt::api
