#include "api/http/router.h"

#include "core/base/check.h"

namespace skyquilt::api {

struct Router::Node {
  std::map<std::string, std::unique_ptr<Node>, std::less<>> literals;
  std::unique_ptr<Node> any;
  std::map<Method, Route> routes;
  std::map<Method, std::vector<std::string>> names;  // of the parameters on the way here, per route
};

namespace {

std::vector<std::string> SegmentsOf(std::string_view pattern) {
  std::vector<std::string> segments;
  SKYQUILT_CHECK(pattern.starts_with('/'), "a pattern begins with a slash");
  while (pattern.size() > 1) {
    pattern.remove_prefix(1);
    const std::size_t end = std::min(pattern.find('/'), pattern.size());
    segments.emplace_back(pattern.substr(0, end));
    pattern.remove_prefix(end);
  }
  return segments;
}

std::function<Response(const Request&)> Answering(Handler handler) {
  return
      [handler = std::move(handler)](const Request& request) { return Answered(handler(request), request); };
}

}  // namespace

Router::Router() : root_(std::make_unique<Node>()) {}
Router::~Router() = default;
Router::Router(Router&&) noexcept = default;
Router& Router::operator=(Router&&) noexcept = default;

Route& Router::Insert(Method method, std::string_view pattern) {
  Node* node = root_.get();
  std::vector<std::string> names;
  for (const std::string& segment : SegmentsOf(pattern)) {
    const bool is_parameter = segment.starts_with('{') && segment.ends_with('}');
    if (is_parameter) names.push_back(segment.substr(1, segment.size() - 2));
    std::unique_ptr<Node>& next = is_parameter ? node->any : node->literals[segment];
    if (next == nullptr) next = std::make_unique<Node>();
    node = next.get();
  }
  SKYQUILT_CHECK(!node->routes.contains(method), "two handlers for one route");
  node->names[method] = std::move(names);
  Route& route = node->routes[method];
  route.pattern = pattern;
  route.scope = method == Method::kGet ? storage::Scope::kRead : storage::Scope::kUpload;
  return route;
}

Route& Router::Add(Method method, std::string_view pattern, Handler handler) {
  Route& route = Insert(method, pattern);
  route.handler = Answering(std::move(handler));
  route.work = method == Method::kGet ? Work::kRead : Work::kWrite;
  return route;
}

Route& Router::AddCompute(Method method, std::string_view pattern, Handler handler) {
  Route& route = Insert(method, pattern);
  route.handler = Answering(std::move(handler));
  route.work = Work::kCompute;
  return route;
}

Route& Router::AddQuick(Method method, std::string_view pattern, Handler handler) {
  Route& route = Insert(method, pattern);
  route.handler = Answering(std::move(handler));
  route.work = Work::kQuick;
  return route;
}

Route& Router::AddUpload(Method method, std::string_view pattern, UploadHandler handler) {
  Route& route = Insert(method, pattern);
  route.upload = [handler = std::move(handler)](const Request& request) -> UploadBegun {
    UploadBegun begun = handler(request);
    if (const Error* error = std::get_if<Error>(&begun)) return Problem(*error, request);
    return begun;
  };
  route.work = Work::kWrite;
  return route;
}

Route& Router::AddBody(Method method, std::string_view pattern, BodyHandler handler, const char* unless_json,
                       std::size_t max_bytes) {
  return AddUpload(
      method, pattern,
      [handler = std::move(handler), unless_json, max_bytes](const Request& request) -> UploadBegun {
        if (unless_json != nullptr && !IsJson(request))
          return Error{ErrorCode::kUnsupportedFormat, unless_json};
        return CollectBody(request, handler, max_bytes);
      });
}

void Router::PutBefore(const Guard& guard) {
  const std::function<void(Node&)> visit = [&](Node& node) {
    for (auto& [method, route] : node.routes) {
      if (route.handler) {
        route.handler = [guard, &route = std::as_const(route),
                         handler = std::move(route.handler)](const Request& request) {
          std::optional<Response> refused = guard(request, route);
          return refused ? *std::move(refused) : handler(request);
        };
      } else {
        route.upload = [guard, &route = std::as_const(route),
                        upload = std::move(route.upload)](const Request& request) -> UploadBegun {
          std::optional<Response> refused = guard(request, route);
          if (refused) return *std::move(refused);
          return upload(request);
        };
      }
    }
    for (auto& [name, next] : node.literals) visit(*next);
    if (node.any != nullptr) visit(*node.any);
  };
  visit(*root_);
}

void Router::SetFallback(Handler handler) {
  fallback_.emplace();
  fallback_->pattern = "(page)";
  fallback_->handler = Answering(std::move(handler));
}

// Literal first, then parameter, with a way back: patterns of few segments, so that the search stays tiny.
const Router::Node* Router::Walk(const Node& node, std::span<const std::string> segments,
                                 std::vector<std::string_view>& values) {
  if (segments.empty()) return node.routes.empty() ? nullptr : &node;
  const auto literal = node.literals.find(segments.front());
  if (literal != node.literals.end()) {
    if (const Node* found = Walk(*literal->second, segments.subspan(1), values)) return found;
  }
  if (node.any == nullptr) return nullptr;
  values.emplace_back(segments.front());
  if (const Node* found = Walk(*node.any, segments.subspan(1), values)) return found;
  values.pop_back();
  return nullptr;
}

std::string Router::Allowed(const std::vector<std::string>& segments) const {
  std::vector<std::string_view> values;
  const Node* node = Walk(*root_, segments, values);
  if (node == nullptr) return fallback_ ? "GET, HEAD, OPTIONS" : "";
  std::string allow;
  for (const auto& [method, route] : node->routes) {
    if (method == Method::kOptions) continue;  // named at the end, with a route of its own or without
    allow += MethodName(method);
    allow += ", ";
    if (method == Method::kGet) allow += "HEAD, ";
  }
  return allow + "OPTIONS";
}

Router::Match Router::Find(Method method, const std::vector<std::string>& segments) const {
  Match match;
  std::vector<std::string_view> values;
  values.reserve(segments.size());
  const Node* node = Walk(*root_, segments, values);
  if (node == nullptr) {
    if (fallback_ && method == Method::kGet) match.route = &*fallback_;
    return match;
  }
  const auto route = node->routes.find(method);
  if (route == node->routes.end()) {
    match.allow = Allowed(segments);
    return match;
  }
  match.route = &route->second;
  const std::vector<std::string>& names = node->names.at(method);
  match.parameters.reserve(names.size());
  for (std::size_t i = 0; i < names.size(); ++i) match.parameters.emplace_back(names[i], values[i]);
  return match;
}

std::vector<std::pair<Method, const Route*>> Router::Routes() const {
  std::vector<std::pair<Method, const Route*>> routes;
  const std::function<void(const Node&)> visit = [&](const Node& node) {
    for (const auto& [method, route] : node.routes) routes.emplace_back(method, &route);
    for (const auto& [name, next] : node.literals) visit(*next);
    if (node.any != nullptr) visit(*node.any);
  };
  visit(*root_);
  return routes;
}

}  // namespace skyquilt::api
