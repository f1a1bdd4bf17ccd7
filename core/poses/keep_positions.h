// KeepPositions: corrected positions of photos (RTK, PPK) come before the track of a plain receiver, whose
// log lends them what they do not say: how they were turned (gimbal, else airframe), how high above take-off
// and how fast (east, north, up) they were. Changes the tie: photos that stand by themselves leave it. Pure.
#pragma once

#include "core/flight/logs/flight_log.h"
#include "core/poses/time/tie_to_log.h"

namespace skyquilt::poses {

// Most photos that the track of a plain receiver would place have corrected positions: their own, a list's,
// or those of camera events.
bool AreSurveyedBesideTrack(const flight::FlightLog& log, const LogTie& tie);

// Photos without a position stay on the track.
void KeepPositions(const flight::FlightLog& log, LogTie& tie);

}  // namespace skyquilt::poses
