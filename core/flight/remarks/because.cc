#include "core/flight/remarks/because.h"

#include <memory>
#include <utility>

#include "core/flight/remarks/remark_words.h"

namespace skyquilt::flight {

Error Because(ErrorCode code, Remark reason, std::string detail) {
  std::string message = InWords(reason);
  return {code, std::move(message), std::move(detail), std::make_shared<const Remark>(std::move(reason))};
}

Remark WhyOf(const Error& error) {
  if (error.reason != nullptr) return *error.reason;
  if (error.code == ErrorCode::kOutOfSpace) return RemarkCode::kFailDiskFull;
  if (error.code == ErrorCode::kCancelled) return RemarkCode::kFailCancelled;
  return Remark(error.message);
}

bool HasReason(const Error& error) { return WhyOf(error).code != RemarkCode::kText; }

}  // namespace skyquilt::flight
