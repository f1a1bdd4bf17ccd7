// Request heads: no crash, what is taken is unambiguous, and how the bytes were cut changes nothing.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "core/base/check.h"
#include "server/routing/request_head.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace skyquilt::server;
  static const HttpSettings settings;
  const std::string_view text(reinterpret_cast<const char*>(bytes), size);
  HeadParser whole(settings);
  const HeadState state = whole.Examine(text);
  if (state == HeadState::kWhole) {
    SKYQUILT_CHECK(whole.size() <= text.size(), "the head is longer than what came");
    SKYQUILT_CHECK(whole.head().target.starts_with('/') || whole.head().target == "*", "a target of no form");
    SKYQUILT_CHECK(!(whole.head().is_chunked && whole.head().content_length), "a body of two lengths");
  }
  HeadParser in_pieces(settings);
  HeadState last = HeadState::kNeedsMore;
  for (std::size_t end = 1; end <= text.size() && last == HeadState::kNeedsMore; end += 1 + end / 8) {
    last = in_pieces.Examine(text.substr(0, end));
  }
  if (last == HeadState::kNeedsMore) last = in_pieces.Examine(text);
  SKYQUILT_CHECK(last == state, "the cuts decide what a head is");
  if (state == HeadState::kWhole)
    SKYQUILT_CHECK(in_pieces.head().target == whole.head().target, "another target");
  return 0;
}
