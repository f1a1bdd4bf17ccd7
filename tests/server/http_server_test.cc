// The server over real sockets, spoken to in raw bytes.
#include "server/http/http_server.h"

#include <gtest/gtest.h>

#include <string>
#include <thread>
#include <tuple>
#include <vector>

#include "api/auth/access.h"
#include "api/build_api.h"
#include "server/routing/network_addresses.h"
#include "tests/server/raw_client.h"
#include "tests/server/served_folder.h"
#include "tests/storage/small_tileset.h"

namespace skyquilt::server {
namespace {

class HttpServerTest : public ServedFolder {
 protected:
  HttpServerTest() : router_(api::BuildApi(service_)) {
    settings_.port = 0;
    settings_.header_deadline = std::chrono::seconds(1);
  }

  void Start() {
    auto server = HttpServer::Listen(settings_, router_, service_);
    ASSERT_TRUE(server) << server.error().message;
    server_ = *std::move(server);
    server_->Start();
  }
  int port() const { return server_->port(); }
  RawAnswer Ask(const std::string& bytes) { return RawClient(port()).Ask(bytes); }
  int CountIncoming() const {
    return static_cast<int>(std::distance(std::filesystem::directory_iterator(dir_.Incoming()), {}));
  }
  bool WaitForIncoming(int count) const {
    for (int i = 0; i < 1000 && CountIncoming() != count; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(25));
    return CountIncoming() == count;
  }

