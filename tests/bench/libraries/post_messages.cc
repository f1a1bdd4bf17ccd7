// What one webhook costs: PostMessage (server/webhooks) to a receiver in the same process that answers at
// once, by a name that has to be resolved. Wall time in the median, processor time of the whole process (the
// receiver's included).
//   post_messages [MESSAGES]
#include <arpa/inet.h>
#include <fmt/core.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "core/base/check.h"
#include "core/base/median.h"
#include "server/webhooks/post_message.h"
#include "tests/bench/alignment/cpu_seconds.h"

namespace {

constexpr std::string_view kAnswer =
    "HTTP/1.1 204 No Content\r\nContent-Length: 0\r\nConnection: close\r\n\r\n";

// Answers once the whole of a message has come, `count` times.
void Answer(int listener, int count, std::size_t body_bytes) {
  for (int k = 0; k < count; ++k) {
    const int socket = accept(listener, nullptr, nullptr);
    std::string heard;
    char piece[8192];
    for (;;) {
      const std::size_t head = heard.find("\r\n\r\n");
      if (head != std::string::npos && heard.size() >= head + 4 + body_bytes) break;
      const ssize_t read = recv(socket, piece, sizeof(piece), 0);
      if (read <= 0) break;
      heard.append(piece, static_cast<std::size_t>(read));
    }
    SKYQUILT_CHECK(send(socket, kAnswer.data(), kAnswer.size(), 0) == static_cast<ssize_t>(kAnswer.size()),
                   "the receiver cannot answer");
    close(socket);
  }
}

}  // namespace

int main(int argc, char** argv) {
  using namespace skyquilt;
  signal(SIGPIPE, SIG_IGN);
  const int count = argc > 1 ? std::atoi(argv[1]) : 500;
  const int listener = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof(address);
  SKYQUILT_CHECK(bind(listener, reinterpret_cast<sockaddr*>(&address), length) == 0 &&
                     listen(listener, 16) == 0 &&
                     getsockname(listener, reinterpret_cast<sockaddr*>(&address), &length) == 0,
                 "no port to listen on");
  const server::OutgoingMessage message{fmt::format("http://localhost:{}/hook", ntohs(address.sin_port)),
                                        {{"Content-Type", "application/json"}, {"User-Agent", "Skyquilt"}},
                                        std::string(1000, ' '),
                                        true};
  std::thread receiver(Answer, listener, count, message.body.size());
  std::vector<double> wall_ms;
  int failed = 0;
  const double cpu = CpuSeconds();
  for (int k = 0; k < count; ++k) {
    const auto start = std::chrono::steady_clock::now();
    const Result<void> posted = server::PostMessage(message);
    if (!posted && failed++ == 0) fmt::print("{} {}\n", posted.error().message, posted.error().detail);
    wall_ms.push_back(
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
  }
  const double taken = CpuSeconds() - cpu;
  if (failed != 0) std::_Exit(1);  // the receiver waits for messages that do not come
  receiver.join();
  close(listener);
  fmt::print("{} messages of 1 kB: {:.2f} ms in the median, {:.2f} ms of processor each\n", count,
             Median(wall_ms), 1e3 * taken / count);
  return 0;
}
