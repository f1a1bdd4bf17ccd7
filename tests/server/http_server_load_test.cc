// The server with more asked of it than it can do: handlers that hang, over real sockets.
#include <atomic>
#include <future>
#include <thread>

#include "api/http/responses.h"
#include "server/http/http_server.h"
#include "server/http/session_set.h"
#include "tests/server/raw_client.h"
#include "tests/server/served_folder.h"

namespace skyquilt::server {
namespace {

using api::Method;
using std::chrono::milliseconds;

class LoadedServerTest : public ServedFolder {
 protected:
  LoadedServerTest() {
    settings_.port = 0;
    settings_.read_threads = settings_.write_threads = settings_.compute_threads = 1;
    const auto hang = [this](const api::Request&) {
      ++hanging_;
      opened_.wait();
      return api::Text(200, "done", "text/plain");
    };
    router_.AddQuick(Method::kGet, "/healthz",
                     [](const api::Request&) { return api::Text(200, "ok", "text/plain"); });
    router_.Add(Method::kGet, "/api/v1/read", hang);
    router_.AddCompute(Method::kGet, "/api/v1/compute", hang);
    router_.Add(Method::kDelete, "/api/v1/write", hang);
    router_
        .AddBody(Method::kPost, "/api/v1/compute",
                 [hang](const api::Request& request, const std::string&) { return hang(request); })
        .work = api::Work::kCompute;
    router_.AddQuick(Method::kGet, "/api/v1/more", [](const api::Request& request) {
      api::Response response = api::Text(200, std::to_string(static_cast<int>(request.work)), "text/plain");
      if (request.work == api::Work::kQuick) response.wants = api::Work::kRead;
      if (request.work == api::Work::kRead) response.wants = api::Work::kCompute;
      return response;
    });
  }
  ~LoadedServerTest() override {
    if (!is_open_) Open();
    server_.reset();
  }

  void Start() {
    server_ = *HttpServer::Listen(settings_, router_, service_);
    server_->Start();
  }
  void Open() {
    is_open_ = true;
    gate_.set_value();
  }
  void WaitForHanging(int count) const {
    while (hanging_ < count) std::this_thread::sleep_for(milliseconds(1));
  }
  std::unique_ptr<RawClient> Client() { return std::make_unique<RawClient>(server_->port()); }
  static std::string Get(const std::string& path, const std::string& headers = "") {
    return "GET " + path + " HTTP/1.1\r\nHost: localhost\r\n" + headers + "\r\n";
  }

