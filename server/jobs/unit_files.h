// UnitFiles: what the units of a job leave below its folder, and under which names. Each unit writes into a
// folder of its own; a file that has its name is whole. A value; any thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <utility>

namespace skyquilt::server {

enum class UnitKind { kLook, kPlace, kRender };
// "look", "place", "render"
const char* UnitKindName(UnitKind kind);

struct UnitToDo {
  UnitKind kind = UnitKind::kLook;
  int number = 0;           // of its kind
  int count = 1;            // units of its kind
  std::int64_t blocks = 0;  // of the whole map; for rendering
  int looks = 0;            // units that looked at photos; for placing
};

inline constexpr const char* kFoundFile = "found.cbor";  // pipeline::WriteFound
inline constexpr const char* kFactsFile = "facts.cbor";  // pipeline::PlacedUnit::facts
inline constexpr const char* kShownFile = "shown.cbor";  // pipeline::WriteShown

// Whether files of these names are all that a unit of this kind leaves.
bool IsWhole(UnitKind kind, const std::set<std::string>& names);

class UnitFiles {
 public:
  explicit UnitFiles(std::filesystem::path root) : root_(std::move(root)) {}
  const std::filesystem::path& root() const { return root_; }

  std::filesystem::path Folder(UnitKind kind, int number) const;
  // Of the files that unit `number` looked at.
  std::filesystem::path Found(int number) const { return Folder(UnitKind::kLook, number) / kFoundFile; }
  std::filesystem::path Facts() const { return Folder(UnitKind::kPlace, 0) / kFactsFile; }
  std::filesystem::path Shown() const { return Folder(UnitKind::kPlace, 0) / kShownFile; }

 private:
  std::filesystem::path root_;
};

}  // namespace skyquilt::server
