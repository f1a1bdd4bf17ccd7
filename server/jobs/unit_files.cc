#include "server/jobs/unit_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <initializer_list>

namespace skyquilt::server {

const char* UnitKindName(UnitKind kind) {
  constexpr std::array kNames = {"look", "place", "render"};
  return kNames[static_cast<std::size_t>(kind)];
}

bool IsWhole(UnitKind kind, const std::set<std::string>& names) {
  const auto has = [&](std::initializer_list<const char*> wanted) {
    return std::all_of(wanted.begin(), wanted.end(), [&](const char* name) { return names.contains(name); });
  };
  switch (kind) {
    case UnitKind::kLook:
      return has({kFoundFile});
    case UnitKind::kPlace:
      return has({kFactsFile, kShownFile});
    case UnitKind::kRender:
      break;
  }
  return has({"mosaic.mbtiles", "mosaic.state"});
}

std::filesystem::path UnitFiles::Folder(UnitKind kind, int number) const {
  return root_ / fmt::format("{}-{}", UnitKindName(kind), number);
}

}  // namespace skyquilt::server
