#include "perception/item_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

namespace apc {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kReach = 0.1;            //!< m at which a turn moves by its step
constexpr std::size_t kLeastPoints = 12;  //!< of a fit
constexpr std::size_t kMostPoints = 120;
constexpr double kForeground = 0.003;    //!< m that a point is nearer than what is known
constexpr float kMostlyMeasured = 0.3f;  //!< share of a block, for its point to be fitted
constexpr double kElsewhere = 0.015, kElsewhereAngle = 0.25;  //!< m or rad between places of one item
constexpr int kPairOptions = 8;                               //!< of each item that are tried in pairs
constexpr int kMostSweeps = 20, kMostPairRounds = 3;

double penalty(double penetration, const SearchSettings& settings) {
  return 1e3 * settings.penetration_cost * std::max(0.0, penetration - settings.allowed_penetration);
}

double pair_penetration(const Solid& a, const Solid& b) {
  if (norm(a.T.p - b.T.p) > norm(a.half) + a.rounding + norm(b.half) + b.rounding) return 0.0;
  return std::max(0.0, -signed_distance(a, b, 0.0));
}

//! The angle between poses of a product: that of its axis, if it is round.
double angle_between(SolidKind kind, const Pose& a, const Pose& b) {
  if (kind == SolidKind::sphere) return 0.0;
  if (kind == SolidKind::cylinder)
    return std::acos(std::min(std::abs(dot(a.R.column(2), b.R.column(2))), 1.0));
  // Half turns about its axes leave a box as it is.
  const Mat3 R = transposed(a.R) * b.R;
  double largest = -1.0;
  for (const double x : {-1.0, 1.0})
    for (const double y : {-1.0, 1.0})
      largest = std::max(largest, x * R(0, 0) + y * R(1, 1) + x * y * R(2, 2));
  return std::acos(std::clamp(0.5 * (largest - 1.0), -1.0, 1.0));
}

//! Points of what is nearer than what is known, and not on what is placed.
std::vector<Vec3> unexplained(const PlacePicture& picture, const Composite& others,
                              const CandidateSettings& settings) {
  std::vector<Vec3> points;
  const auto width = static_cast<std::size_t>(picture.width());
  const auto stride = static_cast<std::size_t>(settings.point_stride);
  for (std::size_t pixel = 0; pixel < picture.n_pixels(); ++pixel) {
    if (pixel % width % stride != 0 || pixel / width % stride != 0 || picture.share(pixel) < kMostlyMeasured)
      continue;
    const Vec3 p = picture.point(pixel);
    const auto known = static_cast<double>(picture.known_depth()[pixel]);
    if (!std::isfinite(known) || !(p.z < known - kForeground)) continue;
    if (others.owner[pixel] >= 0 &&
        std::abs(p.z - static_cast<double>(others.depth[pixel])) < settings.explained)
      continue;
    points.push_back(p);
  }
  return points;
}

//! At most kMostPoints of the points near a surface, spread evenly over them.
std::vector<Vec3> near_surface(const Product& product, const Pose& T, const std::vector<Vec3>& points,
                               double distance) {
  const Pose back = inverse(T);
  const double reach = norm(product.half) + distance;
  std::vector<Vec3> out;
  for (const Vec3& p : points) {
    const Vec3 away = p - T.p;
    if (dot(away, away) > reach * reach) continue;
    if (std::abs(distance_to_surface(product.kind, product.half, back * p)) < distance) out.push_back(p);
  }
  if (out.size() <= kMostPoints) return out;
  for (std::size_t i = 0; i < kMostPoints; ++i) out[i] = out[i * out.size() / kMostPoints];
  out.resize(kMostPoints);
  return out;
}

Pose fitted(const Product& product, Pose T, const std::vector<Vec3>& points,
            const CandidateSettings& settings, const Vec3& up) {
  FitSettings fit;
  fit.up = up;
  fit.freedom = Freedom::all;
  for (const double scale : settings.scales) {
    const std::vector<Vec3> own = near_surface(product, T, points, settings.near_surface);
    if (own.size() < kLeastPoints) return T;
    fit.scale = scale;
    T = fit_surface(product.kind, product.half, own, T, fit).T;
  }
  return T;
}

//! Those that exchange the axes of a box: sides of nearly equal length are easily taken for each other.
std::array<Mat3, 5> quarter_turns() {
  const Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
  return {from_columns(y, -1.0 * x, z), from_columns(x, z, -1.0 * y), from_columns(z, y, -1.0 * x),
          from_columns(y, z, x), from_columns(z, x, y)};
}

//! The best options first, no two of them of one place, at most n.
std::vector<Option> distinct(SolidKind kind, std::vector<Option> options, const CandidateSettings& settings,
                             int n, int most_there) {
  std::stable_sort(options.begin(), options.end(),
                   [](const Option& a, const Option& b) { return a.cost < b.cost; });
  std::vector<Option> kept;
  for (const Option& option : options) {
    if (static_cast<int>(kept.size()) >= n || !(option.cost < kInfinity)) break;
    int n_there = 0;
    bool is_new = true;
    for (const Option& other : kept) {
      const double distance = norm(other.T.p - option.T.p);
      if (distance < settings.place) ++n_there;
      if (distance < settings.apart && angle_between(kind, other.T, option.T) < settings.apart_angle)
        is_new = false;
    }
    if (is_new && n_there < most_there) kept.push_back(option);
  }
  return kept;
}

//! The choice of one option, or none, for each item.
class JointChoice {
 public:
  JointChoice(const PlacePicture& picture, const std::vector<int>& products,
              const std::vector<std::vector<Pose>>& options, double least_gain,
              const SearchSettings& settings)
      : picture_(picture), least_gain_(least_gain), settings_(settings), chosen_(products.size(), -1) {
    for (std::size_t i = 0; i < products.size(); ++i) {
      items_.emplace_back();
      for (const Pose& T : options[i])
        items_.back().push_back({picture.sight(products[i], T), picture.solid(products[i], T),
                                 penalty(picture.penetration(products[i], T), settings)});
    }
  }

