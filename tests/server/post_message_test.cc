#include "server/webhooks/post_message.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <thread>

namespace skyquilt::server {
namespace {

// By an address in text form.
bool IsTaken(const std::string& address) {
  const bool is_ipv6 = address.find(':') != std::string::npos;
  return CheckReceiver("http://" + (is_ipv6 ? "[" + address + "]" : address) + "/hook").ok();
}

TEST(CheckReceiver, RefusesWhatLeadsInside) {
  for (const char* address :
       {"127.0.0.1",      "127.8.9.1",       "10.0.0.1",        "172.16.0.1", "172.31.255.255",
        "192.168.1.1",    "169.254.169.254", "100.64.0.1",      "0.0.0.0",    "192.0.2.7",
        "198.18.0.1",     "224.0.0.1",       "255.255.255.255", "::",         "::1",
        "fe80::1",        "fc00::1",         "fd12::1",         "ff02::1",    "::ffff:127.0.0.1",
        "::ffff:8.8.8.8", "64:ff9b::7f00:1", "2002:7f00:1::",   "2001::1",    "2001:db8::1"}) {
    EXPECT_FALSE(IsTaken(address)) << address;
  }
}

TEST(CheckReceiver, LetsThePublicThrough) {
  for (const char* address :
       {"8.8.8.8", "172.15.0.1", "172.32.0.1", "192.167.0.1", "100.63.0.1", "100.128.0.1", "1.1.1.1",
        "223.255.255.254", "2606:4700::1111", "2a00:1450:4001:80b::200e"}) {
    EXPECT_TRUE(IsTaken(address)) << address;
  }
}

TEST(CheckReceiver, RefusesPrivateAddressesHoweverTheyAreWritten) {
  for (const char* host : {"127.0.0.1", "localhost:8080", "[::1]:80", "10.0.0.1", "2130706433", "0x7f.1",
                           "192.168.1", "[::ffff:127.0.0.1]", "169.254.169.254"}) {
    const auto checked = CheckReceiver(std::string("http://") + host + "/hook");
    ASSERT_FALSE(checked) << host;
    EXPECT_EQ(checked.error().code, ErrorCode::kUnprocessable) << host;
    EXPECT_NE(checked.error().message.find("--webhooks any"), std::string::npos) << checked.error().message;
  }
  EXPECT_FALSE(CheckReceiver("http://"));
}

TEST(CheckReceiver, LetsPublicOnesThroughAndNamesThatNobodyKnowsYet) {
  for (const char* host : {"8.8.8.8", "[2606:4700::1111]:8443", "nowhere.invalid"})
    EXPECT_TRUE(CheckReceiver(std::string("https://") + host + "/hook")) << host;
}

// Listens on loopback, gives everyone the same answer and keeps what the last one said.
class Receiver {
 public:
  explicit Receiver(std::string answer) : answer_(std::move(answer)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t length = sizeof(address);
    EXPECT_EQ(bind(listener_, reinterpret_cast<sockaddr*>(&address), length), 0);
    EXPECT_EQ(listen(listener_, 4), 0);
    EXPECT_EQ(getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &length), 0);
    port_ = ntohs(address.sin_port);
    thread_ = std::thread([this] { Run(); });
  }
  ~Receiver() {
    Stop();
    close(listener_);
  }
  // What the last one said may be read afterwards.
  void Stop() {
    is_ended_ = true;
    if (thread_.joinable()) thread_.join();
  }
  std::string Url() const { return "http://127.0.0.1:" + std::to_string(port_) + "/hook?x=1"; }
  int port() const { return port_; }
  int count() const { return count_; }
  const std::string& heard() const { return heard_; }

 private:
  void Run() {
    while (!is_ended_) {
      pollfd waiting{listener_, POLLIN, 0};
      if (poll(&waiting, 1, 20) != 1) continue;
      const int socket = accept(listener_, nullptr, nullptr);
      heard_.clear();
      char piece[4096];
      while (!heard_.ends_with("END")) {
        const ssize_t read = recv(socket, piece, sizeof(piece), 0);
        if (read <= 0) break;
        heard_.append(piece, static_cast<std::size_t>(read));
      }
      ++count_;
      EXPECT_EQ(send(socket, answer_.data(), answer_.size(), MSG_NOSIGNAL),
                static_cast<ssize_t>(answer_.size()));
      close(socket);
    }
  }

