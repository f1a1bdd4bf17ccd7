// FileDescriptor: a descriptor that is closed at the end of its scope, unless it was before. One owner;
// moves.
#pragma once

#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace skyquilt {

class FileDescriptor {
 public:
  // Negative: there is none.
  explicit FileDescriptor(int fd = -1) : fd_(fd) {}
  ~FileDescriptor() { Close(); }
  FileDescriptor(FileDescriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  FileDescriptor& operator=(FileDescriptor&&) = delete;
  FileDescriptor(const FileDescriptor&) = delete;
  FileDescriptor& operator=(const FileDescriptor&) = delete;
  bool is_open() const { return fd_ >= 0; }
  int get() const { return fd_; }
  // How many bytes were read: fewer only at the end of the file; negative (errno): it cannot be read.
  ssize_t ReadAt(std::uint64_t offset, void* into, std::size_t bytes) const {
    std::size_t done = 0;
    while (done < bytes) {
      const ssize_t got =
          pread(fd_, static_cast<char*>(into) + done, bytes - done, static_cast<off_t>(offset + done));
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) return got;
      if (got == 0) break;
      done += static_cast<std::size_t>(got);
    }
    return static_cast<ssize_t>(done);
  }
  // How many bytes were written: fewer only where that failed (errno).
  std::size_t Write(const void* from, std::size_t bytes) const {
    std::size_t done = 0;
    while (done < bytes) {
      const ssize_t wrote = write(fd_, static_cast<const char*>(from) + done, bytes - done);
      if (wrote < 0 && errno == EINTR) continue;
      if (wrote < 0) break;
      done += static_cast<std::size_t>(wrote);
    }
    return done;
  }
  void Close() {
    if (fd_ >= 0) close(std::exchange(fd_, -1));
  }

 private:
  int fd_;
};

}  // namespace skyquilt
