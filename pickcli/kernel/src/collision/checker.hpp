//! \file
//! Collision checks of one robot in one world: free configurations, proven edges, clearance.
#pragma once

#include <vector>

#include "collision/robot.hpp"
#include "collision/world.hpp"

namespace apc {

//! What a frame meets: nothing, a solid of the world, another frame, or a point of the world's cloud.
enum class ContactKind : int { none = -1, world = 0, self = 1, cloud = 2 };

//! Whether an edge is free, and if not, where and why.
struct EdgeReport {
  bool free = true;
  double t = -1.0;                       //!< where on the edge, in 0..1, it is not free; -1 if it is
  int frame = -1;                        //!< which frame is not free there; L is the held item
  ContactKind kind = ContactKind::none;  //!< of what
  int index = -1;                        //!< index of the obstacle or the point, or the inner frame
  int n_configurations = 0;              //!< how many were tested
};

//! The nearest pair at one configuration.
struct Contact {
  double distance;  //!< m, negative inside
  int frame = -1;   //!< as in EdgeReport; -1: nothing within max_distance
  ContactKind kind = ContactKind::none;
  int index = -1;
};

//! A row of many configurations, and its clearance.
struct ClearRow {
  int row;
  double distance;  //!< m, negative inside
};

//! Checks are const and may run in several threads; robot and world must not be changed meanwhile.
class Checker {
 public:
  explicit Checker(Robot robot) : robot_(std::move(robot)) {}

  Robot& robot() { return robot_; }
  const Robot& robot() const { return robot_; }
  const World& world() const { return world_; }
  World& world() { return world_; }
  int n() const { return robot_.chain().n(); }

  //! out[i]: whether everything at Q[i] (of n_rows, n) keeps more than margin.
  void are_free(const double* Q, int n_rows, double margin, bool* out) const;

  //! Proof for every point of the segment from q0 to q1 and of the tube of half-width slack (n, or null)
  //! around it. Never says free wrongly; says not free only if some point of the edge comes nearer than
  //! margin + slack's motion + resolution + a few roundings, or, for a held solid, where a slab does not
  //! tell. is_doubtful: set if the edge is probably blocked, as most of those that planners try. Blocked edges
  //! are then found sooner, free ones are proven later; the result is the same.
  EdgeReport check_edge(const double* q0, const double* q1, double margin, const double* slack,
                        double resolution, bool is_doubtful = false) const;

  //! The first of the edges between n_rows rows of Q (n_rows, n) that check_edge does not find free, by slack
  //! (n_rows - 1, n, or null); -1 if there is none.
  int first_blocked_edge(const double* Q, int n_rows, double margin, const double* slack,
                         double resolution) const;

  //! The nearest pair at q (n), in double precision and signed; distance is at most max_distance.
  Contact clearance(const double* q, double max_distance) const;

  //! Distances of the nearest pairs at the rows of Q (n_rows, n); where the batch test proves that none is
  //! nearer than max_distance, that.
  void clearances(const double* Q, int n_rows, double max_distance, double* out) const;

  //! The n_most rows of Q (n_rows, n) with the largest clearances, the largest first, of equal ones in their order.
  //! Of the others no more is measured than that they are none of these.
  std::vector<ClearRow> clearest(const double* Q, int n_rows, int n_most, double max_distance) const;

 private:
  //! Tries to prove eight edges between nine rows of Q at once, each whole and as if it moved as far as any of
  //! them: a trajectory's many short ones mostly are.
  void prove_edges(const double* Q, double margin, const double* slack, double resolution,
                   bool* are_proven) const;

  Robot robot_;
  World world_;
};

}  // namespace apc
