#include "core/poses/lists/named_photos.h"

#include <algorithm>
#include <cctype>

#include "core/flight/bytes/text_fields.h"

namespace skyquilt::poses {
namespace {

constexpr std::size_t kShortestEnding = 2, kLongestEnding = 5;
constexpr std::size_t kMaxOfOneName = 100;  // whose folders are compared with those of each row

std::string PathInSmallLetters(std::string_view name) {
  std::string path = flight::LowerCase(name);
  std::replace(path.begin(), path.end(), '\\', '/');
  return path;
}

std::string_view WithoutFolders(std::string_view path) { return path.substr(path.find_last_of('/') + 1); }

std::string_view WithoutEnding(std::string_view name) { return name.substr(0, name.rfind('.')); }

std::string_view FolderOf(std::string_view path) {
  const std::size_t end = path.find_last_of('/');
  return end == std::string_view::npos ? std::string_view() : path.substr(0, end);
}

// "arw", not the "1_0018" of "field.1_0018".
bool HasEndingOfFile(std::string_view name) {
  const std::size_t dot = name.rfind('.');
  if (dot == std::string_view::npos) return false;
  const std::string_view ending = name.substr(dot + 1);
  return ending.size() >= kShortestEnding && ending.size() <= kLongestEnding &&
         std::all_of(ending.begin(), ending.end(), [](unsigned char c) { return std::isalnum(c) != 0; });
}

// How many folders the two have in common, counted from the file upwards.
int FoldersInCommon(std::string_view a, std::string_view b) {
  int common = 0;
  for (a = FolderOf(a), b = FolderOf(b); !a.empty() && WithoutFolders(a) == WithoutFolders(b); ++common) {
    a = FolderOf(a);
    b = FolderOf(b);
  }
  return common;
}

}  // namespace

std::string PlainFileName(std::string_view name) {
  return std::string(WithoutFolders(PathInSmallLetters(name)));
}

NamedPhotos::NamedPhotos(const std::vector<flight::Photo>& photos) {
  for (std::size_t i = 0; i < photos.size(); ++i) {
    path_of_.push_back(PathInSmallLetters(photos[i].name));
    const std::string_view plain = WithoutFolders(path_of_.back());
    photos_of_[std::string(plain)].push_back(i);
    if (WithoutEnding(plain) != plain) photos_of_[std::string(WithoutEnding(plain))].push_back(i);
  }
}

NamedPhotos::Found NamedPhotos::Find(std::string_view name) const {
  const std::string path = PathInSmallLetters(name);
  const std::string_view plain = WithoutFolders(path);
  auto called = photos_of_.find(plain);
  if (called == photos_of_.end() && HasEndingOfFile(plain)) called = photos_of_.find(WithoutEnding(plain));
  if (called == photos_of_.end()) return {};
  if (called->second.size() > kMaxOfOneName) return {.photos = {}, .is_open = true};
  Found found;
  int most = 0;
  for (const std::size_t i : called->second) {
    const int common = FoldersInCommon(path, path_of_[i]);
    if (common > most) found.photos.clear();
    most = std::max(most, common);
    if (common == most) found.photos.push_back(i);
  }
  const std::string_view folder = FolderOf(path_of_[found.photos.front()]);
  found.is_open = std::any_of(found.photos.begin(), found.photos.end(),
                              [&](std::size_t i) { return FolderOf(path_of_[i]) != folder; });
  if (found.is_open) found.photos.clear();
  return found;
}

}  // namespace skyquilt::poses
