#include <algorithm>
#include <set>

#include "core/flight/read_flight.h"

namespace skyquilt::flight {
namespace {

namespace fs = std::filesystem;

bool IsHidden(const fs::path& path) { return path.filename().string().starts_with("."); }

Result<void> WalkFolder(const fs::path& folder, std::vector<fs::path>& found) {
  std::error_code error;
  fs::recursive_directory_iterator it(folder, fs::directory_options::skip_permission_denied, error);
  std::vector<fs::path> paths;
  while (!error && it != fs::recursive_directory_iterator()) {
    std::error_code ignored_kind;  // a file that vanished is no file
    if (IsHidden(it->path())) {
      if (it->is_directory(ignored_kind)) it.disable_recursion_pending();
    } else if (!it->is_directory(ignored_kind)) {
      paths.push_back(it->path());  // links to nothing and pipes too: reading them says what is wrong
    }
    it.increment(error);
  }
  if (error) {
    return Error{ErrorCode::kIo,
                 "The folder " + folder.string() + " cannot be read: " + error.message() + ".", ""};
  }
  std::sort(paths.begin(), paths.end());
  found.insert(found.end(), paths.begin(), paths.end());
  return {};
}

// The file's name alone where it is unique, else with as many folders in front as it takes.
std::string UniqueName(const fs::path& path, const std::set<std::string>& taken) {
  std::string name = path.filename().string();
  fs::path folder = path.parent_path();
  while (taken.contains(name) && !folder.filename().empty()) {
    name = folder.filename().string() + "/" + name;
    folder = folder.parent_path();
  }
  for (int copy = 2; taken.contains(name); ++copy) {
    name = path.filename().string() + " (" + std::to_string(copy) + ")";
  }
  return name;
}

}  // namespace

Result<std::vector<InputFile>> ListInputFiles(const std::vector<fs::path>& paths) {
  std::vector<fs::path> found;
  for (const fs::path& path : paths) {
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    if (!fs::exists(status))
      return Error{ErrorCode::kNotFound, "There is no file or folder " + path.string() + ".", ""};
    if (!fs::is_directory(status)) {
      found.push_back(path);
    } else if (auto walked = WalkFolder(path, found); !walked) {
      return walked.error();
    }
  }
  std::vector<InputFile> files;
  std::set<std::string> names;
  std::set<fs::path> seen;
  for (const fs::path& path : found) {
    if (!seen.insert(path.lexically_normal()).second) continue;  // given twice
    std::string name = UniqueName(path, names);
    names.insert(name);
    files.push_back({std::move(name), path});
  }
  return files;
}

}  // namespace skyquilt::flight