  std::promise<void> gate_;
  std::shared_future<void> opened_ = gate_.get_future().share();
  bool is_open_ = false;
  std::atomic<int> hanging_ = 0;
  api::Router router_;
  HttpSettings settings_;
  std::unique_ptr<HttpServer> server_;
};

TEST_F(LoadedServerTest, AnswersWhatIsQuickWhileAllElseHangs) {
  Start();
  const auto read = Client(), compute = Client(), write = Client(), quick = Client();
  read->Send(Get("/api/v1/read"));
  compute->Send(Get("/api/v1/compute"));
  write->Send("DELETE /api/v1/write HTTP/1.1\r\nHost: localhost\r\n\r\n");
  WaitForHanging(3);
  for (int i = 0; i < 20; ++i) EXPECT_EQ(quick->Ask(Get("/healthz")).body, "ok");
  Open();
  for (const auto& client : {read.get(), compute.get(), write.get()})
    EXPECT_EQ(client->Receive().body, "done");
}

TEST_F(LoadedServerTest, RefusesWhatItHasNoRoomForAndSaysWhenToComeAgain) {
  settings_.max_waiting = 2;
  Start();
  std::vector<std::unique_ptr<RawClient>> taken;
  for (int i = 0; i < 3; ++i) {
    taken.push_back(Client());
    taken.back()->Send(Get("/api/v1/compute"));
    if (i == 0) WaitForHanging(1);
  }
  // The other two are on their way; one of those that come now finds the queue full.
  RawAnswer refused;
  std::vector<std::unique_ptr<RawClient>> more;
  while (refused.status != 429) {
    more.push_back(Client());
    more.back()->Send(Get("/api/v1/compute"));
    std::this_thread::sleep_for(milliseconds(50));
    const auto last = Client();
    refused = last->Ask(Get("/api/v1/compute"));
  }
  EXPECT_NE(refused.head.find("Retry-After: "), std::string::npos) << refused.head;
  EXPECT_NE(refused.body.find("rate_limited"), std::string::npos) << refused.body;
  // Reading has a queue of its own.
  const auto reader = Client();
  reader->Send(Get("/api/v1/read"));
  WaitForHanging(2);
  Open();
  EXPECT_EQ(taken[0]->Receive().status, 200);
  EXPECT_EQ(reader->Receive().status, 200);
}

TEST_F(LoadedServerTest, GivesAnAddressNoMoreThanItsShare) {
  settings_.max_of_client = 1;
  settings_.trusted_proxies = {*AddressRange::From("127.0.0.1")};
  Start();
  const auto first = Client(), second = Client(), other = Client(), own = Client();
  first->Send(Get("/api/v1/compute", "X-Forwarded-For: 192.0.2.1\r\n"));
  WaitForHanging(1);
  const RawAnswer refused = second->Ask(Get("/api/v1/compute", "X-Forwarded-For: 192.0.2.1\r\n"));
  EXPECT_EQ(refused.status, 429);
  EXPECT_NE(refused.body.find("your address"), std::string::npos) << refused.body;
  other->Send(Get("/api/v1/compute", "X-Forwarded-For: 192.0.2.2\r\n"));
  own->Send(Get("/api/v1/compute"));
  Open();
  EXPECT_EQ(first->Receive().status, 200);
  EXPECT_EQ(other->Receive().status, 200);
  EXPECT_EQ(own->Receive().status, 200);
}

TEST_F(LoadedServerTest, WorksOnWhatABodyAsksForBesideThatWhichWrites) {
  settings_.max_of_client = 1;
  settings_.trusted_proxies = {*AddressRange::From("127.0.0.1")};
  Start();
  const std::string post =
      "POST /api/v1/compute HTTP/1.1\r\nHost: localhost\r\nX-Forwarded-For: 192.0.2.1\r\n"
      "Content-Length: 2\r\n\r\n{}";
  const auto first = Client(), second = Client(), writer = Client();
  first->Send(post);
  WaitForHanging(1);
  EXPECT_EQ(second->Ask(post).status, 429);
  writer->Send("DELETE /api/v1/write HTTP/1.1\r\nHost: localhost\r\n\r\n");
  WaitForHanging(2);
  Open();
  EXPECT_EQ(first->Receive().body, "done");
  EXPECT_EQ(writer->Receive().body, "done");
}

TEST_F(LoadedServerTest, GoesOnWhereAnAnswerAsksFor) {
  Start();
  EXPECT_EQ(Client()->Ask(Get("/api/v1/more")).body, std::to_string(static_cast<int>(api::Work::kCompute)));
}

TEST_F(LoadedServerTest, EndsWithinItsTimeWhateverHangs) {
  Start();
  const auto running = Client(), waiting = Client();
  running->Send(Get("/api/v1/compute"));
  WaitForHanging(1);
  waiting->Send(Get("/api/v1/compute"));
  EXPECT_FALSE(server_->Drain(milliseconds(100)));
  // Returns at all: what it ends runs on until Open().
  EXPECT_FALSE(server_->End(std::chrono::steady_clock::now() + milliseconds(100)));
  Open();
  EXPECT_TRUE(server_->End(std::chrono::steady_clock::now() + std::chrono::minutes(1)));
  EXPECT_EQ(hanging_, 1);  // what waited was not begun
}

TEST(SessionSet, AdmitsSoManyOverAllAndOfOneClient) {
  SessionSet sessions;
  SessionSet::Place a1 = sessions.Admit("a", 4, 2), a2 = sessions.Admit("a", 4, 2);
  ASSERT_NE(a1, nullptr);
  ASSERT_NE(a2, nullptr);
  EXPECT_EQ(sessions.Admit("a", 4, 2), nullptr);
  const SessionSet::Place b = sessions.Admit("b", 4, 2);
  EXPECT_NE(b, nullptr);
  const SessionSet::Place unnamed = sessions.Admit("", 4, 2);
  EXPECT_NE(unnamed, nullptr);
  EXPECT_EQ(sessions.Admit("", 4, 2), nullptr);  // four are all
  a1.reset();
  EXPECT_NE(sessions.Admit("a", 4, 2), nullptr);
}

}  // namespace
}  // namespace skyquilt::server
