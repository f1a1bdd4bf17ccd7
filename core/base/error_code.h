// The closed list of error kinds. Every Error carries one; the API maps each to an HTTP status
// (api/http/responses.cc), and a test walks this list to see that none was forgotten. Any thread.
#pragma once

#include <array>
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
  kInternal,        // a defect of this program
};

inline constexpr std::array kAllErrorCodes = {
    ErrorCode::kInvalidArgument,
    ErrorCode::kUnprocessable,
    ErrorCode::kUnsupportedFormat,
    ErrorCode::kCorrupt,
    ErrorCode::kNoPosition,
    ErrorCode::kNotFound,
    ErrorCode::kConflict,
    ErrorCode::kPreconditionFailed,
    ErrorCode::kTooLarge,
    ErrorCode::kOutOfSpace,
    ErrorCode::kUnauthorized,
    ErrorCode::kForbidden,
    ErrorCode::kMethodNotAllowed,
    ErrorCode::kNotAcceptable,
    ErrorCode::kLengthRequired,
    ErrorCode::kRangeNotSatisfiable,
    ErrorCode::kDigestMismatch,
    ErrorCode::kRateLimited,
    ErrorCode::kTimeout,
    ErrorCode::kCancelled,
    ErrorCode::kUnavailable,
    ErrorCode::kNotImplemented,
    ErrorCode::kIo,
    ErrorCode::kInternal,
};

// A stable lower-case word for machines, e.g. "no_position".
std::string_view ErrorCodeName(ErrorCode code);

}  // namespace skyquilt
