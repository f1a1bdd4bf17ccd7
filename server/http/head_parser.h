// HeadParser: parses one request head from the bytes received so far. Refuses what is not HTTP, is ambiguous
// or not for this server as early as possible. Touches no socket and never waits; one thread.
#pragma once

#include <cstddef>
#include <memory>
#include <string_view>

#include "server/routing/http_settings.h"
#include "server/routing/request_head.h"

namespace boost::beast::http {
struct buffer_body;
template <bool, class, class>
class parser;
}  // namespace boost::beast::http

namespace skyquilt::server {

// Beast's, which goes on with the body.
using RequestParser = boost::beast::http::parser<true, boost::beast::http::buffer_body, std::allocator<char>>;

enum class HeadState { kNeedsMore, kWhole, kRefused };

class HeadParser {
 public:
  explicit HeadParser(const HttpSettings& settings);
  ~HeadParser();

  // `bytes`: all that has come of this head, which grows from call to call.
  HeadState Examine(std::string_view bytes);

  // After kWhole: the head, how many bytes it took, and the parser of what follows it.
  RequestHead& head() { return head_; }
  std::size_t size() const { return size_; }
  std::unique_ptr<RequestParser> TakeParser();
  // After kRefused.
  const Refusal& refusal() const { return refusal_; }

 private:
  HeadState Parse(std::string_view head_with_end);
  HeadState Refuse(Refusal refusal);

  const HttpSettings& settings_;
  std::size_t searched_ = 0;
  std::size_t size_ = 0;
  std::unique_ptr<RequestParser> parser_;
  RequestHead head_;
  Refusal refusal_;
};

}  // namespace skyquilt::server
