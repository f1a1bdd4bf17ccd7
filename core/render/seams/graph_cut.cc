#include "core/render/seams/graph_cut.h"

#include <algorithm>
#include <limits>

#include "core/base/check.h"

namespace skyquilt::render {
namespace {

std::int32_t Saturated(std::int64_t weight) {
  return static_cast<std::int32_t>(
      std::clamp<std::int64_t>(weight, -GraphCut::kMaxWeight, GraphCut::kMaxWeight));
}

constexpr std::int32_t kNoWay = std::numeric_limits<std::int32_t>::max();

}  // namespace

GraphCut::GraphCut(std::size_t nodes, std::size_t expected_edges) : nodes_(nodes) {
  arcs_.reserve(2 * expected_edges);
}

void GraphCut::AddEdge(std::size_t from, std::size_t to, std::int32_t weight) {
  SKYQUILT_CHECK(from < nodes_.size() && to < nodes_.size() && from != to && weight >= 0,
                 "an edge of a graph cut needs two nodes and a weight that is not negative");
  const auto arc = static_cast<Index>(arcs_.size());
  arcs_.push_back({static_cast<Index>(to), nodes_[from].first_arc, Saturated(weight)});
  nodes_[from].first_arc = arc;
  arcs_.push_back({static_cast<Index>(from), nodes_[to].first_arc, 0});
  nodes_[to].first_arc = arc + 1;
}

void GraphCut::AddTerminals(std::size_t node, std::int32_t source_weight, std::int32_t sink_weight) {
  SKYQUILT_CHECK(node < nodes_.size() && source_weight >= 0 && sink_weight >= 0,
                 "a node of a graph cut needs weights that are not negative");
  // What both have flows through at once: only the difference can change the cut.
  const std::int64_t difference = std::int64_t{source_weight} - sink_weight;
  nodes_[node].terminal = Saturated(nodes_[node].terminal + difference);
}

void GraphCut::Activate(Index node) {
  if (At(node).next_active != kNone) return;
  At(node).next_active = node;
  if (last_active_ == kNone) {
    first_active_ = node;
  } else {
    At(last_active_).next_active = node;
  }
  last_active_ = node;
}

// The first in the queue that still belongs to a tree; kNone: no tree can grow any more.
GraphCut::Index GraphCut::NextActive() {
  while (first_active_ != kNone) {
    const Index node = first_active_;
    const Index next = At(node).next_active;
    first_active_ = next == node ? kNone : next;
    if (first_active_ == kNone) last_active_ = kNone;
    At(node).next_active = kNone;
    if (At(node).parent != kNone) return node;
  }
  return kNone;
}

void GraphCut::Solve() {
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    Node& node = nodes_[i];
    if (node.terminal == 0) continue;
    node.tree = node.terminal > 0 ? Tree::kSource : Tree::kSink;
    node.parent = kTerminal;
    node.distance = 1;
    Activate(static_cast<Index>(i));
  }
  for (Index node = NextActive(); node != kNone;) {
    const Index bridge = Grow(node);
    ++time_;
    if (bridge == kNone) {
      node = NextActive();
      continue;
    }
    Augment(bridge);
    Adopt();
    // The same node goes on where it was, unless it lost its tree.
    if (At(node).parent == kNone) node = NextActive();
  }
}

// Takes the free neighbours of a node into its tree. The arc from the source's to the sink's tree where they
// met; kNone: they did not.
GraphCut::Index GraphCut::Grow(Index at) {
  const Node& node = At(at);
  for (Index arc = node.first_arc; arc != kNone; arc = ArcAt(arc).next) {
    if (LeftFor(node.tree, arc) == 0) continue;
    const Index to = ArcAt(arc).to;
    Node& other = At(to);
    if (other.parent == kNone) {
      other.tree = node.tree;
      other.parent = arc ^ 1;
      other.seen_at = node.seen_at;
      other.distance = node.distance + 1;
      Activate(to);
    } else if (other.tree != node.tree) {
      return node.tree == Tree::kSource ? arc : arc ^ 1;
    } else if (other.seen_at <= node.seen_at && other.distance > node.distance + 1) {
      other.parent = arc ^ 1;  // a shorter way to the terminal
      other.seen_at = node.seen_at;
      other.distance = node.distance + 1;
    }
  }
  return kNone;
}