  std::vector<Choice> run() {
    greedy();
    one_by_one();
    for (int round = 0; round < kMostPairRounds && in_pairs(); ++round) one_by_one();
    std::vector<Choice> found;
    for (std::size_t i = 0; i < items_.size(); ++i) found.push_back(result(i));
    return found;
  }

 private:
  struct Entry {
    Sight sight;
    Solid solid;
    double own_penalty;
  };
  struct Best {
    int option = -1;
    double cost = 0.0;  //!< of none
  };

  Composite without(std::size_t i, std::size_t j) const {
    Composite out = known_only(picture_);
    for (std::size_t k = 0; k < items_.size(); ++k)
      if (k != i && k != j && chosen_[k] >= 0)
        add(out, entry(k, chosen_[k]).sight, static_cast<std::int32_t>(k));
    return out;
  }

  const Entry& entry(std::size_t item, int option) const {
    return items_[item][static_cast<std::size_t>(option)];
  }

  double penalty_between(std::size_t i, int a, std::size_t j, int b) {
    if (i > j) {
      std::swap(i, j);
      std::swap(a, b);
    }
    const auto key = std::make_tuple(i, a, j, b);
    const auto known = penalties_.find(key);
    if (known != penalties_.end()) return known->second;
    const double found = penalty(pair_penetration(entry(i, a).solid, entry(j, b).solid), settings_);
    penalties_.emplace(key, found);
    return found;
  }

  //! Cost of an option with the chosen ones of all others but one; least_gain is what having none saves.
  double cost(std::size_t i, int option, const Composite& others, std::size_t except) {
    double sum = cost_before(entry(i, option).sight, others) + entry(i, option).own_penalty + least_gain_;
    for (std::size_t k = 0; k < items_.size() && sum < 0.0; ++k)
      if (k != i && k != except && chosen_[k] >= 0) sum += penalty_between(i, option, k, chosen_[k]);
    return sum;
  }

  Best best(std::size_t i, const Composite& others, std::size_t except) {
    Best found;
    for (int option = 0; option < static_cast<int>(items_[i].size()); ++option) {
      const double c = cost(i, option, others, except);
      if (c < found.cost) found = {option, c};
    }
    return found;
  }

