// Geolocation CSV of Pix4D: "image,latitude,longitude,height[,yaw,pitch,roll | omega,phi,kappa][,accH,accV]",
// with a header line (with or without #) or none. Angles are used only where the header names them: without
// one, yaw-pitch- roll and omega-phi-kappa look alike and are left out with a warning. Rows become camera
// events without a time. Fails with kCorrupt when no row could be read. Any thread.
#pragma once

#include "core/base/result.h"
#include "core/flight/logs/flight_log.h"
#include "core/flight/logs/log_bytes.h"

namespace skyquilt::flight {

bool LooksLikePix4dCsv(LogBytes head);

Result<FlightLog> ParsePix4dCsv(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed = {});

}  // namespace skyquilt::flight