void GraphCut::Orphan(Index node) {
  At(node).parent = kOrphan;
  orphans_.push_back(node);
}

// Lets flow all that fits through the way from the source over `bridge` to the sink.
void GraphCut::Augment(Index bridge) {
  std::int32_t flow = ArcAt(bridge).left;
  Index source_end = ArcAt(bridge ^ 1).to, sink_end = ArcAt(bridge).to;
  for (; At(source_end).parent != kTerminal; source_end = ArcAt(At(source_end).parent).to)
    flow = std::min(flow, ArcAt(At(source_end).parent ^ 1).left);
  for (; At(sink_end).parent != kTerminal; sink_end = ArcAt(At(sink_end).parent).to)
    flow = std::min(flow, ArcAt(At(sink_end).parent).left);
  flow = std::min({flow, At(source_end).terminal, -At(sink_end).terminal});

  ArcAt(bridge).left -= flow;
  ArcAt(bridge ^ 1).left += flow;
  for (Index node = ArcAt(bridge ^ 1).to; node != source_end;) {
    const Index parent = At(node).parent;
    const Index next = ArcAt(parent).to;
    ArcAt(parent).left += flow;
    if ((ArcAt(parent ^ 1).left -= flow) == 0) Orphan(node);
    node = next;
  }
  if ((At(source_end).terminal -= flow) == 0) Orphan(source_end);
  for (Index node = ArcAt(bridge).to; node != sink_end;) {
    const Index parent = At(node).parent;
    const Index next = ArcAt(parent).to;
    ArcAt(parent ^ 1).left += flow;
    if ((ArcAt(parent).left -= flow) == 0) Orphan(node);
    node = next;
  }
  if ((At(sink_end).terminal += flow) == 0) Orphan(sink_end);
}

void GraphCut::Adopt() {
  for (std::size_t i = 0; i < orphans_.size(); ++i) AdoptOne(orphans_[i]);  // which may add some
  orphans_.clear();
}

// kNoWay: the node's tree hangs on an orphan.
std::int32_t GraphCut::DistanceToTerminal(Index at) {
  std::int32_t distance = 0;
  for (Index node = at;; node = ArcAt(At(node).parent).to) {
    if (At(node).seen_at == time_) {
      distance += At(node).distance;
      break;
    }
    const Index parent = At(node).parent;
    if (parent == kOrphan || parent == kNone) return kNoWay;
    ++distance;
    if (parent != kTerminal) continue;
    At(node).seen_at = time_;
    At(node).distance = 1;
    break;
  }
  // What lies on the way is known from now on, too.
  std::int32_t left = distance;
  for (Index node = at; At(node).seen_at != time_; node = ArcAt(At(node).parent).to) {
    At(node).seen_at = time_;
    At(node).distance = left--;
  }
  return distance;
}

// Finds an orphan the neighbour of its tree that is nearest to the terminal; without any it becomes free, and
// its children orphans.
void GraphCut::AdoptOne(Index at) {
  Node& orphan = At(at);
  Index best = kNone;
  std::int32_t least = kNoWay;
  for (Index arc = orphan.first_arc; arc != kNone; arc = ArcAt(arc).next) {
    const Index other = ArcAt(arc).to;
    // Flow comes from a parent in the source's tree and goes to one in the sink's.
    if (At(other).tree != orphan.tree || LeftFor(orphan.tree, arc ^ 1) == 0) continue;
    const Index parent = At(other).parent;
    if (parent == kNone || parent == kOrphan) continue;
    const std::int32_t distance = DistanceToTerminal(other);
    if (distance >= least) continue;
    best = arc;
    least = distance;
  }
  if (best != kNone) {
    orphan.parent = best;
    orphan.seen_at = time_;
    orphan.distance = least + 1;
    return;
  }
  for (Index arc = orphan.first_arc; arc != kNone; arc = ArcAt(arc).next) {
    const Index other = ArcAt(arc).to;
    const Index parent = At(other).parent;
    if (At(other).tree != orphan.tree || parent == kNone) continue;
    if (LeftFor(orphan.tree, arc ^ 1) != 0) Activate(other);
    if (parent >= 0 && ArcAt(parent).to == at) Orphan(other);
  }
  orphan.tree = Tree::kFree;
  orphan.parent = kNone;
  orphan.seen_at = 0;
}

}  // namespace skyquilt::render