  void greedy() {
    for (std::size_t n = 0; n < items_.size(); ++n) {
      const Composite others = without(items_.size(), items_.size());
      std::size_t which = items_.size();
      Best least;
      for (std::size_t i = 0; i < items_.size(); ++i) {
        if (chosen_[i] >= 0) continue;
        const Best found = best(i, others, items_.size());
        if (found.cost < least.cost) {
          least = found;
          which = i;
        }
      }
      if (which == items_.size()) return;
      chosen_[which] = least.option;
      one_by_one();
    }
  }

  //! Only items that have a place, or may get one.
  void one_by_one() {
    for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
      bool has_changed = false;
      for (std::size_t i = 0; i < items_.size(); ++i) {
        if (chosen_[i] < 0) continue;
        const Best found = best(i, without(i, i), i);
        has_changed = has_changed || found.option != chosen_[i];
        chosen_[i] = found.option;
      }
      if (!has_changed) return;
    }
  }

  bool in_pairs() {
    bool has_changed = false;
    for (std::size_t i = 0; i < items_.size(); ++i)
      for (std::size_t j = i + 1; j < items_.size(); ++j) has_changed = change_pair(i, j) || has_changed;
    return has_changed;
  }

  bool change_pair(std::size_t i, std::size_t j) {
    const int before_i = chosen_[i], before_j = chosen_[j];
    const Composite others = without(i, j);
    chosen_[i] = chosen_[j] = -1;
    std::vector<std::pair<double, int>> ranked{{0.0, -1}};
    for (int a = 0; a < static_cast<int>(items_[i].size()); ++a) {
      const double c = cost(i, a, others, j);
      if (a == before_i || c < 0.0) ranked.emplace_back(c, a);
    }
    std::stable_sort(ranked.begin(), ranked.end());
    double least = kInfinity, before = kInfinity;
    std::pair<int, int> chosen{before_i, before_j};
    int tried = 0;
    for (const auto& [cost_a, a] : ranked) {
      if (tried++ >= kPairOptions && a != before_i && a >= 0) continue;
      Composite with = others;
      if (a >= 0) add(with, entry(i, a).sight, static_cast<std::int32_t>(i));
      chosen_[i] = a;
      const Best b = best(j, with, j);
      if (a == before_i) {
        before = cost_a + (before_j < 0 ? 0.0 : cost(j, before_j, with, j));
        if (before < least - 1e-6) {
          least = before;
          chosen = {before_i, before_j};
        }
      }
      if (cost_a + b.cost < least - 1e-6) {
        least = cost_a + b.cost;
        chosen = {a, b.option};
      }
    }
    chosen_[i] = chosen.first;
    chosen_[j] = chosen.second;
    return least < before - 1e-6;
  }

  //! Whether an option is another place than the chosen one, not the same a little off.
  bool is_elsewhere(std::size_t i, int option) const {
    const Pose &a = entry(i, option).solid.T, &b = entry(i, chosen_[i]).solid.T;
    return norm(a.p - b.p) > kElsewhere || angle_between(entry(i, option).solid.kind, a, b) > kElsewhereAngle;
  }

  Choice result(std::size_t i) {
    if (chosen_[i] < 0) return {};
    const Composite others = without(i, i);
    const double own = cost(i, chosen_[i], others, i) - least_gain_;
    double next = 0.0;
    for (int option = 0; option < static_cast<int>(items_[i].size()); ++option)
      if (is_elsewhere(i, option)) next = std::min(next, cost(i, option, others, i) - least_gain_);
    return {chosen_[i], -own, next - own};
  }

  const PlacePicture& picture_;
  double least_gain_;
  const SearchSettings& settings_;
  std::vector<std::vector<Entry>> items_;
  std::vector<int> chosen_;
  std::map<std::tuple<std::size_t, int, std::size_t, int>, double> penalties_;
};

}  // namespace

double cost_before(const Sight& sight, const Composite& others) {
  double sum = 0.0;
  for (std::size_t i = 0; i < sight.pixel.size(); ++i) {
    const auto pixel = static_cast<std::size_t>(sight.pixel[i]);
    if (sight.depth[i] < others.depth[pixel]) sum += static_cast<double>(sight.cost[i] - others.cost[pixel]);
  }
  return sum;
}

