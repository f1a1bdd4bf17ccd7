// SqliteStatement: a Statement's driver over SQLite. Owns the library's statement. As of statement.h.
#pragma once

#include "storage/db/statement.h"

struct sqlite3_stmt;

namespace skyquilt::storage {

class SqliteStatement final : public StatementDriver {
 public:
  explicit SqliteStatement(sqlite3_stmt* handle) : handle_(handle) {}
  ~SqliteStatement() override;
  void BindInt64(int index, std::int64_t value) override;
  void BindDouble(int index, double value) override;
  void BindText(int index, std::string_view value) override;
  void BindBlob(int index, std::span<const std::uint8_t> value) override;
  void BindNull(int index) override;
  Result<bool> Step() override;
  void Reset() override;
  std::int64_t ColumnInt64(int column) const override;
  double ColumnDouble(int column) const override;
  std::string_view ColumnText(int column) const override;
  std::span<const std::uint8_t> ColumnBlob(int column) const override;
  bool IsNull(int column) const override;

 private:
  sqlite3_stmt* handle_;
};

}  // namespace skyquilt::storage
