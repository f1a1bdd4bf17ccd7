// UnitInputs: what the units of a cut flight are made from, as a digest: the flight's files (what is stored
// under a name never changes), the options, the version that cut it and where. Two jobs of one digest make
// the same units, as long as no file came meanwhile: a job to whose flight one came loses its digest. Pure;
// any thread.
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

// SHA-256, in hex.
std::string DigestOf(const UnitInputs& inputs);

}  // namespace skyquilt::storage
