// ScriptedServer: an HTTP server of this machine that answers as a test tells it to, one request a
// connection. It keeps what it was asked.
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace skyquilt::test {

inline std::string HttpText(int status, const std::string& body = "", const std::string& headers = "") {
  return "HTTP/1.1 " + std::to_string(status) + " X\r\nContent-Length: " + std::to_string(body.size()) +
         "\r\nConnection: close\r\n" + headers + "\r\n" + body;
}

class ScriptedServer {
 public:
  // What the n-th request (from 0) is answered, byte by byte; an empty text closes without a word.
  using Script = std::function<std::string(int n, const std::string& request)>;

  explicit ScriptedServer(Script script) : script_(std::move(script)) {
    listening_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t length = sizeof(address);
    if (bind(listening_, reinterpret_cast<sockaddr*>(&address), length) != 0 || listen(listening_, 16) != 0)
      return;
    getsockname(listening_, reinterpret_cast<sockaddr*>(&address), &length);
    port_ = ntohs(address.sin_port);
    thread_ = std::thread([this] { Serve(); });
  }
  ~ScriptedServer() {
    is_ended_ = true;
    shutdown(listening_, SHUT_RDWR);
    close(listening_);
    if (thread_.joinable()) thread_.join();
  }
  ScriptedServer(const ScriptedServer&) = delete;
  ScriptedServer& operator=(const ScriptedServer&) = delete;

  std::string Endpoint() const { return "http://127.0.0.1:" + std::to_string(port_); }
  std::vector<std::string> requests() const {
    const std::lock_guard lock(mutex_);
    return requests_;
  }

 private:
  void Serve() {
    while (!is_ended_) {
      const int fd = accept(listening_, nullptr, nullptr);
      if (fd < 0) return;
      Answer(fd);
      close(fd);
    }
  }

  void Answer(int fd) {
    std::string request;
    char bytes[65536];
    std::size_t wanted = std::string::npos;
    while (request.size() < wanted) {
      const ssize_t got = recv(fd, bytes, sizeof(bytes), 0);
      if (got <= 0) break;
      request.append(bytes, static_cast<std::size_t>(got));
      const std::size_t head = request.find("\r\n\r\n");
      if (head == std::string::npos || wanted != std::string::npos) continue;
      const std::size_t said = request.find("Content-Length: ");
      wanted = head + 4 + (said < head ? std::stoul(request.substr(said + 16)) : 0);
    }
    int n = 0;
    {
      const std::lock_guard lock(mutex_);
      n = static_cast<int>(requests_.size());
      requests_.push_back(request);
    }
    const std::string answer = script_(n, request);
    for (std::size_t sent = 0; sent < answer.size();) {
      const ssize_t wrote = send(fd, answer.data() + sent, answer.size() - sent, MSG_NOSIGNAL);
      if (wrote <= 0) return;
      sent += static_cast<std::size_t>(wrote);
    }
  }

  Script script_;
  int listening_ = -1;
  int port_ = 0;
  std::atomic<bool> is_ended_{false};
  mutable std::mutex mutex_;
  std::vector<std::string> requests_;
  std::thread thread_;
};

}  // namespace skyquilt::test
