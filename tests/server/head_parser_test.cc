// However the bytes of a head were cut on their way, it means the same.
#include <gtest/gtest.h>

#include <string>

#include "server/routing/request_head.h"

namespace skyquilt::server {
namespace {

HeadState InPieces(const std::string& head, std::size_t step) {
  static const HttpSettings settings;
  HeadParser parser(settings);
  for (std::size_t end = step; end < head.size(); end += step) {
    const HeadState state = parser.Examine(std::string_view(head).substr(0, end));
    if (state != HeadState::kNeedsMore) return state;
  }
  return parser.Examine(head);
}

TEST(HeadParser, MeansTheSameHoweverTheBytesWereCut) {
  const std::string fields = "Host: localhost\r\nContent-Length: 3\r\n\r\n";
  const struct {
    std::string head;
    HeadState state;
  } cases[] = {
      {"GET /a?b=1 HTTP/1.1\r\n" + fields, HeadState::kWhole},
      {"GET /a HTTP/1.1\r\nHost: localhost\r\n", HeadState::kNeedsMore},
      {"GET /a HTTP/1.1\r\r\n" + fields, HeadState::kRefused},
      {"GET /a HTTP/1.1\r\r\nHost: localhost\r\n", HeadState::kRefused},
      {"GET /a HTTP/1.1\n" + fields, HeadState::kRefused},
      {"GET /\x01 HTTP/1.1\r\n" + fields, HeadState::kRefused},
      {"GET /a HTTP/1.1\r\nX: a\r\n b\r\n" + fields, HeadState::kRefused},
  };
  for (const auto& [head, state] : cases) {
    for (std::size_t step = 1; step <= head.size(); ++step) {
      EXPECT_EQ(InPieces(head, step), state) << testing::PrintToString(head) << " in steps of " << step;
    }
  }
}

}  // namespace
}  // namespace skyquilt::server
