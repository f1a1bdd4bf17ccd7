// HttpTransfers: single HTTP exchanges through libcurl, over connections that stay open from one to the
// next. Follows no redirect and keeps no cookie. Any number of threads. Errors: kUnavailable (no
// connection, a stall, an answer that broke off), kTooLarge (an answer beyond its bound), and what the
// receiver of the body answers.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "storage/blobs/s3/sign_request.h"

namespace skyquilt::storage {

struct HttpAnswer {
  long status = 0;
  std::map<std::string, std::string> headers;  // names in lower case
  std::string body;

  // Empty when absent.
  std::string Header(const std::string& name) const;
  bool IsGood() const { return status >= 200 && status < 300; }
};

struct HttpExchange {
  std::string method;
  std::string url;
  NamedValues headers;
  std::string_view body;  // lives as long as the exchange
  // Takes the body of a 2xx answer as it comes; absent: it is in the answer.
  std::function<Result<void>(std::string_view)> take;
  // Before the first byte of such a body: status and headers are there.
  std::function<Result<void>(const HttpAnswer&)> begin;
  std::size_t max_answer_bytes = std::size_t{16} << 20;  // of a body that is in the answer
  std::chrono::milliseconds connect_patience{5'000};
  std::chrono::seconds stall_patience{10};
};

class HttpTransfers {
 public:
  HttpTransfers();
  ~HttpTransfers();
  HttpTransfers(const HttpTransfers&) = delete;
  HttpTransfers& operator=(const HttpTransfers&) = delete;

  Result<HttpAnswer> Perform(const HttpExchange& exchange);

 private:
  struct Idle;
  std::mutex mutex_;
  std::unique_ptr<Idle> idle_;
};

}  // namespace skyquilt::storage