  const std::string answer_;
  const int listener_ = socket(AF_INET, SOCK_STREAM, 0);
  int port_ = 0;
  std::string heard_;
  std::atomic<int> count_ = 0;
  std::atomic<bool> is_ended_ = false;
  std::thread thread_;
};

TEST(PostMessage, SendsOneRequestWithItsHeadersAndBody) {
  Receiver receiver("HTTP/1.1 200 OK\r\nContent-Length: 2\r\n\r\nok");
  const auto posted =
      PostMessage({receiver.Url(), {{"X-Skyquilt-Delivery", "7"}}, std::string(3000, 'a') + "END", true});
  ASSERT_TRUE(posted) << posted.error().detail;
  receiver.Stop();
  EXPECT_EQ(receiver.count(), 1);
  EXPECT_TRUE(receiver.heard().starts_with("POST /hook?x=1 HTTP/1.1\r\n"));
  EXPECT_NE(receiver.heard().find("Host: 127.0.0.1:" + std::to_string(receiver.port()) + "\r\n"),
            std::string::npos);
  EXPECT_NE(receiver.heard().find("X-Skyquilt-Delivery: 7\r\n"), std::string::npos);
  EXPECT_TRUE(receiver.heard().ends_with("\r\n\r\n" + std::string(3000, 'a') + "END"));
}

TEST(PostMessage, FollowsNoRedirect) {
  Receiver inside("HTTP/1.1 200 OK\r\nContent-Length: 0\r\n\r\n");
  Receiver receiver("HTTP/1.1 307 Temporary Redirect\r\nLocation: " + inside.Url() +
                    "\r\nContent-Length: 0\r\n\r\n");
  const auto posted = PostMessage({receiver.Url(), {}, "END", true});
  EXPECT_EQ(posted.error().code, ErrorCode::kUnavailable);
  EXPECT_EQ(posted.error().message, "127.0.0.1 answered 307.");
  EXPECT_EQ(receiver.count(), 1);
  EXPECT_EQ(inside.count(), 0);
}

TEST(PostMessage, GoesThroughNoProxyOfTheEnvironment) {
  Receiver receiver("HTTP/1.1 204 No Content\r\n\r\n");
  setenv("no_proxy", "", 1);
  setenv("http_proxy", "http://127.0.0.1:9", 1);
  const auto posted = PostMessage({receiver.Url(), {}, "END", true});
  unsetenv("http_proxy");
  EXPECT_TRUE(posted) << posted.error().detail;
}

TEST(PostMessage, WaitsForNoBodyAndTakesNoOtherProtocol) {
  Receiver endless("HTTP/1.1 500 Broken\r\nContent-Length: 1000000000\r\n\r\nand so on");
  EXPECT_EQ(PostMessage({endless.Url(), {}, "END", true}).error().message, "127.0.0.1 answered 500.");
  EXPECT_EQ(PostMessage({"file:///etc/hostname", {}, "END", true}).error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(PostMessage({"gopher://127.0.0.1/", {}, "END", true}).error().code, ErrorCode::kUnavailable);
}

TEST(PostMessage, RefusesAPrivateAddressBeforeItConnects) {
  const auto posted = PostMessage({"http://127.0.0.1:9/", {}, "{}", false});
  EXPECT_EQ(posted.error().code, ErrorCode::kForbidden);
  EXPECT_EQ(PostMessage({"http://2130706433:9/", {}, "{}", false}).error().code, ErrorCode::kForbidden);
  EXPECT_EQ(PostMessage({"http://[::ffff:127.0.0.1]:9/", {}, "{}", false}).error().code,
            ErrorCode::kForbidden);
  EXPECT_EQ(PostMessage({"http://:80/", {}, "{}", true}).error().code, ErrorCode::kInvalidArgument);
}

}  // namespace
}  // namespace skyquilt::server
