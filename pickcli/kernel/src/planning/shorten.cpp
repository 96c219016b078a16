//! \file
//! First needless vertices go, then shortcuts are tried one after the other, then needless vertices go again.
#include "planning/shorten.hpp"

#include <algorithm>
#include <cmath>

namespace apc {

double EdgeCost::operator()(const double* from, const double* to, int n) const {
  double most = 0.0, squares = 0.0;
  for (int j = 0; j < n; ++j) {
    const double seconds = std::abs(to[j] - from[j]) / velocity[j];
    most = std::max(most, seconds);
    squares += seconds * seconds;
  }
  return most + calm * std::sqrt(squares);
}

namespace {

class Polyline {
 public:
  Polyline(const Checker& checker, const ShortenQuery& query)
      : checker_(checker),
        query_(query),
        n_(static_cast<std::size_t>(checker.n())),
        points_(query.Q, query.Q + n_ * static_cast<std::size_t>(query.n_rows)) {}

  std::size_t size() const { return points_.size() / n_; }
  std::vector<double> take() { return std::move(points_); }

  //! Goes from each vertex to the last that a proven edge leads to.
  void drop_needless() {
    std::vector<double> kept(points_.begin(), points_.begin() + signed_n());
    for (std::size_t at = 0, last = size() - 1; at < last;) {
      std::size_t to = last;
      while (to > at + 1 && !is_free(row(at), row(to))) --to;
      append(kept, row(to));
      at = to;
    }
    points_ = std::move(kept);
  }

  void take_shortcuts() {
    add_up();
    std::vector<double> a(n_), b(n_);
    for (int k = 0; k < query_.n_shortcuts; ++k) {
      const double from = query_.shortcuts[2 * k] * along_.back(),
                   to = query_.shortcuts[2 * k + 1] * along_.back();
      const std::size_t i = point(from, a.data()), j = point(to, b.data());
      const double saved = to - from - query_.cost(a.data(), b.data(), checker_.n());
      if (i == j || saved < query_.worthwhile * along_.back() || !is_free(a.data(), b.data())) continue;
      // The rests of the two cut edges are free, but a proof that halves them elsewhere may not get through.
      if (!is_free(row(i), a.data()) || !is_free(b.data(), row(j + 1))) continue;
      std::vector<double> cut(points_.begin(), points_.begin() + static_cast<std::ptrdiff_t>((i + 1) * n_));
      append(cut, a.data());
      append(cut, b.data());
      cut.insert(cut.end(), points_.begin() + static_cast<std::ptrdiff_t>((j + 1) * n_), points_.end());
      points_ = std::move(cut);
      add_up();
    }
  }

 private:
  const double* row(std::size_t i) const { return &points_[i * n_]; }
  std::ptrdiff_t signed_n() const { return static_cast<std::ptrdiff_t>(n_); }
  void append(std::vector<double>& points, const double* q) const { points.insert(points.end(), q, q + n_); }

  bool is_free(const double* a, const double* b) const {
    return checker_.check_edge(a, b, query_.margin, nullptr, query_.resolution).free;
  }

  //! along_[i]: cost from the start to vertex i.
  void add_up() {
    along_.assign(1, 0.0);
    for (std::size_t i = 0; i + 1 < size(); ++i)
      along_.push_back(along_.back() + query_.cost(row(i), row(i + 1), checker_.n()));
  }

  //! The edge on which this cost from the start is reached, and the point.
  std::size_t point(double cost, double* out) const {
    const auto after = std::upper_bound(along_.begin(), along_.end(), cost) - along_.begin();
    const std::size_t i = std::min(static_cast<std::size_t>(after) - 1, along_.size() - 2);
    const double share = (cost - along_[i]) / (along_[i + 1] - along_[i]);
    for (std::size_t j = 0; j < n_; ++j) out[j] = row(i)[j] + share * (row(i + 1)[j] - row(i)[j]);
    return i;
  }

  const Checker& checker_;
  const ShortenQuery& query_;
  const std::size_t n_;
  std::vector<double> points_, along_;
};

}  // namespace

std::vector<double> shorten(const Checker& checker, const ShortenQuery& query) {
  Polyline polyline(checker, query);
  polyline.drop_needless();
  if (polyline.size() > 2 && query.n_shortcuts > 0) polyline.take_shortcuts();
  polyline.drop_needless();
  return polyline.take();
}

}  // namespace apc
