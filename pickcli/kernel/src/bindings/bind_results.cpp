//! \file
//! What the checks of pickcli.kernel speak of and answer: SolidKind, ContactKind, EdgeReport.
#include "bindings/bindings.hpp"
#include "collision/checker.hpp"

namespace apc {

namespace nb = nanobind;

void bind_results(nb::module_& m) {
  nb::enum_<SolidKind>(m, "SolidKind", nb::is_arithmetic(), "What a solid is, before its rounding.")
      .value("BOX", SolidKind::box, "By its half extents.")
      .value("CYLINDER", SolidKind::cylinder, "About its z; half extents (radius, radius, half length).")
      .value("SPHERE", SolidKind::sphere, "Half extents three times its radius.");
  nb::enum_<ContactKind>(m, "ContactKind", nb::is_arithmetic(), "What a frame meets.")
      .value("NONE", ContactKind::none, "Nothing.")
      .value("WORLD", ContactKind::world, "A solid of the world.")
      .value("SELF", ContactKind::self, "Another frame.")
      .value("CLOUD", ContactKind::cloud, "A point of the world's cloud.");
  nb::class_<EdgeReport>(m, "EdgeReport", "Whether an edge is free, and if not, where and why.")
      .def_ro("free", &EdgeReport::free, "Whether every point of the edge is proven free.")
      .def_ro("t", &EdgeReport::t,
              "Where on the edge, 0 at q0 and 1 at q1, it was found not free; -1 if it is.")
      .def_ro("frame", &EdgeReport::frame,
              "The frame that is not free there, L for the held item; -1 if the edge is free.")
      .def_ro("kind", &EdgeReport::kind, "What it meets there; NONE if the edge is free.")
      .def_ro("index", &EdgeReport::index,
              "Index of the solid or the point, or the frame nearer to the base; -1 if the edge is free.")
      .def_ro("n_configurations", &EdgeReport::n_configurations, "How many configurations were tested.");
}

}  // namespace apc
