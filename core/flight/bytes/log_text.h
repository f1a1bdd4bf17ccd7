// LogText: the bytes of a text log as UTF-8, whatever it was saved as. UTF-16 of either order is decoded, by
// its byte-order mark or, without one, where every second byte of its beginning is zero; all other bytes,
// binary logs too, are passed on as they are, but for a byte-order mark of UTF-8. A decoded log is held in
// memory: 64 MiB of UTF-16 at most (96 MiB decoded), a longer one is refused with advice. Half of a pair
// becomes U+FFFD. Any thread; the bytes given must outlive it.
#pragma once

#include <string>
#include <string_view>

#include "core/base/result.h"
#include "core/flight/bytes/log_bytes.h"

namespace skyquilt::flight {

class LogText {
 public:
  // Error: kUnsupportedFormat for UTF-16 beyond the bound.
  static Result<LogText> Of(std::string_view name, LogBytes bytes);

  LogBytes bytes() const { return is_decoded_ ? BytesOf(decoded_) : raw_; }
  bool is_decoded() const { return is_decoded_; }

 private:
  LogBytes raw_;
  std::string decoded_;
  bool is_decoded_ = false;
};

}  // namespace skyquilt::flight
