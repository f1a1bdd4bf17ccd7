// A film of a camera that moves over painted ground, and a folder to keep it in.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "tests/support/temporary_folder.h"

namespace skyquilt::video {

constexpr int kFilmWidthPx = 640, kFilmHeightPx = 480, kFilmFramesPerS = 30;

class FilmFolder : public test::TemporaryFolder {
 public:
  std::filesystem::path Write(const std::string& name, const std::string& bytes) const;
};

// MPEG-4 part 2 in an MP4; frame k shows the ground from `left_px(k)` on. False: this machine has no encoder
// for it.
bool WriteFilm(const std::filesystem::path& path, int frames, const std::function<int(int)>& left_px);

}  // namespace skyquilt::video
