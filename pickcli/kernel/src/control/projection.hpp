//! \file
//! The configuration nearest to another one whose tool pose meets inequalities.
#pragma once

#include <vector>

#include "control/pose_constraints.hpp"
#include "kinematics/chain.hpp"
#include "kinematics/ik.hpp"

namespace apc {

//! Which configurations are sought: those in limits whose tool pose meets all constraints.
struct ProjectionProblem {
  const Chain& chain;
  Pose T_last_tip, T_world_object;
  const std::vector<PoseConstraint>& constraints;
  const double* lower;       //!< (n,) rad or m
  const double* upper;       //!< (n,) rad or m
  const double* weights;     //!< (n,) > 0: cost of a squared distance of each joint, relative to the others
  const double* reference;   //!< (n,) from which the distance is measured
  double longest_step = 0.3; //!< of weighted joints in an iteration: so far the rows are believed
  int max_iterations = 40;
  double tolerance = 1e-6;   //!< m or cosine: constraints are kept by so much, and met to half of it
};

//! A configuration, how far it is from the reference, and whether all constraints are met.
struct Projection {
  Configuration q;
  double squared_distance = 0.0;  //!< weighted
  bool is_met = false;
};

//! From a seed (n,), descend to the constraints, and along them to what is nearest to the reference.
//!
//! A descent along the constraints: each step is a hierarchical QP of the limits and the step's length, the
//! linearized constraints, and the distance; Newton steps lead back to the constraints, and a step that does not
//! bring the configuration nearer is tried again shorter (a generalized reduced gradient method, Nocedal and
//! Wright, Numerical Optimization, 2nd edition, section 15.3, whose iterates all meet the constraints).
Projection project(const ProjectionProblem& problem, const double* seed);

}  // namespace apc
