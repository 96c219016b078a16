//! \file
//! pickcli.kernel.PlacePicture and fits of poses.
#include "bindings/bindings.hpp"

#include <nanobind/stl/vector.h>

#include <array>

#include "bindings/arrays.hpp"
#include "perception/item_search.hpp"
#include "perception/place_picture.hpp"
#include "perception/surface_fit.hpp"

namespace apc {
namespace {

using namespace nb::literals;

using Floats = nb::ndarray<const float, nb::shape<-1, -1>, nb::c_contig, nb::device::cpu>;
using Labels = nb::ndarray<const std::int32_t, nb::shape<-1, -1>, nb::c_contig, nb::device::cpu>;

SolidKind to_kind(int kind) {
  if (kind < 0 || kind > 2) throw nb::value_error("kind: 0 is a box, 1 a cylinder, 2 a sphere");
  return static_cast<SolidKind>(kind);
}

Vec3 to_vector(nb::handle in, const char* name) {
  const Doubles v(in, name, {3});
  return {v[0], v[1], v[2]};
}

Vec3 to_half(nb::handle in, SolidKind kind) {
  const Vec3 h = to_vector(in, "half_extents");
  if (!(h.x > 0.0 && h.y > 0.0 && h.z > 0.0) || (kind != SolidKind::box && h.x != h.y) ||
      (kind == SolidKind::sphere && h.y != h.z))
    throw nb::value_error("half_extents: must be positive, and radii where it is round");
  return h;
}

std::vector<Pose> to_poses(nb::handle in, const char* name) {
  const Doubles poses(in, name, {kAny, 4, 4});
  std::vector<Pose> out;
  for (int i = 0; i < poses.rows(); ++i)
    out.push_back(to_pose(poses.data() + 16 * static_cast<std::size_t>(i), {name, i}));
  return out;
}

nb::object from_poses(const std::vector<Pose>& poses) {
  std::vector<double> out(16 * poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) write_pose(poses[i], &out[16 * i]);
  return to_numpy(std::move(out), {poses.size(), 4, 4});
}

std::vector<Vec3> to_points(nb::handle in) {
  const Doubles points(in, "points", {kAny, 3});
  std::vector<Vec3> out;
  for (std::size_t i = 0; i < static_cast<std::size_t>(points.rows()); ++i)
    out.push_back({points[3 * i], points[3 * i + 1], points[3 * i + 2]});
  return out;
}

nb::tuple surface_distance_of(int kind_in, nb::handle half_in, nb::handle points_in) {
  const SolidKind kind = to_kind(kind_in);
  const Vec3 half = to_half(half_in, kind);
  std::vector<double> distances, gradients;
  for (const Vec3& p : to_points(points_in)) {
    const SurfaceDistance found = surface_distance(kind, half, p);
    distances.push_back(found.distance);
    for (const double x : {found.gradient.x, found.gradient.y, found.gradient.z}) gradients.push_back(x);
  }
  const std::size_t n = distances.size();
  return nb::make_tuple(to_numpy(std::move(distances), {n}), to_numpy(std::move(gradients), {n, 3}));
}

nb::tuple fit_surface_of(int kind_in, nb::handle half_in, nb::handle points_in, nb::handle start_in,
                         double scale, nb::handle up_in, int most_steps) {
  const SolidKind kind = to_kind(kind_in);
  const Vec3 half = to_half(half_in, kind);
  const std::vector<Vec3> points = to_points(points_in);
  const Doubles start(start_in, "start", {4, 4});
  if (!(scale > 0.0)) throw nb::value_error("scale: must be above 0");
  FitSettings settings;
  settings.scale = scale;
  settings.most_steps = most_steps;
  settings.freedom = up_in.is_none() ? Freedom::all : Freedom::upright;
  if (!up_in.is_none()) settings.up = to_vector(up_in, "up");
  const SurfaceFit fit = fit_surface(kind, half, points, to_pose(start.data(), "start"), settings);
  std::vector<double> T(16);
  write_pose(fit.T, T.data());
  return nb::make_tuple(to_numpy(std::move(T), {4, 4}), fit.cost, fit.steps);
}

std::vector<float> to_floats(const Floats& in) { return {in.data(), in.data() + in.size()}; }

std::vector<float> to_singles(const Doubles& in) { return {in.data(), in.data() + in.size()}; }

void require_size(std::size_t rows, std::size_t columns, const PinholeCamera& camera, const char* name) {
  if (rows != static_cast<std::size_t>(camera.height) || columns != static_cast<std::size_t>(camera.width))
    throw nb::value_error((std::string(name) + ": not of the size of the picture").c_str());
}

void make_picture(PlacePicture* self, nb::handle intrinsics_in, const Floats& depth, const Floats& share,
                  const Labels& colour, const std::vector<Floats>& known, const nb::tuple& known_solids,
                  nb::handle known_colours_in, const DepthNoise& noise, nb::handle costs_in) {
  const Doubles k(intrinsics_in, "intrinsics", {4}), costs(costs_in, "costs", {6});
  const Doubles known_colours(known_colours_in, "known_colours", {kAny});
  if (!(k[0] > 0.0 && k[1] > 0.0)) throw nb::value_error("intrinsics: fx and fy must be positive");
  if (known.size() != 2) throw nb::value_error("known: expected depth and facing");
  MeasuredPicture measured{
      {k[0], k[1], k[2], k[3], static_cast<int>(depth.shape(1)), static_cast<int>(depth.shape(0))},
      to_floats(depth),
      to_floats(share),
      {colour.data(), colour.data() + colour.size()}};
  require_size(share.shape(0), share.shape(1), measured.camera, "share");
  require_size(colour.shape(0), colour.shape(1), measured.camera, "colour");
  require_size(known[0].shape(0), known[0].shape(1), measured.camera, "known depth");
  require_size(known[1].shape(0), known[1].shape(1), measured.camera, "known facing");
  for (const std::int32_t label : measured.colour)
    if (label < 0 || label >= known_colours.rows()) throw nb::value_error("colour: no such label");
  for (std::size_t i = 0; i < measured.depth.size(); ++i)
    if (!(measured.share[i] >= 0.0f && measured.share[i] <= 1.0f) ||
        (measured.share[i] > 0.0f && !(measured.depth[i] > 0.0f && std::isfinite(measured.depth[i]))))
      throw nb::value_error(
          "depth: must be finite and above 0 where some of a block came back, share from 0 to 1");
  KnownSurface surface{to_floats(known[0]), to_floats(known[1]), {}};
  const std::vector<Pose> poses = to_poses(known_solids[0], "T_camera_solid");
  const Doubles half(known_solids[1], "half_extents", {static_cast<Py_ssize_t>(poses.size()), 3});
  const Integers kinds(known_solids[2], "kind", {static_cast<Py_ssize_t>(poses.size())});
  for (std::size_t i = 0; i < poses.size(); ++i)
    surface.solids.push_back(
        make_solid(poses[i], {half[3 * i], half[3 * i + 1], half[3 * i + 2]}, to_kind(kinds[i]), 0.0));
  new (self) PlacePicture(std::move(measured), std::move(surface), to_singles(known_colours), noise,
                          {costs[0], costs[1], costs[2], costs[3], costs[4], costs[5]});
}

int add_product(PlacePicture& self, int kind_in, nb::handle half_in, double no_return,
                nb::handle colours_in) {
  const SolidKind kind = to_kind(kind_in);
  const Doubles colours(colours_in, "colours", {self.n_labels()});
  if (!(no_return >= 0.0 && no_return <= 1.0))
    throw nb::value_error("no_return: must be a share from 0 to 1");
  return self.add({kind, to_half(half_in, kind), no_return, to_singles(colours)});
}

int to_product(const PlacePicture& picture, int product) {
  if (product < 0 || product >= picture.n_products()) throw nb::value_error("product: no such product");
  return product;
}

SearchSettings to_search(nb::handle steps_in, nb::handle up_in, double allowed_penetration) {
  const Doubles steps(steps_in, "steps", {kAny});
  SearchSettings settings;
  settings.steps.assign(steps.data(), steps.data() + steps.size());
  settings.allowed_penetration = allowed_penetration;
  settings.freedom = up_in.is_none() ? Freedom::all : Freedom::upright;
  if (!up_in.is_none()) settings.up = to_vector(up_in, "up");
  return settings;
}

std::vector<PlacedProduct> to_placed(const PlacePicture& picture, nb::handle products_in,
                                     nb::handle poses_in) {
  const std::vector<Pose> poses = to_poses(poses_in, "T_camera_item");
  const Integers products(products_in, "products", {static_cast<Py_ssize_t>(poses.size())});
  std::vector<PlacedProduct> placed;
  for (std::size_t i = 0; i < poses.size(); ++i)
    placed.push_back({to_product(picture, products[i]), poses[i]});
  return placed;
}

nb::tuple candidates_of(const PlacePicture& self, int product, nb::handle starts_in, nb::handle up_in,
                        nb::handle steps_in, const nb::tuple& counts, const nb::tuple& placed_in) {
  const std::vector<Pose> starts = to_poses(starts_in, "starts");
  const SearchSettings search = to_search(steps_in, up_in, SearchSettings{}.allowed_penetration);
  CandidateSettings settings;
  settings.n_searched = nb::cast<int>(counts[0]);
  settings.n_kept = nb::cast<int>(counts[1]);
  const std::vector<PlacedProduct> placed = to_placed(self, placed_in[0], placed_in[1]);
  std::vector<Option> found;
  {
    nb::gil_scoped_release unlocked;
    found = candidates(self, to_product(self, product), starts, placed, settings, search);
  }
  std::vector<Pose> poses;
  std::vector<double> gains;
  for (const Option& option : found) {
    poses.push_back(option.T);
    gains.push_back(-option.cost);
  }
  const std::size_t n = gains.size();
  return nb::make_tuple(from_poses(poses), to_numpy(std::move(gains), {n}));
}

nb::tuple choose_of(const PlacePicture& self, nb::handle products_in,
                    const std::vector<nb::object>& options_in, double least_gain) {
  const Integers given(products_in, "products", {static_cast<Py_ssize_t>(options_in.size())});
  std::vector<int> products;
  std::vector<std::vector<Pose>> options;
  for (std::size_t i = 0; i < options_in.size(); ++i) {
    products.push_back(to_product(self, given[i]));
    options.push_back(to_poses(options_in[i], "options"));
  }
  const SearchSettings settings;
  std::vector<Choice> found;
  {
    nb::gil_scoped_release unlocked;
    found = choose(self, products, options, least_gain, settings);
  }
  std::vector<std::int32_t> chosen;
  std::vector<double> gains, margins;
  for (const Choice& each : found) {
    chosen.push_back(each.option);
    gains.push_back(each.gain);
    margins.push_back(each.margin);
  }
  const std::size_t n = found.size();
  return nb::make_tuple(to_numpy(std::move(chosen), {n}), to_numpy(std::move(gains), {n}),
                        to_numpy(std::move(margins), {n}));
}

nb::object refined_of(const PlacePicture& self, nb::handle products_in, nb::handle poses_in, nb::handle up_in,
                      nb::handle steps_in, double allowed_penetration, int n_rounds) {
  std::vector<PlacedProduct> placed = to_placed(self, products_in, poses_in);
  SearchSettings settings = to_search(steps_in, up_in, allowed_penetration);
  settings.tries_turns = settings.freedom == Freedom::upright;
  std::vector<Pose> poses;
  {
    nb::gil_scoped_release unlocked;
    poses = refined(self, std::move(placed), n_rounds, settings);
  }
  return from_poses(poses);
}

nb::object evidence_of(const PlacePicture& self, nb::handle products_in, nb::handle poses_in,
                       double near_surface) {
  const std::vector<Evidence> found =
      evidence(self, to_placed(self, products_in, poses_in), near_surface, {});
  std::vector<double> out;
  for (const Evidence& e : found)
    for (const double x : {double(e.expected), double(e.shown), double(e.supported), double(e.through),
                           double(e.before), e.gain, e.colour})
      out.push_back(x);
  return to_numpy(std::move(out), {found.size(), 7});
}

nb::object costs_of(const PlacePicture& self, int product, nb::handle poses_in, const nb::tuple& placed_in) {
  const std::vector<Pose> poses = to_poses(poses_in, "T_camera_item");
  const Composite others = composed(self, to_placed(self, placed_in[0], placed_in[1]), -1);
  std::vector<double> costs;
  for (const Pose& T : poses) costs.push_back(self.cost_before(to_product(self, product), T, others));
  const std::size_t n = costs.size();
  return to_numpy(std::move(costs), {n});
}

nb::tuple composed_of(const PlacePicture& self, nb::handle products_in, nb::handle poses_in) {
  Composite all = composed(self, to_placed(self, products_in, poses_in), -1);
  const std::size_t H = static_cast<std::size_t>(self.height()), W = static_cast<std::size_t>(self.width());
  return nb::make_tuple(to_numpy(std::move(all.owner), {H, W}), to_numpy(std::move(all.depth), {H, W}),
                        to_numpy(std::move(all.cost), {H, W}));
}

}  // namespace

void bind_perception(nb::module_& m) {
  m.def("surface_distance", &surface_distance_of, "kind"_a, "half_extents"_a, "points"_a,
        nb::sig("def surface_distance(kind: int, half_extents: " APC_F64 ", points: " APC_F64
                ") -> tuple[" APC_F64 ", " APC_F64 "]"),
        R"(How far points are from the surface of a solid.

Args:
    kind: A value of SolidKind.
    half_extents: (3,) m; of a cylinder (r, r, half length), of a sphere (r, r, r).
    points: (N, 3) in the solid's frame.

Returns:
    Distances (N,) in m, negative inside, and their gradients (N, 3), of length 1.)");
  m.def("fit_surface", &fit_surface_of, "kind"_a, "half_extents"_a, "points"_a, "start"_a, "scale"_a,
        "up"_a.none() = nb::none(), "most_steps"_a = 50,
        nb::sig("def fit_surface(kind: int, half_extents: " APC_F64 ", points: " APC_F64 ", start: " APC_F64
                ", scale: float, up: " APC_F64 " | None = None, most_steps: int = 50) -> tuple[" APC_F64
                ", float, int]"),
        R"(Fit the pose of a solid to points on its surface.

Powell's dogleg (1970) on the mean of d^2 / (scale^2 + d^2) over the points (Geman and McClure 1985), of which d is the
distance from the surface.

Args:
    kind: A value of SolidKind.
    half_extents: (3,) m; of a cylinder (r, r, half length), of a sphere (r, r, r).
    points: (N, 3) m.
    start: (4, 4) pose to begin at.
    scale: m from which on a point counts as one of something else.
    up: (3,) the only axis of turns, of length 1; None for turns about all axes.
    most_steps: Number of steps at most.

Returns:
    The pose (4, 4), the cost in [0, 1), and the number of steps.)");
  nb::class_<PlacePicture>(m, "PlacePicture",
                           R"(A picture of one place, and how well items in it explain the picture.

Render and compare: for every pixel in which an item would be seen, the costs (negative logarithms of likelihoods) of
what was measured there tell whether its surface was measured (and how far off), was seen through, is behind something
else, or gave no depth, and whether the colour is one of its own. All poses are in the camera's frame. Items hide each
other. One thread; the same input gives the same bytes.)")
      .def("__init__", &make_picture, "intrinsics"_a, "depth"_a, "share"_a, "colour"_a, "known"_a,
           "known_solids"_a, "known_colours"_a, "noise"_a, "costs"_a,
           nb::sig("def __init__(self, intrinsics: " APC_F64 ", depth: " APC_F32 ", share: " APC_F32
                   ", colour: " APC_I32 ", known: collections.abc.Sequence[" APC_F32
                   "], known_solids: tuple[" APC_F64 ", " APC_F64 ", " APC_I32 "], known_colours: " APC_F64
                   ", noise: DepthNoise, costs: " APC_F64 ") -> None"),
           R"(Take a picture, of which each pixel may stand for a block of the sensor's.

Args:
    intrinsics: (4,) fx, fy, cx, cy in px.
    depth: (H, W) m along the optical axis; anything where nothing was measured.
    share: (H, W) share of each block that was measured.
    colour: (H, W) labels of colours.
    known: Depth (H, W) in m of what is known, NaN where items are not looked for, and (H, W) the cosine between ray and
        normal there.
    known_solids: Poses (K, 4, 4), half extents (K, 3) and kinds (K,) of solids that items do not reach into.
    known_colours: (L,) cost of each label on what is known.
    noise: Coefficients of the sensor.
    costs: (6,) m that surfaces may be off besides noise; the most that a depth before, and one behind what is expected
        cost; the share of pixels without depth whatever the surface; the most that no depth costs where the second eye
        sees something else, or the surface is out of the sensor's range; the weight of a pixel.)")
      .def("add", &add_product, "kind"_a, "half_extents"_a, "no_return"_a, "colours"_a,
           nb::sig("def add(self, kind: int, half_extents: " APC_F64 ", no_return: float, colours: " APC_F64
                   ") -> int"),
           R"(Add an item that may be in the place.

Args:
    kind: A value of SolidKind.
    half_extents: (3,) m; of a cylinder (r, r, half length), of a sphere (r, r, r).
    no_return: Share of its surface from which nothing comes back.
    colours: (L,) cost of each label on it.

Returns:
    Its index.)")
      .def("candidates", &candidates_of, "product"_a, "starts"_a, "up"_a, "steps"_a, "counts"_a, "placed"_a,
           nb::sig("def candidates(self, product: int, starts: " APC_F64 ", up: " APC_F64 ", steps: " APC_F64
                   ", counts: tuple[int, int], placed: tuple[" APC_I32 ", " APC_F64 "]) -> tuple[" APC_F64
                   ", " APC_F64 "]"),
           R"(Find the best places of one item.

Each start is fitted to the points near it that nothing explains; the best are moved while that explains the picture
better, and of those at most a few are kept around each place.

Args:
    product: Index of the item.
    starts: (N, 4, 4) poses.
    up: (3,) against gravity; moved items are turned about it.
    steps: (S,) m, sizes of the moves, falling.
    counts: How many starts are moved, and how many places are kept.
    placed: Indices (M,) and poses (M, 4, 4) of other items that are there.

Returns:
    Poses (K, 4, 4), the best first, and gains (K,): by how much the picture is explained better.)")
      .def(
          "choose", &choose_of, "products"_a, "options"_a, "least_gain"_a,
          nb::sig("def choose(self, products: " APC_I32 ", options: collections.abc.Sequence[" APC_F64
                  "], least_gain: float) -> tuple[" APC_I32 ", " APC_F64 ", " APC_F64 "]"),
          R"(Choose a pose for each of several items, or none, so that together they explain the picture best.

Greedily at first, then items one by one and in pairs while that gets better. Items that reach into each other, or into
what is known, cost.

Args:
    products: (N,) indices of the items.
    options: Poses (K, 4, 4) of each.
    least_gain: By which an item must explain the picture better to be placed.

Returns:
    Indices (N,) of the options, -1 for none; the gain (N,) of each, with the others in their places; and its margin
    (N,): the gain beside that of the item's best option elsewhere.)")
      .def("refined", &refined_of, "products"_a, "T_camera_item"_a, "up"_a.none(), "steps"_a,
           "allowed_penetration"_a, "n_rounds"_a,
           nb::sig("def refined(self, products: " APC_I32 ", T_camera_item: " APC_F64 ", up: " APC_F64
                   " | None, steps: " APC_F64 ", allowed_penetration: float, n_rounds: int) -> " APC_F64),
           R"(Move placed items, one after the other, while that explains the picture better.

Args:
    products: (N,) indices of the items.
    T_camera_item: (N, 4, 4) their poses.
    up: (3,) the only axis of turns, then boxes are also tried with exchanged axes; None for turns about all axes.
    steps: (S,) m, sizes of the moves, falling.
    allowed_penetration: m that items may reach into each other and into what is known.
    n_rounds: How often each is moved.

Returns:
    (N, 4, 4) poses.)")
      .def("evidence", &evidence_of, "products"_a, "T_camera_item"_a, "near_surface"_a,
           nb::sig("def evidence(self, products: " APC_I32 ", T_camera_item: " APC_F64
                   ", near_surface: float) -> " APC_F64),
           R"(Tell what the picture says of placed items.

Args:
    products: (N,) indices of the items.
    T_camera_item: (N, 4, 4) their poses.
    near_surface: m within which a surface was measured.

Returns:
    (N, 7) pixels that would show it if nothing but what is known were before it; of these those that no other item
    hides; of these those in which its surface, something behind it, and something before it was measured; the gain by
    which the picture is explained better with it than without; the mean cost of the colours of supported pixels.)")
      .def("costs", &costs_of, "product"_a, "T_camera_item"_a, "placed"_a,
           nb::sig("def costs(self, product: int, T_camera_item: " APC_F64 ", placed: tuple[" APC_I32
                   ", " APC_F64 "]) -> " APC_F64),
           R"(Tell what an item costs at several poses, beside what it hides there.

Args:
    product: Index of the item.
    T_camera_item: (N, 4, 4) poses.
    placed: Indices (M,) and poses (M, 4, 4) of other items that are there.

Returns:
    (N,) costs of the picture with the item, less that without it; penetrations cost nothing here.)")
      .def("composed", &composed_of, "products"_a, "T_camera_item"_a,
           nb::sig("def composed(self, products: " APC_I32 ", T_camera_item: " APC_F64 ") -> tuple[" APC_I32
                   ", " APC_F32 ", " APC_F32 "]"),
           R"(Render placed items before what is known.

Args:
    products: (N,) indices of the items.
    T_camera_item: (N, 4, 4) their poses.

Returns:
    (H, W) which of the items is seen, -1 for what is known; depth (H, W) in m, infinite where nothing is looked for;
    cost (H, W) of each pixel.)");
}

}  // namespace apc
