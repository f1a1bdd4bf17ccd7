#include "core/base/text/file_names.h"

#include <algorithm>
#include <array>
#include <map>
#include <set>

#include "core/base/text/plain_text.h"

namespace skyquilt {
namespace {

// What a photo and the files that go with it have in common ("a/DJI_0001.JPG", "a/DJI_0001.JPG.xmp").
std::string CompanyOf(const std::string& path) {
  const std::string_view file = FileOf(path);
  return std::string(FolderOf(path)) + "/" + LowerCase(file.substr(0, file.find('.')));
}

// "a/b/c", 2 -> "b/c"
std::string LastParts(const std::string& folder, std::size_t parts) {
  if (folder.empty()) return folder;
  std::size_t begin = folder.size();
  for (; parts > 0 && begin != std::string::npos && begin > 0; --parts)
    begin = folder.find_last_of('/', begin - 1);
  return begin == std::string::npos ? folder : begin == 0 ? folder.substr(1) : folder.substr(begin + 1);
}

// By folder the last parts that tell it from the others.
std::map<std::string, std::string> LabelsOf(const std::set<std::string>& folders) {
  std::map<std::string, std::string> labels;
  std::vector<std::string> open(folders.begin(), folders.end());
  for (std::size_t parts = 1; parts <= kMaxFoldersOfName && !open.empty(); ++parts) {
    std::map<std::string, std::size_t> times;
    for (const std::string& folder : open) {
      labels[folder] = LastParts(folder, parts);
      ++times[LowerCase(labels[folder])];
    }
    std::erase_if(open, [&](const std::string& folder) { return times[LowerCase(labels[folder])] == 1; });
  }
  return labels;
}

}  // namespace

std::string_view FileOf(std::string_view path) { return path.substr(path.find_last_of('/') + 1); }

std::string_view FolderOf(std::string_view path) {
  const std::size_t end = path.find_last_of('/');
  return end == std::string_view::npos ? std::string_view() : path.substr(0, end);
}

bool IsOfPrograms(std::string_view name) {
  constexpr std::array<std::string_view, 6> kFolders = {
      "@eadir", "@recycle", "#recycle", "$recycle.bin", "system volume information", "__macosx"};
  return name.starts_with('.') ||
         std::find(kFolders.begin(), kFolders.end(), LowerCase(name)) != kFolders.end();
}

bool IsNamedAsPicture(std::string_view file) {
  constexpr std::array<std::string_view, 6> kEndings = {"jpg", "jpeg", "tif", "tiff", "png", "dng"};
  const std::size_t dot = file.rfind('.');
  if (dot == std::string_view::npos || dot == 0) return false;
  const std::string ending = LowerCase(file.substr(dot + 1));
  return std::find(kEndings.begin(), kEndings.end(), ending) != kEndings.end();
}

std::string NumberedName(std::string_view name, std::string_view mark) {
  const std::size_t dot = name.rfind('.');
  // An ending of a folder's is none of the file's, nor is ".hidden" one.
  const bool has_ending = dot != std::string_view::npos && dot > name.find_last_of('/') + 1;
  const std::string_view stem = has_ending ? name.substr(0, dot) : name;
  std::string numbered(stem);
  return numbered.append("(").append(mark).append(")").append(name.substr(stem.size()));
}

std::vector<std::string> NamesApart(const std::vector<std::string>& paths) {
  std::map<std::string, std::string> first_folder;  // by plain name
  std::set<std::string> doubled;                    // plain names that files of several folders have
  for (const std::string& path : paths) {
    const std::string plain = LowerCase(FileOf(path)), folder(FolderOf(path));
    if (first_folder.try_emplace(plain, folder).first->second != folder) doubled.insert(plain);
  }
  const auto is_doubled = [&](const std::string& path) { return doubled.contains(LowerCase(FileOf(path))); };
  std::set<std::string> folders;
  std::map<std::string, bool> is_picture_doubled;  // by company
  for (const std::string& path : paths) {
    if (is_doubled(path)) folders.emplace(FolderOf(path));
    if (!IsNamedAsPicture(FileOf(path))) continue;
    bool& is_any_doubled = is_picture_doubled[CompanyOf(path)];
    is_any_doubled = is_any_doubled || is_doubled(path);
  }
  const auto keeps_folder = [&](const std::string& path) {
    const auto picture = is_picture_doubled.find(CompanyOf(path));
    return is_doubled(path) || picture == is_picture_doubled.end() || picture->second;
  };
  const std::map<std::string, std::string> labels = LabelsOf(folders);
  std::vector<std::string> names;
  std::set<std::string> taken;
  std::map<std::string, int> copies;
  for (const std::string& path : paths) {
    std::string name(FileOf(path));
    const auto label = labels.find(std::string(FolderOf(path)));
    if (label != labels.end() && !label->second.empty() && keeps_folder(path))
      name = label->second + "/" + name;
    const std::string own = name;
    while (!taken.insert(name).second)
      name = NumberedName(own, std::to_string(++copies.try_emplace(own, 1).first->second));
    names.push_back(std::move(name));
  }
  return names;
}

std::string WithFoldersJoined(std::string name) {
  std::replace(name.begin(), name.end(), '/', '_');
  return name;
}

}  // namespace skyquilt
