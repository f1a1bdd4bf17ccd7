// A conversation with a process of this binary that decodes files of users (server/sandbox/sandbox.h), over
// one pipe in each direction. SandboxedChild is that process seen from its parent: its messages are not
// trusted, its resource use is watched, and it is ended when the object is destroyed, or by itself when the
// thread that started it ends. WorkForParent is the process's own side. One thread.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "core/base/process/file_descriptor.h"
#include "core/base/result.h"
#include "server/sandbox/spawn_process.h"

namespace skyquilt::server {

// Each message is its length (four bytes, little-endian) and that many bytes, never more than the reader's
// limit: the other side may have been compromised by the files it read. Validating the content is up to the
// caller. A reader or writer does not own its descriptor.
class MessageWriter {
 public:
  explicit MessageWriter(int fd) : fd_(fd) {}
  // False: nobody reads any more, or (where the descriptor does not block) not within `patience`, or not
  // before `go_on`, asked some times a second, says that nobody needs it to.
  bool Write(std::string_view message, std::chrono::milliseconds patience = std::chrono::hours(1),
             const std::function<bool()>& go_on = nullptr);

 private:
  int fd_;
};

class MessageReader {
 public:
  MessageReader(int fd, std::size_t max_bytes) : fd_(fd), max_bytes_(max_bytes) {}

  // Waits for the next message, `patience` at most, however much of one there always is to read. Nothing:
  // none came, or is_ended() says why none will.
  std::optional<std::string> Read(std::chrono::milliseconds patience);
  // The other side is gone, or has sent what is no message.
  bool is_ended() const { return is_ended_; }
  // It has begun a message of more than it may say.
  bool is_too_long() const { return is_too_long_; }

 private:
  std::optional<std::string> Next();

  int fd_;
  const std::size_t max_bytes_;
  std::string unread_;
  bool is_ended_ = false;
  bool is_too_long_ = false;
};

// An error within a message, in JSON, with its reason where that is not too long.
nlohmann::json ErrorJson(const Error& error);
// Nothing: it is none that ErrorJson makes.
std::optional<Error> ErrorOfJson(const nlohmann::json& json);

// Whether a text within a message may have been cut to that (CutToBytes) before it came.
bool IsShort(std::string_view text, std::size_t max_bytes);

// What one message of a child may hold.
inline constexpr std::size_t kMaxMessageBytes = std::size_t{64} << 10;

class SandboxedChild {
 public:
  // `command`: of this program, which calls WorkForParent (server/commands/sandboxed.cc). `task`: the first
  // message; one that does not listen does not answer either. `go_on`: false once nobody wants its work any
  // more (the job is cancelled, the server stops): asked wherever a process that hangs would be waited for
  // longer than for the next message. Error: kUnavailable.
  static Result<std::unique_ptr<SandboxedChild>> Start(const char* command, std::string_view task,
                                                       std::function<bool()> go_on,
                                                       std::size_t max_message_bytes = kMaxMessageBytes);
  ~SandboxedChild() { Kill(); }
  SandboxedChild(const SandboxedChild&) = delete;
  SandboxedChild& operator=(const SandboxedChild&) = delete;

  // False: it does not listen.
  bool Tell(std::string_view message);
  // Waits for its next message, `patience` at most. Nothing: none came; is_silent(): and none will.
  std::optional<std::string> Listen(std::chrono::milliseconds patience) { return reader_.Read(patience); }
  bool is_silent() const { return reader_.is_ended(); }
  bool has_said_too_much() const { return reader_.is_too_long(); }

  // Processor time of all its threads so far.
  double CpuS() const;
  // Memory that is its own alone: what it allocated, not the files it maps.
  std::int64_t MemoryBytes() const;

  // After its last word there is nothing left to do: waits some seconds for its end, then, or once nobody
  // wants it, kills it. How it ended, and what it took.
  const ProcessEnd& End();
  const ProcessEnd& Kill();

 private:
  SandboxedChild(pid_t pid, FileDescriptor to_child, FileDescriptor from_child, std::function<bool()> go_on,
                 std::size_t max_message_bytes)
      : pid_(pid),
        go_on_(std::move(go_on)),
        to_child_(std::move(to_child)),
        from_child_(std::move(from_child)),
        writer_(to_child_.get()),
        reader_(from_child_.get(), max_message_bytes) {}

  const pid_t pid_;
  const std::function<bool()> go_on_;
  const FileDescriptor to_child_;
  const FileDescriptor from_child_;
  MessageWriter writer_;
  MessageReader reader_;
  std::optional<ProcessEnd> end_;
};

// All that such a process does: follows its parent into the end and ends for no Ctrl-C before that, takes the
// descriptor of standard output for messages to it, so that a library that prints says nothing in between,
// and lets `work` do the task that is the first message on standard input. The exit code: what `work`
// answers; 1 where there is no parent or task.
int WorkForParent(int parent, const std::function<int(const std::string& task, MessageReader& from_parent,
                                                      MessageWriter& to_parent)>& work);

}  // namespace skyquilt::server
