#include "control/hierarchical_qp.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace apc {
namespace {

constexpr double kRank = 1e-9;        // of the largest row before it was projected: less counts as dependent
constexpr double kFeasible = 1e-10;   // violation from which a row is one of the least squares
constexpr double kOptimal = 1e-9;     // multiplier from which a row is let go
constexpr double kHeld = 1e-9;        // violation from which later levels keep a row where it is
constexpr double kMoves = 1e-12;      // change of a row over a step from which the step may be stopped there
constexpr double kEvaluated = 1e-7;   // largest change of a level's violation by later levels
constexpr std::size_t kMaxIterations = 1000;  // of one level; random problems of 16 unknowns take under 100

//! Rows a x <= b; equalities where is_equality.
struct Rows {
  Matrix a;
  std::vector<double> b;
  std::vector<std::uint8_t> is_equality;

  explicit Rows(std::size_t n) : a(0, n) {}

  void add(const double* row, double bound, double sign, bool is_equal = false) {
    a.append(row);
    double* last = a.row(a.n_rows - 1);
    for (std::size_t j = 0; j < a.n_columns; ++j) last[j] *= sign;
    b.push_back(sign * bound);
    is_equality.push_back(is_equal);
  }

  std::size_t size() const { return b.size(); }

  std::vector<double> excess(const std::vector<double>& x) const {
    std::vector<double> found(size());
    for (std::size_t i = 0; i < size(); ++i) found[i] = dot(a.row(i), x.data(), x.size()) - b[i];
    return found;
  }
};

Matrix selected(const Matrix& A, const std::vector<std::size_t>& rows) {
  Matrix some(0, A.n_columns);
  for (std::size_t i : rows) some.append(A.row(i));
  return some;
}

//! The search of one level within the free directions Z (n, k) that the levels before leave.
class LevelSearch {
 public:
  LevelSearch(const Rows& level, const Rows& kept, const Matrix& Z)
      : level_(level), kept_(kept), Z_(Z), levelZ_(product(level.a, Z)), keptZ_(product(kept.a, Z)),
        smallest_(kRank * largest_row(level.a)), smallest_kept_(kRank * largest_row(kept.a)), is_square_(level.size()), is_working_(kept.size()) {}

  //! Improve x to the optimum; false if the iterations do not end.
  bool run(std::vector<double>& x, std::size_t& n_iterations) {
    std::vector<double> excess = level_.excess(x);
    for (std::size_t i = 0; i < level_.size(); ++i)
      is_square_[i] = level_.is_equality[i] || excess[i] > kFeasible;
    for (std::size_t k = 0; k < kMaxIterations; ++k) {
      ++n_iterations;
      if (!step(x, excess) && !let_go(excess)) return true;
    }
    return false;
  }

 private:
  //! Step towards the least squares within the working set; true if a row stopped it, and joined.
  bool step(std::vector<double>& x, std::vector<double>& excess) {
    const std::vector<double> p = direction(excess);
    const std::vector<double> gaps = kept_.excess(x);
    double share = 1.0;
    std::size_t first = level_.size() + kept_.size();
    for (std::size_t i = 0; i < level_.size(); ++i)
      if (!is_square_[i]) stop_at(levelZ_.row(i), p, excess[i], i, share, first);
    for (std::size_t i = 0; i < kept_.size(); ++i)
      if (!is_working_[i]) stop_at(keptZ_.row(i), p, gaps[i], level_.size() + i, share, first);
    for (std::size_t i = 0; i < x.size(); ++i) x[i] += share * dot(Z_.row(i), p.data(), p.size());
    excess = level_.excess(x);
    if (first == level_.size() + kept_.size()) return false;
    if (first < level_.size()) {
      is_square_[first] = 1;
    } else {
      is_working_[first - level_.size()] = 1;
      working_.push_back(first - level_.size());
    }
    return true;
  }

  std::vector<double> direction(const std::vector<double>& excess) {
    std::vector<double> p(Z_.n_columns, 0.0);
    Matrix squares(0, Z_.n_columns);
    std::vector<double> wanted;
    for (std::size_t i = 0; i < level_.size(); ++i)
      if (is_square_[i]) squares.append(levelZ_.row(i)), wanted.push_back(-excess[i]);
    if (working_.empty()) return least_squares(squares, wanted.data(), smallest_);
    const Matrix N = null_space(selected(keptZ_, working_), smallest_kept_);
    const std::vector<double> y = least_squares(product(squares, N), wanted.data(), smallest_);
    for (std::size_t i = 0; i < p.size(); ++i) p[i] = dot(N.row(i), y.data(), y.size());
    return p;
  }

  //! Shorten the step to where a row (k,) that is `gap` beyond its bound, which is 0 or less, is met.
  static void stop_at(const double* row, const std::vector<double>& p, double gap, std::size_t i, double& share,
                      std::size_t& first) {
    const double moved = dot(row, p.data(), p.size());
    if (moved <= kMoves) return;
    const double until = std::max(0.0, -gap) / moved;
    if (until < share) share = until, first = i;
  }

