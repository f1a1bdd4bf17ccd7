#include "storage/db/statement.h"

#include "core/base/try.h"

namespace skyquilt::storage {

Result<std::vector<std::string>> Statement::AllText() {
  std::vector<std::string> texts;
  while (true) {
    const Result<bool> row = Step();
    if (!row) return row.error();
    if (!*row) return texts;
    texts.emplace_back(ColumnText(0));
  }
}

Result<void> Statement::Run() {
  while (true) {
    SKYQUILT_TRY_ASSIGN(const bool row, Step());
    if (!row) break;
  }
  Reset();
  return {};
}

}  // namespace skyquilt::storage
