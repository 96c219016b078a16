#include "collision/workspace.hpp"

#include <cstdlib>
#include <new>

namespace apc {

Workspace& Workspace::mine() {
  thread_local Workspace workspace;
  return workspace;
}

void* Workspace::scratch(std::size_t n_bytes) {
  if (size_ < n_bytes) {
    size_ = (n_bytes + 63) / 64 * 64;
    memory_.reset(std::aligned_alloc(64, size_));
    if (!memory_) {
      size_ = 0;
      throw std::bad_alloc();
    }
  }
  return memory_.get();
}

void Workspace::Free::operator()(void* p) const { std::free(p); }

}  // namespace apc
