//! \file
//! Inverse kinematics by damped least squares (Levenberg-Marquardt) within joint limits.
#pragma once

#include <vector>

#include "kinematics/chain.hpp"

namespace apc {

using Configuration = std::vector<double>;  //!< (n,) rad or m

//! What a configuration is searched for, and between which limits.
struct IkProblem {
  const Chain& chain;
  Pose T_last_tip;
  const double* lower;    //!< (n,) rad or m
  const double* upper;    //!< (n,) rad or m
  const double* weights;  //!< (n,) > 0: what moving a joint costs, relative to the others
  int max_iterations = 60;
  double position_tolerance = 1e-5;  //!< m
  double rotation_tolerance = 1e-4;  //!< rad
};

//! How a search for one configuration ended.
enum class IkResult { converged, not_converged, at_limit };

//! Moves q (n,) until the tip stands at T_world_target. at_limit: stuck with a joint pressed against a limit.
IkResult solve(const IkProblem& problem, const Pose& T_world_target, double* q);

//! Every solution reached from seeds (n_seeds, n), in seed order, without those that differ from an
//! earlier one by at most `distinct` in every joint.
std::vector<Configuration> solve_all(const IkProblem& problem, const Pose& T_world_target,
                                     const double* seeds, int n_seeds, double distinct);

}  // namespace apc
