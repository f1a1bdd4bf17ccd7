// Messages over a pipe between two of our processes, of which the other may have been compromised by the
// files it read: each message is its length (four bytes, little-endian) and that many bytes, never more than
// the reader's limit. Validating the content is up to the caller. A reader or writer is used by one thread at
// a time and does not own its descriptor.
#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace skyquilt::server {

class MessageWriter {
 public:
  explicit MessageWriter(int fd) : fd_(fd) {}
  // False: nobody reads any more, or not within `patience` (where the descriptor does not block).
  bool Write(std::string_view message, std::chrono::milliseconds patience = std::chrono::hours(1));

 private:
  int fd_;
};

class MessageReader {
 public:
  MessageReader(int fd, std::size_t max_bytes) : fd_(fd), max_bytes_(max_bytes) {}

  // Waits for the next message, `patience` at most. Nothing: none came, or is_ended() says why none will.
  std::optional<std::string> Read(std::chrono::milliseconds patience);
  // The other side is gone, or has sent what is no message.
  bool is_ended() const { return is_ended_; }

 private:
  std::optional<std::string> Next();

  int fd_;
  const std::size_t max_bytes_;
  std::string unread_;
  bool is_ended_ = false;
};

}  // namespace skyquilt::server
