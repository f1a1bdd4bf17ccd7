#include "core/poses/lists/named_photos.h"

#include <algorithm>
#include <cctype>

#include "core/base/text/file_names.h"
#include "core/flight/bytes/composed_letters.h"
#include "core/flight/bytes/text_fields.h"

namespace skyquilt::poses {
namespace {

constexpr std::size_t kShortestEnding = 2, kLongestEnding = 5;
constexpr std::size_t kMaxOfOneName = 100;  // whose folders are compared with those of each row
constexpr std::size_t kEnoughDoubles = 4;   // to know that there is one besides the pictures of an exposure
constexpr int kMaxJoints = 16;              // at which a name may be folders and the file's own

std::string PathInSmallLetters(std::string_view name) {
  std::string path = flight::LowerCase(flight::WithComposedLetters(name));
  std::replace(path.begin(), path.end(), '\\', '/');
  return path;
}

std::string_view WithoutEnding(std::string_view name) { return name.substr(0, name.rfind('.')); }

bool IsOneWord(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isalnum(c) != 0; });
}

// "arw", not the "1_0018" of "field.1_0018".
bool HasEndingOfFile(std::string_view name) {
  const std::size_t dot = name.rfind('.');
  if (dot == std::string_view::npos) return false;
  const std::string_view ending = name.substr(dot + 1);
  return ending.size() >= kShortestEnding && ending.size() <= kLongestEnding && IsOneWord(ending);
}

std::string_view WithoutEndingOfFile(std::string_view name) {
  return HasEndingOfFile(name) ? WithoutEnding(name) : name;
}

// "dji_0001" of "dji_0001(2)", as servers and file managers number a second file; nothing of others.
std::string_view WithoutNumber(std::string_view stem) {
  const std::size_t bracket = stem.rfind('(');
  if (bracket == std::string_view::npos || bracket == 0 || !stem.ends_with(')')) return {};
  const std::string_view number = stem.substr(bracket + 1, stem.size() - bracket - 2);
  return number.empty() || !IsOneWord(number) ? std::string_view() : flight::Trim(stem.substr(0, bracket));
}

// What a file may have been called before folders were joined to its name or it was numbered; no ending.
std::vector<std::string_view> OriginalsOf(std::string_view plain) {
  const std::string_view stem = WithoutEndingOfFile(plain);
  std::vector<std::string_view> originals;
  if (const std::string_view unnumbered = WithoutNumber(stem); !unnumbered.empty())
    originals.push_back(unnumbered);
  std::string_view rest = stem;
  for (int joint = 0; joint < kMaxJoints; ++joint) {
    const std::size_t line = rest.find('_');
    if (line == std::string_view::npos || line + 1 == rest.size()) break;
    rest.remove_prefix(line + 1);
    originals.push_back(rest);
  }
  return originals;
}

// "dji_0001", neither "0001" nor "v": what is left of a name by chance is no camera's name.
bool LooksLikeNameOfCamera(std::string_view stem) {
  return std::any_of(stem.begin(), stem.end(), [](unsigned char c) { return std::isalpha(c) != 0; }) &&
         std::any_of(stem.begin(), stem.end(), [](unsigned char c) { return std::isdigit(c) != 0; });
}

// How many folders the two have in common, counted from the file upwards.
int FoldersInCommon(std::string_view a, std::string_view b) {
  int common = 0;
  for (a = FolderOf(a), b = FolderOf(b); !a.empty() && FileOf(a) == FileOf(b); ++common) {
    a = FolderOf(a);
    b = FolderOf(b);
  }
  return common;
}

}  // namespace

std::string PlainFileName(std::string_view name) { return std::string(FileOf(PathInSmallLetters(name))); }

NamedPhotos::NamedPhotos(const std::vector<flight::Photo>& photos) {
  for (std::size_t i = 0; i < photos.size(); ++i) {
    path_of_.push_back(PathInSmallLetters(photos[i].name));
    Register(path_of_.back(), i);
    for (const std::string& other : photos[i].other_names) Register(PathInSmallLetters(other), i);
    for (const std::string_view original : OriginalsOf(FileOf(path_of_.back()))) {
      Numbers& doubles = doubles_of_[std::string(original)];
      if (doubles.size() < kEnoughDoubles) doubles.push_back(i);
    }
  }
}

void NamedPhotos::Register(std::string_view path, std::size_t photo) {
  const std::string_view plain = FileOf(path);
  for (const std::string_view name : {plain, WithoutEnding(plain)}) {
    Numbers& called = photos_of_[std::string(name)];
    if (called.empty() || called.back() != photo) called.push_back(photo);
  }
}

const NamedPhotos::Numbers* NamedPhotos::Called(std::string_view plain) const {
  auto called = photos_of_.find(plain);
  if (called == photos_of_.end() && HasEndingOfFile(plain)) called = photos_of_.find(WithoutEnding(plain));
  return called == photos_of_.end() ? nullptr : &called->second;
}

