#include "core/base/error_code.h"

#include <algorithm>

#include "core/base/check.h"

namespace skyquilt {
namespace {

struct NamedCode {
  ErrorCode code;
  std::string_view name;
};
constexpr std::array kNamedCodes = {
    NamedCode{ErrorCode::kInvalidArgument, "invalid_argument"},
    NamedCode{ErrorCode::kUnprocessable, "unprocessable"},
    NamedCode{ErrorCode::kUnsupportedFormat, "unsupported_format"},
    NamedCode{ErrorCode::kCorrupt, "corrupt"},
    NamedCode{ErrorCode::kNoPosition, "no_position"},
    NamedCode{ErrorCode::kNotFound, "not_found"},
    NamedCode{ErrorCode::kConflict, "conflict"},
    NamedCode{ErrorCode::kPreconditionFailed, "precondition_failed"},
    NamedCode{ErrorCode::kTooLarge, "too_large"},
    NamedCode{ErrorCode::kOutOfSpace, "out_of_space"},
    NamedCode{ErrorCode::kUnauthorized, "unauthorized"},
    NamedCode{ErrorCode::kForbidden, "forbidden"},
    NamedCode{ErrorCode::kMethodNotAllowed, "method_not_allowed"},
    NamedCode{ErrorCode::kNotAcceptable, "not_acceptable"},
    NamedCode{ErrorCode::kLengthRequired, "length_required"},
    NamedCode{ErrorCode::kRangeNotSatisfiable, "range_not_satisfiable"},
    NamedCode{ErrorCode::kDigestMismatch, "digest_mismatch"},
    NamedCode{ErrorCode::kRateLimited, "rate_limited"},
    NamedCode{ErrorCode::kTimeout, "timeout"},
    NamedCode{ErrorCode::kCancelled, "cancelled"},
    NamedCode{ErrorCode::kUnavailable, "unavailable"},
    NamedCode{ErrorCode::kNotImplemented, "not_implemented"},
    NamedCode{ErrorCode::kIo, "io"},
    NamedCode{ErrorCode::kInternal, "internal"},
};
static_assert(std::equal(kNamedCodes.begin(), kNamedCodes.end(), kAllErrorCodes.begin(), kAllErrorCodes.end(),
                         [](const NamedCode& named, ErrorCode code) { return named.code == code; }));

}  // namespace

std::string_view ErrorCodeName(ErrorCode code) {
  const auto* const known = std::find_if(kNamedCodes.begin(), kNamedCodes.end(),
                                         [&](const NamedCode& one) { return one.code == code; });
  SKYQUILT_CHECK(known != kNamedCodes.end(), "error code outside the closed list");
  return known->name;
}

}  // namespace skyquilt
