#include "tests/server/raw_client.h"

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>

#include "core/base/check.h"

namespace skyquilt::server {
namespace {

std::size_t LengthIn(std::string head) {
  std::transform(head.begin(), head.end(), head.begin(), [](unsigned char c) { return std::tolower(c); });
  const std::size_t at = head.find("\r\ncontent-length: ");
  return at == std::string::npos ? 0 : std::strtoull(head.c_str() + at + 18, nullptr, 10);
}

}  // namespace

RawClient::RawClient(int port, const std::string& to) : fd_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  SKYQUILT_CHECK(inet_pton(AF_INET, to.c_str(), &address.sin_addr) == 1, "an address of IPv4");
  const timeval patience{15, 0};
  setsockopt(fd_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  const int failed = connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address);
  SKYQUILT_CHECK(failed == 0, "the test could not connect");
}

RawClient::~RawClient() { close(fd_); }

void RawClient::Send(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t sent = send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent <= 0) return;  // the server closed: the answer tells why
    bytes.remove_prefix(static_cast<std::size_t>(sent));
  }
}

bool RawClient::Fill() {
  char slice[65536];
  const ssize_t got = recv(fd_, slice, sizeof slice, 0);
  if (got <= 0) return false;
  buffer_.append(slice, static_cast<std::size_t>(got));
  return true;
}

RawAnswer RawClient::Receive(bool has_body) {
  RawAnswer answer;
  while (buffer_.find("\r\n\r\n") == std::string::npos) {
    if (!Fill()) return answer;
  }
  const std::size_t end = buffer_.find("\r\n\r\n") + 4;
  answer.head = buffer_.substr(0, end);
  buffer_.erase(0, end);
  answer.status = std::atoi(answer.head.c_str() + 9);
  const std::size_t length = has_body && answer.status >= 200 ? LengthIn(answer.head) : 0;
  while (buffer_.size() < length && Fill()) {
  }
  answer.body = buffer_.substr(0, length);
  buffer_.erase(0, std::min(length, buffer_.size()));
  return answer;
}

bool RawClient::IsClosed() {
  char byte;
  return buffer_.empty() && recv(fd_, &byte, 1, 0) == 0;
}

}  // namespace skyquilt::server
