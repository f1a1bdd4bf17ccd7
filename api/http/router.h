// Router: from a method and a path to the handler that answers. Patterns are segments, "{name}" stands for
// any one segment; a literal segment wins over a parameter. Built once at the start, then only read: any
// thread.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "api/http/http_message.h"
#include "api/http/responses.h"
#include "storage/catalogue/tokens.h"

namespace skyquilt::api {

// An error is answered by its problem document.
using Handler = std::function<Result<Response>(const Request&)>;
// Begins an upload: either takes the body, or refuses it before it is read. An Error is a handler's to give:
// a Route answers its problem document.
using UploadBegun = std::variant<std::unique_ptr<BodySink>, Response, Error>;
using UploadHandler = std::function<UploadBegun(const Request&)>;

// Of a function of what it works on, which must outlive the router, and of what is asked.
template <typename Subject, typename Function>
auto On(Subject& subject, Function* handler) {
  return [&subject, handler](const auto&... asked) { return handler(subject, asked...); };
}
// The same, with its errors as `refuse` answers them.
template <typename Subject, typename Answer>
auto On(Subject& subject, Answer (*handler)(Subject&, const Request&),
        Response (*refuse)(const Error&, const Request&)) {
  return [&subject, handler, refuse](const Request& request) -> Answer {
    Answer answer = handler(subject, request);
    const Error* error = nullptr;
    if constexpr (std::is_same_v<Answer, UploadBegun>) {
      error = std::get_if<Error>(&answer);
    } else {
      error = answer ? nullptr : &answer.error();
    }
    return error == nullptr ? std::move(answer) : Answer(refuse(*error, request));
  };
}

// What a route is for, as Route::scope: nobody is asked who he is.
inline constexpr std::optional<storage::Scope> kEverybody;

struct Route {
  std::string pattern;  // for metrics and the test that walks the contract
  // What a token must be good for, where tokens are asked for (api/auth/access).
  std::optional<storage::Scope> scope;
  std::function<Response(const Request&)> handler;  // exactly one of the two is set
  UploadHandler upload;
  // Where it begins; an answer may ask for more (Response::wants). Of an upload, where it is finished: kWrite
  // goes on where its bytes were written, kCompute waits for its turn.
  Work work = Work::kRead;
};

class Router {
 public:
  Router();
  ~Router();
  Router(Router&&) noexcept;
  Router& operator=(Router&&) noexcept;

  // A route is registered in one place, with all that is to be known of it. A GET asks for the scope to read
  // and all else for the scope to upload, unless the route that is returned is told otherwise. GET where
  // reading is fine, everything else where writing is.
  Route& Add(Method method, std::string_view pattern, Handler handler);
  // Makes pictures, plans or verdicts.
  Route& AddCompute(Method method, std::string_view pattern, Handler handler);
  // Answers from memory, with at most a page or two read from a file that is open: runs where sockets are
  // served, and everybody there waits for it.
  Route& AddQuick(Method method, std::string_view pattern, Handler handler);
  Route& AddUpload(Method method, std::string_view pattern, UploadHandler handler);
  // A small upload, of at most `max_bytes`, which is collected before it is looked at. `unless_json`: how a
  // body is refused, before it is read, that is not JSON; null: none is.
  Route& AddBody(Method method, std::string_view pattern, BodyHandler handler,
                 const char* unless_json = nullptr, std::size_t max_bytes = kMaxCollectedBytes);
  // Asked before the handler of every route that is there now; a Response of its is the answer.
  using Guard = std::function<std::optional<Response>(const Request&, const Route&)>;
  void PutBefore(const Guard& guard);
  // Answers GET of paths that no pattern has (the web page).
  void SetFallback(Handler handler);

  struct Match {
    const Route* route = nullptr;  // none: no such path (both empty), or the path lacks this method
    std::vector<std::pair<std::string, std::string>> parameters;
    std::string allow;  // the path's methods for the Allow header, e.g. "GET, HEAD, OPTIONS"
  };
  Match Find(Method method, const std::vector<std::string>& segments) const;
  // What the path allows at all; empty when there is no such path.
  std::string Allowed(const std::vector<std::string>& segments) const;
  std::vector<std::pair<Method, const Route*>> Routes() const;

 private:
  struct Node;
  Route& Insert(Method method, std::string_view pattern);
  static const Node* Walk(const Node& node, std::span<const std::string> segments,
                          std::vector<std::string_view>& values);
  std::unique_ptr<Node> root_;
  std::optional<Route> fallback_;
};

}  // namespace skyquilt::api
