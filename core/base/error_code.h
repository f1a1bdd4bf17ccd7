// The closed list of error kinds. Every Error carries one; the API maps each to an HTTP status
// (api/http/responses.cc), and a test walks this list to see that none was forgotten. Any thread.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

namespace skyquilt {

enum class ErrorCode {
  kInvalidArgument,    // a value the caller gave is outside its rule
  kUnprocessable,      // well-formed, but it cannot be worked on (a flight without usable photos)
  kUnsupportedFormat,  // bytes of a kind we do not read
  kCorrupt,            // bytes of a kind we read, but damaged
  kNoPosition,         // a photo that cannot be placed on the ground
  kNotFound,
  kConflict,            // the thing exists already, or its state forbids the act
  kPreconditionFailed,  // If-Match and its kin
  kTooLarge,
  kOutOfSpace,
  kUnauthorized,
  kForbidden,
  kMethodNotAllowed,
  kNotAcceptable,
  kLengthRequired,
  kRangeNotSatisfiable,
  kDigestMismatch,
  kRateLimited,
  kTimeout,
  kCancelled,
  kUnavailable,     // try again later
  kNotImplemented,  // a protocol feature that is not offered
  kIo,              // the machine failed to read or write
  kInternal,        // a defect of this program; stays the last
};

inline constexpr auto kAllErrorCodes = [] {
  std::array<ErrorCode, static_cast<std::size_t>(ErrorCode::kInternal) + 1> all{};
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<ErrorCode>(i);
  return all;
}();

// A stable lower-case word for machines, e.g. "no_position".
std::string_view ErrorCodeName(ErrorCode code);

}  // namespace skyquilt
