//! \file
//! Two trees of proven edges that grow towards each other.
#include "planning/rrt_connect.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace apc {
namespace {

//! Radius of a node's domain once an edge from it has failed, as a share of the diagonal.
constexpr double kDomain = 0.3;

//! Draws of one iteration, at most: the last one counts wherever it lies.
constexpr int kMostDraws = 50;

//! Iterations after which both trees begin anew, over the diagonal's length in steps: trees that went astray
//! early seldom recover. Their edges are then half as long, as narrow passages ask for, until they are this many
//! times shorter; then long again.
constexpr double kAttempt = 175.0;
constexpr double kMostShorter = 4.0;

//! Steele, Lea and Flood 2014. Unlike the engines of the standard library it begins at no cost.
class SplitMix64 {
 public:
  explicit SplitMix64(std::uint64_t seed) : state_(seed) {}

  //! Uniform in [0, 1).
  double operator()() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
    z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
    return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
  }

 private:
  std::uint64_t state_;
};

struct Nearest {
  int node;
  double distance;
};

//! Configurations, each with the one that it was reached from; the roots come first.
class Tree {
 public:
  Tree(int n, const double* roots, int n_roots)
      : n_(n), states_(roots, roots + n * n_roots), parents_(n_roots, -1), is_edge_failed_(n_roots, false) {}

  int size() const { return static_cast<int>(parents_.size()); }
  int parent(int i) const { return parents_[static_cast<std::size_t>(i)]; }
  const double* state(int i) const {
    return &states_[static_cast<std::size_t>(i) * static_cast<std::size_t>(n_)];
  }

  int add(const double* q, int parent) {
    states_.insert(states_.end(), q, q + n_);
    parents_.push_back(parent);
    is_edge_failed_.push_back(false);
    return size() - 1;
  }

  //! Whether an edge drawn from a node was not proven: it stands before something.
  bool is_at_obstacle(int i) const { return is_edge_failed_[static_cast<std::size_t>(i)]; }
  void set_at_obstacle(int i) { is_edge_failed_[static_cast<std::size_t>(i)] = true; }

  //! The first of the nearest, by going through all: up to some thousands nothing is quicker.
  Nearest nearest(const double* q) const {
    int best = 0;
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i < size(); ++i) {
      const double* p = state(i);
      double d = 0.0;
      for (int j = 0; j < n_; ++j) d += (p[j] - q[j]) * (p[j] - q[j]);
      if (d < least) least = d, best = i;
    }
    return {best, std::sqrt(least)};
  }

 private:
  int n_;
  std::vector<double> states_;
  std::vector<int> parents_;
  std::vector<bool> is_edge_failed_;
};

class Search {
 public:
  Search(const Checker& checker, const ConnectQuery& query)
      : checker_(checker),
        query_(query),
        n_(checker.n()),
        random_(query.seed),
        at_start_(n_, query.start, 1),
        at_goals_(n_, query.goals, query.n_goals),
        drawn_(static_cast<std::size_t>(n_)),
        stepped_(drawn_),
        step_(query.step),
        diagonal_(distance(query.lower, query.upper)) {}

  std::vector<double> run() {
    double left = kAttempt * diagonal_ / step_;
    for (int i = 0; i < query_.max_iterations; ++i) {
      if (--left < 0.0) {
        begin_anew();
        left = kAttempt * diagonal_ / step_;
      }
      // The smaller tree grows: where one is shut in, the other must not outgrow it.
      const bool from_start = at_start_.size() <= at_goals_.size();
      Tree &grown = from_start ? at_start_ : at_goals_, &other = from_start ? at_goals_ : at_start_;
      const Nearest near = draw_near(grown);
      const int tip = step_towards(grown, near, drawn_.data(), from_start).node;
      if (tip < 0) {
        grown.set_at_obstacle(near.node);
        continue;
      }
      const std::vector<double> target(grown.state(tip), grown.state(tip) + n_);
      const int met = run_towards(other, target.data(), !from_start);
      if (met >= 0) return from_start ? joined(tip, met) : joined(met, tip);
    }
    return {};
  }

 private:
  struct Step {
    int node = -1;  //!< that was added; -1: the edge to it is not proven
    bool arrived = false;
  };

  double distance(const double* p, const double* q) const {
    double squares = 0.0;
    for (int j = 0; j < n_; ++j) squares += (q[j] - p[j]) * (q[j] - p[j]);
    return std::sqrt(squares);
  }

  void begin_anew() {
    step_ = step_ * kMostShorter > query_.step ? step_ / 2.0 : query_.step;
    at_start_ = Tree(n_, query_.start, 1);
    at_goals_ = Tree(n_, query_.goals, query_.n_goals);
  }

  //! Draws until what is drawn lies in the domain of the node that is nearest to it (Yershova et al. 2005): what
  //! lies far beyond an obstacle would only lead into it again.
  Nearest draw_near(const Tree& tree) {
    Nearest near;
    for (int i = 0; i < kMostDraws; ++i) {
      draw();
      near = tree.nearest(drawn_.data());
      if (!tree.is_at_obstacle(near.node) || near.distance <= kDomain * diagonal_) break;
    }
    return near;
  }

  void draw() {
    for (std::size_t j = 0; j < drawn_.size(); ++j)
      drawn_[j] = query_.lower[j] + random_() * (query_.upper[j] - query_.lower[j]);
  }

  //! From a node towards q, by one step at most.
  Step step_towards(Tree& tree, const Nearest& near, const double* q, bool from_start) {
    const double* p = tree.state(near.node);
    const bool arrives = near.distance <= step_;
    for (int j = 0; j < n_; ++j)
      stepped_[static_cast<std::size_t>(j)] =
          arrives ? q[j] : p[j] + step_ / near.distance * (q[j] - p[j]);
    const double *a = from_start ? p : stepped_.data(), *b = from_start ? stepped_.data() : p;
    if (!checker_.check_edge(a, b, query_.margin, nullptr, query_.resolution, true).free) return {};
    return {tree.add(stepped_.data(), near.node), arrives};
  }

  //! Step by step as far as edges are proven; the node at q if it gets there, else -1.
  int run_towards(Tree& tree, const double* q, bool from_start) {
    for (;;) {
      const Step step = step_towards(tree, tree.nearest(q), q, from_start);
      if (step.node < 0) return -1;
      if (step.arrived) return step.node;
    }
  }

  //! Through both trees, whose nodes of these numbers are the same configuration.
  std::vector<double> joined(int in_start, int in_goals) const {
    std::vector<int> up;
    for (int i = in_start; i >= 0; i = at_start_.parent(i)) up.push_back(i);
    std::vector<double> path;
    for (auto i = up.rbegin(); i != up.rend(); ++i) append(path, at_start_.state(*i));
    for (int i = at_goals_.parent(in_goals); i >= 0; i = at_goals_.parent(i))
      append(path, at_goals_.state(i));
    return path;
  }

  void append(std::vector<double>& path, const double* q) const { path.insert(path.end(), q, q + n_); }

  const Checker& checker_;
  const ConnectQuery& query_;
  const int n_;
  SplitMix64 random_;
  Tree at_start_, at_goals_;
  std::vector<double> drawn_, stepped_;
  double step_;            //!< longest edge of the trees as they are
  const double diagonal_;  //!< of the box that is drawn from
};

}  // namespace

std::vector<double> rrt_connect(const Checker& checker, const ConnectQuery& query) {
  return Search(checker, query).run();
}

}  // namespace apc
