// CommonErrorOf: what the recorded positions of one flight have in common: of which kind they are, and how
// far off all of them lie together, which no comparison among them can show. Assumed, one sigma a horizontal
// axis: 1.5 m without corrections (consumer receivers are off by 1 to 3 m for minutes to hours), what the
// records state of themselves where they do, and 0.02 m with corrections (RTK, PPK; base and antenna). Pure.
#pragma once

#include <vector>

#include "core/flight/photo.h"

namespace skyquilt::flight {
struct CameraEvent;
struct GnssSample;
}  // namespace skyquilt::flight

namespace skyquilt::poses {

inline constexpr double kWorstCorrectedM = 0.1;  // what says it is worse has no corrections

struct CommonError {
  bool is_corrected = false;              // RTK or PPK
  double sigma_m = flight::kPlainSigmaM;  // of each horizontal axis

  bool operator==(const CommonError&) const = default;
};

// What a receiver says of a bad fix is common to all positions for the most part: beyond this they still lie
// to each other as good ones do.
inline constexpr double kWorstPlainM = 15.0;

// Times what positions claim of themselves: what errs by more is something else than it claims to be.
inline constexpr double kFalseClaim = 4.0;

// Of one row of a list: it says so in a word, or states centimetres.
bool IsCorrected(const flight::CameraEvent& event);

// The error of a row of a list, one sigma a horizontal axis: as stated, else as assumed.
double SigmaOfRowM(const flight::CameraEvent& event);

CommonError CommonErrorOf(const std::vector<const flight::RecordedPosition*>& positions);
CommonError CommonErrorOf(const std::vector<flight::GnssSample>& samples);

}  // namespace skyquilt::poses
