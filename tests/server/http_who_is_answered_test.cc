// Whom the server answers: by which name it was called, which page asks, and from where.
#include <gtest/gtest.h>

#include <tuple>

#include "api/auth/access.h"
#include "server/routing/network_addresses.h"
#include "tests/server/http_server_fixture.h"
#include "tests/storage/small_tileset.h"

namespace skyquilt::server {
namespace {

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
  // Of OGC API Processes: "respond-async".
  EXPECT_NE(preflight.head.find(", Prefer, "), std::string::npos);
  EXPECT_NE(
      ask("OPTIONS", "/api/v1/uploads", "").head.find("Access-Control-Allow-Methods: POST, OPTIONS\r\n"),
      std::string::npos);
  // A page whose name is no more than ours by DNS has no token either.
  EXPECT_EQ(Ask("GET /healthz HTTP/1.1\r\nHost: evil.example\r\n\r\n").status, 200);
}

TEST_F(HttpServerTest, IsOpenedToTheNetworkForReadingLinksAlone) {
  service_.open_network = [this] { return server_->OpenNetwork(); };
  service_.addresses_for_others = [this](bool) { return server_->NetworkAddresses(); };
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

}  // namespace
}  // namespace skyquilt::server
