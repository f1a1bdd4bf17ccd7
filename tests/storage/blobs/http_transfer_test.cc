#include "storage/blobs/s3/http_transfer.h"

#include <gtest/gtest.h>

#include "tests/storage/blobs/scripted_server.h"

namespace skyquilt::storage {
namespace {

using test::HttpText;
using test::ScriptedServer;

HttpExchange To(const ScriptedServer& server, const char* method) {
  HttpExchange exchange;
  exchange.method = method;
  exchange.url = server.Endpoint() + "/a/../b";
  exchange.stall_patience = std::chrono::seconds(2);
  return exchange;
}

TEST(HttpTransfers, SendsWhatWasSaidAndReadsTheAnswer) {
  const ScriptedServer server(
      [](int, const std::string&) { return HttpText(200, "body", "X-Some-Name:  a value \r\n"); });
  HttpTransfers transfers;
  HttpExchange exchange = To(server, "PUT");
  exchange.body = "what is sent";
  exchange.headers = {{"X-One", "1"}};
  const auto answer = transfers.Perform(exchange);
  ASSERT_TRUE(answer) << answer.error().detail;
  EXPECT_EQ(answer->body, "body");
  EXPECT_EQ(answer->Header("x-some-name"), "a value");
  const std::string request = server.requests().at(0);
  EXPECT_TRUE(request.starts_with("PUT /a/../b HTTP/1.1")) << request;  // as it was signed
  EXPECT_NE(request.find("X-One: 1"), std::string::npos);
  EXPECT_TRUE(request.ends_with("\r\n\r\nwhat is sent"));
}

TEST(HttpTransfers, GivesTheBodyOfAGoodAnswerToItsReceiverAndThatOfABadOneToTheCaller) {
  const ScriptedServer server([](int n, const std::string&) { return HttpText(n == 0 ? 200 : 404, "body"); });
  HttpTransfers transfers;
  std::string taken;
  HttpExchange exchange = To(server, "GET");
  exchange.take = [&](std::string_view came) -> Result<void> {
    taken += came;
    return {};
  };
  EXPECT_EQ(transfers.Perform(exchange)->body, "");
  EXPECT_EQ(taken, "body");
  EXPECT_EQ(transfers.Perform(exchange)->body, "body");
  EXPECT_EQ(taken, "body");
}

TEST(HttpTransfers, ReportsWhatBrokeOffStalledOrWasTooLong) {
  std::atomic<bool> has_given_up = false;
  const ScriptedServer server([&](int n, const std::string&) -> std::string {
    if (n == 0) return "";
    if (n == 1) return HttpText(200, "0123456789").substr(0, 60);
    for (int i = 0; n == 3 && i < 6'000 && !has_given_up; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return HttpText(200, std::string(1000, 'x'));
  });
  HttpTransfers transfers;
  HttpExchange exchange = To(server, "GET");
  EXPECT_EQ(transfers.Perform(exchange).error().code, ErrorCode::kUnavailable);
  EXPECT_EQ(transfers.Perform(exchange).error().code, ErrorCode::kUnavailable);
  exchange.max_answer_bytes = 100;
  EXPECT_EQ(transfers.Perform(exchange).error().code, ErrorCode::kTooLarge);
  exchange.max_answer_bytes = 10'000;
  exchange.stall_patience = std::chrono::seconds(1);
  const auto stalled = transfers.Perform(exchange);
  has_given_up = true;
  ASSERT_FALSE(stalled) << "it waited until there was an answer";
  EXPECT_EQ(stalled.error().code, ErrorCode::kUnavailable);
}

TEST(HttpTransfers, FollowsNoRedirect) {
  const ScriptedServer server(
      [](int, const std::string&) { return HttpText(307, "", "Location: http://127.0.0.1:1/\r\n"); });
  HttpTransfers transfers;
  EXPECT_EQ(transfers.Perform(To(server, "GET"))->status, 307);
  EXPECT_EQ(server.requests().size(), 1U);
}

}  // namespace
}  // namespace skyquilt::storage
