// RawClient: a socket that sends exactly the given bytes, for tests of what no HTTP library would send.
#pragma once

#include <chrono>
#include <string>
#include <string_view>

namespace skyquilt::server {

struct RawAnswer {
  int status = 0;  // 0: the connection closed without an answer
  std::string head;
  std::string body;
};

class RawClient {
 public:
  explicit RawClient(int port, const std::string& address = "127.0.0.1");
  ~RawClient();
  RawClient(const RawClient&) = delete;
  RawClient& operator=(const RawClient&) = delete;

  void Send(std::string_view bytes);
  // One answer; `has_body` false for HEAD.
  RawAnswer Receive(bool has_body = true);
  // True when the server closed the connection (within the receive time-out of 15 s).
  bool IsClosed();
  RawAnswer Ask(std::string_view bytes) {
    Send(bytes);
    return Receive();
  }

 private:
  bool Fill();
  int fd_;
  std::string buffer_;
};

}  // namespace skyquilt::server
