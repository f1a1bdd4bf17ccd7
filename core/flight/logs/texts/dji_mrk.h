// Exposure logs of DJI and Autel RTK cameras (.MRK): one tab-separated row an exposure, GPS week and time of
// week, the position of the image sensor (the offset from the antenna is already applied), sigma north, east,
// down, and a flag (16 single, 34 float, 50 fixed). Rows become camera events with their sequence number; t_s
// = 0 is the first row. Rows of another GPS week or damaged rows are counted. Fails with kCorrupt when no row
// could be read. Any thread.
#pragma once

#include "core/base/result.h"
#include "core/flight/bytes/log_bytes.h"
#include "core/flight/logs/flight_log.h"

namespace skyquilt::flight {

bool LooksLikeDjiMrk(LogBytes head);

Result<FlightLog> ParseDjiMrk(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed = {});

}  // namespace skyquilt::flight
