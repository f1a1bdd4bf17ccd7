#include "server/http/request_pool.h"

#include <pthread.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <thread>
#include <utility>

namespace skyquilt::server {
namespace {

constexpr int kMaxPiecesInARow = 4;  // while something waits that has not begun

struct Waiting {
  RequestPool::Work work;
  RequestPool::Clock::time_point since;
};

struct Client {
  std::deque<Waiting> waiting;
  std::size_t held = 0;  // waiting or running
};

}  // namespace

struct RequestPool::State {
  explicit State(Settings given) : settings(std::move(given)) {}

  // Under the lock. The client whose turn it is goes to the end of the line, if it has more.
  std::pair<std::string, Waiting> TakeNext() {
    const std::string name = std::move(turns.front());
    turns.pop_front();
    Client& client = clients.at(name);
    Waiting next = std::move(client.waiting.front());
    client.waiting.pop_front();
    if (!client.waiting.empty()) turns.push_back(name);
    --waiting;
    return {name, std::move(next)};
  }

  void GiveBack(const std::string& name) {
    const auto client = clients.find(name);
    if (--client->second.held == 0) clients.erase(client);
  }

  void Run() {
    std::unique_lock lock(mutex);
    while (true) {
      news.wait(lock, [&] { return is_closed || !pieces.empty() || waiting > 0; });
      if (is_closed) return;
      ++running;
      if (!pieces.empty() && (waiting == 0 || pieces_in_a_row < kMaxPiecesInARow)) {
        pieces_in_a_row = waiting == 0 ? 0 : pieces_in_a_row + 1;
        std::function<void()> piece = std::move(pieces.front());
        pieces.pop_front();
        lock.unlock();
        piece();
        piece = nullptr;
        lock.lock();
      } else {
        pieces_in_a_row = 0;
        auto [name, next] = TakeNext();
        const bool is_late = Clock::now() - next.since > settings.max_wait;
        if (is_late) ++refused;
        lock.unlock();
        next.work(is_late);
        next.work = nullptr;
        lock.lock();
        GiveBack(name);
      }
      --running;
    }
  }

  const Settings settings;
  mutable std::mutex mutex;
  std::condition_variable news;
  std::condition_variable ended;
  std::deque<std::function<void()>> pieces;
  std::map<std::string, Client> clients;
  std::deque<std::string> turns;  // clients with something waiting, each once
  std::size_t waiting = 0;
  std::size_t running = 0;
  std::uint64_t refused = 0;
  int pieces_in_a_row = 0;
  int threads_left = 0;
  bool is_closed = false;
};

RequestPool::RequestPool(Settings settings) : state_(std::make_shared<State>(std::move(settings))) {
  for (int i = 0; i < state_->settings.threads; ++i) {
    {
      const std::lock_guard lock(state_->mutex);
      ++state_->threads_left;
    }
    std::thread([state = state_] {
      pthread_setname_np(pthread_self(), state->settings.name.substr(0, 15).c_str());
      // On Linux the priority is a thread's own. Where it is refused, the work is done at the usual one.
      if (state->settings.niceness > 0) {
        setpriority(PRIO_PROCESS, static_cast<id_t>(syscall(SYS_gettid)), state->settings.niceness);
      }
      state->Run();
      const std::lock_guard lock(state->mutex);
      --state->threads_left;
      state->ended.notify_all();
    }).detach();
  }
}

RequestPool::~RequestPool() {
  Stop(Clock::now());
  std::unique_lock lock(state_->mutex);
  state_->ended.wait(lock, [&] { return state_->threads_left == 0; });
}

RequestPool::Answer RequestPool::Submit(std::string_view client, Work work) {
  State& state = *state_;
  const std::lock_guard lock(state.mutex);
  const Settings& settings = state.settings;
  std::string name(client);
  const auto known = state.clients.find(name);
  const std::size_t held = known == state.clients.end() ? 0 : known->second.held;
  if (!client.empty() && settings.max_of_client > 0 && held >= settings.max_of_client) {
    ++state.refused;
    return Answer::kClientFull;
  }
  // An idle thread's place does not count as waiting, although the thread has not yet come for it.
  const std::size_t idle = static_cast<std::size_t>(settings.threads) - state.running;
  if (state.is_closed || state.waiting >= settings.max_waiting + idle) {
    ++state.refused;
    return Answer::kFull;
  }
  Client& taken = state.clients[name];
  ++taken.held;
  if (taken.waiting.empty()) state.turns.push_back(std::move(name));
  taken.waiting.push_back({std::move(work), Clock::now()});
  ++state.waiting;
  state.news.notify_one();
  return Answer::kTaken;
}

void RequestPool::Continue(std::function<void()> work) {
  const std::lock_guard lock(state_->mutex);
  if (state_->is_closed) return;
  state_->pieces.push_back(std::move(work));
  state_->news.notify_one();
}

bool RequestPool::Stop(Clock::time_point until) {
  // What is dropped may own much, and is destroyed without the lock.
  std::deque<std::function<void()>> pieces;
  std::map<std::string, Client> clients;
  std::unique_lock lock(state_->mutex);
  state_->is_closed = true;
  pieces.swap(state_->pieces);
  for (auto& [name, client] : state_->clients) {
    client.held -= client.waiting.size();
    clients[name].waiting.swap(client.waiting);
  }
  state_->turns.clear();
  state_->waiting = 0;
  state_->news.notify_all();
  return state_->ended.wait_until(lock, until, [&] { return state_->threads_left == 0; });
}

RequestPool::Load RequestPool::load() const {
  const std::lock_guard lock(state_->mutex);
  return {state_->waiting + state_->pieces.size(), state_->running, state_->refused};
}

const RequestPool::Settings& RequestPool::settings() const { return state_->settings; }

}  // namespace skyquilt::server
