#include "storage/db/statement.h"

#include "core/base/try.h"

namespace skyquilt::storage {

Result<std::vector<std::string>> Statement::AllText() {
  return All([](const Statement& row) { return std::string(row.ColumnText(0)); });
}

Result<std::int64_t> Statement::Number() {
  SKYQUILT_TRY_ASSIGN(const auto number, First([](const Statement& row) { return row.ColumnInt64(0); }));
  return number.value_or(0);
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
