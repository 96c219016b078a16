//! \file
//! Two trees of proven edges that grow towards each other.
#include "planning/rrt_connect.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace apc {
namespace {

//! Configurations, each with the one that it was reached from; the roots come first.
class Tree {
 public:
  Tree(int n, const double* roots, int n_roots)
      : n_(n), states_(roots, roots + n * n_roots), parents_(n_roots, -1) {}

  int size() const { return static_cast<int>(parents_.size()); }
  int parent(int i) const { return parents_[static_cast<std::size_t>(i)]; }
  const double* state(int i) const {
    return &states_[static_cast<std::size_t>(i) * static_cast<std::size_t>(n_)];
  }

  int add(const double* q, int parent) {
    states_.insert(states_.end(), q, q + n_);
    parents_.push_back(parent);
    return size() - 1;
  }

  //! The first of the nearest, by going through all: up to some thousands nothing is quicker.
  int nearest(const double* q) const {
    int best = 0;
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i < size(); ++i) {
      const double* p = state(i);
      double d = 0.0;
      for (int j = 0; j < n_; ++j) d += (p[j] - q[j]) * (p[j] - q[j]);
      if (d < least) least = d, best = i;
    }
    return best;
  }

 private:
  int n_;
  std::vector<double> states_;
  std::vector<int> parents_;
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
        stepped_(drawn_) {}

  std::vector<double> run() {
    for (int i = 0; i < query_.max_iterations; ++i) {
      // The smaller tree grows: where one is shut in, the other must not outgrow it.
      const bool from_start = at_start_.size() <= at_goals_.size();
      Tree &grown = from_start ? at_start_ : at_goals_, &other = from_start ? at_goals_ : at_start_;
      draw();
      const int tip = step_towards(grown, drawn_.data(), from_start).node;
      if (tip < 0) continue;
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

  //! By a recipe of our own: what std::uniform_real_distribution returns is not the same everywhere.
  void draw() {
    for (std::size_t j = 0; j < drawn_.size(); ++j) {
      const double share = static_cast<double>(random_() >> 11) * 0x1p-53;
      drawn_[j] = query_.lower[j] + share * (query_.upper[j] - query_.lower[j]);
    }
  }

  Step step_towards(Tree& tree, const double* q, bool from_start) {
    const int near = tree.nearest(q);
    const double* p = tree.state(near);
    double d = 0.0;
    for (int j = 0; j < n_; ++j) d += (q[j] - p[j]) * (q[j] - p[j]);
    d = std::sqrt(d);
    const bool arrives = d <= query_.step;
    for (int j = 0; j < n_; ++j)
      stepped_[static_cast<std::size_t>(j)] = arrives ? q[j] : p[j] + query_.step / d * (q[j] - p[j]);
    const double *a = from_start ? p : stepped_.data(), *b = from_start ? stepped_.data() : p;
    if (!checker_.check_edge(a, b, query_.margin, nullptr, query_.resolution, true).free) return {};
    return {tree.add(stepped_.data(), near), arrives};
  }

  //! Step by step as far as edges are proven; the node at q if it gets there, else -1.
  int run_towards(Tree& tree, const double* q, bool from_start) {
    for (;;) {
      const Step step = step_towards(tree, q, from_start);
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
  std::mt19937_64 random_;
  Tree at_start_, at_goals_;
  std::vector<double> drawn_, stepped_;
};

}  // namespace

std::vector<double> rrt_connect(const Checker& checker, const ConnectQuery& query) {
  return Search(checker, query).run();
}

}  // namespace apc
