// Which build of the hot test runs.
#pragma once

#include "eight.hpp"

namespace apc {

// Runs the hot test with memory of its own, kept from call to call by each thread.
eight::Verdict run_eight(const eight::Robot& robot, const eight::World& world, const eight::Batch& batch);

// AVX2 where the processor has it, unless set_simd says otherwise.
const char* simd_name();

// "avx2" or "baseline". Throws std::invalid_argument for what is not available.
void set_simd(const char* name);

}  // namespace apc
