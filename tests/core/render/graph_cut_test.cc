#include "core/render/seams/graph_cut.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <tuple>

namespace skyquilt::render {
namespace {

struct Graph {
  struct Edge {
    std::size_t from, to;
    std::int32_t weight;
  };
  std::vector<std::int32_t> source, sink;  // by node
  std::vector<Edge> edges;
};

// What it costs to have the nodes whose bits are set on the sink's side.
std::int64_t CostOf(const Graph& graph, std::uint32_t on_sink_side) {
  const auto is_on_sink_side = [&](std::size_t node) { return (on_sink_side >> node & 1U) != 0; };
  std::int64_t cost = 0;
  for (std::size_t i = 0; i < graph.source.size(); ++i)
    cost += is_on_sink_side(i) ? graph.source[i] : graph.sink[i];
  for (const Graph::Edge& edge : graph.edges) {
    if (!is_on_sink_side(edge.from) && is_on_sink_side(edge.to)) cost += edge.weight;
  }
  return cost;
}

// Of the cheapest cuts the one that all others contain.
std::uint32_t SmallestCheapest(const Graph& graph) {
  std::int64_t least = INT64_MAX;
  std::uint32_t in_all = 0;
  for (std::uint32_t cut = 0; cut < (1U << graph.source.size()); ++cut) {
    const std::int64_t cost = CostOf(graph, cut);
    if (cost < least) in_all = ~0U;
    least = std::min(least, cost);
    if (cost == least) in_all &= cut;
  }
  return in_all;
}

std::uint32_t Solved(const Graph& graph) {
  GraphCut cut(graph.source.size(), graph.edges.size());
  for (const Graph::Edge& edge : graph.edges) cut.AddEdge(edge.from, edge.to, edge.weight);
  for (std::size_t i = 0; i < graph.source.size(); ++i) cut.AddTerminals(i, graph.source[i], graph.sink[i]);
  cut.Solve();
  std::uint32_t on_sink_side = 0;
  for (std::size_t i = 0; i < graph.source.size(); ++i) {
    if (cut.IsOnSinkSide(i)) on_sink_side |= 1U << i;
  }
  return on_sink_side;
}

Graph RandomGraph(std::mt19937& random, std::int32_t max_weight) {
  const auto up_to = [&](std::int64_t most) {
    return static_cast<std::int32_t>(std::uniform_int_distribution<std::int64_t>(0, most)(random));
  };
  const auto weight = [&] { return up_to(3) == 0 ? 0 : up_to(max_weight); };
  Graph graph;
  const std::int32_t nodes = up_to(10);
  for (std::int32_t i = 0; i < nodes; ++i) {
    graph.source.push_back(weight());
    graph.sink.push_back(weight());
  }
  if (nodes < 2) return graph;
  // From none, so that every node is alone, to more than one between the same two.
  const std::int32_t edges = up_to(3 * nodes);
  for (std::int32_t k = 0; k < edges; ++k) {
    const std::int32_t from = up_to(nodes - 1), to = (from + 1 + up_to(nodes - 2)) % nodes;
    graph.edges.push_back({static_cast<std::size_t>(from), static_cast<std::size_t>(to), weight()});
  }
  return graph;
}

TEST(GraphCut, FindsTheSmallestOfTheCheapestCuts) {
  std::mt19937 random(7);
  // Small weights make many cuts equally cheap.
  for (const std::int32_t max_weight : {1, 3, 20, 1000, GraphCut::kMaxWeight}) {
    for (int round = 0; round < 1500; ++round) {
      const Graph graph = RandomGraph(random, max_weight);
      ASSERT_EQ(Solved(graph), SmallestCheapest(graph)) << "round " << round << ", weights to " << max_weight;
    }
  }
}

TEST(GraphCut, DoesNotDependOnTheOrderOfEdges) {
  std::mt19937 random(8);
  for (int round = 0; round < 500; ++round) {
    Graph graph = RandomGraph(random, 5);
    const std::uint32_t before = Solved(graph);
    std::shuffle(graph.edges.begin(), graph.edges.end(), random);
    ASSERT_EQ(Solved(graph), before) << "round " << round;
  }
}

TEST(GraphCut, TakesGraphsWithNothingToCut) {
  EXPECT_EQ(Solved({}), 0U);
  EXPECT_EQ(Solved({{0}, {0}, {}}), 0U);
  EXPECT_EQ(Solved({{0}, {5}, {}}), 1U);
  EXPECT_EQ(Solved({{5, 0}, {0, 5}, {}}), 2U);
  EXPECT_EQ(Solved({{5, 5}, {5, 5}, {{0, 1, 0}}}), 0U);
}

TEST(GraphCut, SaturatesWeights) {
  constexpr std::int32_t kHuge = INT32_MAX;
  // Cheaper than the edge is one of the two ends, though both sums would not fit 32 bits.
  EXPECT_EQ(Solved({{kHuge, 0}, {0, 7}, {{0, 1, kHuge}, {0, 1, kHuge}, {1, 0, kHuge}}}), 0U);
  EXPECT_EQ(Solved({{7, 0}, {0, kHuge}, {{0, 1, kHuge}}}), 3U);
  GraphCut cut(1, 0);
  for (int i = 0; i < 10; ++i) cut.AddTerminals(0, 0, kHuge);
  cut.AddTerminals(0, 9, 0);
  cut.Solve();
  EXPECT_TRUE(cut.IsOnSinkSide(0));
}

// A picture of labels as seams have it: neighbours in a grid, compared with the cost of every other cut that
// differs in one node or in one row.
TEST(GraphCut, NoSingleChangeMakesALargeGridCheaper) {
  constexpr std::size_t kSide = 60;
  std::mt19937 random(9);
  std::uniform_int_distribution<std::int32_t> weight(0, 50);
  std::vector<std::int32_t> source, sink;
  std::vector<std::tuple<std::size_t, std::size_t, std::int32_t>> edges;
  for (std::size_t i = 0; i < kSide * kSide; ++i) {
    source.push_back(weight(random));
    sink.push_back(weight(random));
    if (i % kSide + 1 < kSide) edges.emplace_back(i, i + 1, weight(random));
    if (i + kSide < kSide * kSide) edges.emplace_back(i + kSide, i, weight(random));
  }
  GraphCut cut(kSide * kSide, edges.size());
  for (const auto& [from, to, cost] : edges) cut.AddEdge(from, to, cost);
  for (std::size_t i = 0; i < source.size(); ++i) cut.AddTerminals(i, source[i], sink[i]);
  cut.Solve();
  std::vector<char> side;
  for (std::size_t i = 0; i < source.size(); ++i) side.push_back(cut.IsOnSinkSide(i) ? 1 : 0);
  const auto cost_of = [&] {
    std::int64_t cost = 0;
    for (std::size_t i = 0; i < source.size(); ++i) cost += side[i] ? source[i] : sink[i];
    for (const auto& [from, to, weight_of_edge] : edges) cost += !side[from] && side[to] ? weight_of_edge : 0;
    return cost;
  };
  const std::int64_t best = cost_of();
  for (std::size_t i = 0; i < source.size(); ++i) {
    side[i] ^= 1;
    EXPECT_GE(cost_of(), best + (side[i] ? 0 : 1)) << "node " << i;
    side[i] ^= 1;
  }
  for (std::size_t row = 0; row < kSide; ++row) {
    for (std::size_t x = 0; x < kSide; ++x) side[row * kSide + x] ^= 1;
    EXPECT_GE(cost_of(), best) << "row " << row;
    for (std::size_t x = 0; x < kSide; ++x) side[row * kSide + x] ^= 1;
  }
}

}  // namespace
}  // namespace skyquilt::render
