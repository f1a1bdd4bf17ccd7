#include "core/base/trace.h"

#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <mutex>
#include <vector>

namespace skyquilt {
namespace {

struct Span {
  const char* name;
  std::string item;
  int thread;
  std::int64_t begun_us;
  std::int64_t took_us;  // kInstant: a decision
  std::vector<std::pair<const char*, double>> numbers = {};
};

constexpr std::int64_t kInstant = -1;
constexpr std::size_t kMaxTraceSpans = 1'000'000;

std::atomic<bool> is_tracing{false};
std::mutex spans_mutex;
std::vector<Span> spans;
std::size_t passed_over = 0;

std::int64_t NowUs() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::microseconds>(now).count();
}

// Names of files may hold anything.
void AppendJsonText(std::string& json, std::string_view text) {
  json += '"';
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte >= 0x7F || c == '"' || c == '\\') {
      char escaped[8];
      std::snprintf(escaped, sizeof escaped, "\\u%04x", byte);
      json += escaped;
    } else {
      json += c;
    }
  }
  json += '"';
}

void AppendArguments(std::string& json, const Span& span) {
  if (span.item.empty() && span.numbers.empty()) return;
  json += ",\"args\":{";
  if (!span.item.empty()) {
    json += "\"item\":";
    AppendJsonText(json, span.item);
  }
  for (const auto& [name, number] : span.numbers) {
    if (json.back() != '{') json += ',';
    AppendJsonText(json, name);
    json += ':';
    char text[32];
    std::snprintf(text, sizeof text, "%.7g", number);
    json += std::isfinite(number) ? text : "null";
  }
  json += '}';
}

void Keep(Span span) {
  const std::lock_guard lock(spans_mutex);
  if (spans.size() < kMaxTraceSpans) {
    spans.push_back(std::move(span));
  } else {
    ++passed_over;
  }
}

}  // namespace

void BeginTrace() {
  const std::lock_guard lock(spans_mutex);
  spans.clear();
  passed_over = 0;
  is_tracing = true;
}

std::string EndTrace() {
  is_tracing = false;
  const std::lock_guard lock(spans_mutex);
  std::string json = "{\"displayTimeUnit\":\"ms\",\"otherData\":{\"spans_passed_over\":\"" +
                     std::to_string(passed_over) + "\"},\"traceEvents\":[";
  const int process = getpid();
  bool is_first = true;
  for (const Span& span : spans) {
    if (!is_first) json += ',';
    is_first = false;
    const bool is_instant = span.took_us == kInstant;
    json += is_instant ? "\n{\"ph\":\"i\",\"s\":\"t\",\"name\":" : "\n{\"ph\":\"X\",\"name\":";
    AppendJsonText(json, span.name);
    json += ",\"pid\":" + std::to_string(process) + ",\"tid\":" + std::to_string(span.thread) +
            ",\"ts\":" + std::to_string(span.begun_us);
    if (!is_instant) json += ",\"dur\":" + std::to_string(span.took_us);
    AppendArguments(json, span);
    json += '}';
  }
  json += "\n]}\n";
  spans.clear();
  return json;
}

TraceSpan::TraceSpan(const char* name, std::string_view item) : name_(name) {
  if (!is_tracing.load(std::memory_order_relaxed)) return;
  item_ = item;
  begun_us_ = NowUs();
}

TraceSpan::~TraceSpan() {
  if (begun_us_ < 0) return;
  Keep({name_, std::move(item_), gettid(), begun_us_, NowUs() - begun_us_});
}

void TraceDecision(const char* name, TraceNumbers numbers, std::string_view item) {
  if (!is_tracing.load(std::memory_order_relaxed)) return;
  Keep({name, std::string(item), gettid(), NowUs(), kInstant, numbers});
}

}  // namespace skyquilt
