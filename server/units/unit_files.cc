#include "server/units/unit_files.h"

#include <fmt/format.h>

#include <array>

namespace skyquilt::server {

const char* UnitKindName(UnitKind kind) {
  constexpr std::array kNames = {"look", "place", "render"};
  return kNames[static_cast<std::size_t>(kind)];
}

std::filesystem::path UnitFiles::Folder(UnitKind kind, int number) const {
  return root_ / fmt::format("{}-{}", UnitKindName(kind), number);
}

}  // namespace skyquilt::server