Composite known_only(const PlacePicture& picture) {
  return {picture.known_depth(), picture.known_costs(), std::vector<std::int32_t>(picture.n_pixels(), -1)};
}

void add(Composite& composite, const Sight& sight, std::int32_t owner) {
  for (std::size_t i = 0; i < sight.pixel.size(); ++i) {
    const auto pixel = static_cast<std::size_t>(sight.pixel[i]);
    if (!(sight.depth[i] < composite.depth[pixel])) continue;
    composite.depth[pixel] = sight.depth[i];
    composite.cost[pixel] = sight.cost[i];
    composite.owner[pixel] = owner;
  }
}

Composite composed(const PlacePicture& picture, const std::vector<PlacedProduct>& placed, int except) {
  Composite out = known_only(picture);
  for (int i = 0; i < static_cast<int>(placed.size()); ++i)
    if (i != except) {
      const PlacedProduct& one = placed[static_cast<std::size_t>(i)];
      add(out, picture.sight(one.product, one.T), i);
    }
  return out;
}

Option searched(const PlacePicture& picture, const PlacedProduct& start, const Composite& others,
                const std::vector<PlacedProduct>& neighbours, const SearchSettings& settings) {
  std::vector<Solid> solids;
  for (const PlacedProduct& each : neighbours) solids.push_back(picture.solid(each.product, each.T));
  const SolidKind kind = picture.product(start.product).kind;
  // Solids that reach into each other only cost more: what shows too little already need not be tested for that.
  const auto cost = [&](const Pose& T, double less_than) {
    double sum = picture.cost_before(start.product, T, others);
    if (!(sum < less_than)) return sum;
    sum += penalty(picture.penetration(start.product, T), settings);
    const Solid own = picture.solid(start.product, T);
    for (const Solid& other : solids) sum += penalty(pair_penetration(own, other), settings);
    return sum;
  };
  // A solid that is turned about its middle no longer agrees with the side that is seen best: turns about edges
  // leave what meets there where it is.
  const Vec3& size = picture.product(start.product).half;
  const std::array<double, 3> half{size.x, size.y, size.z};
  const auto turned = [&](const Pose& T, const Vec3& axis, const Vec3& fixed, double step) {
    const Mat3 R = rotation(axis, step / kReach * settings.turn_per_step);
    return Pose{R * T.R, fixed + R * (T.p - fixed)};
  };
  const auto moved = [&](const Pose& T, int direction, double step) {
    if (direction < 3) return Pose{T.R, T.p + step * T.R.column(direction)};
    if (settings.freedom != Freedom::all) return turned(T, settings.up, T.p, step);
    const int axis = direction % 3, edge = direction / 3 - 2, b = (axis + 1) % 3, c = (axis + 2) % 3;
    if (edge < 0) return turned(T, T.R.column(axis), T.p, step);
    const double y = half[static_cast<std::size_t>(b)], z = half[static_cast<std::size_t>(c)];
    const Vec3 out = (edge & 1 ? -y : y) * T.R.column(b) + (edge & 2 ? -z : z) * T.R.column(c);
    return turned(T, T.R.column(axis), T.p + out, step);
  };
  Option best{start.T, cost(start.T, kInfinity)};
  const auto improve = [&](int first, int last, double step) {
    const double before = best.cost;
    for (int direction = first; direction < last; ++direction) {
      if (direction >= 3 && kind == SolidKind::sphere) break;
      if (direction >= 3 && direction % 3 == 2 && kind == SolidKind::cylinder) continue;
      for (const double sign : {1.0, -1.0}) {
        const Pose T = moved(best.T, direction, sign * step);
        const double c = cost(T, best.cost);
        if (!(c < best.cost)) continue;
        best = {T, c};
        break;
      }
    }
    return best.cost < before;
  };
  const bool is_free = settings.freedom == Freedom::all;
  for (const double step : settings.steps)
    for (int round = 0; round < settings.most_rounds; ++round)
      if (!improve(0, is_free ? 6 : 4, step) && !(is_free && improve(6, 18, step))) break;
  return best;
}

