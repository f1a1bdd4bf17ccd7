#include "core/flight/lists/film_file.h"

#include <algorithm>
#include <array>

namespace skyquilt::flight {

bool LooksLikeFilm(std::string_view head) {
  if (head.size() < kFilmHeadBytes || head.substr(4, 4) != "ftyp") return false;
  constexpr std::array<std::string_view, 8> kPictures = {"heic", "heix", "hevc", "heim",
                                                         "heis", "mif1", "avif", "crx "};
  return std::find(kPictures.begin(), kPictures.end(), head.substr(8, 4)) == kPictures.end();
}

}  // namespace skyquilt::flight
