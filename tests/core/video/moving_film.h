// A film of a camera that moves over painted ground.
#pragma once

#include <filesystem>
#include <functional>

namespace skyquilt::video {

constexpr int kFilmWidthPx = 640, kFilmHeightPx = 480, kFilmFramesPerS = 30;

// MPEG-4 part 2 in an MP4; frame k shows the ground from `left_px(k)` on. False: this machine has no encoder
// for it.
bool WriteFilm(const std::filesystem::path& path, int frames, const std::function<int(int)>& left_px);

}  // namespace skyquilt::video
