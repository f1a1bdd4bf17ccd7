// Subtitles that the cameras of DJI and Autel write beside a film: SubRip (.SRT) and Advanced SubStation
// Alpha
// (.ASS); cue_text.h says what is read of their words. Fixes become GNSS samples whose sigma follows the
// digits written; the camera's clock is kept as local_at_zero. t_s is the time in the film; where the clock
// runs ahead of it (a time lapse, films joined) t_s follows the clock, but for ParseFilmSubtitles. Any
// thread. Fails with kCorrupt for a file without subtitles, kNoPosition when none holds a position.
#pragma once

#include "core/base/result.h"
#include "core/flight/bytes/log_bytes.h"
#include "core/flight/logs/flight_log.h"

namespace skyquilt::flight {

bool LooksLikeDjiSrt(LogBytes head);
bool LooksLikeAss(LogBytes head);

Result<FlightLog> ParseDjiSrt(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed = {});
Result<FlightLog> ParseAss(std::string_view name, LogBytes bytes, const ConsumedUpTo& consumed = {});

// Either of them, in the time of the film.
Result<FlightLog> ParseFilmSubtitles(std::string_view name, LogBytes bytes);

}  // namespace skyquilt::flight
