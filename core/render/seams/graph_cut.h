// GraphCut: the cheapest way to part nodes in two, source side and sink side, by the maximal flow between two
// terminals (Boykov and Kolmogorov, "An experimental comparison of min-cut/max-flow algorithms", 2004). Of
// several cheapest cuts the one with the fewest nodes on the sink's side, which is unique: the answer depends
// neither on the order of edges nor on how the flow was found. Any graph is fine: empty, without edges, with
// zero weights, disconnected. Weights saturate at kMaxWeight. Not for several threads at once.
#pragma once

#include <cstdint>
#include <vector>

namespace skyquilt::render {

class GraphCut {
 public:
  // So that a pushed flow, up to the sum of both directions, stays within 32 bits.
  static constexpr std::int32_t kMaxWeight = (std::int32_t{1} << 30) - 1;

  GraphCut(std::size_t nodes, std::size_t expected_edges);

  // What it costs to have `from` on the source's and `to` on the sink's side. Weights are not negative.
  void AddEdge(std::size_t from, std::size_t to, std::int32_t weight);
  // What it costs to have the node on the sink's side (`source_weight`) or on the source's (`sink_weight`);
  // several add up.
  void AddTerminals(std::size_t node, std::int32_t source_weight, std::int32_t sink_weight);

  // Finds the cut; once, after all edges.
  void Solve();
  bool IsOnSinkSide(std::size_t node) const { return nodes_[node].tree == Tree::kSink; }

 private:
  using Index = std::int32_t;
  static constexpr Index kNone = -1, kTerminal = -2, kOrphan = -3;
  enum class Tree : std::uint8_t { kFree, kSource, kSink };

  struct Node {
    Index first_arc = kNone;
    Index parent = kNone;       // the arc from this node to its parent, or one of the marks above
    Index next_active = kNone;  // itself: last in the queue; kNone: not in it
    std::int32_t terminal = 0;  // left of the source's (positive) or sink's (negative) weight
    std::int32_t seen_at = 0;   // when the distance was last known to be true
    std::int32_t distance = 0;  // to the terminal
    Tree tree = Tree::kFree;
  };
  // Arcs come in pairs, there and back: the other of `arc` is `arc ^ 1`.
  struct Arc {
    Index to;
    Index next;  // of the same node
    std::int32_t left;
  };

  Node& At(Index node) { return nodes_[static_cast<std::size_t>(node)]; }
  Arc& ArcAt(Index arc) { return arcs_[static_cast<std::size_t>(arc)]; }
  // What may still flow along an arc of a node, away from the source or towards the sink as its tree asks.
  std::int32_t LeftFor(Tree tree, Index arc) { return ArcAt(tree == Tree::kSource ? arc : arc ^ 1).left; }
  void Activate(Index node);
  Index NextActive();
  Index Grow(Index node);
  void Augment(Index bridge);
  void Adopt();
  void AdoptOne(Index node);
  std::int32_t DistanceToTerminal(Index node);
  void Orphan(Index node);

  std::vector<Node> nodes_;
  std::vector<Arc> arcs_;
  std::vector<Index> orphans_;
  Index first_active_ = kNone, last_active_ = kNone;
  std::int32_t time_ = 0;
};

}  // namespace skyquilt::render
