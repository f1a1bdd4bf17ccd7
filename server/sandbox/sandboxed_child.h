// A conversation with a process of this binary that decodes files of users (server/sandbox/sandbox.h), over
// one pipe in each direction. SandboxedChild is that process seen from its parent: its messages are not
// trusted, its resource use is watched, and it is ended when the object is destroyed, or by itself when the
// thread that started it ends. MeetParent and ParentsMessages are the process's own side. One thread.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace skyquilt::server {

// Each message is its length (four bytes, little-endian) and that many bytes, never more than the reader's
// limit: the other side may have been compromised by the files it read. Validating the content is up to the
// caller. A reader or writer does not own its descriptor.
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

// What one message of a child may hold.
inline constexpr std::size_t kMaxMessageBytes = std::size_t{64} << 10;

class SandboxedChild {
 public:
  // `words`: what follows the program's name; the number of this process is added ("--parent"). Error:
  // kUnavailable.
  static Result<std::unique_ptr<SandboxedChild>> Start(std::vector<std::string> words);
  ~SandboxedChild();
  SandboxedChild(const SandboxedChild&) = delete;
  SandboxedChild& operator=(const SandboxedChild&) = delete;

  // False: it does not listen.
  bool Tell(std::string_view message);
  // Waits for its next message, `patience` at most. Nothing: none came; is_silent(): and none will.
  std::optional<std::string> Listen(std::chrono::milliseconds patience) { return reader_.Read(patience); }
  bool is_silent() const { return reader_.is_ended(); }

  // Processor time of all its threads so far.
  double CpuS() const;
  // Memory that is its own alone: what it allocated, not the files it maps.
  std::int64_t MemoryBytes() const;

  // Waits for its end, `patience` at most, then kills it. How it ended, as waitpid has it.
  int End(std::chrono::milliseconds patience);
  int Kill() { return End(std::chrono::milliseconds(0)); }

 private:
  SandboxedChild(pid_t pid, int to_child, int from_child)
      : pid_(pid),
        to_child_(to_child),
        from_child_(from_child),
        writer_(to_child),
        reader_(from_child, kMaxMessageBytes) {}

  const pid_t pid_;
  const int to_child_;
  const int from_child_;
  MessageWriter writer_;
  MessageReader reader_;
  std::optional<int> status_;
};

// In such a process, first of all: follows its parent into the end, and takes the descriptor of standard
// output for messages to the parent, so that a library that prints says nothing in between. Nothing: the
// parent is gone.
std::optional<MessageWriter> MeetParent(int parent);
// Everything the parent may say comes as messages on standard input.
MessageReader ParentsMessages();

}  // namespace skyquilt::server
