// RequestPool: threads for requests that compute or wait, so that the threads that serve sockets do neither.
// Bounded: the number of waiting requests, their share per client, and the time they wait (`max_wait`) are
// limited; a request beyond that is refused at once. Clients take turns, however many requests each has
// waiting. Submit, Continue: any thread. Work must not throw.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace skyquilt::server {

class RequestPool {
 public:
  using Clock = std::chrono::steady_clock;

  struct Settings {
    std::string name;  // of the threads, at most 15 letters
    int threads = 2;
    std::size_t max_waiting = 64;   // over all clients, beside what runs
    std::size_t max_of_client = 0;  // that wait or run for one named client; 0: as many as there is room for
    std::chrono::milliseconds max_wait{10'000};
    int niceness = 0;  // above 0: gives way to the threads that serve sockets
  };

  enum class Answer { kTaken, kFull, kClientFull };
  // `is_late`: it waited longer than anybody should, and is to answer that instead of doing what it is for.
  using Work = std::function<void(bool is_late)>;

  explicit RequestPool(Settings settings);
  // Waits for what runs; what still waits is dropped unrun.
  ~RequestPool();
  RequestPool(const RequestPool&) = delete;
  RequestPool& operator=(const RequestPool&) = delete;

  // `client` empty: no share is counted, but turns are taken as for one more client.
  Answer Submit(std::string_view client, Work work);
  // The next piece of what was begun: never refused, never late, and before what has not begun, of which some
  // goes between. Bounded by its caller, who has one piece under way at a time.
  void Continue(std::function<void()> work);
  // Takes nothing more, drops what waits, and waits for what runs. False: something still runs at `until`;
  // the process is to end without destroying what that work uses.
  bool Stop(Clock::time_point until);

  struct Load {
    std::size_t waiting = 0;
    std::size_t running = 0;
    std::uint64_t refused = 0;  // since the start, late ones among them
  };
  Load load() const;
  const Settings& settings() const;

 private:
  struct State;
  std::shared_ptr<State> state_;  // shared with the threads: one that never ends outlives the pool
};

}  // namespace skyquilt::server
