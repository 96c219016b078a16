//! \file
//! Memory that a thread keeps from one edge to the next.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "collision/interval_queue.hpp"

namespace apc {

class Workspace {
 public:
  //! This thread's own: one user at a time.
  static Workspace& mine();

  std::vector<Interval> intervals;

  //! At least n_bytes, aligned to 64, valid until the next call.
  void* scratch(std::size_t n_bytes);

 private:
  struct Free {
    void operator()(void* p) const;
  };
  std::unique_ptr<void, Free> memory_;
  std::size_t size_ = 0;
};

}  // namespace apc
