// The server over real sockets: HTTP as it is and is not spoken, and bodies that come in.
#include "server/http/http_server.h"

#include <gtest/gtest.h>

#include <atomic>

#include "api/http/responses.h"
#include "server/routing/request_log.h"
#include "tests/server/http_server_fixture.h"
#include "tests/storage/small_tileset.h"
#include "tests/support/value_of.h"

namespace skyquilt::server {
namespace {

TEST_F(HttpServerTest, AnswersOverOneConnectionAgainAndAgain) {
  Start();
  RawClient client(port());
  for (int i = 0; i < 3; ++i) EXPECT_EQ(client.Ask("GET /healthz HTTP/1.1\r\n" + kHost + "\r\n").status, 200);
}

// Else the log has the number of a failure and nobody knows of what.
TEST_F(HttpServerTest, TellsItsLogAloneWhatAFailureIsOf) {
  router_.Add(api::Method::kGet, "/api/v1/broken", [](const api::Request& request) {
    return api::Problem({ErrorCode::kIo, "The file could not be read.", "Input/output error"}, request);
  });
  Start();
  RawClient client(port());
  testing::internal::CaptureStderr();
  const RawAnswer answer = client.Ask("GET /api/v1/broken HTTP/1.1\r\n" + kHost + "\r\n");
  client.Ask("GET /healthz HTTP/1.1\r\n" + kHost + "\r\n");  // by then the other's line is written
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_EQ(answer.status, 500);
  EXPECT_EQ(answer.body.find("Input/output error"), std::string::npos);
  EXPECT_NE(log.find("Input/output error"), std::string::npos) << log;
}

TEST(RequestLog, HasAllThatAnErrorSays) {
  testing::internal::CaptureStderr();
  LogFailure("-", "exports", Error{ErrorCode::kIo, "cannot remove a file", ""});
  LogFailure("-", "claim", Error{ErrorCode::kIo, "The database could not be read.", "disk I/O error"});
  const std::string log = testing::internal::GetCapturedStderr();
  for (const char* said : {"cannot remove a file", "could not be read", "disk I/O error"})
    EXPECT_NE(log.find(said), std::string::npos) << said;
}

TEST_F(HttpServerTest, AnswersAThousandPipelinedRequests) {
  Start();
  RawClient client(port());
  std::string requests;
  for (int i = 0; i < 1000; ++i) requests += "GET /healthz HTTP/1.1\r\n" + kHost + "\r\n";
  std::thread sender([&] { client.Send(requests); });
  for (int i = 0; i < 1000; ++i) ASSERT_EQ(client.Receive().status, 200) << i;
  sender.join();
}

TEST_F(HttpServerTest, RefusesWhatIsNotGoodHttp) {
  Start();
  const std::string get = "GET /healthz HTTP/1.1\r\n";
  const std::pair<int, std::string> cases[] = {
      {400, get + "\r\n"},
      {400, get + kHost + kHost + "\r\n"},
      {400, get + "Host: a b\r\n\r\n"},
      {400, get + "Host: \r\n\r\n"},
      {400, get + "Host: [::1]evil.example\r\n\r\n"},
      {400, get + "Host: 127.0.0.1:99999999999\r\n\r\n"},
      {400, get + kHost + "X: a\r\n b\r\n\r\n"},
      {400, get + kHost + "X : a\r\n\r\n"},
      {400, "GET /healthz\xc3\xa6 HTTP/1.1\r\n" + kHost + "\r\n"},
      {400, "GET /a\x01 HTTP/1.1\r\n" + kHost + "\r\n"},
      {400, "GET /healthz HTTP/1.1\n" + kHost + "\r\n"},
      {400, "GET  /healthz HTTP/1.1\r\n" + kHost + "\r\n"},
      {400, "\x16\x03\x01 hello\r\n\r\n"},
      {400, get + kHost + "Content-Length: 1\r\nContent-Length: 1\r\n\r\nx"},
      {400, get + kHost + "Content-Length: 1\r\nContent-Length: 2\r\n\r\nx"},
      {400, get + kHost + "Content-Length: +1\r\n\r\nx"},
      {400, get + kHost + "Content-Length: -1\r\n\r\nx"},
      {400, get + kHost + "Content-Length: 1\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n"},
      {501, get + kHost + "Transfer-Encoding: xchunked\r\n\r\n"},
      {501, get + kHost + "Transfer-Encoding: identity, chunked\r\n\r\n0\r\n\r\n"},
      {505, "GET /healthz HTTP/3.7\r\n" + kHost + "\r\n"},
      {417, "PUT /healthz HTTP/1.1\r\n" + kHost + "Expect: a-miracle\r\n\r\n"},
      {501, "TRACE /healthz HTTP/1.1\r\n" + kHost + "\r\n"},
      {501, "BREW /healthz HTTP/1.1\r\n" + kHost + "\r\n"},
      {400, "CONNECT example.com:80 HTTP/1.1\r\n" + kHost + "\r\n"},
      {400, "GET http://other/healthz HTTP/1.1\r\n" + kHost + "\r\n"},
      {400, "GET /../etc/passwd HTTP/1.1\r\n" + kHost + "\r\n"},
      {400, "GET /%2e%2e/etc/passwd HTTP/1.1\r\n" + kHost + "\r\n"},
      {404, "GET /nothing HTTP/1.1\r\n" + kHost + "\r\n"},
      {405, "DELETE /healthz HTTP/1.1\r\n" + kHost + "\r\n"},
      {414, "GET /" + std::string(9000, 'a') + " HTTP/1.1\r\n" + kHost + "\r\n"},
      {431, get + kHost + "X: " + std::string(100000, 'a') + "\r\n\r\n"},
  };
  for (const auto& [status, request] : cases) {
    const RawAnswer answer = Ask(request);
    // Beast tells some of these apart less finely; what counts is that none is taken for a good request.
    EXPECT_EQ(answer.status, status) << testing::PrintToString(request.substr(0, 120));
    if (answer.status >= 400) {
      EXPECT_NE(answer.head.find("application/problem+json"), std::string::npos);
    }
  }
}

TEST_F(HttpServerTest, TakesTheAbsoluteFormAndHttp10) {
  Start();
  EXPECT_EQ(Ask("GET http://localhost/healthz HTTP/1.1\r\n" + kHost + "\r\n").status, 200);
  RawClient old(port());
  EXPECT_EQ(old.Ask("GET /healthz HTTP/1.0\r\n\r\n").status, 200);
  EXPECT_TRUE(old.IsClosed());
}

TEST_F(HttpServerTest, AnswersHeadLikeGetWithoutTheBody) {
  Start();
  RawClient client(port());
  const RawAnswer get = client.Ask("GET /version HTTP/1.1\r\n" + kHost + "\r\n");
  client.Send("HEAD /version HTTP/1.1\r\n" + kHost + "\r\n");
  const RawAnswer head = client.Receive(false);
  EXPECT_NE(get.head.find("Server-Timing: work;dur="), std::string::npos);
  const auto without_id_and_times = [](std::string text) {
    for (const char* name : {"Date: ", "X-Request-Id: ", "Server-Timing: "}) {
      const std::size_t at = text.find(name);
      text.erase(at, text.find("\r\n", at) - at);
    }
    return text;
  };
  EXPECT_EQ(without_id_and_times(head.head), without_id_and_times(get.head));
  EXPECT_EQ(client.Ask("GET /healthz HTTP/1.1\r\n" + kHost + "\r\n").status, 200);
}

TEST_F(HttpServerTest, LeadsFromAnAddressWithASlashBehindItToTheOneWithout) {
  Start();
  const RawAnswer led = Ask("GET /stac/?token=a HTTP/1.1\r\n" + kHost + "\r\n");
  EXPECT_EQ(led.status, 308);
  EXPECT_NE(led.head.find("Location: /stac?token=a"), std::string::npos) << led.head;
  for (const std::string line :
       {"GET /nothing/", "GET /stac//", "GET //stac/", "GET /../stac/", "POST /stac/"})
    EXPECT_EQ(Ask(line + " HTTP/1.1\r\n" + kHost + "\r\n").status, 400) << line;
}

TEST_F(HttpServerTest, TellsWhatAnAddressTakes) {
  Start();
  EXPECT_NE(Ask("DELETE /healthz HTTP/1.1\r\n" + kHost + "\r\n").head.find("Allow: GET, HEAD, OPTIONS"),
            std::string::npos);
  const RawAnswer options = Ask("OPTIONS /api/v1/flights HTTP/1.1\r\n" + kHost + "\r\n");
  EXPECT_EQ(options.status, 204);
  EXPECT_NE(options.head.find("Allow: GET, HEAD, POST, OPTIONS"), std::string::npos);
  EXPECT_EQ(Ask("OPTIONS * HTTP/1.1\r\n" + kHost + "\r\n").status, 204);
}

TEST_F(HttpServerTest, ClosesWhoeverSendsAHeadTooSlowly) {
  Start();
  RawClient silent(port());
  RawClient slow(port());
  slow.Send("GET /healthz HT");
  EXPECT_EQ(slow.Receive().status, 408);
  EXPECT_TRUE(slow.IsClosed());
  EXPECT_TRUE(silent.IsClosed());
}

TEST_F(HttpServerTest, StoresAnUploadInAnyFraming) {
  Start();
  const std::string flight = catalogue_.AddFlight("f", "{}", storage::Now())->id;
  const std::string put = "PUT /api/v1/flights/" + flight + "/files/";
  EXPECT_EQ(Ask(put + "a.jpg HTTP/1.1\r\n" + kHost + "Content-Length: 3\r\n\r\nabc").status, 201);
  EXPECT_EQ(Ask(put + "b.jpg HTTP/1.1\r\n" + kHost +
                "Transfer-Encoding: chunked\r\n\r\n2;x=y\r\nab\r\n3\r\ncde\r\n0\r\n\r\n")
                .status,
            201);
  RawClient polite(port());
  polite.Send(put + "c.jpg HTTP/1.1\r\n" + kHost + "Content-Length: 4\r\nExpect: 100-continue\r\n\r\n");
  EXPECT_EQ(polite.Receive().status, 100);
  polite.Send("abcd");
  EXPECT_EQ(polite.Receive().status, 201);
  const auto files = catalogue_.ListFiles(flight);
  ASSERT_EQ(files->size(), 3u);
  EXPECT_EQ((*files)[0].bytes, 3);
  EXPECT_EQ((*files)[1].bytes, 5);
  EXPECT_EQ((*files)[2].bytes, 4);
}

TEST_F(HttpServerTest, RefusesBrokenChunksAndKeepsNothing) {
  Start();
  const std::string flight = catalogue_.AddFlight("f", "{}", storage::Now())->id;
  const std::string put = "PUT /api/v1/flights/" + flight + "/files/a.jpg HTTP/1.1\r\n" + kHost +
                          "Transfer-Encoding: chunked\r\n\r\n";
  for (const char* body : {"zz\r\nab\r\n", "ffffffffffffffff\r\nab", "2\r\nabXX\r\n0\r\n\r\n", "-1\r\n"}) {
    const int status = Ask(put + body).status;
    EXPECT_TRUE(status == 400 || status == 413) << body << " " << status;
  }
  EXPECT_TRUE(WaitForIncoming(0));
  EXPECT_TRUE(catalogue_.ListFiles(flight)->empty());
}

TEST_F(HttpServerTest, ForgetsAnUploadWhoseClientWentAway) {
  Start();
  const std::string flight = catalogue_.AddFlight("f", "{}", storage::Now())->id;
  auto client = std::make_unique<RawClient>(port());
  client->Send("PUT /api/v1/flights/" + flight + "/files/a.jpg HTTP/1.1\r\n" + kHost +
               "Content-Length: 3221225472\r\n\r\n" + std::string(100000, 'x'));
  EXPECT_TRUE(WaitForIncoming(1));
  client.reset();
  EXPECT_TRUE(WaitForIncoming(0));
  EXPECT_TRUE(catalogue_.ListFiles(flight)->empty());
}

TEST_F(HttpServerTest, TellsWhoeverSendsABodyTooSlowly) {
  settings_.slice_deadline = std::chrono::seconds(1);
  Start();
  const std::string flight = catalogue_.AddFlight("f", "{}", storage::Now())->id;
  RawClient stalled(port()), dripping(port());
  for (RawClient* client : {&stalled, &dripping}) {
    client->Send("PUT /api/v1/flights/" + flight + "/files/a.jpg HTTP/1.1\r\n" + kHost +
                 "Content-Length: 1000000\r\n\r\n" + std::string(300'000, 'x'));
  }
  for (int i = 0; i < 4; ++i) {
    dripping.Send("x");
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  for (RawClient* client : {&stalled, &dripping}) {
    const RawAnswer answer = client->Receive();
    EXPECT_EQ(answer.status, 408);
    EXPECT_NE(answer.body.find("128 KiB"), std::string::npos) << answer.body;
    EXPECT_NE(answer.body.find("1 s"), std::string::npos) << answer.body;
    EXPECT_TRUE(client->IsClosed());
  }
  EXPECT_TRUE(WaitForIncoming(0));
  EXPECT_TRUE(catalogue_.ListFiles(flight)->empty());
}

TEST_F(HttpServerTest, KeepsWhatCameTooSlowlyOfAResumableUpload) {
  settings_.slice_deadline = std::chrono::seconds(1);
  Start();
  const std::string flight = catalogue_.AddFlight("f", "{}", storage::Now())->id;
  storage::SpooledUpload wish;
  wish.flight_id = flight;
  wish.name = "a.jpg";
  wish.length = 500'000;
  const std::string upload = service_.spool.Create(wish, service_.db.ages().Now())->id;
  const std::string tus = "/api/v1/uploads/" + upload + " HTTP/1.1\r\n" + kHost + "Tus-Resumable: 1.0.0\r\n";
  const std::string patch = "PATCH " + tus + "Content-Type: application/offset+octet-stream\r\n";
  EXPECT_EQ(
      Ask(patch + "Upload-Offset: 0\r\nContent-Length: 500000\r\n\r\n" + std::string(300'000, 'x')).status,
      408);
  RawClient client(port());
  client.Send("HEAD " + tus + "\r\n");
  EXPECT_NE(client.Receive(false).head.find("Upload-Offset: 300000\r\n"), std::string::npos);
  EXPECT_EQ(Ask(patch + "Upload-Offset: 300000\r\nContent-Length: 200000\r\n\r\n" + std::string(200'000, 'x'))
                .status,
            204);
  EXPECT_EQ(catalogue_.ListFiles(flight)->at(0).bytes, 500'000);
}

TEST_F(HttpServerTest, RefusesAnUploadBeforeItsBodyIsSent) {
  Start();
  RawClient client(port());
  client.Send("PUT /api/v1/flights/00000000000000000000000000/files/a.jpg HTTP/1.1\r\n" + kHost +
              "Content-Length: 3221225472\r\nExpect: 100-continue\r\n\r\n");
  EXPECT_EQ(client.Receive().status, 404);
  EXPECT_EQ(Ask("PUT /api/v1/flights/00000000000000000000000000/files/a.jpg HTTP/1.1\r\n" + kHost +
                "Content-Length: 999999999999\r\n\r\n")
                .status,
            413);
}

TEST_F(HttpServerTest, ServesTilesToManyConnectionsWhileTheMapIsReplaced) {
  Start();
  const std::string flight = catalogue_.AddFlight("f", "{}", storage::Now())->id;
  storage::PublishSmallTileset(dir_, *db_, flight, {{1, 0, 1, "revision 1"}});
  std::atomic<bool> is_done = false;
  std::vector<std::thread> readers;
  for (int t = 0; t < 4; ++t) {
    readers.emplace_back([&] {
      RawClient client(port());
      while (!is_done) {
        const RawAnswer answer = client.Ask("GET /tiles/" + flight + "/1/0/0 HTTP/1.1\r\n" + kHost + "\r\n");
        ASSERT_EQ(answer.status, 200);
        ASSERT_TRUE(answer.body.starts_with("revision "));
      }
    });
  }
  for (int i = 2; i <= 8; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(60));
    storage::PublishSmallTileset(dir_, *db_, flight, {{1, 0, 1, "revision " + std::to_string(i)}});
  }
  is_done = true;
  for (std::thread& reader : readers) reader.join();
}

TEST_F(HttpServerTest, DrainsIdleAndBusyConnections) {
  Start();
  RawClient idle(port());
  EXPECT_EQ(idle.Ask("GET /healthz HTTP/1.1\r\n" + kHost + "\r\n").status, 200);
  const std::string flight = catalogue_.AddFlight("f", "{}", storage::Now())->id;
  RawClient busy(port());
  busy.Send("PUT /api/v1/flights/" + flight + "/files/a.jpg HTTP/1.1\r\n" + kHost +
            "Content-Length: 6\r\nExpect: 100-continue\r\n\r\n");
  ASSERT_EQ(busy.Receive().status, 100);
  std::thread finisher([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    busy.Send("abcdef");
    EXPECT_EQ(busy.Receive().status, 201);
    EXPECT_TRUE(busy.IsClosed());
  });
  EXPECT_TRUE(server_->Drain(std::chrono::seconds(10)));
  finisher.join();
  EXPECT_TRUE(idle.IsClosed());
}

TEST_F(HttpServerTest, SaysThatAPortIsTaken) {
  Start();
  HttpSettings same = settings_;
  same.port = static_cast<std::uint16_t>(port());
  EXPECT_EQ(test::ErrorOf(HttpServer::Listen(same, router_, service_)).code, ErrorCode::kConflict);
  same.address = "nowhere";
  EXPECT_EQ(HttpServer::Listen(same, router_, service_).error().code, ErrorCode::kInvalidArgument);
}

}  // namespace
}  // namespace skyquilt::server
