// Statement: one prepared SQL statement of a SqlConnection. Bind (1-based), Step until false, Reset, use
// again. What is bound is copied, so that a temporary may be bound: no engine keeps a view of it.
// Views that ColumnText and ColumnBlob return live until the next Step or Reset. One thread at a time; must
// not outlive its database. Parameters are written ? or ?1, in every engine. Errors: kOutOfSpace, kCorrupt,
// kConflict (a constraint), kUnavailable (locked, or the connection was lost), kInvalidArgument (text that
// the engine cannot store), kIo.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/base/result.h"

namespace skyquilt::storage {

// What an engine does for a Statement.
class StatementDriver {
 public:
  StatementDriver() = default;
  virtual ~StatementDriver() = default;
  StatementDriver(const StatementDriver&) = delete;
  StatementDriver& operator=(const StatementDriver&) = delete;
  virtual void BindInt64(int index, std::int64_t value) = 0;
  virtual void BindDouble(int index, double value) = 0;
  virtual void BindText(int index, std::string_view value) = 0;
  virtual void BindBlob(int index, std::span<const std::uint8_t> value) = 0;
  virtual void BindNull(int index) = 0;
  virtual Result<bool> Step() = 0;
  virtual void Reset() = 0;
  virtual std::int64_t ColumnInt64(int column) const = 0;
  virtual double ColumnDouble(int column) const = 0;
  virtual std::string_view ColumnText(int column) const = 0;
  virtual std::span<const std::uint8_t> ColumnBlob(int column) const = 0;
  virtual bool IsNull(int column) const = 0;
};

class Statement {
 public:
  Statement() = default;
  explicit Statement(std::unique_ptr<StatementDriver> driver) : driver_(std::move(driver)) {}

  Statement& Bind(int index, std::int64_t value) {
    driver_->BindInt64(index, value);
    return *this;
  }
  Statement& Bind(int index, int value) { return Bind(index, static_cast<std::int64_t>(value)); }
  Statement& Bind(int index, double value) {
    driver_->BindDouble(index, value);
    return *this;
  }
  Statement& Bind(int index, std::string_view value) {
    driver_->BindText(index, value);
    return *this;
  }
  Statement& Bind(int index, const char* value) { return Bind(index, std::string_view(value)); }
  Statement& Bind(int index, std::span<const std::uint8_t> value) {
    driver_->BindBlob(index, value);
    return *this;
  }
  Statement& BindNull(int index) {
    driver_->BindNull(index);
    return *this;
  }
  // Nothing is NULL.
  template <typename T>
  Statement& Bind(int index, const std::optional<T>& value) {
    return value ? Bind(index, *value) : BindNull(index);
  }
  // The first parameters, in their order.
  template <typename... Values>
  Statement& BindAll(const Values&... values) {
    [[maybe_unused]] int index = 0;
    (Bind(++index, values), ...);
    return *this;
  }

  // True: a row is there. False: done.
  Result<bool> Step() { return driver_->Step(); }
  // Shows `visit` each row that is left.
  template <typename Visit>
  Result<void> Each(const Visit& visit) {
    while (true) {
      const Result<bool> row = Step();
      if (!row) return row.error();
      if (!*row) return {};
      visit(*this);
    }
  }
  // What `read` makes of each row that is left.
  template <typename Read>
  auto All(const Read& read) -> Result<std::vector<std::invoke_result_t<Read, const Statement&>>> {
    std::vector<std::invoke_result_t<Read, const Statement&>> all;
    const Result<void> read_all = Each([&](const Statement& row) { all.push_back(read(row)); });
    if (!read_all) return read_all.error();
    return all;
  }
  // What `read` makes of the first row, if there is one; then as Run: RETURNING hands out its row before the
  // statement is done, and only done is committed.
  template <typename Read>
  auto First(const Read& read) -> Result<std::optional<std::invoke_result_t<Read, const Statement&>>> {
    std::optional<std::invoke_result_t<Read, const Statement&>> first;
    const Result<bool> row = Step();
    if (!row) return row.error();
    if (!*row) return first;
    first.emplace(read(*this));
    if (const Result<void> done = Run(); !done) return done.error();
    return first;
  }
  // The first column of all rows that are left.
  Result<std::vector<std::string>> AllText();
  // The first column of the first row, as First; 0 where there is none.
  Result<std::int64_t> Number();
  // Steps to the end, drops any rows and resets: for statements that write.
  Result<void> Run();
  void Reset() {
    if (driver_) driver_->Reset();
  }

  std::int64_t ColumnInt64(int column) const { return driver_->ColumnInt64(column); }
  double ColumnDouble(int column) const { return driver_->ColumnDouble(column); }
  std::string_view ColumnText(int column) const { return driver_->ColumnText(column); }
  std::span<const std::uint8_t> ColumnBlob(int column) const { return driver_->ColumnBlob(column); }
  bool IsNull(int column) const { return driver_->IsNull(column); }

 private:
  std::unique_ptr<StatementDriver> driver_;
};

}  // namespace skyquilt::storage
