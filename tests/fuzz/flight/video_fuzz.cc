// Films as libav reads them, and the subtitles within.
#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <string>

#include "core/base/check.h"
#include "core/video/video_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace skyquilt;
  const int fd = memfd_create("film", MFD_CLOEXEC);
  SKYQUILT_CHECK(fd >= 0 && write(fd, data, size) == static_cast<ssize_t>(size),
                 "the film's bytes are in memory");
  const std::string path = "/proc/self/fd/" + std::to_string(fd);
  (void)video::VideoFile::Subtitles(path);
  auto film = video::VideoFile::Open(path, 1);
  constexpr int kMaxPixels = 1 << 20, kMaxFrames = 8;  // more only takes longer
  if (film && film->facts().width_px <= kMaxPixels / film->facts().height_px) {
    for (int k = 0; k < kMaxFrames; ++k) {
      const auto next = film->Next();
      if (!next || !*next) break;
      (void)film->Gray(64);
      film->Keep();
      (void)film->Kept();
    }
  }
  close(fd);
  return 0;
}
