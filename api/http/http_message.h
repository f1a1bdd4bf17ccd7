// What a handler sees of HTTP: plain values, no socket and no library. The session (server/http/http_session)
// makes a Request out of bytes it has checked, and sends what a handler answers. Bodies that may be large
// never are strings: an upload is pushed into a BodySink, a download is pulled from a BodySource.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/result.h"

namespace skyquilt::api {

enum class Method {
  kGet,
  kPost,
  kPut,
  kPatch,
  kDelete,
  kOptions
};  // HEAD comes as kGet; OPTIONS reaches a handler only where a route asks for it
const char* MethodName(Method method);

// Where a request is carried out, each on threads of its own.
enum class Work {
  kQuick,    // where sockets are served: from memory, or a page or two of a file that is open
  kRead,     // reads the catalogue and files
  kWrite,    // waits for the disk to have it, and for others that write
  kCompute,  // takes processor time: pictures, plans, verdicts
};

// Names compare without regard to case. Few, so a list.
class Headers {
 public:
  Headers() = default;
  Headers(std::initializer_list<std::pair<std::string, std::string>> list) : list_(list) {}
  void Add(std::string name, std::string value) {
    if (list_.empty()) list_.reserve(8);  // as many as most have
    list_.emplace_back(std::move(name), std::move(value));
  }
  void Set(std::string_view name, std::string value);
  void Remove(std::string_view name);
  // One more field of the request that the answer depends on; in one line, since some caches read one alone.
  void AddVary(std::string_view field);
  // Empty when absent.
  std::string_view Find(std::string_view name) const;
  bool Has(std::string_view name) const;
  const std::vector<std::pair<std::string, std::string>>& list() const { return list_; }

 private:
  std::vector<std::pair<std::string, std::string>> list_;
};

struct Request {
  Method method = Method::kGet;
  std::string path;                                             // as sent, still encoded; for messages
  std::vector<std::pair<std::string, std::string>> parameters;  // {name} of the route, decoded and checked
  std::vector<std::pair<std::string, std::string>> query;       // decoded; the first of a name counts
  Headers headers;
  std::optional<std::uint64_t> content_length;
  std::string body;       // small bodies only; empty for uploads
  std::string base_url;   // "http://host:port/base", for absolute links; no slash at the end
  std::string base_path;  // "/base", before paths of this server in answers; empty: it lies at the root
  std::string request_id;
  std::string client;  // who counts as one when shares are dealt out; empty: this machine itself
  bool is_from_this_machine = false;  // and, as far as is said, no proxy's
  bool needs_token = false;    // it came by an address that was opened to the network (api/auth/access)
  Work work = Work::kCompute;  // where it is carried out now; a handler that needs a later kind asks for it
  // Who asks (api/auth/access).
  std::string owner;      // id of the token it showed; empty where the server asks for none
  bool is_admin = false;  // may act on flights of others; so may everybody where the server asks for no token
  std::string only_flight;  // the one flight that its token opens; empty: every flight

  // Precondition: the route's pattern has this parameter.
  const std::string& Parameter(std::string_view name) const;
  std::optional<std::string_view> Query(std::string_view name) const;
};

class BodySource {
 public:
  virtual ~BodySource() = default;
  virtual std::uint64_t length() const = 0;
  // Fills from the front; 0 only at the end. May block on the disk.
  virtual Result<std::size_t> Read(std::span<std::uint8_t> into) = 0;
};

// An answer without an end: asked again whenever it has news, and every few seconds, until the client goes.
class LiveSource {
 public:
  virtual ~LiveSource() = default;
  // What is new; often nothing.
  virtual Result<std::string> Next() = 0;
  // Where Next is to be called now: where waiting for the disk is fine, or where sockets are served.
  virtual bool WaitsForDisk() const = 0;
  // `wake` is called, from any thread, whenever Next has something; it does not block.
  virtual void OnNews(std::function<void()> wake) = 0;
};

struct Response {
  int status = 200;
  Headers headers;
  std::string body;
  std::unique_ptr<BodySource> source;  // instead of body
  std::unique_ptr<LiveSource> live;    // instead of body
  std::optional<Work> wants;           // instead of an answer: to be asked again where such work is done
  std::string for_log;                 // what a failure is of; is sent to nobody
};

// Takes an upload piece by piece, in order, then answers. Destroyed without Finish: the upload broke, and
// nothing of it may stay. May block on the disk. One thread at a time.
class BodySink {
 public:
  virtual ~BodySink() = default;
  virtual Result<void> Write(std::span<const std::uint8_t> bytes) = 0;
  virtual Response Finish() = 0;
};

bool EqualsIgnoringCase(std::string_view a, std::string_view b);

}  // namespace skyquilt::api
