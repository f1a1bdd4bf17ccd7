// What every transfer by libcurl begins with: its handle, its headers, and the options that hold for all of
// them. HTTP and HTTPS alone; redirects are not followed. One thread a transfer.
#pragma once

#include <curl/curl.h>

#include <array>
#include <cstdlib>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/base/check.h"

namespace skyquilt::storage {

struct EndTransfer {
  void operator()(CURL* transfer) const { curl_easy_cleanup(transfer); }
};
using CurlTransfer = std::unique_ptr<CURL, EndTransfer>;
struct EndHeaders {
  void operator()(curl_slist* headers) const { curl_slist_free_all(headers); }
};
using CurlHeaders = std::unique_ptr<curl_slist, EndHeaders>;
using CurlWords = std::array<char, CURL_ERROR_SIZE>;

inline CurlTransfer NewTransfer() {
  static const CURLcode started = curl_global_init(CURL_GLOBAL_DEFAULT);
  SKYQUILT_CHECK(started == CURLE_OK, "libcurl does not start");
  CurlTransfer transfer(curl_easy_init());
  SKYQUILT_CHECK(transfer != nullptr, "out of memory");
  return transfer;
}

inline CurlHeaders CurlHeadersOf(const std::vector<std::pair<std::string, std::string>>& headers) {
  // Without it libcurl asks before it sends a large body, and waits for those who do not answer that.
  CurlHeaders list(curl_slist_append(nullptr, "Expect:"));
  for (const auto& [name, value] : headers) {
    curl_slist* longer = curl_slist_append(list.get(), (name + ": " + value).c_str());
    SKYQUILT_CHECK(longer != nullptr, "out of memory");
    (void)list.release();
    list.reset(longer);
  }
  return list;
}

template <typename Value>
void SetOption(CURL* transfer, CURLoption option, Value value) {
  SKYQUILT_CHECK(curl_easy_setopt(transfer, option, value) == CURLE_OK, "this libcurl lacks an option");
}

// `headers` and `said`, for what it says when it fails, live as long as the transfer.
inline void SetUsualOptions(CURL* transfer, const std::string& url, const CurlHeaders& headers,
                            CurlWords& said) {
  SetOption(transfer, CURLOPT_URL, url.c_str());
  SetOption(transfer, CURLOPT_HTTPHEADER, headers.get());
  SetOption(transfer, CURLOPT_ERRORBUFFER, said.data());
  SetOption(transfer, CURLOPT_PROTOCOLS_STR, "http,https");
  SetOption(transfer, CURLOPT_NOSIGNAL, 1L);
  // As OpenSSL's own programs have it.
  if (const char* trusted = std::getenv("SSL_CERT_FILE")) SetOption(transfer, CURLOPT_CAINFO, trusted);
}

// What it said of its failure.
inline std::string CurlWordsOf(const CurlWords& said, CURLcode failed) {
  return said[0] != '\0' ? said.data() : curl_easy_strerror(failed);
}

}  // namespace skyquilt::storage
