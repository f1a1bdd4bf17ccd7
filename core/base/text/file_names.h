// The names of files that several folders bring together: what tells files of one plain name apart, as every
// way into a flight does it (the command line, archives, `upload`; web/src/upload/drop_files.js and the
// Python client do the same), and as core/poses/lists finds the photos that lists name. Pure; any thread.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace skyquilt {

// So many folders stand in front of a name at most.
inline constexpr std::size_t kMaxFoldersOfName = 8;

// "c.jpg" and "a/b" of "a/b/c.jpg".
std::string_view FileOf(std::string_view path);
std::string_view FolderOf(std::string_view path);

// Whether a file or folder of this name (without folders) is hidden, or what systems and programs keep for
// themselves: a Mac's attributes, previews of network drives, deleted files. No way into a flight takes it.
bool IsOfPrograms(std::string_view name);

// By its ending, in any case: "a.JPG", not ".jpg".
bool IsNamedAsPicture(std::string_view file);

// The second file of a name, with a mark in front of the ending: "a.jpg", "2" -> "a(2).jpg". Without a blank,
// which geo.txt cannot hold, and unlike a camera's own numbers.
std::string NumberedName(std::string_view name, std::string_view mark);

// A name for each of these paths (folders with '/'), each once: the file's own where no other has it in any
// case, else with as many of its folders in front as tell it from the others: "100MEDIA/DJI_0001.JPG" and
// "101MEDIA/DJI_0001.JPG". So are called the files beside such that are no pictures, whatever else has their
// name: a list counts for the photos of its own folder. What has a picture's name but for the ending (a
// sidecar) is called as that picture is. A number is the last resort.
std::vector<std::string> NamesApart(const std::vector<std::string>& paths);

// For those who take no folders: "101MEDIA_DJI_0001.JPG".
std::string WithFoldersJoined(std::string name);

}  // namespace skyquilt