// Photos whose names have the folders of `path`, or of the list's name, joined to them: as many as can be.
const NamedPhotos::Numbers* NamedPhotos::CalledWithFolder(std::string_view path, const List& list) const {
  const std::string_view plain = FileOf(path);
  std::vector<std::string> joined;  // from the file upwards
  std::string_view folders = FolderOf(path);
  for (std::size_t k = 0; k < kMaxFoldersOfName && !folders.empty(); ++k) {
    const std::string_view below = joined.empty() ? plain : std::string_view(joined.back());
    joined.push_back(std::string(FileOf(folders)) + "_" + std::string(below));
    folders = FolderOf(folders);
  }
  if (joined.empty() && !list.calls_doubles_so) {
    const std::string_view list_file = FileOf(list.path);
    std::size_t line = list_file.find('_');
    for (int joint = 0; joint < kMaxJoints && line != std::string_view::npos; ++joint) {
      joined.push_back(std::string(list_file.substr(0, line + 1)) + std::string(plain));
      line = list_file.find('_', line + 1);
    }
  }
  for (auto name = joined.rbegin(); name != joined.rend(); ++name) {
    if (const Numbers* called = Called(*name)) return called;
  }
  return nullptr;
}

bool NamedPhotos::HasOtherDouble(std::string_view plain, const Numbers& but) const {
  const auto doubles = doubles_of_.find(WithoutEndingOfFile(plain));
  return doubles != doubles_of_.end() &&
         std::any_of(doubles->second.begin(), doubles->second.end(),
                     [&](std::size_t i) { return std::find(but.begin(), but.end(), i) == but.end(); });
}

// Whether another photo has the name that this one may have had before.
bool NamedPhotos::IsDouble(std::size_t photo) const {
  const std::vector<std::string_view> originals = OriginalsOf(FileOf(path_of_[photo]));
  return std::any_of(originals.begin(), originals.end(), [&](std::string_view original) {
    const auto called = photos_of_.find(original);
    return called != photos_of_.end() && called->second.front() != photo;
  });
}

std::vector<NamedPhotos::Found> NamedPhotos::FindAll(std::string_view list_name,
                                                     const std::vector<std::string_view>& names) const {
  std::vector<std::string> paths;
  List list{PathInSmallLetters(list_name), false};
  for (const std::string_view name : names) {
    paths.push_back(PathInSmallLetters(name));
    const Numbers* called = Called(FileOf(paths.back()));
    list.calls_doubles_so = list.calls_doubles_so || (called != nullptr && IsDouble(called->front()));
  }
  std::vector<Found> found;
  for (const std::string& path : paths) found.push_back(Find(path, list));
  return found;
}

std::vector<NamedPhotos::Found> NamedPhotos::FindAll(const flight::FlightLog& log) const {
  std::vector<std::string_view> names;
  for (const flight::CameraEvent& event : log.events)
    names.push_back(event.image_name ? std::string_view(*event.image_name) : std::string_view());
  return FindAll(log.file_name, names);
}

NamedPhotos::Found NamedPhotos::Find(std::string_view row, const List& list) const {
  const std::string_view plain = FileOf(row);
  if (plain.empty()) return {};
  // Rows without folders are of the list's own, unless it calls photos by what the folders were joined to.
  const std::string_view list_folder = list.calls_doubles_so ? std::string_view() : FolderOf(list.path);
  const bool is_of_list = FolderOf(row).empty() && !list_folder.empty();
  const std::string path =
      is_of_list ? std::string(list_folder) + "/" + std::string(plain) : std::string(row);
  if (const Numbers* joined = CalledWithFolder(path, list)) return {.photos = *joined, .is_open = false};
  const Numbers* called = Called(plain);
  if (called == nullptr) {
    // Two that are only so called with folders in front, of which the row has none.
    const auto doubles = doubles_of_.find(WithoutEndingOfFile(plain));
    const bool is_open =
        doubles != doubles_of_.end() && doubles->second.size() > 1 && LooksLikeNameOfCamera(doubles->first);
    return {.photos = {}, .is_open = is_open};
  }
  if (called->size() > kMaxOfOneName) return {.photos = {}, .is_open = true};
  Found found;
  int most = 0;
  for (const std::size_t i : *called) {
    const int common = FoldersInCommon(path, path_of_[i]);
    if (common > most) found.photos.clear();
    most = std::max(most, common);
    if (common == most) found.photos.push_back(i);
  }
  const std::string_view folder = FolderOf(path_of_[found.photos.front()]);
  found.is_open = std::any_of(found.photos.begin(), found.photos.end(),
                              [&](std::size_t i) { return FolderOf(path_of_[i]) != folder; }) ||
                  (most == 0 && !list.calls_doubles_so && HasOtherDouble(plain, *called));
  if (found.is_open) found.photos.clear();
  return found;
}

}  // namespace skyquilt::poses
