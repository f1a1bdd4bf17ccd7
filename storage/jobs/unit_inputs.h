// UnitInputs: what the units of a cut flight are made from, as a digest: the flight's files (what is stored
// under a name never changes), the options, the version of the program and where it cut. Two jobs of one
// digest make the same units, as long as no file came meanwhile and no other version made one of them: a job
// of which that is so loses its digest. Pure; any thread.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "storage/catalogue/catalogue.h"

namespace skyquilt::storage {

struct UnitInputs {
  const std::vector<StoredFile>& files;
  std::string_view options;  // of the job
  std::string_view version;
  int looks = 1;  // units that look at files
};

// "1.0:", the version, before a SHA-256 in hex.
std::string DigestOf(const UnitInputs& inputs);

}  // namespace skyquilt::storage
