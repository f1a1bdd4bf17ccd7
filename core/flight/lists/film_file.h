// LooksLikeFilm: whether a file is a film in an MP4 or MOV, by its first bytes (ISO/IEC 14496-12, the file
// type box); pictures in the same container (HEIC, AVIF, CR3) are none. Pure; any thread.
#pragma once

#include <string_view>

namespace skyquilt::flight {

inline constexpr std::size_t kFilmHeadBytes = 12;

bool LooksLikeFilm(std::string_view head);

}  // namespace skyquilt::flight
