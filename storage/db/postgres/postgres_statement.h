// PostgresStatement: a Statement's driver over PostgreSQL. The first Step runs it and fetches all of its
// rows. Parameters go in binary with their types: int8, float8, text, bytea. Otherwise as Statement says.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "storage/db/postgres/postgres_db.h"
#include "storage/db/sql_connection.h"

namespace skyquilt::storage {

// "WHERE a=? AND b=?2" -> "WHERE a=$1 AND b=$2", outside of quotes. A bare ? is one more than the highest
// before it, as SQLite has it.
struct NumberedSql {
  std::string text;
  int parameters = 0;
};
NumberedSql NumberParameters(std::string_view sql);

class PostgresStatement final : public StatementDriver {
 public:
  PostgresStatement(PostgresDb& db, std::string_view sql);
  bool IsNull(int column) const override;
  std::string_view ColumnText(int column) const override;
  std::int64_t ColumnInt64(int column) const override;
  double ColumnDouble(int column) const override;
  std::span<const std::uint8_t> ColumnBlob(int column) const override;
  Result<bool> Step() override;
  void Reset() override;
  void BindNull(int index) override;
  void BindText(int index, std::string_view value) override;
  void BindInt64(int index, std::int64_t value) override;
  void BindDouble(int index, double value) override;
  void BindBlob(int index, std::span<const std::uint8_t> value) override;

 private:
  void BindNumber(int index, std::uint32_t type, std::uint64_t bits);
  PgParameter& At(int index);

  PostgresDb& db_;
  NumberedSql sql_;
  std::vector<PgParameter> parameters_;
  PgResult result_;
  int row_ = -1;
  mutable std::vector<std::vector<std::uint8_t>> blobs_;  // of this row
};

}  // namespace skyquilt::storage
