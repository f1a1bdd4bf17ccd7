// Result<T>: a value, or the Error that input caused. Exceptions are kept for a machine that ran out of
// something. Reading the wrong side aborts the program. Any thread.
//
//   Result<TileId> id = TileId::Make(z, x, y);
//   if (!id) return id.error();
//   Use(*id);
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "core/base/check.h"
#include "core/base/error_code.h"

namespace skyquilt {

namespace flight {
struct Remark;  // core/flight/remarks/remark.h
}

struct Error {
  ErrorCode code = ErrorCode::kInternal;
  std::string message;      // for the user: what is wrong and what to do
  std::string detail = {};  // for the log
  // The same as the message, as a code with its values (core/flight/remarks/because.h); null: it has none.
  std::shared_ptr<const flight::Remark> reason = nullptr;
};

template <typename T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}      // NOLINT: implicit by design
  Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}  // NOLINT: implicit by design

  bool ok() const { return state_.index() == 0; }
  explicit operator bool() const { return ok(); }

  const T& value() const& {
    Require();
    return std::get<0>(state_);
  }
  T& value() & {
    Require();
    return std::get<0>(state_);
  }
  T&& value() && {
    Require();
    return std::get<0>(std::move(state_));
  }
  const T& operator*() const& { return value(); }
  T& operator*() & { return value(); }
  T&& operator*() && { return std::move(*this).value(); }
  const T* operator->() const { return &value(); }
  T* operator->() { return &value(); }

  const Error& error() const {
    SKYQUILT_CHECK(!ok(), "asked a Result with a value for its error");
    return std::get<1>(state_);
  }

 private:
  void Require() const {
    SKYQUILT_CHECK(ok(), "asked a Result with an error for its value: " + std::get<1>(state_).message);
  }
  std::variant<T, Error> state_;
};

template <>
class [[nodiscard]] Result<void> {
 public:
  Result() = default;
  Result(Error error) : error_(std::move(error)) {}  // NOLINT: implicit by design

  bool ok() const { return !error_.has_value(); }
  explicit operator bool() const { return ok(); }
  const Error& error() const {
    SKYQUILT_CHECK(!ok(), "asked a good Result for its error");
    return *error_;
  }

 private:
  std::optional<Error> error_;
};

}  // namespace skyquilt