  //! Let the row with the most negative multiplier go; false if there is none: the optimum is reached.
  bool let_go(const std::vector<double>& excess) {
    double least = -kOptimal;
    std::size_t worst = level_.size() + kept_.size();
    for (std::size_t i = 0; i < level_.size(); ++i)
      if (is_square_[i] && !level_.is_equality[i] && excess[i] < least) least = excess[i], worst = i;
    const std::vector<double> multipliers = working_multipliers(excess);
    std::size_t at = 0;
    for (std::size_t k = 0; k < working_.size(); ++k)
      if (multipliers[k] < least) least = multipliers[k], worst = level_.size() + working_[k], at = k;
    if (worst == level_.size() + kept_.size()) return false;
    if (worst < level_.size()) {
      is_square_[worst] = 0;
    } else {
      is_working_[worst - level_.size()] = 0;
      working_.erase(working_.begin() + static_cast<std::ptrdiff_t>(at));
    }
    return true;
  }

  std::vector<double> working_multipliers(const std::vector<double>& excess) const {
    if (working_.empty()) return {};
    std::vector<double> gradient(Z_.n_columns, 0.0);
    for (std::size_t i = 0; i < level_.size(); ++i)
      if (is_square_[i])
        for (std::size_t j = 0; j < gradient.size(); ++j) gradient[j] -= excess[i] * levelZ_(i, j);
    return least_squares(transposed(selected(keptZ_, working_)), gradient.data(), smallest_kept_);
  }

  const Rows& level_;
  const Rows& kept_;
  const Matrix& Z_;
  Matrix levelZ_, keptZ_;
  double smallest_, smallest_kept_;  // of their projected rows: less is rounding
  std::vector<std::uint8_t> is_square_, is_working_;
  std::vector<std::size_t> working_;  // rows of kept_ that hold as equalities
};

Rows one_sided(const PriorityLevel& level) {
  Rows rows(level.rows.n_columns);
  for (std::size_t i = 0; i < level.rows.n_rows; ++i) {
    const double *row = level.rows.row(i), lower = level.lower[i], upper = level.upper[i];
    const bool is_equal = lower == upper;
    if (is_equal || std::isfinite(upper)) rows.add(row, upper, 1.0, is_equal);
    if (!is_equal && std::isfinite(lower)) rows.add(row, lower, -1.0);
  }
  return rows;
}

//! Keep what a level has reached: the rows that stay as they are leave Z, the others are kept within bounds.
void keep(const PriorityLevel& level, const std::vector<double>& violation, Rows& kept, Matrix& Z) {
  Matrix held(0, level.rows.n_columns);
  for (std::size_t i = 0; i < level.rows.n_rows; ++i) {
    const double* row = level.rows.row(i);
    if (level.lower[i] == level.upper[i] || std::abs(violation[i]) > kHeld) {
      held.append(row);
      continue;
    }
    if (std::isfinite(level.upper[i])) kept.add(row, level.upper[i], 1.0);
    if (std::isfinite(level.lower[i])) kept.add(row, level.lower[i], -1.0);
  }
  if (held.n_rows > 0 && Z.n_columns > 0) Z = product(Z, null_space(product(held, Z), kRank * largest_row(held)));
}

Matrix identity(std::size_t n) {
  Matrix I(n, n);
  for (std::size_t i = 0; i < n; ++i) I(i, i) = 1.0;
  return I;
}

//! Which level is further from its bounds at the end than when it was solved, "" if none is.
std::string spoilt(const std::vector<PriorityLevel>& levels, const HierarchySolution& found) {
  for (double each : found.x)
    if (!std::isfinite(each)) return "its solution is not finite";
  for (std::size_t p = 0; p < levels.size(); ++p) {
    const std::vector<double> now = levels[p].violation(found.x);
    for (std::size_t i = 0; i < now.size(); ++i)
      if (!(std::abs(now[i] - found.violations[p][i]) <= kEvaluated))
        return "level " + std::to_string(p + 1) + ": row " + std::to_string(i + 1) + " is moved by later levels";
  }
  return "";
}

}  // namespace

std::vector<double> PriorityLevel::violation(const std::vector<double>& x) const {
  std::vector<double> found(rows.n_rows, 0.0);
  for (std::size_t i = 0; i < rows.n_rows; ++i) {
    const double at = dot(rows.row(i), x.data(), x.size());
    found[i] = at > upper[i] ? at - upper[i] : at < lower[i] ? at - lower[i] : 0.0;
  }
  return found;
}

HierarchySolution solve_hierarchy(const std::vector<PriorityLevel>& levels, std::vector<double> start) {
  const std::size_t n = start.size();
  HierarchySolution found;
  found.x = std::move(start);
  Matrix Z = identity(n);
  Rows kept(n);
  for (const PriorityLevel& level : levels) {
    const Rows rows = one_sided(level);
    if (Z.n_columns > 0 && rows.size() > 0 && !LevelSearch(rows, kept, Z).run(found.x, found.n_iterations)) {
      found.failure = "level " + std::to_string(found.violations.size() + 1) + ": no optimum after " +
                      std::to_string(kMaxIterations) + " changes of its active set";
      return found;
    }
    found.violations.push_back(level.violation(found.x));
    keep(level, found.violations.back(), kept, Z);
  }
  found.failure = spoilt(levels, found);
  return found;
}

}  // namespace apc
