// Geolocation CSV of Pix4D: "image,latitude,longitude,height[,yaw,pitch,roll | omega,phi,kappa][,accH,accV]",
// with a header line (with or without #) or none; coordinates of a projected system stand east first, as
// "image,x,y,z". The header's order of the two counts, and angles are used only where it names them: without
// one, yaw-pitch-roll and omega-phi-kappa look alike and are left out with a warning. What the rows say is
// kept as written; which reading of it is true, core/poses/lists judges. Rows become camera events without a
// time. Fails with kCorrupt when no row could be read. Any thread.
#pragma once

#include "core/base/result.h"
#include "core/flight/bytes/log_bytes.h"
#include "core/flight/logs/flight_log.h"

namespace skyquilt::flight {

bool LooksLikePix4dCsv(LogBytes head);

Result<FlightLog> ParsePix4dCsv(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed = {});

}  // namespace skyquilt::flight
