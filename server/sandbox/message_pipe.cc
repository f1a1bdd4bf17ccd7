#include "server/sandbox/message_pipe.h"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <limits>

namespace skyquilt::server {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kHeadBytes = 4;

// Whether something happens on the descriptor before `end`.
bool Wait(int fd, short events, Clock::time_point end) {
  while (true) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now()).count();
    pollfd wanted{fd, events, 0};
    const int most = std::numeric_limits<int>::max();
    const int happened = poll(&wanted, 1, static_cast<int>(std::clamp<std::int64_t>(left, 0, most)));
    if (happened > 0) return true;
    if (happened == 0 || errno != EINTR) return false;
  }
}

}  // namespace

bool MessageWriter::Write(std::string_view message, std::chrono::milliseconds patience) {
  const auto end = Clock::now() + patience;
  std::string bytes;
  bytes.reserve(kHeadBytes + message.size());
  for (std::size_t i = 0; i < kHeadBytes; ++i)
    bytes.push_back(static_cast<char>((message.size() >> (8 * i)) & 0xff));
  bytes.append(message);
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t wrote = write(fd_, bytes.data() + done, bytes.size() - done);
    if (wrote > 0) {
      done += static_cast<std::size_t>(wrote);
    } else if (errno == EAGAIN) {
      if (!Wait(fd_, POLLOUT, end)) return false;
    } else if (errno != EINTR) {
      return false;
    }
  }
  return true;
}

std::optional<std::string> MessageReader::Next() {
  if (unread_.size() < kHeadBytes) return std::nullopt;
  std::size_t length = 0;
  for (std::size_t i = 0; i < kHeadBytes; ++i)
    length |= static_cast<std::size_t>(static_cast<unsigned char>(unread_[i])) << (8 * i);
  if (length > max_bytes_) {
    is_ended_ = true;
    return std::nullopt;
  }
  if (unread_.size() < kHeadBytes + length) return std::nullopt;
  std::string message = unread_.substr(kHeadBytes, length);
  unread_.erase(0, kHeadBytes + length);
  return message;
}

std::optional<std::string> MessageReader::Read(std::chrono::milliseconds patience) {
  const auto end = Clock::now() + patience;
  while (!is_ended_) {
    if (auto message = Next()) return message;
    if (is_ended_ || !Wait(fd_, POLLIN, end)) break;
    char block[16 * 1024];
    const ssize_t got = read(fd_, block, sizeof(block));
    if (got > 0) {
      unread_.append(block, static_cast<std::size_t>(got));
    } else if (got == 0 || (errno != EINTR && errno != EAGAIN)) {
      is_ended_ = true;
    }
  }
  return std::nullopt;
}

}  // namespace skyquilt::server
