// Who may do what: every route of the API against every scope.
#include "api/auth/access.h"

#include <set>
#include <thread>

#include "tests/api/sample_service.h"

namespace skyquilt::api {
namespace {

using storage::Scope;

std::string MakeToken(SampleService& sample, const std::string& name, Scope scope,
                      std::optional<storage::Time> expires = {}) {
  const std::string text = NewTokenText();
  EXPECT_TRUE(sample.service().tokens.Add({name, name, HashToken(text), scope, storage::Now(), expires}));
  return text;
}

int StatusFor(SampleService& sample, Method method, const Route& route, const std::string& token,
              bool in_query = false) {
  Request request;
  request.method = method;
  if (in_query) {
    request.query.emplace_back("token", token);
  } else if (!token.empty()) {
    request.headers.Add("Authorization", "Bearer " + token);
  }
  const std::optional<Response> refused = CheckAccess(sample.service(), request, route);
  if (!refused) return 0;
  // The node's clients get their refusals as answers.
  return refused->status == 200
             ? (refused->body.find("Invalid authentication") == std::string::npos ? 403 : 401)
             : refused->status;
}

TEST(Access, ATokenThatACommandMadeIsGoodAtOnce) {
  SampleService sample;
  const std::string first = MakeToken(sample, "first", Scope::kRead);
  Route route;
  route.scope = Scope::kRead;
  ASSERT_EQ(StatusFor(sample, Method::kGet, route, first), 0);
  // As another program does it: what the server has in memory does not know.
  storage::Tokens elsewhere(sample.service().db);
  const std::string text = NewTokenText();
  ASSERT_TRUE(elsewhere.Add({"new", "new", HashToken(text), Scope::kRead, storage::Now(), {}}));
  std::this_thread::sleep_for(storage::Tokens::kFreshForUnknown);
  EXPECT_EQ(StatusFor(sample, Method::kGet, route, text), 0);
  EXPECT_EQ(StatusFor(sample, Method::kGet, route, text + "x"), 401);
}

TEST(Access, EveryRouteAsksForWhatItDoes) {
  SampleService sample;
  std::set<std::string> open;
  std::set<std::string> read_by_post;
  std::set<std::string> uploaders_get;
  std::set<std::string> for_admins;
  for (const auto& [method, route] : sample.router().Routes()) {
    const std::string what = std::string(MethodName(method)) + " " + route->pattern;
    if (!route->scope) open.insert(what);
    if (method != Method::kGet && route->scope == Scope::kRead) read_by_post.insert(what);
    if (method == Method::kGet && route->scope == Scope::kUpload) uploaders_get.insert(what);
    if (route->scope == Scope::kAdmin) for_admins.insert(what);
  }
  // What needs no token is nothing of any flight.
  EXPECT_EQ(open,
            (std::set<std::string>{"GET /auth/info", "GET /basemap.json", "GET /basemap.pmtiles", "GET /docs",
                                   "GET /healthz", "GET /openapi.json", "GET /readyz", "GET /version",
                                   "OPTIONS /api/v1/uploads", "OPTIONS /api/v1/uploads/{upload}",
                                   "POST /auth/login", "POST /auth/register"}));
  // Another form of what may be downloaded anyway, and questions too long for an address.
  EXPECT_EQ(read_by_post,
            (std::set<std::string>{
                "DELETE /api/v1/flights/{flight}/exports/{export}", "POST /api/v1/flights/{flight}/exports",
                "POST /api/v1/flights/{flight}/heights", "POST /api/v1/flights/{flight}/statistics",
                "POST /api/v1/flights/{flight}/volume", "POST /stac/search"}));
  // Links are for who may end them. What changes something is listed in flight_access_test.
  EXPECT_EQ(uploaders_get, std::set<std::string>{"GET /api/v1/flights/{flight}/shares"});
  EXPECT_EQ(for_admins,
            (std::set<std::string>{"DELETE /api/v1/webhooks/{webhook}", "GET /api/v1/webhooks",
                                   "GET /metrics", "POST /api/v1/network", "POST /api/v1/webhooks"}));
}

TEST(Access, WithoutTokensAllIsOpen) {
  SampleService sample;
  for (const auto& [method, route] : sample.router().Routes())
    EXPECT_EQ(StatusFor(sample, method, *route, ""), 0);
}

TEST(Access, WhoComesByTheNetworkNeedsATokenAlsoWhereNobodyElseDoes) {
  SampleService sample;
  ASSERT_EQ(sample.Send(Method::kPost, "/api/v1/flights/" + sample.NewFlight() + "/shares").status, 201);
  for (const auto& [method, route] : sample.router().Routes()) {
    Request request;
    request.method = method;
    request.needs_token = true;
    const std::optional<Response> refused = CheckAccess(sample.service(), request, *route);
    EXPECT_EQ(refused.has_value(), route->scope.has_value()) << route->pattern;
    EXPECT_FALSE(request.is_admin) << route->pattern;
  }
}

TEST(Access, TheNetworkIsOpenedFromThisMachineAlone) {
  SampleService sample;
  int opened = 0;
  sample.service().open_network = [&] {
    ++opened;
    return Result<void>();
  };
  Request request;
  request.method = Method::kPost;
  const auto match = sample.router().Find(Method::kPost, {"api", "v1", "network"});
  ASSERT_NE(match.route, nullptr);
  EXPECT_EQ(match.route->scope, Scope::kAdmin);
  const auto ask = [&] {
    auto begun = match.route->upload(request);
    return std::get<std::unique_ptr<BodySink>>(begun)->Finish().status;
  };
  EXPECT_EQ(ask(), 403);
  EXPECT_EQ(opened, 0);
  request.is_from_this_machine = true;
  EXPECT_EQ(ask(), 200);
  EXPECT_EQ(opened, 1);
  sample.service().open_network = nullptr;
  EXPECT_EQ(ask(), 409) << "the operator said how others reach it";
}

TEST(Access, EveryRouteAgainstEveryToken) {
  SampleService sample;
  const std::string read = MakeToken(sample, "read", Scope::kRead);
  const std::string upload = MakeToken(sample, "upload", Scope::kUpload);
  const std::string admin = MakeToken(sample, "admin", Scope::kAdmin);
  const std::string ended = MakeToken(sample, "ended", Scope::kAdmin, storage::FromUs(1));
  for (const auto& [method, route] : sample.router().Routes()) {
    const std::optional<Scope> scope = route->scope;
    const std::string what = std::string(MethodName(method)) + " " + route->pattern;
    const int refused = scope ? 401 : 0;
    EXPECT_EQ(StatusFor(sample, method, *route, ""), refused) << what;
    EXPECT_EQ(StatusFor(sample, method, *route, "sq_wrong"), refused) << what;
    EXPECT_EQ(StatusFor(sample, method, *route, ended), refused) << what;
    EXPECT_EQ(StatusFor(sample, method, *route, admin), 0) << what;
    EXPECT_EQ(StatusFor(sample, method, *route, upload), scope == Scope::kAdmin ? 403 : 0) << what;
    EXPECT_EQ(StatusFor(sample, method, *route, read), scope > Scope::kRead ? 403 : 0) << what;
    // In the address a token opens reading alone, but for the node's clients, who know no other way.
    const bool is_node =
        route->pattern.starts_with("/task/") || route->pattern == "/info" || route->pattern == "/options";
    EXPECT_EQ(StatusFor(sample, method, *route, admin, true), scope > Scope::kRead && !is_node ? 403 : 0)
        << what;
  }
}

TEST(Access, ARevokedTokenEnds) {
  SampleService sample;
  const std::string token = MakeToken(sample, "one", Scope::kRead);
  MakeToken(sample, "other", Scope::kRead);
  const Route& flights = *sample.router().Find(Method::kGet, {"api", "v1", "flights"}).route;
  EXPECT_EQ(StatusFor(sample, Method::kGet, flights, token), 0);
  ASSERT_TRUE(sample.service().tokens.Revoke("one"));
  EXPECT_EQ(StatusFor(sample, Method::kGet, flights, token), 401);
}

TEST(Access, TheLastTokenRevokedOrEndedOpensNothing) {
  SampleService sample;
  const std::string token = MakeToken(sample, "one", Scope::kAdmin);
  ASSERT_TRUE(sample.service().tokens.Revoke("one"));
  const auto all_are_refused = [&] {
    for (const auto& [method, route] : sample.router().Routes()) {
      const int refused = route->scope ? 401 : 0;
      EXPECT_EQ(StatusFor(sample, method, *route, ""), refused)
          << MethodName(method) << " " << route->pattern;
      EXPECT_EQ(StatusFor(sample, method, *route, token), refused)
          << MethodName(method) << " " << route->pattern;
    }
  };
  all_are_refused();
  EXPECT_NE(sample.Get("/api/v1/flights").body.find("--open"), std::string::npos);
  // A process that starts now, or reads the catalogue anew, knows it too.
  EXPECT_TRUE(storage::Tokens(sample.service().db).Read()->requires_token);
  MakeToken(sample, "ended", Scope::kAdmin, storage::FromUs(1));
  all_are_refused();
  EXPECT_FALSE((*sample.service().tokens.Known())->HasLiveOne(storage::Now()));
  ASSERT_TRUE(sample.service().tokens.LetEverybodyIn());
  EXPECT_EQ(sample.Get("/api/v1/flights").status, 200);
  MakeToken(sample, "two", Scope::kRead);
  EXPECT_EQ(sample.Get("/api/v1/flights").status, 401);
}

TEST(Access, AShareOnlyReadsAlsoWhereNobodyNeedsAToken) {
  SampleService sample;
  const std::string flight = sample.NewFlight();
  const std::string other = sample.NewFlight();
  const std::string share = NewShareText();
  ASSERT_TRUE(sample.service().tokens.AddShare(
      {"one", "one", HashToken(share), Scope::kRead, storage::Now(), {}, {}, {}, flight}));
  EXPECT_FALSE(sample.service().tokens.Read()->requires_token);
  for (const auto& [method, route] : sample.router().Routes()) {
    const std::optional<Scope> scope = route->scope;
    const std::string what = std::string(MethodName(method)) + " " + route->pattern;
    EXPECT_EQ(StatusFor(sample, method, *route, ""), 0) << what;
    for (const bool in_query : {false, true}) {
      EXPECT_EQ(StatusFor(sample, method, *route, share, in_query), scope > Scope::kRead ? 403 : 0) << what;
    }
  }
  Headers shown{{"Authorization", "Bearer " + share}};
  EXPECT_EQ(sample.Get("/api/v1/access", shown).body,
            R"({"needs_token":false,"scope":"read","flight":")" + flight + R"(","keep_days":0})");
  EXPECT_EQ(sample.Get("/api/v1/flights", shown).body.find(other), std::string::npos);
  // Revoked, it is still no more than it was.
  ASSERT_TRUE(sample.service().tokens.RevokeShare(flight, "one"));
  EXPECT_EQ(sample.Get("/api/v1/access", shown).status, 401);
  EXPECT_EQ(sample.Get("/api/v1/access").status, 200);
  // A first token closes the server as ever, and a share opens none that is closed.
  MakeToken(sample, "two", Scope::kRead);
  ASSERT_TRUE(sample.service().tokens.AddShare(
      {"three", "three", HashToken(share), Scope::kRead, storage::Now(), {}, {}, {}, flight}));
  EXPECT_EQ(sample.Get("/api/v1/flights").status, 401);
  EXPECT_EQ(sample.Get("/api/v1/access", shown).status, 200);
}

TEST(Access, TokensAreLongAndNeverTheSame) {
  EXPECT_GE(NewTokenText().size(), 46u);
  EXPECT_NE(NewTokenText(), NewTokenText());
  EXPECT_EQ(HashToken("a").size(), 32u);
}

TEST(Access, TellsWhoAsksWhatItMayDo) {
  SampleService sample;
  const auto told = [&](Headers headers, const std::string& query = "") {
    return sample.Get("/api/v1/access" + query, std::move(headers)).body;
  };
  EXPECT_EQ(told({}), R"({"needs_token":false,"scope":"admin","flight":null,"keep_days":0})");
  const std::string flight = sample.NewFlight();
  for (const Scope scope : {Scope::kRead, Scope::kUpload, Scope::kAdmin}) {
    const std::string name = storage::ScopeName(scope);
    EXPECT_EQ(told(sample.MakeToken(name, scope)),
              R"({"needs_token":true,"scope":")" + name + R"(","flight":null,"keep_days":0})");
  }
  EXPECT_EQ(told(sample.MakeToken("share", Scope::kRead, {}, flight)),
            R"({"needs_token":true,"scope":"read","flight":")" + flight + R"(","keep_days":0})");
  const std::string text = MakeToken(sample, "in the address", Scope::kUpload);
  EXPECT_EQ(told({}, "?token=" + text), R"({"needs_token":true,"scope":"read","flight":null,"keep_days":0})");
  EXPECT_EQ(sample.Get("/api/v1/access").status, 401);
}

// Programs that cascade a WMS write the names of all parameters in capitals (GeoServer).
TEST(Access, ATokenInTheAddressIsNamedInAnyCase) {
  SampleService sample;
  const std::string text = MakeToken(sample, "one", Scope::kUpload);
  const Response told = sample.Get("/wms?SERVICE=WMS&REQUEST=GetCapabilities&TOKEN=" + text);
  EXPECT_EQ(told.status, 200) << told.body;
  EXPECT_NE(told.body.find("/wms?token=" + text), std::string::npos) << told.body;
  EXPECT_EQ(sample.Get("/wms?TOKEN=" + text + "x").status, 401);
  // It still only reads.
  EXPECT_EQ(sample.Send(Method::kPost, "/api/v1/flights?TOKEN=" + text, "{}").status, 403);
}

}  // namespace
}  // namespace skyquilt::api
