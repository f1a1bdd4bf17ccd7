// NamedPhotos: the photos of a flight as lists, tables and logs name them, for whoever looks one up. Case
// does not matter; nor do folders while one photo alone is so called, nor an ending that the row lacks or
// that is that of the raw file beside the photo. Pictures of one exposure (one folder and name, other
// endings) share what is said of it. A value that outlives the photos; any thread. Finding costs the
// logarithm of their number.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/flight/photo.h"

namespace skyquilt::poses {

// As names of files are compared: the file's own, in small letters.
std::string PlainFileName(std::string_view name);

class NamedPhotos {
 public:
  explicit NamedPhotos(const std::vector<flight::Photo>& photos);

  struct Found {
    std::vector<std::size_t> photos;  // numbers of those given; empty: none, or it is not told which
    bool is_open = false;  // photos of several folders are so called, and the name has none of these
  };
  Found Find(std::string_view name) const;

 private:
  std::vector<std::string> path_of_;  // by photo: in small letters, folders with '/'
  std::map<std::string, std::vector<std::size_t>, std::less<>>
      photos_of_;  // by plain name, with and without ending
};

}  // namespace skyquilt::poses