std::vector<Option> candidates(const PlacePicture& picture, int product, const std::vector<Pose>& starts,
                               const std::vector<PlacedProduct>& placed, const CandidateSettings& settings,
                               const SearchSettings& search) {
  const Product& shape = picture.product(product);
  const Composite others = composed(picture, placed, -1);
  const std::vector<Vec3> points = unexplained(picture, others, settings);
  std::vector<Option> found;
  for (const Pose& start : starts) {
    Option best{start, kInfinity};
    for (const Pose& T : {fitted(shape, start, points, settings, search.up), start}) {
      int shown = 0;
      const double cost = picture.cost_before(product, T, others, &shown);
      if (shown >= settings.least_shown && cost < best.cost) best = {T, cost};
    }
    found.push_back(best);
  }
  std::vector<Solid> solids;
  for (const PlacedProduct& each : placed) solids.push_back(picture.solid(each.product, each.T));
  for (Option& option : found) {
    if (!(option.cost < kInfinity)) continue;
    option.cost += penalty(picture.penetration(product, option.T), search);
    const Solid own = picture.solid(product, option.T);
    for (const Solid& other : solids) option.cost += penalty(pair_penetration(own, other), search);
  }
  found = distinct(shape.kind, std::move(found), settings, settings.n_searched, 2 * settings.most_there);
  for (Option& option : found) option = searched(picture, {product, option.T}, others, placed, search);
  return distinct(shape.kind, std::move(found), settings, settings.n_kept, settings.most_there);
}

std::vector<Choice> choose(const PlacePicture& picture, const std::vector<int>& products,
                           const std::vector<std::vector<Pose>>& options, double least_gain,
                           const SearchSettings& settings) {
  return JointChoice(picture, products, options, least_gain, settings).run();
}

std::vector<Pose> refined(const PlacePicture& picture, std::vector<PlacedProduct> placed, int n_rounds,
                          const SearchSettings& settings) {
  for (int round = 0; round < n_rounds; ++round)
    for (int i = 0; i < static_cast<int>(placed.size()); ++i) {
      std::vector<PlacedProduct> neighbours = placed;
      neighbours.erase(neighbours.begin() + i);
      const Composite others = composed(picture, placed, i);
      PlacedProduct& one = placed[static_cast<std::size_t>(i)];
      Option best = searched(picture, one, others, neighbours, settings);
      if (settings.tries_turns && picture.product(one.product).kind == SolidKind::box)
        for (const Mat3& turn : quarter_turns()) {
          const Pose turned{one.T.R * turn, one.T.p};
          const Option other = searched(picture, {one.product, turned}, others, neighbours, settings);
          if (other.cost < best.cost) best = other;
        }
      one.T = best.T;
    }
  std::vector<Pose> poses;
  for (const PlacedProduct& each : placed) poses.push_back(each.T);
  return poses;
}

std::vector<Evidence> evidence(const PlacePicture& picture, const std::vector<PlacedProduct>& placed,
                               double near_surface, const SearchSettings& settings) {
  std::vector<Evidence> found;
  for (int i = 0; i < static_cast<int>(placed.size()); ++i) {
    const PlacedProduct& one = placed[static_cast<std::size_t>(i)];
    const Composite others = composed(picture, placed, i);
    const Sight sight = picture.sight(one.product, one.T);
    Evidence e;
    e.gain = -cost_before(sight, others) - penalty(picture.penetration(one.product, one.T), settings);
    for (std::size_t k = 0; k < sight.pixel.size(); ++k) {
      const auto pixel = static_cast<std::size_t>(sight.pixel[k]);
      ++e.expected;
      if (!(sight.depth[k] < others.depth[pixel])) continue;
      ++e.shown;
      if (!picture.is_measured(pixel)) continue;
      const double off = picture.point(pixel).z - static_cast<double>(sight.depth[k]);
      if (std::abs(off) <= near_surface) {
        ++e.supported;
        e.colour += picture.colour_cost(one.product, pixel);
      } else {
        ++(off > 0.0 ? e.through : e.before);
      }
    }
    if (e.supported > 0) e.colour /= e.supported;
    found.push_back(e);
  }
  return found;
}

}  // namespace apc
