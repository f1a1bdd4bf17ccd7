// RequestHead: the first lines of a request, and HeadParser, which reads one from the bytes received so far.
// It refuses what is not HTTP, is ambiguous or not for this server as early as possible, and checks what the
// HTTP library omits (Boost 1.74 accepts no Host, two Hosts, unknown transfer codings, folded headers and
// 8-bit targets). Touches no socket and never waits; one thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "api/http/http_message.h"
#include "server/routing/http_settings.h"

namespace boost::beast::http {
struct buffer_body;
template <bool, class, class>
class parser;
}  // namespace boost::beast::http

namespace skyquilt::server {

// Why a request is refused, as a status and a sentence.
struct Refusal {
  int status = 400;
  std::string reason;
};

// What the rest of the server goes by.
struct RequestHead {
  std::string method;  // as sent
  std::string target;  // origin form
  int version = 11;    // 10 or 11
  api::Headers headers;
  std::string host;
  bool is_chunked = false;
  std::optional<std::uint64_t> content_length;
  bool wants_continue = false;
};

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
