// NamedPhotos: the photos of a flight as lists, tables and logs name them, for whoever looks one up. Case
// does not matter, nor whether a letter with a mark is one character or two; nor do folders while one photo
// alone is so called, nor an ending that the row lacks or that is that of the raw file beside the photo.
// Pictures of one exposure (one folder and name, other endings) share what is said of it. Photos of several
// cards may share a name. What tells them apart is the folder in the row, or else the list's own, against
// that of the photo: in front of its name with a '/', or joined to it ("101MEDIA_DJI_0001.JPG"). While
// "DJI_0001.JPG" has such a double, or a numbered one ("DJI_0001(2).JPG"), a row of that name means none of
// them, unless its list calls doubles by their full names. A value that outlives the photos; any thread.
// Finding costs the logarithm of their number.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/flight/logs/flight_log.h"
#include "core/flight/photo.h"

namespace skyquilt::poses {

// As names of files are compared: the file's own, in small letters.
std::string PlainFileName(std::string_view name);

class NamedPhotos {
 public:
  explicit NamedPhotos(const std::vector<flight::Photo>& photos);

  struct Found {
    std::vector<std::size_t> photos;  // numbers of those given; empty: none, or it is not told which
    bool is_open = false;             // several photos are so called, and nothing tells which one is meant
  };
  // All names of one list, which together tell more.
  std::vector<Found> FindAll(std::string_view list_name, const std::vector<std::string_view>& names) const;
  // By event of the log; nothing for events without a name.
  std::vector<Found> FindAll(const flight::FlightLog& log) const;

 private:
  struct List {
    std::string path;               // as paths are compared
    bool calls_doubles_so = false;  // by their full names: then plain names are full ones too
  };
  using Numbers = std::vector<std::size_t>;

  void Register(std::string_view path, std::size_t photo);
  const Numbers* Called(std::string_view plain) const;
  const Numbers* CalledWithFolder(std::string_view path, const List& list) const;
  bool HasOtherDouble(std::string_view plain, const Numbers& but) const;
  bool IsDouble(std::size_t photo) const;
  Found Find(std::string_view path, const List& list) const;

  std::vector<std::string> path_of_;                        // by photo: in small letters, folders with '/'
  std::map<std::string, Numbers, std::less<>> photos_of_;   // by plain name, with and without ending
  std::map<std::string, Numbers, std::less<>> doubles_of_;  // by plain name without ending: the first of them
};

}  // namespace skyquilt::poses
