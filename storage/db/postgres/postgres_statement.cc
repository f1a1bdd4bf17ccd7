#include "storage/db/postgres/postgres_statement.h"

#include <endian.h>
#include <libpq-fe.h>

#include <algorithm>
#include <bit>
#include <charconv>

#include "core/base/check.h"

namespace skyquilt::storage {
namespace {

// Types of PostgreSQL's catalogue, fixed for ever.
constexpr std::uint32_t kBool = 16, kBytea = 17, kInt8 = 20, kText = 25, kFloat8 = 701;

}  // namespace

NumberedSql NumberParameters(std::string_view sql) {
  NumberedSql numbered;
  char quote = '\0';
  for (std::size_t i = 0; i < sql.size(); ++i) {
    const char c = sql[i];
    if (quote != '\0') {
      if (c == quote) quote = '\0';
    } else if (c == '\'' || c == '"') {
      quote = c;
    } else if (c == '?') {
      int number = 0;
      const char* begin = sql.data() + i + 1;
      const auto parsed = std::from_chars(begin, sql.data() + sql.size(), number);
      if (parsed.ec != std::errc()) number = numbered.parameters + 1;
      if (parsed.ec == std::errc()) i += static_cast<std::size_t>(parsed.ptr - begin);
      numbered.parameters = std::max(numbered.parameters, number);
      numbered.text += "$" + std::to_string(number);
      continue;
    }
    numbered.text.push_back(c);
  }
  return numbered;
}

PostgresStatement::PostgresStatement(PostgresDb& db, std::string_view sql)
    : db_(db), sql_(NumberParameters(sql)), parameters_(static_cast<std::size_t>(sql_.parameters)) {}

PgParameter& PostgresStatement::At(int index) {
  SKYQUILT_CHECK(index >= 1 && index <= sql_.parameters, "a parameter that the SQL does not have");
  return parameters_[static_cast<std::size_t>(index - 1)];
}

void PostgresStatement::BindNumber(int index, std::uint32_t type, std::uint64_t bits) {
  const std::uint64_t big_endian = htobe64(bits);
  At(index) = {type, false, {reinterpret_cast<const char*>(&big_endian), sizeof big_endian}};
}

void PostgresStatement::BindInt64(int index, std::int64_t value) {
  BindNumber(index, kInt8, static_cast<std::uint64_t>(value));
}

void PostgresStatement::BindDouble(int index, double value) {
  BindNumber(index, kFloat8, std::bit_cast<std::uint64_t>(value));
}

void PostgresStatement::BindText(int index, std::string_view value) {
  At(index) = {kText, false, std::string(value)};
}

void PostgresStatement::BindBlob(int index, std::span<const std::uint8_t> value) {
  At(index) = {kBytea, false, std::string(value.begin(), value.end())};
}

void PostgresStatement::BindNull(int index) { At(index) = {0, true, {}}; }

Result<bool> PostgresStatement::Step() {
  if (result_ == nullptr) {
    Result<PgResult> result = db_.Run(sql_.text, parameters_);
    if (!result) return result.error();
    result_ = *std::move(result);
    row_ = -1;
  }
  ++row_;
  blobs_.clear();
  return row_ < PQntuples(result_.get());
}

void PostgresStatement::Reset() {
  result_.reset();
  row_ = -1;
}

bool PostgresStatement::IsNull(int column) const { return PQgetisnull(result_.get(), row_, column) != 0; }

std::string_view PostgresStatement::ColumnText(int column) const {
  return {PQgetvalue(result_.get(), row_, column),
          static_cast<std::size_t>(PQgetlength(result_.get(), row_, column))};
}

std::int64_t PostgresStatement::ColumnInt64(int column) const {
  const std::string_view text = ColumnText(column);
  if (PQftype(result_.get(), column) == kBool) return text == "t" ? 1 : 0;
  std::int64_t value = 0;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

double PostgresStatement::ColumnDouble(int column) const {
  const std::string_view text = ColumnText(column);
  double value = 0.0;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

std::span<const std::uint8_t> PostgresStatement::ColumnBlob(int column) const {
  if (IsNull(column)) return {};
  std::size_t size = 0;
  unsigned char* bytes =
      PQunescapeBytea(reinterpret_cast<const unsigned char*>(PQgetvalue(result_.get(), row_, column)), &size);
  SKYQUILT_CHECK(bytes != nullptr, "there is memory for a blob");
  if (blobs_.capacity() == 0) blobs_.reserve(static_cast<std::size_t>(PQnfields(result_.get())));
  blobs_.emplace_back(bytes, bytes + size);
  PQfreemem(bytes);
  return blobs_.back();
}

}  // namespace skyquilt::storage