  api::Router router_;
  HttpSettings settings_;
  std::unique_ptr<HttpServer> server_;
};

const std::string kHost = "Host: localhost\r\n";

TEST_F(HttpServerTest, AnswersOverOneConnectionAgainAndAgain) {
  Start();
  RawClient client(port());
  for (int i = 0; i < 3; ++i) EXPECT_EQ(client.Ask("GET /healthz HTTP/1.1\r\n" + kHost + "\r\n").status, 200);
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

TEST_F(HttpServerTest, TellsWhatAnAddressTakes) {
  Start();
  EXPECT_NE(Ask("DELETE /healthz HTTP/1.1\r\n" + kHost + "\r\n").head.find("Allow: GET, HEAD, OPTIONS"),
            std::string::npos);
  const RawAnswer options = Ask("OPTIONS /api/v1/flights HTTP/1.1\r\n" + kHost + "\r\n");
  EXPECT_EQ(options.status, 204);
  EXPECT_NE(options.head.find("Allow: GET, HEAD, POST, OPTIONS"), std::string::npos);
  EXPECT_EQ(Ask("OPTIONS * HTTP/1.1\r\n" + kHost + "\r\n").status, 204);
}

TEST_F(HttpServerTest, AnswersToItsOwnMachineAndItsOwnPageOnly) {
  Start();
  EXPECT_EQ(Ask("GET /healthz HTTP/1.1\r\nHost: evil.example\r\n\r\n").status, 421);
  EXPECT_EQ(Ask("GET /healthz HTTP/1.1\r\nHost: 127.0.0.1:8080\r\n\r\n").status, 200);
  EXPECT_EQ(Ask("GET /healthz HTTP/1.1\r\nHost: 127.evil.example\r\n\r\n").status, 421);
  EXPECT_EQ(Ask("GET /healthz HTTP/1.1\r\nHost: [::1]:80\r\n\r\n").status, 200);
  const std::string post = "POST /api/v1/flights HTTP/1.1\r\n" + kHost + "Content-Length: 0\r\n";
  EXPECT_EQ(Ask(post + "Origin: https://evil.example\r\n\r\n").status, 403);
  EXPECT_EQ(Ask(post + "Origin: null\r\n\r\n").status, 403);
  EXPECT_EQ(Ask(post + "Origin: http://localhost\r\n\r\n").status, 201);
  // Another scheme or port is another site, and the browser's own word counts before all.
  EXPECT_EQ(Ask(post + "Origin: https://localhost\r\n\r\n").status, 403);
  EXPECT_EQ(Ask(post + "Origin: http://localhost:81\r\n\r\n").status, 403);
  EXPECT_EQ(Ask(post + "Origin: https://localhost\r\nX-Forwarded-Proto: https\r\n\r\n").status, 201);
  EXPECT_EQ(Ask(post + "Origin: https://localhost\r\nSec-Fetch-Site: same-origin\r\n\r\n").status, 201);
  EXPECT_EQ(Ask(post + "Sec-Fetch-Site: cross-site\r\n\r\n").status, 403);
  EXPECT_EQ(Ask(post + "Sec-Fetch-Site: same-site\r\n\r\n").status, 403);
  EXPECT_EQ(Ask(post + "Origin: http://localhost\r\nSec-Fetch-Site: cross-site\r\n\r\n").status, 403);
}

TEST_F(HttpServerTest, AnswersToTheNamesThatItsOperatorGaveIt) {
  settings_.hosts = {"maps.example.org", "other.example:8443"};
  Start();
  const auto status = [&](const std::string& host) {
    return Ask("GET /healthz HTTP/1.1\r\nHost: " + host + "\r\n\r\n").status;
  };
  EXPECT_EQ(status("maps.example.org"), 200);
  EXPECT_EQ(status("MAPS.example.org:8080"), 200);
  EXPECT_EQ(status("other.example:8443"), 200);
  EXPECT_EQ(status("other.example"), 421);
  EXPECT_EQ(status("maps.example.org.evil.example"), 421);
  EXPECT_NE(Ask("GET /healthz HTTP/1.1\r\nHost: evil.example\r\n\r\n").body.find("--host"),
            std::string::npos);
}

TEST_F(HttpServerTest, AnswersToNoOtherNameThatAProxyPassesOn) {
  settings_.trusted_proxies.push_back(*AddressRange::From("127.0.0.1"));
  settings_.hosts = {"maps.example.org"};
  Start();
  const auto ask = [&](const std::string& host) {
    return Ask("GET /stac HTTP/1.1\r\n" + kHost + "X-Forwarded-Host: " + host + "\r\n\r\n");
  };
  EXPECT_EQ(ask("evil.example").status, 421);
  EXPECT_NE(ask("maps.example.org").body.find("http://maps.example.org/stac"), std::string::npos);
  // Where tokens are asked for, any name is answered, and links do not follow it.
  const std::string text = api::NewTokenText();
  ASSERT_TRUE(
      service_.tokens.Add({"one", "one", api::HashToken(text), storage::Scope::kAdmin, storage::Now()}));
  const RawAnswer closed = ask("evil.example\r\nAuthorization: Bearer " + text);
  EXPECT_EQ(closed.status, 200);
  EXPECT_EQ(closed.body.find("evil"), std::string::npos);
  EXPECT_NE(closed.body.find("http://localhost/stac"), std::string::npos);
}

TEST_F(HttpServerTest, ListeningAtAllAddressesAnswersToThoseOfTheMachineAlone) {
  settings_.address = "0.0.0.0";
  Start();
  const auto status = [&](const std::string& host) {
    return Ask("GET /healthz HTTP/1.1\r\nHost: " + host + "\r\n\r\n").status;
  };
  EXPECT_EQ(status("127.0.0.1"), 200);
  EXPECT_EQ(status("localhost:80"), 200);
  EXPECT_EQ(status("192.0.2.7"), 421);  // of no machine, by RFC 5737
  EXPECT_EQ(status("evil.example"), 421);
}

TEST_F(HttpServerTest, LetsNoPageOfElsewhereReadWithoutTokens) {
  Start();
  const std::string flight = catalogue_.AddFlight("f", "{}", storage::Now())->id;
  storage::PublishSmallTileset(dir_, *db_, flight, {{1, 0, 1, "tile"}});
  const std::string evil = " HTTP/1.1\r\n" + kHost + "Origin: https://evil.example\r\n";
  const std::vector<std::string> paths = {"/api/v1/flights",  "/tiles/" + flight + "/1/0/0",
                                          "/ogc/collections", "/stac/" + flight,
                                          "/wms/" + flight,   "/info"};
  for (const std::string& path : paths) {
    EXPECT_EQ(Ask("GET " + path + evil + "\r\n").head.find("Access-Control"), std::string::npos) << path;
    const RawAnswer preflight = Ask("OPTIONS " + path + evil + "Access-Control-Request-Method: GET\r\n\r\n");
    EXPECT_EQ(preflight.head.find("Access-Control"), std::string::npos) << path;
  }
}

TEST_F(HttpServerTest, LetsPagesOfNamedSitesRead) {
  settings_.cors_origins = {"https://maps.example.org"};
  Start();
  const auto head = [&](const std::string& method, const std::string& path, const std::string& origin) {
    return Ask(method + " " + path + " HTTP/1.1\r\n" + kHost + "Content-Length: 0\r\nOrigin: " + origin +
               "\r\n\r\n")
        .head;
  };
  const std::string named = "Access-Control-Allow-Origin: https://maps.example.org\r\n";
  EXPECT_NE(head("GET", "/api/v1/flights", "https://maps.example.org").find(named), std::string::npos);
  EXPECT_NE(head("GET", "/nowhere", "https://maps.example.org").find(named), std::string::npos);
  EXPECT_NE(head("POST", "/api/v1/flights", "https://maps.example.org").find(" 201 "), std::string::npos);
  const std::string refused = head("POST", "/api/v1/flights", "https://evil.example");
  EXPECT_NE(refused.find(" 403 "), std::string::npos);
  EXPECT_EQ(refused.find("Access-Control"), std::string::npos);
  EXPECT_NE(refused.find("Vary: Origin"), std::string::npos);
  EXPECT_EQ(head("GET", "/api/v1/flights", "http://maps.example.org").find("Access-Control"),
            std::string::npos);
}

TEST_F(HttpServerTest, LetsAnyPageWithATokenReadWhateverTheAnswer) {
  Start();
  const std::string text = api::NewTokenText();
  ASSERT_TRUE(
      service_.tokens.Add({"one", "one", api::HashToken(text), storage::Scope::kAdmin, storage::Now()}));
  const std::string shown = "Authorization: Bearer " + text + "\r\n";
  const auto ask = [&](const std::string& method, const std::string& path, const std::string& more) {
    return Ask(method + " " + path + " HTTP/1.1\r\n" + kHost + "Origin: https://other.example\r\n" + more +
               "\r\n");
  };
  const std::string any = "Access-Control-Allow-Origin: *\r\n";
  const std::tuple<int, std::string, std::string> cases[] = {{401, "/api/v1/flights", ""},
                                                             {200, "/api/v1/flights", shown},
                                                             {404, "/api/v1/flights/none", shown},
                                                             {404, "/nowhere", ""},
                                                             {200, "/healthz", ""}};
  for (const auto& [status, path, more] : cases) {
    const RawAnswer answer = ask("GET", path, more);
    EXPECT_EQ(answer.status, status) << path;
    EXPECT_NE(answer.head.find(any), std::string::npos) << path;
  }
  EXPECT_EQ(ask("POST", "/api/v1/flights", shown + "Content-Length: 0\r\n").status, 201);
  EXPECT_EQ(ask("POST", "/api/v1/flights", "Content-Length: 0\r\n").status, 401);
  const RawAnswer preflight = ask("OPTIONS", "/api/v1/flights", "Access-Control-Request-Method: POST\r\n");
  EXPECT_EQ(preflight.status, 204);
  EXPECT_NE(preflight.head.find(any), std::string::npos);
  EXPECT_NE(preflight.head.find("Access-Control-Allow-Methods: GET, HEAD, POST, OPTIONS\r\n"),
            std::string::npos);
  EXPECT_NE(
      ask("OPTIONS", "/api/v1/uploads", "").head.find("Access-Control-Allow-Methods: POST, OPTIONS\r\n"),
      std::string::npos);
  // A page whose name is no more than ours by DNS has no token either.
  EXPECT_EQ(Ask("GET /healthz HTTP/1.1\r\nHost: evil.example\r\n\r\n").status, 200);
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

TEST_F(HttpServerTest, IsOpenedToTheNetworkForReadingLinksAlone) {
  service_.open_network = [this] { return server_->OpenNetwork(); };
  service_.addresses_for_others = [this] { return server_->NetworkAddresses(); };
  Start();
  const std::vector<std::string> hosts = NetworkHosts();
  const std::string open = "POST /api/v1/network HTTP/1.1\r\nContent-Length: 0\r\n" + kHost;
  EXPECT_EQ(Ask(open + "X-Forwarded-For: 192.0.2.7\r\n\r\n").status, 403) << "a proxy asks for another";
  EXPECT_EQ(Ask(open + "Origin: http://evil.example\r\n\r\n").status, 403) << "another site's page";
  EXPECT_TRUE(server_->NetworkAddresses().empty());
  if (hosts.empty()) {
    EXPECT_EQ(Ask(open + "\r\n").status, 409);
    GTEST_SKIP() << "this machine is in no network";
  }
  ASSERT_EQ(Ask(open + "\r\n").status, 200);
  EXPECT_EQ(Ask(open + "\r\n").status, 200) << "once more changes nothing";
  ASSERT_EQ(server_->NetworkAddresses().size(), hosts.size());
  const std::string url = server_->NetworkAddresses().front();
  const int network_port = std::stoi(url.substr(url.rfind(':') + 1));
  const std::string flight = catalogue_.AddFlight("f", "{}", storage::Now())->id;
  const std::string at = "/api/v1/flights/" + flight;
  EXPECT_EQ(Ask("GET " + at + " HTTP/1.1\r\n" + kHost + "\r\n").status, 200) << "here all is as it was";
  const std::string text = api::NewShareText();
  storage::Token share{"s", "s", api::HashToken(text), storage::Scope::kRead, storage::Now()};
  share.flight_id = flight;
  ASSERT_TRUE(service_.tokens.AddShare(share));
  const auto ask_there = [&](const std::string& method_and_path, const std::string& token) {
    return RawClient(network_port, hosts.front())
        .Ask(method_and_path + " HTTP/1.1\r\nHost: " + hosts.front() + "\r\nContent-Length: 0\r\n" +
             (token.empty() ? "" : "Authorization: Bearer " + token + "\r\n") + "\r\n")
        .status;
  };
  EXPECT_EQ(ask_there("GET " + at, text), 200);
  EXPECT_EQ(ask_there("GET " + at, ""), 401);
  for (const std::string& change :
       {"DELETE " + at, "PATCH " + at, "PUT " + at + "/files/a.jpg", std::string("POST /api/v1/flights"),
        std::string("POST /api/v1/network")}) {
    EXPECT_EQ(ask_there(change, ""), 401) << change;
    EXPECT_EQ(ask_there(change, text), 403) << change;
  }
  EXPECT_TRUE(server_->Drain(std::chrono::seconds(10)));
}

TEST_F(HttpServerTest, SaysThatAPortIsTaken) {
  Start();
  HttpSettings same = settings_;
  same.port = static_cast<std::uint16_t>(port());
  const auto second = HttpServer::Listen(same, router_, service_);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, ErrorCode::kConflict);
  same.address = "nowhere";
  EXPECT_EQ(HttpServer::Listen(same, router_, service_).error().code, ErrorCode::kInvalidArgument);
}

}  // namespace
}  // namespace skyquilt::server
